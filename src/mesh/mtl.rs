//! Wavefront MTL: colours, coverage, glass and glow of an OBJ file's materials.
//!
//! Highlights (`Ks`, `Ns`, ...) are phenomenological and passed over: what shines is better said with a measured metal and
//! its films.

use std::path::Path;

use glam::Vec3;

use crate::color::{Emission, Index};
use crate::document::{
    Base, Channel4, Encoding, Image, ImageSource, Map, Material, Microfacets, Scalar, SurfaceEmission, Texture, Wrap,
};

use super::error::{Fault, MeshError, Notes};
use super::obj::{Library, number};
use super::{Model, Options, contents, find};

/// `illum` numbers that let light through and bend it: glass, refraction, glass without ray tracing.
const CLEAR: [u32; 4] = [4, 6, 7, 9];

/// Everything that a `newmtl` block says.
struct Block {
    name: String,
    color: Vec3,
    /// Image of the colour.
    map: Option<usize>,
    glow: Vec3,
    opacity: f32,
    ior: f32,
    illum: u32,
}

impl Block {
    fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            color: Vec3::splat(0.8),
            map: None,
            glow: Vec3::ZERO,
            opacity: 1.0,
            ior: 1.5,
            illum: 2,
        }
    }

    fn material(self) -> Material {
        let map = self.map.map(|image| Map {
            image,
            texcoord: String::new(),
            slot: 0,
            encoding: Encoding::Srgb,
            channel: Channel4::G,
            wrap: [Wrap::Repeat; 2],
        });
        let clear = CLEAR.contains(&self.illum);
        let base = if clear {
            Base::Dielectric {
                index: Index::Constant { n: self.ior, k: 0.0 },
                microfacets: Microfacets::default(),
                absorption_per_m: Vec3::ZERO,
                fresnel: true,
                priority: None,
            }
        } else {
            // With an image, exporters write the colour that they show without it.
            let value = if map.is_some() { Vec3::ONE } else { self.color };
            Base::Diffuse { reflectance: Texture { value, map }, ior: 1.5 }
        };
        let shines = self.glow.max_element() > 0.0;
        Material {
            id: self.name,
            base,
            emission: shines.then(|| SurfaceEmission {
                radiance: Texture::constant(self.glow),
                spectrum: Emission::default(),
                two_sided: true,
            }),
            // Clear bodies are told by their index; exporters lower their coverage as well.
            opacity: Scalar::constant(if clear { 1.0 } else { self.opacity }),
            ..Material::default()
        }
    }
}

/// Adds the materials of a library that the OBJ file at `path` names. A library or an image that is missing is a note.
///
/// # Errors
/// A library or an image outside the folder, or what is no number in it.
pub fn add(
    model: &mut Model,
    path: &Path,
    folder: &Path,
    library: &Library,
    options: &Options,
) -> Result<(), MeshError> {
    let mut notes = Notes::new(path);
    let found = find(folder, &options.allow_path, Path::new(&library.name)).map_err(|(reason, hint)| {
        let message = format!("the material library `{}` {reason}", library.name);
        Fault { line: Some(library.line), message, hint }.locate(path)
    })?;
    let Some(file) = found else {
        let seen = format!("the material library `{}` is missing", library.name);
        notes.add(library.line, 1, &seen, "its materials are the default one");
        model.notes.extend(notes.finish());
        return Ok(());
    };
    let bytes = contents(&file, options.max_bytes)?;
    let mut notes = Notes::new(&file);
    parse(model, &bytes, folder, options, &mut notes).map_err(|fault| fault.locate(&file))?;
    model.notes.extend(notes.finish());
    Ok(())
}

fn parse(model: &mut Model, bytes: &[u8], folder: &Path, options: &Options, notes: &mut Notes) -> Result<(), Fault> {
    let mut block: Option<Block> = None;
    for (line, text) in (1..).zip(bytes.split(|&byte| byte == b'\n')) {
        let text = text.trim_ascii();
        let end = text.iter().position(|byte| byte.is_ascii_whitespace()).unwrap_or(text.len());
        let (keyword, rest) = text.split_at(end);
        let rest = rest.trim_ascii();
        let value = |low: f32, high: f32| {
            let word = rest.split(|byte| byte.is_ascii_whitespace()).next().unwrap_or_default();
            Ok::<f32, Fault>(number(line, word)?.clamp(low, high))
        };
        if keyword == b"newmtl" {
            model.materials.extend(block.take().map(Block::material));
            block = Some(Block::new(&String::from_utf8_lossy(rest)));
        }
        let Some(block) = &mut block else { continue };
        match keyword {
            b"Kd" => block.color = color(line, rest)?.min(Vec3::ONE),
            b"Ke" => block.glow = color(line, rest)?,
            b"d" => block.opacity = value(0.0, 1.0)?,
            b"Tr" => block.opacity = 1.0 - value(0.0, 1.0)?,
            b"Ni" => block.ior = value(1.0, 5.0)?,
            b"illum" => block.illum = value(0.0, 100.0)? as u32,
            b"map_Kd" => {
                let user = format!("material `{}`", block.name);
                block.map = image(model, line, rest, (folder, user), options, notes)?;
            }
            _ => {}
        }
    }
    model.materials.extend(block.map(Block::material));
    Ok(())
}

/// Three numbers, or one for all three; none is below 0.
fn color(line: usize, rest: &[u8]) -> Result<Vec3, Fault> {
    let mut values = rest.split(|byte| byte.is_ascii_whitespace()).filter(|word| !word.is_empty());
    let mut next = || values.next().map(|word| number(line, word)).transpose();
    match (next()?, next()?, next()?) {
        (Some(r), Some(g), Some(b)) => Ok(Vec3::new(r, g, b).max(Vec3::ZERO)),
        (Some(grey), None, None) => Ok(Vec3::splat(grey).max(Vec3::ZERO)),
        _ => Err(Fault::at(line, "a colour takes 3 numbers, or 1 for all")),
    }
}

/// The image of a `map_Kd`, whose options (`-s 1 1 1`, ...) are passed over: its name comes last.
fn image(
    model: &mut Model,
    line: usize,
    rest: &[u8],
    (folder, user): (&Path, String),
    options: &Options,
    notes: &mut Notes,
) -> Result<Option<usize>, Fault> {
    let text = String::from_utf8_lossy(rest).replace('\\', "/");
    let name = if text.starts_with('-') { text.split_whitespace().last().unwrap_or_default() } else { text.as_str() };
    if let Some(known) = model.images.iter().position(|image| image.uri == name) {
        return Ok(Some(known));
    }
    let found = find(folder, &options.allow_path, Path::new(name));
    let Some(file) = found.map_err(|(reason, hint)| Fault {
        line: Some(line),
        message: format!("the image `{name}` {reason}"),
        hint,
    })?
    else {
        notes.add(line, 1, &format!("the image `{name}` is missing"), "the colour is used instead");
        return Ok(None);
    };
    model.images.push(Image { id: name.to_owned(), uri: name.to_owned(), user, source: ImageSource::File(file) });
    Ok(Some(model.images.len() - 1))
}
