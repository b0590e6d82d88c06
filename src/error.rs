//! The top error: one variant per room that can fail, and the exit code that each means.

use std::path::PathBuf;

use thiserror::Error;

use crate::collada::SceneError;
use crate::output::OutputError;
use crate::render::RenderError;
use crate::scene::BuildError;

#[derive(Debug, Error)]
pub enum Error {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error("{scene}: {source}")]
    Build { scene: String, source: BuildError },
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    Output(#[from] OutputError),
    /// What was asked for makes no sense together, or with this scene.
    #[error("{0}")]
    Usage(String),
    /// Stopped by a signal. Unless `done` is 0, what was rendered has been written.
    #[error("stopped by {name} {}", progress(*done, *wanted))]
    Interrupted { signal: i32, name: &'static str, done: u32, wanted: u32 },
    /// Stopped by a signal, with a checkpoint to go on from.
    #[error("stopped by {name} after {done} of {wanted} samples per pixel; go on with --resume ({})", checkpoint.display())]
    Suspended { name: &'static str, done: u32, wanted: u32, checkpoint: PathBuf },
}

fn progress(done: u32, wanted: u32) -> String {
    match done {
        0 => "before every pixel had its samples; no picture was written".to_owned(),
        _ => format!("after {done} of {wanted} samples per pixel; the picture holds what was done"),
    }
}

impl Error {
    /// 1 scene, render or input error, 2 usage, 3 output, 75 (EX_TEMPFAIL) stopped with a checkpoint, 128 + n stopped by
    /// signal n.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Scene(_) | Self::Build { .. } | Self::Render(_) => 1,
            Self::Output(OutputError::Damaged { .. }) => 1,
            Self::Usage(_) => 2,
            Self::Output(_) => 3,
            Self::Suspended { .. } => 75,
            Self::Interrupted { signal, .. } => 128u8.saturating_add(*signal as u8),
        }
    }
}
