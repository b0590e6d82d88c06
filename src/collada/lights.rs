//! `<light>`: our `<area>`, CGL, Blender's extra, or the common technique, in this order.

use std::f32::consts::PI;

use glam::Vec3;

use crate::color::Emission;
use crate::document::{AreaShape, Falloff, Light, LightKind, Presence, SpotEdge};

use super::FalloffRule;
use super::blender::{self, Lamp, LightExtra};
use super::error::Fault;
use super::loader::{Loader, technique};
use super::numbers;
use super::profile::{self, lights::LightProfile, lights::Strength};
use super::xml::Element;

/// A light that has been read once.
#[derive(Clone, Copy)]
pub struct LoadedLight {
    pub index: usize,
    /// Width and height of an area light whose size is not in the node's matrix.
    pub size: Option<(f32, f32)>,
}

/// What the chosen technique says, before our `<spectrum>` is applied.
struct Reading {
    kind: LightKind,
    color: Vec3,
    spectrum: Emission,
    size: Option<(f32, f32)>,
    /// `color` is W per channel over the whole area.
    is_power: bool,
    is_cgl_area: bool,
}

impl Reading {
    fn new(kind: LightKind, color: Vec3) -> Self {
        Self { kind, color, spectrum: Emission::E, size: None, is_power: false, is_cgl_area: false }
    }
}

/// Reads a light, once per `<light>`.
pub fn load<'a>(loader: &mut Loader<'a>, light: Element<'a>) -> Result<LoadedLight, Fault> {
    if let Some(&known) = loader.lights.get(&light.index()) {
        return Ok(known);
    }
    let profile = match profile::of(loader, light) {
        Some(technique) => profile::lights::read(technique)?,
        None => LightProfile::default(),
    };
    let Reading { mut kind, color, mut spectrum, size, is_power, is_cgl_area } = read(loader, light, &profile)?;
    if let Some(given) = profile.spectrum {
        spectrum = given;
    }
    if let Some(given) = profile.radius_m {
        match &mut kind {
            LightKind::Point { falloff: Falloff::Attenuation { .. }, .. } => {
                let advice = "it is ignored: a lamp with a size falls off with 1/d^2";
                loader.warnings.add(light, "`radius_m` of a point light with attenuation", advice);
            }
            LightKind::Point { radius_m, .. } | LightKind::Spot { radius_m, .. } => *radius_m = given,
            _ => loader.warnings.add(light, "`radius_m` of a light that is neither point nor spot", "it is ignored"),
        }
    }
    if let Some(given) = profile.angle_deg {
        match &mut kind {
            LightKind::Directional { angle_deg } => *angle_deg = given,
            _ => loader.warnings.add(light, "`angle_deg` of a light that is not directional", "it is ignored"),
        }
    }
    let index = loader.document.lights.len();
    let id = light.attribute("id").unwrap_or_default().to_owned();
    loader.light_elements.push(light);
    loader.document.lights.push(Light { id, kind, color, spectrum });
    if is_power {
        loader.powers.push((index, color));
    }
    if is_cgl_area {
        loader.cgl_areas.insert(index);
    }
    let loaded = LoadedLight { index, size };
    loader.lights.insert(light.index(), loaded);
    Ok(loaded)
}

fn read<'a>(loader: &mut Loader<'a>, light: Element<'a>, profile: &LightProfile) -> Result<Reading, Fault> {
    if let Some(area) = &profile.area {
        let (color, is_power) = match area.strength {
            Strength::Radiance(radiance) => (radiance, false),
            Strength::Power(watts) => (Vec3::splat(watts), true),
        };
        return Ok(Reading { is_power, spectrum: area.spectrum.clone(), ..Reading::new(area.kind, color) });
    }
    let extra = technique(light, "blender").map(blender::light_extra).transpose()?.flatten();
    if let Some(technique) = technique(light, "CGL") {
        return source(loader, technique, None, &["ambient", "directional", "area", "point", "spot"]);
    }
    let Some(common) = light.child("technique_common") else {
        return Err(light.fault("this <light> has no <technique_common>"));
    };
    source(loader, common, extra.as_ref(), &["ambient", "directional", "point", "spot"])
}

/// The light source that is the technique's child.
fn source<'a>(
    loader: &mut Loader<'a>,
    technique: Element<'a>,
    extra: Option<&LightExtra>,
    kinds: &[&'static str],
) -> Result<Reading, Fault> {
    let Some(element) = technique.children().find(|child| kinds.contains(&child.name())) else {
        let name = technique.children().next().map_or("", |child| child.name());
        let fault = technique.fault(format!("no known kind of light here: <{name}>"));
        return Err(fault.suggest(name, kinds.iter().copied()));
    };
    let Some(color) = element.child("color") else {
        return Err(element.fault(format!("this <{}> has no <color>", element.name())));
    };
    let color = match numbers::floats(color)?.len() {
        4 => numbers::fixed::<4>(color).map(|[r, g, b, _]| Vec3::new(r, g, b))?,
        _ => Vec3::from(numbers::fixed::<3>(color)?),
    };
    if let Some(extra) = extra {
        return blender_light(loader, element, extra, color);
    }
    if technique.name() == "technique_common" && loader.blender.is_some_and(|version| version.writes_watts()) {
        if element.name() == "point" {
            let advice = "an area light cannot be told from a point light: export with Blender's profile";
            loader.warnings.add(element, "a point light from Blender without its extra data", advice);
        }
        return blender_light(loader, element, &blender::implied_extra(element)?, color);
    }
    let reading = match element.name() {
        "ambient" => Reading::new(LightKind::Ambient, color),
        "directional" => Reading::new(LightKind::Directional { angle_deg: 0.0 }, color),
        "area" => {
            let kind = LightKind::Area { shape: AreaShape::Rectangle, presence: Presence::Solid };
            Reading { is_cgl_area: true, ..Reading::new(kind, color) }
        }
        "point" => {
            let falloff = falloff(loader, element, false)?;
            Reading::new(LightKind::Point { radius_m: 0.0, falloff }, color)
        }
        _ => {
            let cone_deg = child_number(element, "falloff_angle")?.unwrap_or(180.0);
            let edge = SpotEdge::Exponent(child_number(element, "falloff_exponent")?.unwrap_or(0.0));
            let falloff = falloff(loader, element, false)?;
            Reading::new(LightKind::Spot { cone_deg: cone_deg.clamp(0.0, 180.0), edge, radius_m: 0.0, falloff }, color)
        }
    };
    Ok(reading)
}

/// Blender's type and size win over the element that it wrote. Since 2.80 the colour is in watts (the sun's in W/m2).
fn blender_light<'a>(
    loader: &mut Loader<'a>,
    element: Element<'a>,
    extra: &LightExtra,
    color: Vec3,
) -> Result<Reading, Fault> {
    let watts = loader.blender.is_some_and(|version| version.writes_watts());
    let radius_m = extra.radius * loader.meter;
    // Blender takes one unit for one metre whatever the scene's unit is: a lamp lights its scene alike at any scale.
    let m2_per_unit2 = loader.meter * loader.meter;
    // A sphere of P watts has the intensity P / 4 pi in every direction; a spot is not brighter for being narrow.
    let intensity = if watts { color / (4.0 * PI) } else { color };
    let intensity = match loader.options.falloff {
        FalloffRule::Collada => intensity,
        FalloffRule::Auto | FalloffRule::Physical => intensity * m2_per_unit2,
    };
    Ok(match extra.lamp {
        Lamp::Point => {
            let falloff = falloff(loader, element, true)?;
            Reading::new(LightKind::Point { radius_m, falloff }, intensity)
        }
        Lamp::Spot => {
            let falloff = falloff(loader, element, true)?;
            let cone_deg = extra.spot_size_deg.clamp(0.0, 180.0);
            let kind = LightKind::Spot { cone_deg, edge: SpotEdge::Blend(extra.spot_blend), radius_m, falloff };
            Reading::new(kind, intensity)
        }
        Lamp::Sun => Reading::new(LightKind::Directional { angle_deg: 0.0 }, color),
        Lamp::Hemi => Reading::new(LightKind::Ambient, color),
        Lamp::Area => {
            let kind = LightKind::Area { shape: extra.shape, presence: Presence::Ghost };
            let color = if watts { color * m2_per_unit2 } else { color };
            Reading { size: Some(extra.size), is_power: watts, ..Reading::new(kind, color) }
        }
    })
}

/// `by_blender`: the numbers are Blender's, which are not attenuations.
fn falloff<'a>(loader: &mut Loader<'a>, element: Element<'a>, by_blender: bool) -> Result<Falloff, Fault> {
    let constant = child_number(element, "constant_attenuation")?.unwrap_or(1.0);
    let linear = child_number(element, "linear_attenuation")?.unwrap_or(0.0);
    let quadratic = child_number(element, "quadratic_attenuation")?.unwrap_or(0.0);
    let is_default = (constant, linear, quadratic) == (1.0, 0.0, 0.0);
    let literal = match loader.options.falloff {
        FalloffRule::Auto => !is_default && !by_blender,
        FalloffRule::Physical => false,
        FalloffRule::Collada => true,
    };
    if !literal {
        if !is_default {
            let seen = format!("attenuation {constant} {linear} {quadratic} of a light");
            loader.warnings.add(element, seen, "it falls off with 1/d^2 (--light-falloff collada takes the numbers)");
        }
        return Ok(Falloff::Physical);
    }
    if constant < 0.0 || linear < 0.0 || quadratic < 0.0 || constant + linear + quadratic <= 0.0 {
        let message = format!("attenuation {constant} {linear} {quadratic} is not positive");
        return Err(element.fault(message));
    }
    // The file's numbers hold for distances in its own unit.
    let per_m = 1.0 / loader.meter;
    Ok(Falloff::Attenuation { constant, linear: linear * per_m, quadratic: quadratic * per_m * per_m })
}

fn child_number(element: Element, name: &str) -> Result<Option<f32>, Fault> {
    element.child(name).map(numbers::single).transpose()
}
