//! Squared errors of linear radiance.

use serde::Serialize;

use super::image::Image;

/// Darkness below which relative errors stop growing: squared errors are divided by reference^2 + this.
const RELATIVE_FLOOR: f64 = 1e-2;
/// Share of the pixels that the trimmed error keeps; it leaves out the worst, which are fireflies.
const KEPT: f64 = 0.999;

/// Means over pixels and channels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SquaredErrors {
    pub mse: f64,
    /// Relative to reference^2 + 0.01.
    pub rel_mse: f64,
    /// Relative, without the worst 0.1 % of the pixels (rounded up).
    pub trimmed_rel_mse: f64,
}

/// Errors of `image` against `reference`, which has the same size. `noise` is the variance of the reference's mean, which
/// adds to squared differences: it is taken off again, down to 0.
pub fn squared_errors(image: &Image, reference: &Image, noise: Option<&[[f64; 3]]>) -> SquaredErrors {
    let (mut mse, mut relative) = (0.0, Vec::with_capacity(image.rgb.len()));
    for (i, (pixel, truth)) in image.rgb.iter().zip(&reference.rgb).enumerate() {
        let noise = noise.map_or([0.0; 3], |noise| noise[i]);
        let (mut square, mut off) = (0.0, 0.0);
        for c in 0..3 {
            let weight = 1.0 / (truth[c] * truth[c] + RELATIVE_FLOOR);
            let difference = (pixel[c] - truth[c]).powi(2);
            mse += difference - noise[c];
            square += difference * weight;
            off += noise[c] * weight;
        }
        // Sorted by what is seen, then freed of the noise: the other way round would prefer noisy references.
        relative.push((square / 3.0, off / 3.0));
    }
    relative.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mean = |kept: &[(f64, f64)]| {
        let sum: f64 = kept.iter().map(|(square, noise)| square - noise).sum();
        (sum / kept.len().max(1) as f64).max(0.0)
    };
    let kept = (relative.len() as f64 * KEPT) as usize;
    SquaredErrors {
        mse: (mse / (3 * image.rgb.len()) as f64).max(0.0),
        rel_mse: mean(&relative),
        trimmed_rel_mse: mean(&relative[..kept]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_what_a_hand_computes() {
        // 1000 pixels of 0.3, of which one is off by (0.3, 0, 0.6) and one by 0.1 in green.
        let reference = Image::row(&[[0.3; 3]; 1000]);
        let mut image = reference.clone();
        image.rgb[7] = [0.6, 0.3, 0.9];
        image.rgb[500] = [0.3, 0.4, 0.3];
        let got = squared_errors(&image, &reference, None);
        // Weights are 1 / (0.09 + 0.01) = 10; the worst pixel of the thousand is trimmed.
        assert!((got.mse - (0.09 + 0.36 + 0.01) / 3000.0).abs() < 1e-15, "{got:?}");
        assert!((got.rel_mse - 4.6 / 3000.0).abs() < 1e-14, "{got:?}");
        assert!((got.trimmed_rel_mse - 0.1 / (3.0 * 999.0)).abs() < 1e-15, "{got:?}");
    }

    #[test]
    fn the_noise_of_the_reference_is_taken_off() {
        let reference = Image::row(&[[0.0; 3], [1.0; 3]]);
        let image = Image::row(&[[0.2; 3], [1.2; 3]]);
        let got = squared_errors(&image, &reference, Some(&[[0.01; 3], [0.02; 3]]));
        assert!((got.mse - (0.04 - 0.015)).abs() < 1e-15, "{got:?}");
        assert!((got.rel_mse - 0.5 * (0.03 / 0.01 + 0.02 / 1.01)).abs() < 1e-12, "{got:?}");
        let all_noise = squared_errors(&reference, &reference, Some(&[[0.1; 3]; 2]));
        assert_eq!((all_noise.mse, all_noise.rel_mse), (0.0, 0.0));
    }
}
