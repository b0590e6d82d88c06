//! A model file as a scene with nothing but the model in it.

use std::path::Path;

use glam::{DVec3, Vec3};

use crate::collada::{LoadOptions, UpAxis, Warning};
use crate::color::Index;
use crate::document::{Base, Binding, Document, Geometry, Item, Material, Mesh, Microfacets, Node, Scalar, Shape};
use crate::math::extent;
use crate::mesh::{self, Kind, MeshError, Note};

/// Roughness of the metal that stands for a material that nobody names.
const PLAIN_ROUGHNESS: f32 = 0.2;

/// Reads a model. Its materials are those of the file; what has none is satin titanium, and the last warning says so where
/// `named` is false: nobody will name one later.
///
/// # Errors
/// See [`mesh::load`]; a model of no extent.
pub fn load(
    path: &Path,
    kind: Kind,
    options: &LoadOptions,
    named: bool,
) -> Result<(Document, Vec<Warning>), MeshError> {
    let read = mesh::Options {
        smooth_normals: options.smooth_normals,
        allow_path: options.allow_path.clone(),
        max_bytes: options.max_bytes,
    };
    let mut model = mesh::load(path, kind, &read)?;
    stand(&mut model.mesh, options.up_axis.unwrap_or(UpAxis::Y)).map_err(|message| MeshError {
        file: path.to_owned(),
        line: None,
        message,
        hint: None,
    })?;
    let mut materials = model.materials;
    let mut bindings: Vec<Binding> = Vec::new();
    let mut plain = false;
    for group in &model.mesh.groups {
        let symbol = &group.symbol;
        if bindings.iter().any(|binding| binding.symbol == *symbol) {
            continue;
        }
        let material = materials.iter().position(|material| material.id == *symbol).unwrap_or_else(|| {
            plain = true;
            let id = if symbol.is_empty() { "model" } else { symbol };
            materials.push(titanium(id));
            materials.len() - 1
        });
        bindings.push(Binding { symbol: symbol.clone(), material, uv_sets: Vec::new() });
    }
    let warning = |note: Note| {
        let Note { file, line, seen, advice, count } = note;
        Warning { file, line, seen, advice, count }
    };
    let mut warnings: Vec<Warning> = model.notes.into_iter().map(warning).collect();
    if plain && !named {
        let advice = "it is satin titanium; --material \"conductor Au; film 550nm n=1.33\" makes it something else";
        let seen = "the model has no material".to_owned();
        warnings.push(Warning { file: path.to_owned(), line: 1, seen, advice: advice.to_owned(), count: 1 });
    }
    let id = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let items = vec![Item::Geometry { geometry: 0, bindings }];
    let document = Document {
        path: path.to_owned(),
        sha256: model.sha256,
        geometries: vec![Geometry { id: id.clone(), shape: Shape::Mesh(model.mesh) }],
        materials,
        images: model.images,
        nodes: vec![Node { name: id.clone(), id, items, ..Node::default() }],
        roots: vec![0],
        ..Document::default()
    };
    Ok((document, warnings))
}

/// Turns the mesh Y-up, scales it to a longest side of 1 and stands it on the middle of the ground.
fn stand(mesh: &mut Mesh, up: UpAxis) -> Result<(), String> {
    let turn = |v: Vec3| match up {
        UpAxis::Y => v,
        UpAxis::Z => Vec3::new(v.x, v.z, -v.y),
        UpAxis::X => Vec3::new(-v.y, v.x, v.z),
    };
    let (low, high) = extent(mesh.positions.iter().map(|p| turn(*p)));
    // The difference of two f32 may be too large for one.
    let (low, high) = (low.as_dvec3(), high.as_dvec3());
    let size = (high - low).max_element();
    if size <= 0.0 {
        return Err("the model has no extent".to_owned());
    }
    let foot = DVec3::new(0.5 * (low.x + high.x), low.y, 0.5 * (low.z + high.z));
    for position in &mut mesh.positions {
        *position = ((turn(*position).as_dvec3() - foot) / size).as_vec3();
    }
    mesh.normals.iter_mut().for_each(|normal| *normal = turn(*normal));
    Ok(())
}

fn titanium(id: &str) -> Material {
    let microfacets = Microfacets { roughness: Scalar::constant(PLAIN_ROUGHNESS), ..Microfacets::default() };
    let base = Base::Conductor { index: Index::Named("Ti".to_owned()), microfacets };
    Material { id: id.to_owned(), base, ..Material::default() }
}
