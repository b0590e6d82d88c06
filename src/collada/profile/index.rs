//! Refractive indices: named materials, constants, RGB triples, tables over wavelength.

use crate::collada::error::Fault;
use crate::collada::xml::Element;
use crate::color::{Index, Kind, kind_of_index, known_index_names};

use super::strict::{Bounds, Strict};

/// A value over wavelength as it was written.
enum Spectrum {
    Constant(f32),
    Rgb([f32; 3]),
    /// (nm, value), increasing wavelengths.
    Table(Vec<(f32, f32)>),
}

/// Known names of one kind, or all of them.
pub fn names(kind: Option<Kind>) -> impl Iterator<Item = &'static str> {
    let fits = move |name: &str| kind.is_none() || kind_of_index(name) == kind;
    known_index_names().iter().copied().filter(move |name| fits(name))
}

/// A material by its name, in any case, of one kind or of any.
pub fn named(strict: &mut Strict, attribute: &'static str, kind: Option<Kind>) -> Result<Option<Index>, Fault> {
    let Some(given) = strict.text(attribute) else { return Ok(None) };
    if let Some(name) = names(kind).find(|name| name.eq_ignore_ascii_case(given)) {
        return Ok(Some(Index::Named(name.to_owned())));
    }
    let fault = strict.element.fault_at_value(attribute, format!("unknown {attribute} `{given}`"));
    Err(fault.suggest(given, names(kind)))
}

/// `metal`, or `eta` with `k`.
pub fn conductor(strict: &mut Strict) -> Result<Index, Fault> {
    let metal = named(strict, "metal", Some(Kind::Metal))?;
    let eta = spectrum(strict, "eta", Bounds::Positive)?;
    let k = spectrum(strict, "k", Bounds::AtLeast(0.0))?;
    strict.not_both("metal", "eta")?;
    strict.not_both("metal", "k")?;
    match (metal, eta, k) {
        (Some(metal), _, _) => Ok(metal),
        (None, Some(eta), Some(k)) => combine(strict.element, eta, k),
        (None, Some(_), None) => Err(strict.element.fault("<conductor> has `eta` but no `k`")),
        (None, None, Some(_)) => Err(strict.element.fault("<conductor> has `k` but no `eta`")),
        (None, None, None) => {
            let fault = strict.element.fault("<conductor> has neither `metal` nor `eta` and `k`");
            Err(fault.hint(format!("metals: {}", names(Some(Kind::Metal)).collect::<Vec<_>>().join(", "))))
        }
    }
}

fn combine(element: Element, eta: Spectrum, k: Spectrum) -> Result<Index, Fault> {
    match (eta, k) {
        (Spectrum::Constant(n), Spectrum::Constant(k)) => Ok(Index::Constant { n, k }),
        (Spectrum::Rgb(n), Spectrum::Rgb(k)) => Ok(Index::Rgb { n, k }),
        (Spectrum::Table(eta), Spectrum::Table(k)) => {
            let mut nodes: Vec<f32> = eta.iter().chain(&k).map(|&(nm, _)| nm).collect();
            nodes.sort_by(f32::total_cmp);
            nodes.dedup();
            Ok(Index::Table(nodes.into_iter().map(|nm| (nm, interpolate(&eta, nm), interpolate(&k, nm))).collect()))
        }
        _ => {
            let fault = element.fault_at_value("k", "`eta` and `k` are written in different forms");
            Err(fault.hint("both are RGB triples, or both are `nm:value` lists"))
        }
    }
}

/// Linear between nodes, constant beyond the ends. The table is not empty.
fn interpolate(table: &[(f32, f32)], nm: f32) -> f32 {
    let after = table.partition_point(|&(node, _)| node < nm);
    match (after.checked_sub(1).and_then(|before| table.get(before)), table.get(after)) {
        (Some(&(nm0, v0)), Some(&(nm1, v1))) => v0 + (v1 - v0) * (nm - nm0) / (nm1 - nm0),
        (Some(&(_, value)), None) | (None, Some(&(_, value))) => value,
        (None, None) => 0.0,
    }
}

fn spectrum(strict: &mut Strict, name: &'static str, bounds: Bounds) -> Result<Option<Spectrum>, Fault> {
    let element = strict.element;
    if element.attribute(name).is_some_and(|text| text.contains(':')) {
        return Ok(table(strict, name, bounds)?.map(Spectrum::Table));
    }
    match strict.numbers(name, bounds)?.as_deref() {
        None => Ok(None),
        Some(&[value]) => Ok(Some(Spectrum::Constant(value))),
        Some(&[r, g, b]) => Ok(Some(Spectrum::Rgb([r, g, b]))),
        Some(values) => {
            let message =
                format!("`{name}` takes 3 numbers (red, green, blue) or a `nm:value` list, here are {}", values.len());
            Err(element.fault_at_value(name, message))
        }
    }
}

/// A `nm:value` list with increasing wavelengths.
pub fn table(strict: &mut Strict, name: &'static str, bounds: Bounds) -> Result<Option<Vec<(f32, f32)>>, Fault> {
    let element = strict.element;
    let Some(text) = strict.text(name) else { return Ok(None) };
    let mut nodes: Vec<(f32, f32)> = Vec::new();
    for token in text.split_whitespace() {
        let fault = |message: String| element.fault_at_value(name, message);
        let pair = token.split_once(':').and_then(|(nm, value)| Some((nm.parse().ok()?, value.parse().ok()?)));
        let Some((nm, value)) = pair else {
            return Err(
                fault(format!("`{name}`: `{token}` is not a `nm:value` pair")).hint("for example `450:1.2 550:1.1`")
            );
        };
        bounds.accept(value).map_err(|message| fault(format!("`{name}` is {value} at {nm} nm; {message}")))?;
        Bounds::Within(100.0, 20000.0)
            .accept(nm)
            .map_err(|message| fault(format!("`{name}` has the wavelength {nm} nm; {message}")))?;
        if nodes.last().is_some_and(|&(last, _)| last >= nm) {
            return Err(fault(format!("`{name}`: the wavelengths do not increase at {nm} nm")));
        }
        nodes.push((nm, value));
    }
    if nodes.is_empty() {
        return Err(element.fault_at_value(name, format!("`{name}` is empty")));
    }
    Ok(Some(nodes))
}
