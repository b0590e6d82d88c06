//! Files out: pictures as EXR and PNG, and text. Whatever is written appears whole under its name, or not at all
//! (`atomic.rs`).
//!
//! This room takes plain numbers ([`Picture`]) and knows nothing of how they were made.

mod apng;
mod atomic;
mod cryptomatte;
mod display;
mod error;
mod exr_read;
mod exr_write;
mod notes;
mod part;
mod picture;
mod png;
mod tev;
mod video;

pub use apng::write_apng;
pub use atomic::{check_writable, write_bytes, write_text};
pub use cryptomatte::cryptomatte;
pub use display::{Codes, Display, picture_size, read_codes};
pub use error::OutputError;
pub use exr_read::read_exr;
pub use exr_write::write_exr;
pub use notes::note;
pub use part::{PartBlock, PartReader, write_part};
pub use picture::{Crop, Format, HeaderValue, Layer, LayerKind, PIXEL_ASPECT, Picture, Written};
pub use png::{PngDepth, write_png};
pub use tev::Viewer;
pub use video::{Container, VideoPlan, check_ffmpeg, write_video};

use std::path::Path;

/// The header value that stands for everything that decides what a frame of a batch looks like.
pub const SETTINGS: &str = "pellicle/settings";

/// True if the picture file at `path` is there and whole, judged by its content: every block of an EXR can be read, every
/// row of a PNG decoded. Cheaper than reading an EXR, as nothing is decompressed.
pub fn is_complete(path: &Path) -> bool {
    match Format::of(path) {
        Ok(Format::Exr) => exr_read::is_complete(path),
        Ok(Format::Png) => png::is_complete(path),
        Err(_) => false,
    }
}

/// Proves before any work that a picture can be written to `path`: its extension is known, its folder there and writable.
///
/// # Errors
/// What stands in the way.
pub fn check_picture(path: &Path) -> Result<Format, OutputError> {
    let format = Format::of(path)?;
    check_writable(path)?;
    Ok(format)
}
