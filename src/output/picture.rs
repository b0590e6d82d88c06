//! The values that picture files are made of.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::error::OutputError;

/// A picture with its extra layers and what is known about it. Rows from the top, pixels from the left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    pub width: u32,
    pub height: u32,
    /// Where the first pixel lies in the whole frame, and the size of that frame, when this is a crop.
    pub crop: Option<Crop>,
    /// Linear sRGB (Rec. 709 primaries, D65), premultiplied by alpha; `width * height` values.
    pub rgba: Vec<[f32; 4]>,
    pub layers: Vec<Layer>,
    /// What to note in the file besides, name and value; names are unique.
    pub header: Vec<(String, HeaderValue)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    pub x: u32,
    pub y: u32,
    pub full_width: u32,
    pub full_height: u32,
}

/// One extra channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// The whole channel name: `albedo.R`, `Z`.
    pub name: String,
    pub kind: LayerKind,
    /// `width * height` values. `Uint` holds whole numbers that f32 can hold (up to 2^24).
    pub data: Vec<f32>,
}

/// How a channel is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayerKind {
    Half,
    Float,
    Uint,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum HeaderValue {
    Text(String),
    Int(i32),
    Float(f32),
}

/// What was lost in writing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Written {
    /// Values beyond the largest half, 65504, that were set to it.
    pub clamped: u64,
    /// Pixels whose colour a PNG cannot hold and that have another one there ([`View::show`](crate::color::view::View::show)).
    pub out_of_gamut: u64,
}

/// The files that pictures can be written to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Exr,
    Png,
}

impl Format {
    /// By the extension, in any case.
    ///
    /// # Errors
    /// Another extension, or none.
    pub fn of(path: &Path) -> Result<Self, OutputError> {
        match path.extension() {
            Some(extension) if extension.eq_ignore_ascii_case("exr") => Ok(Self::Exr),
            Some(extension) if extension.eq_ignore_ascii_case("png") => Ok(Self::Png),
            _ => Err(OutputError::Extension { path: path.to_path_buf() }),
        }
    }
}

/// The header value that tells the width of a pixel over its height, where that is not 1.
pub const PIXEL_ASPECT: &str = "pixelAspectRatio";

impl Picture {
    /// Width of a pixel over its height.
    pub(super) fn pixel_aspect(&self) -> f32 {
        let of = |(name, value): &(String, HeaderValue)| match value {
            HeaderValue::Float(aspect) if name == PIXEL_ASPECT => Some(*aspect),
            _ => None,
        };
        self.header.iter().find_map(of).unwrap_or(1.0)
    }

    /// What is wrong with the sizes, if anything.
    pub(super) fn check(&self) -> Result<(), String> {
        let pixels = u64::from(self.width) * u64::from(self.height);
        if pixels == 0 {
            return Err(format!("a picture of {}x{} has no pixels", self.width, self.height));
        }
        if self.rgba.len() as u64 != pixels {
            return Err(format!("{} pixels for {}x{}", self.rgba.len(), self.width, self.height));
        }
        match self.layers.iter().find(|layer| layer.data.len() as u64 != pixels) {
            Some(layer) => Err(format!("layer {} has {} values for {pixels} pixels", layer.name, layer.data.len())),
            None => Ok(()),
        }
    }
}
