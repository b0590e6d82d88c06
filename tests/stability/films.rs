//! The optics: exact in f64, per wavelength in f32, and the tables.

use pellicle::color::{Emission, IndexCurve, Sensor};
use pellicle::film::{Layer, Range, Rung, Side, Split, Stack, choose, exact, spectral};

use super::Count;

const INDICES: [f64; 7] = [0.3, 0.999_999, 1.0, 1.33, 1.5, 2.4, 10.0];
const EXTINCTIONS: [f64; 5] = [0.0, 1e-6, 0.01, 1.0, 10.0];
/// (n, k): air, the film's neighbours' own indices, ideal and real metals, a faintly absorbing body.
const BASES: [(f64, f64); 7] = [(1.0, 0.0), (1.5, 0.0), (0.5, 0.0), (1.5, 1e-6), (0.2, 3.0), (0.0, 4.0), (3.0, 10.0)];
/// Negative from noise, nothing, an atom's share, ..., the thickest, and what a broken texel holds.
const THICKNESSES: [f64; 7] = [-100.0, 0.0, 1e-3, 1.0, 300.0, 50_000.0, f64::NAN];
const NM: [f32; 4] = [380.0, 470.0, 550.0, 780.0];

struct System {
    stack: Stack,
    name: String,
    lossless: bool,
}

/// Every film on every base, its thickness varying.
fn systems() -> Vec<System> {
    let curve = |n: f64, k: f64| IndexCurve::constant(n, k).unwrap();
    let mut systems = Vec::new();
    for n in INDICES {
        for k in EXTINCTIONS {
            for base in BASES {
                let layers = vec![Layer { index: curve(n, k), thickness_nm: 300.0 }];
                let stack = Stack { layers, varying: Some(0), ..Stack::bare(curve(1.0, 0.0), curve(base.0, base.1)) };
                let lossless = k == 0.0 && base.1 == 0.0;
                systems.push(System { stack, name: format!("{n}+{k}i on {base:?}"), lossless });
            }
        }
    }
    systems
}

/// Straight down, sideways, along the surface, and around every critical angle of these media.
fn cosines(system: &System, side: Side) -> Vec<f64> {
    let (outside, base) = (1.0, system.stack.base.at(550.0).re);
    let from = if side == Side::Outside { outside } else { base };
    let mut cosines = vec![1.0, 0.5, 0.1, 1e-3, 1e-6, 0.0];
    for to in [outside, base, system.stack.layers[0].index.at(550.0).re] {
        if to < from {
            let critical = (1.0 - (to / from).powi(2)).sqrt();
            cosines.extend([-1e-6, 0.0, 1e-6].map(|off| critical + off));
        }
    }
    cosines
}

fn sides(system: &System) -> &'static [Side] {
    // Light from inside a body that absorbs has no beginning: R and T are not shares of anything there.
    if system.stack.base.max_k() > 0.0 { &[Side::Outside] } else { &[Side::Outside, Side::Inside] }
}

fn physical(count: &mut Count, split: Split<f64>, lossless: bool, slack: f64, at: &dyn Fn() -> String) {
    let Split { reflect, transmit } = split;
    count.assert(reflect.is_finite() && transmit.is_finite(), || format!("{}: {split:?}", at()));
    let within = reflect >= -slack && transmit >= -slack && reflect + transmit <= 1.0 + slack;
    count.assert(within, || format!("{}: {split:?} is beyond 0..1", at()));
    if lossless {
        count.assert((reflect + transmit - 1.0).abs() <= slack, || format!("{}: {split:?} does not add up to 1", at()));
    }
}

#[test]
fn exact_optics_are_physical_at_every_extreme() {
    let mut count = Count::default();
    for system in systems() {
        for &side in sides(&system) {
            for cos in cosines(&system, side) {
                for nm in THICKNESSES {
                    count.combination();
                    let split = exact(&system.stack, side, cos, nm, 550.0).mean();
                    let at = || format!("{}, {side:?}, cos {cos}, {nm} nm", system.name);
                    physical(&mut count, split, system.lossless, 1e-9, &at);
                }
                continuous(&mut count, &system, side, cos);
            }
        }
    }
    count.finish(2_000);
}

/// No film, less than none, and one that is not a number are the bare surface, and so is next to none; and a film of its
/// neighbour's index changes nothing.
fn continuous(count: &mut Count, system: &System, side: Side, cos: f64) {
    let bare = Stack::bare(system.stack.outside.clone(), system.stack.base.clone());
    let truth = exact(&bare, side, cos, 0.0, 550.0).mean();
    let at = |nm: f64| exact(&system.stack, side, cos, nm, 550.0).mean();
    let near = |a: Split<f64>, slack: f64| {
        (a.reflect - truth.reflect).abs() <= slack && (a.transmit - truth.transmit).abs() <= slack
    };
    let name = || format!("{}, {side:?}, cos {cos}: bare {truth:?}", system.name);
    for nm in [0.0, -100.0, f64::NAN] {
        count.assert(near(at(nm), 1e-12), || format!("{} but {nm} nm {:?}", name(), at(nm)));
    }
    // A millionth of a nanometre: everything changes in proportion to thickness times permittivity over cosine.
    let slack = 1e-7 * system.stack.layers[0].index.at(550.0).norm_sqr().max(1.0) / cos.max(1e-3);
    if cos >= 1e-3 {
        count.assert(near(at(1e-6), slack), || format!("{} but a trace {:?}", name(), at(1e-6)));
    }
    let (film, base) = (system.stack.layers[0].index.at(550.0), system.stack.base.at(550.0));
    if film == base && base.im == 0.0 {
        count.assert(near(at(300.0), 1e-9), || format!("{} but index matched {:?}", name(), at(300.0)));
    }
}

#[test]
fn wavelengths_in_f32_follow_the_exact_optics_at_every_extreme() {
    let mut count = Count::default();
    for system in systems() {
        let film = spectral(&system.stack, Range { min_nm: 0.0, max_nm: 1_000.0 });
        for &side in sides(&system) {
            for cos in cosines(&system, side) {
                for nm in THICKNESSES {
                    count.combination();
                    let split = film.split(side, cos as f32, nm as f32, &NM);
                    for ((reflect, transmit), lambda) in split.reflect.iter().zip(&split.transmit).zip(NM) {
                        let at = || format!("{}, {side:?}, cos {cos}, {nm} nm, {lambda} nm", system.name);
                        let here = Split { reflect: f64::from(*reflect), transmit: f64::from(*transmit) };
                        physical(&mut count, here, system.lossless, 2e-5, &at);
                    }
                }
            }
            let average = film.average(side, 300.0, &NM);
            count.assert(average.iter().all(|a| (-1e-5..=1.0 + 1e-5).contains(a)), || {
                format!("{}, {side:?}: average {average:?}", system.name)
            });
        }
    }
    count.finish(2_000);
}

#[test]
fn tables_are_physical_at_every_extreme() {
    let mut count = Count::default();
    let sensor = Sensor::new(&Emission::D65);
    // A luminance is a mean of reflectances; single channels of saturated colours leave 0..1.
    let luminance = |[r, g, b]: [f32; 3]| 0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b);
    for (i, mut system) in systems().into_iter().enumerate() {
        // Thickness varies in some: their tables are a hundred times as large.
        let varies = i % 12 == 5;
        let max_nm = if varies { 400.0 } else { 0.0 };
        if !varies {
            system.stack.varying = None;
        }
        let range = Range { min_nm: 0.0, max_nm };
        let (film, _) = choose(&system.stack, range, &sensor, 1.0, Some(Rung::Table));
        for &side in sides(&system) {
            for cos in cosines(&system, side) {
                for nm in if varies { &THICKNESSES[..] } else { &[300.0] } {
                    count.combination();
                    let split = film.split(side, cos as f32, *nm as f32);
                    let here = Split { reflect: luminance(split.reflect), transmit: luminance(split.transmit) };
                    let at = || format!("{}, {side:?}, cos {cos}, {nm} nm", system.name);
                    physical(&mut count, here, system.lossless, 2e-3, &at);
                }
            }
        }
    }
    count.finish(2_000);
}
