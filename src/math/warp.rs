//! Maps from the unit square to directions and surfaces, each beside its density.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_4, PI};

use glam::{Vec2, Vec3};

use super::trigonometry::{sin_cos_eighth, sin_cos_turn};

/// Unit disc, area-preserving and with little distortion. Shirley & Chiu 1997.
#[inline]
pub fn square_to_disk(u: [f32; 2]) -> Vec2 {
    let x = 2.0 * u[0] - 1.0;
    let y = 2.0 * u[1] - 1.0;
    if x == 0.0 && y == 0.0 {
        return Vec2::ZERO;
    }
    // The angle to the nearer axis, at most an eighth of a turn.
    let near_x = x.abs() > y.abs();
    let (radius, other) = if near_x { (x, y) } else { (y, x) };
    let (sin, cos) = sin_cos_eighth(FRAC_PI_4 * (other / radius));
    let (along, across) = (radius * cos, radius * sin);
    if near_x { Vec2::new(along, across) } else { Vec2::new(across, along) }
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
    let (sin, cos) = sin_cos_turn(u[1]);
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
    let (sin, cos) = sin_cos_turn(u[1]);
    Vec3::new(radius * cos, radius * sin, 1.0 - off_axis)
}

/// Density of [`square_to_cone`], 1/sr.
#[inline]
pub fn cone_pdf(one_minus_cos: f32) -> f32 {
    1.0 / (2.0 * PI * one_minus_cos)
}

/// Direction around +z that is half the time within 1 - cos = `width`, roughly, and may go anywhere: the spherical Cauchy
/// distribution. Kato & McCullagh 2020, "Some properties of a Cauchy family on the sphere", section 2.
#[inline]
pub fn square_to_cauchy(u: [f32; 2], width: f32) -> Vec3 {
    square_to_cone([1.0, u[1]], 2.0 * width * u[0] / (2.0 + width - 2.0 * u[0]))
}

/// Density of [`square_to_cauchy`] where 1 - cos of the angle to the axis is `off_axis`, 1/sr.
#[inline]
pub fn cauchy_pdf(off_axis: f32, width: f32) -> f32 {
    let reach = off_axis + width;
    0.25 * FRAC_1_PI * width * (2.0 + width) / (reach * reach)
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
