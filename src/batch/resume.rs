//! Which frames of a batch are there already.

use std::fs;

use sha2::{Digest, Sha256};

use super::frames::{FrameList, Pattern};
use crate::document::{Document, ImageSource};
use crate::math::hex;
use crate::output;

/// A short hash of everything that decides what frames look like: the scene with its images, this program's version, and
/// the `choices` of the user, in any form that differs where they do.
pub fn settings(document: &Document, choices: &str) -> String {
    let mut hash = Sha256::new();
    hash.update(env!("CARGO_PKG_VERSION"));
    hash.update(&document.sha256);
    for image in &document.images {
        match &image.source {
            ImageSource::File(path) => hash.update(fs::read(path).unwrap_or_default()),
            ImageSource::Bytes(bytes) => hash.update(bytes),
            ImageSource::Missing => {}
        }
    }
    hash.update(choices);
    hex(&hash.finalize()[..8])
}

/// The frames whose files are not there, not whole, or made with other settings.
pub fn missing(frames: &FrameList, pattern: &Pattern, settings: &str) -> FrameList {
    let is_there = |frame: &u32| {
        let path = pattern.path(*frame);
        output::note(&path, output::SETTINGS).as_deref() == Some(settings) && output::is_complete(&path)
    };
    FrameList(frames.0.iter().filter(|frame| !is_there(frame)).copied().collect())
}
