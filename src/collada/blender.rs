//! Blender's exporter: its version, its light extra, and its known mistakes.

use glam::Vec3;

use crate::document::{AreaShape, TransformKind};

use super::error::Fault;
use super::numbers;
use super::xml::Element;

/// (major, minor): (2, 79), (4, 5).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Version(u32, u32);

impl Version {
    /// Since 2.80 the light energy is in watts and lambert is the only shader written.
    pub fn writes_watts(self) -> bool {
        self >= Self(2, 80)
    }

    /// The choice of an up axis came with 2.8x.
    pub fn exports_y_up(self) -> bool {
        self >= Self(2, 80)
    }
}

/// Reads `Blender 4.5.15 LTS ...`.
pub fn version(authoring_tool: &str) -> Option<Version> {
    let numbers = authoring_tool.trim().strip_prefix("Blender ")?;
    let mut parts = numbers.split(|c: char| !c.is_ascii_digit());
    Some(Version(parts.next()?.parse().ok()?, parts.next()?.parse().ok()?))
}

/// The light's type as Blender numbers it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lamp {
    Point,
    Sun,
    Spot,
    Hemi,
    Area,
}

/// `<light><extra><technique profile="blender">`, lengths in file units.
pub struct LightExtra {
    pub lamp: Lamp,
    pub radius: f32,
    pub spot_size_deg: f32,
    pub spot_blend: f32,
    pub shape: AreaShape,
    /// Width and height of an area light.
    pub size: (f32, f32),
}

/// `None` when the extra has no known `<type>`.
pub fn light_extra(technique: Element) -> Result<Option<LightExtra>, Fault> {
    let number = |name: &str| technique.child(name).map(numbers::single).transpose();
    let lamp = match number("type")? {
        Some(0.0) => Lamp::Point,
        Some(1.0) => Lamp::Sun,
        Some(2.0) => Lamp::Spot,
        Some(3.0) => Lamp::Hemi,
        Some(4.0) => Lamp::Area,
        _ => return Ok(None),
    };
    let width = number("area_size")?.unwrap_or(1.0);
    let height = number("area_sizey")?.unwrap_or(width);
    let (shape, size) = match number("area_shape")? {
        Some(1.0) => (AreaShape::Rectangle, (width, height)),
        Some(4.0) => (AreaShape::Disk, (width, width)),
        Some(5.0) => (AreaShape::Disk, (width, height)),
        _ => (AreaShape::Rectangle, (width, width)),
    };
    Ok(Some(LightExtra {
        lamp,
        radius: number("radius")?.unwrap_or(0.0).max(0.0),
        spot_size_deg: number("spotsize")?.unwrap_or(45.0),
        spot_blend: number("spotblend")?.unwrap_or(0.15).clamp(0.0, 1.0),
        shape,
        size,
    }))
}

/// The light as the common technique alone describes it, where Blender was told not to write its own profile.
pub fn implied_extra(element: Element) -> Result<LightExtra, Fault> {
    let number = |name: &str| element.child(name).map(numbers::single).transpose();
    let lamp = match element.name() {
        "ambient" => Lamp::Hemi,
        "directional" => Lamp::Sun,
        "spot" => Lamp::Spot,
        _ => Lamp::Point,
    };
    Ok(LightExtra {
        lamp,
        radius: 0.0,
        spot_size_deg: number("falloff_angle")?.unwrap_or(45.0),
        // Blender writes its blend where the exponent belongs.
        spot_blend: number("falloff_exponent")?.unwrap_or(0.15).clamp(0.0, 1.0),
        shape: AreaShape::Rectangle,
        size: (1.0, 1.0),
    })
}

/// Blender 2.8 and later write decomposed transforms as scale, rotation, translation, which puts the translation through
/// the rotation. True when that order changes where the node lies.
pub fn misordered(kinds: &[TransformKind]) -> bool {
    let (Some(TransformKind::Scale(scale)), Some(TransformKind::Translate(offset))) = (kinds.first(), kinds.last())
    else {
        return false;
    };
    let turned = kinds.iter().any(|kind| matches!(kind, TransformKind::Rotate { angle_deg, .. } if *angle_deg != 0.0));
    *offset != Vec3::ZERO && (turned || (*scale - Vec3::ONE).abs().max_element() > 1e-4)
}

/// Whether a camera stands upright in a Y-up world although the file says Z-up: its right-hand axis is level against Y
/// and not against Z. Blender writes `Z_UP` even when it was told to export Y up.
pub fn looks_y_up(camera_right: Vec3) -> bool {
    let right = camera_right.normalize_or_zero();
    right.y.abs() < 1e-4 && right.z.abs() > 1e-2
}
