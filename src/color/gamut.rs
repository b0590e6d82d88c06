//! Colours that sRGB cannot show, brought into it along lines of equal hue.
//!
//! Films make colours purer than a screen's, and lamps are brighter than its white. Clipping each channel for itself turns
//! hues (bright orange becomes yellow); here the way goes through Oklab, where hue is a direction (Ottosson 2020, "A
//! perceptual color space for image processing"): from the colour towards a grey, to where sRGB begins.

use glam::{Mat3, Vec3};

/// Linear sRGB to cone responses, and their cube roots to lightness, a, b; column by column. Ottosson 2020.
const TO_CONES: Mat3 = Mat3::from_cols_array(&[
    0.412_221_47,
    0.211_903_5,
    0.088_302_46,
    0.536_332_54,
    0.680_699_5,
    0.281_718_84,
    0.051_445_993,
    0.107_396_96,
    0.629_978_7,
]);
const TO_LAB: Mat3 = Mat3::from_cols_array(&[
    0.210_454_26,
    1.977_998_5,
    0.025_904_037,
    0.793_617_8,
    -2.428_592_2,
    0.782_771_77,
    -0.004_072_047,
    0.450_593_7,
    -0.808_675_77,
]);
/// And back.
const FROM_LAB: Mat3 = Mat3::from_cols_array(&[
    1.0,
    1.0,
    1.0,
    0.396_337_78,
    -0.105_561_346,
    -0.089_484_18,
    0.215_803_76,
    -0.063_854_17,
    -1.291_485_5,
]);
const FROM_CONES: Mat3 = Mat3::from_cols_array(&[
    4.076_741_7,
    -1.268_438,
    -0.004_196_086_3,
    -3.307_711_6,
    2.609_757_4,
    -0.703_418_6,
    0.230_969_94,
    -0.341_319_4,
    1.707_614_7,
]);
/// How much lightness gives way to keep chroma: Ottosson 2021, "sRGB gamut clipping", adaptive towards a lightness of 0.5,
/// with the middle of his three values.
const GIVE: f32 = 0.5;
/// The way is cut in half this often.
const HALVINGS: u32 = 16;

/// The nearest colour of the same hue that sRGB holds, for linear sRGB of any size; what it holds stays as it is. A little
/// lightness is given away with the chroma, and more where there is too much of it: far above white there is only white.
pub fn into_srgb(rgb: Vec3) -> Vec3 {
    if rgb.cmpge(Vec3::ZERO).all() && rgb.cmple(Vec3::ONE).all() {
        return rgb;
    }
    let lab = to_oklab(rgb);
    let chroma = lab.y.hypot(lab.z);
    let above = lab.x - 0.5;
    let reach = 0.5 + above.abs() + GIVE * chroma;
    let grey = 0.5 * (1.0 + (reach - (reach * reach - 2.0 * above.abs()).max(0.0).sqrt()).copysign(above));
    let mapped = toward_grey(lab, grey.clamp(0.0, 1.0), |rgb| rgb.min_element() >= 0.0 && rgb.max_element() <= 1.0);
    mapped.clamp(Vec3::ZERO, Vec3::ONE)
}

/// The nearest colour of the same hue and lightness without negative channels: what tone curves can take. Brightness has no
/// limit.
pub fn without_negatives(rgb: Vec3) -> Vec3 {
    let scale = rgb.max_element();
    if rgb.min_element() >= 0.0 {
        return rgb;
    }
    if scale.is_nan() || scale <= 0.0 {
        return Vec3::ZERO;
    }
    let lab = to_oklab(rgb / scale);
    toward_grey(lab, lab.x.max(0.0), |rgb| rgb.min_element() >= 0.0).max(Vec3::ZERO) * scale
}

/// Goes from a colour towards a grey until it `fits`.
fn toward_grey(lab: Vec3, grey: f32, fits: impl Fn(Vec3) -> bool) -> Vec3 {
    let grey = Vec3::new(grey, 0.0, 0.0);
    let (mut inside, mut outside) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (inside + outside);
        let end = if fits(from_oklab(grey.lerp(lab, middle))) { &mut inside } else { &mut outside };
        *end = middle;
    }
    from_oklab(grey.lerp(lab, inside))
}

fn to_oklab(rgb: Vec3) -> Vec3 {
    TO_LAB * (TO_CONES * rgb).map(f32::cbrt)
}

fn from_oklab(lab: Vec3) -> Vec3 {
    FROM_CONES * (FROM_LAB * lab).map(|root| root * root * root)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hue_deg(rgb: Vec3) -> f32 {
        let lab = to_oklab(rgb);
        lab.z.atan2(lab.y).to_degrees()
    }

    /// Pure, bright, dark, and beyond all.
    fn strange() -> impl Iterator<Item = Vec3> {
        let levels = [-0.4f32, -0.02, 0.0, 0.3, 1.0, 1.3, 6.0];
        (0..343).map(move |i| Vec3::new(levels[i % 7], levels[i / 7 % 7], levels[i / 49]))
    }

    #[test]
    fn hues_stay_and_everything_fits() {
        for rgb in strange() {
            let mapped = into_srgb(rgb);
            assert!(mapped.min_element() >= 0.0 && mapped.max_element() <= 1.0, "{rgb}: {mapped}");
            let chroma = |rgb| to_oklab(rgb).yz().length();
            // Greys have no hue, and colours that are mostly negative are none.
            if chroma(mapped) > 0.02 && rgb.element_sum() > 0.3 {
                let turn = (hue_deg(mapped) - hue_deg(rgb) + 540.0).rem_euclid(360.0) - 180.0;
                assert!(turn.abs() < 1.0, "{rgb} to {mapped} turns by {turn} degrees");
            }
            assert!(chroma(mapped) <= chroma(rgb) + 1e-3, "{rgb}: {mapped}");
        }
    }

    #[test]
    fn what_fits_stays_and_far_above_white_is_white() {
        for rgb in [Vec3::ZERO, Vec3::ONE, Vec3::new(1.0, 0.0, 0.2)] {
            assert_eq!(into_srgb(rgb), rgb);
            assert_eq!(without_negatives(rgb * 7.0), rgb * 7.0);
        }
        for rgb in [Vec3::splat(2.0), Vec3::new(900.0, 800.0, 700.0)] {
            assert!((into_srgb(rgb) - 1.0).abs().max_element() < 0.02, "{}", into_srgb(rgb));
        }
        assert!(into_srgb(Vec3::splat(-1.0)).max_element() < 1e-6);
        assert!(!into_srgb(Vec3::NAN).is_nan());
    }

    #[test]
    fn negatives_go_while_lightness_stays() {
        // What has no luminance is no colour.
        let luminous = |rgb: &Vec3| rgb.dot(Vec3::new(0.2126, 0.7152, 0.0722)) > 0.05;
        for rgb in strange().filter(luminous) {
            let mapped = without_negatives(rgb);
            let lightness = [mapped, rgb].map(|rgb| to_oklab(rgb).x);
            assert!(mapped.min_element() >= 0.0, "{rgb}: {mapped}");
            assert!((lightness[0] / lightness[1] - 1.0).abs() < 0.02, "{rgb}: {lightness:?}");
        }
    }

    use glam::Vec3Swizzles;
}
