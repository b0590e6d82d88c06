//! `pellicle compare` as scripts use it, the variance layers that it needs, and `--clamp`, which it would find out.

use std::fs;
use std::path::Path;

use pellicle::output::{HeaderValue, LayerKind, Picture, is_complete, read_exr};
use serde_json::Value;

use crate::cli::{Folder, fail, run, succeed};

const SMALL: [&str; 5] = ["--size", "24x18", "--spp", "32", "--quiet"];

/// Renders the small room as floats and gives the file.
fn render(folder: &Folder, name: &str, options: &[&str]) -> String {
    let file = folder.file(name);
    succeed(&[&["render", "room.dae", "-o", &file, "--float"], &SMALL[..], options].concat());
    file
}

fn picture(file: &str) -> Picture {
    read_exr(Path::new(file)).unwrap()
}

fn compared(options: &[&str]) -> Value {
    serde_json::from_str(&succeed(&[&["compare", "--json"], options].concat()).stdout).unwrap()
}

#[test]
fn a_picture_is_like_itself() {
    let folder = Folder::new("like-itself");
    let a = render(&folder, "a.exr", &[]);
    let found = compared(&[&a, &a]);
    for metric in ["mse", "rel_mse", "trimmed_rel_mse"] {
        assert_eq!(found[metric], 0.0, "{metric}");
    }
    assert_eq!((&found["delta_e"]["max"], &found["flip"]["max"]), (&Value::from(0.0), &Value::from(0.0)));
    assert_eq!(found["z_test"], Value::Null);
    let text = succeed(&["compare", &a, &a]).stdout;
    assert!(
        text.starts_with("24x18, exposed by") && text.contains("FLIP") && text.contains("--aov variance"),
        "{text}"
    );
}

#[test]
fn errors_are_those_of_the_pixels() {
    let folder = Folder::new("errors");
    let [a, b] = [["a.exr", "1"], ["b.exr", "2"]].map(|[name, seed]| render(&folder, name, &["--seed", seed]));
    let found = compared(&[&a, &b]);
    let (one, two) = (picture(&a), picture(&b));
    let pixels = one.rgba.iter().zip(&two.rgba);
    let sum: f64 = pixels.flat_map(|(a, b)| (0..3).map(|c| f64::from(a[c]) - f64::from(b[c]))).map(|d| d * d).sum();
    let mse = sum / (3.0 * 24.0 * 18.0);
    assert!((found["mse"].as_f64().unwrap() / mse - 1.0).abs() < 1e-12 && mse > 0.0, "{found} {mse}");
}

#[test]
fn limits_decide_the_exit_code() {
    let folder = Folder::new("limits");
    let [a, b] = [["a.exr", "1"], ["b.exr", "2"]].map(|[name, seed]| render(&folder, name, &["--seed", seed]));
    let loose = ["--max-mse", "1e3", "--max-relmse", "1e3", "--max-de", "99", "--max-flip", "1"];
    succeed(&[&["compare", &a, &b], &loose[..]].concat());
    for limit in ["--max-mse", "--max-relmse", "--max-de", "--max-flip"] {
        let run = run(&["compare", &a, &b, limit, "1e-9"]);
        assert_eq!(run.code, Some(1), "{limit}");
        assert!(run.stderr.contains("is above 0.000000001") && run.stdout.contains("MSE"), "{}", run.stderr);
    }
    assert!(fail(2, &["compare", &a, &b, "--max-mse", "0"]).contains("above 0"));
    assert!(fail(3, &["compare", &a, &folder.file("none.exr")]).contains("none.exr"));
}

#[test]
fn pictures_of_different_sizes_are_refused_with_both_sizes() {
    let folder = Folder::new("sizes");
    let a = render(&folder, "a.exr", &[]);
    let b = folder.file("b.exr");
    succeed(&["render", "room.dae", "-o", &b, "-r", "20x10", "--spp", "1", "-q"]);
    let error = fail(2, &["compare", &a, &b]);
    assert!(error.contains("a.exr is 24x18") && error.contains("b.exr is 20x10"), "{error}");
}

#[test]
fn the_difference_is_drawn() {
    let folder = Folder::new("drawn");
    let [a, b] = [["a.exr", "1"], ["b.exr", "2"]].map(|[name, seed]| render(&folder, name, &["--seed", seed]));
    let png = folder.file("d.png");
    succeed(&["compare", &a, &b, "--diff", &png, "--diff-max", "20"]);
    assert!(is_complete(Path::new(&png)));
    assert!(fail(2, &["compare", &a, &b, "--diff", &folder.file("d.exr")]).contains(".png"));
}

#[test]
fn variance_layers_are_there_when_asked_for_and_say_how_noisy_the_mean_is() {
    let folder = Folder::new("variance");
    assert!(picture(&render(&folder, "plain.exr", &[])).layers.is_empty());
    let options = |seed| ["--aov", "variance", "--seed", seed];
    let [a, b] = [["a.exr", "1"], ["b.exr", "2"]].map(|[name, seed]| picture(&render(&folder, name, &options(seed))));
    let names: Vec<&str> = a.layers.iter().map(|layer| layer.name.as_str()).collect();
    assert_eq!(names, ["variance.B", "variance.G", "variance.R"]);
    assert!(a.layers.iter().all(|layer| layer.kind == LayerKind::Float));
    // The samples of a pixel are stratified: the variance of independent ones is an upper bound, far above at the edges of lights.
    let stated: f32 = a.layers.iter().chain(&b.layers).flat_map(|layer| &layer.data).sum();
    let pixels = a.rgba.iter().zip(&b.rgba);
    let squares: f32 = pixels.flat_map(|(a, b)| (0..3).map(|c| (a[c] - b[c]).powi(2))).sum();
    assert!((0.02..1.2).contains(&(squares / stated)), "{squares} {stated}");
    assert!(fail(2, &["render", "room.dae", "-o", "a.exr", "--aov", "depht"]).contains("variance"));
}

#[test]
fn the_z_test_passes_what_differs_by_noise_and_finds_what_does_not() {
    let folder = Folder::new("z-test");
    let options = |seed, bounces| ["--aov", "variance", "--seed", seed, "--max-bounces", bounces];
    let a = render(&folder, "a.exr", &options("1", "4"));
    let same = render(&folder, "same.exr", &options("2", "4"));
    let darker = render(&folder, "darker.exr", &options("3", "0"));
    assert_eq!(compared(&[&a, &same, "--alpha", "0.001"])["z_test"]["passed"], true);
    let found = run(&["compare", &a, &darker, "--alpha", "0.001"]);
    assert_eq!(found.code, Some(1));
    assert!(found.stdout.contains("DIFFERENT") && found.stderr.contains("z-test"), "{}", found.stderr);
    // Unless it is asked for, what the test finds is told but is no failure.
    assert!(succeed(&["compare", &a, &darker]).stdout.contains("DIFFERENT"));
    let plain = render(&folder, "plain.exr", &[]);
    assert!(fail_with_text(2, &["compare", &a, &plain, "--alpha", "0.01"]).contains("--aov variance"));
}

/// Like `fail`, for runs that print what they found before.
fn fail_with_text(code: i32, arguments: &[&str]) -> String {
    let run = run(arguments);
    assert_eq!(run.code, Some(code), "{}", run.stderr);
    run.stderr
}

#[test]
fn clamping_is_called_biased_wherever_it_happened() {
    let folder = Folder::new("clamp");
    let noted = |file: &str| picture(file).header.into_iter().find(|(name, _)| name == "pellicle/biased");
    let stats = folder.file("stats.json");
    let free = render(&folder, "free.exr", &[]);
    let clamped = folder.file("clamped.exr");
    let run = succeed(&[
        "render", "room.dae", "-o", &clamped, "--float", "-r", "24x18", "--spp", "32", "--clamp", "0.5", "--stats",
        &stats,
    ]);
    assert!(run.stderr.lines().any(|line| line.ends_with("biased: samples clamped to 0.5")), "{}", run.stderr);
    assert_eq!(noted(&free), None);
    assert_eq!(noted(&clamped).unwrap().1, HeaderValue::Text("samples clamped to 0.5".to_owned()));
    let sum = |file: &str| picture(file).rgba.iter().flat_map(|pixel| pixel[..3].to_vec()).sum::<f32>();
    assert!(sum(&clamped) < sum(&free));
    assert!(picture(&clamped).rgba.iter().all(|pixel| pixel[..3].iter().all(|&value| value <= 0.500_001)));
    let stats: Value = serde_json::from_str(&fs::read_to_string(stats).unwrap()).unwrap();
    assert!(stats["clamped_samples"].as_u64().unwrap() > 0);
    assert!(fail(2, &["render", "room.dae", "-o", "a.exr", "--clamp", "0"]).contains("above 0"));
}

/// Oxide on titanium that faces coated gold needs wavelengths; anodised plates that see only grey felt do not.
#[test]
fn auto_carries_wavelengths_where_films_face_each_other() {
    let folder = Folder::new("auto");
    for (scene, mode) in [("facing_films", "mode: spectral"), ("titanium", "mode: rgb")] {
        let scene = format!("{}/scenes/{scene}.dae", env!("CARGO_MANIFEST_DIR"));
        let run = succeed(&["render", &scene, "-o", &folder.file("a.exr"), "-r", "48x", "--spp", "1"]);
        assert!(run.stderr.contains(mode), "{}", run.stderr);
    }
}
