//! The denoiser, where there is one.

use super::*;

/// Sets the library for a run of the program.
fn with_library(library: Option<&str>, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pellicle"));
    command.args(arguments).current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/cli"));
    match library {
        Some(library) => command.env("PELLICLE_OIDN_LIB", library),
        None => command.env_remove("PELLICLE_OIDN_LIB"),
    };
    let output = command.output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn without_the_library_one_line_says_so_and_the_noisy_picture_is_kept() {
    let folder = Folder::new("no-library");
    for (name, library, reason) in [
        ("absent.exr", "/nowhere/libOpenImageDenoise.so.2", "cannot open shared object file"),
        ("other.exr", "libm.so.6", "a library without oidnNewDevice is not Open Image Denoise"),
    ] {
        let file = folder.file(name);
        let (code, stderr) = with_library(Some(library), &["render", "room.dae", "-o", &file, "--denoise", "--float"]);
        assert_eq!(code, Some(0), "{stderr}");
        let warnings: Vec<&str> = stderr.lines().filter(|line| line.contains("denois")).collect();
        let [line] = warnings.as_slice() else { panic!("{stderr}") };
        for expected in ["warning: cannot denoise", reason, "pip install pyoidn", "$PELLICLE_OIDN_LIB"] {
            assert!(line.contains(expected), "{line}");
        }
        let plain = folder.file("plain.exr");
        succeed(&["render", "room.dae", "-o", &plain, "--float", "-q"]);
        let [found, plain] = [&file, &plain].map(|file| read_exr(Path::new(file)).unwrap());
        assert_eq!((found.rgba, found.layers.len()), (plain.rgba, 0));
    }
    let part = folder.file("a.part");
    assert!(fail(2, &["render", "room.dae", "-o", &part, "--samples", "0:2", "--denoise"]).contains("--denoise"));
}

/// Against the library that PELLICLE_OIDN_LIB names, or that the system has.
#[test]
fn with_the_library_noise_goes_and_colours_stay() {
    let folder = Folder::new("library");
    let library = std::env::var("PELLICLE_OIDN_LIB").ok();
    let file = folder.file("a.exr");
    let options = ["render", "film.dae", "-r", "96x72", "--strategy", "mis", "-o"];
    let run = |options: &[&str]| with_library(library.as_deref(), options);
    let (code, stderr) = run(&[&options[..], &[&file, "--denoise", "--float", "--spp", "16", "--aov", "N"]].concat());
    assert_eq!(code, Some(0), "{stderr}");
    if stderr.contains("cannot denoise") {
        println!(
            "skipped: needs Open Image Denoise ({})",
            stderr.lines().find(|line| line.contains("denoise")).unwrap()
        );
        return;
    }
    let reference = folder.file("reference.exr");
    run(&[&options[..], &[&reference, "--float", "--spp", "1024", "--seed", "9"]].concat());
    let [picture, reference] = [&file, &reference].map(|file| read_exr(Path::new(file)).unwrap());
    let floor = layer(&picture, "N.Y");
    let denoised = ["denoised.R", "denoised.G", "denoised.B"].map(|name| layer(&picture, name));
    let (mut before, mut after, mut sums) = (0.0, 0.0, [0.0f64; 2]);
    // The lamp has no noise; where it ends, blurring is all that there is to lose.
    for (index, truth) in reference.rgba.iter().enumerate().filter(|(index, _)| floor[*index] > 0.99) {
        for channel in 0..3 {
            let [noisy, clean] = [picture.rgba[index][channel], denoised[channel][index]].map(f64::from);
            let truth = f64::from(truth[channel]);
            before += (noisy - truth).powi(2);
            after += (clean - truth).powi(2);
            sums[0] += clean;
            sums[1] += truth;
        }
    }
    assert!(after < 0.5 * before, "{after} of {before}");
    assert!((sums[0] / sums[1] - 1.0).abs() < 0.03, "{sums:?}");
    let version = picture.header.iter().find(|(name, _)| name == "pellicle/denoiser");
    let Some((_, HeaderValue::Text(version))) = version else { panic!("{:?}", picture.header) };
    assert!(version.starts_with("Open Image Denoise "), "{version}");

    // A PNG is the denoised picture, with the noisy one beside it.
    let png = folder.file("b.png");
    run(&[&options[..], &[&png, "--denoise", "--spp", "4"]].concat());
    assert_ne!(fs::read(&png).unwrap(), fs::read(folder.file("b.noisy.png")).unwrap());
}
