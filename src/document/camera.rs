//! Cameras.

use glam::Vec2;

#[derive(Clone, Debug)]
pub struct Camera {
    pub id: String,
    pub projection: Projection,
    pub lens: Option<Lens>,
    /// Lens shift as a share of the larger picture side (Blender's `shiftx`, `shifty`).
    pub shift: Vec2,
}

#[derive(Clone, Copy, Debug)]
pub enum Projection {
    /// Full angles in degrees; at least one of the two fovs is given. `aspect` = width / height.
    Perspective { xfov_deg: Option<f32>, yfov_deg: Option<f32>, aspect: Option<f32> },
    /// Half extents in file units; at least one is given.
    Orthographic { xmag: Option<f32>, ymag: Option<f32>, aspect: Option<f32> },
}

/// Thin lens.
#[derive(Clone, Copy, Debug)]
pub struct Lens {
    pub aperture_radius_m: f32,
    pub focus_distance_m: f32,
    /// Sides of the aperture; below 3 it is round.
    pub blades: u32,
}
