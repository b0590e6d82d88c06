//! Display encodings.

/// Linear light in [0, 1] to the sRGB signal (IEC 61966-2-1). Values outside are mapped too, odd about zero; clamping is
/// the caller's choice.
pub fn srgb_encode(linear: f32) -> f32 {
    let magnitude = linear.abs();
    let signal = if magnitude <= 0.003_130_8 { 12.92 * magnitude } else { 1.055 * magnitude.powf(1.0 / 2.4) - 0.055 };
    signal.copysign(linear)
}

/// The sRGB signal to linear light: the inverse of [`srgb_encode`].
pub fn srgb_decode(signal: f32) -> f32 {
    let magnitude = signal.abs();
    let linear = if magnitude <= 0.040_45 { magnitude / 12.92 } else { ((magnitude + 0.055) / 1.055).powf(2.4) };
    linear.copysign(signal)
}
