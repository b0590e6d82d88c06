//! `pellicle chart`: what is charted is what was measured.

use std::fs;
use std::path::Path;

use pellicle::output::is_complete;

use crate::cli::{Folder, fail, succeed};

/// A CSV as maps from its heads to fields; quoted fields hold no commas here.
fn rows(file: &str) -> Vec<std::collections::HashMap<String, String>> {
    let text = fs::read_to_string(file).unwrap();
    let mut lines = text.lines();
    let heads: Vec<String> = lines.next().unwrap().split(',').map(str::to_owned).collect();
    let row = |line: &str| {
        let fields: Vec<String> = line.split(',').map(|field| field.trim_matches('"').to_owned()).collect();
        assert_eq!(fields.len(), heads.len(), "{line}");
        heads.iter().cloned().zip(fields).collect()
    };
    lines.map(row).collect()
}

fn all_three_are_there(base: &str) {
    let svg = fs::read_to_string(format!("{base}.svg")).unwrap();
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
    assert!(is_complete(Path::new(&format!("{base}.png"))));
}

#[test]
fn film_models_are_timed_and_judged() {
    let folder = Folder::new("chart-films");
    let base = folder.file("bubble");
    let stack = ["--layer", "1.33,0", "--base", "air", "--thickness", "0,800", "--repeats", "3"];
    let table = succeed(&[&["chart", "films", "-o", &base], &stack[..]].concat()).stdout;
    all_three_are_there(&base);
    let rows = rows(&format!("{base}.csv"));
    let models: Vec<String> = rows.iter().map(|row| format!("{} {}", row["model"], row["paths"])).collect();
    let expected = ["bare 0", "table 0", "three-wave 0", "gaussian 0"].into_iter().map(str::to_owned);
    let lanes = [4, 8, 16].into_iter().flat_map(|n| [1, 64].map(|paths| format!("spectral-{n} {paths}")));
    assert_eq!(models, expected.chain(lanes).collect::<Vec<_>>());
    for row in &rows {
        let number = |name: &str| row[name].parse::<f64>().unwrap();
        assert!(number("ns_median") > 0.0 && number("ns_q1") <= number("ns_median"), "{row:?}");
        assert!(number("de_mean") <= number("de_p99") && number("de_p99") <= number("de_worst"), "{row:?}");
    }
    // No interference at all is far off, the tabulated integral is near, wavelengths agree in the mean.
    let mean = |model: usize| rows[model]["de_mean"].parse::<f64>().unwrap();
    assert!(mean(0) > 5.0 && mean(1) < 0.2 && mean(2) > mean(3), "{table}");
    assert!(mean(4) > mean(6) && mean(6) > mean(8) && [5, 7, 9].iter().all(|&row| mean(row) < 0.1), "{table}");
    assert!(table.lines().any(|line| line.starts_with("* table")), "{table}");
}

#[test]
fn films_of_a_scene_are_its_coated_materials() {
    let table = succeed(&["chart", "films", "film.dae", "--repeats", "1"]).stdout;
    assert!(table.contains("table") && table.contains("spectral-16, 64 paths"), "{table}");
    assert!(fail(2, &["chart", "films", "room.dae"]).contains("no material has a film"));
    assert!(fail(2, &["chart", "films", "--layer", "1.3,200"]).contains("--base"));
    assert!(fail(2, &["chart", "films", "film.dae", "--base", "1.5"]).contains("cannot be used with"));
}

const QUICK: [&str; 10] =
    ["--size", "12x9", "--spp", "2,8", "--repeats", "2", "--reference-spp", "128", "--config", "rgb=--mode rgb"];

#[test]
fn convergence_measures_every_configuration_alike() {
    let folder = Folder::new("chart-convergence");
    let (base, cache, series) = (folder.file("room"), folder.file("cache"), folder.file("s.exr"));
    succeed(&["render", "room.dae", "-o", &series, "-r", "12x9", "--spp", "32", "--float", "--mode", "rgb", "-q"]);
    let pellicle = env!("CARGO_BIN_EXE_pellicle");
    let outside = format!("outside={series},{series}@2.5");
    let more = ["--config", "spectral=--mode spectral", "--vs", pellicle, "--series", &outside, "--cache", &cache];
    let arguments = [&["chart", "convergence", "film.dae", "-o", &base], &QUICK[..], &more[..]].concat();
    let first = succeed(&arguments);
    all_three_are_there(&base);
    let rows = rows(&format!("{base}.csv"));
    // Two configurations by two programs, two numbers of samples, two repeats; two pictures from outside.
    assert_eq!(rows.len(), 2 * 2 * 2 * 2 + 2);
    let of = |name: &str| rows.iter().filter(|row| row["config"] == name).cloned().collect::<Vec<_>>();
    for (name, reference) in [("rgb", "rgb"), ("spectral", "spectral")] {
        let (own, other) = (of(name), of(&format!("{name} (vs)")));
        assert_eq!((own.len(), other.len()), (4, 4));
        for (own, other) in own.iter().zip(&other) {
            // The second program is the first one: the same seeds give the same pictures, and so the same errors.
            for field in ["repeat", "spp", "noise_reference", "noise_mse", "relmse", "ciede2000_mean", "flip_mean"] {
                assert_eq!(own[field], other[field], "{name} {field}");
            }
            assert_eq!((own["noise_reference"].as_str(), own["reference"].as_str()), (reference, "spectral"));
            assert!(own["wall_s"].parse::<f64>().unwrap() > 0.0 && own["cpu_s"].parse::<f64>().unwrap() > 0.0);
        }
        let mse = |spp: &str| -> f64 {
            let rows = own.iter().filter(|row| row["spp"] == spp);
            rows.map(|row| row["noise_mse"].parse::<f64>().unwrap()).sum()
        };
        assert!(mse("8") < mse("2"));
    }
    assert_eq!((of("outside")[1]["wall_s"].as_str(), of("outside")[0]["spp"].as_str()), ("2.5", "32"));
    assert_eq!(of("outside")[0]["noise_mse"], "");

    // The second run takes both references from the cache, with the errors that they had.
    let second = succeed(&arguments).stdout;
    assert_eq!(second.matches("from the cache").count(), 2, "{second}");
    let errors = |text: &str| -> Vec<String> {
        let lines = text.lines().filter(|line| line.starts_with("reference"));
        lines.map(|line| line.rsplit("its own error: ").next().unwrap().to_owned()).collect()
    };
    assert_eq!(errors(&first.stdout), errors(&second));
}

#[test]
fn a_reference_that_is_not_converged_is_pointed_at() {
    let folder = Folder::new("chart-floor");
    let cache = folder.file("cache");
    let arguments =
        ["chart", "convergence", "room.dae", "-r", "12x9", "--spp", "64", "--repeats", "1", "--cache", &cache];
    let few = [&arguments[..], &["--config", "all=--mode rgb", "--reference-spp", "16"]].concat();
    let said = succeed(&few).stderr;
    assert!(said.contains("all at 64 spp comes within 4 times the error of reference rgb"), "{said}");
    let many = [&arguments[..], &["--config", "all=--mode rgb", "--reference-spp", "4096"]].concat();
    let said = succeed(&many).stderr;
    assert!(!said.contains("comes within"), "{said}");
}

#[test]
fn only_unbiased_comparable_pictures_are_charted() {
    let folder = Folder::new("chart-refused");
    let cache = folder.file("cache");
    let refused = |more: &[&str]| {
        fail(2, &[&["chart", "convergence", "room.dae"], &QUICK[..], &["--cache", &cache], more].concat())
    };
    let clamp = refused(&["--config", "dim=--clamp 1"]);
    assert!(clamp.contains("--config dim: --clamp makes renders biased"), "{clamp}");
    assert!(refused(&["--all", "--clamp 1"]).contains("biased"));
    assert!(refused(&["--config", "more=--spp 8"]).contains("--spp"));
    assert!(refused(&["--config", "no=--stratgy light"]).contains("--stratgy"));
    assert!(refused(&["--config", "light"]).contains("NAME=OPTIONS"));
    assert!(refused(&["--config", "other=--camera narrow"]).contains("--all"));
    assert!(refused(&["--series", "x=a.exr@soon"]).contains("soon"));

    let dim = folder.file("dim.exr");
    succeed(&["render", "room.dae", "-o", &dim, "-r", "12x9", "--spp", "4", "--clamp", "1", "-q"]);
    assert!(refused(&["--series", &format!("x={dim}")]).contains("biased"));
    let large = folder.file("large.exr");
    succeed(&["render", "room.dae", "-o", &large, "-r", "16x9", "--spp", "4", "-q"]);
    assert!(refused(&["--series", &format!("x={large}")]).contains("16x9 instead of 12x9"));
}

#[test]
fn growth_is_measured_at_every_size() {
    let folder = Folder::new("chart-growth");
    let base = folder.file("growth");
    let table = succeed(&["chart", "growth", "--quick", "-o", &base]).stdout;
    all_three_are_there(&base);
    let rows = rows(&format!("{base}.csv"));
    let of = |name: &str, field: &str| -> Vec<f64> {
        let mine = rows.iter().filter(|row| row["series"] == name);
        mine.map(|row| row[field].parse().unwrap()).collect()
    };
    for (name, sizes) in [
        ("triangles", &[968.0, 10_082.0, 100_352.0][..]),
        ("lights", &[1.0, 10.0, 100.0]),
        ("pixels", &[4096.0, 16_384.0, 65_536.0]),
        ("bounces", &[1.0, 2.0, 4.0, 8.0]),
        ("lanes", &[3.0, 4.0, 8.0, 16.0]),
    ] {
        assert_eq!(of(name, "size"), sizes);
        for field in ["build_s", "build_wall_s", "us_per_sample"] {
            assert!(of(name, field).iter().all(|&number| number > 0.0 && number.is_finite()), "{name} {field}");
        }
        for row in ["exponent", "larger half"] {
            let lines = table.lines().skip_while(|line| !line.starts_with(name)).skip(1);
            assert!(lines.take_while(|line| !line.is_empty()).any(|line| line.starts_with(row)), "{table}");
        }
    }
    // What does not depend on the clock: paths get longer as they may, and carry whatever lanes they have just as far.
    let rays = of("bounces", "rays_per_sample");
    assert!(rays.windows(2).all(|pair| pair[1] > pair[0]), "{rays:?}");
    let rays = of("lanes", "rays_per_sample");
    assert!(rays.iter().all(|&number| (number / rays[0] - 1.0).abs() < 0.2), "{rays:?}");
    assert!(of("lights", "relmse").iter().all(|&error| error > 0.0 && error.is_finite()));
    // Vertices, indices and a BVH; 80 bytes of a pixel. Both with room for what the machine does otherwise.
    let (scene, picture) = (of("triangles", "build_mb")[2], of("pixels", "render_mb")[2]);
    assert!((5.0..50.0).contains(&scene) && (2.0..50.0).contains(&picture), "{scene} {picture}");
    let svg = fs::read_to_string(format!("{base}.svg")).unwrap();
    assert!(["build: ", "time per sample: ", "memory: ", "noise x time: "].iter().all(|name| svg.contains(name)));
}

#[test]
fn growth_says_what_it_cannot_do() {
    let few = fail(1, &["chart", "growth", "--quick", "--max-memory", "5M"]);
    assert!(few.contains("100000 triangles: the scene needs about") && few.contains("--max-memory"), "{few}");
    let nowhere = fail(3, &["chart", "growth", "-o", "no/such/folder/growth"]);
    assert!(nowhere.contains("no/such/folder") && !nowhere.contains("triangles"), "{nowhere}");
    assert!(fail(2, &["chart", "growth", "--threads", "100000"]).contains("--threads"));
    assert!(fail(2, &["chart", "growth", "--one", "lamps:3"]).contains("SERIES:SIZE"));
}
