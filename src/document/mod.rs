//! The scene as plain data: what a file says, before anything is built from it.
//!
//! No XML, no Embree, no colour mode. `collada` fills it, `scene::build` reads it. Lists refer to each other by index, so a
//! `Document` can be cloned, compared and animated freely. Lengths are in file units until [`Document::to_world`] is
//! applied (metres, Y up, right-handed afterwards); wavelengths and film thicknesses are nanometres; colours are linear
//! sRGB.

mod animation;
mod camera;
mod curve;
mod light;
mod material;
mod node;
mod pose;
mod preset;
mod shape;
mod texture;

pub use animation::{CameraPart, Channel, EnvironmentPart, FilmPart, Interpolation, MaterialPart, Quantity};
pub use camera::{Camera, Lens, Projection};
pub use light::{AreaShape, Environment, Falloff, Light, LightKind, Presence, SpotEdge};
pub use material::{Base, Distribution, Film, Material, Microfacets, SurfaceEmission, THICKEST_NM, Thickness, Tint};
pub use node::{Binding, Item, Node, Transform, TransformKind};
pub use pose::{Changes, PoseError};
pub use preset::{Knob, Preset};
pub use shape::{Geometry, Group, Mesh, Shape, UvSet};
pub use texture::{Channel4, Encoding, Image, ImageSource, Map, NormalMap, Scalar, Texture, Wrap};

use std::path::PathBuf;

use glam::{Mat4, Vec3};
use sha2::{Digest, Sha256};

use crate::math::hex;

/// Everything one scene file holds.
#[derive(Clone, Debug, Default)]
pub struct Document {
    /// The file it came from, for messages.
    pub path: PathBuf,
    /// SHA-256 of the text that was read and of the models that it names, hexadecimal.
    pub sha256: String,
    /// File space to world space: the `up_axis` rotation times the `<unit>` scale (uniform).
    pub to_world: Mat4,
    pub geometries: Vec<Geometry>,
    pub materials: Vec<Material>,
    pub images: Vec<Image>,
    pub lights: Vec<Light>,
    pub cameras: Vec<Camera>,
    /// All nodes; a node may be reached from several parents (`<instance_node>`), never from itself.
    pub nodes: Vec<Node>,
    /// The top-level nodes of the scene that is instantiated.
    pub roots: Vec<usize>,
    pub environment: Option<Environment>,
    pub channels: Vec<Channel>,
    pub render: RenderHints,
    /// True when the file carries CS184 "CGL" material or light data, which invites its own camera framing.
    pub has_cgl: bool,
}

/// What the scene file asks of the renderer; the command line overrides each.
#[derive(Clone, Debug, Default)]
pub struct RenderHints {
    pub width: Option<u32>,
    pub height: Option<u32>,
    /// Width of a pixel over its height.
    pub pixel_aspect: Option<f32>,
    pub spp: Option<u32>,
    pub seed: Option<u32>,
    pub max_bounces: Option<u32>,
    pub mode: Option<String>,
    pub tolerance: Option<f32>,
    pub exposure_ev: Option<f32>,
    /// Id of a camera or of a camera's node.
    pub camera: Option<String>,
}

/// A scene further from the origin than this many times its own size is moved there: the digits of f32 are spent on the
/// distance else, and light leaks through walls.
const FAR: f32 = 8.0;

impl Document {
    /// Takes a file that the scene names into its hash.
    pub fn depend_on(&mut self, file: &[u8]) {
        self.sha256 = hex(&Sha256::new().chain_update(&self.sha256).chain_update(file).finalize());
    }

    /// Brings a scene that lies far from the origin there, by way of [`to_world`](Self::to_world): once, before anything is
    /// built, while distances still cancel exactly.
    pub fn come_near(&mut self) {
        if let Some(center) = self.far_center() {
            self.to_world = Mat4::from_translation(-center) * self.to_world;
        }
    }

    /// World matrix of every reachable node instance that carries items, in depth-first order: (node, node-to-world).
    /// A node reached along several paths appears once for each.
    pub fn placements(&self) -> Vec<(usize, Mat4)> {
        let mut placed = Vec::new();
        let mut stack: Vec<(usize, Mat4)> = self.roots.iter().rev().map(|&root| (root, self.to_world)).collect();
        while let Some((index, parent)) = stack.pop() {
            let node = &self.nodes[index];
            let to_world = parent * node.local();
            stack.extend(node.children.iter().rev().map(|&child| (child, to_world)));
            if !node.items.is_empty() {
                placed.push((index, to_world));
            }
        }
        placed
    }

    /// For each of the [`placements`](Self::placements), whether one of the marked nodes or a node below one is placed there.
    /// `marked` has one entry per node.
    pub fn placed_under(&self, marked: &[bool]) -> Vec<bool> {
        let mut under = Vec::new();
        let mut stack: Vec<(usize, bool)> = self.roots.iter().rev().map(|&root| (root, false)).collect();
        while let Some((index, parent)) = stack.pop() {
            let node = &self.nodes[index];
            let inside = parent || marked[index];
            stack.extend(node.children.iter().rev().map(|&child| (child, inside)));
            if !node.items.is_empty() {
                under.push(inside);
            }
        }
        under
    }

    /// What a node is called: its id, else its name.
    pub fn node_name(&self, index: usize) -> String {
        let named = self.nodes.get(index).and_then(|node| [&node.id, &node.name].into_iter().find(|n| !n.is_empty()));
        named.map_or_else(|| format!("node {index}"), String::clone)
    }

    /// A material's id; `default` for what has no material.
    pub fn material_name(&self, index: usize) -> String {
        let named = self.materials.get(index).map(|material| &material.id).filter(|id| !id.is_empty());
        named.map_or_else(|| "default".to_owned(), String::clone)
    }

    /// The middle of all geometry, if that is far from the origin.
    fn far_center(&self) -> Option<Vec3> {
        // Matrices alone carry scenes away: vertices that are written far out have lost their digits already.
        if self.placements().iter().all(|(_, to_world)| to_world.w_axis.truncate() == Vec3::ZERO) {
            return None;
        }
        let (low, high) = self.bounds()?;
        let center = 0.5 * (low + high);
        (center.is_finite() && center.length() > FAR * (high - low).length()).then_some(center)
    }

    /// Corners of a box around the boxes of all placed shapes, world space; `None` where there is none.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        // Once for each geometry: a mesh may be placed very often.
        let bounds: Vec<Option<(Vec3, Vec3)>> =
            self.geometries.iter().map(|geometry| geometry.shape.bounds()).collect();
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for (node, to_world) in &self.placements() {
            for item in &self.nodes[*node].items {
                let Item::Geometry { geometry, .. } = item else { continue };
                let Some((least, most)) = bounds[*geometry] else { continue };
                for corner in 0..8 {
                    let pick = |axis: usize| if corner >> axis & 1 == 1 { most[axis] } else { least[axis] };
                    let point = to_world.transform_point3(Vec3::new(pick(0), pick(1), pick(2)));
                    (low, high) = (low.min(point), high.max(point));
                }
            }
        }
        (low.x <= high.x).then_some((low, high))
    }
}
