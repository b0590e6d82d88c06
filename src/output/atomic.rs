//! The one way in which files are written: to `.NAME.tmp.PID` beside the target, flushed to the disk, renamed.
//!
//! So the name holds the old content, the new content or nothing, whenever the process or the machine stops. Two processes
//! that write the same name do not disturb each other; the last rename wins.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use super::error::OutputError;

/// Writes UTF-8 text.
///
/// # Errors
/// What the system says, with the path. The old file is untouched then.
pub fn write_text(path: &Path, text: &str) -> Result<(), OutputError> {
    save(path, text.as_bytes())
}

/// Writes bytes as they are.
///
/// # Errors
/// As [`write_text`].
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    save(path, bytes)
}

/// Proves that `path` can be written, by creating and removing the temporary file.
///
/// # Errors
/// A missing folder, a folder where the file should be, or what the system says.
pub fn check_writable(path: &Path) -> Result<(), OutputError> {
    Temporary::create(path).map(drop)
}

/// Puts `bytes` under the name `path`, all or nothing.
pub(super) fn save(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let mut temporary = Temporary::create(path)?;
    temporary.file.write_all(bytes).map_err(OutputError::io("write", path))?;
    temporary.commit()
}

/// A file under its temporary name; removed when dropped without [`commit`](Self::commit).
pub(super) struct Temporary<'a> {
    target: &'a Path,
    folder: &'a Path,
    name: PathBuf,
    file: File,
    committed: bool,
}

impl<'a> Temporary<'a> {
    pub fn create(target: &'a Path) -> Result<Self, OutputError> {
        let folder = match target.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        };
        let (Some(file_name), false) = (target.file_name(), target.is_dir()) else {
            return Err(OutputError::IsFolder { path: target.to_path_buf() });
        };
        if !folder.exists() {
            return Err(OutputError::NoFolder { path: target.to_path_buf(), folder: folder.to_path_buf() });
        }
        let mut prefix = OsString::from(".");
        prefix.push(file_name);
        prefix.push(".tmp.");
        remove_stale(folder, &prefix);

        let mut name = prefix;
        name.push(std::process::id().to_string());
        let name = folder.join(name);
        let file = File::create_new(&name).map_err(OutputError::io("create a file for", target))?;
        Ok(Self { target, folder, name, file, committed: false })
    }

    /// For programs that open files themselves.
    pub fn path(&self) -> &Path {
        &self.name
    }

    pub fn file(&self) -> &File {
        &self.file
    }

    pub fn commit(mut self) -> Result<(), OutputError> {
        self.file.sync_all().map_err(OutputError::io("flush to disk", self.target))?;
        fs::rename(&self.name, self.target).map_err(OutputError::io("rename to", self.target))?;
        self.committed = true;
        // The rename itself is safe only once the folder has reached the disk.
        let folder = File::open(self.folder).and_then(|folder| folder.sync_all());
        folder.map_err(OutputError::io("flush to disk the folder of", self.target))
    }
}

impl Drop for Temporary<'_> {
    fn drop(&mut self) {
        if !self.committed {
            // Nothing more can be done if this fails; the next run removes it.
            let _ = fs::remove_file(&self.name);
        }
    }
}

/// Removes what dead processes left of the same target. One with our own number is from before as well: in a container
/// every run may have the same. What cannot be removed or listed does no harm.
fn remove_stale(folder: &Path, prefix: &OsString) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let Some(pid) = name.as_encoded_bytes().strip_prefix(prefix.as_encoded_bytes()) else { continue };
        let Some(pid) = std::str::from_utf8(pid).ok().and_then(|digits| digits.parse::<u32>().ok()) else { continue };
        if pid == std::process::id() || !is_alive(pid) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Where there is no /proc, everyone counts as alive.
fn is_alive(pid: u32) -> bool {
    !Path::new("/proc/self").exists() || Path::new("/proc").join(pid.to_string()).exists()
}
