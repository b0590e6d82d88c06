//! Files that another file refers to: only from its own folder, or from those that the user allows.

use std::path::{Path, PathBuf};

/// Why a reference is refused: a reason, and perhaps the way out.
pub type Refusal = (String, Option<String>);

/// The file that `path` names from `folder` (whose symlinks are resolved); `Ok(None)`: there is none. Symlinks are resolved
/// before the folder is checked.
///
/// # Errors
/// The file lies outside `folder` and all `allowed` folders, or is none.
pub fn find(folder: &Path, allowed: &[PathBuf], path: &Path) -> Result<Option<PathBuf>, Refusal> {
    let Ok(file) = folder.join(path).canonicalize() else { return Ok(None) };
    let inside = file.starts_with(folder)
        || allowed.iter().filter_map(|allowed| allowed.canonicalize().ok()).any(|allowed| file.starts_with(allowed));
    if !inside {
        let hint = "--allow-path with its folder permits it".to_owned();
        return Err(("lies outside the scene's folder".to_owned(), Some(hint)));
    }
    if !file.is_file() {
        return Err(("is not a file".to_owned(), None));
    }
    Ok(Some(file))
}

/// The folder that a file's references start from, symlinks resolved.
///
/// # Errors
/// The folder cannot be read.
pub fn folder_of(path: &Path) -> std::io::Result<PathBuf> {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.canonicalize(),
        _ => Path::new(".").canonicalize(),
    }
}
