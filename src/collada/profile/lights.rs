//! `<light>`: `<area>` and `<spectrum>`.

use glam::Vec3;

use crate::collada::error::Fault;
use crate::collada::xml::Element;
use crate::color::Emission;
use crate::document::{AreaShape, LightKind, Presence};

use super::spectrum;
use super::strict::{Bounds, Strict, at_most_one, only_children};

/// What our profile says about a light.
#[derive(Default)]
pub struct LightProfile {
    pub area: Option<Area>,
    pub spectrum: Option<Emission>,
    /// Size of a point or spot light, metres.
    pub radius_m: Option<f32>,
    /// Full angle of the disc in the sky that directional light comes from.
    pub angle_deg: Option<f32>,
}

pub struct Area {
    pub kind: LightKind,
    pub strength: Strength,
    pub spectrum: Emission,
}

pub enum Strength {
    /// W/(sr m2).
    Radiance(Vec3),
    /// W in all, spread over the area.
    Power(f32),
}

pub fn read(technique: Element) -> Result<LightProfile, Fault> {
    only_children(technique, &["area", "spectrum"])?;
    let mut profile = LightProfile::default();
    if let Some(element) = at_most_one(technique, &["area"])? {
        profile.area = Some(area(element)?);
    }
    if let Some(element) = at_most_one(technique, &["spectrum"])? {
        let mut strict = Strict::new(element);
        profile.spectrum = spectrum::read(&mut strict, "kind")?;
        profile.radius_m = strict.number("radius_m", Bounds::AtLeast(0.0))?;
        profile.angle_deg = strict.number("angle_deg", Bounds::Within(0.0, 180.0))?;
        strict.finish(&[])?;
    }
    Ok(profile)
}

fn area(element: Element) -> Result<Area, Fault> {
    let mut strict = Strict::new(element);
    let shapes = [("rectangle", AreaShape::Rectangle), ("disk", AreaShape::Disk), ("sphere", AreaShape::Sphere)];
    let shape = strict.choice("shape", &shapes)?.unwrap_or(AreaShape::Rectangle);
    let radiance = strict.rgb("radiance", Bounds::AtLeast(0.0))?;
    let power = strict.number("power_w", Bounds::AtLeast(0.0))?;
    strict.not_both("radiance", "power_w")?;
    let spectrum = spectrum::read(&mut strict, "spectrum")?.unwrap_or_default();
    let presence = if strict.flag("visible")?.unwrap_or(true) { Presence::Solid } else { Presence::Hidden };
    let strength = match (radiance, power) {
        (Some(radiance), _) => Strength::Radiance(radiance),
        (None, Some(watts)) => Strength::Power(watts),
        (None, None) => return Err(element.fault("<area> has neither `radiance` nor `power_w`")),
    };
    strict.finish(&[])?;
    Ok(Area { kind: LightKind::Area { shape, presence }, strength, spectrum })
}
