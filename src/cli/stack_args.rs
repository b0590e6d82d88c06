//! Options about a stack of films, shared by the commands that study one.

use clap::Args;

use super::say;
use crate::color::Emission;
use crate::document::{Knob, Preset};
use crate::error::Error;
use crate::study::{Coating, Medium, StudyError};

#[derive(Args)]
pub struct StackArgs {
    /// The medium that light comes from [default: 1]
    #[arg(long, value_name = "INDEX", value_parser = Medium::parse, allow_negative_numbers = true)]
    ambient: Option<Medium>,
    /// A layer and its thickness in nm, outermost first (repeatable); none is a bare surface
    #[arg(long = "layer", value_name = "INDEX,NM", value_parser = layer, allow_hyphen_values = true)]
    layers: Vec<Layer>,
    /// A named surface (see --list), and the number that it follows: a voltage, a thickness
    #[arg(long, value_name = "NAME[:NUMBER]", value_parser = preset, conflicts_with_all = ["ambient", "layers", "base"])]
    preset: Option<Chosen>,
    /// The medium under the layers
    #[arg(long, value_name = "INDEX", value_parser = Medium::parse, allow_negative_numbers = true)]
    base: Option<Medium>,
}

#[derive(Clone)]
struct Layer {
    medium: Medium,
    nm: f64,
}

/// A preset with the value of its knob.
#[derive(Clone)]
struct Chosen {
    preset: &'static Preset,
    value: f32,
}

/// Numbers that were written with commas and ranges.
#[derive(Clone)]
pub struct List(pub Vec<f64>);

/// Values beyond which a list is a slip of the pen.
pub(super) const MOST_VALUES: usize = 10_000_000;
/// A light path through an ambient with more absorption than this has no reflectance to speak of.
const MOST_AMBIENT_K: f64 = 1e-3;

impl StackArgs {
    /// True where nothing was asked for.
    pub fn is_empty(&self) -> bool {
        self.ambient.is_none() && self.layers.is_empty() && self.base.is_none() && self.preset.is_none()
    }

    /// The stack; `used_nm` are the first and the last wavelength that matter.
    pub fn coating(&self, used_nm: [f64; 2]) -> Result<Coating, Error> {
        if let Some(Chosen { preset, value }) = &self.preset {
            return Coating::of_preset(preset, *value).map_err(|error| Error::Usage(error.to_string()));
        }
        let Some(base) = &self.base else {
            let fix = "--base missing: give the medium under the layers, like `--base 1.5` or `--base Au`; or --preset; or \
                       --scene with --material; or --list";
            return Err(Error::Usage(fix.to_owned()));
        };
        let ambient = match &self.ambient {
            Some(medium) => medium.clone(),
            None => Medium::parse("1").map_err(|error| Error::Usage(error.to_string()))?,
        };
        if ambient.curve.max_k() > MOST_AMBIENT_K {
            let (label, k) = (&ambient.label, ambient.curve.max_k());
            let problem = format!("--ambient {label}: light cannot arrive through an absorbing medium (k up to {k})");
            return Err(Error::Usage(format!("{problem}; give a transparent one, like `--ambient 1.5`")));
        }
        let layers: Vec<(Medium, f64)> = self.layers.iter().map(|layer| (layer.medium.clone(), layer.nm)).collect();
        for medium in layers.iter().map(|layer| &layer.0).chain([&ambient, base]) {
            note_coverage(medium, used_nm);
        }
        Ok(Coating::new(&ambient, &layers, base))
    }
}

/// Says where a file's end values stand in for missing ones.
fn note_coverage(medium: &Medium, used_nm: [f64; 2]) {
    let Some((first, last)) = medium.covers_nm else { return };
    if used_nm[0] < first || used_nm[1] > last {
        say(&format!("note: {} covers {first}..{last} nm; outside its end values are used", medium.label));
    }
}

/// The least and the greatest of some numbers.
pub(super) fn ends(values: &[f64]) -> [f64; 2] {
    [values.iter().copied().fold(f64::INFINITY, f64::min), values.iter().copied().fold(0.0, f64::max)]
}

/// The same, where they differ.
pub(super) fn span(values: &[f64]) -> Option<[f64; 2]> {
    let [low, high] = ends(values);
    (high > low).then_some([low, high])
}

/// `NAME` or `NAME:NUMBER`
fn preset(text: &str) -> Result<Chosen, String> {
    let (name, value) = text.split_once(':').map_or((text, None), |(name, value)| (name, Some(value)));
    let Some(preset) = Preset::find(name) else {
        let names: Vec<&str> = Preset::all().iter().map(|preset| preset.name).collect();
        return Err(format!("unknown preset; known are {}", names.join(", ")));
    };
    let Knob { name, least, most, default } = preset.knob;
    let value = value.map_or(Ok(f64::from(default)), number)? as f32;
    if !(least..=most).contains(&value) {
        return Err(format!("{name} is {value}; it must lie in {least}..{most}"));
    }
    Ok(Chosen { preset, value })
}

/// `INDEX,NM`
fn layer(text: &str) -> Result<Layer, String> {
    let missing = || "thickness missing; write INDEX,NM with the thickness in nm, like 1.33,250".to_owned();
    let (index, nm) = text.rsplit_once(',').ok_or_else(missing)?;
    if nm.trim().is_empty() {
        return Err(missing());
    }
    let nm = number(nm).map_err(|reason| format!("thickness {reason}"))?;
    if nm < 0.0 {
        return Err(format!("the thickness {nm} nm is negative; give 0 or more"));
    }
    let medium = Medium::parse(index).map_err(|error: StudyError| error.to_string())?;
    Ok(Layer { medium, nm })
}

pub(super) fn angles(text: &str) -> Result<List, String> {
    list(text, |angle| (0.0..=90.0).contains(&angle), "is not an angle of incidence; give degrees from 0 to 90")
}

pub(super) fn thicknesses(text: &str) -> Result<List, String> {
    list(text, |nm| nm >= 0.0, "is not a thickness; give 0 nm or more")
}

/// Numbers and `start:stop:step` ranges with commas between them; each value must be `fit`.
pub(super) fn list(text: &str, fit: impl Fn(f64) -> bool, otherwise: &str) -> Result<List, String> {
    let mut values = Vec::new();
    for item in text.split(',') {
        let parts: Vec<&str> = item.split(':').collect();
        match parts.as_slice() {
            [value] => values.push(number(value)?),
            [start, stop, step] => {
                let (start, stop, step) = (number(start)?, number(stop)?, number(step)?);
                if step <= 0.0 || stop < start {
                    return Err(format!("`{item}` is empty; a range is start:stop:step, upwards, like 380:780:5"));
                }
                // The last step may miss the end by rounding.
                let steps = ((stop - start) / step + 1e-9).floor();
                if steps + values.len() as f64 > MOST_VALUES as f64 {
                    return Err(format!("with `{item}` these are more than {MOST_VALUES} values; take a larger step"));
                }
                values.extend((0..=steps as usize).map(|i| (start + i as f64 * step).min(stop)));
            }
            _ => return Err(format!("`{item}` is neither a number nor start:stop:step")),
        }
    }
    match values.iter().find(|&&value| !fit(value)) {
        Some(value) => Err(format!("{value} {otherwise}")),
        None => Ok(List(values)),
    }
}

fn number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ if text.trim().is_empty() => Err("a number is missing; write them with commas, like 0,30,60".to_owned()),
        _ => Err(format!("`{}` is not a number", text.trim())),
    }
}

pub(super) fn illuminant(text: &str) -> Result<Emission, String> {
    match text.to_ascii_lowercase().as_str() {
        "d65" => Ok(Emission::D65),
        "e" => Ok(Emission::E),
        "a" => Ok(Emission::A),
        other => match other.strip_prefix("blackbody:").map(str::parse::<f32>) {
            Some(Ok(kelvin)) if (500.0..=100_000.0).contains(&kelvin) => Ok(Emission::Blackbody(kelvin)),
            Some(_) => Err("the temperature must be 500 to 100000 kelvin, like blackbody:3200".to_owned()),
            None => Err("known are D65, E, A and blackbody:K, like blackbody:3200".to_owned()),
        },
    }
}
