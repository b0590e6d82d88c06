//! How pictures are shown; and picture files as 16-bit sRGB codes, for videos: EXR through our own view transform, PNG as
//! it is.

use std::path::Path;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::error::OutputError;
use super::exr_read::read_exr;
use super::picture::Format;
use crate::color::view::View;

/// How linear values are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Display {
    /// Brightness in stops.
    pub exposure_ev: f32,
    pub view: View,
}

impl Display {
    /// As it is, channel by channel: for drawings and data.
    pub const PLAIN: Self = Self { exposure_ev: 0.0, view: View::None };

    /// The display's signal, 0..1, and whether the colour had to be changed for it ([`View::show`]).
    pub fn show(self, rgb: [f32; 3]) -> ([f32; 3], bool) {
        let (signal, outside) = self.view.show(Vec3::from(rgb) * self.exposure_ev.exp2());
        (signal.to_array(), outside)
    }
}

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

/// Reads a PNG (any depth; alpha is ignored) or an EXR (R, G, B over black, shown as `write_png` shows them).
///
/// # Errors
/// A file that is missing, damaged or of another kind.
pub fn read_codes(path: &Path, display: Display) -> Result<Codes, OutputError> {
    match Format::of(path)? {
        Format::Png => {
            let decode = || image::ImageReader::open(path)?.with_guessed_format()?.decode();
            let image = decode().map_err(|error| OutputError::damaged(path, error))?.into_rgb16();
            let pixels = image.pixels().map(|pixel| pixel.0).collect();
            Ok(Codes { width: image.width(), height: image.height(), pixels })
        }
        Format::Exr => {
            let picture = read_exr(path)?;
            let codes = |rgb| display.show(rgb).0.map(|signal| (signal * 65_535.0 + 0.5) as u16);
            let pixels = picture.rgba.iter().map(|&[r, g, b, _]| codes([r, g, b])).collect();
            Ok(Codes { width: picture.width, height: picture.height, pixels })
        }
    }
}
