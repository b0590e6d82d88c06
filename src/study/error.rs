//! What can be wrong with a stack that is asked for.

use std::fmt::Display;

use thiserror::Error;

use crate::color::IndexError;

#[derive(Debug, Error)]
pub enum StudyError {
    #[error("`{0}` is not an index; write 1.33, 1.6+0.3i, a name like Au (see --list), or @FILE.csv")]
    NotAnIndex(String),
    #[error("k = {0} is negative; an absorbing medium is written n+ki, like 1.6+0.3i")]
    NegativeK(f64),
    #[error(transparent)]
    Index(#[from] IndexError),
    /// A table of n and k that cannot be read; `line` counts from 1.
    #[error("{file}, line {line}: {reason}")]
    Row { file: String, line: usize, reason: String },
    #[error("{file}: {reason}")]
    File { file: String, reason: String },
    #[error("no material `{wanted}` in the scene{}; it has {}",
        nearest.as_ref().map(|id| format!(", did you mean `{id}`?")).unwrap_or_default(), known.join(", "))]
    NoMaterial { wanted: String, nearest: Option<String>, known: Vec<String> },
    #[error("material `{0}` only emits: it has no surface that reflects")]
    NoSurface(String),
    #[error("material `{id}`: {source}")]
    Material { id: String, source: IndexError },
    #[error("cannot draw: {0}")]
    Drawing(String),
}

impl StudyError {
    pub(super) fn drawing(error: impl Display) -> Self {
        Self::Drawing(error.to_string())
    }
}
