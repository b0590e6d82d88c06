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
#[derive(Clone, Debug)]
pub struct Grid {
    width: usize,
    height: usize,
    /// Cumulative weight of the rows (height + 1 entries, first 0, last 1), and of the cells in each row.
    rows: Vec<f32>,
    cells: Vec<f32>,
    /// Cell weights divided by their mean: the density itself.
    density: Vec<f32>,
}

impl Grid {
    /// Row-major weights; `None` when none is positive.
    pub fn new(weights: &[f32], width: usize) -> Option<Self> {
        let height = weights.len().checked_div(width)?;
        let clean = |w: f32| if w.is_finite() && w > 0.0 { f64::from(w) } else { 0.0 };
        let total: f64 = weights.iter().map(|&w| clean(w)).sum();
        if total <= 0.0 {
            return None;
        }
        let row_sums = weights.chunks_exact(width).map(|row| row.iter().map(|&w| clean(w)).sum::<f64>());
        let rows = cumulative(row_sums);
        let cells = weights.chunks_exact(width).flat_map(|row| cumulative(row.iter().map(|&w| clean(w)))).collect();
        let mean = total / weights.len() as f64;
        let density = weights.iter().map(|&w| (clean(w) / mean) as f32).collect();
        Some(Self { width, height, rows, cells, density })
    }

    /// (point, density at it), from two numbers in [0, 1).
    pub fn sample(&self, u: [f32; 2]) -> ([f32; 2], f32) {
        let (row, dy) = pick(&self.rows, u[1]);
        let stride = self.width + 1;
        let (column, dx) = pick(&self.cells[row * stride..(row + 1) * stride], u[0]);
        let point = [(column as f32 + dx) / self.width as f32, (row as f32 + dy) / self.height as f32];
        (point, self.density[row * self.width + column])
    }

    /// Density at a point of [0, 1)^2.
    pub fn pdf(&self, point: [f32; 2]) -> f32 {
        let column = ((point[0] * self.width as f32) as usize).min(self.width - 1);
        let row = ((point[1] * self.height as f32) as usize).min(self.height - 1);
        self.density[row * self.width + column]
    }
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
