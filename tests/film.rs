//! Film optics and colour against independent truth, and against what physics says.
//!
//! `tests/data/film` holds a small share of the truth tables; all of them are used where `../shared/film` (or
//! `$PELLICLE_SHARED/film`) is present.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::fs;
use std::path::{Path, PathBuf};

use pellicle::color::{
    Emission, Index, IndexCurve, IndexError, Lab, Sensor, Uplift, delta_e_2000, known_index_names, view,
};
use pellicle::film::{Layer, Range, Rung, Side, Stack, choose, exact, spectral};

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

/// Rows of (words, numbers): the first field is a word in tables that name their system.
fn table(path: &Path) -> Vec<(String, Vec<f64>)> {
    let text = fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut rows = Vec::new();
    for line in text.lines().filter(|line| !line.starts_with('#')).skip(1) {
        let numbers: Vec<f64> = line.split(',').filter_map(|field| field.parse().ok()).collect();
        rows.push((line.split(',').next().unwrap_or_default().to_owned(), numbers));
    }
    assert!(!rows.is_empty(), "{} is empty", path.display());
    rows
}

fn own(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/film").join(name)
}

/// The shared truth tables, or None with the reason printed.
pub fn shared() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    let folder = std::env::var_os("PELLICLE_SHARED").map_or(beside, PathBuf::from).join("film");
    if folder.is_dir() {
        return Some(folder);
    }
    println!("skipped the full tables: none at {} (set PELLICLE_SHARED)", folder.display());
    None
}

/// Own rows and, where present, all shared rows of one kind: (system, numbers).
fn truth(own_name: &str, shared_prefix: &str, columns: &[usize]) -> Vec<(String, Vec<f64>)> {
    let mut rows = table(&own(own_name));
    if let Some(folder) = shared() {
        for name in SYSTEMS {
            for (_, row) in table(&folder.join(format!("{shared_prefix}_{name}.csv"))) {
                rows.push((name.to_owned(), columns.iter().map(|&c| row[c]).collect()));
            }
        }
    }
    rows
}

fn constant(n: f64, k: f64) -> IndexCurve {
    IndexCurve::constant(n, k).unwrap()
}

fn named(name: &str) -> IndexCurve {
    Index::Named(name.to_owned()).curve().unwrap()
}

/// One layer of varying thickness.
fn film(outside: IndexCurve, layer: IndexCurve, base: IndexCurve) -> Stack {
    Stack { outside, layers: vec![Layer { index: layer, thickness_nm: 0.0 }], base, varying: Some(0), weight: 1.0 }
}

fn air() -> IndexCurve {
    constant(1.0, 0.0)
}

/// A system of the truth tables; `value` is their thickness column.
fn system(name: &str, value: f64) -> Stack {
    let simple = |a: f64, b: f64, c: f64| film(constant(a, 0.0), constant(b, 0.0), constant(c, 0.0));
    let layers = |indices: &[(f64, f64, f64)]| -> Vec<Layer> {
        indices.iter().map(|&(n, k, thickness_nm)| Layer { index: constant(n, k), thickness_nm }).collect()
    };
    match name {
        "soap_bubble" => simple(1.0, 1.33, 1.0),
        "soap_on_glass" => simple(1.0, 1.33, 1.5),
        "film15_on_water" => simple(1.0, 1.5, 1.33),
        "film15_from_water" => simple(1.33, 1.5, 1.0),
        "glass_from_inside" => simple(1.5, 1.33, 1.0),
        "ftir_gap" => simple(1.5, 1.0, 1.5),
        "tio2_on_gold" => film(air(), constant(2.4, 0.0), named("Au")),
        "sio2_on_al" => film(air(), constant(1.46, 0.0), named("Al")),
        "mgf2_on_glass" => simple(1.0, 1.38, 1.5),
        "oxide_on_ti" => film(air(), named("TiO2"), named("Ti")),
        "index_match" => simple(1.0, 1.5, 1.5),
        "absorbing_on_glass" => film(air(), constant(1.6, 0.3), constant(1.5, 0.0)),
        "qw5_on_glass" => {
            let (h, l) = ((2.35, 0.0, value / 4.0 / 2.35), (1.46, 0.0, value / 4.0 / 1.46));
            Stack { layers: layers(&[h, l, h, l, h]), ..Stack::bare(air(), constant(1.5, 0.0)) }
        }
        "butterfly21" | "butterfly21_abs" => {
            let absorbs = name == "butterfly21_abs";
            let k = if absorbs { 0.06 } else { 0.0 };
            let pair = [(1.56, k, 0.8 * value), (1.0, 0.0, 1.1 * value)];
            let indices: Vec<_> = (0..21).map(|i| pair[i % 2]).collect();
            let base = if absorbs { constant(1.56, 0.06) } else { air() };
            Stack { layers: layers(&indices), ..Stack::bare(air(), base) }
        }
        other => panic!("unknown system {other}"),
    }
}

fn measured_media(name: &str) -> bool {
    ["tio2_on_gold", "sio2_on_al", "oxide_on_ti"].contains(&name)
}

fn cos_deg(degrees: f64) -> f64 {
    degrees.to_radians().cos()
}

#[test]
fn exact_agrees_with_every_row_of_the_truth_tables() {
    let rows = truth("rt.csv", "rt", &[0, 1, 2, 3, 4, 5, 6]);
    for name in SYSTEMS {
        let (mut worst_r, mut worst_t) = (0.0f64, 0.0f64);
        for (_, row) in rows.iter().filter(|(system, _)| system == name) {
            let got = exact(&system(name, row[1]), Side::Outside, cos_deg(row[0]), row[1], row[2]);
            worst_r = worst_r.max((got.s.reflect - row[3]).abs()).max((got.p.reflect - row[4]).abs());
            worst_t = worst_t.max((got.s.transmit - row[5]).abs()).max((got.p.transmit - row[6]).abs());
        }
        println!("{name:20} |dR| {worst_r:.1e} |dT| {worst_t:.1e}");
        let tolerance = if measured_media(name) { 1e-5 } else { 1e-9 };
        assert!(worst_r < tolerance && worst_t < tolerance, "{name}: {worst_r:e} {worst_t:e}");
    }
}

#[test]
fn exact_agrees_with_sixty_digits_at_the_edges() {
    let mut rows = table(&own("edges.csv"));
    rows.extend(shared().map(|folder| table(&folder.join("edge_cases.csv"))).unwrap_or_default());
    let mut worst = 0.0f64;
    for (_, row) in &rows {
        let stack = film(constant(row[0], 0.0), constant(row[1], row[2]), constant(row[3], row[4]));
        // The cosines are f32 numbers printed with nine digits.
        let got = exact(&stack, Side::Outside, f64::from(row[6] as f32), row[5], row[7]);
        let values = [got.s.reflect, got.p.reflect, got.s.transmit, got.p.transmit];
        for (value, truth) in values.iter().zip(&row[8..]) {
            worst = worst.max((value - truth).abs());
        }
    }
    println!("{} edge cases, worst {worst:.1e}", rows.len());
    assert!(worst < 1e-9, "{worst:e}");
}

/// FILM tolerances of the f32 kernels: mean of the polarisations against `exact`, by region.
#[test]
fn f32_lanes_agree_with_exact_by_region() {
    let nm: [f32; 8] = std::array::from_fn(|i| 385.0 + 55.0 * i as f32);
    for name in SYSTEMS {
        let mut worst = [0.0f64; 3];
        for value in [0.0, 3.0, 40.0, 100.0, 270.0, 550.0, 1200.0, 3000.0] {
            let stack = system(name, value);
            // The other columns are a design wavelength and a percentage.
            if stack.varying.is_none() && !(40.0..=600.0).contains(&value) {
                continue;
            }
            let range = Range { min_nm: 0.0, max_nm: 3000.0 };
            let lanes = spectral(&stack, range);
            for side in [Side::Outside, Side::Inside] {
                let (from, to) =
                    if side == Side::Outside { (&stack.outside, &stack.base) } else { (&stack.base, &stack.outside) };
                let critical = |n: f64| (n / from.at(550.0).re).asin().to_degrees();
                let edges =
                    [critical(to.at(550.0).re), stack.layers.first().map_or(90.0, |l| critical(l.index.at(550.0).re))];
                for step in 0..180 {
                    let degrees = 0.5 * f64::from(step);
                    let mu = cos_deg(degrees) as f32;
                    let got = lanes.split(side, mu, value as f32, &nm);
                    let near = edges.iter().any(|edge| (degrees - edge).abs() < 1.0) || from.at(550.0).im > 0.0;
                    let region = if degrees > 89.4 {
                        2
                    } else if degrees > 85.0 || near {
                        1
                    } else {
                        0
                    };
                    for (i, nm) in nm.into_iter().enumerate() {
                        let truth = exact(&stack, side, f64::from(mu), value, f64::from(nm)).mean();
                        let error = (f64::from(got.reflect[i]) - truth.reflect).abs();
                        let error = error.max((f64::from(got.transmit[i]) - truth.transmit).abs());
                        worst[region] = worst[region].max(error);
                    }
                }
            }
        }
        println!("{name:20} f32: {:.1e}, edges {:.1e}, last half degree {:.1e}", worst[0], worst[1], worst[2]);
        assert!(worst[0] < 1e-4 && worst[1] < 5e-4 && worst[2] < 2e-3, "{name}: {worst:?}");
    }
}

#[test]
fn rungs_agree_with_the_colour_tables() {
    let sensor = Sensor::new(&Emission::D65);
    let rows = truth("colour.csv", "colour", &[0, 1, 5, 6, 7, 17, 18, 19]);
    for name in SYSTEMS {
        let mut line = format!("{name:20}");
        for rung in [Rung::Table, Rung::Gaussian, Rung::ThreeWave] {
            let mut rows: Vec<&Vec<f64>> =
                rows.iter().filter(|(system, row)| system == name && row[0] <= 85.0).map(|(_, row)| row).collect();
            rows.sort_by(|a, b| a[1].total_cmp(&b[1]));
            let (mut sum, mut worst, mut worst_t) = (0.0, 0.0f64, 0.0f64);
            for group in rows.chunk_by(|a, b| a[1] == b[1]) {
                let value = group[0][1];
                let (built, verdict) = choose(&system(name, value), Range::constant(value), &sensor, 1.0, Some(rung));
                if built.rung() != rung {
                    assert!(verdict.not_offered.iter().any(|(other, _)| *other == rung));
                    sum = f64::NAN;
                }
                for row in group {
                    let split = built.split(Side::Outside, cos_deg(row[0]) as f32, value as f32);
                    let error = delta_e_2000(lab(split.reflect), lab_f64(&row[2..5]));
                    (sum, worst) = (sum + error, worst.max(error));
                    worst_t = worst_t.max(delta_e_2000(lab(split.transmit), lab_f64(&row[5..8])));
                }
            }
            let mean = sum / rows.len() as f64;
            if mean.is_nan() {
                line += &format!(" | {rung} not offered");
                continue;
            }
            line += &format!(" | {rung} R mean {mean:.4} worst {worst:.3}, T worst {worst_t:.3}");
            if rung == Rung::Table {
                assert!(mean <= 0.02 && worst <= 1.0 && worst_t <= 1.0, "{name}: {mean} {worst} {worst_t}");
            }
        }
        println!("{line}");
    }
}

fn lab(rgb: [f32; 3]) -> Lab {
    Lab::from_linear_srgb(rgb.map(f64::from))
}

fn lab_f64(rgb: &[f64]) -> Lab {
    Lab::from_linear_srgb([rgb[0], rgb[1], rgb[2]])
}

/// A rung is nowhere much worse than its verdict says, over a finer grid than the ladder's own.
#[test]
fn rung_errors_stay_near_their_verdicts() {
    let sensor = Sensor::new(&Emission::D65);
    for (name, max_nm) in
        [("soap_bubble", 1200.0), ("tio2_on_gold", 500.0), ("oxide_on_ti", 300.0), ("ftir_gap", 800.0)]
    {
        let stack = system(name, 0.0);
        for rung in [Rung::Table, Rung::ThreeWave] {
            let (built, verdict) = choose(&stack, Range { min_nm: 0.0, max_nm }, &sensor, 1.0, Some(rung));
            let (mut worst, mut sum, mut count) = (0.0f64, 0.0, 0);
            for i in 0..23 {
                for j in 0..18 {
                    let (nm, mu) = (max_nm * f64::from(i) / 22.0, cos_deg(5.0 * f64::from(j)));
                    let truth = |nm_: f64| exact(&stack, Side::Outside, mu, nm, nm_).mean().reflect;
                    let truth = Lab::from_linear_srgb(sensor.rgb_of_reflectance(truth));
                    let error = delta_e_2000(truth, lab(built.split(Side::Outside, mu as f32, nm as f32).reflect));
                    (worst, sum, count) = (worst.max(error), sum + error, count + 1);
                }
            }
            println!("{name} {rung}: mean {:.3} worst {worst:.3}; {verdict}", sum / f64::from(count));
            let told = verdict.tried[0].worst_delta_e;
            assert!(worst <= 3.0 * told + 1.0, "{name} {rung}: worst {worst}, told {told}");
        }
    }
}

/// Named laws of thin films (FILM a6), in f64.
#[test]
fn exact_obeys_the_laws_of_thin_films() {
    let close = |a: f64, b: f64, what: &str| assert!((a - b).abs() < 1e-12, "{what}: {a} {b}");
    for degrees in [0.0, 20.0, 50.0, 70.0, 85.0, 89.9] {
        let mu = cos_deg(degrees);
        let nm = 550.0;
        for base in [constant(1.0, 0.0), constant(1.5, 0.0), named("Au")] {
            let bare = exact(&Stack::bare(air(), base.clone()), Side::Outside, mu, 0.0, nm).mean();
            let soap = film(air(), constant(1.33, 0.0), base.clone());
            close(exact(&soap, Side::Outside, mu, 0.0, nm).mean().reflect, bare.reflect, "no thickness is bare");
            close(exact(&soap, Side::Outside, mu, -9.0, nm).mean().reflect, bare.reflect, "negative counts as 0");
            let same = film(air(), base.clone(), base.clone());
            close(exact(&same, Side::Outside, mu, 77.0, nm).mean().reflect, bare.reflect, "film = base is bare");
            let empty = film(air(), air(), base.clone());
            close(exact(&empty, Side::Outside, mu, 432.0, nm).mean().reflect, bare.reflect, "film = outside is bare");
            let half = 0.5 * nm / (1.33f64.powi(2) - 1.0 + mu * mu).sqrt();
            close(exact(&soap, Side::Outside, mu, half, nm).mean().reflect, bare.reflect, "half a wave is bare");
            let twice = exact(&soap, Side::Outside, mu, 600.0, 1100.0).mean().reflect;
            if base.as_constant().is_some() {
                close(exact(&soap, Side::Outside, mu, 300.0, nm).mean().reflect, twice, "scaling");
            }
            let split = Stack {
                layers: vec![
                    Layer { index: constant(1.6, 0.2), thickness_nm: 40.0 },
                    Layer { index: constant(1.6, 0.2), thickness_nm: 60.0 },
                ],
                ..Stack::bare(air(), base.clone())
            };
            let whole = film(air(), constant(1.6, 0.2), base.clone());
            let (split, whole) =
                (exact(&split, Side::Outside, mu, 0.0, nm), exact(&whole, Side::Outside, mu, 100.0, nm));
            close(split.mean().reflect, whole.mean().reflect, "splitting a layer");
            close(split.mean().transmit, whole.mean().transmit, "splitting a layer");
        }
        let quarter = film(air(), constant(1.5f64.sqrt(), 0.0), constant(1.5, 0.0));
        let thickness = 0.25 * nm / 1.5f64.sqrt();
        close(exact(&quarter, Side::Outside, 1.0, thickness, nm).mean().reflect, 0.0, "quarter wave");
        let mirror = film(air(), constant(1.33, 0.0), constant(0.0, 3.0));
        close(exact(&mirror, Side::Outside, mu, 321.0, nm).mean().reflect, 1.0, "Gires-Tournois");
        let opaque =
            exact(&film(air(), constant(1.6, 0.5), constant(2.0, 0.0)), Side::Outside, mu, 50_000.0, nm).mean();
        let half_space = exact(&Stack::bare(air(), constant(1.6, 0.5)), Side::Outside, mu, 0.0, nm).mean();
        close(opaque.reflect, half_space.reflect, "an opaque film is a half space");

        // Reciprocity at the conjugate angle, absorbing or not; R + T <= 1; R + T = 1 without losses.
        for layer in [constant(2.1, 0.0), constant(1.6, 0.1), constant(1.2, 0.0)] {
            let stack = film(air(), layer.clone(), constant(1.5, 0.0));
            let conjugate = (1.0 - (1.0 - mu * mu) / 2.25).sqrt();
            let (there, back) =
                (exact(&stack, Side::Outside, mu, 400.0, nm), exact(&stack, Side::Inside, conjugate, 400.0, nm));
            close(there.s.transmit, back.s.transmit, "reciprocity");
            close(there.p.transmit, back.p.transmit, "reciprocity");
            let sum = there.mean().reflect + there.mean().transmit;
            assert!(sum < 1.0 + 1e-12);
            if layer.max_k() == 0.0 {
                close(sum, 1.0, "energy");
            }
        }
    }
}

#[test]
fn nothing_is_ever_not_a_number() {
    let sensor = Sensor::new(&Emission::D65);
    let indices = [(1.0, 0.0), (1.33, 0.0), (2.4, 0.0), (0.6, 0.0), (1.6, 0.3), (0.05, 10.0), (0.0, 1000.0)];
    let nm = [380.0f32, 500.0, 613.7, 780.0];
    for outside in [1.0, 1.5] {
        for layer in indices {
            for base in indices {
                let stack = film(constant(outside, 0.0), constant(layer.0, layer.1), constant(base.0, base.1));
                let range = Range { min_nm: 0.0, max_nm: 60.0 };
                let lanes = spectral(&stack, range);
                let rgb = choose(&stack, range, &sensor, 1.0, Some(Rung::Table)).0;
                for side in [Side::Outside, Side::Inside] {
                    for mu in [0.0, 1e-9, 1e-4, 0.3, 0.745_356, 0.9, 1.0, 1.0 + 1e-7] {
                        for nm_thick in [-5.0f32, 0.0, 1e-3, 55.0, 1e3, 5e4] {
                            let truth = exact(&stack, side, mu, f64::from(nm_thick), 550.0).mean();
                            let split = lanes.split(side, mu as f32, nm_thick, &nm);
                            let table = rgb.split(side, mu as f32, nm_thick);
                            let what = || format!("{outside} {layer:?} {base:?} {side:?} {mu} {nm_thick}");
                            assert!((-1e-12..=1.0 + 1e-12).contains(&truth.reflect), "{} {truth:?}", what());
                            for value in split.reflect.iter().chain(&split.transmit) {
                                assert!((-1e-4..=1.0 + 1e-3).contains(value), "{} {split:?}", what());
                            }
                            for value in table.reflect.iter().chain(&table.transmit) {
                                assert!((-0.5..=1.5).contains(value), "{} {table:?}", what());
                            }
                        }
                    }
                }
            }
        }
    }
}

/// n2^2 (1 - F_inside) = n0^2 (1 - F_outside), and the tables agree with the quadrature per wavelength.
#[test]
fn averages_keep_energy() {
    let sensor = Sensor::new(&Emission::E);
    let nm: [f32; 4] = [400.0, 500.0, 600.0, 700.0];
    for (name, value) in [("soap_on_glass", 380.0), ("film15_from_water", 200.0), ("absorbing_on_glass", 150.0)] {
        let stack = system(name, 0.0);
        let lanes = spectral(&stack, Range { min_nm: 0.0, max_nm: 600.0 });
        let integral = |side: Side, nm: f64| {
            let at = |i: i32| (f64::from(i) + 0.5) / 20_000.0;
            (0..20_000)
                .map(|i| 2.0 * at(i) * exact(&stack, side, at(i), value, nm).mean().reflect / 20_000.0)
                .sum::<f64>()
        };
        for side in [Side::Outside, Side::Inside] {
            let average = lanes.average(side, value as f32, &nm);
            for i in 0..4 {
                let truth = integral(side, f64::from(nm[i]));
                assert!(
                    (f64::from(average[i]) - truth).abs() < 3e-3,
                    "{name} {side:?} {}: {} {truth}",
                    nm[i],
                    average[i]
                );
            }
            let table = choose(&stack, Range { min_nm: 0.0, max_nm: 600.0 }, &sensor, 1.0, Some(Rung::Table)).0;
            let (rgb, got) = (sensor.rgb_of_reflectance(|nm| integral(side, nm)), table.average(side, value as f32));
            for c in 0..3 {
                assert!((rgb[c] - f64::from(got[c])).abs() < 2e-3, "{name} {side:?}: {rgb:?} {got:?}");
            }
        }
    }
}

#[test]
fn spectra_and_sensors_are_normalised() {
    for white in [Emission::E, Emission::D65, Emission::A, Emission::Blackbody(3000.0)] {
        let sensor = Sensor::new(&white);
        assert!(sensor.rgb_of_reflectance(|_| 1.0).iter().all(|c| (c - 1.0).abs() < 1e-12));
        let mean = (0..4000).map(|i| 380.05 + 0.1 * i as f32).fold([0.0f64; 3], |sum, nm| {
            let (response, power) = (sensor.response(nm), sensor.white().at(f64::from(nm)));
            std::array::from_fn(|c| sum[c] + f64::from(response[c]) * power / 4000.0)
        });
        assert!(mean.iter().all(|c| (c - 1.0).abs() < 2e-4), "{white:?} {mean:?}");
    }
    // A flat spectrum under D65 is the published white; A is warmer than D65, which is nearly a 6500 K black body.
    let sensor = Sensor::new(&Emission::D65);
    let light = |emission: Emission| sensor.rgb_of_light(|nm| emission.spectrum().at(nm));
    let [r, g, b] = light(Emission::E);
    assert!((r - 1.205).abs() < 2e-3 && (g - 0.948).abs() < 2e-3 && (b - 0.909).abs() < 2e-3, "{r} {g} {b}");
    let [r, g, b] = light(Emission::A);
    assert!(r > 1.5 && g < 1.0 && b < 0.4 && r > g && g > b);
    assert!(light(Emission::Blackbody(6504.0)).iter().all(|c| (c - 1.0).abs() < 0.06));
    assert!(light(Emission::Blackbody(1.0)).iter().all(|c| c.is_finite()));
    // Uplifted colours come back, and stay reflectances.
    let uplift = Uplift::new();
    for rgb in [[1.0f32, 1.0, 1.0], [0.8, 0.1, 0.05], [0.0, 1.0, 0.0], [0.2, 0.3, 0.9]] {
        let back = sensor.rgb_of_reflectance(|nm| f64::from(uplift.uplift(rgb, &[nm as f32])[0]));
        assert!((0..3).all(|c| (back[c] - f64::from(rgb[c])).abs() < 2e-3), "{rgb:?} {back:?}");
        let lanes: [f32; 16] = uplift.uplift(rgb, &std::array::from_fn(|i| 380.0 + 25.0 * i as f32));
        assert!(lanes.iter().all(|r| (-1e-4..=1.0 + 1e-4).contains(r)));
    }
    for value in [0.0f32, 0.001, 0.0031308, 0.2, 1.0] {
        assert!((view::srgb_decode(view::srgb_encode(value)) - value).abs() < 1e-6);
    }
}

#[test]
fn ciede2000_gives_the_published_differences() {
    for (_, row) in table(&own("ciede2000.csv")) {
        let lab = |at: usize| Lab { l: row[at], a: row[at + 1], b: row[at + 2] };
        assert!((delta_e_2000(lab(0), lab(3)) - row[6]).abs() < 1e-4, "{row:?}");
        assert!((delta_e_2000(lab(3), lab(0)) - row[6]).abs() < 1e-4, "{row:?}");
    }
}

#[test]
fn named_indices_are_indices() {
    assert!(known_index_names().len() > 50);
    for name in known_index_names() {
        let curve = named(name);
        for nm in (380..=780).step_by(10) {
            let index = curve.at(f64::from(nm));
            assert!(index.re > 0.0 && index.re < 7.0 && index.im >= 0.0 && index.im < 9.0, "{name} {nm}: {index}");
        }
    }
    for (name, n, k) in [("BK7", 1.5168, 0.0), ("water", 1.3334, 0.0), ("diamond", 2.4175, 0.0), ("Au", 0.28, 2.93)] {
        let index = named(name).at(587.56);
        assert!((index.re - n).abs() < 0.02 && (index.im - k).abs() < 0.02, "{name}: {index}");
    }
    let unknown = Index::Named("Gald".to_owned()).curve();
    assert!(matches!(unknown, Err(IndexError::Unknown { .. })));
    let near = Index::Named("SiO3".to_owned()).curve().unwrap_err().to_string();
    assert!(near.contains("did you mean \"SiO2\""), "{near}");
    assert!(Index::Table(vec![(500.0, 1.5, 0.0), (400.0, 1.5, 0.0)]).curve().is_err());
    assert!(Index::Constant { n: 0.0, k: 0.0 }.curve().is_err());
    assert!(Index::Constant { n: 0.0, k: 1000.0 }.curve().is_ok());
}
