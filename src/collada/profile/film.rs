//! `<film>`: one homogeneous layer, its thickness constant or varying.

use crate::collada::error::Fault;
use crate::collada::loader::Loader;
use crate::collada::xml::Element;
use crate::color::{Index, Kind};
use crate::document::{Film, Knob, Preset, THICKEST_NM, Thickness};

use super::index::{named, names};
use super::maps;
use super::strict::{Bounds, Strict, at_most_one};

/// The children of a film that make its thickness vary.
pub const VARYING: [&str; 3] = ["noise", "drain", "map"];

/// All `<film>` children of a base, outermost first.
pub fn stack<'a>(loader: &mut Loader<'a>, base: Element<'a>, user: &str) -> Result<Vec<Film>, Fault> {
    let mut films = Vec::new();
    let mut varies = false;
    for element in base.children_named("film") {
        let read = match element.attribute("preset") {
            Some(_) => preset_films(loader, element, user)?,
            None => vec![read(loader, element, user)?],
        };
        let varying = read.iter().any(|film| !matches!(film.thickness, Thickness::Constant { .. }));
        if varying && varies {
            let fault = element.fault("a second film of this stack varies in thickness");
            return Err(fault.hint("one film of a stack may have <noise>, <drain> or <map>; the others are constant"));
        }
        varies |= varying;
        films.extend(read);
    }
    Ok(films)
}

/// The films of a named surface, on another base.
fn preset_films<'a>(loader: &mut Loader<'a>, element: Element<'a>, user: &str) -> Result<Vec<Film>, Fault> {
    let mut strict = Strict::new(element);
    let named = preset(&mut strict, "preset")?;
    let named = strict.required("preset", named)?;
    let mut films = of_preset(loader, &mut strict, named, user)?;
    // The weights of a stack are multiplied: one of them says it all.
    if let (Some(weight), Some(film)) = (strict.number("weight", Bounds::Within(0.0, 1.0))?, films.first_mut()) {
        film.weight = weight;
    }
    strict.finish(&VARYING)?;
    Ok(films)
}

/// The preset that an attribute names.
pub fn preset(strict: &mut Strict, attribute: &'static str) -> Result<Option<&'static Preset>, Fault> {
    let Some(name) = strict.text(attribute) else { return Ok(None) };
    let fault = || strict.element.fault_at_value(attribute, format!("unknown preset `{name}`"));
    let known = || Preset::all().iter().map(|preset| preset.name);
    Preset::find(name).map(Some).ok_or_else(|| fault().suggest(name, known()))
}

/// The films of a preset, from its own number; a single one may vary.
pub fn of_preset<'a>(
    loader: &mut Loader<'a>,
    strict: &mut Strict<'a>,
    preset: &'static Preset,
    user: &str,
) -> Result<Vec<Film>, Fault> {
    let Knob { name, least, most, default } = preset.knob;
    let value = strict.number(name, Bounds::Within(least, most))?.unwrap_or(default);
    let mut films = preset.films(value);
    let element = strict.element;
    match (at_most_one(element, &VARYING)?, films.as_mut_slice()) {
        (None, _) => {}
        (Some(varying), [Film { thickness: Thickness::Constant { nm }, .. }]) => {
            films[0].thickness = vary(loader, varying, *nm, user)?;
        }
        (Some(varying), _) => {
            let message = format!("`{}` has {} layers, which cannot vary", preset.name, films.len());
            return Err(varying.fault(message).hint("presets of one layer can"));
        }
    }
    Ok(films)
}

fn read<'a>(loader: &mut Loader<'a>, element: Element<'a>, user: &str) -> Result<Film, Fault> {
    let mut strict = Strict::new(element);
    let nm = thickness_nm(&mut strict, "thickness_nm")?;
    let material = named(&mut strict, "material", None)?;
    let ior = strict.number("ior", Bounds::Within(0.01, 10.0))?;
    let k = strict.number("k", Bounds::AtLeast(0.0))?;
    let weight = strict.number("weight", Bounds::Within(0.0, 1.0))?.unwrap_or(1.0);
    strict.not_both("material", "ior")?;
    strict.not_both("material", "k")?;
    let index = match (material, ior) {
        (Some(material), _) => material,
        (None, Some(n)) => Index::Constant { n, k: k.unwrap_or(0.0) },
        (None, None) => {
            let fault = element.fault("<film> has neither `ior` nor `material`");
            let films: Vec<&str> = names(Some(Kind::Film)).collect();
            return Err(fault.hint(format!("materials: {}, and every glass and metal", films.join(", "))));
        }
    };
    let required = || strict.required("thickness_nm", nm);
    let thickness = match at_most_one(element, &VARYING)? {
        None => Thickness::Constant { nm: required()? },
        Some(varying) => {
            if nm.is_some() && varying.name() != "noise" {
                let seen = format!("`thickness_nm` of a <film> whose thickness comes from <{}>", varying.name());
                loader.warnings.add(element, seen, "it has no meaning there and is ignored");
            }
            let nm = if varying.name() == "noise" { required()? } else { 0.0 };
            vary(loader, varying, nm, user)?
        }
    };
    strict.finish(&VARYING)?;
    Ok(Film { index, thickness, weight })
}

/// What makes a film's thickness vary; `nm` is what noise varies.
fn vary<'a>(loader: &mut Loader<'a>, element: Element<'a>, nm: f32, user: &str) -> Result<Thickness, Fault> {
    match element.name() {
        "noise" => noise(element, nm),
        "drain" => drain(element),
        _ => map(loader, element, user),
    }
}

/// 0, or 1 to the limit: a film of a fraction of a nanometre is a film in micrometres.
fn thickness_nm(strict: &mut Strict, name: &'static str) -> Result<Option<f32>, Fault> {
    let Some(value) = strict.number(name, Bounds::AtLeast(0.0))? else { return Ok(None) };
    let fault = |message: String| strict.element.fault_at_value(name, message);
    if value > 0.0 && value < 1.0 {
        let hint = format!("did you mean um? {value} um are {} nm", value * 1000.0);
        return Err(fault(format!("`{name}` is {value}; it must be 0 or lie in 1..{THICKEST_NM}")).hint(hint));
    }
    if value > THICKEST_NM {
        let hint = format!("did you mean um? the limit is {} um", THICKEST_NM / 1000.0);
        return Err(fault(format!("`{name}` is {value}; it must lie in 0..{THICKEST_NM}")).hint(hint));
    }
    Ok(Some(value))
}

fn noise(element: Element, nm: f32) -> Result<Thickness, Fault> {
    let mut strict = Strict::new(element);
    let noise = Thickness::Noise {
        nm,
        amplitude: strict.number("amplitude", Bounds::Within(0.0, 1.0))?.unwrap_or(0.025),
        frequency: strict.number("frequency", Bounds::AtLeast(0.0))?.unwrap_or(4.0),
        octaves: strict.whole("octaves", 1, 16)?.unwrap_or(1),
        seed: strict.whole("seed", 0, u32::MAX)?.unwrap_or(0),
    };
    strict.finish(&[])?;
    Ok(noise)
}

fn drain(element: Element) -> Result<Thickness, Fault> {
    let mut strict = Strict::new(element);
    let top_nm = thickness_nm(&mut strict, "top_nm")?;
    let top_nm = strict.required("top_nm", top_nm)?;
    let bottom_nm = thickness_nm(&mut strict, "bottom_nm")?;
    let bottom_nm = strict.required("bottom_nm", bottom_nm)?;
    let exponent = strict.number("exponent", Bounds::Positive)?.unwrap_or(1.0);
    strict.finish(&[])?;
    Ok(Thickness::Drain { top_nm, bottom_nm, exponent })
}

fn map<'a>(loader: &mut Loader<'a>, element: Element<'a>, user: &str) -> Result<Thickness, Fault> {
    let mut strict = Strict::new(element);
    let mut map = maps::image(loader, &mut strict, user)?;
    let min_nm = thickness_nm(&mut strict, "min_nm")?;
    let min_nm = strict.required("min_nm", min_nm)?;
    let max_nm = thickness_nm(&mut strict, "max_nm")?;
    let max_nm = strict.required("max_nm", max_nm)?;
    map.channel = maps::channel(&mut strict)?.unwrap_or_default();
    strict.finish(&[])?;
    Ok(Thickness::Map { min_nm, max_nm, map })
}
