//! Stills that end at a time or a noise.

use super::*;

/// What the statistics of a render say, with its hash.
fn stats(folder: &Folder, options: &[&str]) -> (serde_json::Value, String) {
    let (file, json) = (folder.file("a.exr"), folder.file("a.json"));
    let start = ["render", "room.dae", "-o", &file, "--stats", &json, "--hash"];
    let run = succeed(&[&start[..], options].concat());
    (serde_json::from_str(&fs::read_to_string(json).unwrap()).unwrap(), run.stdout)
}

#[test]
fn a_time_ends_a_still() {
    let folder = Folder::new("still-time");
    let (stats, _) = stats(&folder, &["--size", "64x48", "--time", "0.5s"]);
    let (render_s, spp) = (stats["render_s"].as_f64().unwrap(), stats["spp"].as_u64().unwrap());
    // A pass may take a little longer than those before it; the machine may be busy.
    assert!((0.1..1.5).contains(&render_s) && spp > 2, "{render_s} s, {spp} spp");
    assert!(is_complete(Path::new(&folder.file("a.exr"))));
}

const NOISY: [&str; 4] = ["--size", "128x96", "--noise", "0.002"];

#[test]
fn a_noise_ends_a_still_with_the_same_bits_however_it_is_made() {
    let folder = Folder::new("still-noise");
    let (one, hash) = stats(&folder, &[&NOISY[..], &["--threads", "1"]].concat());
    let number = |name: &str| one[name].as_f64().unwrap();
    assert!(number("noise") <= 0.002 && number("noise") > 0.0007, "{one}");
    assert!(number("spp") >= 32.0 && number("mean_spp") > number("spp"), "{one}");
    assert_eq!(stats(&folder, &[&NOISY[..], &["--threads", "3"]].concat()).1, hash);

    // Stopped and gone on with.
    let file = folder.file("b.exr");
    let arguments = [&["render", "room.dae", "-o", &file, "--resume", "--hash", "--threads", "1"], &NOISY[..]].concat();
    let (mut stops, mut tries) = (0, 0);
    let last = loop {
        let child = command(&arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(30 + 30 * tries));
        let _ = Command::new("kill").args(["-s", "INT", &child.id().to_string()]).output();
        let run: Run = child.wait_with_output().unwrap().into();
        if run.code == Some(0) {
            break run;
        }
        // One that was caught before it had begun has nothing to save.
        assert!(matches!(run.code, Some(75) | None), "{:?} {}", run.code, run.stderr);
        stops += u64::from(run.code == Some(75));
        tries += 1;
        assert!(tries < 60, "it never ends");
    };
    assert!(stops > 0, "the first run was too quick to be stopped");
    assert_eq!(last.stdout, hash, "after {stops} stops");
}

#[test]
fn the_most_samples_hold_where_the_noise_is_out_of_reach() {
    let folder = Folder::new("still-most");
    let (stats, hash) = stats(&folder, &["--noise", "1e-6", "--spp", "50"]);
    assert_eq!((stats["spp"].as_u64(), stats["mean_spp"].as_f64()), (Some(50), Some(50.0)));
    assert_eq!(self::stats(&folder, &["--spp", "50"]).1, hash);
}

#[test]
fn parts_are_not_cut_short() {
    let folder = Folder::new("still-part");
    let stderr = fail(2, &["render", "room.dae", "-o", &folder.file("a.part"), "--noise", "0.1"]);
    assert!(stderr.contains("--noise"), "{stderr}");
}
