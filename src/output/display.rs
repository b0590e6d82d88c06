//! Picture files as 16-bit sRGB codes, for videos: EXR through our own view transform, PNG as it is.

use std::path::Path;

use super::error::OutputError;
use super::exr_read::read_exr;
use super::picture::Format;
use super::png::srgb;

/// sRGB codes, 0 to 65535; rows from the top. 8-bit codes are times 257.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Codes {
    pub width: u32,
    pub height: u32,
    /// `width * height` values.
    pub pixels: Vec<[u16; 3]>,
}

impl Codes {
    pub fn row(&self, y: u32) -> &[[u16; 3]] {
        let width = self.width as usize;
        &self.pixels[y as usize * width..][..width]
    }
}

/// Width and height of a PNG or EXR file, from its header.
///
/// # Errors
/// A file that is missing, damaged or of another kind.
pub fn picture_size(path: &Path) -> Result<[u32; 2], OutputError> {
    let damaged = |error: &dyn ToString| OutputError::damaged(path, error.to_string());
    match Format::of(path)? {
        Format::Png => image::image_dimensions(path).map(|(width, height)| [width, height]).map_err(|e| damaged(&e)),
        Format::Exr => {
            let meta = exr::meta::MetaData::read_from_file(path, false).map_err(|e| damaged(&e))?;
            let size = meta.headers.first().map(|header| header.layer_size).ok_or_else(|| damaged(&"it is empty"))?;
            match (u32::try_from(size.0), u32::try_from(size.1)) {
                (Ok(width), Ok(height)) => Ok([width, height]),
                _ => Err(damaged(&"it is too large")),
            }
        }
    }
}

/// Reads a PNG (any depth; alpha is ignored) or an EXR (R, G, B over black, times 2^`exposure_ev`, clipped to 0..1, through
/// the sRGB curve: what `write_png` does).
///
/// # Errors
/// A file that is missing, damaged or of another kind.
pub fn read_codes(path: &Path, exposure_ev: f32) -> Result<Codes, OutputError> {
    match Format::of(path)? {
        Format::Png => {
            let decode = || image::ImageReader::open(path)?.with_guessed_format()?.decode();
            let image = decode().map_err(|error| OutputError::damaged(path, error))?.into_rgb16();
            let pixels = image.pixels().map(|pixel| pixel.0).collect();
            Ok(Codes { width: image.width(), height: image.height(), pixels })
        }
        Format::Exr => {
            let picture = read_exr(path)?;
            let gain = exposure_ev.exp2();
            let code = |value: f32| (srgb(value * gain) * 65_535.0 + 0.5) as u16;
            let pixels = picture.rgba.iter().map(|&[r, g, b, _]| [r, g, b].map(code)).collect();
            Ok(Codes { width: picture.width, height: picture.height, pixels })
        }
    }
}
