//! Film optics and colour against independent truth.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::fs;
use std::path::{Path, PathBuf};

use pellicle::color::{Emission, Index, IndexCurve, Lab, Sensor, delta_e_2000};
use pellicle::film::{Layer, Range, RgbFilm, Rung, Side, Stack, choose, exact, spectral};

/// The shared truth tables, or None with the reason printed.
fn shared() -> Option<PathBuf> {
    let root = std::env::var_os("PELLICLE_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"), PathBuf::from);
    let folder = root.join("film");
    if folder.is_dir() {
        return Some(folder);
    }
    println!("skipped: no truth tables at {} (set PELLICLE_SHARED)", folder.display());
    None
}

fn rows(path: &Path) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(path).unwrap();
    text.lines()
        .filter(|line| !line.starts_with('#'))
        .filter_map(|line| line.split(',').map(|field| field.trim().parse().ok()).collect())
        .collect()
}

fn constant(n: f64, k: f64) -> IndexCurve {
    IndexCurve::constant(n, k).unwrap()
}

fn measured(folder: &Path, name: &str) -> IndexCurve {
    IndexCurve::table(rows(&folder.join(format!("nk_{name}.csv"))).iter().map(|row| (row[0], row[1], row[2]))).unwrap()
}

fn film(outside: IndexCurve, layer: IndexCurve, base: IndexCurve) -> Stack {
    Stack { outside, layers: vec![Layer { index: layer, thickness_nm: 0.0 }], base, varying: Some(0), weight: 1.0 }
}

/// The system of a truth table; `value` is its thickness column. (stack, thickness of the varying layer, tolerance)
fn system(folder: &Path, name: &str, value: f64) -> Option<(Stack, f64)> {
    let simple = |a: f64, b: f64, c: f64| film(constant(a, 0.0), constant(b, 0.0), constant(c, 0.0));
    let layers = |indices: &[(f64, f64, f64)]| -> Vec<Layer> {
        indices.iter().map(|&(n, k, thickness_nm)| Layer { index: constant(n, k), thickness_nm }).collect()
    };
    let stack = match name {
        "soap_bubble" => simple(1.0, 1.33, 1.0),
        "soap_on_glass" => simple(1.0, 1.33, 1.5),
        "film15_on_water" => simple(1.0, 1.5, 1.33),
        "film15_from_water" => simple(1.33, 1.5, 1.0),
        "glass_from_inside" => simple(1.5, 1.33, 1.0),
        "ftir_gap" => simple(1.5, 1.0, 1.5),
        "tio2_on_gold" => film(constant(1.0, 0.0), constant(2.4, 0.0), measured(folder, "Au_Johnson")),
        "sio2_on_al" => film(constant(1.0, 0.0), constant(1.46, 0.0), measured(folder, "Al_Rakic")),
        "mgf2_on_glass" => simple(1.0, 1.38, 1.5),
        "oxide_on_ti" => film(constant(1.0, 0.0), measured(folder, "TiO2_Siefke"), measured(folder, "Ti_Johnson")),
        "index_match" => simple(1.0, 1.5, 1.5),
        "absorbing_on_glass" => film(constant(1.0, 0.0), constant(1.6, 0.3), constant(1.5, 0.0)),
        "qw5_on_glass" => {
            let (h, l) = ((2.35, 0.0, value / 4.0 / 2.35), (1.46, 0.0, value / 4.0 / 1.46));
            Stack { layers: layers(&[h, l, h, l, h]), ..Stack::bare(constant(1.0, 0.0), constant(1.5, 0.0)) }
        }
        "butterfly21" | "butterfly21_abs" => {
            let k = if name == "butterfly21" { 0.0 } else { 0.06 };
            let pair = [(1.56, k, 0.8 * value), (1.0, 0.0, 1.1 * value)];
            let indices: Vec<_> = (0..21).map(|i| pair[i % 2]).collect();
            let base = if name == "butterfly21" { constant(1.0, 0.0) } else { constant(1.56, 0.06) };
            Stack { layers: layers(&indices), ..Stack::bare(constant(1.0, 0.0), base) }
        }
        _ => return None,
    };
    Some((stack, value))
}

const SYSTEMS: [&str; 15] = [
    "soap_bubble",
    "soap_on_glass",
    "film15_on_water",
    "film15_from_water",
    "glass_from_inside",
    "ftir_gap",
    "tio2_on_gold",
    "sio2_on_al",
    "mgf2_on_glass",
    "oxide_on_ti",
    "index_match",
    "absorbing_on_glass",
    "qw5_on_glass",
    "butterfly21",
    "butterfly21_abs",
];

#[test]
fn exact_agrees_with_every_row_of_the_truth_tables() {
    let Some(folder) = shared() else { return };
    for name in SYSTEMS {
        let (mut worst_r, mut worst_t) = (0.0f64, 0.0f64);
        for row in rows(&folder.join(format!("rt_{name}.csv"))) {
            let (stack, nm) = system(&folder, name, row[1]).unwrap();
            let got = exact(&stack, Side::Outside, row[0].to_radians().cos(), nm, row[2]);
            worst_r = worst_r.max((got.s.reflect - row[3]).abs()).max((got.p.reflect - row[4]).abs());
            worst_t = worst_t.max((got.s.transmit - row[5]).abs()).max((got.p.transmit - row[6]).abs());
        }
        println!("{name:20} |dR| {worst_r:.1e} |dT| {worst_t:.1e}");
        let tolerance = if ["tio2_on_gold", "sio2_on_al", "oxide_on_ti"].contains(&name) { 1e-5 } else { 1e-9 };
        assert!(worst_r < tolerance && worst_t < tolerance, "{name}: {worst_r:e} {worst_t:e}");
    }
}

#[test]
fn exact_agrees_with_sixty_digits_at_the_edges() {
    let Some(folder) = shared() else { return };
    let (mut worst, mut count) = (0.0f64, 0);
    for row in rows(&folder.join("edge_cases.csv")) {
        let stack = film(constant(row[0], 0.0), constant(row[1], row[2]), constant(row[3], row[4]));
        // The cosines are f32 numbers printed with nine digits.
        let got = exact(&stack, Side::Outside, f64::from(row[6] as f32), row[5], row[7]);
        let values = [got.s.reflect, got.p.reflect, got.s.transmit, got.p.transmit];
        for (value, truth) in values.iter().zip(&row[8..]) {
            worst = worst.max((value - truth).abs());
        }
        count += 1;
    }
    println!("{count} edge cases, worst {worst:.1e}");
    assert!(count > 1000 && worst < 1e-8, "{worst:e}");
}

#[test]
fn rungs_agree_with_the_colour_tables() {
    let Some(folder) = shared() else { return };
    let sensor = Sensor::new(&Emission::D65);
    for name in SYSTEMS {
        let mut line = format!("{name:20}");
        for rung in [Rung::Table, Rung::ThreeWave, Rung::Gaussian] {
            let (mut sum, mut worst, mut count, mut worst_t) = (0.0, 0.0f64, 0.0, 0.0f64);
            let mut built: Vec<(f64, RgbFilm)> = Vec::new();
            for row in rows(&folder.join(format!("colour_{name}.csv"))) {
                if row[0] > 85.0 {
                    continue;
                }
                let (mut stack, nm) = system(&folder, name, row[1]).unwrap();
                if let Some(layer) = stack.varying.take() {
                    stack.layers[layer].thickness_nm = nm;
                }
                if built.last().is_none_or(|(value, _)| *value != row[1]) {
                    match built.iter().position(|(value, _)| *value == row[1]) {
                        Some(at) => {
                            let last = built.len() - 1;
                            built.swap(at, last);
                        }
                        None => {
                            let film = choose(&stack, Range { min_nm: 0.0, max_nm: 0.0 }, &sensor, 1.0, Some(rung));
                            built.push((row[1], film.0));
                        }
                    }
                }
                let film = &built.last().unwrap().1;
                if film.rung() != rung {
                    continue;
                }
                let split = film.split(Side::Outside, row[0].to_radians().cos() as f32, 0.0);
                let de = |got: [f32; 3], at: usize| {
                    delta_e_2000(
                        Lab::from_linear_srgb(got.map(f64::from)),
                        Lab::from_linear_srgb([row[at], row[at + 1], row[at + 2]]),
                    )
                };
                let error = de(split.reflect, 5);
                sum += error;
                worst = worst.max(error);
                worst_t = worst_t.max(de(split.transmit, 17));
                count += 1.0;
            }
            line += &format!(" {rung} mean {:.4} worst {worst:.3} T {worst_t:.3} ", sum / count);
            if rung == Rung::Table {
                assert!(sum / count <= 0.02 && worst <= 1.0, "{name}: {} {worst}", sum / count);
            }
        }
        println!("{line}");
    }
}

#[test]
#[ignore = "a measurement: cargo test --release --test film film_timings -- --ignored --nocapture"]
fn film_timings() {
    use std::hint::black_box;
    let sensor = Sensor::new(&Emission::D65);
    let name = |n: &str| Index::Named(n.into()).curve().unwrap();
    let systems = [
        ("soap bubble", film(constant(1.0, 0.0), constant(1.33, 0.0), constant(1.0, 0.0)), 1200.0),
        ("soap on BK7", film(constant(1.0, 0.0), name("soap"), name("BK7")), 1200.0),
        ("TiO2 2.4 on Au", film(constant(1.0, 0.0), constant(2.4, 0.0), name("Au")), 500.0),
        ("TiO2 on Ti", film(constant(1.0, 0.0), name("TiO2"), name("Ti")), 300.0),
        ("absorbing", film(constant(1.0, 0.0), constant(1.6, 0.3), constant(1.5, 0.0)), 1000.0),
    ];
    let inputs: Vec<(f32, f32)> = (0..4096u32)
        .map(|i| {
            ((i.wrapping_mul(2654435761) >> 8) as f32 / 16777216.0, (i.wrapping_mul(40503) & 0xffff) as f32 / 65536.0)
        })
        .collect();
    let ns = |f: &mut dyn FnMut(f32, f32)| {
        let mut best = f64::INFINITY;
        for _ in 0..20 {
            let start = std::time::Instant::now();
            for &(mu, d) in &inputs {
                f(mu, d);
            }
            best = best.min(start.elapsed().as_secs_f64() / inputs.len() as f64 * 1e9);
        }
        best
    };
    for (label, stack, max_nm) in systems {
        let fixed = {
            let mut s = stack.clone();
            s.varying = None;
            s.layers[0].thickness_nm = 0.4 * max_nm;
            s
        };
        let range = Range { min_nm: 0.0, max_nm };
        print!("{label:16}");
        for (what, s) in [("1-D", &fixed), ("2-D", &stack)] {
            let start = std::time::Instant::now();
            let (f, verdict) = choose(s, range, &sensor, 1.0, Some(Rung::Table));
            let total = start.elapsed().as_secs_f64();
            let t = ns(&mut |mu, d| {
                black_box(f.split(Side::Outside, mu, d * max_nm as f32));
            });
            print!(
                " table {what} {t:.1} ns (choose {:.1} ms, build {:.1} ms, {} kB, worst dE {:.3})",
                total * 1e3,
                verdict.tried[0].build_seconds * 1e3,
                verdict.tried[0].table_bytes / 1024,
                verdict.tried[0].worst_delta_e
            );
        }
        let (f, _) = choose(&stack, range, &sensor, 1.0, Some(Rung::ThreeWave));
        print!(
            " three-wave {:.1} ns",
            ns(&mut |mu, d| {
                black_box(f.split(Side::Outside, mu, d * max_nm as f32));
            })
        );
        let start = std::time::Instant::now();
        let f = spectral(&stack, range);
        print!(" spectral build {:.2} ms", start.elapsed().as_secs_f64() * 1e3);
        let nm4: [f32; 4] = std::array::from_fn(|i| 400.0 + 90.0 * i as f32);
        let nm8: [f32; 8] = std::array::from_fn(|i| 400.0 + 45.0 * i as f32);
        let nm16: [f32; 16] = std::array::from_fn(|i| 390.0 + 24.0 * i as f32);
        print!(
            " N=4 {:.1}",
            ns(&mut |mu, d| {
                black_box(f.split(Side::Outside, mu, d * max_nm as f32, black_box(&nm4)));
            })
        );
        print!(
            " N=8 {:.1}",
            ns(&mut |mu, d| {
                black_box(f.split(Side::Outside, mu, d * max_nm as f32, black_box(&nm8)));
            })
        );
        print!(
            " N=16 {:.1}",
            ns(&mut |mu, d| {
                black_box(f.split(Side::Outside, mu, d * max_nm as f32, black_box(&nm16)));
            })
        );
        println!(
            " avg8 {:.1}",
            ns(&mut |_, d| {
                black_box(f.average(Side::Outside, d * max_nm as f32, black_box(&nm8)));
            })
        );
    }
    let (f, _) = choose(&Stack::bare(constant(1.0, 0.0), constant(1.5, 0.0)), Range::constant(0.0), &sensor, 1.0, None);
    println!(
        "{} {:.1} ns",
        f.rung(),
        ns(&mut |mu, d| {
            black_box(f.split(Side::Outside, mu, d));
        })
    );
}
