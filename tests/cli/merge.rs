//! One picture in pieces: sample ranges that are merged, and renders that are stopped and gone on with.

use super::signals::Rendering;
use super::*;

const SPP: u32 = 24;

/// Renders samples into `NAME.part`.
fn part(folder: &Folder, name: &str, samples: &str, options: &[&str]) -> String {
    let file = folder.file(&format!("{name}.part"));
    let spp = SPP.to_string();
    succeed(&[&["render", "room.dae", "-o", &file, "--spp", &spp, "--samples", samples, "--quiet"], options].concat());
    file
}

/// The hash that a run printed.
fn hash(run: &Run) -> String {
    let hash = run.stdout.trim_end().to_owned();
    assert!(hash.len() == 64 && hash.bytes().all(|byte| byte.is_ascii_hexdigit()), "{hash}");
    hash
}

fn whole(folder: &Folder, name: &str, options: &[&str]) -> String {
    let file = folder.file(name);
    let spp = SPP.to_string();
    hash(&succeed(&[&["render", "room.dae", "-o", &file, "--spp", &spp, "--hash"], options].concat()))
}

fn merge(folder: &Folder, name: &str, parts: &[&str], options: &[&str]) -> Run {
    let file = folder.file(name);
    succeed(&[&["merge", "-o", &file, "--hash"], parts, options].concat())
}

#[test]
fn any_split_merged_in_any_order_gives_the_bits_of_the_whole() {
    let folder = Folder::new("split");
    let expected = whole(&folder, "whole.exr", &["--float"]);
    assert_eq!(whole(&folder, "again.png", &["--threads", "1"]), expected, "whatever the format and the threads");
    for cuts in [vec![], vec![7], vec![1, 16], vec![1, 2, 3, 11, 16, 23]] {
        let bounds = [vec![0], cuts, vec![SPP]].concat();
        let mut parts: Vec<String> = Vec::new();
        for range in bounds.windows(2) {
            let samples = format!("{}:{}", range[0], range[1]);
            let threads = (parts.len() % 3 + 1).to_string();
            parts.push(part(&folder, &samples.replace(':', "-"), &samples, &["--threads", &threads]));
        }
        let mut order: Vec<&str> = parts.iter().map(String::as_str).collect();
        assert_eq!(hash(&merge(&folder, "merged.exr", &order, &["--float"])), expected, "{bounds:?}");
        order.reverse();
        let middle = order.len() / 2;
        order.rotate_left(middle);
        assert_eq!(hash(&merge(&folder, "merged.exr", &order, &["--float"])), expected, "{bounds:?} out of order");

        let [mut whole, mut merged] =
            ["whole.exr", "merged.exr"].map(|name| read_exr(Path::new(&folder.file(name))).unwrap());
        for picture in [&mut whole, &mut merged] {
            picture.header.retain(|(name, _)| name != "renderTimeSeconds");
        }
        assert_eq!(merged, whole, "pixels and header");
    }
}

#[test]
fn merged_png_files_look_as_rendered() {
    let folder = Folder::new("merged-png");
    whole(&folder, "whole.png", &["--exposure", "1.5"]);
    let parts = ["0:10", "10:24"].map(|samples| part(&folder, &samples[..1], samples, &["--exposure", "1.5"]));
    merge(&folder, "merged.png", &[&parts[0], &parts[1]], &[]);
    let [whole, merged] = ["whole.png", "merged.png"].map(|name| image::open(folder.file(name)).unwrap().to_rgb8());
    assert_eq!(whole, merged);
}

/// Auto mode finds the same in every part, and spectral parts add up as well.
#[test]
fn spectral_parts_of_a_film_merge() {
    let folder = Folder::new("spectral");
    for mode in ["auto", "spectral"] {
        let options = ["film.dae", "--spp", "6", "--mode", mode, "--size", "16x12"];
        let expected = hash(&succeed(&[&["render", "-o", &folder.file("w.exr"), "--hash"], &options[..]].concat()));
        let files = ["0:1", "1:6"].map(|samples| {
            let file = folder.file(&format!("{}.part", &samples[..1]));
            succeed(&[&["render", "-o", &file, "--samples", samples], &options[..]].concat());
            file
        });
        assert_eq!(hash(&merge(&folder, "m.exr", &[&files[1], &files[0]], &[])), expected, "{mode}");
    }
}

#[test]
fn gaps_are_named_with_what_to_render() {
    let folder = Folder::new("gap");
    let parts = ["2:7", "9:20"].map(|samples| part(&folder, &samples[..1], samples, &[]));
    let output = folder.file("m.exr");
    let stderr = fail(2, &["merge", &parts[1], &parts[0], "-o", &output]);
    for gap in ["--samples 0:2", "--samples 7:9", "--samples 20:24", "--partial"] {
        assert!(stderr.contains(gap), "{stderr}");
    }
    assert!(!Path::new(&output).exists());
    let run = merge(&folder, "m.exr", &[&parts[1], &parts[0]], &["--partial"]);
    assert!(run.stderr.contains("16 of 24 spp"), "{}", run.stderr);
}

#[test]
fn overlaps_are_named_with_both_files() {
    let folder = Folder::new("overlap");
    let parts = ["0:13", "11:24"].map(|samples| part(&folder, &samples[..2].replace(':', ""), samples, &[]));
    for options in [&["-o", &folder.file("m.exr")][..], &["-o", &folder.file("m.exr"), "--partial"]] {
        let stderr = fail(2, &[&["merge", &parts[1], &parts[0]], options].concat());
        assert!(stderr.contains("0.part and") && stderr.contains("11.part both hold the samples 11:13"), "{stderr}");
    }
    let twice = fail(2, &["merge", &parts[0], &parts[0], "-o", &folder.file("m.exr")]);
    assert!(twice.contains("both hold the samples 0:13"), "{twice}");
}

#[test]
fn parts_of_different_pictures_are_refused() {
    let folder = Folder::new("different");
    let first = part(&folder, "first", "0:12", &[]);
    for (option, value, name) in [
        ("--seed", "1", "seed is 0 there, 1 here"),
        ("--size", "30x20", "size is [32,24] there, [30,20] here"),
        ("--filter", "box", "filter is \"BlackmanHarris\" there, \"Box\" here"),
        ("--mode", "spectral", "mode is \"rgb\" there, \"spectral8\" here"),
        ("--max-bounces", "3", "max_bounces is 16 there, 3 here"),
        ("--strategy", "light", "strategy is"),
        ("--tolerance", "2", "tolerance is 1.0 there, 2.0 here"),
        ("--film", "bare", "film is null there"),
        ("--spp", "25", "spp is 24 there, 25 here"),
        ("--camera", "narrow", "camera is"),
        ("--up-axis", "x", "reading is"),
    ] {
        let file = folder.file("second.part");
        let mut arguments = vec!["render", "room.dae", "-o", &file, "--samples", "12:24", option, value];
        if option != "--spp" {
            arguments.extend(["--spp", "24"]);
        }
        succeed(&arguments);
        let stderr = fail(2, &["merge", &first, &file, "-o", &folder.file("m.exr")]);
        assert!(stderr.contains(name), "{option}: {stderr}");
    }
}

#[test]
fn damaged_parts_are_refused() {
    let folder = Folder::new("damaged");
    let parts = ["0:12", "12:24"].map(|samples| part(&folder, &samples[..2].replace(':', ""), samples, &[]));
    let bytes = fs::read(&parts[1]).unwrap();
    let output = folder.file("m.exr");
    let mut flipped = bytes.clone();
    flipped[bytes.len() / 2] ^= 1;
    let longer = [&bytes[..], b"more"].concat();
    for broken in [&bytes[..10], &bytes[..100], &bytes[..bytes.len() / 2], &bytes[..bytes.len() - 1], &flipped, &longer]
    {
        fs::write(&parts[1], broken).unwrap();
        let stderr = fail(1, &["merge", &parts[0], &parts[1], "-o", &output, "--quiet"]);
        assert!(stderr.contains("cannot read") && stderr.contains("12.part"), "{stderr}");
        assert!(!Path::new(&output).exists());
    }
    assert!(fail(1, &["merge", &parts[0], "nowhere.part", "-o", &output]).contains("nowhere.part"));
    let picture = folder.file("p.png");
    succeed(&["render", "room.dae", "-o", &picture, "--spp", "1"]);
    assert!(fail(1, &["merge", &picture, "-o", &output]).contains("is not a part"));
}

#[test]
fn ranges_and_names_that_make_no_sense_are_usage_errors() {
    let folder = Folder::new("ranges");
    let (file, picture) = (folder.file("a.part"), folder.file("a.exr"));
    for range in ["5", "5:5", "6:2", "a:b", "-1:4"] {
        let samples = format!("--samples={range}");
        assert!(fail(2, &["render", "room.dae", "-o", &file, &samples]).contains("FIRST:END"), "{range}");
    }
    let beyond = fail(2, &["render", "room.dae", "-o", &file, "--spp", "8", "--samples", "4:9"]);
    assert!(beyond.contains("beyond the 8 samples per pixel"), "{beyond}");
    let named = fail(2, &["render", "room.dae", "-o", &picture, "--spp", "8", "--samples", "4:8"]);
    assert!(named.contains("a.4-8.part"), "{named}");
    assert!(folder.names().is_empty());
}

/// Stopped by a signal, gone on with, stopped again: the bits of an unbroken render, for pictures and parts.
#[test]
fn interrupted_renders_go_on_to_the_same_bits() {
    let folder = Folder::new("resume");
    let size = ["--size", "160x120", "--spp", "600", "--quiet"];
    let expected = {
        let file = folder.file("whole.exr");
        hash(&succeed(&[&["render", "room.dae", "-o", &file, "--hash"], &size[..]].concat()))
    };
    for (name, signal) in [("a.exr", "TERM"), ("b.part", "INT")] {
        let file = folder.file(name);
        let arguments =
            [&["render", "room.dae", "-o", &file, "--resume", "--checkpoint", "1h", "--hash"], &size[..]].concat();
        let mut stops = 0;
        let last = loop {
            let child = command(&arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
            std::thread::sleep(Duration::from_millis(400));
            let pid = child.id().to_string();
            // Later runs may be too quick to catch.
            let _ = Command::new("kill").args(["-s", signal, &pid]).output();
            let run: Run = child.wait_with_output().unwrap().into();
            if run.code == Some(0) {
                break run;
            }
            assert_eq!(run.code, Some(75), "{}", run.stderr);
            assert!(run.stderr.contains("go on with --resume"), "{}", run.stderr);
            assert!(Path::new(&format!("{file}.checkpoint")).exists());
            // The picture as far as it is; a part is whole or not there.
            assert!(name == "a.exr" || !Path::new(&file).exists());
            stops += 1;
            assert!(stops < 100, "it never ends");
        };
        assert!(stops > 0, "the first run was too quick to be stopped");
        assert_eq!(hash(&last), expected, "{name} after {stops} stops");
        assert!(!Path::new(&format!("{file}.checkpoint")).exists());
    }
    let merged = succeed(&["merge", &folder.file("b.part"), "-o", &folder.file("c.exr"), "--hash"]);
    assert_eq!(hash(&merged), expected);
}

/// Power loss: the last periodic checkpoint is there, and another process goes on from it.
#[test]
fn a_killed_render_goes_on_from_its_last_checkpoint() {
    let folder = Folder::new("killed");
    let size = ["--size", "160x120", "--spp", "900"];
    let file = folder.file("whole.exr");
    let expected = hash(&succeed(&[&["render", "room.dae", "-o", &file, "--hash"], &size[..]].concat()));
    let file = folder.file("a.exr");
    let arguments = [&["render", "room.dae", "-o", &file, "--checkpoint", "0.2s", "--hash"], &size[..]].concat();
    let mut child = command(&arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let checkpoint = PathBuf::from(format!("{file}.checkpoint"));
    let start = Instant::now();
    while !checkpoint.exists() {
        assert!(start.elapsed() < Duration::from_secs(20), "no checkpoint");
        std::thread::sleep(Duration::from_millis(10));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!Path::new(&file).exists());
    let other = fail(2, &[&arguments[..], &["--resume", "--seed", "3"]].concat());
    assert!(other.contains("seed was 0 there and is 3 now"), "{other}");
    let run = succeed(&[&arguments[..], &["--resume"]].concat());
    assert!(run.stderr.contains("going on from"), "{}", run.stderr);
    assert_eq!(hash(&run), expected);
}

#[test]
fn an_interrupted_part_without_checkpoint_leaves_nothing() {
    let folder = Folder::new("no-checkpoint");
    let rendering = Rendering::start(&folder.file("a.part"), "64x48");
    std::thread::sleep(Duration::from_millis(300));
    rendering.send(&["TERM"]);
    let (status, stderr) = rendering.end();
    assert_eq!(status, Some(143), "{stderr}");
    assert!(folder.names().is_empty(), "{:?}", folder.names());
}
