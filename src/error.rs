//! The top error: one variant per room that can fail, and the exit code that each means.

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
    /// A limit that the user set is exceeded.
    #[error("{0}")]
    Beyond(String),
    /// Stopped by a signal. Unless `done` is 0, what was rendered has been written.
    #[error("stopped by {name} {}", progress(*done, *wanted))]
    Interrupted { signal: i32, name: &'static str, done: u32, wanted: u32 },
}

fn progress(done: u32, wanted: u32) -> String {
    match done {
        0 => "before every pixel had a sample; no picture was written".to_owned(),
        _ => format!("after {done} of {wanted} samples per pixel; the picture holds what was done"),
    }
}

impl Error {
    /// 1 scene or render error or beyond a limit, 2 usage, 3 output, 128 + n stopped by signal n.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Scene(_) | Self::Build { .. } | Self::Render(_) | Self::Beyond(_) => 1,
            Self::Usage(_) => 2,
            Self::Output(_) => 3,
            Self::Interrupted { signal, .. } => 128u8.saturating_add(*signal as u8),
        }
    }
}
