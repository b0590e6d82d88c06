//! Numbers in CSV files.

/// Ten significant digits, without trailing zeros: enough to compare to 1e-9.
pub(super) fn ten_digits(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        // Also turns -0 into 0.
        return if value == 0.0 { "0".to_owned() } else { value.to_string() };
    }
    let scientific = format!("{value:.9e}");
    // The exponent after rounding decides: 9.9999999999 has two digits before the point.
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    match exponent.parse::<i32>() {
        Ok(exponent @ -4..10) => trimmed(&format!("{value:.*}", (9 - exponent) as usize)).to_owned(),
        _ => format!("{}e{exponent}", trimmed(mantissa)),
    }
}

fn trimmed(digits: &str) -> &str {
    if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits }
}

/// A step of 1, 2 or 5 times a power of ten that divides `span` into at most `most` parts.
pub(super) fn round_step(span: f64, most: f64) -> f64 {
    let least = span / most;
    let power = 10f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0].map(|digit| digit * power).into_iter().find(|&step| step >= least).unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::{round_step, ten_digits};

    #[test]
    fn numbers_have_ten_digits_and_no_more() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (1.0, "1"),
            (380.0, "380"),
            (0.1 + 0.2, "0.3"),
            (1.0 / 3.0, "0.3333333333"),
            (-2.0 / 3.0, "-0.6666666667"),
            (0.000_123_456_789_012, "0.000123456789"),
            (1.466_442_084_49e-34, "1.466442084e-34"),
            (9.999_999_999_9, "10"),
            (1e10, "1e10"),
        ] {
            assert_eq!(ten_digits(value), text);
        }
    }

    #[test]
    fn steps_are_round_and_few() {
        assert_eq!(round_step(1000.0, 10.0), 100.0);
        assert_eq!(round_step(90.0, 10.0), 10.0);
        assert_eq!(round_step(200.0, 10.0), 20.0);
        assert_eq!(round_step(85.0, 10.0), 10.0);
        assert!((round_step(0.3, 4.0) - 0.1).abs() < 1e-12);
    }
}
