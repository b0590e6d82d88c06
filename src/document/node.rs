//! The transform hierarchy and what hangs in it.

use glam::{Mat4, Vec3};

/// One node of the transform hierarchy.
#[derive(Clone, Debug, Default)]
pub struct Node {
    pub id: String,
    pub name: String,
    pub sid: String,
    /// Composed in order, left to right: M = T1 * T2 * ...
    pub transforms: Vec<Transform>,
    pub items: Vec<Item>,
    pub children: Vec<usize>,
}

/// One transform element, kept apart so that animation channels can address its parts.
#[derive(Clone, Debug)]
pub struct Transform {
    pub sid: String,
    pub kind: TransformKind,
}

#[derive(Clone, Copy, Debug)]
pub enum TransformKind {
    Matrix(Mat4),
    Translate(Vec3),
    Rotate {
        axis: Vec3,
        angle_deg: f32,
    },
    Scale(Vec3),
    LookAt {
        eye: Vec3,
        target: Vec3,
        up: Vec3,
    },
    /// RenderMan style: moves points along `translation` so that `rotation` tilts towards it by `angle_deg`.
    Skew {
        angle_deg: f32,
        rotation: Vec3,
        translation: Vec3,
    },
}

/// What a node puts into the scene.
#[derive(Clone, Debug)]
pub enum Item {
    Geometry { geometry: usize, bindings: Vec<Binding> },
    Light(usize),
    Camera(usize),
}

/// `<instance_material>`: which material a symbol means for this instance.
#[derive(Clone, Debug)]
pub struct Binding {
    pub symbol: String,
    pub material: usize,
    /// `<bind_vertex_input>`: texture coordinate name -> `TEXCOORD` set number.
    pub uv_sets: Vec<(String, u32)>,
}

impl Node {
    /// The node's own transform, parent space from node space.
    pub fn local(&self) -> Mat4 {
        self.transforms.iter().fold(Mat4::IDENTITY, |product, transform| product * transform.kind.matrix())
    }
}

impl TransformKind {
    /// The 4x4 matrix of this element (column vectors).
    pub fn matrix(&self) -> Mat4 {
        match *self {
            Self::Matrix(matrix) => matrix,
            Self::Translate(offset) => Mat4::from_translation(offset),
            Self::Rotate { axis, angle_deg } => match axis.try_normalize() {
                Some(axis) => Mat4::from_axis_angle(axis, angle_deg.to_radians()),
                None => Mat4::IDENTITY,
            },
            Self::Scale(factors) => Mat4::from_scale(factors),
            Self::LookAt { eye, target, up } => Mat4::look_at_rh(eye, target, up).inverse(),
            Self::Skew { angle_deg, rotation, translation } => skew(angle_deg, rotation, translation),
        }
    }
}

/// The matrix of [`TransformKind::Skew`]: COLLADA 1.4.1 specification, element `<skew>`; RenderMan Interface 3.2, `RiSkew`.
fn skew(angle_deg: f32, rotation: Vec3, translation: Vec3) -> Mat4 {
    let (Some(along), Some(from)) = (translation.try_normalize(), rotation.try_normalize()) else {
        return Mat4::IDENTITY;
    };
    // Split `from` into its parts along and across the translation axis; tilt the across part by the angle.
    let along_part = from.dot(along);
    let Some(across) = (from - along * along_part).try_normalize() else {
        return Mat4::IDENTITY;
    };
    let across_part = from.dot(across);
    let (sin, cos) = angle_deg.to_radians().sin_cos();
    let turned_across = across_part * cos - along_part * sin;
    let turned_along = across_part * sin + along_part * cos;
    if turned_across <= 0.0 {
        return Mat4::IDENTITY;
    }
    let shear = turned_along / turned_across - along_part / across_part;
    let column = |axis: Vec3| (axis + along * (shear * axis.dot(across))).extend(0.0);
    Mat4::from_cols(column(Vec3::X), column(Vec3::Y), column(Vec3::Z), glam::Vec4::W)
}
