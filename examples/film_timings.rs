//! Nanoseconds per evaluation of every film model, table sizes and build times.
//!
//!     cargo run --release --example film_timings
//!
//! Times are the best of many runs on one core; angles and thicknesses are scattered.

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use pellicle::color::{Emission, Index, IndexCurve, Sensor};
use pellicle::film::{Layer, Range, Rung, Side, Stack, choose, exact, spectral};

const EVALUATIONS: u32 = 4096;

fn main() -> Result<(), Box<dyn Error>> {
    let sensor = Sensor::new(&Emission::D65);
    let named = |name: &str| Index::Named(name.to_owned()).curve();
    let film = |layer: IndexCurve, base: IndexCurve| -> Result<Stack, Box<dyn Error>> {
        let layers = vec![Layer { index: layer, thickness_nm: 300.0 }];
        Ok(Stack { layers, varying: Some(0), ..Stack::bare(IndexCurve::constant(1.0, 0.0)?, base) })
    };
    let plain = |n: f64, k: f64| IndexCurve::constant(n, k);
    let mut systems = vec![
        ("bubble, 0..1200 nm", film(plain(1.33, 0.0)?, plain(1.0, 0.0)?)?, 1200.0),
        ("bubble, 0..50000 nm", film(plain(1.33, 0.0)?, plain(1.0, 0.0)?)?, 50_000.0),
        ("soap on BK7, 0..1200 nm", film(named("soap")?, named("BK7")?)?, 1200.0),
        ("n = 2.4 on Au, 0..500 nm", film(plain(2.4, 0.0)?, named("Au")?)?, 500.0),
        ("TiO2 on Ti, 0..300 nm", film(named("TiO2")?, named("Ti")?)?, 300.0),
        ("Fe3O4 on Fe, 0..200 nm", film(named("Fe3O4")?, named("Fe")?)?, 200.0),
        ("1.6+0.3i on 1.5, 0..500 nm", film(plain(1.6, 0.3)?, plain(1.5, 0.0)?)?, 500.0),
    ];
    for (label, mut stack, _) in systems.clone() {
        if let Some(label) = label.split(',').next() {
            stack.varying = None;
            systems.push((label, stack, 0.0));
        }
    }
    systems.push(("bare Au", Stack::bare(plain(1.0, 0.0)?, named("Au")?), 0.0));
    systems.push(("bare n = 1.5", Stack::bare(plain(1.0, 0.0)?, plain(1.5, 0.0)?), 0.0));

    for (label, stack, max_nm) in systems {
        let range = Range { min_nm: 0.0, max_nm };
        println!("{label}");
        for rung in Rung::ALL {
            let start = Instant::now();
            let (rgb, verdict) = choose(&stack, range, &sensor, 1.0, Some(rung));
            let milliseconds = 1e3 * start.elapsed().as_secs_f64();
            let Some(trial) = verdict.tried.first().filter(|_| rgb.rung() == rung) else { continue };
            let ns = best_ns(|mu, share| black_box(rgb.split(Side::Outside, mu, share * max_nm as f32)));
            println!(
                "  {rung:10} {ns:6.1} ns, dE mean {:.3} worst {:.3}, {} bytes, built in {:.2} ms ({milliseconds:.2} ms with the verdict)",
                trial.mean_delta_e,
                trial.worst_delta_e,
                trial.table_bytes,
                1e3 * trial.build_seconds,
            );
        }
        let start = Instant::now();
        let lanes = spectral(&stack, range);
        let built = 1e3 * start.elapsed().as_secs_f64();
        let (nm4, nm8, nm16) = (waves::<4>(), waves::<8>(), waves::<16>());
        let scaled = |share: f32| share * max_nm as f32;
        let four = best_ns(|mu, d| black_box(lanes.split(Side::Outside, mu, scaled(d), black_box(&nm4))));
        let eight = best_ns(|mu, d| black_box(lanes.split(Side::Outside, mu, scaled(d), black_box(&nm8))));
        let sixteen = best_ns(|mu, d| black_box(lanes.split(Side::Outside, mu, scaled(d), black_box(&nm16))));
        let average = best_ns(|_, d| black_box(lanes.average(Side::Outside, scaled(d), black_box(&nm8))));
        println!(
            "  spectral   4: {four:.1} ns, 8: {eight:.1} ns, 16: {sixteen:.1} ns, average of 8: {average:.1} ns, built in {built:.2} ms"
        );
        let yardstick =
            best_ns(|mu, d| black_box(exact(&stack, Side::Outside, f64::from(mu), f64::from(scaled(d)), 550.0)));
        println!("  exact      {yardstick:.1} ns per wavelength");
    }
    Ok(())
}

fn waves<const N: usize>() -> [f32; N] {
    std::array::from_fn(|i| 385.0 + 390.0 / N as f32 * i as f32)
}

/// The best time per evaluation of `evaluate(cosine, share of the thickness range)`.
fn best_ns<T>(evaluate: impl Fn(f32, f32) -> T) -> f64 {
    let scatter = |i: u32, by: u32| (i.wrapping_mul(by) >> 8) as f32 / 16_777_216.0;
    let inputs: Vec<(f32, f32)> =
        (0..EVALUATIONS).map(|i| (scatter(i, 2_654_435_761), scatter(i, 2_246_822_519))).collect();
    let run = || {
        let start = Instant::now();
        for &(mu, share) in &inputs {
            evaluate(mu, share);
        }
        start.elapsed().as_secs_f64()
    };
    (0..50).map(|_| run()).fold(f64::INFINITY, f64::min) * 1e9 / f64::from(EVALUATIONS)
}
