//! Extended COLLADA -> [`Document`]: the 1.4.1 and 1.5.0 standard, the CS184 "CGL" dialect, Blender's exporter, and
//! this program's own profile:
//!
//! ```xml
//! <effect id="au-soap-fx">
//!   <profile_COMMON>...</profile_COMMON>
//!   <extra><technique profile="pellicle">
//!     <conductor metal="Au" roughness="0.2">
//!       <film thickness_nm="550" ior="1.33"><noise amplitude="0.025" frequency="4"/></film>
//!     </conductor>
//!   </technique></extra>
//! </effect>
//! ```
//!
//! One pass of the XML reader builds an arena of elements (`xml`), then only what the scene instantiates is interpreted.
//! Everything that cannot be meant is an error with its place; what a renderer can do without is a [`Warning`].

mod animation;
mod asset;
mod bindings;
mod blender;
mod cameras;
mod cgl;
mod coincident;
mod common;
mod dress;
mod encoding;
mod error;
mod geometry;
mod images;
mod lights;
mod loader;
mod materials;
mod mesh;
mod nodes;
mod numbers;
mod package;
mod power;
mod primitives;
mod profile;
mod sources;
mod sweep;
mod targets;
mod transforms;
mod visual_scene;
mod warnings;
mod xml;

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::document::Document;
use crate::math::hex;

pub use dress::dress;
pub use error::{Place, SceneError};
pub use warnings::Warning;

/// How to read a scene where the file leaves a choice.
#[derive(Clone, Debug)]
pub struct LoadOptions {
    /// Folders besides the scene's own that images may come from.
    pub allow_path: Vec<PathBuf>,
    /// Drop broken meshes and cameras with a warning instead of refusing the file.
    pub lenient: bool,
    /// Replace the file's normals by area-weighted ones.
    pub smooth_normals: bool,
    /// Overrides `<up_axis>`.
    pub up_axis: Option<UpAxis>,
    /// Read `<transparent>` the other way round, as many exporters write it.
    pub invert_opacity: bool,
    pub falloff: FalloffRule,
    pub missing_texture: MissingTexture,
    /// Limit in bytes for the file, for everything unpacked from an archive together, for its elements in memory, and for
    /// the scene that is made of them.
    pub max_bytes: u64,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self {
            allow_path: Vec::new(),
            lenient: false,
            smooth_normals: false,
            up_axis: None,
            invert_opacity: false,
            falloff: FalloffRule::Auto,
            missing_texture: MissingTexture::Error,
            max_bytes: 4 << 30,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UpAxis {
    X,
    Y,
    Z,
}

/// How point and spot lights fall off with distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FalloffRule {
    /// 1/d^2, unless the file gives attenuation other than 1/0/0 and is not Blender's.
    #[default]
    Auto,
    /// Always 1/d^2.
    Physical,
    /// Always the attenuation elements, literally.
    Collada,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MissingTexture {
    #[default]
    Error,
    /// Go on with [`crate::document::ImageSource::Missing`] and a warning.
    Magenta,
}

/// Reads a `.dae` or `.zae` file.
///
/// Lengths in the result are file units (see [`Document::to_world`]). Warnings come in the order in which they were met,
/// equal ones merged.
///
/// # Errors
/// Everything that makes the scene other than its author can have meant it, with the place in the file: broken XML,
/// dangling references, wrong counts, values out of range, unknown names inside our own profile, missing images.
pub fn load(path: &Path, options: &LoadOptions) -> Result<(Document, Vec<Warning>), SceneError> {
    let whole_file = |message| SceneError { file: path.to_owned(), place: None, message, hint: None };
    let (package, bytes) = package::open(path, options.max_bytes).map_err(whole_file)?;
    let sha256 = hex(&Sha256::digest(&bytes));
    let source = encoding::decode(bytes).map_err(whole_file)?;
    let xml = xml::parse(source, options.max_bytes).map_err(|broken| broken.0.locate(path, &broken.1))?;
    let mut loader = loader::Loader::new(&xml, options, &package);
    loader.document.path = path.to_owned();
    loader.document.sha256 = sha256;
    visual_scene::read(&mut loader).map_err(|fault| fault.locate(path, &xml))?;
    loader.document.come_near();
    let warnings = loader.warnings.finish(path, &xml);
    Ok((loader.document, warnings))
}
