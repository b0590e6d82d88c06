//! The program as it is run: exit codes, messages, signals, full disks.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use pellicle::output::{is_complete, read_exr};

#[path = "cli/animate.rs"]
mod animate;
#[path = "cli/batches.rs"]
mod batches;
#[path = "cli/crop.rs"]
mod crop;
#[path = "cli/encode.rs"]
mod encode;
#[path = "cli/faults.rs"]
pub mod faults;
#[path = "cli/instances.rs"]
mod instances;
#[path = "cli/live.rs"]
mod live;
#[path = "cli/merge.rs"]
mod merge;
#[path = "cli/models.rs"]
mod models;
#[path = "cli/shell.rs"]
mod shell;
#[path = "cli/signals.rs"]
pub mod signals;
#[path = "cli/slurm.rs"]
mod slurm;
#[path = "cli/stops.rs"]
mod stops;
#[path = "cli/turntable.rs"]
mod turntable;

/// An empty folder with the name of its test, removed at the end.
pub struct Folder(PathBuf);

impl Folder {
    pub fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("pellicle-cli-{}-{name}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn file(&self, name: &str) -> String {
        self.0.join(name).to_str().unwrap().to_owned()
    }

    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).unwrap();
        let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Runs in the folder of the tests' scenes, so that messages hold no path of this machine.
pub fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pellicle"));
    command.args(arguments).current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/cli"));
    command.stdin(Stdio::null());
    command
}

/// What a finished run left behind.
pub struct Run {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Self { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }
}

pub fn run(arguments: &[&str]) -> Run {
    command(arguments).output().unwrap().into()
}

/// Runs and wants success.
pub fn succeed(arguments: &[&str]) -> Run {
    let run = run(arguments);
    assert_eq!(run.code, Some(0), "{arguments:?}: {}", run.stderr);
    run
}

/// Runs and wants this exit code; gives back what it said on stderr.
pub fn fail(code: i32, arguments: &[&str]) -> String {
    let run = run(arguments);
    assert_eq!(run.code, Some(code), "{arguments:?}: {}", run.stderr);
    assert_eq!(run.stdout, "", "{arguments:?}");
    run.stderr
}

/// Renders a scene to EXR with more options; the pixels, and what was said on stderr.
fn render(scene: &str, options: &[&str]) -> (Vec<[f32; 4]>, String) {
    let folder = Folder::new(&format!("{scene}{}", options.concat()));
    let file = folder.file("a.exr");
    let run = succeed(&[&["render", scene, "-o", &file, "--float"], options].concat());
    (read_exr(Path::new(&file)).unwrap().rgba, run.stderr)
}

fn is_black(pixels: &[[f32; 4]]) -> bool {
    pixels.iter().all(|pixel| pixel[..3] == [0.0; 3])
}

#[test]
fn renders_png_and_exr_and_says_nothing_on_stdout() {
    let folder = Folder::new("formats");
    for name in ["a.png", "b.exr", "C.EXR", "name with spaces Ä.png"] {
        let file = folder.file(name);
        assert_eq!(succeed(&["render", "room.dae", "-o", &file]).stdout, "");
        assert!(is_complete(Path::new(&file)), "{name}");
    }
    assert_eq!(folder.names().len(), 4, "nothing else is left: {:?}", folder.names());
}

#[test]
fn quiet_says_nothing_at_all() {
    let folder = Folder::new("quiet");
    let run = succeed(&["render", "dark.dae", "-o", &folder.file("a.png"), "--quiet"]);
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""));
}

#[test]
fn statistics_hold_what_was_measured() {
    let folder = Folder::new("stats");
    let json = folder.file("a.json");
    succeed(&["render", "room.dae", "-o", &folder.file("a.exr"), "--stats", &json, "--spp", "64"]);
    let stats: serde_json::Value = serde_json::from_str(&fs::read_to_string(json).unwrap()).unwrap();
    let number = |name: &str| stats[name].as_f64().unwrap_or_else(|| panic!("{name} is no number: {stats}"));
    for (name, low, high) in [
        ("width", 32.0, 32.0),
        ("height", 24.0, 24.0),
        ("spp", 64.0, 64.0),
        ("non_finite", 0.0, 0.0),
        ("render_s", 1e-6, 60.0),
        // Counted in ticks of 0.01 s.
        ("render_cpu_s", 0.0, 60.0),
        ("bvh_s", 1e-9, 10.0),
        ("load_s", 1e-9, 10.0),
        // A camera ray each, and at most 16 bounces.
        ("rays", 32.0 * 24.0 * 64.0, 17.0 * 32.0 * 24.0 * 64.0),
        ("shadow_rays", 1.0, 17.0 * 32.0 * 24.0 * 64.0),
        ("peak_rss_mb", 1.0, 4000.0),
    ] {
        assert!((low..=high).contains(&number(name)), "{name} = {}", number(name));
    }
    assert!(number("load_s") >= number("bvh_s") + number("parse_s"));
    assert!(number("total_s") >= number("load_s") + number("render_s"));
}

#[test]
fn gives_the_same_bits_on_any_number_of_threads() {
    let one = render("room.dae", &["--threads", "1"]).0;
    for threads in ["2", "3"] {
        assert_eq!(render("room.dae", &["--threads", threads]).0, one, "{threads} threads");
    }
    assert_ne!(render("room.dae", &["--seed", "1"]).0, one, "another seed gives another picture");
}

#[test]
fn no_bounces_show_the_emitters_alone() {
    let lamp = [4.0, 2.0, 1.0, 1.0];
    let (pixels, _) = render("room.dae", &["--max-bounces", "0", "--filter", "box"]);
    assert!(pixels.contains(&lamp));
    // The floor takes the lower rows from edge to edge; the lamp does not reach there.
    assert!(is_black(&pixels[32 * 20..]));
    let (pixels, _) = render("room.dae", &["--max-bounces", "1", "--filter", "box"]);
    assert!(pixels.contains(&lamp));
    assert!(!is_black(&pixels[32 * 20..]));
}

#[test]
fn size_takes_one_side_or_both() {
    let folder = Folder::new("size");
    let file = folder.file("a.exr");
    for (size, expected) in
        [("20x10", (20, 10)), ("20X10", (20, 10)), ("40x", (40, 30)), ("x12", (16, 12)), ("1x1", (1, 1))]
    {
        succeed(&["render", "room.dae", "-o", &file, "--size", size]);
        let picture = read_exr(Path::new(&file)).unwrap();
        assert_eq!((picture.width, picture.height), expected, "--size {size}");
    }
    for size in ["x", "20", "0x10", "-5x10", "20x10x30", "70000x1", "a×b"] {
        assert!(fail(2, &["render", "room.dae", "-o", &file, &format!("--size={size}")]).contains("--size"), "{size}");
    }
}

#[test]
fn pictures_that_do_not_fit_into_memory_are_refused_with_their_bytes() {
    let folder = Folder::new("memory");
    let (file, start) = (folder.file("a.exr"), Instant::now());
    let stderr = fail(1, &["render", "room.dae", "-o", &file, "--size", "65500x65500", "--max-memory", "64G"]);
    assert!(stderr.contains("65500x65500 picture needs 343220000000 bytes"), "{stderr}");
    assert!(stderr.contains("only 64000000000"), "{stderr}");
    let stderr = fail(1, &["render", "room.dae", "-o", &file, "--max-memory", "50k"]);
    assert!(stderr.contains("32x24 picture needs 61440 bytes"), "{stderr}");
    fail(2, &["render", "room.dae", "-o", &file, "--max-memory", "many"]);
    assert!(start.elapsed() < Duration::from_secs(5));
    assert!(folder.names().is_empty());
}

#[test]
fn the_camera_is_chosen_by_its_id_or_its_node() {
    let wide = render("room.dae", &[]).0;
    let narrow = render("room.dae", &["--camera", "narrow"]).0;
    assert_ne!(narrow, wide);
    assert_eq!(render("room.dae", &["--camera", "side"]).0, narrow);
    assert_eq!(render("room.dae", &["--camera", "wide"]).0, wide);
    let folder = Folder::new("camera");
    let stderr = fail(2, &["render", "room.dae", "-o", &folder.file("a.png"), "--camera", "rear"]);
    assert!(stderr.starts_with("error: no camera `rear`"), "{stderr}");
    assert!(stderr.contains("wide") && stderr.contains("narrow"), "{stderr}");
    assert!(folder.names().is_empty());
}

#[test]
fn framing_is_as_written_unless_asked_for() {
    let (written, _) = render("room.dae", &["--framing", "scene"]);
    assert_eq!(render("room.dae", &[]).0, written);
    let (course, stderr) = render("room.dae", &["--framing", "cs184"]);
    assert_ne!(course, written);
    assert!(stderr.contains("framing: CS184"), "{stderr}");
}

#[test]
fn a_scene_without_light_is_black_with_a_warning() {
    let (pixels, stderr) = render("dark.dae", &[]);
    assert!(is_black(&pixels));
    assert!(stderr.contains("warning: the scene has no light"), "{stderr}");
}

#[test]
fn a_scene_without_camera_is_framed_with_a_warning() {
    let (pixels, stderr) = render("no_camera.dae", &[]);
    assert!(!is_black(&pixels));
    assert!(stderr.contains("warning: the scene has no camera"), "{stderr}");
}

#[test]
fn an_empty_scene_is_a_picture_too() {
    let (pixels, stderr) = render("empty.dae", &[]);
    assert_eq!(pixels.len(), 32 * 24);
    assert!(is_black(&pixels));
    assert!(stderr.contains("no light") && stderr.contains("no camera"), "{stderr}");
}

#[test]
fn progress_as_json_is_one_object_a_line() {
    let folder = Folder::new("progress");
    let stderr = succeed(&["render", "room.dae", "-o", &folder.file("a.png"), "--progress", "json"]).stderr;
    let objects: Vec<&str> = stderr.lines().filter(|line| line.starts_with('{')).collect();
    let last: serde_json::Value = serde_json::from_str(objects.last().unwrap()).unwrap();
    assert_eq!(last["done"].as_f64(), Some(1.0));
}

#[test]
fn check_lists_what_a_scene_holds() {
    let run = succeed(&["check", "room.dae"]);
    assert_eq!(
        run.stdout,
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/cli/room.txt")).unwrap()
    );
    assert_eq!(run.stderr, "");
    let run = succeed(&["check", "film.dae"]);
    assert!(run.stdout.contains("conductor Au, roughness 0.1\n    film 550 nm, n = 1.33\n"), "{}", run.stdout);
}

#[test]
fn check_survives_a_reader_that_goes_away() {
    let mut child = command(&["check", "room.dae"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let run: Run = child.wait_with_output().unwrap().into();
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
}

#[test]
fn help_shows_an_example_of_every_subcommand() {
    let overview = succeed(&["--help"]).stdout;
    assert!(overview.contains("\n  pellicle render "), "{overview}");
    let shown = overview.lines().filter_map(|line| line.strip_prefix("  ")?.split_once("  "));
    let commands: Vec<&str> = shown.map(|(name, _)| name).filter(|name| !name.starts_with(['-', ' ', 'p'])).collect();
    assert!(commands.len() >= 12, "{commands:?}");
    for subcommand in commands.into_iter().filter(|name| !name.is_empty() && *name != "help") {
        assert!(overview.contains(&format!("  {subcommand}")), "{overview}");
        let help = succeed(&[subcommand, "--help"]).stdout;
        assert!(help.contains(&format!("  pellicle {subcommand} ")), "{help}");
        assert!(help.contains("Example"), "{help}");
    }
}

#[test]
fn wrong_usage_exits_with_2_and_points_to_help() {
    let nothing = fail(2, &[]);
    assert!(nothing.contains("Usage: pellicle <COMMAND>"), "{nothing}");
    let flag = fail(2, &["render", "room.dae", "-o", "a.png", "--sample", "4"]);
    assert!(flag.contains("--sample") && flag.contains("--help"), "{flag}");
    assert!(fail(2, &["paint"]).contains("paint"));
    assert!(fail(2, &["render", "room.dae"]).contains("--output"));
    assert!(fail(2, &["render", "-o", "a.png"]).contains("SCENE"));
    assert!(fail(2, &["render", "room.dae", "-o", "a.png", "--spp", "0"]).contains("--spp"));
    assert!(fail(2, &["render", "room.dae", "-o", "a.png", "--mode", "cmyk"]).contains("rgb"));
}
