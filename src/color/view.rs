//! From linear light to what a display is sent.

use glam::{Mat3, Vec3};
use serde::{Deserialize, Serialize};

use super::gamut::{into_srgb, without_negatives};

/// How linear sRGB becomes a display's signal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum View {
    /// The sRGB curve. What sRGB cannot show keeps its hue: it is brought inside along lines of equal hue in Oklab.
    #[default]
    Srgb,
    /// AgX: sixteen and a half stops, bright colours pale to white. Troy Sobotka 2022, in the form of Benjamin Wrensch's
    /// "Minimal AgX Implementation" (2024, MIT): its two matrices and the polynomial in place of the curve.
    Agx,
    /// A film-like curve for each channel: Krzysztof Narkowicz 2016, "ACES Filmic Tone Mapping Curve" (CC0), exposed so that
    /// mid grey (0.18) stays where it is.
    Filmic,
    /// The sRGB curve with each channel clipped for itself.
    None,
}

/// Columns of the matrix that draws colours together before AgX's curve, and of the one that spreads them after.
const AGX_INSET: Mat3 = Mat3::from_cols_array(&[
    0.842_479_06,
    0.042_328_242,
    0.042_375_655,
    0.078_433_6,
    0.878_468_64,
    0.078_433_6,
    0.079_223_745,
    0.079_166_13,
    0.879_143,
]);
const AGX_OUTSET: Mat3 = Mat3::from_cols_array(&[
    1.196_879,
    -0.052_896_85,
    -0.052_971_635,
    -0.098_020_88,
    1.151_903_1,
    -0.098_043_45,
    -0.099_029_74,
    -0.098_961_18,
    1.151_073_7,
]);
/// Stops at which AgX's curve begins and ends: 10 below and 6.5 above mid grey.
const AGX_STOPS: [f32; 2] = [-12.473_93, 4.026_069];
/// AgX's curve over those stops, highest power first.
const AGX_CURVE: [f32; 7] = [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.002_32];
/// What the filmic curve leaves mid grey at 0.18 with.
const FILMIC_EXPOSURE: f32 = 0.723_17;
/// Brighter is not told apart: infinity has no hue.
const BRIGHTEST: f32 = 1e6;

impl View {
    /// The signal, 0..1, of linear sRGB; and whether the colour is none that sRGB holds (or not a number, which becomes
    /// black). Bright ones count where the view has no curve for them.
    pub fn show(self, rgb: Vec3) -> (Vec3, bool) {
        if rgb.is_nan() {
            return (Vec3::ZERO, true);
        }
        let rgb = rgb.clamp(Vec3::splat(-BRIGHTEST), Vec3::splat(BRIGHTEST));
        let negative = rgb.min_element() < 0.0;
        let outside = negative || rgb.max_element() > 1.0;
        match self {
            Self::Srgb => (into_srgb(rgb).map(clipped), outside),
            Self::None => (rgb.map(clipped), outside),
            Self::Agx => (agx(without_negatives(rgb)), negative),
            Self::Filmic => (without_negatives(rgb).map(|x| clipped(filmic(x * FILMIC_EXPOSURE))), negative),
        }
    }
}

/// The signal itself: AgX aims at displays, not at light.
fn agx(rgb: Vec3) -> Vec3 {
    let [low, high] = AGX_STOPS;
    let curved = (AGX_INSET * rgb).map(|x| {
        let stops = x.max(f32::MIN_POSITIVE).log2().clamp(low, high);
        let x = (stops - low) / (high - low);
        AGX_CURVE.iter().fold(0.0, |sum, factor| sum * x + factor)
    });
    (AGX_OUTSET * curved).clamp(Vec3::ZERO, Vec3::ONE)
}

fn clipped(linear: f32) -> f32 {
    srgb_encode(linear.clamp(0.0, 1.0))
}

fn filmic(x: f32) -> f32 {
    x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
}

/// Linear light in [0, 1] to the sRGB signal (IEC 61966-2-1). Values outside are mapped too, odd about zero; clamping is
/// the caller's choice.
pub fn srgb_encode(linear: f32) -> f32 {
    let magnitude = linear.abs();
    // 1.055 p - 0.055, written so that 1 gives 1 to the last bit.
    let power = |x: f32| 1.0 + 1.055 * (x.powf(1.0 / 2.4) - 1.0);
    let signal = if magnitude <= 0.003_130_8 { 12.92 * magnitude } else { power(magnitude) };
    signal.copysign(linear)
}

/// The sRGB signal to linear light: the inverse of [`srgb_encode`].
pub fn srgb_decode(signal: f32) -> f32 {
    let magnitude = signal.abs();
    let linear = if magnitude <= 0.040_45 { magnitude / 12.92 } else { ((magnitude + 0.055) / 1.055).powf(2.4) };
    linear.copysign(signal)
}
