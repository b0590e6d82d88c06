//! Measured refractive indices by name: the tables under `data/nk`, each with its source and licence in its first lines.

use std::sync::LazyLock;

use super::index::{IndexCurve, IndexError};
use super::table;

/// What a named material is mostly used for. Any name may stand for any role.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Metals and semiconductors: opaque bases.
    Metal,
    /// Transparent bases.
    Glass,
    /// Coatings, oxides and biological layers.
    Film,
}

struct Named {
    name: &'static str,
    kind: Kind,
    csv: &'static str,
}

macro_rules! tables {
    ($($kind:ident: $($name:literal)*;)*) => {
        &[$($(Named { name: $name, kind: Kind::$kind, csv: include_str!(concat!("../../data/nk/", $name, ".csv")) },)*)*]
    };
}

static TABLES: &[Named] = tables! {
    Metal: "Ag" "Al" "Au" "brass" "Co" "Cr" "Cu" "Fe" "Ge" "Hg" "Ir" "Mg" "Mn" "Mo" "Nb" "Ni" "Pb" "Pd" "Pt" "Rh"
        "Si" "stainless-steel" "Ti" "TiN" "V" "W" "Zn" "Zr";
    Glass: "BK7" "CaF2" "calcite" "diamond" "F2" "fused-silica" "PMMA" "polycarbonate" "polystyrene" "quartz"
        "sapphire" "SF10" "SF11" "soda-lime" "water" "zirconia";
    Film: "Al2O3" "aragonite" "chitin" "cryolite" "Fe2O3" "Fe3O4" "HfO2" "keratin" "MgF2" "Nb2O5" "oil" "Si3N4"
        "SiO2" "soap" "Ta2O5" "TiO2" "WO3" "ZnS" "ZrO2";
};

/// Every known name: metals, then glasses, then films.
pub fn known_index_names() -> &'static [&'static str] {
    static NAMES: LazyLock<Vec<&'static str>> = LazyLock::new(|| TABLES.iter().map(|table| table.name).collect());
    &NAMES
}

/// What a known name is mostly used for.
pub fn kind_of_index(name: &str) -> Option<Kind> {
    find(name).map(|table| table.kind)
}

/// Where the table of a known name comes from: its source line.
pub fn source_of_index(name: &str) -> Option<&'static str> {
    find(name)?.csv.lines().find_map(|line| line.strip_prefix("# source: "))
}

/// The measured curve; names are compared without regard to case.
pub(super) fn curve(name: &str) -> Result<IndexCurve, IndexError> {
    let Some(table) = find(name) else {
        return Err(IndexError::Unknown { name: name.to_owned(), nearest: nearest(name) });
    };
    IndexCurve::table(table::parse::<2>(table.csv).into_iter().map(|(nm, [n, k])| (nm, n, k)))
}

fn find(name: &str) -> Option<&'static Named> {
    TABLES.iter().find(|table| table.name.eq_ignore_ascii_case(name))
}

/// The known name that is closest in spelling, where one is close at all.
fn nearest(name: &str) -> Option<String> {
    let distance = |known: &str| strsim::damerau_levenshtein(&known.to_lowercase(), &name.to_lowercase());
    let best = TABLES.iter().min_by_key(|table| distance(table.name))?;
    (distance(best.name) <= 1 + name.chars().count() / 3).then(|| best.name.to_owned())
}
