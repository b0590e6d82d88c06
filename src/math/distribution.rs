//! Discrete distributions: an alias table, and a piecewise-constant density on the unit square.

/// Draws an index in constant time with probability proportional to its weight. Vose 1991.
#[derive(Clone, Debug)]
pub struct Alias {
    entries: Vec<AliasEntry>,
}

#[derive(Clone, Copy, Debug)]
struct AliasEntry {
    /// Below this share of the cell the index itself is taken, above it `other`.
    threshold: f32,
    other: u32,
    probability: f32,
}

impl Alias {
    /// `None` when no weight is positive. Non-finite and negative weights count as zero.
    pub fn new(weights: &[f32]) -> Option<Self> {
        let weights: Vec<f64> =
            weights.iter().map(|&w| if w.is_finite() && w > 0.0 { f64::from(w) } else { 0.0 }).collect();
        let sum: f64 = weights.iter().sum();
        if sum <= 0.0 {
            return None;
        }
        let count = weights.len();
        let mut scaled: Vec<f64> = weights.iter().map(|w| w / sum * count as f64).collect();
        let mut entries: Vec<AliasEntry> = weights
            .iter()
            .enumerate()
            .map(|(i, w)| AliasEntry { threshold: 1.0, other: i as u32, probability: (w / sum) as f32 })
            .collect();
        let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..count).partition(|&i| scaled[i] < 1.0);
        while let (Some(low), Some(&high)) = (small.pop(), large.last()) {
            entries[low].threshold = scaled[low] as f32;
            entries[low].other = high as u32;
            scaled[high] -= 1.0 - scaled[low];
            if scaled[high] < 1.0 {
                large.pop();
                small.push(high);
            }
        }
        // What rounding left over must never send a draw to an index of weight zero.
        for i in small {
            if weights[i] == 0.0 {
                entries[i].threshold = 0.0;
            }
        }
        Some(Self { entries })
    }

    /// (index, its probability), from one number in [0, 1).
    #[inline]
    pub fn sample(&self, u: f32) -> (usize, f32) {
        let position = u * self.entries.len() as f32;
        let cell = (position as usize).min(self.entries.len() - 1);
        let entry = self.entries[cell];
        let index = if position - cell as f32 <= entry.threshold && entry.threshold > 0.0 {
            cell
        } else {
            entry.other as usize
        };
        (index, self.entries[index].probability)
    }

    #[inline]
    pub fn probability(&self, index: usize) -> f32 {
        self.entries[index].probability
    }
}

/// A density on [0, 1)^2, constant in each cell of a width x height grid.
///
/// Points are warped down a pyramid of weights (Clarberg et al. 2005, "Wavelet Importance Sampling", section 4.1): few cache
/// lines per draw, and stratified numbers give stratified points.
#[derive(Clone, Debug)]
pub struct Grid {
    width: usize,
    height: usize,
    /// Square blocks of 2^levels cells a side, side by side along the longer axis, cover the grid.
    levels: u32,
    columns: usize,
    /// Cumulative weight of the blocks: first 0, last 1.
    blocks: Vec<f32>,
    /// Weights from one number per block to one per cell; in each level block by block, in Z-order within a block.
    pyramid: Vec<Vec<f32>>,
    /// Turns a cell's weight into density.
    scale: f32,
}

impl Grid {
    /// Row-major weights; `None` when none is positive. Non-finite and negative weights count as zero.
    pub fn new(weights: &[f32], width: usize) -> Option<Self> {
        let height = weights.len().checked_div(width)?;
        let clean = |w: f32| if w.is_finite() && w > 0.0 { w } else { 0.0 };
        let total: f64 = weights.iter().map(|&w| f64::from(clean(w))).sum();
        if total <= 0.0 {
            return None;
        }
        let levels = width.min(height).next_power_of_two().trailing_zeros();
        let columns = width.div_ceil(1 << levels);
        let count = columns * height.div_ceil(1 << levels);
        let mut cells = vec![0.0f32; count << (2 * levels)];
        let mut grid = Self { width, height, levels, columns, blocks: Vec::new(), pyramid: Vec::new(), scale: 0.0 };
        for (i, &weight) in weights.iter().enumerate() {
            cells[grid.cell(i % width, i / width)] = clean(weight);
        }
        grid.pyramid.push(cells);
        for _ in 0..levels {
            let finer = &grid.pyramid[grid.pyramid.len() - 1];
            grid.pyramid.push(finer.chunks_exact(4).map(|four| four.iter().sum()).collect());
        }
        grid.pyramid.reverse();
        grid.blocks = cumulative(grid.pyramid[0].iter().map(|&w| f64::from(w)));
        grid.scale = (weights.len() as f64 / total) as f32;
        Some(grid)
    }

    /// (point, density at it), from two numbers in [0, 1).
    pub fn sample(&self, u: [f32; 2]) -> ([f32; 2], f32) {
        let along = usize::from(self.columns == 1);
        let mut u = u;
        let (block, rest) = pick(&self.blocks, u[along]);
        u[along] = rest;
        let mut cell = block;
        let (mut x, mut y) = (0, 0);
        for level in &self.pyramid[1..] {
            cell *= 4;
            let four: [f32; 4] = [level[cell], level[cell + 1], level[cell + 2], level[cell + 3]];
            let (top, bottom) = (four[0] + four[1], four[2] + four[3]);
            let lower = choose(&mut u[1], top, bottom);
            let (left, right) = (four[2 * usize::from(lower)], four[2 * usize::from(lower) + 1]);
            let further = choose(&mut u[0], left, right);
            (x, y) = (2 * x + usize::from(further), 2 * y + usize::from(lower));
            cell += usize::from(further) + 2 * usize::from(lower);
        }
        (x, y) = (x + ((block % self.columns) << self.levels), y + ((block / self.columns) << self.levels));
        let point = [(x as f32 + u[0]) / self.width as f32, (y as f32 + u[1]) / self.height as f32];
        (point, self.pyramid[self.levels as usize][cell] * self.scale)
    }

    /// Density at a point of [0, 1)^2.
    pub fn pdf(&self, point: [f32; 2]) -> f32 {
        let x = ((point[0] * self.width as f32) as usize).min(self.width - 1);
        let y = ((point[1] * self.height as f32) as usize).min(self.height - 1);
        self.pyramid[self.levels as usize][self.cell(x, y)] * self.scale
    }

    /// Place of a cell in the finest level.
    fn cell(&self, x: usize, y: usize) -> usize {
        let mask = (1 << self.levels) - 1;
        let block = (y >> self.levels) * self.columns + (x >> self.levels);
        let inside = spread_bits((x & mask) as u32) | spread_bits((y & mask) as u32) << 1;
        (block << (2 * self.levels)) | inside as usize
    }
}

/// Moves bit i to bit 2i: two of them make a place on a Z-order curve.
pub fn spread_bits(x: u32) -> u64 {
    let mut x = u64::from(x);
    for (shift, mask) in [(16, 0x0000_ffff_0000_ffff), (8, 0x00ff_00ff_00ff_00ff), (4, 0x0f0f_0f0f_0f0f_0f0f)] {
        x = (x | x << shift) & mask;
    }
    x = (x | x << 2) & 0x3333_3333_3333_3333;
    (x | x << 1) & 0x5555_5555_5555_5555
}

/// True for the second of two weights, which are not both zero; the number is stretched back to [0, 1).
#[inline]
fn choose(u: &mut f32, first: f32, second: f32) -> bool {
    let share = first / (first + second);
    let chosen = *u >= share;
    // Selected before the division: no branch, which half the time would be guessed wrong.
    let (low, width) = if chosen { (share, 1.0 - share) } else { (0.0, share) };
    // Rounding must not reach 1, nor choose a weight of zero next time.
    *u = ((*u - low) / width).clamp(0.0, 1.0 - f32::EPSILON / 2.0);
    chosen
}

/// Running sums scaled to end at 1 (or all zero), with a leading 0.
fn cumulative(weights: impl Iterator<Item = f64>) -> Vec<f32> {
    let mut sums = vec![0.0];
    let mut sum = 0.0;
    for weight in weights {
        sum += weight;
        sums.push(sum);
    }
    let scale = if sum > 0.0 { 1.0 / sum } else { 0.0 };
    sums.iter().map(|s| (s * scale) as f32).collect()
}

/// The interval of a cumulative table that `u` falls into, and where inside it (0..1).
fn pick(cumulative: &[f32], u: f32) -> (usize, f32) {
    let last = cumulative.len() - 2;
    let index = cumulative.partition_point(|&c| c <= u).saturating_sub(1).min(last);
    let width = cumulative[index + 1] - cumulative[index];
    let inside = if width > 0.0 { (u - cumulative[index]) / width } else { 0.5 };
    (index, inside.clamp(0.0, 1.0 - f32::EPSILON / 2.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alias_draws_in_proportion_and_never_a_zero() {
        let weights = [3.0, 0.0, 1.0, f32::NAN, 4.0];
        let alias = Alias::new(&weights).unwrap();
        let mut counts = [0usize; 5];
        for i in 0..80_000 {
            let (index, probability) = alias.sample((i as f32 + 0.5) / 80_000.0);
            counts[index] += 1;
            assert_eq!(probability, alias.probability(index));
        }
        assert_eq!((counts[1], counts[3]), (0, 0));
        for (index, share) in [(0, 3.0 / 8.0), (2, 1.0 / 8.0), (4, 0.5)] {
            assert!((counts[index] as f32 / 80_000.0 - share).abs() < 1e-3);
        }
        assert!(Alias::new(&[0.0, -1.0]).is_none());
    }

    #[test]
    fn grid_density_integrates_to_one_and_matches_its_draws() {
        let weights = [0.0, 1.0, 2.0, 5.0, 0.0, 8.0];
        let grid = Grid::new(&weights, 3).unwrap();
        assert_eq!(grid.pdf([0.4, 0.2]), 1.0 * 6.0 / 16.0);
        let mut mean = 0.0;
        for i in 0..64 {
            for j in 0..64 {
                let (point, pdf) = grid.sample([(i as f32 + 0.5) / 64.0, (j as f32 + 0.5) / 64.0]);
                assert!(pdf > 0.0 && (pdf - grid.pdf(point)).abs() < 1e-5);
                mean += 1.0 / pdf / 4096.0;
            }
        }
        // The mean of 1/pdf is the area where the density is positive: four of six cells.
        assert!((mean - 4.0 / 6.0).abs() < 0.02, "{mean}");
    }
}
