//! Another surface for a loaded scene: `--material`.

use std::path::Path;

use crate::document::{Document, Material, Quantity};
use crate::mesh::folder_of;

use super::LoadOptions;
use super::error::{Fault, SceneError};
use super::loader::Loader;
use super::package::Package;
use super::profile::material;
use super::profile::one_line::{self, Line};

/// Gives every surface that does not shine another material; `NAME=...` only the material of that name. What follows is a
/// surface in one line (docs/format.md). Images are found beside the scene. Animation of what is replaced ends.
///
/// # Errors
/// What is no material, with its place in the text; a name that the scene does not have.
pub fn dress(document: &mut Document, text: &str, options: &LoadOptions) -> Result<(), SceneError> {
    let (name, line) = match text.split_once('=') {
        Some((name, line)) if !name.trim().contains([' ', ';']) => (Some(name.trim()), line),
        _ => (None, text),
    };
    let error = |fault: Fault, line: &Line| {
        let mut error = line.settle(fault).locate(Path::new("--material"), &line.xml);
        // What stands around the elements is of no interest here.
        if let Some(place) = &mut error.place {
            place.element_path.clear();
        }
        error
    };
    let parsed = one_line::parse(line).map_err(|broken| error(broken.0, &broken.1))?;
    let replaced: Vec<usize> = match name {
        Some(name) => (0..document.materials.len()).filter(|&i| document.material_name(i) == name).collect(),
        None => (0..document.materials.len()).filter(|&i| document.materials[i].emission.is_none()).collect(),
    };
    if let (true, Some(name)) = (replaced.is_empty(), name) {
        let names: Vec<String> = (0..document.materials.len()).map(|i| document.material_name(i)).collect();
        let fault = Fault { span: 0..0, element: None, message: String::new(), hint: None };
        let hint = fault.suggest(name, names.iter().map(String::as_str)).hint;
        let message = format!("the scene has no material `{name}`");
        return Err(SceneError { file: "--material".into(), place: None, message, hint });
    }
    let folder = folder_of(&document.path).unwrap_or_default();
    let package = Package::Folder(folder);
    let mut loader = Loader::new(&parsed.xml, options, &package);
    loader.document = std::mem::take(document);
    let read = material::read(&mut loader, parsed.xml.root(), "--material");
    *document = loader.document;
    let mut material = read.map_err(|fault| error(fault, &parsed))?;
    material.number_texcoords();
    for &index in &replaced {
        let own = &mut document.materials[index];
        *own = Material { id: std::mem::take(&mut own.id), ..material.clone() };
    }
    document.channels.retain(|channel| match channel.drives {
        Quantity::Material { material, .. } | Quantity::Film { material, .. } => !replaced.contains(&material),
        _ => true,
    });
    Ok(())
}
