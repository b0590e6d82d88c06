//! Turntables: the camera, the object or the light goes around once, in steps that close to a ring.

use std::fmt::Write;

use glam::{Affine3A, DAffine3, DVec3, Mat4, Vec3};

use crate::document::{Document, Item, Shape};
use crate::error::Error;
use crate::math::extent;

/// Of the extent of all shapes along an axis: what covers this share along two axes is ground or room.
const COVERS: f32 = 0.9;
/// Names that the opening line shows.
const SHOWN: usize = 3;

/// What goes around. For a film these are three different things: the angle to the eye changes, the angles to eye and light
/// change together, or the angle to the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turning {
    Camera,
    Object,
    Light,
}

/// The point that everything goes around.
#[derive(Clone, Debug, PartialEq)]
pub enum Pivot {
    /// The middle of the object's box.
    Auto,
    /// The origin of a node.
    Node(String),
    /// In the file's own axes and units.
    Point([f32; 3]),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// World up.
    Up,
    /// Of the file.
    X,
    Y,
    Z,
}

#[derive(Clone, Debug, PartialEq)]
pub struct TurntablePlan {
    pub turning: Turning,
    /// Frames of the whole ring.
    pub count: u32,
    /// From frame 0 to frame `count`, anticlockwise about the axis.
    pub degrees: f64,
    pub pivot: Pivot,
    pub axis: Axis,
    /// Nodes that make up the object; empty: the node of the pivot, or else every shape that is neither lamp nor ground nor
    /// room.
    pub objects: Vec<String>,
}

/// A turntable of one document.
pub struct Turntable {
    pub turning: Turning,
    count: u32,
    degrees: f64,
    pivot: DVec3,
    axis: DVec3,
    /// For each placement, whether it goes around.
    pub turns: Vec<bool>,
    placements: Vec<(usize, Mat4)>,
}

/// A placement as the choice of the object sees it.
struct Piece {
    node: usize,
    /// World space; `None` where nothing has a shape.
    bounds: Option<(Vec3, Vec3)>,
    /// Light, or shapes that shine.
    lamp: bool,
}

impl Turntable {
    /// The turntable, and a line that says what turns about what.
    ///
    /// # Errors
    /// Nodes that the scene does not have, or nothing that could turn.
    pub fn new(document: &Document, plan: &TurntablePlan) -> Result<(Self, String), Error> {
        let placements = document.placements();
        let pieces: Vec<Piece> = placements.iter().map(|placement| piece(document, placement)).collect();
        let object = object(document, plan, &pieces)?;
        let turns: Vec<bool> = match plan.turning {
            Turning::Camera => vec![false; pieces.len()],
            Turning::Object => object.clone(),
            Turning::Light => pieces.iter().map(|piece| piece.lamp).collect(),
        };
        if plan.turning == Turning::Object && !object.contains(&true) {
            return Err(Error::Usage("the scene has no shape that could turn".to_owned()));
        }
        if plan.turning == Turning::Light && !turns.contains(&true) && document.environment.is_none() {
            return Err(Error::Usage("the scene has no light that could turn".to_owned()));
        }
        let pivot = match &plan.pivot {
            Pivot::Auto => middle(&pieces, &object),
            Pivot::Point(point) => document.to_world.transform_point3(Vec3::from(*point)),
            Pivot::Node(id) => {
                let to_world = node_to_world(document, id).ok_or_else(|| unknown(document, id))?;
                to_world.transform_point3(Vec3::ZERO)
            }
        };
        let axis = match plan.axis {
            Axis::Up => Vec3::Y,
            Axis::X => document.to_world.transform_vector3(Vec3::X),
            Axis::Y => document.to_world.transform_vector3(Vec3::Y),
            Axis::Z => document.to_world.transform_vector3(Vec3::Z),
        };
        let table = Self {
            turning: plan.turning,
            count: plan.count,
            degrees: plan.degrees,
            pivot: pivot.as_dvec3(),
            axis: axis.as_dvec3().normalize(),
            turns,
            placements,
        };
        let line = table.describe(document, &pieces, &object);
        Ok((table, line))
    }

    /// Degrees at a frame or between two, 0 to below 360: the frame after the last of a full turn is the first to the last bit.
    pub fn angle_deg(&self, frame: f64) -> f64 {
        (self.degrees * frame / f64::from(self.count)).rem_euclid(360.0)
    }

    /// How what turns stands at a frame, seen from how the file has it.
    pub fn motion(&self, frame: f64) -> Affine3A {
        let turn = DAffine3::from_axis_angle(self.axis, self.angle_deg(frame).to_radians());
        let to_pivot = DAffine3::from_translation(self.pivot);
        let motion = to_pivot * turn * DAffine3::from_translation(-self.pivot);
        Affine3A::from_mat3_translation(motion.matrix3.as_mat3(), motion.translation.as_vec3())
    }

    /// The document's placements with what turns turned.
    pub fn placements(&self, motion: &Affine3A) -> Vec<(usize, Mat4)> {
        let motion = Mat4::from(*motion);
        let turned = |(&(node, to_world), &turns): (&(usize, Mat4), &bool)| {
            (node, if turns { motion * to_world } else { to_world })
        };
        self.placements.iter().zip(&self.turns).map(turned).collect()
    }

    fn describe(&self, document: &Document, pieces: &[Piece], object: &[bool]) -> String {
        let of = |wanted: &dyn Fn(&Piece, bool) -> bool| {
            let found = pieces.iter().zip(&self.turns).filter(|(piece, turns)| wanted(piece, **turns));
            names(found.map(|(piece, _)| document.nodes[piece.node].id.as_str()).collect())
        };
        let what = match self.turning {
            Turning::Camera => "the camera".to_owned(),
            Turning::Object => of(&|_, turns| turns),
            Turning::Light if document.environment.is_none() => of(&|_, turns| turns),
            Turning::Light => format!("the environment, {}", of(&|_, turns| turns)),
        };
        let [x, y, z] = self.pivot.as_vec3().to_array();
        let step_deg = self.degrees / f64::from(self.count);
        let mut line = format!("turning {what} about ({x:.4}, {y:.4}, {z:.4}) m by {step_deg} degrees a frame");
        let still = |piece: &Piece, turns: bool| !turns && !piece.lamp && piece.bounds.is_some();
        if self.turning == Turning::Object && pieces.iter().zip(&self.turns).any(|(p, turns)| still(p, *turns)) {
            let _ = write!(line, "; not {} (--object chooses)", of(&still));
        }
        let walls = walls(pieces, object);
        if self.turning == Turning::Camera && !walls.is_empty() {
            let ids = walls.into_iter().map(|node| document.nodes[node].id.as_str()).collect();
            let _ = write!(line, "; {} may come between (--mode object turns the object instead)", names(ids));
        }
        line
    }
}

/// The first few of several names.
fn names(all: Vec<&str>) -> String {
    let shown = all.iter().take(SHOWN).map(|name| if name.is_empty() { "(no id)" } else { name });
    let shown = shown.collect::<Vec<_>>().join(", ");
    match all.len() {
        0 => "nothing".to_owned(),
        count if count > SHOWN => format!("{shown} and {} more", count - SHOWN),
        _ => shown,
    }
}

fn piece(document: &Document, &(node, to_world): &(usize, Mat4)) -> Piece {
    let mut piece = Piece { node, bounds: None, lamp: false };
    for item in &document.nodes[node].items {
        match item {
            Item::Light(_) => piece.lamp = true,
            Item::Camera(_) => {}
            Item::Geometry { geometry, bindings } => {
                let shines = |material: usize| {
                    document.materials.get(material).is_some_and(|material| material.emission.is_some())
                };
                piece.lamp |= !bindings.is_empty() && bindings.iter().all(|binding| shines(binding.material));
                let (low, high) = piece.bounds.unwrap_or((Vec3::INFINITY, Vec3::NEG_INFINITY));
                let (from, to) = shape_bounds(&document.geometries[*geometry].shape, &to_world);
                if from.x <= to.x {
                    piece.bounds = Some((low.min(from), high.max(to)));
                }
            }
        }
    }
    piece
}

fn shape_bounds(shape: &Shape, to_world: &Mat4) -> (Vec3, Vec3) {
    match shape {
        Shape::Mesh(mesh) => extent(mesh.positions.iter().map(|p| to_world.transform_point3(*p))),
        Shape::Sphere { radius } => {
            let center = to_world.transform_point3(Vec3::ZERO);
            let reach = Vec3::splat(radius * to_world.x_axis.truncate().length());
            (center - reach, center + reach)
        }
    }
}

/// Which placements make up the object.
fn object(document: &Document, plan: &TurntablePlan, pieces: &[Piece]) -> Result<Vec<bool>, Error> {
    let mut marked = vec![false; document.nodes.len()];
    let mut mark = |id: &String| match document.nodes.iter().position(|node| node.id == *id) {
        Some(node) => {
            marked[node] = true;
            Ok(())
        }
        None => Err(unknown(document, id)),
    };
    plan.objects.iter().try_for_each(&mut mark)?;
    if let (Pivot::Node(id), true) = (&plan.pivot, plan.objects.is_empty()) {
        mark(id)?;
    }
    let chosen = document.placed_under(&marked);
    let has_shape = |(piece, chosen): (&Piece, &bool)| *chosen && piece.bounds.is_some();
    if !plan.objects.is_empty() || pieces.iter().zip(&chosen).any(has_shape) {
        return Ok(chosen);
    }

    // Leave out lamps, and what reaches across the scene: ground, walls, room.
    let candidates = || pieces.iter().filter(|piece| !piece.lamp).filter_map(|piece| piece.bounds);
    let (low, high) = candidates()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), (from, to)| (low.min(from), high.max(to)));
    let covers = |(from, to): (Vec3, Vec3)| {
        let share = (to - from) / (high - low).max(Vec3::splat(f32::MIN_POSITIVE));
        share.to_array().into_iter().filter(|share| *share >= COVERS).count() >= 2
    };
    let all_cover = candidates().all(covers);
    let belongs = |piece: &Piece| !piece.lamp && piece.bounds.is_some_and(|bounds| all_cover || !covers(bounds));
    Ok(pieces.iter().map(belongs).collect())
}

/// The middle of the object's box.
fn middle(pieces: &[Piece], object: &[bool]) -> Vec3 {
    let boxes = pieces.iter().zip(object).filter(|(_, belongs)| **belongs).filter_map(|(piece, _)| piece.bounds);
    let (low, high) =
        boxes.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), (from, to)| (low.min(from), high.max(to)));
    if low.x <= high.x { 0.5 * (low + high) } else { Vec3::ZERO }
}

/// Nodes that are not of the object and stand as high as it does.
fn walls(pieces: &[Piece], object: &[bool]) -> Vec<usize> {
    let both = || pieces.iter().zip(object);
    let bounds = both().filter(|(_, belongs)| **belongs).filter_map(|(piece, _)| piece.bounds);
    let top = bounds.map(|(_, high)| high.y).fold(f32::NEG_INFINITY, f32::max);
    let middle = middle(pieces, object).y;
    let stands = |(low, high): (Vec3, Vec3)| low.y < middle && high.y >= top;
    let is_wall = |(piece, belongs): &(&Piece, &bool)| !**belongs && !piece.lamp && piece.bounds.is_some_and(stands);
    both().filter(is_wall).map(|(piece, _)| piece.node).collect()
}

/// World matrix of the first place of a node.
fn node_to_world(document: &Document, id: &str) -> Option<Mat4> {
    let mut stack: Vec<(usize, Mat4)> = document.roots.iter().rev().map(|&root| (root, document.to_world)).collect();
    while let Some((index, parent)) = stack.pop() {
        let node = &document.nodes[index];
        let to_world = parent * node.local();
        if node.id == id {
            return Some(to_world);
        }
        stack.extend(node.children.iter().rev().map(|&child| (child, to_world)));
    }
    None
}

fn unknown(document: &Document, id: &str) -> Error {
    let ids = document.nodes.iter().map(|node| node.id.as_str()).filter(|known| !known.is_empty());
    let alike = |a: &&str, b: &&str| strsim::jaro_winkler(a, id).total_cmp(&strsim::jaro_winkler(b, id));
    let nearest = ids.max_by(alike).map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
    Error::Usage(format!("no node `{id}` in the scene{nearest}"))
}
