//! Triangles as a file gives them, each corner with indices of its own, and the mesh that they make.

use glam::{Vec2, Vec3};

use crate::document::{Group, Mesh, UvSet};

use super::crease;
use super::error::{Fault, Notes};
use super::normals;
use super::polygons;
use super::vertices::unify;

/// Stands for "the file gives none".
pub const ABSENT: u32 = u32::MAX;

/// Indices per corner: point, normal, texture coordinates.
pub const WIDTH: usize = 3;

/// Corners beyond which 32 bits do not number them.
const MOST_CORNERS: usize = u32::MAX as usize - 1;

/// Bytes per corner while a mesh is made: indices here, in the way from points to corners, and of the vertex it becomes.
const CORNER_BYTES: u64 = 48;

#[derive(Default)]
pub struct Soup {
    pub points: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    /// [`WIDTH`] indices per corner, three corners per triangle; normals and texture coordinates may be [`ABSENT`].
    corners: Vec<u32>,
    /// Names of materials with the first triangle that has each.
    runs: Vec<(String, usize)>,
    /// Memory that the mesh may take.
    max_bytes: u64,
    /// Buffers of [`polygon`](Self::polygon).
    outline: Vec<Vec3>,
    cut: Vec<[usize; 3]>,
}

impl Soup {
    /// Nothing yet, of what may take so much memory.
    pub fn within(max_bytes: u64) -> Self {
        Self { max_bytes, ..Self::default() }
    }

    /// Triangles from now on have this material.
    pub fn use_material(&mut self, name: &str) {
        let from = self.triangle_count();
        match self.runs.last_mut() {
            Some(run) if run.1 == from => run.0 = name.to_owned(),
            _ => self.runs.push((name.to_owned(), from)),
        }
    }

    /// Cuts a polygon with three or more corners into triangles. Its indices must be in range.
    ///
    /// # Errors
    /// More corners than 32 bits number or the memory holds.
    pub fn polygon(&mut self, corners: &[[u32; WIDTH]]) -> Result<(), Fault> {
        let count = self.corners.len() / WIDTH + 3 * corners.len();
        if count > MOST_CORNERS {
            return Err(Fault::new("the model has more than 2^32 corners").hint("split it into several files"));
        }
        if count as u64 * CORNER_BYTES > self.max_bytes {
            let message = format!("the model takes more than {} bytes of memory", self.max_bytes);
            return Err(Fault::new(message).hint("raise --max-memory if the file is right"));
        }
        self.outline.clear();
        self.outline.extend(corners.iter().map(|corner| self.points[corner[0] as usize]));
        self.cut.clear();
        polygons::triangulate(&self.outline, &mut self.cut);
        self.corners.extend(self.cut.iter().flatten().flat_map(|&corner| corners[corner]));
        Ok(())
    }

    fn triangle_count(&self) -> usize {
        self.corners.len() / (3 * WIDTH)
    }

    /// The mesh. Normals that the file lacks are those of the faces around, smooth where they meet at a blunt angle; with
    /// `smooth` all are, whatever the file says and the angle is.
    pub fn finish(mut self, smooth: bool, notes: &mut Notes) -> Mesh {
        let mut mesh = Mesh::default();
        self.drop_degenerate(&mut mesh);
        if mesh.degenerate > 0 {
            notes.add(1, mesh.degenerate, "a triangle without area", "it is dropped");
        }
        if smooth {
            let point = |corner: usize| self.corners[WIDTH * corner] as usize;
            let triangles = (0..self.triangle_count()).map(|t| [point(3 * t), point(3 * t + 1), point(3 * t + 2)]);
            self.normals = normals::smooth(&self.points, triangles);
            self.corners.chunks_exact_mut(WIDTH).for_each(|corner| corner[1] = corner[0]);
        } else {
            crease::fill(&self.points, &mut self.normals, &mut self.corners);
        }
        let unified = unify(&self.corners, WIDTH, self.points.len());
        let index = |corner: &u32, channel: usize| self.corners[*corner as usize * WIDTH + channel] as usize;
        mesh.triangles = unified.triangles;
        mesh.positions = unified.corners.iter().map(|corner| self.points[index(corner, 0)]).collect();
        mesh.normals = unified.corners.iter().map(|corner| self.normals[index(corner, 1)]).collect();
        if !self.uvs.is_empty() {
            let uv = |corner: &u32| self.uvs.get(index(corner, 2)).copied().unwrap_or(Vec2::ZERO);
            mesh.uv_sets.push(UvSet { set: 0, uvs: unified.corners.iter().map(uv).collect() });
        }
        let broken = normals::repair(&mut mesh.normals, &mesh.positions, &mesh.triangles);
        if broken > 0 {
            notes.add(1, broken, "a normal without length", "the normals of the faces around it are used");
        }
        mesh
    }

    /// Moves the triangles with area together, and turns the runs into groups of them.
    fn drop_degenerate(&mut self, mesh: &mut Mesh) {
        let runs = std::mem::take(&mut self.runs);
        let count = self.triangle_count();
        // Triangles before the first name have none.
        let nameless = runs.first().is_none_or(|run| run.1 > 0).then(|| (String::new(), 0));
        let runs: Vec<(String, usize)> = nameless.into_iter().chain(runs).collect();
        let mut kept = 0;
        for (i, (symbol, first)) in runs.iter().enumerate() {
            let end = runs.get(i + 1).map_or(count, |next| next.1);
            let start = kept;
            for triangle in *first..end {
                let at = |corner: usize| WIDTH * (3 * triangle + corner);
                let points = [0, 1, 2].map(|corner| self.points[self.corners[at(corner)] as usize]);
                if normals::area_vector(points).length_squared() > 0.0 {
                    self.corners.copy_within(at(0)..at(3), 3 * WIDTH * kept);
                    kept += 1;
                }
            }
            if kept > start {
                mesh.groups.push(Group { symbol: symbol.clone(), triangles: start..kept });
            }
        }
        mesh.degenerate = count - kept;
        self.corners.truncate(3 * WIDTH * kept);
    }
}
