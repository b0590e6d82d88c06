//! What the target of a `<channel>` is.
//!
//! Addresses of COLLADA 1.4.1, chapter 3: `id/sid`, with `.X`, `.ANGLE`, `(i)` or `(column)(row)` for one of several numbers.
//! For what our profile writes as attributes: `id/ATTRIBUTE` and `id/CHILD/ATTRIBUTE`, below the base of an effect and below
//! `<environment>`, `<lens>`, `<area>` of other elements.

use crate::document::{CameraPart, EnvironmentPart, FilmPart, MaterialPart, Quantity};

use super::loader::{Loader, technique};
use super::nodes::NodeMemo;
use super::numbers;
use super::profile::PROFILE;
use super::transforms;
use super::xml::Element;

/// A resolved target.
#[derive(Default)]
pub struct Aim {
    /// Nothing where the scene has no such thing; several where materials share an effect.
    pub drives: Vec<Quantity>,
    /// One of the quantity's numbers; all without.
    pub member: Option<usize>,
    /// How many numbers the quantity has.
    count: usize,
}

impl Aim {
    /// Whether curves of `width` numbers fit.
    pub fn takes(&self, width: usize) -> Result<(), String> {
        let is_transform = matches!(self.drives.first(), Some(Quantity::Transform { .. }));
        let fits = match (self.member, self.count) {
            (Some(member), count) => width == 1 && member < count,
            // A colour may come with its alpha, or grey.
            (None, 3) if !is_transform => matches!(width, 1 | 3 | 4),
            (None, count) => width == count,
        };
        let wanted = if self.member.is_some() { 1 } else { self.count };
        if fits { Ok(()) } else { Err(format!("its keys have {width} numbers, the target takes {wanted}")) }
    }
}

pub fn resolve(loader: &Loader, target: &str) -> Aim {
    let Some((id, path)) = target.split_once('/') else { return Aim::default() };
    let (path, suffix) = split_member(path);
    let segments: Vec<&str> = path.split('/').collect();
    let Some(element) = loader.by_id(id, &["node", "camera", "light", "effect", "material", "visual_scene"]) else {
        return Aim::default();
    };
    let drives: Vec<Quantity> = match element.name() {
        "node" => transform(loader, element, &segments).into_iter().collect(),
        "camera" => camera(loader, element, &segments).into_iter().collect(),
        "light" => light(loader, element, &segments).into_iter().collect(),
        "visual_scene" => environment(&segments).into_iter().collect(),
        "material" => materials(loader, &segments, |material| material.index() == element.index()),
        _ => materials(loader, &segments, |material| uses(material, id)),
    };
    let numbers = |quantity: &Quantity| loader.document.numbers(*quantity).map(|numbers| numbers.len());
    let drives: Vec<Quantity> = drives.into_iter().filter(|quantity| numbers(quantity).is_some()).collect();
    let Some(count) = drives.first().and_then(numbers) else { return Aim::default() };
    match suffix {
        None => Aim { drives, member: None, count },
        Some(suffix) => match member(suffix, count) {
            Some(member) => Aim { drives, member: Some(member), count },
            None => Aim::default(),
        },
    }
}

/// Cuts `.X` or `(3)(0)` off the last segment.
fn split_member(path: &str) -> (&str, Option<&str>) {
    let last = path.rfind('/').map_or(0, |slash| slash + 1);
    match path[last..].find(['.', '(']) {
        Some(at) => (&path[..last + at], Some(&path[last + at..])),
        None => (path, None),
    }
}

/// Which of `count` numbers a suffix means. A matrix is written row by row and addressed by column and row.
fn member(suffix: &str, count: usize) -> Option<usize> {
    if let Some(name) = suffix.strip_prefix('.') {
        return match name {
            "X" | "R" | "U" | "S" => Some(0),
            "Y" | "G" | "V" | "T" => Some(1),
            "Z" | "B" | "P" => Some(2),
            "W" | "A" => Some(3),
            "ANGLE" if count == 7 => Some(0),
            "ANGLE" => Some(3),
            _ => None,
        };
    }
    let inner = suffix.strip_prefix('(')?.strip_suffix(')')?;
    match inner.split_once(")(") {
        None => inner.parse().ok(),
        Some((column, row)) if count == 16 => {
            let [column, row]: [usize; 2] = [column.parse().ok()?, row.parse().ok()?];
            (column < 4 && row < 4).then_some(4 * row + column)
        }
        Some(_) => None,
    }
}

/// The first element below that has this sid, nearest first.
fn by_sid<'a>(element: Element<'a>, sid: &str) -> Option<Element<'a>> {
    let mut level: Vec<Element> = element.children().collect();
    while !level.is_empty() {
        if let Some(found) = level.iter().find(|candidate| candidate.attribute("sid") == Some(sid)) {
            return Some(*found);
        }
        level = level.iter().flat_map(|candidate| candidate.children()).collect();
    }
    None
}

fn transform(loader: &Loader, node: Element, segments: &[&str]) -> Option<Quantity> {
    let element = segments.iter().try_fold(node, |scope, sid| by_sid(scope, sid))?;
    let owner = element.parent()?;
    let Some(NodeMemo::Done(placed)) = loader.nodes.get(&owner.index()) else { return None };
    let mut siblings = owner.children().filter(|child| transforms::NAMES.contains(&child.name()));
    let transform = siblings.position(|sibling| sibling.index() == element.index())?;
    Some(Quantity::Transform { node: placed.index, transform })
}

fn camera(loader: &Loader, element: Element, segments: &[&str]) -> Option<Quantity> {
    let camera = *loader.cameras.get(&element.index())?;
    let part = match *segments {
        ["lens", attribute] => {
            let focal = || technique(element, PROFILE)?.child("lens")?.attribute("focal_mm")?.parse().ok();
            match attribute {
                "focus_distance_m" => CameraPart::FocusDistance,
                "aperture_radius_m" => CameraPart::ApertureRadius,
                "f_number" => CameraPart::FNumber { focal_mm: focal()? },
                _ => return None,
            }
        }
        // Blender and others give the sid of the element's own name.
        [.., sid] => match by_sid(element, sid).map_or(sid, |found| found.name()) {
            "xfov" => CameraPart::XFov,
            "yfov" => CameraPart::YFov,
            "xmag" => CameraPart::XMag,
            "ymag" => CameraPart::YMag,
            _ => return None,
        },
        [] => return None,
    };
    Some(Quantity::Camera { camera, part })
}

fn light(loader: &Loader, element: Element, segments: &[&str]) -> Option<Quantity> {
    let light = loader.lights.get(&element.index())?.index;
    let strongest = loader.document.lights[light].color.max_element();
    let area = || technique(element, PROFILE)?.child("area");
    let written = match *segments {
        ["area", attribute @ ("radiance" | "power_w")] => numbers_in(area()?.attribute(attribute)?),
        [.., sid] if area().is_none() => {
            let color = by_sid(element, sid).or_else(|| color_of(element)).filter(|found| found.name() == "color")?;
            if sid != "color" && color.attribute("sid") != Some(sid) {
                return None;
            }
            numbers_in(&color.text())
        }
        _ => return None,
    };
    // The file's numbers may be watts, or meant for another falloff: what the loader made of them tells the factor.
    let written = written.into_iter().take(3).fold(0.0, f32::max);
    (written > 0.0 && strongest > 0.0).then_some(Quantity::LightColor { light, scale: strongest / written })
}

/// The `<color>` of a light's kind.
fn color_of(light: Element) -> Option<Element> {
    light.child("technique_common")?.children().find_map(|kind| kind.child("color"))
}

fn numbers_in(text: &str) -> Vec<f32> {
    numbers::Tokens::new(0, text).filter_map(|(_, token)| token.parse().ok()).collect()
}

fn environment(segments: &[&str]) -> Option<Quantity> {
    let part = match *segments {
        ["environment", "radiance"] => EnvironmentPart::Radiance,
        ["environment", "strength"] => EnvironmentPart::Strength,
        ["environment", "rotation_deg"] => EnvironmentPart::Rotation,
        _ => return None,
    };
    Some(Quantity::Environment(part))
}

fn uses(material: Element, effect: &str) -> bool {
    let url = material.child("instance_effect").and_then(|instance| instance.attribute("url"));
    url.and_then(|url| url.strip_prefix('#')) == Some(effect)
}

/// The same part of every material that is wanted.
fn materials(loader: &Loader, segments: &[&str], wanted: impl Fn(Element) -> bool) -> Vec<Quantity> {
    let mut found: Vec<usize> = Vec::new();
    let mut common = None;
    for (&index, &material) in &loader.materials {
        let element = Element::new(loader.xml, index);
        if wanted(element) {
            found.push(material);
            let instance = element.child("instance_effect");
            common = instance.and_then(|instance| loader.follow(instance, "url", &["effect"]).ok());
        }
    }
    found.sort_unstable();
    let Some(effect) = common else { return Vec::new() };
    let is_plain = technique(effect, PROFILE).is_none() && technique(effect, "CGL").is_none();
    let quantity = |material: usize| {
        if is_plain {
            return common_part(effect, segments).map(|part| Quantity::Material { material, part });
        }
        profile_part(material, segments)
    };
    found.into_iter().filter_map(quantity).collect()
}

/// A colour of the common profile, by its sid.
fn common_part(effect: Element, segments: &[&str]) -> Option<MaterialPart> {
    let color = by_sid(effect, segments.last()?).filter(|found| found.name() == "color")?;
    match color.parent()?.name() {
        "diffuse" => Some(MaterialPart::Reflectance),
        "emission" => Some(MaterialPart::Emission),
        _ => None,
    }
}

/// An attribute of our profile, below the base.
fn profile_part(material: usize, segments: &[&str]) -> Option<Quantity> {
    let part = |part| Some(Quantity::Material { material, part });
    let (film, rest) = match *segments {
        ["reflectance"] => return part(MaterialPart::Reflectance),
        ["roughness"] => return part(MaterialPart::Roughness),
        ["absorption_per_m"] => return part(MaterialPart::Absorption),
        ["radiance"] => return part(MaterialPart::Emission),
        [film, ref rest @ ..] => (film, rest),
        [] => return None,
    };
    let film = match film.strip_prefix("film")? {
        "" => 0,
        index => index.strip_prefix('(')?.strip_suffix(')')?.parse().ok()?,
    };
    let part = match *rest {
        ["thickness_nm"] => FilmPart::Thickness,
        ["weight"] => FilmPart::Weight,
        ["ior"] => FilmPart::Ior,
        ["noise", "amplitude"] => FilmPart::Amplitude,
        ["drain", "top_nm"] => FilmPart::Top,
        ["drain", "bottom_nm"] => FilmPart::Bottom,
        ["map", "min_nm"] => FilmPart::Min,
        ["map", "max_nm"] => FilmPart::Max,
        _ => return None,
    };
    Some(Quantity::Film { material, film, part })
}
