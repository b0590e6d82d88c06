//! `<material>` -> `<effect>` -> [`Material`]: which of the profiles on an effect counts.

use crate::document::Material;

use super::cgl;
use super::common;
use super::error::Fault;
use super::loader::{Loader, technique};
use super::profile;
use super::xml::Element;

/// The material's index in the document.
pub fn load<'a>(loader: &mut Loader<'a>, material: Element<'a>) -> Result<usize, Fault> {
    if let Some(&known) = loader.materials.get(&material.index()) {
        return Ok(known);
    }
    let mut read = read(loader, material, 0)?;
    read.number_texcoords();
    loader.take(material, read.bytes())?;
    loader.document.materials.push(read);
    let index = loader.document.materials.len() - 1;
    loader.materials.insert(material.index(), index);
    Ok(index)
}

/// Our profile goes before CGL, CGL before the common profile. `depth` counts CGL `<base_material>` references.
pub fn read<'a>(loader: &mut Loader<'a>, material: Element<'a>, depth: usize) -> Result<Material, Fault> {
    let id = material.attribute("id").unwrap_or_default();
    let user = format!("material `{id}`");
    let Some(instance) = material.child("instance_effect") else {
        return Err(material.fault(format!("{user} has no <instance_effect>")));
    };
    let effect = loader.follow(instance, "url", &["effect"])?;
    loader.effects_read.insert(effect.index());
    let read = if let Some(technique) = profile::of(loader, effect) {
        profile::material::read(loader, technique, &user)?
    } else if let Some(technique) = technique(effect, "CGL") {
        cgl::material(loader, technique, depth)?
    } else {
        common::read(loader, effect, instance, &user)?
    };
    Ok(Material { id: id.to_owned(), ..read })
}
