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
