//! Primitive elements to triangles of corners.

use glam::Vec3;

use crate::mesh::polygons;

use super::error::Fault;
use super::loader::Loader;
use super::numbers;
use super::sources::check_count;
use super::xml::Element;

pub const SURFACES: [&str; 5] = ["triangles", "polylist", "polygons", "tristrips", "trifans"];
pub const LINES: [&str; 2] = ["lines", "linestrips"];

/// One index stream of a primitive.
#[derive(Clone, Copy)]
pub struct Stream<'a> {
    pub offset: usize,
    /// Where this stream's source begins in its pool.
    pub base: usize,
    /// Elements of the source.
    pub count: usize,
    pub source: Element<'a>,
}

/// Indices as they stand in the file, and the triangles cut from them.
#[derive(Default)]
pub struct Faces {
    /// `stride` indices per corner.
    pub indices: Vec<u32>,
    /// Corner numbers.
    pub triangles: Vec<[u32; 3]>,
}

/// Reads all faces of a primitive. `streams[0]` is the position; `points` its pool.
pub fn read<'a>(
    loader: &mut Loader<'a>,
    primitive: Element<'a>,
    stride: usize,
    streams: &[Stream<'a>],
    points: &[Vec3],
) -> Result<Faces, Fault> {
    let mut faces = Faces::default();
    let mut loops = Vec::new();
    for child in primitive.children() {
        match child.name() {
            "p" => loops.push(vec![faces.list(child, stride, streams)?]),
            "ph" => {
                let rings: Result<Vec<_>, Fault> = child
                    .children()
                    .filter(|ring| matches!(ring.name(), "p" | "h"))
                    .map(|ring| faces.list(ring, stride, streams))
                    .collect();
                loops.push(rings?);
            }
            _ => {}
        }
    }
    let position =
        |corner: usize| points[streams[0].base + faces.indices[corner * stride + streams[0].offset] as usize];
    let mut cutter = Cutter { position: &position, points: Vec::new(), cut: Vec::new(), triangles: Vec::new() };
    let count = match primitive.name() {
        "triangles" => {
            for ring in loops.iter().flatten() {
                if ring.len() % 3 != 0 {
                    let message = format!("{} corners do not make whole triangles", ring.len());
                    return Err(primitive.fault(message));
                }
                cutter.triangles.extend(ring.clone().step_by(3).map(|corner| triple([corner, corner + 1, corner + 2])));
            }
            cutter.triangles.len()
        }
        "polylist" => {
            let corners = loops.iter().flatten().map(|ring| ring.len()).sum();
            polylist(primitive, corners, &mut cutter)?
        }
        "tristrips" => {
            for ring in loops.iter().flatten() {
                // Every second triangle of a strip is wound the other way.
                let triangle = |i: usize| if i % 2 == 0 { [i, i + 1, i + 2] } else { [i + 1, i, i + 2] };
                let last = ring.len().saturating_sub(2);
                cutter.triangles.extend((0..last).map(|i| triple(triangle(i).map(|corner| ring.start + corner))));
            }
            loops.len()
        }
        "trifans" => {
            for ring in loops.iter().flatten() {
                let last = ring.len().saturating_sub(1);
                cutter.triangles.extend((1..last).map(|i| triple([ring.start, ring.start + i, ring.start + i + 1])));
            }
            loops.len()
        }
        _ => {
            loops.iter().for_each(|rings| cutter.cut(rings));
            loops.len()
        }
    };
    let triangles = cutter.triangles;
    faces.triangles = triangles;
    check_count(loader, primitive, count, primitive.name())?;
    Ok(faces)
}

fn triple(corners: [usize; 3]) -> [u32; 3] {
    // A corner takes two bytes of the file at least, so numbers stay below 2^32 for every file that fits the limit.
    corners.map(|corner| corner as u32)
}

impl Faces {
    /// Appends one list of indices; returns its range in corners.
    fn list(&mut self, p: Element, stride: usize, streams: &[Stream]) -> Result<std::ops::Range<usize>, Fault> {
        let start = self.indices.len();
        numbers::indices(p, &mut self.indices)?;
        let added = &self.indices[start..];
        if added.len() % stride != 0 {
            let message = format!("{} indices are not a multiple of the {stride} inputs per corner", added.len());
            return Err(p.fault(message));
        }
        for stream in streams {
            let own = added.iter().skip(stream.offset).step_by(stride);
            let Some(corner) = own.clone().position(|&index| index as usize >= stream.count) else { continue };
            let token = corner * stride + stream.offset;
            let id = stream.source.attribute("id").unwrap_or_default();
            let message =
                format!("index {} is out of range: source `{id}` has {} elements", added[token], stream.count);
            return Err(p.fault_at(numbers::token_span(p, token), message));
        }
        Ok(start / stride..self.indices.len() / stride)
    }
}

/// Cuts polygons, keeping its buffers from one to the next.
struct Cutter<'f> {
    position: &'f dyn Fn(usize) -> Vec3,
    points: Vec<Vec3>,
    cut: Vec<[usize; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Cutter<'_> {
    /// One polygon: its outline, then its holes, each a range of corners.
    fn cut(&mut self, rings: &[std::ops::Range<usize>]) {
        let corners: Vec<usize> = rings.iter().flat_map(|ring| ring.clone()).collect();
        self.points.clear();
        self.points.extend(corners.iter().map(|&corner| (self.position)(corner)));
        self.cut.clear();
        if rings.len() == 1 {
            polygons::triangulate(&self.points, &mut self.cut);
        } else {
            let mut start = 0;
            let local = |ring: &std::ops::Range<usize>| {
                start += ring.len();
                start - ring.len()..start
            };
            let loops: Vec<_> = rings.iter().map(local).collect();
            polygons::triangulate_with_holes(&self.points, &loops, &mut self.cut);
        }
        self.triangles.extend(self.cut.iter().map(|triangle| triple(triangle.map(|local| corners[local]))));
    }
}

/// Returns the number of polygons.
fn polylist(primitive: Element, corners: usize, cutter: &mut Cutter) -> Result<usize, Fault> {
    let Some(vcount) = primitive.child("vcount") else {
        return Err(primitive.fault("this <polylist> has no <vcount>"));
    };
    let mut sizes = Vec::new();
    numbers::indices(vcount, &mut sizes)?;
    let wanted: u64 = sizes.iter().map(|&size| u64::from(size)).sum();
    if wanted != corners as u64 {
        return Err(vcount.fault(format!("<vcount> adds up to {wanted} corners, <p> holds {corners}")));
    }
    let mut start = 0;
    for &size in &sizes {
        let end = start + size as usize;
        if size == 3 {
            cutter.triangles.push(triple([start, start + 1, start + 2]));
        } else {
            let ring = start..end;
            cutter.cut(std::slice::from_ref(&ring));
        }
        start = end;
    }
    Ok(sizes.len())
}
