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
        let weights: Vec<f64> = weights.iter().map(|&w| clean(f64::from(w))).collect();
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

/// A density on [0, 1)^2, constant in each cell of a grid. A column is drawn first, then a cell of it, both by inversion,
/// which keeps stratified numbers stratified.
///
/// Probabilities are whole numbers of units, so that draws and [`Grid::pdf`] agree exactly.
#[derive(Clone, Debug)]
pub struct Grid {
    columns: Stairs,
    /// One table per column.
    cells: Stairs,
    /// Turns a column's units times a cell's into density.
    scale: f32,
}

/// Cumulative tables of the same length, one after another, with guides that make a draw take constant time on average (Chen
/// & Asau 1974, "On Generating Random Variates from an Empirical Distribution").
#[derive(Clone, Debug)]
struct Stairs {
    length: usize,
    /// `length` + 1 in a table: from 0 to [`UNITS`], or 0 throughout where no weight is positive.
    sums: Vec<u32>,
    /// 2^`guide_log2` in a table, one per equal share of the units: an index that no draw from there lies below.
    guides: Vec<u16>,
    guide_log2: u32,
}

const UNITS_LOG2: u32 = 31;
/// What all probabilities of a table add up to.
const UNITS: u32 = 1 << UNITS_LOG2;

impl Stairs {
    /// From `weight(table, index)`.
    fn new(tables: usize, length: usize, weight: impl Fn(usize, usize) -> f64) -> Self {
        let guide_log2 = length.next_power_of_two().trailing_zeros();
        let mut sums = Vec::with_capacity(tables * (length + 1));
        let mut guides = Vec::with_capacity(tables << guide_log2);
        let mut weights = vec![0.0; length];
        for table in 0..tables {
            weights.iter_mut().enumerate().for_each(|(index, w)| *w = clean(weight(table, index)));
            let total: f64 = weights.iter().sum();
            // A unit of its own keeps each positive weight possible.
            let shared = f64::from(UNITS) - weights.iter().filter(|&&w| w > 0.0).count() as f64;
            let (mut sum, mut own) = (0.0, 0);
            let first = sums.len();
            sums.push(0);
            for &weight in &weights {
                sum += weight;
                own += u32::from(weight > 0.0);
                // Not a number where no weight is positive, which makes 0 units.
                sums.push((sum / total * shared) as u32 + own);
            }
            let mut index = 0;
            for share in 0..1u32 << guide_log2 {
                while index + 1 < length && sums[first + index + 1] <= share << (UNITS_LOG2 - guide_log2) {
                    index += 1;
                }
                guides.push(index.min(usize::from(u16::MAX)) as u16);
            }
        }
        Self { length, sums, guides, guide_log2 }
    }

    /// (index, place within it in 0..1, its units), from a number in [0, 1) and a table with a positive weight.
    #[inline]
    fn sample(&self, table: usize, u: f32) -> (usize, f32, u32) {
        let position = (u * UNITS as f32) as u32;
        let share = (position >> (UNITS_LOG2 - self.guide_log2)) as usize;
        let mut index = usize::from(self.guides[(table << self.guide_log2) + share]);
        let sums = &self.sums[table * (self.length + 1)..][..self.length + 1];
        while sums[index + 1] <= position {
            index += 1;
        }
        let units = sums[index + 1] - sums[index];
        let inside = ((position - sums[index]) as f32 + 0.5) / units as f32;
        (index, inside.min(1.0 - f32::EPSILON / 2.0), units)
    }

    #[inline]
    fn units(&self, table: usize, index: usize) -> u32 {
        let place = table * (self.length + 1) + index;
        self.sums[place + 1] - self.sums[place]
    }
}

impl Grid {
    /// From the weight of the cell (x, y); `None` when none is positive. Non-finite and negative weights count as zero.
    pub fn new(width: usize, height: usize, weight: impl Fn(usize, usize) -> f32) -> Option<Self> {
        let sum = |x: usize| (0..height).map(|y| clean(f64::from(weight(x, y)))).sum();
        let sums: Vec<f64> = (0..width).map(sum).collect();
        if !sums.iter().any(|&sum| sum > 0.0) {
            return None;
        }
        let columns = Stairs::new(1, width, |_, x| sums[x]);
        let cells = Stairs::new(width, height, |x, y| f64::from(weight(x, y)));
        Some(Self { columns, cells, scale: ((width * height) as f64 / f64::from(UNITS).powi(2)) as f32 })
    }

    /// (point, density at it), from two numbers in [0, 1).
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> ([f32; 2], f32) {
        let (x, right, column) = self.columns.sample(0, u[0]);
        let (y, down, cell) = self.cells.sample(x, u[1]);
        let point = [(x as f32 + right) / self.columns.length as f32, (y as f32 + down) / self.cells.length as f32];
        (point, self.density(column, cell))
    }

    /// Density in a cell.
    #[inline]
    pub fn pdf(&self, x: usize, y: usize) -> f32 {
        self.density(self.columns.units(0, x), self.cells.units(x, y))
    }

    fn density(&self, column: u32, cell: u32) -> f32 {
        column as f32 * cell as f32 * self.scale
    }
}

/// A weight that can be added up.
fn clean(weight: f64) -> f64 {
    if weight.is_finite() && weight > 0.0 { weight } else { 0.0 }
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
        let grid = Grid::new(3, 2, |x, y| weights[3 * y + x]).unwrap();
        assert_eq!(grid.pdf(1, 0), 1.0 * 6.0 / 16.0);
        let mut mean = 0.0;
        for i in 0..64 {
            for j in 0..64 {
                let (point, pdf) = grid.sample([(i as f32 + 0.5) / 64.0, (j as f32 + 0.5) / 64.0]);
                assert!(pdf > 0.0 && pdf == grid.pdf((point[0] * 3.0) as usize, (point[1] * 2.0) as usize));
                mean += 1.0 / pdf / 4096.0;
            }
        }
        // The mean of 1/pdf is the area where the density is positive: four of six cells.
        assert!((mean - 4.0 / 6.0).abs() < 0.02, "{mean}");
        assert!(Grid::new(2, 2, |_, _| -1.0).is_none());
    }

    #[test]
    fn what_is_drawn_is_possible_and_what_is_possible_is_drawn() {
        // Weights of all sizes, and more of them than a guide can number.
        let weight = |_: usize, y: usize| match y % 4 {
            0 => 0.0,
            1 => 1e-30,
            2 => f32::NAN,
            _ => 1e30 * (y as f32).sqrt(),
        };
        for height in [1, 2, 3, 5, 64, 1000, 70_000] {
            let grid = Grid::new(2, height, |x, y| weight(x, y + 3)).unwrap();
            let total: f64 = (0..height).map(|y| f64::from(grid.cells.units(1, y))).sum();
            assert_eq!(total, f64::from(UNITS));
            for y in 0..height {
                assert_eq!(grid.cells.units(1, y) > 0, weight(1, y + 3) > 0.0);
            }
            for i in 0..=10_000 {
                let u = (i as f32 / 10_000.0).min(1.0 - f32::EPSILON / 2.0);
                let (index, inside, units) = grid.cells.sample(1, u);
                assert!(units == grid.cells.units(1, index) && units > 0 && (0.0..1.0).contains(&inside));
                let [low, high] = [0, 1].map(|next| grid.cells.sums[grid.cells.length + 1 + index + next]);
                assert!((low..high).contains(&((u * UNITS as f32) as u32)));
            }
        }
    }
}
