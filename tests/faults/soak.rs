//! Many frames in one process: memory, file handles and the time of a frame stay what they were.

use super::*;

/// What /proc told at one moment: frames that were done, resident memory in bytes, open files.
struct Look {
    frames: f64,
    memory: f64,
    files: usize,
}

fn look(pid: u32, folder: &str) -> Option<Look> {
    let status = fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
    let kib: f64 =
        status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?.trim().split(' ').next()?.parse().ok()?;
    let files = fs::read_dir(format!("/proc/{pid}/fd")).ok()?.count();
    let names = fs::read_dir(folder).ok()?.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let frames = names.filter(|name| name.starts_with("f.")).count() as f64;
    Some(Look { frames, memory: kib * 1024.0, files })
}

/// Least squares, bytes per frame.
fn slope(looks: &[Look]) -> f64 {
    let count = looks.len() as f64;
    let mean = |of: fn(&Look) -> f64| looks.iter().map(of).sum::<f64>() / count;
    let (frames, memory) = (mean(|look| look.frames), mean(|look| look.memory));
    let along = |look: &Look| (look.frames - frames) * (look.memory - memory);
    looks.iter().map(along).sum::<f64>() / looks.iter().map(|look| (look.frames - frames).powi(2)).sum::<f64>()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Turns the scene of the command line's tests; films, BVH and lights are posed anew for each frame.
fn soak(frames: usize, most_bytes_per_frame: f64, most_drift: f64) {
    let folder = Folder::new(&format!("soak-{frames}"));
    let (output, count) = (folder.file("f.####.png"), frames.to_string());
    let options = ["--mode", "object", "--frames", &count, "--spp", "1", "--threads", "1", "--quiet"];
    let mut child = command(&[&["turntable", "film.dae", "-o", &output], &options[..]].concat()).spawn().unwrap();
    let mut looks: Vec<Look> = Vec::new();
    while child.try_wait().unwrap().is_none() {
        looks.extend(look(child.id(), &folder.file(".")));
        std::thread::sleep(Duration::from_millis(20));
    }
    assert!(child.wait().unwrap().success());

    // The first quarter fills caches and the allocator's pools.
    looks.retain(|look| look.frames > frames as f64 / 4.0 && look.frames < frames as f64 - 1.0);
    let files = looks.iter().map(|look| look.files);
    let (least, most) = (files.clone().min().unwrap(), files.max().unwrap());
    let report: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(folder.file("frames.json")).unwrap()).unwrap();
    let seconds: Vec<f64> =
        report["frames"].as_array().unwrap().iter().map(|row| row["total_s"].as_f64().unwrap()).collect();
    assert_eq!(seconds.len(), frames);
    let quarter = |number: usize| median(seconds[number * frames / 4..(number + 1) * frames / 4].to_vec());
    let (slope, drift) = (slope(&looks), quarter(3) / quarter(1));
    println!(
        "{frames} frames: {slope:.0} bytes/frame over {} looks, {:.1} MB at the end, {least} to {most} files open, frame time {:.2} ms, last quarter {drift:.3} of the second",
        looks.len(),
        looks.last().unwrap().memory * 1e-6,
        1e3 * quarter(1),
    );
    assert!(slope < most_bytes_per_frame, "{slope} bytes per frame");
    assert!(most <= least + 3, "{least} to {most} files");
    assert!(drift < most_drift, "frames became slower: {drift}");
}

/// Reports keep some numbers and a thumbnail of each frame: that may grow. The machine may be busy.
#[test]
fn a_hundred_frames_stay_flat() {
    soak(100, 50_000.0, 3.0);
}

/// `cargo test --release soak -- --ignored --nocapture`, on a machine that does nothing else.
#[test]
#[ignore = "takes a minute, and measures time"]
fn two_thousand_frames_stay_flat() {
    soak(2_000, 12_000.0, 1.1);
}
