//! Batches that are broken off, go on, run out of disk or of time.

use super::faults::SmallDisk;
use super::turntable::{pixels, report};
use super::*;

/// Five frames of 64x48, or what `more` says instead.
fn arguments<'a>(output: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let mut all = [&["turntable", "room.dae", "-o", output, "--float", "--progress", "none"], more].concat();
    for (option, value) in [("--frames", "5"), ("--size", "64x48"), ("--spp", "96")] {
        if !all.contains(&option) {
            all.extend([option, value]);
        }
    }
    all
}

fn wait_for(path: &str) {
    let start = Instant::now();
    while !Path::new(path).exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "{path} does not come");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn what_kill_9_leaves_goes_on_to_the_same_bits() {
    let (whole, broken) = (Folder::new("unbroken"), Folder::new("killed"));
    succeed(&arguments(&whole.file("f.####.exr"), &[]));
    let output = broken.file("f.####.exr");
    let mut child = command(&arguments(&output, &[])).stderr(Stdio::null()).spawn().unwrap();
    wait_for(&broken.file("f.0001.exr"));
    child.kill().unwrap();
    child.wait().unwrap();
    let missing = succeed(&arguments(&output, &["--missing"])).stdout;
    assert!(missing.ends_with("-4/5\n") || missing == "4/5\n", "{missing}");

    let run = succeed(&arguments(&output, &["--resume"]));
    assert!(run.stderr.contains(" of 5 frames are there"), "{}", run.stderr);
    for frame in 0..5 {
        assert_eq!(pixels(&broken, frame), pixels(&whole, frame), "frame {frame}");
    }
    assert_eq!(report(&broken)["summary"]["done"], 5);
    assert_eq!(broken.names(), whole.names(), "nothing else is left");
    assert_eq!(succeed(&arguments(&output, &["--missing"])).stdout, "");
    let again = succeed(&arguments(&output, &["--resume"])).stderr;
    assert!(again.contains("5 of 5 frames are there") && !again.contains("triangles"), "nothing is built: {again}");
}

#[test]
fn only_whole_frames_of_the_same_settings_count() {
    let folder = Folder::new("repair");
    let output = folder.file("f.####.exr");
    succeed(&arguments(&output, &["--spp", "4"]));
    let before: Vec<_> = (0..5).map(|frame| pixels(&folder, frame)).collect();
    let missing = |more: &[&str]| succeed(&arguments(&output, &[&["--missing"], more].concat())).stdout;
    assert_eq!(missing(&["--spp", "4"]), "");
    // Other settings, other frames; threads and reports are none.
    assert_eq!(missing(&["--spp", "5"]), "0-4/5\n");
    assert_eq!(missing(&["--spp", "4", "--max-bounces", "3"]), "0-4/5\n");
    assert_eq!(missing(&["--spp", "4", "--degrees", "90"]), "0-4/5\n");
    assert_eq!(missing(&["--spp", "4", "--threads", "1", "--report", "elsewhere"]), "");

    // A file cut short still has its header; one is gone.
    let cut = folder.file("f.0001.exr");
    let bytes = fs::read(&cut).unwrap();
    fs::write(&cut, &bytes[..bytes.len() * 3 / 4]).unwrap();
    fs::remove_file(folder.file("f.0003.exr")).unwrap();
    assert_eq!(missing(&["--spp", "4"]), "1,3/5\n");
    let untouched = fs::metadata(folder.file("f.0000.exr")).unwrap().modified().unwrap();
    let run = succeed(&arguments(&output, &["--spp", "4", "--resume"]));
    assert!(run.stderr.contains("3 of 5 frames are there"), "{}", run.stderr);
    assert_eq!((0..5).map(|frame| pixels(&folder, frame)).collect::<Vec<_>>(), before);
    assert_eq!(fs::metadata(folder.file("f.0000.exr")).unwrap().modified().unwrap(), untouched);
    assert_eq!(report(&folder)["summary"]["missing"], "");
}

#[test]
fn pngs_are_known_again_as_well() {
    let folder = Folder::new("png");
    let output = folder.file("f.####.png");
    succeed(&arguments(&output, &["--spp", "4"]));
    assert_eq!(succeed(&arguments(&output, &["--spp", "4", "--missing"])).stdout, "");
    assert_eq!(succeed(&arguments(&output, &["--spp", "4", "--missing", "--exposure", "1"])).stdout, "0-4/5\n");
}

#[test]
fn a_signal_leaves_whole_frames_and_a_report_to_go_on_from() {
    for (signal, name) in [("INT", "SIGINT"), ("TERM", "SIGTERM")] {
        let folder = Folder::new(&format!("paused-{signal}"));
        let output = folder.file("f.####.exr");
        let child = command(&arguments(&output, &["--spp", "400"])).stderr(Stdio::piped()).spawn().unwrap();
        wait_for(&folder.file("f.0000.exr"));
        let pid = child.id().to_string();
        assert!(Command::new("kill").args(["-s", signal, &pid]).status().unwrap().success());
        let run: Run = child.wait_with_output().unwrap().into();
        assert_eq!(run.code, Some(75), "{}", run.stderr);
        assert!(run.stderr.contains(&format!("stopped by {name} with ")), "{}", run.stderr);
        assert!(run.stderr.contains("--resume goes on"), "{}", run.stderr);
        let report = report(&folder);
        let done = report["summary"]["done"].as_u64().unwrap();
        assert!((1..5).contains(&done), "{done}");
        let frames = folder.names().into_iter().filter(|name| name.ends_with(".exr")).count();
        assert_eq!(frames as u64, done, "{:?}", folder.names());
        assert!(folder.names().iter().all(|name| !name.starts_with('.')));
    }
}

#[test]
fn a_full_disk_stops_the_batch() {
    let folder = Folder::new("full-batch");
    let Some(_disk) = SmallDisk::mount(&folder) else { return };
    // Some 0.7 MB a frame.
    let output = folder.file("f.####.exr");
    let stderr = fail(3, &arguments(&output, &["--size", "1000x750", "--spp", "1", "--quiet"]));
    assert!(stderr.contains("No space left on device"), "{stderr}");
    let frames: Vec<String> = folder.names().into_iter().filter(|name| name.ends_with(".exr")).collect();
    assert!((1..5).contains(&frames.len()), "{frames:?}");
    assert!(frames.iter().all(|name| is_complete(Path::new(&folder.file(name)))), "{frames:?}");
    assert!(folder.names().iter().all(|name| !name.starts_with('.')), "{:?}", folder.names());
}

#[test]
fn a_frame_that_cannot_be_written_is_a_row() {
    let folder = Folder::new("in-the-way");
    fs::create_dir(folder.file("f.0001.exr")).unwrap();
    let output = folder.file("f.####.exr");
    let stderr = fail(1, &arguments(&output, &["--spp", "1"]));
    assert!(stderr.contains("these frames failed: 1/5"), "{stderr}");
    let report = report(&folder);
    assert_eq!(report["summary"]["done"], 4);
    assert!(report["frames"][1]["reason"].as_str().unwrap().contains("is a folder"));
}

/// Rows of the report, as numbers.
fn numbers(folder: &Folder, name: &str) -> Vec<f64> {
    report(folder)["frames"].as_array().unwrap().iter().map(|row| row[name].as_f64().unwrap()).collect()
}

#[test]
fn frames_stop_at_their_time() {
    let folder = Folder::new("time");
    let output = folder.file("f.####.exr");
    succeed(&arguments(&output, &["--frames", "3", "--spp", "60000", "--time-per-frame", "0.4s"]));
    for (render_s, spp) in numbers(&folder, "render_s").into_iter().zip(numbers(&folder, "spp")) {
        // A pass may take a little longer than those before it; the machine may be busy.
        assert!((0.1..3.0).contains(&render_s) && (2.0..60_000.0).contains(&spp), "{render_s} s, {spp} spp");
    }
    // What stopped can be made again from its samples alone.
    let stopped = pixels(&folder, 1);
    let spp = numbers(&folder, "spp")[1].to_string();
    succeed(&arguments(&output, &["--frames", "1/3", "--spp", &spp]));
    assert_eq!(pixels(&folder, 1), stopped);
}

#[test]
fn frames_stop_at_their_noise() {
    let folder = Folder::new("noise");
    let output = folder.file("f.####.exr");
    succeed(&arguments(&output, &["--frames", "0/2", "--spp", "16"]));
    let target = numbers(&folder, "noise")[0] / 3.0;
    let noise = format!("{target:.6}");
    succeed(&arguments(&output, &["--frames", "0/2", "--spp", "60000", "--noise", &noise]));
    for (noise, spp) in numbers(&folder, "noise").into_iter().zip(numbers(&folder, "spp")) {
        // A third of the noise takes about nine times the samples.
        assert!(
            (0.5 * target..=1.0001 * target).contains(&noise) && spp > 48.0 && spp < 1600.0,
            "{noise} at {spp} spp"
        );
    }
}

#[test]
fn a_total_is_shared_evenly() {
    let folder = Folder::new("total");
    let output = folder.file("f.####.exr");
    let start = Instant::now();
    succeed(&arguments(&output, &["--frames", "6", "--spp", "60000", "--total-time", "3s"]));
    assert!(start.elapsed() < Duration::from_secs(8), "{:?}", start.elapsed());
    // A busy machine may cut any frame short, but none takes many more samples than the one before.
    let spp = numbers(&folder, "spp");
    assert!(spp[0] < 60_000.0 && spp.windows(2).all(|pair| pair[1] <= 1.25 * pair[0]), "{spp:?}");
    let budget_s = numbers(&folder, "budget_s");
    assert!(budget_s[0] <= 0.5, "a sixth of the time: {budget_s:?}");
    assert!(budget_s.iter().all(|seconds| *seconds < 3.0), "{budget_s:?}");
}
