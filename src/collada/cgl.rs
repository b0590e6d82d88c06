//! The CS184 course dialect, `<technique profile="CGL">`: materials. Its lights are in `lights`, its sphere in `geometry`.

use glam::Vec3;

use crate::color::Index;
use crate::document::{
    Base, Distribution, Film, Material, Microfacets, Scalar, SurfaceEmission, Texture, Thickness, Tint,
};

use super::error::Fault;
use super::loader::Loader;
use super::materials;
use super::numbers;
use super::xml::Element;

const KINDS: [&str; 6] = ["emission", "mirror", "refraction", "glass", "microfacet", "thinfilm"];

/// Longest chain of films whose base is a film's material.
const BASE_LIMIT: usize = 8;

/// Thickness of a `<thinfilm>` that gives none.
const DEFAULT_THICKNESS_NM: f32 = 500.0;

/// The last known child counts, as in the course program.
pub fn material<'a>(loader: &mut Loader<'a>, technique: Element<'a>, depth: usize) -> Result<Material, Fault> {
    warn_unknown(loader, technique);
    let mut known = technique.children().filter(|child| KINDS.contains(&child.name()));
    let Some(first) = known.next() else {
        let names: Vec<&str> = technique.children().map(|child| child.name()).collect();
        let fault = technique.fault(format!("no known CGL material: <{}>", names.join(">, <")));
        return Err(fault.suggest(names.first().copied().unwrap_or_default(), KINDS));
    };
    let last = known.last().unwrap_or(first);
    if last.index() != first.index() {
        loader.warnings.add(
            technique,
            "several CGL materials in one effect",
            format!("the last one, <{}>, counts", last.name()),
        );
    }
    match last.name() {
        "emission" => emission(last),
        "mirror" => mirror(last),
        "refraction" => refraction(last),
        "glass" => glass(last),
        "microfacet" => microfacet(last),
        _ => thinfilm(loader, last, depth),
    }
}

/// Names the children that nobody reads.
pub fn warn_unknown<'a>(loader: &mut Loader<'a>, technique: Element<'a>) {
    for child in technique.children().filter(|child| !KINDS.contains(&child.name())) {
        loader.warnings.add(child, format!("unknown CGL material <{}>", child.name()), "it is ignored");
    }
}

fn surface(base: Base) -> Material {
    Material { base, ..Material::default() }
}

fn dielectric(ior: f32, fresnel: bool) -> Base {
    Base::Dielectric {
        index: Index::Constant { n: ior, k: 0.0 },
        microfacets: Microfacets::default(),
        absorption_per_m: Vec3::ZERO,
        fresnel,
        priority: None,
    }
}

fn required<'a>(element: Element<'a>, name: &str) -> Result<Element<'a>, Fault> {
    element.child(name).ok_or_else(|| element.fault(format!("this <{}> has no <{name}>", element.name())))
}

/// RGB, none negative.
fn rgb(element: Element) -> Result<Vec3, Fault> {
    let value = Vec3::from(numbers::fixed::<3>(element)?);
    if value.min_element() < 0.0 {
        return Err(element.fault_at_text(format!("<{}> is negative", element.name())));
    }
    Ok(value)
}

fn positive(element: Element) -> Result<f32, Fault> {
    let value = numbers::single(element)?;
    if value <= 0.0 {
        return Err(element.fault_at_text(format!("<{}> is {value}; it must be greater than 0", element.name())));
    }
    Ok(value)
}

fn emission(element: Element) -> Result<Material, Fault> {
    let radiance = rgb(required(element, "radiance")?)?;
    let emission =
        SurfaceEmission { radiance: Texture::constant(radiance), spectrum: Default::default(), two_sided: true };
    Ok(Material { emission: Some(emission), ..surface(Base::Black) })
}

fn mirror(element: Element) -> Result<Material, Fault> {
    let reflect = rgb(required(element, "reflectance")?)?;
    // With n = 0 nothing enters: |r| = 1 at every angle, for every k.
    let index = Index::Constant { n: 0.0, k: 1000.0 };
    let base = Base::Conductor { index, microfacets: Microfacets::default() };
    Ok(Material { tint: Tint { reflect, transmit: Vec3::ONE }, ..surface(base) })
}

fn refraction(element: Element) -> Result<Material, Fault> {
    let transmit = rgb(required(element, "transmittance")?)?;
    let ior = positive(required(element, "ior")?)?;
    Ok(Material { tint: Tint { reflect: Vec3::ONE, transmit }, ..surface(dielectric(ior, false)) })
}

fn glass(element: Element) -> Result<Material, Fault> {
    let transmit = rgb(required(element, "transmittance")?)?;
    let reflect = rgb(required(element, "reflectance")?)?;
    let ior = positive(required(element, "ior")?)?;
    Ok(Material { tint: Tint { reflect, transmit }, ..surface(dielectric(ior, true)) })
}

fn microfacet(element: Element) -> Result<Material, Fault> {
    let alpha = required(element, "alpha")?;
    let roughness = numbers::single(alpha)?;
    if !(0.0..=1.0).contains(&roughness) {
        return Err(alpha.fault_at_text(format!("<alpha> is {roughness}; it must lie in 0..1")));
    }
    let n = rgb(required(element, "eta")?)?.to_array();
    let k = rgb(required(element, "k")?)?.to_array();
    let microfacets = Microfacets { distribution: Distribution::Beckmann, roughness: Scalar::constant(roughness) };
    Ok(surface(Base::Conductor { index: Index::Rgb { n, k }, microfacets }))
}

/// A student extension: a film over another material, or over a smooth dielectric.
fn thinfilm<'a>(loader: &mut Loader<'a>, element: Element<'a>, depth: usize) -> Result<Material, Fault> {
    let ior = positive(required(element, "ior")?)?;
    let thickness = element.child("thickness");
    let nm = thickness.map(numbers::single).transpose()?.unwrap_or(DEFAULT_THICKNESS_NM);
    if let Some(thickness) = thickness.filter(|_| !(0.0..=50_000.0).contains(&nm)) {
        return Err(thickness.fault_at_text(format!("<thickness> is {nm} nm; it must lie in 0..50000")));
    }
    let mut material = match element.child("base_material") {
        Some(base) if depth == BASE_LIMIT => return Err(base.fault("<base_material> references run in a circle")),
        Some(base) => {
            let target = loader.follow(base, "target", &["material"])?;
            materials::read(loader, target, depth + 1)?
        }
        None => surface(dielectric(element.child("base_ior").map(positive).transpose()?.unwrap_or(1.0), true)),
    };
    if matches!(material.base, Base::Black) {
        return Err(element.fault("the base of this <thinfilm> only emits light, so it can have no film"));
    }
    material.tint.reflect *= element.child("reflectance").map(rgb).transpose()?.unwrap_or(Vec3::ONE);
    material.tint.transmit *= element.child("transmittance").map(rgb).transpose()?.unwrap_or(Vec3::ONE);
    let index = Index::Constant { n: ior, k: 0.0 };
    material.films.insert(0, Film { index, thickness: Thickness::Constant { nm }, weight: 1.0 });
    Ok(material)
}
