//! PNG: sRGB, 8 or 16 bits, for looking at.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use png::{
    BitDepth, ColorType, Decoder, Encoder, EncodingError, PixelDimensions, ScaledFloat, SourceChromaticities,
    SrgbRenderingIntent, Unit,
};

use super::atomic;
use super::display::Display;
use super::error::OutputError;
use super::picture::{HeaderValue, Picture, Written};

/// Bits per channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PngDepth {
    /// Dithered, so that smooth gradients show no bands: each value is rounded up or down by the share that is lost, in a
    /// fixed pattern of pixel and channel. Values that 8 bits hold exactly stay as they are.
    #[default]
    Eight,
    /// Rounded to the nearest.
    Sixteen,
}

/// Writes R, G, B (over black) as a display shows them. The header goes into text chunks; extra layers stay behind. The same
/// picture gives the same bytes.
///
/// # Errors
/// Sizes that do not fit, or what the system says; the old file is untouched then.
pub fn write_png(path: &Path, picture: &Picture, display: Display, depth: PngDepth) -> Result<Written, OutputError> {
    picture.check().map_err(|reason| OutputError::picture(path, reason))?;
    let (signal, out_of_gamut) = pixels(picture, display, depth);
    let bytes = encode(picture, &signal, depth).map_err(|error| OutputError::picture(path, error))?;
    atomic::save(path, &bytes)?;
    Ok(Written { clamped: 0, out_of_gamut })
}

/// True if the file decodes to its end.
pub(super) fn is_complete(path: &Path) -> bool {
    let walk = || -> Result<(), png::DecodingError> {
        let mut reader = Decoder::new(BufReader::new(File::open(path)?)).read_info()?;
        while reader.next_row()?.is_some() {}
        reader.finish()
    };
    walk().is_ok()
}

/// Fine enough to state any ratio of a pixel's sides.
const PIXELS_PER_UNIT: u32 = 10_000;

fn encode(picture: &Picture, signal: &[u8], depth: PngDepth) -> Result<Vec<u8>, EncodingError> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, picture.width, picture.height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(match depth {
        PngDepth::Eight => BitDepth::Eight,
        PngDepth::Sixteen => BitDepth::Sixteen,
    });
    // gAMA and cHRM say the same to readers that do not know sRGB (PNG specification, 11.3.3.5).
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    encoder.set_source_gamma(ScaledFloat::from_scaled(45_455));
    let (white, red, green, blue) = ((0.3127, 0.329), (0.64, 0.33), (0.3, 0.6), (0.15, 0.06));
    encoder.set_source_chromaticities(SourceChromaticities::new(white, red, green, blue));
    let aspect = picture.pixel_aspect();
    if aspect != 1.0 {
        // Pixels per unit of length: fewer across where they are wide.
        let (xppu, yppu) = (PIXELS_PER_UNIT, (PIXELS_PER_UNIT as f32 * aspect).round() as u32);
        encoder.set_pixel_dims(Some(PixelDimensions { xppu, yppu, unit: Unit::Unspecified }));
    }
    encoder.add_text_chunk("Software".to_string(), format!("pellicle {}", env!("CARGO_PKG_VERSION")))?;
    for (name, value) in &picture.header {
        let value = match value {
            HeaderValue::Text(text) => text.clone(),
            HeaderValue::Int(number) => number.to_string(),
            HeaderValue::Float(number) => number.to_string(),
        };
        encoder.add_itxt_chunk(name.clone(), value)?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(signal)?;
    writer.finish()?;
    Ok(file)
}

/// The file's values, and how many pixels have a colour that is none of sRGB.
fn pixels(picture: &Picture, display: Display, depth: PngDepth) -> (Vec<u8>, u64) {
    let mut out_of_gamut = 0;
    let width = picture.width as usize;
    let mut bytes = Vec::with_capacity(picture.rgba.len() * 6);
    for (index, pixel) in picture.rgba.iter().enumerate() {
        let (signal, outside) = display.show([pixel[0], pixel[1], pixel[2]]);
        out_of_gamut += u64::from(outside);
        for (channel, code) in signal.into_iter().enumerate() {
            match depth {
                PngDepth::Eight => {
                    let dither = threshold((index % width) as u32, (index / width) as u32, channel as u32);
                    bytes.push((code * 255.0 + dither) as u8);
                }
                PngDepth::Sixteen => bytes.extend(((code * 65535.0 + 0.5) as u16).to_be_bytes()),
            }
        }
    }
    (bytes, out_of_gamut)
}

/// What is added before cutting to whole numbers: in 0..1, evenly spread over any neighbourhood. Roberts's R2 sequence along
/// both axes: fractions of x / p + y / p^2 with p = 1.3247... (the plastic number), a third further for each channel.
pub(super) fn threshold(x: u32, y: u32, channel: u32) -> f32 {
    let steps = x
        .wrapping_mul(3_242_174_889)
        .wrapping_add(y.wrapping_mul(2_447_445_414))
        .wrapping_add(channel.wrapping_mul(1_431_655_765));
    // 16 bits, so that a sum with 255 is exact.
    (steps >> 16) as f32 / 65_536.0
}
