//! Pictures that would not fit: refused before anything is rendered, with the bytes in the message. (Stills:
//! `cli::pictures_that_do_not_fit_into_memory_are_refused_with_their_bytes`.)

use super::*;
use crate::cli::{fail, succeed};

#[test]
fn every_command_that_makes_pictures_knows_its_limit() {
    let folder = Folder::new("limits");
    let bytes = |stderr: String| assert!(stderr.contains("4000x3000 picture needs 960000000 bytes"), "{stderr}");
    let large = ["--size", "4000x3000", "--max-memory", "500M", "--quiet"];
    let frames = folder.file("f.####.png");
    bytes(fail(1, &[&["render", "room.dae", "-o", &folder.file("a.part"), "--samples", "0:1"], &large[..]].concat()));
    bytes(fail(1, &[&["turntable", "room.dae", "-o", &frames, "--frames", "3"], &large[..]].concat()));
    bytes(fail(1, &[&["animate", "moving.dae", "-o", &frames], &large[..]].concat()));
    let part = folder.file("a.part");
    succeed(&["render", "room.dae", "-o", &part, "--samples", "0:4", "--quiet"]);
    let stderr = fail(1, &["merge", &part, "-o", &folder.file("m.exr"), "--max-memory", "50k"]);
    assert!(stderr.contains("32x24 picture needs 61440 bytes"), "{stderr}");
    succeed(&["merge", &part, "-o", &folder.file("m.exr"), "--max-memory", "100k"]);
}

/// Each of them takes memory, and a hundred thousand a whole machine.
#[test]
fn threads_have_a_limit() {
    for threads in ["1025", "100000", "99999999999999999999", "-1", "many"] {
        let stderr = fail(2, &["render", "room.dae", "-o", "a.png", &format!("--threads={threads}")]);
        assert!(stderr.contains("give a number up to 1024"), "{stderr}");
    }
}

/// The limit is no part of the settings: who has more memory can go on.
#[test]
fn a_checkpoint_goes_on_under_another_limit() {
    let folder = Folder::new("other-limit");
    let render = |more: &[&str]| {
        let file = folder.file("a.part");
        succeed(&[&["render", "room.dae", "-o", &file, "--samples", "0:4", "--resume"], more].concat()).stderr
    };
    render(&["--max-memory", "100M"]);
    assert!(render(&["--max-memory", "200M"]).contains("going on from"));
}
