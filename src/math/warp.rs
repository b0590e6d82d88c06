//! Maps from the unit square to directions and surfaces, each beside its density.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, PI};

use glam::{Vec2, Vec3};

/// Unit disc, area-preserving and with little distortion. Shirley & Chiu 1997.
#[inline]
pub fn square_to_disk(u: [f32; 2]) -> Vec2 {
    let x = 2.0 * u[0] - 1.0;
    let y = 2.0 * u[1] - 1.0;
    if x == 0.0 && y == 0.0 {
        return Vec2::ZERO;
    }
    let (radius, angle) =
        if x.abs() > y.abs() { (x, FRAC_PI_4 * (y / x)) } else { (y, FRAC_PI_2 - FRAC_PI_4 * (x / y)) };
    let (sin, cos) = angle.sin_cos();
    Vec2::new(radius * cos, radius * sin)
}

/// Cosine-weighted direction about +z. Malley's method.
#[inline]
pub fn square_to_cosine_hemisphere(u: [f32; 2]) -> Vec3 {
    let disk = square_to_disk(u);
    Vec3::new(disk.x, disk.y, (1.0 - disk.length_squared()).max(0.0).sqrt())
}

/// Density of [`square_to_cosine_hemisphere`], 1/sr.
#[inline]
pub fn cosine_hemisphere_pdf(cos_theta: f32) -> f32 {
    cos_theta.max(0.0) * FRAC_1_PI
}

/// Uniform direction.
#[inline]
pub fn square_to_sphere(u: [f32; 2]) -> Vec3 {
    let z = 1.0 - 2.0 * u[0];
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (2.0 * PI * u[1]).sin_cos();
    Vec3::new(radius * cos, radius * sin, z)
}

/// Density of [`square_to_sphere`], 1/sr.
pub const UNIFORM_SPHERE_PDF: f32 = 0.25 * FRAC_1_PI;

/// Uniform direction inside the cone around +z with 1 - cos(half angle) = `one_minus_cos` (kept apart from the cosine,
/// which loses all digits for small cones).
#[inline]
pub fn square_to_cone(u: [f32; 2], one_minus_cos: f32) -> Vec3 {
    let off_axis = u[0] * one_minus_cos;
    let radius = (off_axis * (2.0 - off_axis)).max(0.0).sqrt();
    let (sin, cos) = (2.0 * PI * u[1]).sin_cos();
    Vec3::new(radius * cos, radius * sin, 1.0 - off_axis)
}

/// Density of [`square_to_cone`], 1/sr.
#[inline]
pub fn cone_pdf(one_minus_cos: f32) -> f32 {
    1.0 / (2.0 * PI * one_minus_cos)
}

/// Barycentric weights (b1, b2) of a uniform point on a triangle. Heitz 2019, "A Low-Distortion Map Between Triangle and
/// Square".
#[inline]
pub fn square_to_triangle(u: [f32; 2]) -> [f32; 2] {
    let [mut x, mut y] = u;
    if y > x {
        x *= 0.5;
        y -= x;
    } else {
        y *= 0.5;
        x -= y;
    }
    [x, y]
}
