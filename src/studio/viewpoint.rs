//! Where a camera stands to see a model well: from the front, a little from the right and above, through a long lens.

use glam::{Mat4, Vec2, Vec3};

use crate::document::{Camera, Document, Projection, Shape};

const AZIMUTH_DEG: f32 = 30.0;
const ELEVATION_DEG: f32 = 22.0;
/// Of a picture of 4:3; as an 80 mm lens on 36 x 24 mm.
const YFOV_DEG: f32 = 22.0;
const ASPECT: f32 = 4.0 / 3.0;
/// Share of the picture that the model may fill.
const FILLS: f32 = 0.8;

/// A camera that sees the model whole, however it is turned about the vertical axis, and its place in the world. Nothing
/// for a scene without vertices.
pub fn camera(document: &Document) -> Option<(Camera, Mat4)> {
    let (sin_a, cos_a) = AZIMUTH_DEG.to_radians().sin_cos();
    let (sin_e, cos_e) = ELEVATION_DEG.to_radians().sin_cos();
    let outward = Vec3::new(sin_a, 0.0, cos_a);
    let toward = outward * cos_e + Vec3::Y * sin_e;
    let up = Vec3::Y * cos_e - outward * sin_e;
    let tan_y = (0.5 * YFOV_DEG.to_radians()).tan();
    let tan = [FILLS * ASPECT * tan_y, FILLS * tan_y];

    // The circles that vertices run through on a turntable, as (radius, height).
    let meshes = document.geometries.iter().filter_map(|geometry| match &geometry.shape {
        Shape::Mesh(mesh) => Some(mesh),
        Shape::Sphere { .. } => None,
    });
    let circles: Vec<(f32, f32)> = meshes.flat_map(|mesh| &mesh.positions).map(|p| (p.x.hypot(p.z), p.y)).collect();
    let (low, high) = circles.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), c| (l.min(c.1), h.max(c.1)));
    if circles.is_empty() {
        return None;
    }
    let mut target = Vec3::Y * (0.5 * (low + high));
    let mut distance = 0.0f32;
    // The nearest and the farthest point of each circle, and one at its side.
    let points = |&(radius, y): &(f32, f32)| {
        let centre = Vec3::Y * y;
        [(centre + radius * outward, 0.0), (centre - radius * outward, 0.0), (centre, radius)]
    };
    // The middle of what is seen is not the middle of what is there: perspective moves it.
    for _ in 0..4 {
        distance = 0.0;
        for (point, side) in circles.iter().flat_map(points) {
            let from = point - target;
            let extent = (from.dot(up).abs() / tan[1]).max(side / tan[0]);
            distance = distance.max(extent + from.dot(toward));
        }
        let (mut bottom, mut top) = (f32::INFINITY, f32::NEG_INFINITY);
        for (point, _) in circles.iter().flat_map(points) {
            let from = point - target;
            let height = from.dot(up) / (distance - from.dot(toward));
            (bottom, top) = (bottom.min(height), top.max(height));
        }
        target += up * (0.5 * (bottom + top) * distance);
    }
    let xfov_deg = 2.0 * (ASPECT * tan_y).atan().to_degrees();
    let projection = Projection::Perspective { xfov_deg: Some(xfov_deg), yfov_deg: Some(YFOV_DEG), aspect: None };
    let camera = Camera { id: "camera".to_owned(), projection, lens: None, shift: Vec2::ZERO };
    Some((camera, Mat4::look_at_rh(target + toward * distance, target, Vec3::Y).inverse()))
}
