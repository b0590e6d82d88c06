//! Bounds of what lights send.

use std::f32::consts::PI;

use glam::Vec3;

/// Where a light is, and what it sends into which directions.
#[derive(Clone, Copy, Debug)]
pub struct Beam {
    /// Corners of its bounding box.
    pub low: Vec3,
    pub high: Vec3,
    /// Its normals lie in a cone around `axis`, of this half angle in radians, and it shines up to `spread` beside them.
    pub axis: Vec3,
    pub half_angle: f32,
    pub spread: f32,
    /// True when it shines along its normals and against them.
    pub two_sided: bool,
    /// Greatest radiant intensity, mean over the colours.
    pub intensity: f32,
}

impl Beam {
    /// A light that shines into all directions.
    pub fn all_around(low: Vec3, high: Vec3, intensity: f32) -> Self {
        Self { low, high, axis: Vec3::Z, half_angle: PI, spread: 0.5 * PI, two_sided: false, intensity }
    }

    pub fn center(&self) -> Vec3 {
        0.5 * (self.low + self.high)
    }

    /// Of its box, squared.
    pub fn diagonal2(&self) -> f32 {
        (self.high - self.low).length_squared()
    }

    /// What both send.
    pub fn with(&self, other: &Self) -> Self {
        let (axis, half_angle) = common_cone((self.axis, self.half_angle), (other.axis, other.half_angle));
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            axis,
            half_angle,
            spread: self.spread.max(other.spread),
            two_sided: self.two_sided || other.two_sided,
            intensity: self.intensity + other.intensity,
        }
    }

    /// What it costs to draw from these lights without telling them apart: large boxes, wide cones. Conty Estevez and Kulla,
    /// section 4.1, with the square of the diagonal for the surface, which is not zero for points in a row.
    pub fn cost(&self) -> f32 {
        let Self { half_angle: o, spread, .. } = *self;
        let w = (o + spread).min(PI);
        let directions = 2.0 * PI * (1.0 - o.cos())
            + 0.5 * PI * (2.0 * w * o.sin() - (o - 2.0 * w).cos() - 2.0 * o * o.sin() + o.cos());
        self.intensity * directions * self.diagonal2()
    }
}

/// The smallest cone that holds two: axes and half angles.
fn common_cone(a: (Vec3, f32), b: (Vec3, f32)) -> (Vec3, f32) {
    let (wide, narrow) = if a.1 >= b.1 { (a, b) } else { (b, a) };
    let between = wide.0.dot(narrow.0).clamp(-1.0, 1.0).acos();
    if (between + narrow.1).min(PI) <= wide.1 {
        return wide;
    }
    let half_angle = 0.5 * (wide.1 + between + narrow.1);
    let across = (narrow.0 - wide.0 * wide.0.dot(narrow.0)).try_normalize();
    match across {
        Some(across) if half_angle < PI => {
            let (sin, cos) = (half_angle - wide.1).sin_cos();
            (wide.0 * cos + across * sin, half_angle)
        }
        // Nearly parallel axes have no direction between them worth turning to.
        None if wide.0.dot(narrow.0) > 0.0 => (wide.0, half_angle.min(PI)),
        _ => (wide.0, PI),
    }
}
