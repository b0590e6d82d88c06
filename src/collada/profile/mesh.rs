//! `<mesh file="dragon.ply"/>`: the shape of a `<geometry>` from an OBJ or PLY file.

use std::path::Path;

use crate::collada::error::Fault;
use crate::collada::images::{beside_scene, locate};
use crate::collada::loader::Loader;
use crate::collada::xml::Element;
use crate::document::{Group, ImageSource, Mesh};
use crate::mesh::{self, Kind};

use super::strict::{Strict, at_most_one, only_children};

/// What the element says.
pub struct Reference<'a> {
    element: Element<'a>,
    file: &'a str,
    kind: Kind,
    /// The material symbol of all its faces; `None`: those that the file names.
    symbol: Option<&'a str>,
}

/// Reads the technique of a geometry, not the file.
pub fn reference(technique: Element) -> Result<Reference, Fault> {
    only_children(technique, &["mesh"])?;
    let Some(element) = at_most_one(technique, &["mesh"])? else {
        return Err(technique.fault("this technique holds no <mesh>").hint("write <mesh file=\"model.ply\"/>"));
    };
    let mut strict = Strict::new(element);
    let file = strict.text("file");
    let file = strict.required("file", file)?;
    let symbol = strict.text("material");
    strict.finish(&[])?;
    let kind = Kind::of(Path::new(file)).ok_or_else(|| {
        let fault = element.fault_at_value("file", format!("`{file}` is neither .obj nor .ply"));
        fault.hint("these two are read; other programs convert to them")
    })?;
    Ok(Reference { element, file, kind, symbol })
}

/// Reads the file, in its own axes and units.
pub fn read<'a>(loader: &mut Loader<'a>, technique: Element<'a>) -> Result<Mesh, Fault> {
    let Reference { element, file, kind, symbol } = reference(technique)?;
    let refused = |message: String, hint: Option<String>| Fault { hint, ..element.fault_at_value("file", message) };
    let source = match locate(loader, file) {
        Ok(Some(source)) => source,
        Ok(None) => return Err(refused(format!("mesh `{file}` is missing"), beside_scene(loader.package, file))),
        Err((reason, hint)) => return Err(refused(format!("mesh `{file}` {reason}"), hint)),
    };
    let options = mesh::Options {
        smooth_normals: loader.options.smooth_normals,
        allow_path: Vec::new(),
        max_bytes: loader.options.max_bytes,
    };
    let bytes = match source {
        ImageSource::Bytes(bytes) => Ok(bytes),
        ImageSource::File(path) => mesh::contents(&path, options.max_bytes),
        ImageSource::Missing => return Err(refused(format!("mesh `{file}` is missing"), None)),
    };
    let read = bytes.and_then(|bytes| {
        loader.document.depend_on(&bytes);
        mesh::read(&bytes, Path::new(file), kind, &options)
    });
    let (mut mesh, notes) = read.map_err(|error| {
        let line = error.line.map(|line| format!("line {line}: ")).unwrap_or_default();
        refused(format!("mesh `{file}`: {line}{}", error.message), error.hint)
    })?;
    for note in notes {
        loader.warnings.add_many(element, note.count, format!("mesh `{file}`: {}", note.seen), note.advice);
    }
    if let Some(symbol) = symbol {
        mesh.groups = vec![Group { symbol: symbol.to_owned(), triangles: 0..mesh.triangles.len() }];
    }
    Ok(mesh)
}
