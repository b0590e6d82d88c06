//! Our own vocabulary, `<technique profile="pellicle">`: strict, because a typo that renders is worse than an error.

pub mod film;
pub mod index;
pub mod lights;
pub mod maps;
pub mod material;
pub mod mesh;
pub mod one_line;
pub mod scene;
pub mod spectrum;
pub mod strict;

use super::loader::{Loader, technique};
use super::xml::Element;

pub const PROFILE: &str = "pellicle";

/// Our technique in the `<extra>` of an element; remembers that it was read, so that none is overlooked.
pub fn of<'a>(loader: &mut Loader<'a>, element: Element<'a>) -> Option<Element<'a>> {
    let technique = technique(element, PROFILE)?;
    loader.profile_read.insert(technique.index());
    Some(technique)
}
