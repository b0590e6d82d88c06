//! The named refractive indices and surfaces, for people to read.

use std::fmt::Write;

use crate::color::{Index, IndexError, Kind, kind_of_index, known_index_names, source_of_index};
use crate::document::{Knob, Preset};

/// Every preset with its number and its source.
pub fn list_presets() -> String {
    let mut text = "Presets, each with the number that it follows, its range and default; source\n".to_owned();
    for Preset { name, about, source, knob, .. } in Preset::all() {
        let Knob { name: number, least, most, default } = knob;
        // Writing to a String cannot fail.
        let _ = writeln!(text, "  {name:<18} {number} {least}..{most}, {default}: {about}\n{:21}{source}", "");
    }
    text
}

/// Every name with n and k at 550 nm and its source, by kind.
///
/// # Errors
/// Never for the tables that the program carries.
pub fn list_indices() -> Result<String, IndexError> {
    let mut text = String::new();
    for (kind, heading) in [
        (Kind::Metal, "Metals and semiconductors"),
        (Kind::Glass, "Glasses, crystals and liquids"),
        (Kind::Film, "Coatings, oxides and biological layers"),
    ] {
        let gap = if text.is_empty() { "" } else { "\n" };
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{gap}{heading:<40} n, k at 550 nm; source");
        for &name in known_index_names().iter().filter(|name| kind_of_index(name) == Some(kind)) {
            let index = Index::Named(name.to_owned()).curve()?.at(550.0);
            let source = source_of_index(name).unwrap_or_default();
            let _ = writeln!(text, "  {name:<16} {:>8.4} {:>8.4}  {source}", index.re, index.im);
        }
    }
    Ok(text)
}
