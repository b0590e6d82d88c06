//! A logarithmic axis over whole powers of ten.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use super::number::ten_digits;

/// Exponents of its ends.
pub(super) struct Decades {
    low: i32,
    high: i32,
}

impl Decades {
    /// Around some values; those that are not above 0 have no place. At least one decade.
    pub(super) fn around(values: impl Iterator<Item = f64>) -> Self {
        let logarithms = values.filter(|value| *value > 0.0 && value.is_finite()).map(f64::log10);
        let [low, high] = logarithms.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(v), b.max(v)]);
        if low > high {
            return Self { low: 0, high: 1 };
        }
        let low = low.floor() as i32;
        Self { low, high: (high.ceil() as i32).max(low + 1) }
    }

    pub(super) fn ends(&self) -> [f64; 2] {
        [power(self.low), power(self.high)]
    }
}

fn power(exponent: i32) -> f64 {
    10f64.powi(exponent)
}

impl Ranged for Decades {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    /// Values beyond the ends are drawn at them.
    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let share = (value.log10() - f64::from(self.low)) / f64::from(self.high - self.low);
        limit.0 + (f64::from(limit.1 - limit.0) * share.clamp(0.0, 1.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _hint: Hint) -> Vec<f64> {
        (self.low..=self.high).map(power).collect()
    }

    fn range(&self) -> Range<f64> {
        let [low, high] = self.ends();
        low..high
    }
}

impl ValueFormatter<f64> for Decades {
    fn format(value: &f64) -> String {
        let exponent = value.log10().round() as i32;
        if (-3..=4).contains(&exponent) { ten_digits(power(exponent)) } else { format!("1e{exponent}") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_span_whole_decades() {
        assert_eq!(Decades::around([0.2, 30.0, 0.0, f64::NAN].into_iter()).ends(), [0.1, 100.0]);
        assert_eq!(Decades::around([10.0].into_iter()).ends(), [10.0, 100.0]);
        assert_eq!(Decades::around([].into_iter()).ends(), [1.0, 10.0]);
        let axis = Decades::around([1.0, 100.0].into_iter());
        assert_eq!([1.0, 10.0, 100.0, 0.0, 1e9].map(|value| axis.map(&value, (0, 300))), [0, 150, 300, 0, 300]);
        assert_eq!([1e-5, 0.01, 1e3].map(|value| Decades::format(&value)), ["1e-5", "0.01", "1000"]);
    }
}
