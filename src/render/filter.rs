//! Pixel filters, sampled: each sample's position is drawn in proportion to the filter, so it belongs to one pixel and has
//! weight 1. Ernst, Stamminger & Greiner 2006, "Filter Importance Sampling".

use std::f32::consts::PI;
use std::sync::LazyLock;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Filter {
    /// The pixel's square.
    Box,
    /// Standard deviation of half a pixel, cut at 1.5 pixels.
    Gaussian,
    /// Blackman-Harris window, 1.5 pixels to each side.
    #[default]
    BlackmanHarris,
}

/// Half width of the wide filters, pixels.
const RADIUS: f32 = 1.5;
const TABLE_SIZE: usize = 512;

static GAUSSIAN: LazyLock<Vec<f32>> = LazyLock::new(|| inverse_cdf(|x| (-2.0 * x * x).exp()));
/// Harris 1978, the minimum 4-term window.
static BLACKMAN_HARRIS: LazyLock<Vec<f32>> = LazyLock::new(|| {
    inverse_cdf(|x| {
        let t = PI * (x / RADIUS + 1.0);
        0.358_75 - 0.488_29 * t.cos() + 0.141_28 * (2.0 * t).cos() - 0.011_68 * (3.0 * t).cos()
    })
});

impl Filter {
    /// Offset from the pixel's centre along one axis, from a number in [0, 1).
    #[inline]
    pub fn sample(self, u: f32) -> f32 {
        match self {
            Self::Box => u - 0.5,
            Self::Gaussian => look_up(&GAUSSIAN, u),
            Self::BlackmanHarris => look_up(&BLACKMAN_HARRIS, u),
        }
    }
}

fn look_up(table: &[f32], u: f32) -> f32 {
    let position = u * (TABLE_SIZE - 1) as f32;
    let index = (position as usize).min(TABLE_SIZE - 2);
    let t = position - index as f32;
    table[index] + (table[index + 1] - table[index]) * t
}

/// Offsets at equally spaced values of the filter's cumulative distribution.
fn inverse_cdf(density: impl Fn(f32) -> f32) -> Vec<f32> {
    const STEPS: usize = 8192;
    let x_of = |i: usize| RADIUS * (2.0 * i as f32 / STEPS as f32 - 1.0);
    let mut cumulative = vec![0.0f64];
    let mut sum = 0.0;
    for i in 0..STEPS {
        sum += f64::from(density(x_of(i) + RADIUS / STEPS as f32).max(0.0));
        cumulative.push(sum);
    }
    let mut step = 0;
    (0..TABLE_SIZE)
        .map(|k| {
            let target = sum * k as f64 / (TABLE_SIZE - 1) as f64;
            while step + 1 < STEPS && cumulative[step + 1] < target {
                step += 1;
            }
            let width = cumulative[step + 1] - cumulative[step];
            let inside = if width > 0.0 { (target - cumulative[step]) / width } else { 0.0 };
            x_of(step) + inside as f32 * 2.0 * RADIUS / STEPS as f32
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filters_are_centred_and_as_wide_as_they_say() {
        // Blackman-Harris over [-1, 1]: 1/3 - 2 (a1 - a2/4 + a3/9) / (pi^2 a0) = 0.0767, times the radius squared.
        for (filter, variance) in
            [(Filter::Box, 1.0 / 12.0), (Filter::Gaussian, 0.243), (Filter::BlackmanHarris, 0.0767 * RADIUS * RADIUS)]
        {
            let offsets: Vec<f32> = (0..10_000).map(|i| filter.sample((i as f32 + 0.5) / 10_000.0)).collect();
            let mean = offsets.iter().sum::<f32>() / 1e4;
            let spread = offsets.iter().map(|x| x * x).sum::<f32>() / 1e4;
            assert!(mean.abs() < 1e-3, "{filter:?} mean {mean}");
            assert!((spread - variance).abs() < 0.05 * variance, "{filter:?} variance {spread}");
        }
    }
}
