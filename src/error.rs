//! The top error: one variant per room that can fail, and the exit code that each means.

use std::path::PathBuf;

use thiserror::Error;

use crate::collada::SceneError;
use crate::document::PoseError;
use crate::mesh::MeshError;
use crate::output::OutputError;
use crate::render::RenderError;
use crate::scene::BuildError;

#[derive(Debug, Error)]
pub enum Error {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Mesh(#[from] MeshError),
    #[error("{scene}: {source}")]
    Build { scene: String, source: BuildError },
    #[error(transparent)]
    Pose(#[from] PoseError),
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    Output(#[from] OutputError),
    /// What was asked for makes no sense together, or with this scene.
    #[error("{0}")]
    Usage(String),
    /// A limit that the user set is exceeded.
    #[error("{0}")]
    Beyond(String),
    /// Stopped by a signal. Unless `done` is 0, what was rendered has been written.
    #[error("stopped by {name} {}", progress(*done, *wanted))]
    Interrupted { signal: i32, name: &'static str, done: u32, wanted: u32 },
    /// Stopped by a signal, with a checkpoint to go on from; a picture has been written as far as it is.
    #[error("stopped by {name} after {done} of {wanted} samples per pixel; go on with --resume ({})", checkpoint.display())]
    Suspended { name: &'static str, done: u32, wanted: u32, checkpoint: PathBuf },
    /// A batch that was stopped by a signal between two frames.
    #[error("stopped by {name} with {left} frames to go; the same command with --resume goes on")]
    Paused { name: &'static str, left: usize },
    /// A batch that went through, but not with every frame.
    #[error("these frames failed: {frames} (the reasons are in {report})")]
    Frames { frames: String, report: String },
}

fn progress(done: u32, wanted: u32) -> String {
    match done {
        0 => "before every pixel had its samples; no picture was written".to_owned(),
        _ => format!("after {done} of {wanted} samples per pixel; the picture holds what was done"),
    }
}

impl Error {
    /// 1 scene, render or input error, failed frames or beyond a limit, 2 usage, 3 output, 75 (EX_TEMPFAIL) stopped with
    /// something to go on from, 128 + n stopped by signal n.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Scene(_) | Self::Mesh(_) | Self::Build { .. } | Self::Pose(_) | Self::Render(_) => 1,
            Self::Output(OutputError::Damaged { .. }) | Self::Frames { .. } | Self::Beyond(_) => 1,
            Self::Usage(_) => 2,
            Self::Output(_) => 3,
            Self::Suspended { .. } | Self::Paused { .. } => 75,
            Self::Interrupted { signal, .. } => 128u8.saturating_add(*signal as u8),
        }
    }
}
