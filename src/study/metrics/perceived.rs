//! Pictures as a display shows them, and colour differences between them.

use crate::color::{Lab, delta_e_2000};

use super::image::Image;

/// The brightness that a mean pixel is brought to: a mid grey.
const MID_GREY: f64 = 0.18;

/// Gain from radiance to a display, where 1 is white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposure(f64);

impl Exposure {
    pub fn from_stops(ev: f32) -> Self {
        Self(f64::from(ev).exp2())
    }

    /// Brings the mean luminance of a picture to a mid grey of 0.18; a black picture stays as it is.
    pub fn of(image: &Image) -> Self {
        let luminance = |[r, g, b]: &[f64; 3]| 0.2126 * r + 0.7152 * g + 0.0722 * b;
        let mean = image.rgb.iter().map(luminance).sum::<f64>() / image.rgb.len() as f64;
        Self(if mean > 0.0 { MID_GREY / mean } else { 1.0 })
    }

    pub fn stops(self) -> f64 {
        self.0.log2()
    }

    /// Linear sRGB of the display, clipped to 0..1; NaN is black.
    pub fn show(self, image: &Image) -> Image {
        let shown = |value: f64| if value.is_nan() { 0.0 } else { (value * self.0).clamp(0.0, 1.0) };
        Image { rgb: image.rgb.iter().map(|pixel| pixel.map(shown)).collect(), variance: None, ..*image }
    }
}

/// CIEDE2000 between the pixels of two pictures of the same size, as a display shows them.
pub fn delta_e_map(shown: &Image, reference: &Image) -> Vec<f64> {
    let pairs = shown.rgb.iter().zip(&reference.rgb);
    pairs.map(|(a, b)| delta_e_2000(Lab::from_linear_srgb(*b), Lab::from_linear_srgb(*a))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exposure_brings_the_mean_to_a_mid_grey_and_clips() {
        let image = Image::row(&[[0.0; 3], [2.0; 3], [f64::NAN, -1.0, 4.0]]);
        let exposure = Exposure::of(&Image::row(&[[0.0; 3], [2.0; 3]]));
        assert!((exposure.stops() - 0.18f64.log2()).abs() < 1e-12);
        let shown = exposure.show(&image);
        assert_eq!(shown.rgb, [[0.0; 3], [0.36; 3], [0.0, 0.0, 0.72]]);
        assert_eq!(Exposure::of(&Image::row(&[[0.0; 3]])), Exposure::from_stops(0.0));
    }

    #[test]
    fn white_against_black_differs_by_a_hundred_and_greys_by_lightness() {
        let map = delta_e_map(&Image::row(&[[1.0; 3], [0.5; 3]]), &Image::row(&[[0.0; 3], [0.5; 3]]));
        assert!((map[0] - 100.0).abs() < 1e-9 && map[1] == 0.0, "{map:?}");
        // L* = 116 Y^(1/3) - 16: 0.18 is 49.4961, 0.2 is 51.8372, mean 50.6667, S_L = 1 + 0.015 * 0.4444 / sqrt(20.4444).
        let greys = delta_e_map(&Image::row(&[[0.2; 3]]), &Image::row(&[[0.18; 3]]));
        assert!((greys[0] - 2.3411 / 1.001_474).abs() < 2e-4, "{greys:?}");
    }
}
