//! Files that cannot be read or written.

use super::*;

/// Takes hours where an error does not come first.
const LONG: [&str; 6] = ["--quiet", "--size", "4000x4000", "--spp", "65536", "--float"];

/// Fails with 3 before anything is rendered.
fn fail_to_write(arguments: &[&str]) -> String {
    let start = Instant::now();
    let stderr = fail(3, &[&["render", "room.dae"], arguments, &LONG].concat());
    assert!(start.elapsed() < Duration::from_secs(2), "found after {:?}", start.elapsed());
    assert!(stderr.starts_with("error: ") && stderr.lines().count() == 1, "{stderr}");
    stderr
}

#[test]
fn a_missing_scene_exits_with_1_and_its_name() {
    let folder = Folder::new("missing-scene");
    let stderr = fail(1, &["render", "no such scene.dae", "-o", &folder.file("a.png")]);
    assert!(stderr.starts_with("error: no such scene.dae: "), "{stderr}");
    assert_eq!(fail(1, &["check", "no such scene.dae"]), stderr);
    assert!(folder.names().is_empty());
}

#[test]
fn a_bad_scene_exits_with_1_and_the_place() {
    let stderr = fail(1, &["check", "bad.dae"]);
    assert!(stderr.starts_with("error: bad.dae:13:72: "), "{stderr}");
    assert!(stderr.contains("did you mean `reflectance`?"), "{stderr}");
    assert!(fail(1, &["check", "bad.txt"]).contains("bad.txt"));
}

#[test]
fn a_missing_output_folder_exits_with_3_before_rendering() {
    let folder = Folder::new("missing-folder");
    let file = folder.file("nowhere/a.exr");
    let stderr = fail_to_write(&["-o", &file]);
    assert!(stderr.contains(&file) && stderr.contains("does not exist"), "{stderr}");
    let stderr = fail_to_write(&["-o", &folder.file("a.exr"), "--stats", &folder.file("nowhere/a.json")]);
    assert!(stderr.contains("nowhere/a.json"), "{stderr}");
    assert!(folder.names().is_empty());
}

#[test]
fn a_file_in_place_of_the_output_folder_exits_with_3_and_stays() {
    let folder = Folder::new("file-as-folder");
    fs::write(folder.file("out"), "old").unwrap();
    let stderr = fail_to_write(&["-o", &folder.file("out/a.exr")]);
    assert!(stderr.contains("out/a.exr"), "{stderr}");
    assert_eq!(fs::read_to_string(folder.file("out")).unwrap(), "old");
    fs::create_dir(folder.file("dir.png")).unwrap();
    assert!(fail_to_write(&["-o", &folder.file("dir.png")]).contains("is a folder"));
}

#[test]
fn an_unknown_extension_exits_with_3_and_lists_the_known() {
    let folder = Folder::new("extension");
    for name in ["a.jpg", "a", "exr", "a.exr.bak"] {
        let stderr = fail_to_write(&["-o", &folder.file(name)]);
        assert!(stderr.contains(".exr") && stderr.contains(".png"), "{stderr}");
    }
    assert!(folder.names().is_empty());
}

#[test]
fn an_old_picture_outlives_a_failed_render() {
    let folder = Folder::new("old-picture");
    fs::write(folder.file("a.exr"), "old").unwrap();
    fail(1, &["render", "bad.dae", "-o", &folder.file("a.exr")]);
    assert_eq!(fs::read_to_string(folder.file("a.exr")).unwrap(), "old");
    assert_eq!(folder.names(), ["a.exr"]);
}

/// A file system of 2 MB, unmounted at the end.
pub struct SmallDisk<'a>(&'a Folder);

impl<'a> SmallDisk<'a> {
    /// `None`, with a printed reason, where this user may not mount.
    pub fn mount(folder: &'a Folder) -> Option<Self> {
        let mount = Command::new("mount").args(["-t", "tmpfs", "-o", "size=2m", "tmpfs"]).arg(&folder.0).output();
        match mount {
            Ok(output) if output.status.success() => Some(Self(folder)),
            Ok(output) => {
                println!("skipped: cannot mount a small disk: {}", String::from_utf8_lossy(&output.stderr).trim());
                None
            }
            Err(error) => {
                println!("skipped: cannot run mount: {error}");
                None
            }
        }
    }
}

impl Drop for SmallDisk<'_> {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.0.0).output();
    }
}

#[test]
fn a_full_disk_exits_with_3_and_leaves_the_old_picture_alone() {
    let folder = Folder::new("full-disk");
    let Some(_disk) = SmallDisk::mount(&folder) else { return };
    let file = folder.file("a.exr");
    fs::write(&file, "old").unwrap();
    // Some 4 MB of noise.
    let stderr =
        fail(3, &["render", "room.dae", "-o", &file, "--quiet", "--float", "--size", "2400x1800", "--spp", "1"]);
    assert!(stderr.contains(&file) && stderr.contains("No space left on device"), "{stderr}");
    assert_eq!(fs::read_to_string(&file).unwrap(), "old");
    assert_eq!(folder.names(), ["a.exr"]);
}
