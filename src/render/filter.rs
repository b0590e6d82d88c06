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

/// Integral of `exp(-2 x^2)` within the radius: sqrt(pi / 2) erf(1.5 sqrt 2).
const GAUSSIAN_AREA: f32 = 1.249_93;
/// The mean of the window times its width.
const BLACKMAN_HARRIS_AREA: f32 = 0.358_75 * 2.0 * RADIUS;

static GAUSSIAN: LazyLock<Vec<f32>> = LazyLock::new(|| inverse_cdf(gaussian));
static BLACKMAN_HARRIS: LazyLock<Vec<f32>> = LazyLock::new(|| inverse_cdf(blackman_harris));

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

    /// The other way round: a pixel that a point of the picture counts for, along one axis, drawn in proportion to the filters of
    /// the pixels around; and the sum of those.
    #[inline]
    pub fn pick(self, at: f32, u: f32) -> (i32, f32) {
        let density = match self {
            Self::Box => return (at.floor() as i32, 1.0),
            Self::Gaussian => |x: f32| gaussian(x) / GAUSSIAN_AREA,
            Self::BlackmanHarris => |x: f32| blackman_harris(x) / BLACKMAN_HARRIS_AREA,
        };
        let middle = at.floor() as i32;
        let pixels = [middle - 1, middle, middle + 1];
        let shares = pixels.map(|pixel| density(at - (pixel as f32 + 0.5)));
        let sum = shares[0] + shares[1] + shares[2];
        let u = u * sum;
        let chosen = usize::from(u >= shares[0]) + usize::from(u >= shares[0] + shares[1]);
        (pixels[chosen], sum)
    }
}

/// In pixels from the centre, within [`RADIUS`].
fn gaussian(x: f32) -> f32 {
    if x.abs() < RADIUS { (-2.0 * x * x).exp() } else { 0.0 }
}

/// Harris 1978, the minimum 4-term window.
fn blackman_harris(x: f32) -> f32 {
    let t = PI * (x / RADIUS + 1.0);
    let window = 0.358_75 - 0.488_29 * t.cos() + 0.141_28 * (2.0 * t).cos() - 0.011_68 * (3.0 * t).cos();
    if x.abs() < RADIUS { window.max(0.0) } else { 0.0 }
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
        sum += f64::from(density(x_of(i) + RADIUS / STEPS as f32));
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

    /// A point that a filter draws counts, in the mean, for the pixel as much as the filter says.
    #[test]
    fn picked_pixels_follow_the_filters() {
        for filter in [Filter::Box, Filter::Gaussian, Filter::BlackmanHarris] {
            // Of points all over the picture those that count for pixel 7.
            let (mut sum, mut second) = (0.0, 0.0);
            let count = 1 << 18;
            for i in 0..count {
                let at = 14.0 * (i as f32 + 0.5) / count as f32;
                let (pixel, weight) = filter.pick(at, (i as f32 * 0.618_034).fract());
                if pixel == 7 {
                    sum += weight * 14.0 / count as f32;
                    second += weight * (at - 7.5).powi(2) * 14.0 / count as f32;
                }
            }
            let offsets: Vec<f32> = (0..10_000).map(|i| filter.sample((i as f32 + 0.5) / 10_000.0)).collect();
            let spread = offsets.iter().map(|x| x * x).sum::<f32>() / 1e4;
            assert!((sum - 1.0).abs() < 2e-3, "{filter:?}: {sum}");
            assert!((second / spread - 1.0).abs() < 0.01, "{filter:?}: {second} {spread}");
        }
    }

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
