//! The scene as plain data: what a file says, before anything is built from it.
//!
//! No XML, no Embree, no colour mode. `collada` fills it, `scene::build` reads it. Lists refer to each other by index, so a
//! `Document` can be cloned, compared and animated freely. Lengths are in file units until [`Document::to_world`] is
//! applied (metres, Y up, right-handed afterwards); wavelengths and film thicknesses are nanometres; colours are linear
//! sRGB.

use std::path::PathBuf;

use glam::{Mat4, Vec2, Vec3};

use crate::color::{Emission, Index};

/// Everything one scene file holds.
#[derive(Clone, Debug, Default)]
pub struct Document {
    /// The file it came from, for messages.
    pub path: PathBuf,
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

#[derive(Clone, Debug)]
pub struct UvSet {
    /// The `set` attribute of the input (0 when absent).
    pub set: u32,
    pub uvs: Vec<Vec2>,
}

/// A run of triangles with one material symbol.
#[derive(Clone, Debug)]
pub struct Group {
    /// Matched against [`Binding::symbol`]; empty when the primitive names none.
    pub symbol: String,
    pub triangles: std::ops::Range<usize>,
}

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
    /// RenderMan style: shear by `angle_deg` from `along` towards `around` is about `rotation` x `translation` axes.
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

/// A surface: one base under any number of films, outermost first.
#[derive(Clone, Debug, Default)]
pub struct Material {
    pub id: String,
    pub base: Base,
    pub films: Vec<Film>,
    pub emission: Option<SurfaceEmission>,
    /// Multiplies reflected and transmitted light (CGL tints); 1 = none.
    pub tint: Tint,
    pub normal_map: Option<NormalMap>,
    /// Coverage: 0 lets everything through unbent.
    pub opacity: Scalar,
}

#[derive(Clone, Debug)]
pub enum Base {
    /// Reflects nothing (a pure emitter).
    Black,
    /// Lambertian. Under a film it becomes an interfaced diffuse base whose inside has refractive index `ior`.
    Diffuse {
        reflectance: Texture,
        ior: f32,
    },
    Conductor {
        index: Index,
        microfacets: Microfacets,
    },
    Dielectric {
        index: Index,
        microfacets: Microfacets,
        /// Beer-Lambert absorption inside, linear RGB, 1/m.
        absorption_per_m: Vec3,
        /// False for CGL `<refraction>`, which transmits everything and reflects nothing.
        fresnel: bool,
    },
}

impl Default for Base {
    fn default() -> Self {
        Self::Diffuse { reflectance: Texture::constant(Vec3::splat(0.5)), ior: 1.5 }
    }
}

#[derive(Clone, Debug, Default)]
pub struct Microfacets {
    pub distribution: Distribution,
    /// The distribution's alpha itself, 0..1; 0 is perfectly smooth.
    pub roughness: Scalar,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Distribution {
    #[default]
    Ggx,
    Beckmann,
}

#[derive(Clone, Copy, Debug)]
pub struct Tint {
    pub reflect: Vec3,
    pub transmit: Vec3,
}

impl Default for Tint {
    fn default() -> Self {
        Self { reflect: Vec3::ONE, transmit: Vec3::ONE }
    }
}

/// Light that a surface sends out.
#[derive(Clone, Debug)]
pub struct SurfaceEmission {
    /// W/(sr m2) per channel.
    pub radiance: Texture,
    pub spectrum: Emission,
    pub two_sided: bool,
}

/// One homogeneous thin layer.
#[derive(Clone, Debug)]
pub struct Film {
    pub index: Index,
    pub thickness: Thickness,
    /// Coverage of the film, 0..1.
    pub weight: f32,
}

#[derive(Clone, Debug)]
pub enum Thickness {
    Constant {
        nm: f32,
    },
    /// nm * (1 + amplitude * noise(frequency * p)), improved Perlin noise in [-1, 1] at the object-space point.
    Noise {
        nm: f32,
        amplitude: f32,
        frequency: f32,
        octaves: u32,
        seed: u32,
    },
    /// Gravity drainage between the object's highest and lowest point along world up.
    Drain {
        top_nm: f32,
        bottom_nm: f32,
        exponent: f32,
    },
    /// mix(min, max, texel), the texel read as linear data.
    Map {
        min_nm: f32,
        max_nm: f32,
        map: Map,
    },
}

/// An RGB value, times an image where there is one.
#[derive(Clone, Debug)]
pub struct Texture {
    pub value: Vec3,
    pub map: Option<Map>,
}

impl Texture {
    pub fn constant(value: Vec3) -> Self {
        Self { value, map: None }
    }
}

/// A number, replaced by an image channel where there is one.
#[derive(Clone, Debug)]
pub struct Scalar {
    pub value: f32,
    pub map: Option<Map>,
}

impl Scalar {
    pub fn constant(value: f32) -> Self {
        Self { value, map: None }
    }
}

impl Default for Scalar {
    /// Smooth roughness; note that opacity starts at 1 (see `Material::opacity` users).
    fn default() -> Self {
        Self::constant(0.0)
    }
}

/// A reference to an image with the way to read it.
#[derive(Clone, Debug)]
pub struct Map {
    pub image: usize,
    /// `texcoord` name, resolved per instance through [`Binding::uv_sets`]; empty: the first set.
    pub texcoord: String,
    pub encoding: Encoding,
    pub channel: Channel4,
    pub wrap: [Wrap; 2],
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    Srgb,
    #[default]
    Linear,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Channel4 {
    R,
    #[default]
    G,
    B,
    A,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    #[default]
    Repeat,
    Mirror,
    Clamp,
    /// Outside is black (COLLADA BORDER and NONE).
    Border,
}

/// Tangent-space normals.
#[derive(Clone, Debug)]
pub struct NormalMap {
    pub map: Map,
    pub scale: f32,
}

/// An image file, resolved and inside the allowed folders; its pixels are read when the scene is built.
#[derive(Clone, Debug)]
pub struct Image {
    pub id: String,
    /// As written in the file, for messages.
    pub uri: String,
    pub source: ImageSource,
}

#[derive(Clone, Debug)]
pub enum ImageSource {
    File(PathBuf),
    /// A member of a `.zae` archive, already unpacked.
    Bytes(Vec<u8>),
    /// Absent, and `--missing-texture=magenta` said to go on.
    Missing,
}

/// A light source that is not a surface material.
#[derive(Clone, Debug)]
pub struct Light {
    pub id: String,
    pub kind: LightKind,
    /// Radiant intensity (point, spot; W/sr), irradiance (directional; W/m2) or radiance (area, ambient; W/(sr m2)).
    pub color: Vec3,
    pub spectrum: Emission,
}

#[derive(Clone, Copy, Debug)]
pub enum LightKind {
    /// One-sided along local -Z.
    Area { shape: AreaShape, visible: bool },
    /// A point, or a sphere of `radius_m` with the same intensity.
    Point { radius_m: f32, falloff: Falloff },
    /// Along local -Z. `cone_deg` is the full angle. Inside, intensity is scaled by `edge`.
    Spot { cone_deg: f32, edge: SpotEdge, radius_m: f32, falloff: Falloff },
    /// Shines along local -Z; `angle_deg` is the full angle of the disc it comes from (0 = parallel).
    Directional { angle_deg: f32 },
    /// Constant radiance from the upper hemisphere (+Y in world space), as the CS184 course has it.
    Ambient,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AreaShape {
    /// Unit square in local XY, centred, times the node matrix.
    Rectangle,
    /// Unit-diameter disc in local XY, centred, times the node matrix.
    Disk,
    /// Unit-diameter sphere, radius scaled by the node's local x axis; radiates outwards.
    Sphere,
}

/// How intensity falls off with distance d (metres of the file's own unit).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Falloff {
    /// 1 / d^2.
    Physical,
    /// 1 / (constant + linear d + quadratic d^2), literally.
    Attenuation { constant: f32, linear: f32, quadratic: f32 },
}

#[derive(Clone, Copy, Debug)]
pub enum SpotEdge {
    /// cos(angle)^exponent inside the cone (COLLADA `falloff_exponent`).
    Exponent(f32),
    /// Blender's `spot_blend`, 0..1: a smooth step over that share of the cone.
    Blend(f32),
}

#[derive(Clone, Debug)]
pub struct Camera {
    pub id: String,
    pub projection: Projection,
    pub lens: Option<Lens>,
    /// Lens shift as a share of the larger picture side (Blender's `shiftx`, `shifty`).
    pub shift: Vec2,
}

#[derive(Clone, Copy, Debug)]
pub enum Projection {
    /// Full angles in degrees; at least one of the two fovs is given. `aspect` = width / height.
    Perspective { xfov_deg: Option<f32>, yfov_deg: Option<f32>, aspect: Option<f32> },
    /// Half extents in file units; at least one is given.
    Orthographic { xmag: Option<f32>, ymag: Option<f32>, aspect: Option<f32> },
}

/// Thin lens.
#[derive(Clone, Copy, Debug)]
pub struct Lens {
    pub aperture_radius_m: f32,
    pub focus_distance_m: f32,
    /// Sides of the aperture; below 3 it is round.
    pub blades: u32,
}

/// Light from infinitely far away, all around.
#[derive(Clone, Debug)]
pub struct Environment {
    /// Lat-long image; v = 0 at +y, u = atan2(x, -z) / 2 pi.
    pub image: Option<usize>,
    /// Constant radiance, or the image's tint.
    pub radiance: Vec3,
    pub strength: f32,
    pub rotation_deg: f32,
    pub spectrum: Emission,
}

/// What the scene file asks of the renderer; the command line overrides each.
#[derive(Clone, Debug, Default)]
pub struct RenderHints {
    pub width: Option<u32>,
    pub height: Option<u32>,
    pub spp: Option<u32>,
    pub seed: Option<u32>,
    pub max_bounces: Option<u32>,
    pub mode: Option<String>,
    pub tolerance: Option<f32>,
    pub exposure_ev: Option<f32>,
    /// Id of a camera or of a camera's node.
    pub camera: Option<String>,
}

/// One `<channel>` with its sampler: a curve over time that drives a target.
#[derive(Clone, Debug)]
pub struct Channel {
    /// As written: `node/sid.X`, `node/sid(3)(0)`, `camera/xfov`, ...
    pub target: String,
    pub times_s: Vec<f32>,
    /// Row-major: `times_s.len()` rows of `width` values.
    pub values: Vec<f32>,
    pub width: usize,
    /// One per key; how the curve runs from this key to the next.
    pub interpolation: Vec<Interpolation>,
    /// BEZIER and HERMITE tangents, `width` (time, value) pairs per key (1-D tangents have been given their times); empty when the curve has none.
    pub in_tangents: Vec<Vec2>,
    pub out_tangents: Vec<Vec2>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    Linear,
    Step,
    Bezier,
    Hermite,
}

impl Document {
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

/// RenderMan's shear: moves points along `translation` so that `rotation` tilts towards it by `angle_deg`.
/// COLLADA 1.4.1 specification, element `<skew>`; RenderMan Interface 3.2, `RiSkew`.
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
