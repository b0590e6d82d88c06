//! How picture files are written: shared by every subcommand that writes some.

use clap::{Args, ValueEnum};

use crate::batch::aov::Aov;
use crate::batch::still::Look;
use crate::color::view::View;
use crate::error::Error;
use crate::output::{Display, PngDepth};

#[derive(Args)]
pub struct FileArgs {
    /// Bits per channel of PNG pictures
    #[arg(long, value_name = "BITS", value_parser = ["8", "16"], default_value = "8")]
    png_depth: String,
    /// How PNG pictures show colours [default: srgb]
    #[arg(long, value_name = "NAME", value_enum)]
    view: Option<ViewArg>,
    /// Write 32-bit instead of 16-bit floats to EXR
    #[arg(long)]
    float: bool,
    /// More layers, with commas between them: in the EXR, or as PNG files beside the PNG (NAME.N.png, ...)
    #[arg(long = "aov", value_name = "LIST", value_enum, value_delimiter = ',', ignore_case = true)]
    aovs: Vec<AovArg>,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum ViewArg {
    /// The sRGB curve; colours beyond sRGB keep their hue
    Srgb,
    /// AgX: a long range of brightness, bright colours pale to white
    Agx,
    /// A film-like curve (Narkowicz's fit to ACES)
    Filmic,
    /// The sRGB curve, each channel clipped for itself
    None,
}

#[derive(Clone, Copy, ValueEnum)]
enum AovArg {
    /// What the first surface is painted in; of a metal, what it reflects straight on, with its films
    Albedo,
    /// Shading normal, world space
    #[value(name = "N", alias = "normal")]
    Normal,
    /// Geometric normal, world space
    #[value(name = "Ng")]
    GeometricNormal,
    /// Depth along the view, metres
    #[value(name = "Z", alias = "depth")]
    Depth,
    /// Position, world space, metres
    #[value(name = "P", alias = "position")]
    Position,
    /// Texture coordinates
    #[value(name = "UV")]
    Uv,
    /// Thickness of all films together, nm (film.thickness_nm)
    Film,
    /// Variance of each pixel's mean
    Variance,
    /// Samples of each pixel (sampleCount)
    #[value(alias = "sampleCount")]
    Samples,
    /// Cryptomatte of nodes (CryptoObject00, ...)
    Object,
    /// Cryptomatte of materials (CryptoMaterial00, ...)
    Material,
    /// The part of each light, shining material and the environment (lg_NAME), up to eight
    Lights,
}

impl From<ViewArg> for View {
    fn from(view: ViewArg) -> Self {
        match view {
            ViewArg::Srgb => Self::Srgb,
            ViewArg::Agx => Self::Agx,
            ViewArg::Filmic => Self::Filmic,
            ViewArg::None => Self::None,
        }
    }
}

impl AovArg {
    fn aov(self) -> Aov {
        match self {
            Self::Albedo => Aov::Albedo,
            Self::Normal => Aov::Normal,
            Self::GeometricNormal => Aov::GeometricNormal,
            Self::Depth => Aov::Depth,
            Self::Position => Aov::Position,
            Self::Uv => Aov::Uv,
            Self::Film => Aov::Film,
            Self::Variance => Aov::Variance,
            Self::Samples => Aov::SampleCount,
            Self::Object => Aov::Object,
            Self::Material => Aov::Material,
            Self::Lights => Aov::Lights,
        }
    }
}

impl FileArgs {
    /// `display` unless the user wants another view.
    pub fn look(&self, display: Display) -> Look {
        let png_depth = if self.png_depth == "16" { PngDepth::Sixteen } else { PngDepth::Eight };
        let view = self.view.map_or(display.view, View::from);
        Look { display: Display { view, ..display }, png_depth, float: self.float }
    }

    /// Each once.
    pub fn aovs(&self) -> Vec<Aov> {
        let mut aovs: Vec<Aov> = self.aovs.iter().map(|arg| arg.aov()).collect();
        aovs.sort();
        aovs.dedup();
        aovs
    }

    /// Telling lights apart has its limits.
    pub fn check_lights(&self, wavelengths: usize, has_checkpoints: bool) -> Result<(), Error> {
        let problem = match (self.aovs().contains(&Aov::Lights), wavelengths, has_checkpoints) {
            (false, ..) | (true, 8, false) => return Ok(()),
            (true, 8, true) => "checkpoints do not tell lights apart; leave out --checkpoint and --resume",
            _ => "lights are told apart with 8 wavelengths only; leave out --wavelengths",
        };
        Err(Error::Usage(format!("--aov lights: {problem}")))
    }

    /// A part holds nothing but sums.
    pub fn check_part(&self) -> Result<(), Error> {
        if self.aovs.is_empty() {
            return Ok(());
        }
        let fix = "give --aov variance,samples to `pellicle merge`, and render the others by themselves, which is cheap: `--max-bounces 0 --spp 64 --aov ... -o layers.exr`";
        Err(Error::Usage(format!("a .part has no room for the layers of --aov: {fix}")))
    }

    /// Merging knows sums, but no scene.
    pub fn check_merge(&self) -> Result<(), Error> {
        match self.aovs().into_iter().find(|aov| aov.needs_survey() || *aov == Aov::Lights) {
            None => Ok(()),
            Some(aov) => Err(Error::Usage(format!(
                "parts know nothing of {}: render it from the scene, which is cheap: `--max-bounces 0 --spp 64 --aov ... -o layers.exr`",
                aov.name()
            ))),
        }
    }
}
