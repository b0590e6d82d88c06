//! Curves over time, and what in the document each of them drives.

use glam::Vec2;

/// One `<channel>` with its sampler: a curve over time that drives a target.
#[derive(Clone, Debug)]
pub struct Channel {
    /// As written: `node/sid.X`, `node/sid(3)(0)`, `camera/xfov`, `effect/film/thickness_nm`, ...
    pub target: String,
    pub drives: Quantity,
    /// Which of the quantity's numbers; `None`: all of them, in order.
    pub member: Option<usize>,
    pub times_s: Vec<f32>,
    /// Row-major: `times_s.len()` rows of `width` values.
    pub values: Vec<f32>,
    pub width: usize,
    /// One per key; how the curve runs from this key to the next.
    pub interpolation: Vec<Interpolation>,
    /// BEZIER control points or HERMITE tangent vectors, `width` (time, value) pairs per key (1-D ones have been given their
    /// times); empty when the curve has none.
    pub in_tangents: Vec<Vec2>,
    pub out_tangents: Vec<Vec2>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    Linear,
    Step,
    Bezier,
    Hermite,
}

/// A part of the document that a channel can drive. Its numbers are those of the file's element or attribute, in the file's
/// order: a matrix row by row, `<rotate>` as x, y, z, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quantity {
    Transform {
        node: usize,
        transform: usize,
    },
    Camera {
        camera: usize,
        part: CameraPart,
    },
    /// Three numbers, or one for all three. Times `scale` they are [`Light::color`](super::Light::color).
    LightColor {
        light: usize,
        scale: f32,
    },
    Material {
        material: usize,
        part: MaterialPart,
    },
    Film {
        material: usize,
        film: usize,
        part: FilmPart,
    },
    Environment(EnvironmentPart),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CameraPart {
    XFov,
    YFov,
    XMag,
    YMag,
    ApertureRadius,
    /// With a fixed focal length.
    FNumber {
        focal_mm: f32,
    },
    FocusDistance,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MaterialPart {
    Reflectance,
    Roughness,
    Absorption,
    Emission,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilmPart {
    /// Of a film of constant or noisy thickness.
    Thickness,
    /// How strong the noise is.
    Amplitude,
    Top,
    Bottom,
    Min,
    Max,
    Weight,
    /// The real part of a constant index.
    Ior,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnvironmentPart {
    Radiance,
    Strength,
    Rotation,
}
