//! The stack under study.

use crate::color::{Index, IndexCurve};
use crate::document::{Base, Document, Material, Preset};
use crate::film::{Layer, Range, Stack};

use super::error::StudyError;
use super::medium::Medium;

/// A stack whose first layer (in a scene's material: its varying layer) takes the thicknesses that are asked for.
#[derive(Clone, Debug)]
pub struct Coating {
    pub stack: Stack,
    /// Thicknesses of that layer as given, in nm; zero without layers.
    pub range: Range,
    /// For people to read: the media from the light on, with the thicknesses of all layers but the first.
    pub label: String,
}

impl Coating {
    /// From media and layers of (medium, thickness in nm), outermost first.
    pub fn new(ambient: &Medium, layers: &[(Medium, f64)], base: &Medium) -> Self {
        // The first layer's thickness is what is varied: it stands beside every result.
        let name = |(i, (medium, nm)): (usize, &(Medium, f64))| match i {
            0 => format!("{} / ", medium.label),
            _ => format!("{} {nm} nm / ", medium.label),
        };
        let middle: String = layers.iter().enumerate().map(name).collect();
        let layer = |(medium, nm): &(Medium, f64)| Layer { index: medium.curve.clone(), thickness_nm: *nm };
        Self {
            stack: Stack {
                outside: ambient.curve.clone(),
                varying: (!layers.is_empty()).then_some(0),
                layers: layers.iter().map(layer).collect(),
                base: base.curve.clone(),
                weight: 1.0,
            },
            range: Range::constant(layers.first().map_or(0.0, |layer| layer.1)),
            label: format!("{} / {middle}{}", ambient.label, base.label),
        }
    }

    /// From a material of a scene, seen from the air. Of a diffuse base this is the interface, not the colour below.
    ///
    /// # Errors
    /// No such material, nothing that reflects, or an index that is none.
    pub fn of_material(document: &Document, id: &str) -> Result<Self, StudyError> {
        let Some(material) = document.materials.iter().find(|material| material.id == id) else {
            let known: Vec<String> = document.materials.iter().map(|material| material.id.clone()).collect();
            let distance = |known: &String| strsim::damerau_levenshtein(known, id);
            let nearest = known.iter().min_by_key(|known| distance(known)).filter(|known| distance(known) <= 3);
            return Err(StudyError::NoMaterial { wanted: id.to_owned(), nearest: nearest.cloned(), known });
        };
        Self::of(material)
    }

    /// A preset at a value within its knob's range, seen from the air.
    ///
    /// # Errors
    /// Never for the presets that the program carries.
    pub fn of_preset(preset: &Preset, value: f32) -> Result<Self, StudyError> {
        let id = format!("{} {} {value}", preset.name, preset.knob.name);
        Self::of(&Material { id, base: preset.base(), films: preset.films(value), ..Material::default() })
    }

    fn of(material: &Material) -> Result<Self, StudyError> {
        let curve =
            |index: &Index| index.curve().map_err(|source| StudyError::Material { id: material.id.clone(), source });
        let base = match &material.base {
            Base::Black => return Err(StudyError::NoSurface(material.id.clone())),
            Base::Diffuse { ior, .. } => curve(&Index::Constant { n: *ior, k: 0.0 })?,
            Base::Conductor { index, .. } | Base::Dielectric { index, .. } => curve(index)?,
        };
        let layers: Result<Vec<Layer>, StudyError> = material
            .films
            .iter()
            .map(|film| Ok(Layer { index: curve(&film.index)?, thickness_nm: film.thickness.range().min_nm }))
            .collect();
        let (varying, range) = varying(material);
        let stack = Stack {
            outside: IndexCurve::constant(1.0, 0.0)?,
            layers: layers?,
            base,
            varying,
            weight: material.films.iter().map(|film| f64::from(film.weight)).product(),
        };
        Ok(Self { stack, range, label: material.id.clone() })
    }

    /// The thicknesses to show where none are asked for, in nm: the one given, or the ends and the middle of a range.
    pub fn thicknesses_nm(&self) -> Vec<f64> {
        let Range { min_nm, max_nm } = self.range;
        if self.varies() { vec![min_nm, 0.5 * (min_nm + max_nm), max_nm] } else { vec![min_nm] }
    }

    pub fn varies(&self) -> bool {
        self.range.max_nm > self.range.min_nm
    }
}

/// The layer of a material that varies, else its first, and the thicknesses of it.
fn varying(material: &Material) -> (Option<usize>, Range) {
    let ranges: Vec<Range> = material.films.iter().map(|film| film.thickness.range()).collect();
    let layer = ranges.iter().position(|range| range.max_nm > range.min_nm).unwrap_or(0);
    match ranges.get(layer) {
        Some(range) => (Some(layer), *range),
        None => (None, Range::constant(0.0)),
    }
}
