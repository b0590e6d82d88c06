//! `<geometry>`: a mesh, here or in a model file, or the CGL sphere.

use crate::document::{Geometry, Shape};

use super::error::{Fault, line_at};
use super::loader::{Loader, technique};
use super::mesh;
use super::numbers;
use super::profile;
use super::xml::Element;

/// The geometry's index in the document; `None` when it has nothing that could be rendered.
pub fn load<'a>(loader: &mut Loader<'a>, geometry: Element<'a>) -> Result<Option<usize>, Fault> {
    if let Some(&known) = loader.geometries.get(&geometry.index()) {
        return Ok(known);
    }
    let id = geometry.attribute("id").unwrap_or_default().to_owned();
    let shape = match read(loader, geometry) {
        Err(fault) if loader.options.lenient => {
            let line = line_at(&loader.xml.source, fault.span.start).0;
            loader.warnings.add(
                geometry,
                format!("geometry `{id}` is broken at line {line}: {}", fault.message),
                "it is dropped",
            );
            None
        }
        read => read?,
    };
    let index = shape.map(|shape| {
        loader.document.geometries.push(Geometry { id, shape });
        loader.document.geometries.len() - 1
    });
    loader.geometries.insert(geometry.index(), index);
    Ok(index)
}

fn read<'a>(loader: &mut Loader<'a>, geometry: Element<'a>) -> Result<Option<Shape>, Fault> {
    let id = geometry.attribute("id").unwrap_or_default();
    if let Some(technique) = profile::of(loader, geometry) {
        return profile::mesh::read(loader, technique).map(|mesh| Some(Shape::Mesh(mesh)));
    }
    if let Some(mesh) = geometry.child("mesh") {
        let mesh = mesh::read(loader, mesh)?;
        loader.take(geometry, mesh.bytes())?;
        if mesh.triangles.is_empty() {
            loader.warnings.add(geometry, format!("geometry `{id}` has no triangles"), "it is ignored");
            return Ok(None);
        }
        return Ok(Some(Shape::Mesh(mesh)));
    }
    if let Some(sphere) = technique(geometry, "CGL").and_then(|cgl| cgl.child("sphere")) {
        let Some(radius) = sphere.child("radius") else {
            return Err(sphere.fault("this <sphere> has no <radius>"));
        };
        let value = numbers::single(radius)?;
        if value <= 0.0 {
            return Err(radius.fault_at_text(format!("a radius of {value} is not positive")));
        }
        return Ok(Some(Shape::Sphere { radius: value }));
    }
    let kind = geometry.children().find(|child| !matches!(child.name(), "asset" | "extra")).map(|child| child.name());
    let seen = match kind {
        Some(kind) => format!("geometry `{id}` is a <{kind}>"),
        None => format!("geometry `{id}` is empty"),
    };
    loader.warnings.add(geometry, seen, "only <mesh> is rendered: it is ignored");
    Ok(None)
}
