//! `<scene>` -> `<visual_scene>`: the root of what is rendered, and the order in which a file is interpreted.

use super::animation;
use super::asset;
use super::coincident;
use super::error::Fault;
use super::loader::Loader;
use super::nodes::{self, INSTANCE_BUDGET};
use super::power;
use super::profile;
use super::sweep;
use super::xml::Element;

/// Fills the loader's document.
pub fn read(loader: &mut Loader) -> Result<(), Fault> {
    let root = loader.xml.root();
    if root.name() != "COLLADA" {
        return Err(root.fault(format!("the root element is <{}>, wanted is <COLLADA>", root.name())));
    }
    let version = root.attribute("version").unwrap_or_default();
    if !version.starts_with("1.4") && !version.starts_with("1.5") {
        loader.warnings.add(root, format!("COLLADA version `{version}`"), "it is read as 1.4.1");
    }
    if let Some(based) = loader.xml.all().find(|element| element.attribute("xml:base").is_some()) {
        loader.warnings.add(based, "`xml:base`", "it is ignored: paths are relative to the scene file");
    }
    let visual_scene = find(loader, root)?;
    asset::read(loader, visual_scene)?;

    let mut instances = 0u64;
    for node in visual_scene.children_named("node") {
        let placed = nodes::load(loader, node, &mut Vec::new())?;
        loader.document.roots.push(placed.index);
        instances = instances.saturating_add(placed.instances);
    }
    if instances > INSTANCE_BUDGET {
        return Err(visual_scene.fault(format!("the scene expands to more than {INSTANCE_BUDGET} instances")));
    }
    power::distribute(loader);
    coincident::drop_duplicates(loader);

    if let Some(technique) = profile::of(loader, visual_scene) {
        loader.document.environment = profile::scene::environment(loader, technique)?;
    }
    if let Some(scene) = root.child("scene") {
        if let Some(technique) = profile::of(loader, scene) {
            loader.document.render = profile::scene::render(loader, technique)?;
        }
        for other in scene.children().filter(|child| child.name().starts_with("instance_")) {
            if other.name() != "instance_visual_scene" {
                loader.warnings.add(
                    other,
                    format!("<{}>", other.name()),
                    "it is ignored: only the visual scene is read",
                );
            }
        }
    }
    animation::read(loader)?;
    sweep::run(loader)
}

/// The visual scene that `<scene>` names; without `<scene>`, the only one there is.
fn find<'a>(loader: &mut Loader<'a>, root: Element<'a>) -> Result<Element<'a>, Fault> {
    if let Some(instance) = root.descend(&["scene", "instance_visual_scene"]) {
        return loader.follow(instance, "url", &["visual_scene"]);
    }
    let scenes: Vec<Element> = loader.xml.all().filter(|element| element.name() == "visual_scene").collect();
    match scenes.as_slice() {
        [only] => {
            loader.warnings.add(root, "the file names no <scene>", "its only <visual_scene> is rendered");
            Ok(*only)
        }
        [] => Err(root.fault("the file has no <visual_scene>")),
        several => {
            let fault = root.fault(format!("the file names no <scene> and has {} <visual_scene>s", several.len()));
            Err(fault.hint("add <scene><instance_visual_scene url=\"#...\"/></scene>"))
        }
    }
}
