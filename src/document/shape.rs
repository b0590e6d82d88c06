//! Shapes: triangle meshes and spheres.

use glam::{Vec2, Vec3};

/// A shape that nodes instantiate.
#[derive(Clone, Debug)]
pub struct Geometry {
    pub id: String,
    pub shape: Shape,
}

#[derive(Clone, Debug)]
pub enum Shape {
    Mesh(Mesh),
    /// CGL `<sphere>`: centred on the node's origin; radius in file units, scaled by the node's local x axis.
    Sphere {
        radius: f32,
    },
}

impl Shape {
    /// Least and largest coordinates; `None` for a mesh without vertices.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        match self {
            Self::Sphere { radius } => Some((Vec3::splat(-radius), Vec3::splat(*radius))),
            Self::Mesh(mesh) => {
                let first = *mesh.positions.first()?;
                Some(mesh.positions.iter().fold((first, first), |(low, high), p| (low.min(*p), high.max(*p))))
            }
        }
    }
}

/// Triangles with unified vertices: index `i` addresses position, normal and every texture coordinate set alike.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    pub positions: Vec<Vec3>,
    /// One per position (unit length), or empty: flat shading.
    pub normals: Vec<Vec3>,
    /// Texture coordinate sets in file order, each one per position; (0, 0) is the image's lower left corner.
    pub uv_sets: Vec<UvSet>,
    pub triangles: Vec<[u32; 3]>,
    /// Consecutive runs of `triangles` that cover them all.
    pub groups: Vec<Group>,
    /// Triangles of zero area that the loader dropped.
    pub degenerate: usize,
}

impl Mesh {
    /// What it takes in memory.
    pub fn bytes(&self) -> usize {
        let uvs: usize = self.uv_sets.iter().map(|set| set.uvs.len()).sum();
        let points = self.positions.len() + self.normals.len();
        points * size_of::<Vec3>() + uvs * size_of::<Vec2>() + self.triangles.len() * size_of::<[u32; 3]>()
    }
}

#[derive(Clone, Debug)]
pub struct UvSet {
    /// The `set` attribute of the input (0 when absent).
    pub set: u32,
    pub uvs: Vec<Vec2>,
}

/// A run of triangles with one material symbol.
#[derive(Clone, Debug)]
pub struct Group {
    /// Matched against [`Binding::symbol`](super::Binding::symbol); empty when the primitive names none.
    pub symbol: String,
    pub triangles: std::ops::Range<usize>,
}
