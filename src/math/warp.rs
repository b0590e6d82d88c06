//! Maps from the unit square to directions and surfaces, each beside its density.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_4, PI};

use glam::{Vec2, Vec3};

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

/// Sine and cosine of an angle of at most pi/4 either way, to 1e-7: no range to reduce, no call, no branch. The polynomials
/// of the Cephes library (Moshier), sinf.c.
#[inline]
fn sin_cos_eighth(angle: f32) -> (f32, f32) {
    let z = angle * angle;
    let sin = ((-1.951_529_6e-4 * z + 8.332_161e-3) * z - 0.166_666_55) * z * angle + angle;
    let cos = ((2.443_315_7e-5 * z - 1.388_731_6e-3) * z + 4.166_664_6e-2) * z * z - 0.5 * z + 1.0;
    (sin, cos)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_sines_are_exact_enough() {
        for i in -1000..=1000 {
            let angle = FRAC_PI_4 * i as f32 / 1000.0;
            let ((sin, cos), (true_sin, true_cos)) = (sin_cos_eighth(angle), f64::from(angle).sin_cos());
            assert!((f64::from(sin) - true_sin).abs() < 1e-7 && (f64::from(cos) - true_cos).abs() < 1e-7, "{angle}");
        }
    }
}
