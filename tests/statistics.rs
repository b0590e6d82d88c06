//! The tests' own tools: chi-square, z-tests, Sidak's correction. Seeds are fixed; every test states its significance.

/// Per-test significance so that `count` independent tests together fail by chance with probability `alpha`. Sidak 1967.
pub fn sidak(alpha: f64, count: usize) -> f64 {
    1.0 - (1.0 - alpha).powf(1.0 / count as f64)
}

/// Probability that a chi-square variable with `dof` degrees of freedom exceeds `statistic`.
pub fn chi_square_tail(statistic: f64, dof: usize) -> f64 {
    upper_gamma(0.5 * dof as f64, 0.5 * statistic)
}

/// Two-sided probability of a standard normal beyond |z|.
pub fn normal_tail(z: f64) -> f64 {
    upper_gamma(0.5, 0.5 * z * z)
}

/// Regularised upper incomplete gamma function Q(a, x): series below a + 1, Lentz's continued fraction above.
fn upper_gamma(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    let front = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > sum * 1e-15 {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return 1.0 - front * sum;
    }
    let mut b = x + 1.0 - a;
    let mut c = 1e300;
    let mut d = 1.0 / b;
    let mut h = d;
    for i in 1..10_000 {
        let an = -(i as f64) * (i as f64 - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        let delta = c * d;
        h *= delta;
        if (delta - 1.0).abs() < 1e-15 {
            break;
        }
    }
    front * h
}

/// Lanczos' approximation (g = 7, n = 9).
fn ln_gamma(x: f64) -> f64 {
    const COEFFICIENTS: [f64; 8] = [
        676.5203681218851,
        -1259.1392167224028,
        771.323_428_777_653_1,
        -176.615_029_162_140_6,
        12.507343278686905,
        -0.13857109526572012,
        9.984_369_578_019_572e-6,
        1.5056327351493116e-7,
    ];
    if x < 0.5 {
        return (std::f64::consts::PI / (std::f64::consts::PI * x).sin()).ln() - ln_gamma(1.0 - x);
    }
    let x = x - 1.0;
    let t = x + 7.5;
    let sum: f64 =
        COEFFICIENTS.iter().enumerate().map(|(i, c)| c / (x + i as f64 + 1.0)).sum::<f64>() + 0.999_999_999_999_809_9;
    0.5 * (2.0 * std::f64::consts::PI).ln() + (x + 0.5) * t.ln() - t + sum.ln()
}

/// Chi-square p-value of observed against expected counts; sparse cells are pooled, and counts where nothing is expected
/// fail outright.
pub fn chi_square(observed: &[f64], expected: &[f64]) -> f64 {
    let (mut statistic, mut cells) = (0.0, 0usize);
    let (mut pooled_observed, mut pooled_expected) = (0.0, 0.0);
    let mut order: Vec<usize> = (0..expected.len()).collect();
    order.sort_by(|&a, &b| expected[a].total_cmp(&expected[b]));
    for i in order {
        pooled_observed += observed[i];
        pooled_expected += expected[i];
        if pooled_expected >= 5.0 {
            statistic += (pooled_observed - pooled_expected).powi(2) / pooled_expected;
            cells += 1;
            (pooled_observed, pooled_expected) = (0.0, 0.0);
        }
    }
    if pooled_expected > 0.0 || pooled_observed > 0.0 {
        if pooled_expected < 1e-3 && pooled_observed > 3.0 {
            return 0.0;
        }
        statistic += (pooled_observed - pooled_expected).powi(2) / pooled_expected.max(1.0);
        cells += 1;
    }
    if cells < 2 { 1.0 } else { chi_square_tail(statistic, cells - 1) }
}

#[test]
fn tails_match_tables() {
    // Abramowitz & Stegun, tables 26.7 and 26.1.
    assert!((chi_square_tail(18.307, 10) - 0.05).abs() < 1e-5);
    assert!((chi_square_tail(3.841, 1) - 0.05).abs() < 1e-4);
    assert!((chi_square_tail(124.342, 100) - 0.05).abs() < 1e-5);
    assert!((normal_tail(1.959_964) - 0.05).abs() < 1e-6);
    assert!((normal_tail(5.0) - 5.733e-7).abs() < 1e-9);
}
