//! Where the scene and its images come from: a folder, or a `.zae` archive.

use std::cell::RefCell;
use std::fs::File;
use std::io::{BufReader, Read};
use std::os::unix::fs::FileTypeExt;
use std::path::{Component, Path, PathBuf};

use zip::ZipArchive;
use zip::result::ZipError;

use super::{encoding, xml};

/// A scene file with the place that its relative references start from.
pub enum Package {
    /// The `.dae` lies in this folder (symlinks resolved).
    Folder(PathBuf),
    Archive(Archive),
}

/// A `.zae`: a zip file whose `manifest.xml` names the root document.
pub struct Archive {
    zip: RefCell<ZipArchive<BufReader<File>>>,
    /// Folder of the root document inside the archive, `/`-separated, empty at the top.
    folder: String,
    /// Bytes that may still be unpacked.
    budget: RefCell<u64>,
}

/// Opens the file and reads its document. Errors are complete messages.
pub fn open(path: &Path, max_bytes: u64) -> Result<(Package, Vec<u8>), String> {
    let mut file = File::open(path).map_err(|error| format!("cannot be opened: {error}"))?;
    let mut bytes = Vec::new();
    let mut magic = [0; 4];
    let cannot_read = |error| format!("cannot be read: {error}");
    let kind = file.metadata().map_err(cannot_read)?.file_type();
    // Some have no end.
    if kind.is_char_device() || kind.is_block_device() {
        return Err("is a device, not a file".to_owned());
    }
    let read = file.read(&mut magic).map_err(cannot_read)?;
    if magic == *b"PK\x03\x04" {
        let archive =
            ZipArchive::new(BufReader::new(file)).map_err(|error| format!("is not a readable archive: {error}"))?;
        return Archive::open(archive, max_bytes);
    }
    bytes.extend_from_slice(&magic[..read]);
    file.take(max_bytes).read_to_end(&mut bytes).map_err(cannot_read)?;
    if bytes.len() as u64 > max_bytes {
        return Err(format!("is larger than the limit of {max_bytes} bytes"));
    }
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let folder = folder.canonicalize().map_err(cannot_read)?;
    Ok((Package::Folder(folder), bytes))
}

impl Archive {
    fn open(mut zip: ZipArchive<BufReader<File>>, max_bytes: u64) -> Result<(Package, Vec<u8>), String> {
        let has_manifest = zip.by_name("manifest.xml").is_ok();
        let mut documents = zip.file_names().filter(|name| name.to_ascii_lowercase().ends_with(".dae"));
        let only_document = documents.next().map(str::to_owned).filter(|_| documents.next().is_none());
        drop(documents);
        let archive = Self { zip: RefCell::new(zip), folder: String::new(), budget: RefCell::new(max_bytes) };
        let root = if has_manifest {
            let manifest = archive.member("manifest.xml")?.unwrap_or_default();
            dae_root(manifest, max_bytes).ok_or("has a manifest.xml without <dae_root>")?
        } else {
            only_document.ok_or("is an archive without manifest.xml and not exactly one .dae inside")?
        };
        let name =
            inside("", &root).ok_or_else(|| format!("has a <dae_root> `{root}` that leads out of the archive"))?;
        let bytes = archive.member(&name)?.ok_or_else(|| format!("does not contain its <dae_root> `{root}`"))?;
        let folder = name.rsplit_once('/').map_or(String::new(), |(folder, _)| folder.to_owned());
        Ok((Package::Archive(Self { folder, ..archive }), bytes))
    }

    /// The member that a reference relative to the root document names; `Ok(None)` when there is no such member.
    pub fn relative(&self, reference: &str) -> Result<Option<Vec<u8>>, String> {
        match inside(&self.folder, reference) {
            Some(name) => self.member(&name),
            None => Err("leads out of the archive".to_owned()),
        }
    }

    fn member(&self, name: &str) -> Result<Option<Vec<u8>>, String> {
        let mut zip = self.zip.borrow_mut();
        let member = match zip.by_name(name) {
            Ok(member) => member,
            Err(ZipError::FileNotFound) => return Ok(None),
            Err(error) => return Err(format!("holds `{name}`, which cannot be unpacked: {error}")),
        };
        let mut budget = self.budget.borrow_mut();
        // The size in the archive's directory is a claim: what is really unpacked is what counts.
        let mut bytes = Vec::new();
        let unpacked = member.take(budget.saturating_add(1)).read_to_end(&mut bytes);
        unpacked.map_err(|error| format!("holds `{name}`, which cannot be unpacked: {error}"))?;
        match budget.checked_sub(bytes.len() as u64) {
            Some(left) => *budget = left,
            None => return Err("unpacks to more bytes than the limit".to_owned()),
        }
        Ok(Some(bytes))
    }
}

fn dae_root(manifest: Vec<u8>, max_bytes: u64) -> Option<String> {
    let manifest = xml::parse(encoding::decode(manifest).ok()?, max_bytes).ok()?;
    let root = manifest.all().find(|element| element.name() == "dae_root")?.text().into_owned();
    let file = root.split('#').next()?;
    Some(super::images::percent_decode(file))
}

/// Joins and normalises; `None` when the result would lie outside the archive.
fn inside(folder: &str, reference: &str) -> Option<String> {
    let mut steps: Vec<&str> = folder.split('/').filter(|step| !step.is_empty()).collect();
    for component in Path::new(reference).components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir => {
                steps.pop()?;
            }
            Component::Normal(step) => steps.push(step.to_str()?),
            Component::RootDir | Component::Prefix(_) => return None,
        }
    }
    Some(steps.join("/"))
}
