//! `pellicle check`: what a scene file holds, without rendering it.

use clap::Args;

use super::scene_args::SceneArgs;
use super::{print, say};
use crate::batch::describe;
use crate::error::Error;

/// List what a scene holds, without rendering it
///
/// Meshes, materials with their films and the film model that would be used, lights, cameras, animation; and what in the
/// file is not supported, as warnings.
#[derive(Args)]
#[command(after_help = "Example:
  pellicle check scene.dae")]
pub struct CheckArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Colour error (CIEDE2000) that a cheaper film model may cost [default: the scene's, or 1]
    #[arg(long, value_name = "DE")]
    tolerance: Option<f32>,
}

pub fn run(args: &CheckArgs) -> Result<(), Error> {
    let (document, warnings) = args.scene.load()?;
    let tolerance = args.tolerance.or(document.render.tolerance).unwrap_or(1.0);
    print(&describe::describe(&document, tolerance, args.scene.memory.most())?)?;
    for warning in &warnings {
        say(&format!("warning: {warning}"));
    }
    Ok(())
}
