//! Curves over time.

use glam::Vec2;

/// One `<channel>` with its sampler: a curve over time that drives a target.
#[derive(Clone, Debug)]
pub struct Channel {
    /// As written: `node/sid.X`, `node/sid(3)(0)`, `camera/xfov`, ...
    pub target: String,
    pub times_s: Vec<f32>,
    /// Row-major: `times_s.len()` rows of `width` values.
    pub values: Vec<f32>,
    pub width: usize,
    /// One per key; how the curve runs from this key to the next.
    pub interpolation: Vec<Interpolation>,
    /// BEZIER and HERMITE tangents, `width` (time, value) pairs per key (1-D tangents have been given their times); empty
    /// when the curve has none.
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
