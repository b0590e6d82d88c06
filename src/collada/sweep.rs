//! After the scene is read: what nobody has looked at. Typos in unused effects are still typos.

use super::cgl;
use super::error::Fault;
use super::loader::{Loader, technique};
use super::profile::{self, PROFILE};
use super::xml::Element;

/// Profiles whose data is known to be of no use here, or is read where it matters.
const QUIET: [&str; 3] = [PROFILE, "CGL", "blender"];

pub fn run(loader: &mut Loader) -> Result<(), Fault> {
    for element in loader.xml.all().filter(|element| element.name() == "technique") {
        let Some(name) = element.attribute("profile") else { continue };
        let owner = owner(element);
        match name {
            PROFILE if !loader.profile_read.contains(&element.index()) => check_unread(loader, element, owner)?,
            "CGL" => {
                let Some(owner) = owner else { continue };
                loader.document.has_cgl |= matches!(owner.name(), "effect" | "light");
                if owner.name() == "effect" && !loader.effects_read.contains(&owner.index()) {
                    cgl::warn_unknown(loader, element);
                }
            }
            _ if QUIET.contains(&name) => {}
            _ if strsim::damerau_levenshtein(&name.to_lowercase(), PROFILE) <= 2 => {
                let seen = format!("data of profile `{name}`");
                loader.warnings.add(element, seen, format!("it is ignored; did you mean `{PROFILE}`?"));
            }
            _ => loader.warnings.add(element, format!("data of profile `{name}`"), "it is not read"),
        }
    }
    Ok(())
}

/// What an `<extra><technique>` belongs to.
fn owner(technique: Element) -> Option<Element> {
    technique.parent().filter(|parent| parent.name() == "extra").and_then(|extra| extra.parent())
}

/// Our technique in an element that the scene does not use is checked all the same; anywhere else it is misplaced.
fn check_unread<'a>(loader: &mut Loader<'a>, element: Element<'a>, owner: Option<Element<'a>>) -> Result<(), Fault> {
    let places = ["effect", "geometry", "light", "camera", "visual_scene", "scene"];
    let Some(owner) = owner.filter(|owner| places.contains(&owner.name())) else {
        let fault = element.fault(format!("data of profile `{PROFILE}` is not read here"));
        return Err(fault
            .hint("it belongs in the <extra> of <effect>, <geometry>, <light>, <camera>, <visual_scene> or <scene>"));
    };
    if technique(owner, PROFILE).is_some_and(|first| first.index() != element.index()) {
        return Err(element.fault(format!("a second technique of profile `{PROFILE}` in this <{}>", owner.name())));
    }
    // Images that only unused elements refer to are looked for, but not kept.
    let images = loader.document.images.len();
    match owner.name() {
        "effect" => {
            let user = format!("effect `{}`", owner.attribute("id").unwrap_or_default());
            profile::material::read(loader, element, &user)?;
        }
        "geometry" => {
            profile::mesh::reference(element)?;
        }
        "light" => {
            profile::lights::read(element)?;
        }
        "camera" => {
            profile::scene::lens(element)?;
        }
        _ => {
            profile::scene::environment(loader, element)?;
        }
    }
    loader.document.images.truncate(images);
    loader.images.retain(|_, index| *index < images);
    Ok(())
}
