//! Folders that cannot be written to, and disks that fill up in the middle. (Stills, frames, and a folder that is missing or is
//! a file: `cli::faults` and `cli::batches`.)

use super::*;
use crate::cli::faults::SmallDisk;
use crate::cli::{fail, run, succeed};
use pellicle::output::is_complete;

/// A file system that is mounted for reading only, with a whole picture and a part on it.
struct ReadOnly<'a>(&'a Folder);

impl<'a> ReadOnly<'a> {
    fn mount(folder: &'a Folder) -> Option<Self> {
        let disk = SmallDisk::mount(folder)?;
        succeed(&["render", "room.dae", "-o", &folder.file("a.exr"), "--quiet"]);
        let path = folder.file(".");
        let again = Command::new("mount").args(["-o", "remount,ro", &path]).output().unwrap();
        assert!(again.status.success(), "{}", String::from_utf8_lossy(&again.stderr));
        std::mem::forget(disk);
        Some(Self(folder))
    }
}

impl Drop for ReadOnly<'_> {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(self.0.file(".")).output();
    }
}

#[test]
fn a_read_only_disk_is_found_before_rendering() {
    let folder = Folder::new("read-only");
    let elsewhere = Folder::new("writable");
    let Some(_disk) = ReadOnly::mount(&folder) else { return };
    let file = |name: &str| folder.file(name);
    let ours = |name: &str| elsewhere.file(name);
    // Hours of rendering, where the error does not come first.
    let long = ["--quiet", "--size", "2000x2000", "--spp", "60000"];
    let render = ["render", "room.dae", "-o"];
    let before = fs::read(file("a.exr")).unwrap();
    for arguments in [
        [&render[..], &[&file("a.exr")], &long].concat(),
        [&render[..], &[&file("b.png")], &long].concat(),
        [&render[..], &[&ours("a.exr"), "--stats", &file("a.json")], &long].concat(),
        [&render[..], &[&ours("a.exr"), "--preview", &file("p.png")], &long].concat(),
        [&render[..], &[&file("a.exr"), "--checkpoint", "1m"], &long].concat(),
        [&render[..], &[&file("a.part"), "--samples", "0:9"], &long].concat(),
        [&["turntable", "room.dae", "-o", &file("f.####.exr"), "--frames", "9"][..], &long].concat(),
        [&["turntable", "room.dae", "-o", &file("new/f.####.exr"), "--frames", "9"][..], &long].concat(),
        [&["turntable", "room.dae", "-o", &ours("f.####.exr"), "--frames", "9", "--report", &file("r")][..], &long]
            .concat(),
        [&["animate", "moving.dae", "-o", &file("f.####.exr"), "--frames", "1-9"][..], &long].concat(),
        vec!["film", "--base", "Au", "--csv", &file("f.csv")],
        vec!["encode", &file("a.exr"), "-o", &file("v.png")],
    ] {
        let start = Instant::now();
        let stderr = fail(3, &arguments);
        assert!(stderr.contains("Read-only file system"), "{arguments:?}: {stderr}");
        assert!(start.elapsed() < Duration::from_secs(3), "{arguments:?} took {:?}", start.elapsed());
    }
    assert_eq!(fs::read(file("a.exr")).unwrap(), before);
}

#[test]
fn a_disk_that_fills_up_leaves_parts_checkpoints_and_reports_whole() {
    let folder = Folder::new("full-others");
    let Some(_disk) = SmallDisk::mount(&folder) else { return };
    succeed(&["render", "room.dae", "-o", &folder.file("a.exr"), "--quiet"]);
    fs::write(folder.file("ballast"), vec![1; 2_060_000]).unwrap();
    let full = |run: Run| {
        assert_eq!(run.code, Some(3), "{}", run.stderr);
        assert!(run.stderr.contains("No space left on device"), "{}", run.stderr);
        assert_eq!(folder.names(), ["a.exr", "ballast"], "nothing half is left");
    };
    let large = ["--size", "400x300", "--quiet"];
    let render = |name: &str, more: &[&str]| {
        run(&[&["render", "room.dae", "-o", &folder.file(name)], &large[..], more].concat())
    };
    full(render("a.part", &["--spp", "2", "--samples", "0:1"]));
    full(render("a.exr", &["--spp", "2", "--float"]));
    full(render("a.png", &["--spp", "2", "--png-depth", "16"]));
    // The first checkpoint fails, not the render's end: seconds, not hours.
    full(render("b.exr", &["--spp", "1000000", "--checkpoint", "1s"]));
    assert!(is_complete(Path::new(&folder.file("a.exr"))));
}
