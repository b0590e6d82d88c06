//! The file's own animation, through the program.

use super::turntable::{pixels, report};
use super::*;

fn animate(folder: &Folder, code: i32, options: &[&str]) -> Run {
    let output = folder.file("f.####.exr");
    let common = ["animate", "moving.dae", "-o", &output, "--fps", "1", "--size", "24x18", "--spp", "4", "--float"];
    let run = run(&[&common[..], &["--progress", "none"], options].concat());
    assert_eq!(run.code, Some(code), "{}", run.stderr);
    run
}

/// From second to second of the scene something else changes: camera, node, film, light, node, lamp.
#[test]
fn no_more_is_built_than_has_changed() {
    let folder = Folder::new("changes");
    let run = animate(&folder, 0, &["--frames", "0-6", "--seed-lock"]);
    assert!(run.stderr.contains("8 channels move the scene from frame 0 to 8"), "{}", run.stderr);
    let report = report(&folder);
    let rows = report["frames"].as_array().unwrap();
    let column = |name: &str| -> Vec<u64> { rows[1..].iter().map(|row| row[name].as_u64().unwrap()).collect() };
    assert_eq!(column("bvh_builds"), [0; 6]);
    assert_eq!(column("instances_moved"), [0, 1, 0, 0, 1, 0]);
    assert_eq!(column("materials_compiled"), [0, 0, 1, 0, 0, 0]);
    for frame in 0..6 {
        assert_ne!(pixels(&folder, frame), pixels(&folder, frame + 1), "frame {frame}");
    }
}

/// A farm renders frames one by one and in any order.
#[test]
fn a_frame_does_not_depend_on_its_batch() {
    let (whole, single) = (Folder::new("whole"), Folder::new("single"));
    animate(&whole, 0, &["--frames", "0-6"]);
    for frame in [5, 2, 4] {
        animate(&single, 0, &["--frames", &frame.to_string()]);
        assert_eq!(pixels(&single, frame), pixels(&whole, frame), "frame {frame}");
    }
    // The report holds what all three have rendered.
    assert_eq!(report(&single)["frames"].as_array().unwrap().len(), 3);
}

#[test]
fn a_frame_that_fails_is_a_row_and_the_batch_goes_on() {
    let folder = Folder::new("failed");
    let run = animate(&folder, 1, &["--frames", "6-8"]);
    assert!(run.stderr.contains("frame 7 failed: animation of `grey-fx/reflectance`"), "{}", run.stderr);
    assert!(run.stderr.contains("error: these frames failed: 7"), "{}", run.stderr);
    let report = report(&folder);
    assert_eq!((&report["summary"]["done"], &report["summary"]["failed"]), (&2.into(), &"7".into()));
    let row = &report["frames"][1];
    assert_eq!(row["status"], "failed");
    assert!(row["reason"].as_str().unwrap().contains("must lie in 0..1"), "{row}");
    assert!(!Path::new(&folder.file("f.0007.exr")).exists());
    assert!(is_complete(Path::new(&folder.file("f.0008.exr"))));
}
