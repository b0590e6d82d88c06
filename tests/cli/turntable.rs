//! Turntables: rings that close, three motions, one load.

use super::*;

/// Small and quick.
const SMALL: [&str; 4] = ["--size", "24x18", "--progress", "none"];

/// What frames.json holds.
pub fn report(folder: &Folder) -> serde_json::Value {
    serde_json::from_str(&fs::read_to_string(folder.file("frames.json")).unwrap()).unwrap()
}

pub fn pixels(folder: &Folder, frame: u32) -> Vec<[f32; 4]> {
    read_exr(Path::new(&folder.file(&format!("f.{frame:04}.exr")))).unwrap().rgba
}

/// Runs a turntable of `scene` into the folder and wants success.
fn turn(folder: &Folder, scene: &str, options: &[&str]) -> Run {
    let output = folder.file("f.####.exr");
    let spp: &[&str] = if options.contains(&"--spp") { &[] } else { &["--spp", "4"] };
    succeed(&[&["turntable", scene, "-o", &output, "--float"], &SMALL[..], spp, options].concat())
}

#[test]
fn a_ring_closes_in_every_mode_and_the_modes_differ() {
    let mut quarters = Vec::new();
    for mode in ["camera", "object", "light"] {
        let folder = Folder::new(&format!("ring-{mode}"));
        turn(&folder, "moving.dae", &["--frames", "0-4/4", "--seed-lock", "--mode", mode]);
        assert_eq!(pixels(&folder, 0), pixels(&folder, 4), "{mode}: frame 4 of 4 is frame 0");
        for frame in 1..4 {
            assert_ne!(pixels(&folder, 0), pixels(&folder, frame), "{mode}: frame {frame}");
        }
        quarters.push(pixels(&folder, 1));
    }
    assert_ne!(quarters[0], quarters[1]);
    assert_ne!(quarters[0], quarters[2]);
    assert_ne!(quarters[1], quarters[2]);
}

/// Turning the camera one way or everything else the other way is the same picture, but for rounding.
#[test]
fn a_camera_that_turns_is_a_world_that_turns_back() {
    let mean = |pixels: &[[f32; 4]]| pixels.iter().map(|p| f64::from(p[0] + p[1] + p[2])).sum::<f64>();
    let camera = Folder::new("orbit");
    turn(&camera, "room.dae", &["--frames", "1/8", "--seed-lock", "--spp", "64"]);
    let world = Folder::new("world");
    let everything = ["--object", "floor-node", "--object", "lamp-node", "--mode", "object"];
    // The pivot is found from the object: say which.
    let back = ["--frames", "7/8", "--seed-lock", "--spp", "64", "--pivot", "floor-node"];
    turn(&world, "room.dae", &[&everything[..], &back].concat());
    let (a, b) = (pixels(&camera, 1), pixels(&world, 7));
    let far = a.iter().zip(&b).filter(|(a, b)| (a[1] - b[1]).abs() > 0.05 * (a[1] + b[1]).max(0.1)).count();
    assert!(far * 20 < a.len(), "{far} of {} pixels differ", a.len());
    assert!((mean(&a) / mean(&b) - 1.0).abs() < 0.02);
}

#[test]
fn the_scene_is_loaded_and_built_once() {
    for (mode, moved) in [("camera", 0), ("object", 3), ("light", 3)] {
        let folder = Folder::new(&format!("once-{mode}"));
        let run = turn(&folder, "moving.dae", &["--frames", "4", "--mode", mode]);
        let report = report(&folder);
        assert_eq!(report["summary"]["done"], 4);
        assert_eq!(report["summary"]["bvh_builds"], 1);
        // One shape turns (a flag; a lamp), in each frame but the first.
        assert_eq!(report["summary"]["instances_moved"], moved, "{mode}: {}", run.stderr);
        let rows = report["frames"].as_array().unwrap();
        assert!(rows[0]["parse_s"].as_f64() > Some(0.0));
        assert!(rows[1..].iter().all(|row| row["parse_s"] == 0.0 && row["textures_s"] == 0.0));
        for row in rows {
            let parts: f64 =
                ["parse_s", "textures_s", "bvh_s", "materials_s", "pilot_s", "render_s", "write_s", "other_s"]
                    .map(|part| row[part].as_f64().unwrap())
                    .iter()
                    .sum();
            assert!((parts - row["total_s"].as_f64().unwrap()).abs() < 1e-4, "{row}");
        }
    }
}

#[test]
fn the_first_line_says_what_turns_and_options_choose() {
    let folder = Folder::new("chosen");
    let first = |run: &Run| run.stderr.lines().next().unwrap().to_owned();
    let line = first(&turn(&folder, "moving.dae", &["--frames", "1", "--mode", "object"]));
    assert!(line.starts_with("turning flag-node about (") && line.contains("; not floor-node ("), "{line}");
    let line = first(&turn(&folder, "moving.dae", &["--frames", "1", "--mode", "object", "--object", "floor-node"]));
    assert!(line.starts_with("turning floor-node about (0.0000, 0.0000, 0.0000) m by 360 degrees"), "{line}");
    let line = first(&turn(&folder, "moving.dae", &["--frames", "1", "--mode", "light", "--pivot", "1,2,-3"]));
    assert!(line.starts_with("turning lamp-node, bulb-node about (1.0000, 2.0000, -3.0000) m"), "{line}");
    let output = folder.file("f.####.exr");
    let stderr = fail(2, &["turntable", "moving.dae", "-o", &output, "--object", "flag"]);
    assert!(stderr.contains("no node `flag`") && stderr.contains("did you mean `flag-node`?"), "{stderr}");
}

#[test]
fn frames_differ_in_their_noise_unless_locked() {
    let folder = Folder::new("seeds");
    turn(&folder, "room.dae", &["--frames", "3", "--seed", "7"]);
    let seeds = |folder: &Folder| -> Vec<u64> {
        report(folder)["frames"].as_array().unwrap().iter().map(|row| row["seed"].as_u64().unwrap()).collect()
    };
    assert_eq!(seeds(&folder), [7, 8, 9]);
    turn(&folder, "room.dae", &["--frames", "3", "--seed", "7", "--seed-lock"]);
    assert_eq!(seeds(&folder), [7, 7, 7]);
}

#[test]
fn a_name_without_a_number_gets_one_and_the_report_is_one_page() {
    let folder = Folder::new("page");
    let output = folder.file("new/turn.png");
    let run = succeed(&[&["turntable", "room.dae", "-o", &output, "--frames", "3", "--spp", "4"], &SMALL[..]].concat());
    assert!(run.stderr.contains("frames go to ") && run.stderr.contains("turn.####.png"), "{}", run.stderr);
    let names =
        ["turn.0000.png", "turn.0001.png", "turn.0002.png", "frames.csv", "frames.json", "frames.svg", "frames.png"];
    for name in names {
        assert!(Path::new(&folder.file(&format!("new/{name}"))).exists(), "{name}");
    }
    let page = fs::read_to_string(folder.file("new/frames.html")).unwrap();
    assert_eq!(page.matches("<img src=\"data:image/jpeg;base64,").count(), 3);
    assert!(!page.replace("http://www.w3.org/2000/svg", "").contains("http"), "the page asks for nothing else");
    assert!(is_complete(Path::new(&folder.file("new/frames.png"))));
    let csv = fs::read_to_string(folder.file("new/frames.csv")).unwrap();
    assert_eq!(csv.lines().count(), 4);
}

#[test]
fn wrong_lists_and_patterns_are_usage() {
    let folder = Folder::new("usage");
    let output = folder.file("f.####.exr");
    for options in [["--frames", "0"], ["--frames", "3-1/4"], ["--pivot", "1,2"], ["--noise", "-1"], ["--fps", "0"]] {
        fail(2, &[&["turntable", "room.dae", "-o", &output], &options[..]].concat());
    }
    fail(2, &["turntable", "room.dae", "-o", &folder.file("#.#.exr")]);
    assert!(fail(2, &["animate", "room.dae", "-o", &output]).contains("no animation"));
    assert_eq!(fail(3, &["turntable", "room.dae", "-o", &folder.file("f.####.jpg")]).lines().count(), 1);
    assert!(folder.names().is_empty());
}

/// What does not move stays sharp to the last bit; what moves becomes the mean of where it was.
#[test]
fn an_open_shutter_blurs_what_moves_and_nothing_else() {
    let sharp = Folder::new("sharp");
    turn(&sharp, "moving.dae", &["--frames", "0/4", "--degrees", "0", "--spp", "8"]);
    let still = Folder::new("still");
    turn(&still, "moving.dae", &["--frames", "0/4", "--degrees", "0", "--spp", "8", "--shutter", "180"]);
    assert_eq!(pixels(&still, 0), pixels(&sharp, 0));

    // Half of a step of 90 degrees, in 64 moments; and the same moments as frames of their own.
    let blurred = Folder::new("blurred");
    let object = ["--mode", "object", "--seed-lock"];
    turn(&blurred, "moving.dae", &[&object[..], &["--frames", "1/4", "--spp", "64", "--shutter", "180"]].concat());
    let moments = Folder::new("moments");
    turn(&moments, "moving.dae", &[&object[..], &["--frames", "48-80/256", "--spp", "32"]].concat());
    let mut mean = vec![0.0; 24 * 18];
    for frame in 48..=80 {
        for (sum, pixel) in mean.iter_mut().zip(pixels(&moments, frame)) {
            *sum += pixel[1] / 33.0;
        }
    }
    let (mut error, mut light) = (0.0, 0.0);
    for (blurred, mean) in pixels(&blurred, 1).iter().zip(&mean) {
        error += (blurred[1] - mean).abs();
        light += mean;
    }
    assert!(error < 0.05 * light, "{error} of {light}");
    assert_ne!(pixels(&blurred, 1), pixels(&moments, 64));
}
