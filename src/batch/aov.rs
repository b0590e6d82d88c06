//! What a picture holds besides its colour, and the layers that it goes into.

use std::time::Instant;

use glam::Vec3;

use crate::denoise::{DenoiseError, Denoiser, Noisy};
use crate::document::Document;
use crate::output::{HeaderValue, Layer, LayerKind, cryptomatte};
use crate::render::{Frame, Seen, Survey};

/// The layer of the picture without its noise.
pub const DENOISED: &str = "denoised";
/// Beginning of the layer of each light group.
pub const LIGHT_GROUP: &str = "lg_";
/// The channels of [`Aov::Variance`].
pub const VARIANCE: [&str; 3] = ["variance.R", "variance.G", "variance.B"];

/// One kind of further values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Aov {
    /// What the first surface is painted in ([`Bsdf::albedo`](crate::bsdf::Bsdf::albedo)), linear sRGB.
    Albedo,
    /// Shading normal of the first surface, world space, unit length, on the camera's side.
    Normal,
    /// Its geometric normal.
    GeometricNormal,
    /// Distance along the viewing direction, metres; 1e10 where there is no surface.
    Depth,
    /// World space, metres.
    Position,
    /// Texture coordinates.
    Uv,
    /// Thickness of all films together, nm; 0 where there is none.
    Film,
    /// The variance of each pixel's mean, as if its samples were independent (they are stratified, which makes the true one
    /// smaller); infinite below two samples.
    Variance,
    /// Samples that each pixel has.
    SampleCount,
    /// Who covers how much of each pixel, by the ids of nodes: a Cryptomatte.
    Object,
    /// The same by the ids of materials.
    Material,
    /// The part of each light, or of each group of them ([`LightGroups`](crate::scene::LightGroups)): `lg_NAME`.
    Lights,
}

/// Layers with what the file's header has to say about them.
#[derive(Debug, Default)]
pub struct Layers {
    pub layers: Vec<Layer>,
    pub header: Vec<(String, HeaderValue)>,
}

impl Aov {
    /// Of its layer.
    pub fn name(self) -> &'static str {
        match self {
            Self::Albedo => "albedo",
            Self::Normal => "N",
            Self::GeometricNormal => "Ng",
            Self::Depth => "Z",
            Self::Position => "P",
            Self::Uv => "UV",
            Self::Film => "film",
            Self::Variance => "variance",
            Self::SampleCount => "sampleCount",
            Self::Object => "CryptoObject",
            Self::Material => "CryptoMaterial",
            Self::Lights => "lights",
        }
    }

    /// True where the scene has to be looked at for it, not only the picture.
    pub fn needs_survey(self) -> bool {
        !matches!(self, Self::Variance | Self::SampleCount | Self::Lights)
    }

    /// Its channels, as far as their names are known beforehand.
    fn channels(self) -> &'static [&'static str] {
        match self {
            Self::Albedo => &["albedo.R", "albedo.G", "albedo.B"],
            Self::Normal => &["N.X", "N.Y", "N.Z"],
            Self::GeometricNormal => &["Ng.X", "Ng.Y", "Ng.Z"],
            Self::Depth => &["Z"],
            Self::Position => &["P.X", "P.Y", "P.Z"],
            Self::Uv => &["UV.U", "UV.V"],
            Self::Film => &["film.thickness_nm"],
            Self::Variance => &VARIANCE,
            Self::SampleCount => &["sampleCount"],
            Self::Object | Self::Material | Self::Lights => &[],
        }
    }

    fn kind(self) -> LayerKind {
        match self {
            Self::Albedo | Self::Normal | Self::GeometricNormal => LayerKind::Half,
            _ => LayerKind::Float,
        }
    }

    /// The values of its channels.
    fn of(self, seen: &Seen) -> Vec3 {
        match self {
            Self::Albedo => seen.albedo,
            Self::Normal => seen.normal,
            Self::GeometricNormal => seen.ng,
            Self::Depth => Vec3::splat(seen.depth_m),
            Self::Position => seen.position,
            Self::Uv => seen.uv.extend(0.0),
            Self::Film => Vec3::splat(seen.film_nm),
            Self::Variance | Self::SampleCount | Self::Object | Self::Material | Self::Lights => Vec3::ZERO,
        }
    }
}

impl Layers {
    /// Of a picture and what else was found of it.
    pub fn new(aovs: &[Aov], frame: &Frame, survey: Option<&Survey>, document: &Document) -> Self {
        let mut made = Self::of_frame(aovs, frame);
        if let Some(survey) = survey {
            made.add_survey(aovs, survey, document);
        }
        made
    }

    /// Of those that can be told from the frame alone.
    pub fn of_frame(aovs: &[Aov], frame: &Frame) -> Self {
        let mut made = Self::default();
        for &aov in aovs {
            match aov {
                Aov::Variance => made.add(aov, || frame.variance.iter().map(|&variance| variance.into())),
                Aov::SampleCount => made.add(aov, || frame.samples.iter().map(|&count| Vec3::splat(count as f32))),
                _ => {}
            }
        }
        made
    }

    /// Adds those that a survey has found.
    fn add_survey(&mut self, aovs: &[Aov], survey: &Survey, document: &Document) {
        let count = survey.pixels().count();
        for &aov in aovs {
            match aov {
                Aov::Variance | Aov::SampleCount | Aov::Lights => {}
                Aov::Object => {
                    let name = |node| document.node_name(node as usize);
                    self.add_mattes(cryptomatte(aov.name(), count, survey.nodes(), name));
                }
                Aov::Material => {
                    let name = |material| document.material_name(material as usize);
                    self.add_mattes(cryptomatte(aov.name(), count, survey.materials(), name));
                }
                _ => self.add(aov, || survey.pixels().map(|seen| aov.of(&seen))),
            }
        }
    }

    /// Adds a layer of R, G and B.
    pub fn add_color(&mut self, name: &str, kind: LayerKind, pixels: &[[f32; 3]]) {
        for (channel, letter) in ["R", "G", "B"].into_iter().enumerate() {
            let data = pixels.iter().map(|rgb| rgb[channel]).collect();
            self.layers.push(Layer { name: format!("{name}.{letter}"), kind, data });
        }
    }

    /// Adds the picture without its noise, in the kind of the picture itself; gives back the seconds that it took.
    ///
    /// # Errors
    /// What the library says.
    pub fn denoise(
        &mut self,
        denoiser: &Denoiser,
        frame: &Frame,
        survey: &Survey,
        kind: LayerKind,
        threads: usize,
    ) -> Result<f64, DenoiseError> {
        let clock = Instant::now();
        let noisy = Noisy {
            width: frame.width as usize,
            height: frame.height as usize,
            rgb: &frame.rgb,
            albedo: survey.pixels().map(|seen| seen.clue.albedo).collect(),
            normal: survey.pixels().map(|seen| seen.clue.normal).collect(),
        };
        let clean = denoiser.denoise(noisy, threads)?;
        self.add_color(DENOISED, kind, &clean);
        self.header.push(("pellicle/denoiser".to_owned(), HeaderValue::Text(denoiser.version())));
        Ok(clock.elapsed().as_secs_f64())
    }

    fn add<I: Iterator<Item = Vec3>>(&mut self, aov: Aov, values: impl Fn() -> I) {
        for (channel, &name) in aov.channels().iter().enumerate() {
            let data = values().map(|value| value[channel]).collect();
            self.layers.push(Layer { name: name.to_owned(), kind: aov.kind(), data });
        }
    }

    fn add_mattes(&mut self, (layers, header): (Vec<Layer>, Vec<(String, HeaderValue)>)) {
        self.layers.extend(layers);
        self.header.extend(header);
    }
}
