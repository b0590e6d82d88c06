//! Powers that measurements follow.

/// The exponent b of y = a x^b through (x, y), by least squares over the logarithms. Points that have no logarithm are left
/// out; `None` where fewer than two different x remain.
pub(super) fn exponent(points: &[(f64, f64)]) -> Option<f64> {
    let logarithms = points.iter().map(|(x, y)| (x.ln(), y.ln()));
    let points: Vec<(f64, f64)> = logarithms.filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
    let count = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / count, b + y / count));
    let (top, bottom) = points.iter().fold((0.0, 0.0), |(t, b), p| (t + (p.0 - x) * (p.1 - y), b + (p.0 - x).powi(2)));
    (bottom > 0.0).then(|| top / bottom)
}

#[cfg(test)]
mod tests {
    use super::exponent;

    #[test]
    fn powers_are_found_exactly() {
        for power in [-1.5, 0.0, 0.3, 1.0, 2.0] {
            let points = [1.0f64, 3.0, 10.0, 1e7].map(|x| (x, 5.0 * x.powf(power)));
            assert!(exponent(&points).is_some_and(|found| (found - power).abs() < 1e-12), "{power}");
        }
    }

    #[test]
    fn errors_to_both_sides_are_shared_out() {
        // A factor up, down, down, up again at even steps: no line is nearer than the level one.
        let points = [(1.0, 2.0), (10.0, 0.5), (100.0, 0.5), (1000.0, 2.0)];
        assert!(exponent(&points).is_some_and(|found| found.abs() < 1e-12));
        // The slope of (0, 0), (1, 0), (2, 3) is 3/2.
        let points = [(1.0, 1.0), (10.0, 1.0), (100.0, 1000.0)];
        assert!(exponent(&points).is_some_and(|found| (found - 1.5).abs() < 1e-12));
    }

    #[test]
    fn what_has_no_logarithm_or_no_spread_has_no_exponent() {
        let points = [(1.0, 1.0), (2.0, 0.0), (0.0, 3.0), (-1.0, 2.0), (5.0, f64::NAN), (4.0, 16.0)];
        assert!(exponent(&points).is_some_and(|found| (found - 2.0).abs() < 1e-12));
        assert_eq!(exponent(&points[..2]), None);
        assert_eq!((exponent(&[]), exponent(&[(2.0, 2.0), (2.0, 3.0)])), (None, None));
    }
}
