//! `<mesh>`: primitives with several index streams -> triangles with unified vertices.

use std::collections::HashMap;

use glam::{Vec2, Vec3};

use crate::document::{Group, Mesh, UvSet};
use crate::mesh::normals;
use crate::mesh::vertices::unify;

use super::error::Fault;
use super::loader::Loader;
use super::primitives::{self, LINES, SURFACES, Stream};
use super::sources::{Accessor, Arrays, whole_number};
use super::xml::Element;

/// Texture coordinate sets of one mesh. Every corner has an index for each: their number multiplies what a mesh takes.
const MOST_UV_SETS: usize = 32;

/// All sources of one kind, one after the other.
struct Pool<T> {
    values: Vec<T>,
    /// Element index of the source -> (start, count).
    ranges: HashMap<usize, (usize, usize)>,
}

/// A primitive with its streams.
struct Layout<'a> {
    primitive: Element<'a>,
    stride: usize,
    position: Stream<'a>,
    normal: Option<Stream<'a>>,
    /// By channel.
    uvs: Vec<Option<Stream<'a>>>,
}

struct Pools {
    points: Pool<Vec3>,
    normals: Pool<Vec3>,
    uvs: Pool<Vec2>,
    /// The `set` numbers, in the order in which they were met: one channel each.
    sets: Vec<u32>,
}

impl<T> Default for Pool<T> {
    fn default() -> Self {
        Self { values: Vec::new(), ranges: HashMap::new() }
    }
}

impl<T> Pool<T> {
    fn stream<'a>(
        &mut self,
        arrays: &mut Arrays,
        loader: &mut Loader<'a>,
        (offset, source): (usize, Element<'a>),
        decode: impl FnOnce(&Accessor<'a>) -> Result<Vec<T>, Fault>,
    ) -> Result<Stream<'a>, Fault> {
        if let Some(&(base, count)) = self.ranges.get(&source.index()) {
            return Ok(Stream { offset, base, count, source });
        }
        let values = decode(&arrays.accessor(loader, source)?)?;
        let (base, count) = (self.values.len(), values.len());
        if base == 0 {
            self.values = values
        } else {
            self.values.extend(values)
        }
        self.ranges.insert(source.index(), (base, count));
        Ok(Stream { offset, base, count, source })
    }
}

/// Reads a mesh. A mesh without triangles is not an error here.
pub fn read<'a>(loader: &mut Loader<'a>, mesh: Element<'a>) -> Result<Mesh, Fault> {
    let mut pools = Pools { points: Pool::default(), normals: Pool::default(), uvs: Pool::default(), sets: Vec::new() };
    let mut arrays = Arrays::default();
    let mut layouts = Vec::new();
    for primitive in mesh.children() {
        if SURFACES.contains(&primitive.name()) {
            layouts.push(pools.layout(&mut arrays, loader, primitive)?);
        } else if LINES.contains(&primitive.name()) {
            loader.warnings.add(primitive, format!("<{}> are not surfaces", primitive.name()), "they are ignored");
        }
    }
    // The pools hold all that is needed of them, and indices are about to take as much memory.
    drop(arrays);
    let channels = pools.sets.len();
    layouts.iter_mut().for_each(|layout| layout.uvs.resize(channels, None));
    let with_normals = !loader.options.smooth_normals && layouts.iter().any(|layout| layout.normal.is_some());
    assemble(loader, mesh, pools, &layouts, with_normals)
}

impl Pools {
    fn layout<'a>(
        &mut self,
        arrays: &mut Arrays,
        loader: &mut Loader<'a>,
        primitive: Element<'a>,
    ) -> Result<Layout<'a>, Fault> {
        let mut stride = 1;
        let mut position = None;
        let mut normal = None;
        let mut uvs = Vec::new();
        let mut note = |semantic: &str, set: usize, at: (usize, Element<'a>)| match semantic {
            "POSITION" => position = position.or(Some(at)),
            "NORMAL" => normal = Some(at),
            "TEXCOORD" if uvs.iter().all(|&(known, _)| known != set) => uvs.push((set, at)),
            _ => {}
        };
        for input in primitive.children_named("input") {
            let Some(offset) = whole_number(input, "offset")? else {
                return Err(input.fault("this <input> has no `offset`"));
            };
            stride = stride.max(offset + 1);
            let semantic = input.attribute("semantic").unwrap_or_default();
            if semantic == "VERTEX" {
                let vertices = loader.follow(input, "source", &["vertices"])?;
                for own in vertices.children_named("input") {
                    let source = loader.follow(own, "source", &["source"])?;
                    note(own.attribute("semantic").unwrap_or_default(), 0, (offset, source));
                }
            } else if matches!(semantic, "NORMAL" | "TEXCOORD") {
                let set = whole_number(input, "set")?.unwrap_or(0);
                note(semantic, set, (offset, loader.follow(input, "source", &["source"])?));
            }
        }
        let Some(position) = position else {
            let fault = primitive.fault(format!("this <{}> has no positions", primitive.name()));
            return Err(fault.hint("it needs <input semantic=\"VERTEX\"> to <vertices> with a POSITION input"));
        };
        let position = self.points.stream(arrays, loader, position, |accessor| accessor.points())?;
        let normal =
            normal.map(|at| self.normals.stream(arrays, loader, at, |accessor| accessor.vectors())).transpose()?;
        let mut layout = Layout { primitive, stride, position, normal, uvs: Vec::new() };
        for (set, at) in uvs {
            let stream = self.uvs.stream(arrays, loader, at, |accessor| accessor.pairs())?;
            // `whole_number` reads 32 bits.
            let set = set as u32;
            let channel = self.sets.iter().position(|&known| known == set).unwrap_or(self.sets.len());
            if channel == self.sets.len() {
                if channel == MOST_UV_SETS {
                    return Err(primitive.fault(format!("the mesh has more than {MOST_UV_SETS} TEXCOORD sets")));
                }
                self.sets.push(set);
            }
            layout.uvs.resize(layout.uvs.len().max(channel + 1), None);
            layout.uvs[channel] = Some(stream);
        }
        Ok(layout)
    }
}

impl<'a> Layout<'a> {
    /// Channel 0 is the position, then the normal (if kept), then the texture coordinate sets.
    fn channels(&self, with_normals: bool) -> Vec<Option<Stream<'a>>> {
        let mut channels = vec![Some(self.position)];
        channels.extend(with_normals.then_some(self.normal));
        channels.extend(&self.uvs);
        channels
    }
}

/// Stands for "no value": normals take the face's, texture coordinates (0, 0).
const ABSENT: u32 = u32::MAX;

fn assemble<'a>(
    loader: &mut Loader<'a>,
    element: Element<'a>,
    mut pools: Pools,
    layouts: &[Layout<'a>],
    with_normals: bool,
) -> Result<Mesh, Fault> {
    // A channel that always has the position's own index needs no index of its own.
    let all: Vec<Vec<Option<Stream>>> = layouts.iter().map(|layout| layout.channels(with_normals)).collect();
    let follows_position = |channel: usize| {
        all.iter().all(|channels| match (channels[0], channels[channel]) {
            (Some(p), Some(own)) => p.offset == own.offset && p.base == own.base && p.count <= own.count,
            _ => false,
        })
    };
    let width_all = 1 + usize::from(with_normals) + pools.sets.len();
    let separate: Vec<usize> = (0..width_all).filter(|&channel| channel == 0 || !follows_position(channel)).collect();
    let width = separate.len();
    let normal_column = separate.iter().position(|&channel| with_normals && channel == 1);

    let mut mesh = Mesh::default();
    let mut tuples: Vec<u32> = Vec::new();
    for (layout, channels) in layouts.iter().zip(&all) {
        let used: Vec<Stream> = channels.iter().flatten().copied().collect();
        let faces = primitives::read(loader, layout.primitive, layout.stride, &used, &pools.points.values)?;
        let columns: Vec<Option<Stream>> = separate.iter().map(|&channel| channels[channel]).collect();
        if tuples.len() / width + 3 * faces.triangles.len() > ABSENT as usize {
            return Err(layout.primitive.fault("the mesh has more than 2^32 corners"));
        }
        let first_triangle = tuples.len() / (3 * width);
        tuples.reserve(faces.triangles.len() * 3 * width);
        for triangle in &faces.triangles {
            let start = tuples.len();
            for &corner in triangle {
                let own = &faces.indices[corner as usize * layout.stride..];
                let index = |stream: &Stream| stream.base as u32 + own[stream.offset];
                tuples.extend(columns.iter().map(|stream| stream.as_ref().map_or(ABSENT, index)));
            }
            let points = [0, 1, 2].map(|corner| pools.points.values[tuples[start + corner * width] as usize]);
            if normals::area_vector(points).length_squared() == 0.0 {
                mesh.degenerate += 1;
                tuples.truncate(start);
            } else if let (Some(column), None) = (normal_column, layout.normal) {
                // Other primitives of this mesh have normals, this one is flat.
                let index = pools.normals.values.len() as u32;
                pools.normals.values.push(normals::face_normal(points));
                (0..3).for_each(|corner| tuples[start + corner * width + column] = index);
            }
        }
        let symbol = layout.primitive.attribute("material").unwrap_or_default().to_owned();
        let triangles = first_triangle..tuples.len() / (3 * width);
        if !triangles.is_empty() {
            mesh.groups.push(Group { symbol, triangles });
        }
    }
    fill(&mut mesh, pools, &tuples, &separate, with_normals, loader.options.smooth_normals);
    report(loader, element, &mut mesh);
    Ok(mesh)
}

/// Writes positions, normals and texture coordinates by vertex.
fn fill(mesh: &mut Mesh, pools: Pools, tuples: &[u32], separate: &[usize], with_normals: bool, smooth: bool) {
    let width = separate.len();
    let Pools {
        points: Pool { values: points, .. }, normals: Pool { values: mut file_normals, .. }, uvs, sets, ..
    } = pools;
    let count = points.len();
    if smooth {
        let corner = |corner: usize| tuples[corner * width] as usize;
        let triangles = (0..tuples.len() / (3 * width)).map(|t| [corner(3 * t), corner(3 * t + 1), corner(3 * t + 2)]);
        file_normals = normals::smooth(&points, triangles);
    }
    if width == 1 {
        mesh.triangles = tuples.chunks_exact(3).map(|corners| [corners[0], corners[1], corners[2]]).collect();
        if with_normals || smooth {
            file_normals.truncate(count);
            mesh.normals = file_normals;
        }
        let one_pool = |&set: &u32| UvSet { set, uvs: uvs.values.iter().take(count).copied().collect() };
        mesh.uv_sets = sets.iter().map(one_pool).collect();
        mesh.positions = points;
        return;
    }
    let unified = unify(tuples, width, count);
    mesh.triangles = unified.triangles;
    // The index of a vertex into a channel's pool.
    let index = |corner: u32, channel: usize| {
        let column = separate.iter().position(|&own| own == channel).unwrap_or(0);
        tuples[corner as usize * width + column] as usize
    };
    mesh.positions = unified.corners.iter().map(|&corner| points[index(corner, 0)]).collect();
    if with_normals || smooth {
        let channel = usize::from(!smooth);
        let normal = |&corner: &u32| file_normals.get(index(corner, channel)).copied().unwrap_or(Vec3::ZERO);
        mesh.normals = unified.corners.iter().map(normal).collect();
    }
    let first_uv = 1 + usize::from(with_normals);
    for (channel, &set) in sets.iter().enumerate() {
        let uv = |&corner: &u32| uvs.values.get(index(corner, first_uv + channel)).copied().unwrap_or(Vec2::ZERO);
        mesh.uv_sets.push(UvSet { set, uvs: unified.corners.iter().map(uv).collect() });
    }
}

fn report<'a>(loader: &mut Loader<'a>, element: Element<'a>, mesh: &mut Mesh) {
    if !mesh.normals.is_empty() {
        let broken = normals::repair(&mut mesh.normals, &mesh.positions, &mesh.triangles);
        if broken > 0 {
            let advice = "the normals of the faces around them are used";
            loader.warnings.add_many(element, broken, "a normal without length", advice);
        }
    }
    let mut lost = 0;
    for uv in mesh.uv_sets.iter_mut().flat_map(|set| &mut set.uvs).filter(|uv| !uv.is_finite()) {
        *uv = Vec2::ZERO;
        lost += 1;
    }
    if lost > 0 {
        loader.warnings.add_many(element, lost, "a texture coordinate that is not finite", "0 0 is used");
    }
    if mesh.degenerate > 0 {
        loader.warnings.add_many(element, mesh.degenerate, "a triangle without area", "it is dropped");
    }
}
