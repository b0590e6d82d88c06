//! Light sources that are not surface materials.

use glam::Vec3;

use crate::color::Emission;

/// A light source that is not a surface material.
#[derive(Clone, Debug)]
pub struct Light {
    pub id: String,
    pub kind: LightKind,
    /// Radiant intensity (point, spot; W/sr), irradiance (directional; W/m2) or radiance (area, ambient; W/(sr m2)).
    pub color: Vec3,
    pub spectrum: Emission,
}

#[derive(Clone, Copy, Debug)]
pub enum LightKind {
    /// One-sided along local -Z.
    Area { shape: AreaShape, presence: Presence },
    /// A point, or a sphere of `radius_m` with the same intensity.
    Point { radius_m: f32, falloff: Falloff },
    /// Along local -Z, from a point or a disc of `radius_m`. `cone_deg` is the full angle. Inside, intensity is scaled by
    /// `edge`.
    Spot { cone_deg: f32, edge: SpotEdge, radius_m: f32, falloff: Falloff },
    /// Shines along local -Z; `angle_deg` is the full angle of the disc it comes from (0 = parallel).
    Directional { angle_deg: f32 },
    /// Constant radiance from the upper hemisphere (+Y in world space), as the CS184 course has it.
    Ambient,
}

/// How much of a thing an area light is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presence {
    /// Seen, and in the way of other light.
    Solid,
    /// Seen, but other light passes as if it were not there, like Blender's lamps.
    Ghost,
    /// Only its light is there.
    Hidden,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AreaShape {
    /// Unit square in local XY, centred, times the node matrix.
    Rectangle,
    /// Unit-diameter disc in local XY, centred, times the node matrix.
    Disk,
    /// Unit-diameter sphere, radius scaled by the node's local x axis; radiates outwards.
    Sphere,
}

/// How intensity falls off with the distance d in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Falloff {
    /// 1 / d^2.
    Physical,
    /// 1 / (constant + linear d + quadratic d^2), literally.
    Attenuation { constant: f32, linear: f32, quadratic: f32 },
}

#[derive(Clone, Copy, Debug)]
pub enum SpotEdge {
    /// cos(angle)^exponent inside the cone (COLLADA `falloff_exponent`).
    Exponent(f32),
    /// Blender's `spot_blend`, 0..1: a smooth step over that share of the cone.
    Blend(f32),
}

/// Light from infinitely far away, all around.
#[derive(Clone, Debug)]
pub struct Environment {
    /// Lat-long image; v = 0 at +y, u = atan2(x, -z) / 2 pi.
    pub image: Option<usize>,
    /// Constant radiance, or the image's tint.
    pub radiance: Vec3,
    pub strength: f32,
    pub rotation_deg: f32,
    pub spectrum: Emission,
}
