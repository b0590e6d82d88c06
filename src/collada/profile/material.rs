//! The bases: `<diffuse>`, `<conductor>`, `<dielectric>`, `<emitter>`, and `<preset>`, which brings films along.

use glam::Vec3;

use crate::collada::error::Fault;
use crate::collada::loader::Loader;
use crate::collada::xml::Element;
use crate::color::{Index, Kind};
use crate::document::{
    Base, Distribution, Encoding, Film, Map, Material, Microfacets, Scalar, SurfaceEmission, Texture,
};

use super::film;
use super::index::{self, named};
use super::maps;
use super::spectrum;
use super::strict::{Bounds, Strict, at_most_one, only_children};

pub const BASES: [&str; 5] = ["diffuse", "conductor", "dielectric", "emitter", "preset"];

/// Children that a base with a surface may have.
pub const SURFACE_CHILDREN: [&str; 4] = ["film", "map", "normal_map", "opacity"];

/// Reads the technique of an effect. `user` names the material for messages.
pub fn read<'a>(loader: &mut Loader<'a>, technique: Element<'a>, user: &str) -> Result<Material, Fault> {
    only_children(technique, &BASES)?;
    let Some(base) = at_most_one(technique, &BASES)? else {
        let fault = technique.fault("this technique holds no base");
        return Err(fault.hint("one of <diffuse>, <conductor>, <dielectric>, <emitter>, <preset>"));
    };
    let mut material = Material::default();
    if base.name() == "emitter" {
        material.base = Base::Black;
        material.emission = Some(emitter(base)?);
        return Ok(material);
    }
    if base.name() != "preset" {
        material.films = film::stack(loader, base, user)?;
    }
    if let Some(element) = at_most_one(base, &["normal_map"])? {
        material.normal_map = Some(maps::normal_map(loader, element, user)?);
    }
    if let Some(element) = at_most_one(base, &["opacity"])? {
        material.opacity = maps::opacity(loader, element, user)?;
    }
    material.base = match base.name() {
        "diffuse" => diffuse(loader, base, user)?,
        "conductor" => conductor(loader, base, user)?,
        "preset" => preset(loader, base, user, &mut material.films)?,
        _ => dielectric(loader, base, user)?,
    };
    Ok(material)
}

fn emitter(element: Element) -> Result<SurfaceEmission, Fault> {
    if let Some(film) = element.child("film") {
        let fault = film.fault("an <emitter> reflects nothing, so it can have no <film>");
        return Err(fault.hint("put the film on a <diffuse>, <conductor> or <dielectric>"));
    }
    let mut strict = Strict::new(element);
    let radiance = strict.rgb("radiance", Bounds::AtLeast(0.0))?.unwrap_or(Vec3::ONE);
    let spectrum = spectrum::read(&mut strict, "spectrum")?.unwrap_or_default();
    let two_sided = strict.flag("two_sided")?.unwrap_or(true);
    strict.finish(&[])?;
    Ok(SurfaceEmission { radiance: Texture::constant(radiance), spectrum, two_sided })
}

fn diffuse<'a>(loader: &mut Loader<'a>, element: Element<'a>, user: &str) -> Result<Base, Fault> {
    let mut strict = Strict::new(element);
    let value = strict.rgb("reflectance", Bounds::Within(0.0, 1.0))?;
    let ior = strict.number("ior", Bounds::Within(1.0, 5.0))?.unwrap_or(1.5);
    let map = maps::base_map(loader, element, "reflectance", Encoding::Srgb, user)?;
    // With an image, an explicit value tints it.
    let value = value.unwrap_or(if map.is_some() { Vec3::ONE } else { Vec3::splat(0.5) });
    strict.finish(&SURFACE_CHILDREN)?;
    Ok(Base::Diffuse { reflectance: Texture { value, map }, ior })
}

fn conductor<'a>(loader: &mut Loader<'a>, element: Element<'a>, user: &str) -> Result<Base, Fault> {
    let mut strict = Strict::new(element);
    let index = index::conductor(&mut strict)?;
    let map = maps::base_map(loader, element, "roughness", Encoding::Linear, user)?;
    let microfacets = microfacets(&mut strict, map)?;
    strict.finish(&SURFACE_CHILDREN)?;
    Ok(Base::Conductor { index, microfacets })
}

fn dielectric<'a>(loader: &mut Loader<'a>, element: Element<'a>, user: &str) -> Result<Base, Fault> {
    let mut strict = Strict::new(element);
    let ior = strict.number("ior", Bounds::Within(1.0, 5.0))?;
    let glass = named(&mut strict, "glass", Some(Kind::Glass))?;
    strict.not_both("glass", "ior")?;
    let index = glass.unwrap_or(Index::Constant { n: ior.unwrap_or(1.5), k: 0.0 });
    let map = maps::base_map(loader, element, "roughness", Encoding::Linear, user)?;
    let microfacets = microfacets(&mut strict, map)?;
    let absorption_per_m = strict.rgb("absorption_per_m", Bounds::AtLeast(0.0))?.unwrap_or(Vec3::ZERO);
    let priority = strict.whole("priority", 0, u32::from(u8::MAX))?.map(|priority| priority as u8);
    strict.finish(&SURFACE_CHILDREN)?;
    Ok(Base::Dielectric { index, microfacets, absorption_per_m, fresnel: true, priority })
}

/// A named surface, with its films.
fn preset<'a>(loader: &mut Loader<'a>, element: Element<'a>, user: &str, films: &mut Vec<Film>) -> Result<Base, Fault> {
    let mut strict = Strict::new(element);
    let named = film::preset(&mut strict, "name")?;
    let named = strict.required("name", named)?;
    *films = film::of_preset(loader, &mut strict, named, user)?;
    let mut base = named.base();
    if let Base::Conductor { microfacets: own, .. } | Base::Dielectric { microfacets: own, .. } = &mut base {
        // A map in a preset is that of its film.
        *own = microfacets(&mut strict, None)?;
    }
    let children: Vec<&str> = film::VARYING.into_iter().chain(["normal_map", "opacity"]).collect();
    strict.finish(&children)?;
    Ok(base)
}

fn microfacets(strict: &mut Strict, map: Option<Map>) -> Result<Microfacets, Fault> {
    let value = strict.number("roughness", Bounds::Within(0.0, 1.0))?.unwrap_or(0.0);
    let words = [("ggx", Distribution::Ggx), ("beckmann", Distribution::Beckmann)];
    let distribution = strict.choice("distribution", &words)?.unwrap_or_default();
    Ok(Microfacets { distribution, roughness: Scalar::mapped(value, map) })
}
