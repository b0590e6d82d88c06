//! Animated PNG: exact sRGB codes of 8 bits that browsers play, without ffmpeg.

use std::io::BufWriter;
use std::path::Path;

use png::{BitDepth, ColorType, Encoder, EncodingError, SrgbRenderingIntent};

use super::atomic::Temporary;
use super::display::Codes;
use super::error::OutputError;
use super::png::threshold;

/// Writes an endless loop of `count` frames of one size. Codes that 8 bits hold stay as they are, others are dithered.
///
/// # Errors
/// The first frame that cannot be read, or what the system says; the old file is untouched then.
pub fn write_apng(
    path: &Path,
    [width, height]: [u32; 2],
    fps: f64,
    count: u32,
    frames: impl Iterator<Item = Result<Codes, OutputError>>,
) -> Result<(), OutputError> {
    let failed = |error: EncodingError| OutputError::picture(path, error);
    let temporary = Temporary::create(path)?;
    let mut encoder = Encoder::new(BufWriter::new(temporary.file()), width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    encoder.set_animated(count, 0).map_err(failed)?;
    let [seconds, parts] = delay(fps);
    encoder.set_frame_delay(seconds, parts).map_err(failed)?;
    let mut writer = encoder.write_header().map_err(failed)?;
    for frame in frames {
        writer.write_image_data(&eight_bits(&frame?)).map_err(failed)?;
    }
    writer.finish().map_err(failed)?;
    temporary.commit()
}

/// Time of a frame as a fraction that 16 bits hold.
fn delay(fps: f64) -> [u16; 2] {
    let whole = fps.fract() == 0.0 && fps <= f64::from(u16::MAX);
    if whole { [1, fps as u16] } else { [1000, (fps * 1000.0).round().clamp(1.0, 65_535.0) as u16] }
}

fn eight_bits(codes: &Codes) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(codes.pixels.len() * 3);
    for (y, row) in (0..codes.height).map(|y| (y, codes.row(y))) {
        for (x, pixel) in (0u32..).zip(row) {
            let eight = |(channel, &code): (u32, &u16)| (f32::from(code) / 257.0 + threshold(x, y, channel)) as u8;
            bytes.extend((0u32..).zip(pixel).map(eight));
        }
    }
    bytes
}
