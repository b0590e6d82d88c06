//! CS184 scenes describe one lamp twice: as an area light, and as an emissive mesh in the same place. Only the mesh, which
//! the camera sees, is kept.

use glam::{Mat4, Vec3};

use crate::document::{Document, Item, Shape};

use super::loader::Loader;

/// Distance from the light's plane that still lies in it, as a share of the light's size.
const TOLERANCE: f32 = 1e-3;

/// Drops CGL area lights that lie in the plane of an emissive mesh and overlap it.
pub fn drop_duplicates(loader: &mut Loader) {
    if loader.cgl_areas.is_empty() {
        return;
    }
    let document = &loader.document;
    let placements = document.placements();
    let emitters: Vec<(usize, Mat4)> =
        placements.iter().copied().filter(|&(node, _)| emissive(document, node).next().is_some()).collect();
    let mut dropped = Vec::new();
    for (node, to_world) in &placements {
        for item in &document.nodes[*node].items {
            let &Item::Light(light) = item else { continue };
            let is_area = loader.cgl_areas.contains(&light) && !dropped.contains(&(*node, light));
            if is_area && emitters.iter().any(|(emitter, matrix)| covers(document, *emitter, matrix, to_world)) {
                dropped.push((*node, light));
            }
        }
    }
    for &(node, light) in &dropped {
        let is_dropped = |item: &Item| matches!(item, Item::Light(own) if *own == light);
        loader.document.nodes[node].items.retain(|item| !is_dropped(item));
        let seen = format!("CGL area light `{}` lies in an emissive mesh", loader.document.lights[light].id);
        loader.warnings.add(loader.light_elements[light], seen, "the mesh is the light: the area light is dropped");
    }
    forget_unused_lights(&mut loader.document);
}

/// Vertex positions of the emissive parts of a node's meshes.
fn emissive(document: &Document, node: usize) -> impl Iterator<Item = Vec3> {
    document.nodes[node].items.iter().flat_map(|item| {
        let Item::Geometry { geometry, bindings } = item else { return Vec::new() };
        let Shape::Mesh(mesh) = &document.geometries[*geometry].shape else { return Vec::new() };
        let shines = |symbol: &str| {
            let binding = bindings.iter().find(|binding| binding.symbol == symbol);
            binding.is_some_and(|binding| document.materials[binding.material].emission.is_some())
        };
        let groups = mesh.groups.iter().filter(|group| shines(&group.symbol));
        let triangles = groups.flat_map(|group| &mesh.triangles[group.triangles.clone()]);
        triangles.flatten().map(|&corner| mesh.positions[corner as usize]).collect()
    })
}

/// Whether the emissive mesh of `emitter` lies in the light's plane and their bounds overlap there.
fn covers(document: &Document, emitter: usize, emitter_to_world: &Mat4, light_to_world: &Mat4) -> bool {
    let (u, v) = (light_to_world.x_axis.truncate(), light_to_world.y_axis.truncate());
    let center = light_to_world.w_axis.truncate();
    let Some(normal) = u.cross(v).try_normalize() else { return false };
    let size = u.length().max(v.length());
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for point in emissive(document, emitter) {
        let offset = emitter_to_world.transform_point3(point) - center;
        if offset.dot(normal).abs() > TOLERANCE * size {
            return false;
        }
        // In units of the light's edges: the light itself is -0.5..0.5.
        let local = Vec3::new(offset.dot(u) / u.length_squared(), offset.dot(v) / v.length_squared(), 0.0);
        (low, high) = (low.min(local), high.max(local));
    }
    let overlap = high.min(Vec3::splat(0.5)) - low.max(Vec3::splat(-0.5));
    overlap.x > TOLERANCE && overlap.y > TOLERANCE
}

/// Removes lights that no node holds any more, and renumbers the rest.
fn forget_unused_lights(document: &mut Document) {
    let mut used = vec![false; document.lights.len()];
    let items = || document.nodes.iter().flat_map(|node| &node.items);
    for item in items() {
        if let Item::Light(light) = item {
            used[*light] = true;
        }
    }
    let renumbered: Vec<usize> = used
        .iter()
        .scan(0, |next, &used| {
            *next += usize::from(used);
            Some(*next)
        })
        .collect();
    let mut kept = used.iter();
    document.lights.retain(|_| kept.next().copied().unwrap_or(false));
    for item in document.nodes.iter_mut().flat_map(|node| &mut node.items) {
        if let Item::Light(light) = item {
            *light = renumbered[*light] - 1;
        }
    }
}
