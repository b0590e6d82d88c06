//! What a bare model stands on.

use std::f32::consts::TAU;

use glam::{Mat4, Vec2, Vec3};

use crate::document::{
    Base, Binding, Channel4, Document, Encoding, Geometry, Group, Image, Item, Map, Material, Mesh, Shape, Texture,
    UvSet, Wrap,
};

use super::{add, sky};

/// The camera, which looks down, sees no end of it.
const RADIUS_M: f32 = 10.0;
/// It lies this far below the model, so that a flat underside is not in the same place.
const GAP_M: f32 = 1e-4;
const SIDES: u32 = 128;
/// Where the grade begins and ends, metres from the middle.
const GRADE_M: [f32; 2] = [0.3, 4.5];
/// Texels along a side of the grade's image.
const TEXELS: usize = 512;

/// Lays a round floor of the reflectance near the middle and far from it.
pub fn lay(document: &mut Document, [near, far]: [Vec3; 2]) {
    let map = (near != far).then(|| {
        let grade = |[u, v]: [f32; 2]| {
            let radius_m = 2.0 * RADIUS_M * Vec2::new(u - 0.5, v - 0.5).length();
            near.lerp(far, sky::smooth(GRADE_M[0], GRADE_M[1], radius_m))
        };
        let (id, source) = ("floor.hdr".to_owned(), sky::image([TEXELS; 2], grade));
        document.images.push(Image { id: id.clone(), uri: id, user: "the floor".to_owned(), source });
        Map {
            image: document.images.len() - 1,
            texcoord: String::new(),
            slot: 0,
            encoding: Encoding::Linear,
            channel: Channel4::G,
            wrap: [Wrap::Clamp; 2],
        }
    });
    let value = if map.is_some() { Vec3::ONE } else { near };
    let base = Base::Diffuse { reflectance: Texture { value, map }, ior: 1.5 };
    document.materials.push(Material { id: "floor".to_owned(), base, ..Material::default() });
    document.geometries.push(Geometry { id: "floor".to_owned(), shape: Shape::Mesh(disc()) });
    let bindings = vec![Binding { symbol: String::new(), material: document.materials.len() - 1, uv_sets: Vec::new() }];
    let below = Mat4::from_translation(Vec3::new(0.0, -GAP_M, 0.0));
    add(document, "floor", below, Item::Geometry { geometry: document.geometries.len() - 1, bindings });
}

/// A disc that faces up, with its image seen from above.
fn disc() -> Mesh {
    let mut unit = vec![Vec2::ZERO];
    unit.extend((0..SIDES).map(|side| Vec2::from_angle(TAU * side as f32 / SIDES as f32)));
    let triangles: Vec<[u32; 3]> = (0..SIDES).map(|side| [0, 1 + (side + 1) % SIDES, 1 + side]).collect();
    Mesh {
        positions: unit.iter().map(|p| RADIUS_M * Vec3::new(p.x, 0.0, p.y)).collect(),
        uv_sets: vec![UvSet { set: 0, uvs: unit.iter().map(|p| 0.5 + 0.5 * *p).collect() }],
        groups: vec![Group { symbol: String::new(), triangles: 0..triangles.len() }],
        triangles,
        ..Mesh::default()
    }
}
