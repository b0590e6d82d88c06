//! `<bind_material>`: which material each symbol of a geometry means.

use crate::document::{Binding, Shape};

use super::error::Fault;
use super::loader::Loader;
use super::materials;
use super::sources::whole_number;
use super::xml::Element;

/// The bindings of one `<instance_geometry>` or `<instance_controller>`: every group of the mesh finds its symbol.
pub fn read<'a>(loader: &mut Loader<'a>, instance: Element<'a>, geometry: usize) -> Result<Vec<Binding>, Fault> {
    let mut bindings = Vec::new();
    if let Some(technique) = instance.descend(&["bind_material", "technique_common"]) {
        for element in technique.children_named("instance_material") {
            let target = loader.follow(element, "target", &["material"])?;
            let material = materials::load(loader, target)?;
            let uv_sets = uv_sets(loader, element, geometry)?;
            bindings.push(Binding {
                symbol: element.attribute("symbol").unwrap_or_default().to_owned(),
                material,
                uv_sets,
            });
        }
    }
    let symbols: Vec<String> = match &loader.document.geometries[geometry].shape {
        // A CGL sphere has no primitive that could name a symbol.
        Shape::Sphere { .. } => {
            bindings.truncate(1);
            bindings.iter_mut().for_each(|binding| binding.symbol.clear());
            vec![String::new()]
        }
        Shape::Mesh(mesh) => mesh.groups.iter().map(|group| group.symbol.clone()).collect(),
    };
    let given = bindings.len();
    for symbol in symbols {
        if bindings.iter().any(|binding| binding.symbol == symbol) {
            continue;
        }
        let material = match (symbol.is_empty(), bindings.first()) {
            // A primitive without symbol, and one material: there is nothing else it could mean.
            (true, Some(only)) if given == 1 => only.material,
            _ => loader.default_material(),
        };
        if !symbol.is_empty() {
            let seen = format!("material symbol `{symbol}` is not bound");
            loader.warnings.add(instance, seen, "grey diffuse is used");
        }
        let uv_sets = if given == 1 && symbol.is_empty() { bindings[0].uv_sets.clone() } else { Vec::new() };
        bindings.push(Binding { symbol, material, uv_sets });
    }
    Ok(bindings)
}

/// `<bind_vertex_input>`. Some exporters number the set they mean differently here and in the mesh.
fn uv_sets<'a>(loader: &mut Loader<'a>, instance: Element<'a>, geometry: usize) -> Result<Vec<(String, u32)>, Fault> {
    let mut bound = Vec::new();
    for element in instance.children_named("bind_vertex_input") {
        if element.attribute("input_semantic") != Some("TEXCOORD") {
            continue;
        }
        let name = element.attribute("semantic").unwrap_or_default().to_owned();
        // `whole_number` reads 32 bits.
        let mut set = whole_number(element, "input_set")?.unwrap_or(0) as u32;
        if let Shape::Mesh(mesh) = &loader.document.geometries[geometry].shape {
            if let ([only], false) = (mesh.uv_sets.as_slice(), mesh.uv_sets.iter().any(|own| own.set == set)) {
                let seen = format!("`{name}` is bound to TEXCOORD set {set}, the mesh has only set {}", only.set);
                set = only.set;
                loader.warnings.add(element, seen, "that one is used");
            }
        }
        bound.push((name, set));
    }
    if let Some(bind) = instance.child("bind") {
        loader.warnings.add(bind, "<bind> of a material parameter", "it is ignored: the effect's own value is used");
    }
    Ok(bound)
}
