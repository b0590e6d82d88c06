//! The ladder: the cheapest RGB rung whose measured error is within the tolerance.

use std::fmt;
use std::time::Instant;

use rayon::prelude::*;
use serde::Serialize;

use crate::color::{Lab, Sensor, delta_e_2000};

use super::bare::Bare;
use super::exact::exact;
use super::gaussian::Gaussian;
use super::quadrature::{ONE_NM, Spectral, nodes};
use super::rgb::{Form, RgbFilm};
use super::stack::{Range, Side, Stack};
use super::table::Table;
use super::three_wave::ThreeWave;

/// The RGB models, in the order in which they are tried.
///
/// The order is that of cost per evaluation on one core, measured once and written down here so that every machine chooses
/// alike (`pellicle chart films`): bare 5 ns, table 6-13 ns, three-wave
/// 20-125 ns, gaussian 160-520 ns. The table is both cheaper and more exact than the analytic rungs, at the price of memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rung {
    /// No interference: Fresnel's equations for the base.
    Bare,
    /// Exact spectral integral, tabulated.
    Table,
    /// One wavelength per channel.
    ThreeWave,
    /// Belcour and Barla 2017.
    Gaussian,
}

impl Rung {
    pub const ALL: [Self; 4] = [Self::Bare, Self::Table, Self::ThreeWave, Self::Gaussian];

    pub fn name(self) -> &'static str {
        match self {
            Self::Bare => "bare",
            Self::Table => "table",
            Self::ThreeWave => "three-wave",
            Self::Gaussian => "gaussian",
        }
    }
}

impl fmt::Display for Rung {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.pad(self.name())
    }
}

/// One rung measured against `exact`.
#[derive(Clone, Debug, Serialize)]
pub struct Trial {
    pub rung: Rung,
    /// CIEDE2000 of the reflectance as a surface colour, over angle and thickness.
    pub mean_delta_e: f64,
    pub worst_delta_e: f64,
    pub table_bytes: usize,
    pub build_seconds: f64,
}

/// What the ladder tried and why it chose what it chose.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    pub chosen: Rung,
    pub reason: String,
    /// CIEDE2000.
    pub tolerance: f64,
    pub tried: Vec<Trial>,
    /// Rungs that do not apply to this stack, each with the reason.
    pub not_offered: Vec<(Rung, &'static str)>,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}: {}", self.chosen, self.reason)?;
        for trial in &self.tried {
            write!(f, "; {} dE mean {:.3} worst {:.3}", trial.rung, trial.mean_delta_e, trial.worst_delta_e)?;
            if trial.table_bytes > 0 {
                write!(f, ", {:.1} kB", trial.table_bytes as f64 / 1024.0)?;
            }
            write!(f, ", {:.1} ms", 1e3 * trial.build_seconds)?;
        }
        Ok(())
    }
}

/// Angles of the measurement, degrees. Even steps to where surfaces are still seen rather than glimpsed.
const ANGLES_DEG: [f64; 6] = [0.0, 25.0, 45.0, 60.0, 75.0, 85.0];
/// Thicknesses of the measurement where they vary.
const THICKNESSES: usize = 5;

/// Builds the cheapest RGB rung whose worst measured error over angle and thickness is within `tolerance` (CIEDE2000), or
/// the one that is `forced`. Where no rung is within the tolerance, the one with the least error is taken, and the verdict
/// says so; where the forced rung does not apply, the ladder goes on as if nothing were forced, and says so.
pub fn choose(
    stack: &Stack,
    range: Range,
    sensor: &Sensor,
    tolerance: f64,
    forced: Option<Rung>,
) -> (RgbFilm, Verdict) {
    let range = range.of(stack);
    let truth = Truth::new(stack, range, sensor);
    let mut verdict =
        Verdict { chosen: Rung::Table, reason: String::new(), tolerance, tried: Vec::new(), not_offered: Vec::new() };
    let mut best: Option<(RgbFilm, f64)> = None;
    let order = forced.into_iter().chain(Rung::ALL.into_iter().filter(|&rung| Some(rung) != forced));
    for rung in order {
        let start = Instant::now();
        let film = match build(rung, stack, range, sensor) {
            Ok(film) => film,
            Err(reason) => {
                verdict.not_offered.push((rung, reason));
                continue;
            }
        };
        let build_seconds = start.elapsed().as_secs_f64();
        let (mean_delta_e, worst_delta_e) = truth.error(&film);
        let table_bytes = match &film.0 {
            Form::Table(table) => table.bytes(),
            _ => 0,
        };
        verdict.tried.push(Trial { rung, mean_delta_e, worst_delta_e, table_bytes, build_seconds });
        let within = worst_delta_e <= tolerance;
        if Some(rung) == forced || within {
            verdict.chosen = rung;
            verdict.reason = if Some(rung) == forced {
                "forced".to_owned()
            } else {
                match verdict.not_offered.iter().find(|(rung, _)| Some(*rung) == forced) {
                    Some((forced, why)) => format!("{forced} was asked for but {why}"),
                    None => format!("cheapest within {tolerance}"),
                }
            };
            return (film, verdict);
        }
        if best.as_ref().is_none_or(|(_, least)| worst_delta_e < *least) {
            best = Some((film, worst_delta_e));
        }
    }
    // The table applies to every stack, so there always is a best.
    let (film, worst) = best.unwrap_or_else(|| (RgbFilm(Form::Table(Table::new(stack, range, sensor))), f64::INFINITY));
    verdict.chosen = film.rung();
    verdict.reason = format!("none is within {tolerance}, the least worst error is {worst:.2}");
    (film, verdict)
}

fn build(rung: Rung, stack: &Stack, range: Range, sensor: &Sensor) -> Result<RgbFilm, &'static str> {
    match rung {
        Rung::Bare => Bare::new(stack)
            .map(|bare| RgbFilm(Form::Bare(bare)))
            .ok_or("a medium absorbs, which makes a bare surface coloured"),
        Rung::Table => Ok(RgbFilm(Form::Table(Table::new(stack, range, sensor)))),
        Rung::ThreeWave => Ok(RgbFilm(Form::ThreeWave(Box::new(ThreeWave::new(stack, range))))),
        Rung::Gaussian => Gaussian::new(stack, range, sensor).map(|film| RgbFilm(Form::Gaussian(Box::new(film)))),
    }
}

/// Exact colours over angle and thickness.
struct Truth {
    points: Vec<(f64, f64, Lab)>,
}

impl Truth {
    fn new(stack: &Stack, range: Range, sensor: &Sensor) -> Self {
        let count = if range.is_constant() { 1 } else { THICKNESSES };
        let thickness = |i: usize| {
            // Off the ends and off any regular grid of the tables; the thinnest is where the models differ most.
            let share = if count == 1 { 0.0 } else { ((i as f64 + 0.37) / count as f64).min(1.0) };
            range.min_nm + share * (range.max_nm - range.min_nm)
        };
        let grid: Vec<(f64, f64)> =
            (0..count).flat_map(|i| ANGLES_DEG.map(|degrees| (degrees.to_radians().cos(), thickness(i)))).collect();
        let points = grid
            .into_par_iter()
            .map(|(mu, nm)| {
                // At least every 1 nm, and finer where fringes are narrower than that.
                let rule = nodes(sensor, Spectral::count(stack, nm).max(ONE_NM));
                let rgb = rule.iter().fold([0.0; 3], |sum: [f64; 3], (lambda, weights)| {
                    let reflect = exact(stack, Side::Outside, mu, nm, *lambda).mean().reflect;
                    std::array::from_fn(|c| sum[c] + weights[c] * reflect)
                });
                (mu, nm, Lab::from_linear_srgb(rgb))
            })
            .collect();
        Self { points }
    }

    /// (mean, worst) CIEDE2000.
    fn error(&self, film: &RgbFilm) -> (f64, f64) {
        let (mut sum, mut worst) = (0.0, 0.0f64);
        for &(mu, nm, truth) in &self.points {
            let reflect = film.split(Side::Outside, mu as f32, nm as f32).reflect.map(f64::from);
            let error = delta_e_2000(truth, Lab::from_linear_srgb(reflect));
            sum += error;
            worst = worst.max(error);
        }
        (sum / self.points.len() as f64, worst)
    }
}
