//! Options about the scene file, shared by every subcommand that reads one.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::memory_args::MemoryArgs;
use crate::collada::{self, FalloffRule, LoadOptions, MissingTexture, UpAxis, Warning};
use crate::document::Document;
use crate::error::Error;
use crate::mesh::Kind;
use crate::scene::Framing;
use crate::studio::{self, Environment};

#[derive(Args, PartialEq)]
pub struct SceneArgs {
    /// The scene: COLLADA .dae or .zae; or a bare model, OBJ or PLY, which gets a floor, a camera and light
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,
    /// Another surface for everything that does not shine, like "conductor Au; film 550nm n=1.33"; NAME=... for the material
    /// NAME alone (repeatable)
    #[arg(long, value_name = "[NAME=]SURFACE", help_heading = "Scene")]
    pub material: Vec<String>,
    /// Light: studio, tent, sky, or a lat-long image, instead of the scene's own environment; bare models have the studio
    #[arg(long, value_name = "NAME|FILE", value_parser = Environment::parse, help_heading = "Scene")]
    pub environment: Option<Environment>,
    /// Also read images from this folder (repeatable); by default only from the scene's own
    #[arg(long, value_name = "DIR", help_heading = "Scene")]
    pub allow_path: Vec<PathBuf>,
    /// Go on where a broken mesh or camera can be left out, with a warning
    #[arg(long, help_heading = "Scene")]
    pub lenient: bool,
    /// What to do about missing images
    #[arg(long, value_name = "WHAT", value_enum, default_value = "error", help_heading = "Scene")]
    pub missing_texture: MissingTextureArg,
    /// Recompute smooth normals instead of using the file's
    #[arg(long, help_heading = "Scene")]
    pub smooth_normals: bool,
    /// Override the file's up axis
    #[arg(long, value_name = "AXIS", value_enum, help_heading = "Scene")]
    pub up_axis: Option<UpAxisArg>,
    /// Read the file's opacity the other way round, for exporters that invert it
    #[arg(long, help_heading = "Scene")]
    pub invert_opacity: bool,
    /// How point and spot lights fall off with distance
    #[arg(long, value_name = "RULE", value_enum, default_value = "auto", help_heading = "Scene")]
    pub light_falloff: FalloffArg,
    #[command(flatten)]
    pub memory: MemoryArgs,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
pub enum MissingTextureArg {
    Error,
    Magenta,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
pub enum UpAxisArg {
    X,
    Y,
    Z,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
pub enum FalloffArg {
    /// Physical, unless the file gives its own attenuation
    Auto,
    /// Always 1/d^2
    Physical,
    /// Always the file's attenuation
    Collada,
}

/// How the camera is placed.
#[derive(Clone, Copy, PartialEq, ValueEnum)]
pub enum FramingArg {
    /// CS184's rule where a CS184 file needs it, else as written
    Auto,
    /// As written
    Scene,
    /// CS184's: keep the direction, move the eye until everything is in view
    Cs184,
}

impl From<FramingArg> for Framing {
    fn from(arg: FramingArg) -> Self {
        match arg {
            FramingArg::Auto => Self::Auto,
            FramingArg::Scene => Self::Scene,
            FramingArg::Cs184 => Self::Cs184,
        }
    }
}

impl SceneArgs {
    pub fn load(&self) -> Result<(Document, Vec<Warning>), Error> {
        let options = self.options();
        let model = Kind::of(&self.scene);
        let (mut document, warnings) = match model {
            Some(kind) => studio::load(&self.scene, kind, &options, !self.material.is_empty())?,
            None => collada::load(&self.scene, &options)?,
        };
        for surface in &self.material {
            collada::dress(&mut document, surface, &options)?;
        }
        match (model, &self.environment) {
            (Some(_), environment) => {
                studio::set_up(&mut document, environment.as_ref().unwrap_or(&Environment::Studio));
            }
            (None, Some(environment)) => studio::light(&mut document, environment),
            (None, None) => {}
        }
        Ok((document, warnings))
    }

    /// How the file is read, as far as the pictures depend on it: not where images may lie, nor how much fits.
    pub fn reading(&self) -> String {
        let max_bytes = LoadOptions::default().max_bytes;
        let options = LoadOptions { allow_path: Vec::new(), max_bytes, ..self.options() };
        match (self.material.as_slice(), &self.environment) {
            ([], None) => format!("{options:?}"),
            (material, environment) => format!("{options:?} {material:?} {environment:?}"),
        }
    }

    fn options(&self) -> LoadOptions {
        LoadOptions {
            allow_path: self.allow_path.clone(),
            lenient: self.lenient,
            smooth_normals: self.smooth_normals,
            up_axis: self.up_axis.map(|axis| match axis {
                UpAxisArg::X => UpAxis::X,
                UpAxisArg::Y => UpAxis::Y,
                UpAxisArg::Z => UpAxis::Z,
            }),
            invert_opacity: self.invert_opacity,
            falloff: match self.light_falloff {
                FalloffArg::Auto => FalloffRule::Auto,
                FalloffArg::Physical => FalloffRule::Physical,
                FalloffArg::Collada => FalloffRule::Collada,
            },
            missing_texture: match self.missing_texture {
                MissingTextureArg::Error => MissingTexture::Error,
                MissingTextureArg::Magenta => MissingTexture::Magenta,
            },
            max_bytes: self.memory.most(),
        }
    }
}
