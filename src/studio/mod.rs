//! A stage for a bare model: floor, camera and light; and light for scenes that have none.
//!
//! The model is turned Y-up, scaled so that the longest side of its box is 1 m, and stood on the middle of the floor: so a
//! film's noise, glass that absorbs and the lamps look alike on every model, whatever units its file has.

mod environment;
mod floor;
mod model;
mod sky;
mod viewpoint;

use glam::Mat4;

use crate::document::{Document, Item, Node, Transform, TransformKind};

pub use environment::{Environment, light};
pub use model::load;

/// Puts a model that was [`load`]ed on a floor, with a camera that sees it whole from everywhere around, and lights it.
pub fn set_up(document: &mut Document, environment: &Environment) {
    if let Some(camera) = viewpoint::camera(document) {
        document.cameras.push(camera.0);
        add(document, "camera", camera.1, Item::Camera(document.cameras.len() - 1));
    }
    light(document, environment);
    if let Some(reflectance) = environment.floor() {
        floor::lay(document, reflectance);
    }
}

/// Hangs a thing into the scene; `to_world` says where it stands in the world.
pub fn add(document: &mut Document, id: &str, to_world: Mat4, item: Item) {
    let kind = TransformKind::Matrix(document.to_world.inverse() * to_world);
    document.nodes.push(Node {
        id: id.to_owned(),
        name: id.to_owned(),
        transforms: vec![Transform { sid: String::new(), kind }],
        items: vec![item],
        ..Node::default()
    });
    document.roots.push(document.nodes.len() - 1);
}
