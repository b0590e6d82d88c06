//! Do two pictures show the same? A z-test of every value against the variances that both files state.

use std::f64::consts::SQRT_2;

use serde::Serialize;

use super::image::Image;

/// Share of the values that may be beyond the limit: variances are estimated from few samples and are far too small where
/// rare bright paths were missed. The rule of Mitsuba 3's render tests.
pub const MOST_OUTLIERS: f64 = 0.0025;
/// Differences below this share of the larger value are rounding of the file, not noise.
const ROUNDING: f64 = 2e-3;

/// What was found. `p` values are two-sided. Our own files state the variance of independent samples, more than what
/// stratified ones have: the test then errs on the side of "same".
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ZTest {
    /// Significance of the whole test, and of one value after Sidak's correction.
    pub alpha: f64,
    pub alpha_of_value: f64,
    /// Values (pixels times channels) that were tested, and that are beyond their limit.
    pub values: usize,
    pub outliers: usize,
    /// The largest |z| of one value.
    pub worst_z: f64,
    /// z of the mean of the whole picture per channel, and its smallest p.
    pub mean_z: [f64; 3],
    pub mean_p: f64,
    /// At most [`MOST_OUTLIERS`] of the values are beyond, and the means agree.
    pub passed: bool,
}

/// Tests at the significance `alpha`; `None` when a picture has no variances. Sidak's correction (1967): of n independent
/// tests each must be as significant as 1 - (1 - alpha)^(1/n). Values whose variance is not known (one sample) are left
/// out.
pub fn z_test(a: &Image, b: &Image, alpha: f64) -> Option<ZTest> {
    let (spread_a, spread_b) = (a.variance.as_ref()?, b.variance.as_ref()?);
    let (mut sums, mut spreads) = ([0.0; 3], [0.0; 3]);
    let mut scores = Vec::with_capacity(3 * a.rgb.len());
    for (i, (one, two)) in a.rgb.iter().zip(&b.rgb).enumerate() {
        for c in 0..3 {
            let variance = spread_a[i][c] + spread_b[i][c];
            if !variance.is_finite() {
                continue;
            }
            let difference = one[c] - two[c];
            sums[c] += difference;
            spreads[c] += variance;
            let rounding = ROUNDING * one[c].abs().max(two[c].abs());
            let beyond = (difference.abs() - rounding).max(0.0);
            // Without any noise every difference is one.
            scores.push(if beyond > 0.0 { beyond / variance.sqrt() } else { 0.0 });
        }
    }
    let alpha_of_value = sidak(alpha, scores.len());
    let outliers = scores.iter().filter(|&&z| normal_tail(z) < alpha_of_value).count();
    let mean_z = std::array::from_fn(|c| if sums[c] == 0.0 { 0.0 } else { sums[c] / f64::sqrt(spreads[c]) });
    let mean_p = mean_z.map(normal_tail).into_iter().fold(1.0, f64::min);
    let few = outliers as f64 <= MOST_OUTLIERS * scores.len() as f64;
    Some(ZTest {
        alpha,
        alpha_of_value,
        values: scores.len(),
        outliers,
        worst_z: scores.iter().copied().fold(0.0, f64::max),
        mean_z,
        mean_p,
        passed: few && mean_p >= sidak(alpha, 3),
    })
}

fn sidak(alpha: f64, count: usize) -> f64 {
    // Through logarithms: 1 - x would lose the digits of a small result.
    -((-alpha).ln_1p() / count.max(1) as f64).exp_m1()
}

/// Two-sided probability of a standard normal beyond |z|: erfc(|z| / sqrt 2), by the series below 2.5 and the continued
/// fraction (Lentz) above; Abramowitz & Stegun 7.1.6 and 7.1.14.
fn normal_tail(z: f64) -> f64 {
    let x = z.abs() / SQRT_2;
    let bell = (-x * x).exp() / std::f64::consts::PI.sqrt();
    if !x.is_finite() {
        return 0.0;
    }
    if x < 2.5 {
        let (mut term, mut sum, mut n) = (2.0 * x, 2.0 * x, 1.0);
        while term > 1e-17 * sum {
            term *= 2.0 * x * x / (2.0 * n + 1.0);
            sum += term;
            n += 1.0;
        }
        return 1.0 - bell * sum;
    }
    let fraction = (1..=60).rev().fold(x, |below, n| x + 0.5 * f64::from(n) / below);
    bell / fraction
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_are_those_of_the_tables() {
        for (z, p) in [(0.0, 1.0), (1.0, 0.317_310_507_863), (1.959_963_985, 0.05), (3.5, 4.652_581_581e-4)] {
            assert!((normal_tail(z) / p - 1.0).abs() < 1e-8, "{z}: {}", normal_tail(z));
        }
        assert!((normal_tail(-6.0) / 1.973_175_290e-9 - 1.0).abs() < 1e-7);
        assert_eq!(normal_tail(f64::INFINITY), 0.0);
        assert!((sidak(0.05, 1) - 0.05).abs() < 1e-15 && (sidak(0.05, 100) - 5.128_014_162e-4).abs() < 1e-12);
    }

    #[test]
    fn a_shift_within_the_noise_of_pixels_shows_in_the_mean() {
        let with = |value: f64| Image { variance: Some(vec![[0.01; 3]; 400]), ..Image::row(&[[value; 3]; 400]) };
        let same = z_test(&with(1.0), &with(1.0), 0.01);
        assert!(same.is_some_and(|test| test.passed && test.worst_z == 0.0 && test.values == 1200), "{same:?}");
        // 0.03 is 0.2 standard deviations of one pixel's difference, and 4.2 of the mean's.
        let shifted = z_test(&with(1.03), &with(1.0), 0.01);
        let right = |test: ZTest| !test.passed && test.outliers == 0 && (test.mean_z[1] - 4.2426).abs() < 1e-3;
        assert!(shifted.is_some_and(right), "{shifted:?}");
        assert_eq!(z_test(&with(1.0), &Image::row(&[[1.0; 3]; 400]), 0.01), None);
    }

    #[test]
    fn differences_without_noise_are_differences() {
        let mut a = Image::row(&[[1.0; 3]; 100]);
        a.variance = Some(vec![[0.0; 3]; 100]);
        let mut b = a.clone();
        b.rgb[3] = [1.5, 1.0005, 1.0];
        let test = z_test(&a, &b, 0.01);
        assert!(test.is_some_and(|test| test.outliers == 1 && !test.passed), "{test:?}");
    }
}
