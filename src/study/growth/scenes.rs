//! Scenes of which one thing can grow. Metres, Y up.

use glam::{Mat4, Vec2, Vec3};

use crate::color::{Emission, Index};
use crate::document::{
    AreaShape, Base, Binding, Camera, Document, Environment, Film, Geometry, Group, Item, Light, LightKind, Material,
    Mesh, Microfacets, Presence, Projection, Scalar, Shape, Texture, Thickness,
};
use crate::studio::add;

/// Reflectance of the hall's floor.
const GREY: f32 = 0.5;
/// Of the room's walls: light goes on long enough to be cut off by the limit.
const WHITE: f32 = 0.95;
/// The hall: side of its floor, height of its lamps and of the camera below them, metres.
const FLOOR_M: f32 = 20.0;
const LAMPS_M: f32 = 1.0;
const CAMERA_M: f32 = 0.9;
/// Area of all lamps together, m2, and their radiance: about 1 comes back from the floor.
const LAMPS_M2: f32 = 4.0;
const LAMP_RADIANCE: f32 = 150.0;
/// Steps that spread points evenly over a square, however many there are: powers of the inverse of the plastic number.
const SPREAD: Vec2 = Vec2::new(0.754_877_7, 0.569_840_3);

/// Titanium, somewhat rough.
pub(super) fn metal() -> Material {
    let microfacets = Microfacets { roughness: Scalar::constant(0.2), ..Microfacets::default() };
    Material { base: Base::Conductor { index: Index::Named("Ti".to_owned()), microfacets }, ..Material::default() }
}

/// The same under an oxide film of uneven thickness.
pub(super) fn anodised() -> Material {
    let thickness = Thickness::Noise { nm: 120.0, amplitude: 0.8, frequency: 2.0, octaves: 2, seed: 0 };
    let film = Film { index: Index::Named("TiO2".to_owned()), thickness, weight: 1.0 };
    Material { films: vec![film], ..metal() }
}

/// Cells along a side of the grid that has about so many triangles: two to a cell.
fn cells(triangles: u64) -> u32 {
    (triangles as f64 / 2.0).sqrt().round().max(1.0) as u32
}

/// The triangles that a [`surface`] has when it is asked for so many.
pub(super) fn triangles_of(triangles: u64) -> u64 {
    2 * u64::from(cells(triangles)).pow(2)
}

/// A square of bumps, 2 m wide, under a white sky. The bumps are the same however many triangles follow them.
pub(super) fn surface(triangles: u64, material: Material) -> Document {
    let mut document = Document::default();
    place(&mut document, bumps(cells(triangles)), material);
    let eye = Vec3::new(0.0, 1.7, 1.9);
    look(&mut document, perspective(50.0), Mat4::look_at_rh(eye, Vec3::new(0.0, 0.0, 0.1), Vec3::Y));
    document.environment = Some(Environment {
        image: None,
        radiance: Vec3::ONE,
        strength: 1.0,
        rotation_deg: 0.0,
        spectrum: Emission::D65,
    });
    document
}

/// A floor under lamps, seen from below them: as much light, from as much area, however many there are.
pub(super) fn hall(lamps: u32) -> Document {
    let mut document = Document::default();
    let far = 0.5 * FLOOR_M;
    let corners = [(-far, -far), (-far, far), (far, far), (far, -far)].map(|(x, z)| Vec3::new(x, 0.0, z));
    place(&mut document, quads(&[corners]), diffuse(GREY));
    let side = (LAMPS_M2 / lamps as f32).sqrt();
    document.lights.push(lamp(LAMP_RADIANCE));
    for number in 0..lamps {
        let spot = (Vec2::splat(0.5) + number as f32 * SPREAD).fract() - 0.5;
        hang(&mut document, Vec3::new(FLOOR_M * spot.x, LAMPS_M, FLOOR_M * spot.y), side);
    }
    let eye = Vec3::new(0.0, CAMERA_M, 0.0);
    let projection = Projection::Orthographic { xmag: Some(far), ymag: Some(far), aspect: None };
    look(&mut document, projection, Mat4::look_at_rh(eye, Vec3::ZERO, Vec3::NEG_Z));
    document
}

/// A closed room of white walls with one lamp, seen from inside: no path leaves it.
pub(super) fn room() -> Document {
    let mut document = Document::default();
    // Both ends of each axis; the two other axes go around.
    let wall = |axis: usize, end: f32| {
        [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(u, v)| {
            let mut corner = Vec3::ZERO;
            (corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (end, u, v);
            corner
        })
    };
    let walls: Vec<_> = (0..3).flat_map(|axis| [-1.0, 1.0].map(|end| wall(axis, end))).collect();
    place(&mut document, quads(&walls), diffuse(WHITE));
    document.lights.push(lamp(5.0));
    hang(&mut document, Vec3::new(0.0, 0.99, 0.0), 0.5);
    look(&mut document, perspective(60.0), Mat4::look_at_rh(Vec3::new(0.0, 0.0, 0.95), Vec3::ZERO, Vec3::Y));
    document
}

fn diffuse(reflectance: f32) -> Material {
    let base = Base::Diffuse { reflectance: Texture::constant(Vec3::splat(reflectance)), ior: 1.5 };
    Material { base, ..Material::default() }
}

/// A grid of cells over -1..1 in x and z, with smooth normals.
fn bumps(cells: u32) -> Mesh {
    let height = |p: Vec2| {
        let wide = 0.06 * (7.0 * p.x + 1.3 * (5.0 * p.y).sin()).sin();
        let middling = 0.03 * (13.0 * p.y + 2.0 * (9.0 * p.x).sin()).sin();
        wide + middling + 0.012 * (31.0 * p.x).sin() * (29.0 * p.y).sin()
    };
    let across = cells + 1;
    let points = (0..across * across).map(|i| Vec2::new((i % across) as f32, (i / across) as f32));
    let points: Vec<Vec2> = points.map(|p| 2.0 * p / cells as f32 - 1.0).collect();
    let normal = |&p: &Vec2| {
        let step = 1e-3;
        let slope = |along: Vec2| (height(p + step * along) - height(p - step * along)) / (2.0 * step);
        Vec3::new(-slope(Vec2::X), 1.0, -slope(Vec2::Y)).normalize()
    };
    let cell = |i: u32| {
        let corner = i / cells * across + i % cells;
        [[corner, corner + across, corner + 1], [corner + 1, corner + across, corner + across + 1]]
    };
    let triangles: Vec<[u32; 3]> = (0..cells * cells).flat_map(cell).collect();
    Mesh {
        positions: points.iter().map(|&p| Vec3::new(p.x, height(p), p.y)).collect(),
        normals: points.iter().map(normal).collect(),
        ..mesh(triangles)
    }
}

fn quads(corners: &[[Vec3; 4]]) -> Mesh {
    let triangles = (0..corners.len() as u32).flat_map(|i| [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k| 4 * i + k)));
    Mesh { positions: corners.concat(), ..mesh(triangles.collect()) }
}

/// Of one material.
fn mesh(triangles: Vec<[u32; 3]>) -> Mesh {
    let groups = vec![Group { symbol: String::new(), triangles: 0..triangles.len() }];
    Mesh { triangles, groups, ..Mesh::default() }
}

fn place(document: &mut Document, mesh: Mesh, material: Material) {
    document.geometries.push(Geometry { id: String::new(), shape: Shape::Mesh(mesh) });
    document.materials.push(material);
    let bindings = vec![Binding { symbol: String::new(), material: 0, uv_sets: Vec::new() }];
    add(document, "", Mat4::IDENTITY, Item::Geometry { geometry: 0, bindings });
}

fn lamp(radiance: f32) -> Light {
    let kind = LightKind::Area { shape: AreaShape::Rectangle, presence: Presence::Solid };
    Light { id: String::new(), kind, color: Vec3::splat(radiance), spectrum: Emission::D65 }
}

/// Hangs a lamp that shines down, so many metres wide.
fn hang(document: &mut Document, at: Vec3, side_m: f32) {
    let down = Mat4::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let size = Mat4::from_scale(Vec3::new(side_m, side_m, 1.0));
    add(document, "", Mat4::from_translation(at) * down * size, Item::Light(0));
}

fn perspective(fov_deg: f32) -> Projection {
    Projection::Perspective { xfov_deg: Some(fov_deg), yfov_deg: Some(fov_deg), aspect: None }
}

/// `view` maps the world to the camera.
fn look(document: &mut Document, projection: Projection, view: Mat4) {
    document.cameras.push(Camera { id: String::new(), projection, lens: None, shift: Vec2::ZERO });
    add(document, "", view.inverse(), Item::Camera(0));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surfaces_have_about_the_triangles_that_are_asked_for_and_face_up() {
        for wanted in [1u64, 1000, 30_000] {
            let Shape::Mesh(mesh) = &surface(wanted, metal()).geometries[0].shape else { panic!("a mesh") };
            let count = mesh.triangles.len() as u64;
            assert_eq!(count, triangles_of(wanted));
            assert!(count.abs_diff(wanted) <= 1 + wanted / 20, "{count} instead of {wanted}");
            for triangle in &mesh.triangles {
                let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
                assert!((b - a).cross(c - a).y > 0.0);
                assert!(triangle.iter().all(|&i| mesh.normals[i as usize].y > 0.0));
            }
        }
    }

    #[test]
    fn lamps_share_out_their_area_over_the_floor() {
        for lamps in [1, 10, 1000] {
            let document = hall(lamps);
            let placed = document.placements();
            let lights = placed.iter().filter(|(node, _)| matches!(document.nodes[*node].items[0], Item::Light(_)));
            let (mut area, mut count) = (0.0, 0);
            for (_, to_world) in lights {
                let place = to_world.w_axis.truncate();
                assert!(place.x.abs() <= 0.5 * FLOOR_M && place.z.abs() <= 0.5 * FLOOR_M && place.y == LAMPS_M);
                assert!((to_world.transform_vector3(Vec3::NEG_Z) - Vec3::NEG_Y).length() < 1e-6);
                area += to_world.x_axis.length() * to_world.y_axis.length();
                count += 1;
            }
            assert!(count == lamps && (area / LAMPS_M2 - 1.0).abs() < 1e-3, "{count} {area}");
        }
    }
}
