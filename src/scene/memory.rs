//! What a scene will take in memory, estimated before anything is built: a failed allocation could only abort the program.

use std::mem::size_of;

use glam::Mat4;

use super::BuildError;
use super::light::Emitter;
use super::light_tree::BYTES_PER_LIGHT;
use super::surface::{Part, Place};
use crate::document::{Document, Item, Mesh, Shape};

/// Embree's BVH of a triangle, with the triangle itself (measured: 60 to 130).
const TRIANGLE_BYTES: u64 = 160;
/// A vertex with its normal.
const VERTEX_BYTES: u64 = 24;
const UV_BYTES: u64 = 8;
/// Embree's instance and its share of the BVH over instances.
const INSTANCE_BYTES: u64 = 1000;

/// What is left of `limit` bytes once the scene's shapes and lights are built.
///
/// # Errors
/// The bytes that they need.
pub fn check(document: &Document, placements: &[(usize, Mat4)], limit: u64) -> Result<u64, BuildError> {
    let shines = |material: usize| document.materials.get(material).is_some_and(|m| m.emission.is_some());
    let mut met = vec![false; document.geometries.len()];
    // The document itself stays.
    let mut bytes: u64 = document.geometries.iter().map(|geometry| document_bytes(&geometry.shape)).sum();
    for (node, _) in placements {
        for item in &document.nodes[*node].items {
            let place = size_of::<Place>() as u64 + INSTANCE_BYTES;
            bytes = bytes.saturating_add(place);
            let Item::Geometry { geometry, bindings } = item else { continue };
            let Shape::Mesh(mesh) = &document.geometries[*geometry].shape else { continue };
            if !std::mem::replace(&mut met[*geometry], true) {
                bytes = bytes.saturating_add(mesh_bytes(mesh));
            }
            // Each place has its own emitters.
            for group in &mesh.groups {
                let shining = bindings.iter().any(|b| b.symbol == group.symbol && shines(b.material));
                let emitters = if shining { group.triangles.len() as u64 } else { 0 };
                let bytes_per_emitter = (size_of::<Emitter>() + BYTES_PER_LIGHT) as u64;
                let own = emitters * bytes_per_emitter + size_of::<Part>() as u64;
                bytes = bytes.saturating_add(own);
            }
        }
    }
    if bytes > limit { Err(BuildError::Memory { bytes, limit }) } else { Ok(limit - bytes) }
}

fn document_bytes(shape: &Shape) -> u64 {
    match shape {
        Shape::Mesh(mesh) => mesh.bytes() as u64,
        Shape::Sphere { .. } => 0,
    }
}

/// Of what is built from it.
fn mesh_bytes(mesh: &Mesh) -> u64 {
    let vertex = VERTEX_BYTES + UV_BYTES * mesh.uv_sets.len() as u64;
    mesh.triangles.len() as u64 * TRIANGLE_BYTES + mesh.positions.len() as u64 * vertex
}
