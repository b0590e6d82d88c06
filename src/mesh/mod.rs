//! Triangle meshes out of polygons, normals, and the model files OBJ (with MTL) and PLY.
//!
//! The readers are our own. `tobj` (4.0) panics on a short colour in an MTL file, wraps on large indices, cuts concave polygons
//! wrongly and cannot tell the line of an error; `ply-rs-bw` needs Rust 1.87 (4.0), or follows whatever count a header
//! promises and keeps a list for every face (3.0).

mod beside;
mod crease;
mod error;
mod mtl;
pub mod normals;
mod obj;
mod ply;
mod ply_data;
pub mod polygons;
mod soup;
pub mod vertices;

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::document::{Image, Material, Mesh};
use crate::math::hex;

pub use beside::{Refusal, find, folder_of};
use error::{Fault, Notes};
pub use error::{MeshError, Note};

/// Which model files there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Obj,
    Ply,
}

impl Kind {
    /// By the end of the file's name, in any case.
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?;
        let is = |known: &str| extension.eq_ignore_ascii_case(known);
        if is("obj") { Some(Self::Obj) } else { is("ply").then_some(Self::Ply) }
    }
}

/// How a model file is read.
#[derive(Clone, Debug)]
pub struct Options {
    /// Replace the file's normals by area-weighted ones.
    pub smooth_normals: bool,
    /// Folders besides the file's own that materials and images may come from.
    pub allow_path: Vec<PathBuf>,
    /// Largest file, and most memory for its mesh.
    pub max_bytes: u64,
}

/// What a model file holds. Coordinates are the file's.
#[derive(Debug)]
pub struct Model {
    /// Groups have the names of the file's materials as symbols.
    pub mesh: Mesh,
    /// Of the file's material libraries; not every symbol need have one.
    pub materials: Vec<Material>,
    pub images: Vec<Image>,
    pub notes: Vec<Note>,
    /// Of the file, hexadecimal.
    pub sha256: String,
}

/// Reads a model with its materials.
///
/// # Errors
/// A file that cannot be read, is damaged or holds no triangle, with the line; references out of the file's folder.
pub fn load(path: &Path, kind: Kind, options: &Options) -> Result<Model, MeshError> {
    let whole = |error: std::io::Error| Fault::new(format!("cannot be read: {error}")).locate(path);
    let bytes = contents(path, options.max_bytes)?;
    let sha256 = hex(&Sha256::digest(&bytes));
    let (mesh, libraries, notes) = parse(&bytes, path, kind, options)?;
    drop(bytes);
    let mut model = Model { mesh, materials: Vec::new(), images: Vec::new(), notes, sha256 };
    let folder = folder_of(path).map_err(whole)?;
    for library in libraries {
        mtl::add(&mut model, path, &folder, &library, options)?;
    }
    Ok(model)
}

/// Reads the shape alone from the bytes of a file that is called `path`.
///
/// # Errors
/// Damaged data, or no triangle.
pub fn read(bytes: &[u8], path: &Path, kind: Kind, options: &Options) -> Result<(Mesh, Vec<Note>), MeshError> {
    parse(bytes, path, kind, options).map(|(mesh, _, notes)| (mesh, notes))
}

type Parsed = (Mesh, Vec<obj::Library>, Vec<Note>);

fn parse(bytes: &[u8], path: &Path, kind: Kind, options: &Options) -> Result<Parsed, MeshError> {
    let mut notes = Notes::new(path);
    let parsed = match kind {
        Kind::Obj => obj::parse(bytes, options.max_bytes, &mut notes),
        Kind::Ply => ply::parse(bytes, options.max_bytes, &mut notes).map(|soup| (soup, Vec::new())),
    };
    let (soup, libraries) = parsed.map_err(|fault| fault.locate(path))?;
    let mesh = soup.finish(options.smooth_normals, &mut notes);
    if mesh.triangles.is_empty() {
        let fault = Fault::new("holds no triangle");
        return Err(fault.hint("clouds of points, and curves, need a surface first (MeshLab, Blender)").locate(path));
    }
    Ok((mesh, libraries, notes.finish()))
}

/// The bytes of a file.
///
/// # Errors
/// A file that cannot be read or is larger than `max_bytes`.
pub fn contents(path: &Path, max_bytes: u64) -> Result<Vec<u8>, MeshError> {
    bytes_of(path, max_bytes).map_err(|fault| fault.locate(path))
}

fn bytes_of(path: &Path, max_bytes: u64) -> Result<Vec<u8>, Fault> {
    let file = File::open(path).map_err(|error| Fault::new(format!("cannot be opened: {error}")))?;
    let mut bytes = Vec::new();
    let read = file.take(max_bytes.saturating_add(1)).read_to_end(&mut bytes);
    read.map_err(|error| Fault::new(format!("cannot be read: {error}")))?;
    if bytes.len() as u64 > max_bytes {
        return Err(Fault::new(format!("is larger than the limit of {max_bytes} bytes")));
    }
    Ok(bytes)
}
