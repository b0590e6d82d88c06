//! Many errors in three numbers.

use serde::Serialize;

/// Mean, 99th percentile and greatest of some errors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    pub mean: f64,
    pub p99: f64,
    pub max: f64,
}

impl Spread {
    /// The percentile is the least value that at least 99 % of the values do not exceed. Of no values everything is 0.
    pub fn of(values: &[f64]) -> Self {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let Some(&max) = sorted.last() else { return Self::default() };
        let rank = (0.99 * sorted.len() as f64).ceil() as usize;
        let mean = sorted.iter().sum::<f64>() / sorted.len() as f64;
        Self { mean, p99: sorted[rank.saturating_sub(1)], max }
    }
}

#[cfg(test)]
mod tests {
    use super::Spread;

    #[test]
    fn the_percentile_leaves_one_value_in_a_hundred_above() {
        let values: Vec<f64> = (1..=200).rev().map(f64::from).collect();
        assert_eq!(Spread::of(&values), Spread { mean: 100.5, p99: 198.0, max: 200.0 });
        assert_eq!(Spread::of(&[3.0]), Spread { mean: 3.0, p99: 3.0, max: 3.0 });
        assert_eq!(Spread::of(&[]), Spread::default());
    }
}
