//! Images that are painted when they are asked for.

use std::f32::consts::{PI, TAU};

use glam::Vec3;
use image::Rgb;
use image::codecs::hdr::HdrEncoder;

use crate::document::ImageSource;

/// Columns of a painted sky; half as many rows.
const WIDTH: usize = 1024;
const HEIGHT: usize = WIDTH / 2;

/// Where the sun stands: behind the camera of a bare model, on the left.
const SUN: Vec3 = Vec3::new(-0.55, 0.62, 0.56);
/// Angular radius of the sun's disc. Larger than the real one (0.27), so that the image has room for it.
const SUN_RADIUS_DEG: f32 = 0.8;

/// A lat-long image of the radiance from each direction (unit length, Y up).
pub fn painted(radiance: impl Fn(Vec3) -> Vec3) -> ImageSource {
    image([WIDTH, HEIGHT], |[u, v]| {
        let ((sin_phi, cos_phi), (sin_theta, cos_theta)) = ((u * TAU).sin_cos(), (v * PI).sin_cos());
        radiance(Vec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi))
    })
}

/// A Radiance HDR image of the colours at (u, v), 0..1 from the upper left corner.
pub fn image([width, height]: [usize; 2], color: impl Fn([f32; 2]) -> Vec3) -> ImageSource {
    let texel = |i: usize| {
        let middle = [(i % width) as f32 + 0.5, (i / width) as f32 + 0.5];
        Rgb(color([middle[0] / width as f32, middle[1] / height as f32]).to_array())
    };
    let texels: Vec<Rgb<f32>> = (0..width * height).map(texel).collect();
    let mut bytes = Vec::new();
    match HdrEncoder::new(&mut bytes).encode(&texels, width, height) {
        Ok(()) => ImageSource::Bytes(bytes),
        // Writing to memory does not fail.
        Err(_) => ImageSource::Missing,
    }
}

/// A soft box: brightest in the middle, with soft edges.
struct SoftBox {
    toward: Vec3,
    /// Half its width and height, as tangents.
    half: [f32; 2],
    radiance: f32,
}

const SOFT_BOXES: [SoftBox; 4] = [
    // A bank overhead, for the floor and for all that faces up.
    SoftBox { toward: Vec3::new(-0.1, 1.0, -0.2), half: [1.2, 0.75], radiance: 1.1 },
    // The light that models, from the left.
    SoftBox { toward: Vec3::new(-1.0, 0.55, 0.5), half: [0.65, 0.8], radiance: 1.3 },
    // A strip from behind that draws the outline.
    SoftBox { toward: Vec3::new(1.0, 0.5, -0.9), half: [0.2, 0.75], radiance: 1.8 },
    // A dim one on the right: what faces it is not black.
    SoftBox { toward: Vec3::new(1.0, 0.4, 0.9), half: [0.55, 0.55], radiance: 0.55 },
];

impl SoftBox {
    fn radiance(&self, toward: Vec3) -> f32 {
        let axis = self.toward.normalize();
        let cos = toward.dot(axis);
        if cos <= 0.0 {
            return 0.0;
        }
        let right = axis.cross(Vec3::Y).normalize();
        let across = [toward.dot(right) / cos / self.half[0], toward.dot(right.cross(axis)) / cos / self.half[1]];
        let edge = |x: f32| 1.0 - smooth(0.8, 1.0, x.abs());
        let middle = 1.0 - 0.25 * (across[0] * across[0] + across[1] * across[1]);
        self.radiance * edge(across[0]) * edge(across[1]) * middle
    }
}

/// Soft boxes in a dark room, a little brighter towards its ceiling.
pub fn studio(toward: Vec3) -> Vec3 {
    let room = 0.05 + 0.06 * (0.5 + 0.5 * toward.y);
    Vec3::splat(room + SOFT_BOXES.iter().map(|lamp| lamp.radiance(toward)).sum::<f32>())
}

/// White cloth all around, brightest above, with a darker slit at the height of the camera that gives shapes an edge.
pub fn tent(toward: Vec3) -> Vec3 {
    let above = 0.5 + 0.5 * toward.y;
    let cloth = 0.55 + 0.75 * above * above;
    let slit = smooth(0.92, 0.985, Vec3::new(0.5, 0.12, 0.86).normalize().dot(toward));
    Vec3::splat(cloth * (1.0 - 0.85 * slit))
}

/// Deep blue at the top, pale at the horizon, warm around the sun; ground below.
pub fn clear_sky(toward: Vec3) -> Vec3 {
    let sun = SUN.normalize();
    let height = toward.y;
    if height < 0.0 {
        return Vec3::new(0.16, 0.145, 0.125);
    }
    let zenith = Vec3::new(0.10, 0.22, 0.52);
    let horizon = Vec3::new(0.60, 0.68, 0.78);
    let gradient = horizon.lerp(zenith, height.sqrt());
    let near_sun = toward.dot(sun).max(0.0);
    let glow = Vec3::new(1.0, 0.85, 0.6) * (0.5 * near_sun.powi(8) + 2.0 * near_sun.powi(96));
    let disc =
        if near_sun > SUN_RADIUS_DEG.to_radians().cos() { Vec3::new(1.0, 0.93, 0.8) * 6500.0 } else { Vec3::ZERO };
    gradient + glow + disc
}

/// 0 below `low`, 1 above `high`, smooth between.
pub fn smooth(low: f32, high: f32, value: f32) -> f32 {
    let t = ((value - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
