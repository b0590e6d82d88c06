//! Values that may vary over a surface, and the images they come from.

use std::path::PathBuf;

use glam::Vec3;

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
    /// The texel becomes `range[0] + (range[1] - range[0]) * texel`.
    pub range: [f32; 2],
}

impl Scalar {
    pub fn constant(value: f32) -> Self {
        Self::mapped(value, None)
    }

    /// With an image whose texels are the number itself.
    pub fn mapped(value: f32, map: Option<Map>) -> Self {
        Self { value, map, range: [0.0, 1.0] }
    }
}

/// A reference to an image with the way to read it.
#[derive(Clone, Debug)]
pub struct Map {
    pub image: usize,
    /// `texcoord` name, resolved per instance through [`Binding::uv_sets`](super::Binding::uv_sets); empty: the first set.
    pub texcoord: String,
    /// Which of the material's texture coordinates that is ([`Material::number_texcoords`](super::Material::number_texcoords)).
    pub slot: usize,
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
    /// Rec. 709 luminance of the three.
    Luminance,
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
    /// Who refers to it first, for messages: "material `gold`".
    pub user: String,
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
