//! What can go wrong with a file.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

#[derive(Debug, Error)]
pub enum OutputError {
    /// The system's reason is in `source` ("No space left on device", ...).
    #[error("cannot {task} {}: {source}", path.display())]
    Io { task: &'static str, path: PathBuf, source: io::Error },
    #[error("{}: the folder {} does not exist", path.display(), folder.display())]
    NoFolder { path: PathBuf, folder: PathBuf },
    #[error("{} is a folder, not a file", path.display())]
    IsFolder { path: PathBuf },
    #[error("{}: pictures are written as .exr or .png", path.display())]
    Extension { path: PathBuf },
    #[error("cannot write {}: {reason}", path.display())]
    Picture { path: PathBuf, reason: String },
    #[error(
        "videos are made by ffmpeg, but {program} cannot be run: install it with `apt-get install ffmpeg` (an animated .png needs none)"
    )]
    NoFfmpeg { program: &'static str },
    #[error(
        "no viewer at {address}: {source}; start tev there first (it listens at 127.0.0.1:14158), or leave out --display"
    )]
    Viewer { address: String, source: io::Error },
    #[error("cannot read {}: {reason}", path.display())]
    Damaged { path: PathBuf, reason: String },
}

impl OutputError {
    /// The disk or quota is used up: the next file would fail as well.
    pub fn is_disk_full(&self) -> bool {
        use io::ErrorKind::{QuotaExceeded, StorageFull};
        matches!(self, Self::Io { source, .. } if matches!(source.kind(), StorageFull | QuotaExceeded))
    }

    pub(super) fn io(task: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |source| Self::Io { task, path: path.to_path_buf(), source }
    }

    pub(super) fn picture(path: &Path, reason: impl ToString) -> Self {
        Self::Picture { path: path.to_path_buf(), reason: reason.to_string() }
    }

    pub(super) fn damaged(path: &Path, reason: impl ToString) -> Self {
        Self::Damaged { path: path.to_path_buf(), reason: reason.to_string() }
    }
}
