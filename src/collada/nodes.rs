//! `<node>`: the hierarchy and what it instantiates.

use glam::Vec3;

use crate::document::{Item, Node, Transform, TransformKind};

use super::bindings;
use super::blender;
use super::cameras;
use super::error::{Fault, line_at};
use super::geometry;
use super::lights;
use super::loader::Loader;
use super::transforms;
use super::xml::{DEPTH_LIMIT, Element};

/// Most nodes that the scene may have once every `<instance_node>` is followed.
pub const INSTANCE_BUDGET: u64 = 1_000_000;

/// Longest chain of controllers that refer to controllers.
const CONTROLLER_LIMIT: usize = 16;

/// What is known of a node element.
#[derive(Clone, Copy)]
pub enum NodeMemo {
    /// Being read: meeting it again is a cycle.
    Open,
    Done(Placed),
}

#[derive(Clone, Copy)]
pub struct Placed {
    /// Index in the document.
    pub index: usize,
    /// Nodes below it and itself, each counted as often as it appears.
    pub instances: u64,
    /// Levels below it and itself.
    height: usize,
}

/// Reads a node and everything below, each element once however often it is instantiated.
/// `chain` holds the nodes from the scene down to this one.
pub fn load<'a>(loader: &mut Loader<'a>, node: Element<'a>, chain: &mut Vec<Element<'a>>) -> Result<Placed, Fault> {
    match loader.nodes.get(&node.index()) {
        Some(NodeMemo::Done(placed)) => return Ok(*placed),
        Some(NodeMemo::Open) => {
            let start = chain.iter().position(|open| open.index() == node.index()).unwrap_or(0);
            let name = |node: &Element| node.attribute("id").unwrap_or("(no id)").to_owned();
            let names: Vec<String> = chain[start..].iter().chain([&node]).map(name).collect();
            return Err(node.fault(format!("nodes contain each other: {}", names.join(" -> "))));
        }
        None => {}
    }
    if chain.len() >= DEPTH_LIMIT {
        return Err(node.fault(format!("nodes are nested deeper than {DEPTH_LIMIT}")));
    }
    loader.nodes.insert(node.index(), NodeMemo::Open);
    chain.push(node);
    let placed = read(loader, node, chain)?;
    chain.pop();
    if placed.instances > INSTANCE_BUDGET {
        return Err(node.fault(format!("this node expands to more than {INSTANCE_BUDGET} instances")));
    }
    if placed.height + chain.len() > DEPTH_LIMIT {
        return Err(node.fault(format!("nodes are nested deeper than {DEPTH_LIMIT}")));
    }
    loader.nodes.insert(node.index(), NodeMemo::Done(placed));
    Ok(placed)
}

fn read<'a>(loader: &mut Loader<'a>, element: Element<'a>, chain: &mut Vec<Element<'a>>) -> Result<Placed, Fault> {
    let index = loader.document.nodes.len();
    loader.document.nodes.push(Node::default());
    let text = |name: &str| element.attribute(name).unwrap_or_default().to_owned();
    let mut node = Node { id: text("id"), name: text("name"), sid: text("sid"), ..Node::default() };
    let mut placed = Placed { index, instances: 1, height: 1 };
    let mut drop_cameras = false;
    match transforms::read(element) {
        Ok(transforms) => node.transforms = transforms,
        Err(fault) if loader.options.lenient && holds_only_cameras(element) => {
            let line = line_at(&loader.xml.source, fault.span.start).0;
            let seen =
                format!("the transform of camera node `{}` is broken at line {line}: {}", node.id, fault.message);
            loader.warnings.add(element, seen, "the camera is dropped: the scene's bounding box is framed");
            drop_cameras = true;
        }
        Err(fault) if fault.hint.is_none() && holds_only_cameras(element) => {
            return Err(fault.hint("--lenient drops this camera and frames the scene's bounding box"));
        }
        Err(fault) => return Err(fault),
    }
    warn_misordered(loader, element, &node.transforms);
    for child in element.children() {
        match child.name() {
            "node" => node.adopt(load(loader, child, chain)?, &mut placed),
            "instance_node" => {
                let target = loader.follow(child, "url", &["node"])?;
                node.adopt(load(loader, target, chain)?, &mut placed);
            }
            "instance_geometry" => {
                let target = loader.follow(child, "url", &["geometry"])?;
                if let Some(geometry) = geometry::load(loader, target)? {
                    let bindings = bindings::read(loader, child, geometry)?;
                    node.items.push(Item::Geometry { geometry, bindings });
                }
            }
            "instance_controller" => controller(loader, child, &mut node, &mut placed)?,
            "instance_light" => {
                let target = loader.follow(child, "url", &["light"])?;
                let light = lights::load(loader, target)?;
                match light.size {
                    None => node.items.push(Item::Light(light.index)),
                    Some((width, height)) => {
                        let scale = TransformKind::Scale(Vec3::new(width, height, 1.0));
                        wrap(loader, &mut node, &mut placed, scale, Item::Light(light.index));
                    }
                }
            }
            "instance_camera" if !drop_cameras => {
                let target = loader.follow(child, "url", &["camera"])?;
                let camera = cameras::load(loader, target)?;
                node.items.push(Item::Camera(camera));
                warn_y_up(loader, element, &node);
            }
            _ => {}
        }
    }
    loader.document.nodes[index] = node;
    Ok(placed)
}

impl Node {
    fn adopt(&mut self, child: Placed, own: &mut Placed) {
        self.children.push(child.index);
        own.instances = own.instances.saturating_add(child.instances);
        own.height = own.height.max(child.height + 1);
    }
}

/// Puts an item into a child node of its own, under one more transform.
fn wrap(loader: &mut Loader, node: &mut Node, placed: &mut Placed, kind: TransformKind, item: Item) {
    let index = loader.document.nodes.len();
    let transforms = vec![Transform { sid: String::new(), kind }];
    loader.document.nodes.push(Node { transforms, items: vec![item], ..Node::default() });
    node.adopt(Placed { index, instances: 1, height: 1 }, placed);
}

/// Skinned and morphed geometry in its bind pose.
fn controller<'a>(
    loader: &mut Loader<'a>,
    instance: Element<'a>,
    node: &mut Node,
    placed: &mut Placed,
) -> Result<(), Fault> {
    loader.warnings.add(instance, "a skinned or morphed geometry", "it is shown in its bind pose");
    let mut bind_shape = None;
    let mut target = loader.follow(instance, "url", &["controller"])?;
    for _ in 0..CONTROLLER_LIMIT {
        let Some(kind) = target.children().find(|child| matches!(child.name(), "skin" | "morph")) else {
            return Err(target.fault("this <controller> has neither <skin> nor <morph>"));
        };
        if let (None, Some(matrix)) = (bind_shape, kind.child("bind_shape_matrix")) {
            bind_shape = Some(transforms::matrix(matrix)?);
        }
        target = loader.follow(kind, "source", &["geometry", "controller"])?;
        if target.name() == "geometry" {
            let Some(geometry) = geometry::load(loader, target)? else { return Ok(()) };
            let bindings = bindings::read(loader, instance, geometry)?;
            let matrix = TransformKind::Matrix(bind_shape.unwrap_or_default());
            wrap(loader, node, placed, matrix, Item::Geometry { geometry, bindings });
            return Ok(());
        }
    }
    Err(instance.fault("controllers refer to each other in a circle"))
}

fn holds_only_cameras(node: Element) -> bool {
    let content = |name: &str| name == "node" || name.starts_with("instance_");
    let mut contents = node.children().filter(|child| content(child.name())).peekable();
    contents.peek().is_some() && contents.all(|child| child.name() == "instance_camera")
}

fn warn_misordered<'a>(loader: &mut Loader<'a>, node: Element<'a>, transforms: &[Transform]) {
    let kinds: Vec<TransformKind> = transforms.iter().map(|transform| transform.kind).collect();
    if loader.blender.is_some_and(|version| version.writes_watts()) && blender::misordered(&kinds) {
        let advice = "the order of the file counts: export with Transform = Matrix for Blender's own positions";
        loader.warnings.add(node, "a node from Blender that scales and rotates its translation", advice);
    }
}

fn warn_y_up<'a>(loader: &mut Loader<'a>, element: Element<'a>, node: &Node) {
    let is_z_up = loader.xml.root().descend(&["asset", "up_axis"]).is_some_and(|axis| axis.text() == "Z_UP");
    if loader.blender.is_some_and(|version| version.exports_y_up())
        && is_z_up
        && blender::looks_y_up(node.local().x_axis.truncate())
    {
        let advice = "Blender writes Z_UP even for a Y-up export: if the picture lies on its side, say --up-axis Y or export \
                      with Up = Z";
        loader.warnings.add(element, "a camera that stands upright for Y up in a Z_UP file", advice);
    }
}
