//! A logarithmic axis.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use super::number::ten_digits;

/// From and to 1, 2 or 5 times a power of ten.
pub(super) struct Decades {
    ends: [f64; 2],
}

/// Axes of up to this many powers of ten show 2 and 5 as well.
const SHORT: f64 = 1.7;

impl Decades {
    /// Around some values; those that are not above 0 have no place.
    pub(super) fn around(values: impl Iterator<Item = f64>) -> Self {
        let values = values.filter(|value| *value > 0.0 && value.is_finite());
        let [low, high] = values.fold([f64::INFINITY, 0.0], |[a, b]: [f64; 2], v| [a.min(v), b.max(v)]);
        if low > high {
            return Self { ends: [1.0, 10.0] };
        }
        // What misses a round number by rounding is one.
        let below = round_numbers(low).into_iter().rev().find(|&round| round <= low * (1.0 + 1e-9));
        let above = round_numbers(high).into_iter().find(|&round| round >= high * (1.0 - 1e-9));
        let [low, high] = [below.unwrap_or(low), above.unwrap_or(high)];
        Self { ends: [low, if high > low { high } else { 10.0 * low }] }
    }

    pub(super) fn ends(&self) -> [f64; 2] {
        self.ends
    }
}

/// 1, 2, 5, 10, ... from below a value to above it.
fn round_numbers(value: f64) -> Vec<f64> {
    let exponent = value.log10().floor() as i32;
    (exponent - 1..=exponent + 1)
        .flat_map(|exponent| [1.0, 2.0, 5.0].map(|digit| digit * 10f64.powi(exponent)))
        .collect()
}

impl Ranged for Decades {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    /// Values beyond the ends are drawn at them.
    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let share = (value / self.ends[0]).ln() / (self.ends[1] / self.ends[0]).ln();
        limit.0 + (f64::from(limit.1 - limit.0) * share.clamp(0.0, 1.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _hint: Hint) -> Vec<f64> {
        let [low, high] = self.ends.map(f64::log10);
        let digits: &[f64] = if high - low < SHORT { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let all = (low.floor() as i32..=high.ceil() as i32).flat_map(|e| digits.iter().map(move |d| d * 10f64.powi(e)));
        all.filter(|value| (self.ends[0] * 0.999..=self.ends[1] * 1.001).contains(value)).collect()
    }

    fn range(&self) -> Range<f64> {
        self.ends[0]..self.ends[1]
    }
}

impl ValueFormatter<f64> for Decades {
    fn format(value: &f64) -> String {
        if (1e-3..1e5).contains(value) { ten_digits(*value) } else { format!("{value:.0e}") }
    }
}

#[cfg(test)]
mod tests {
    use plotters::coord::ranged1d::BoldPoints;

    use super::*;

    #[test]
    fn axes_end_at_round_numbers() {
        assert_eq!(Decades::around([0.3, 30.0, 0.0, f64::NAN].into_iter()).ends(), [0.2, 50.0]);
        assert_eq!(Decades::around([0.1 + 0.2 - 0.1].into_iter()).ends(), [0.2, 2.0]);
        assert_eq!(Decades::around([].into_iter()).ends(), [1.0, 10.0]);
        let axis = Decades::around([1.0, 100.0].into_iter());
        assert_eq!([1.0, 10.0, 100.0, 0.0, 1e9].map(|value| axis.map(&value, (0, 300))), [0, 150, 300, 0, 300]);
        assert_eq!(axis.key_points(BoldPoints(9)), [1.0, 10.0, 100.0]);
        assert_eq!(Decades::around([0.2, 1.5].into_iter()).key_points(BoldPoints(9)), [0.2, 0.5, 1.0, 2.0]);
        assert_eq!([2e-5, 0.01, 1e3].map(|value| Decades::format(&value)), ["2e-5", "0.01", "1000"]);
    }
}
