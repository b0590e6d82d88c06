//! What an evaluation of each film model costs, beside how wrong it is.

use std::hint::black_box;
use std::time::Instant;

use glam::Vec3;

use crate::color::{Emission, Lab, Sensor, delta_e_2000};
use crate::film::{Range, RgbFilm, Rung, Side, SpectralFilm, choose, spectral};
use crate::math::GOLDEN;
use crate::mode::{Mode, Spectral};

use super::coating::Coating;
use super::colours::exact_colour;
use super::metrics::Spread;

/// Angles of the errors: even steps to where surfaces are seen rather than glimpsed.
const ANGLES_DEG: [f64; 18] = [0., 5., 10., 15., 20., 25., 30., 35., 40., 45., 50., 55., 60., 65., 70., 75., 80., 85.];
/// Thicknesses of the errors, where they vary.
const THICKNESSES: usize = 16;
/// Paths whose mean the second row of a spectral model shows: a modest pixel.
pub const PATHS: u32 = 64;
/// Evaluations of one timing: short enough that most are not disturbed.
const EVALUATIONS: u32 = 4096;

/// One model of one stack.
#[derive(Clone, Debug)]
pub struct FilmCost {
    pub stack: String,
    /// The name of a rung, or `spectral-N`.
    pub model: String,
    /// Paths whose mean is judged; 0 where the model has no noise.
    pub paths: u32,
    /// Of one evaluation on one core: first quartile, median, third quartile over the repeats.
    pub ns: [f64; 3],
    /// CIEDE2000 of R as a surface colour against `film::exact`, over angle and thickness.
    pub errors: Vec<f64>,
    pub table_bytes: usize,
    pub build_s: f64,
}

impl FilmCost {
    pub fn spread(&self) -> Spread {
        Spread::of(&self.errors)
    }
}

/// Something whose evaluations are timed.
enum Model {
    Rgb(RgbFilm),
    Lanes(usize),
}

/// Measures every RGB rung and every number of wavelengths on a stack, and names the rungs that do not apply. Timings of
/// the models take turns, `repeats` times, so that what disturbs the machine disturbs all alike.
pub fn film_costs(
    coating: &Coating,
    range: Range,
    illuminant: &Emission,
    repeats: usize,
) -> (Vec<FilmCost>, Vec<(Rung, &'static str)>) {
    let sensor = Sensor::new(illuminant);
    let truth = Truth::new(coating, range, &sensor);
    let mut models: Vec<(Model, f64, usize)> = Vec::new();
    let mut not_offered = Vec::new();
    for rung in Rung::ALL {
        let (film, verdict) = choose(&coating.stack, range, &sensor, f64::INFINITY, Some(rung));
        if let Some(refused) = verdict.not_offered.iter().find(|(refused, _)| *refused == rung) {
            not_offered.push(*refused);
        } else if let Some(trial) = verdict.tried.first() {
            models.push((Model::Rgb(film), trial.build_seconds, trial.table_bytes));
        }
    }
    let start = Instant::now();
    let lanes = spectral(&coating.stack, range);
    let build_s = start.elapsed().as_secs_f64();
    models.extend([4, 8, 16].map(|count| (Model::Lanes(count), build_s, 0)));

    let inputs = inputs(range);
    let mut times_ns = vec![Vec::with_capacity(repeats); models.len()];
    for _ in 0..repeats {
        for ((model, ..), times) in models.iter().zip(&mut times_ns) {
            times.push(model.time_ns(&lanes, &inputs));
        }
    }

    let mut costs = Vec::new();
    for ((model, build_s, table_bytes), mut times) in models.into_iter().zip(times_ns) {
        times.sort_by(f64::total_cmp);
        let ns = [0.25, 0.5, 0.75].map(|share| times[(share * (times.len() - 1) as f64).round() as usize]);
        let cost = |model: String, paths: u32, errors: Vec<f64>| FilmCost {
            stack: coating.label.clone(),
            model,
            paths,
            ns,
            errors,
            table_bytes,
            build_s,
        };
        match model {
            Model::Rgb(film) => costs.push(cost(film.rung().name().to_owned(), 0, truth.errors_of_rgb(&film))),
            Model::Lanes(count) => costs.extend([1, PATHS].map(|paths| {
                let errors = match count {
                    4 => truth.errors_of_lanes::<4>(&lanes, illuminant, &sensor, paths),
                    8 => truth.errors_of_lanes::<8>(&lanes, illuminant, &sensor, paths),
                    _ => truth.errors_of_lanes::<16>(&lanes, illuminant, &sensor, paths),
                };
                cost(format!("spectral-{count}"), paths, errors)
            })),
        }
    }
    (costs, not_offered)
}

/// Scattered cosines and thicknesses.
fn inputs(range: Range) -> Vec<(f32, f32)> {
    let scatter = |i: u32, by: u32| (i.wrapping_mul(by) >> 8) as f32 / 16_777_216.0;
    let nm = |share: f32| range.min_nm as f32 + share * (range.max_nm - range.min_nm) as f32;
    (0..EVALUATIONS).map(|i| (scatter(i, 2_654_435_761), nm(scatter(i, 2_246_822_519)))).collect()
}

impl Model {
    /// Nanoseconds per evaluation, from one run over the inputs.
    fn time_ns(&self, lanes: &SpectralFilm, inputs: &[(f32, f32)]) -> f64 {
        match self {
            Self::Rgb(film) => time_ns(inputs, |mu, nm| film.split(Side::Outside, mu, nm)),
            Self::Lanes(4) => time_lanes_ns::<4>(lanes, inputs),
            Self::Lanes(8) => time_lanes_ns::<8>(lanes, inputs),
            Self::Lanes(_) => time_lanes_ns::<16>(lanes, inputs),
        }
    }
}

fn time_lanes_ns<const N: usize>(film: &SpectralFilm, inputs: &[(f32, f32)]) -> f64 {
    let waves = Spectral::<N>::waves(0.37).nm;
    time_ns(inputs, |mu, nm| film.split(Side::Outside, mu, nm, black_box(&waves)))
}

fn time_ns<T>(inputs: &[(f32, f32)], evaluate: impl Fn(f32, f32) -> T) -> f64 {
    let start = Instant::now();
    for &(mu, nm) in inputs {
        black_box(evaluate(mu, nm));
    }
    start.elapsed().as_secs_f64() * 1e9 / inputs.len() as f64
}

/// Exact colours over angle and thickness.
struct Truth {
    /// Cosine, thickness in nm, colour.
    points: Vec<(f32, f32, Lab)>,
}

impl Truth {
    fn new(coating: &Coating, range: Range, sensor: &Sensor) -> Self {
        use rayon::prelude::*;
        let count = if range.is_constant() { 1 } else { THICKNESSES };
        // Off the ends and off any regular grid of the tables.
        let share = |i: usize| if count == 1 { 0.0 } else { (i as f64 + 0.37) / count as f64 };
        let nm = |i: usize| range.min_nm + share(i) * (range.max_nm - range.min_nm);
        let places: Vec<(f64, f64)> = (0..count).flat_map(|i| ANGLES_DEG.map(|angle| (angle, nm(i)))).collect();
        let point = |(angle_deg, nm): (f64, f64)| {
            let colour = exact_colour(coating, angle_deg, nm, sensor).reflect;
            (angle_deg.to_radians().cos() as f32, nm as f32, Lab::from_linear_srgb(colour))
        };
        Self { points: places.into_par_iter().map(point).collect() }
    }

    fn errors_of_rgb(&self, film: &RgbFilm) -> Vec<f64> {
        self.errors(|mu, nm, _| film.split(Side::Outside, mu, nm).reflect.map(f64::from))
    }

    /// Of the mean over `paths` rotations of the wavelengths, spread evenly as the sampler of a pixel does.
    fn errors_of_lanes<const N: usize>(
        &self,
        film: &SpectralFilm,
        illuminant: &Emission,
        sensor: &Sensor,
        paths: u32,
    ) -> Vec<f64> {
        let light = Spectral::<N>::spectrum(illuminant, sensor);
        self.errors(|mu, nm, turn| {
            let mut sum = Vec3::ZERO;
            for path in 0..paths {
                let waves = Spectral::<N>::waves((turn + path as f32) / paths as f32);
                let reflect = Spectral::<N>::split(film, Side::Outside, mu, nm, &waves).reflect;
                let seen = Spectral::<N>::emitted(&light, Vec3::ONE, &waves) * reflect;
                sum += Spectral::<N>::to_rgb(seen, &waves, sensor);
            }
            (sum / paths as f32).to_array().map(f64::from)
        })
    }

    /// CIEDE2000 of `reflect(cosine, thickness, a number in 0..1 that differs from place to place)`.
    fn errors(&self, reflect: impl Fn(f32, f32, f32) -> [f64; 3]) -> Vec<f64> {
        let error = |(i, &(mu, nm, truth)): (usize, &(f32, f32, Lab))| {
            delta_e_2000(truth, Lab::from_linear_srgb(reflect(mu, nm, (i as f32 * GOLDEN as f32).fract())))
        };
        self.points.iter().enumerate().map(error).collect()
    }
}
