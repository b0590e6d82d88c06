//! What a contest found: table, CSV, chart.

use std::fmt::Write;

use super::contest::{Contest, Row};
use super::reference::Reference;
use crate::output::Picture;
use crate::study::error::StudyError;
use crate::study::exponent::exponent;
use crate::study::log_chart::{Chart, Panel, Series, Value};
use crate::study::metrics::{Spread, delta_e_map};
use crate::study::number::ten_digits;

/// A reference is converged enough where what is measured is at least this many times its own error.
const CONVERGED: f64 = 4.0;

/// The seconds on the axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// CPU seconds over threads: what a quiet machine would show. Wall seconds where they are all that is known.
    Cpu,
    Wall,
}

pub struct Report<'a> {
    pub contest: &'a Contest<'a>,
    pub rows: &'a [Row],
    pub clock: Clock,
}

/// A contender at one number of samples: means over its repeats.
struct Step {
    spp: u32,
    seconds: Value,
    noise_mse: Option<Value>,
    noise_rel_mse: Option<f64>,
    rel_mse: Value,
    delta_e: Value,
    flip: Value,
}

impl Report<'_> {
    fn seconds(&self, row: &Row) -> f64 {
        match (self.clock, row.cpu_s) {
            (Clock::Cpu, Some(cpu_s)) => cpu_s / row.threads as f64,
            _ => row.wall_s,
        }
    }

    /// In the order of samples, then (of series) of seconds.
    fn steps(&self, contender: usize) -> Vec<Step> {
        let mut mine: Vec<&Row> = self.rows.iter().filter(|row| row.contender == contender).collect();
        mine.sort_by(|a, b| a.spp.cmp(&b.spp).then(a.wall_s.total_cmp(&b.wall_s)));
        let alike = |a: &&Row, b: &&Row| a.spp == b.spp && a.spp > 0;
        let step = |rows: &[&Row]| Step {
            spp: rows[0].spp,
            seconds: mean(rows, |row| self.seconds(row)),
            noise_mse: rows[0].noise.map(|_| mean(rows, |row| row.noise.map_or(0.0, |noise| noise.mse))),
            noise_rel_mse: rows[0].noise.map(|_| mean(rows, |row| row.noise.map_or(0.0, |noise| noise.rel_mse)).at),
            rel_mse: mean(rows, |row| row.colour.rel_mse),
            delta_e: mean(rows, |row| row.delta_e),
            flip: mean(rows, |row| row.flip),
        };
        mine.chunk_by(alike).map(step).collect()
    }

    /// One row per picture. Errors of noise are against the reference of the own mean, named beside them, all others against
    /// the first reference.
    pub fn csv(&self) -> String {
        let mut csv =
            "config,repeat,spp,wall_s,cpu_s,threads,noise_reference,noise_mse,noise_relmse,noise_relmse_trimmed,\
                       reference,mse,relmse,relmse_trimmed,ciede2000_mean,flip_mean\n"
                .to_owned();
        let reference = self.contest.references.first().map_or("", |(_, reference)| &reference.label);
        for row in self.rows {
            let contender = &self.contest.contenders[row.contender];
            let label = contender.mean.as_ref().map(|mean| mean.label()).unwrap_or_default();
            let noise = match row.noise {
                Some(noise) => [noise.mse, noise.rel_mse, noise.trimmed_rel_mse].map(ten_digits).join(","),
                None => ",,".to_owned(),
            };
            let cpu_s = row.cpu_s.map(ten_digits).unwrap_or_default();
            let wall_s = ten_digits(row.wall_s);
            let colour = row.colour;
            let errors = [colour.mse, colour.rel_mse, colour.trimmed_rel_mse, row.delta_e, row.flip].map(ten_digits);
            // Writing to a String cannot fail.
            let _ = writeln!(
                csv,
                "\"{}\",{},{},{wall_s},{cpu_s},{},{label},{noise},{reference},{}",
                contender.name,
                row.repeat,
                row.spp,
                row.threads,
                errors.join(",")
            );
        }
        csv
    }

    /// How far another mean is from the first reference: what its colour model gets wrong, and what is left of the noise of
    /// both, most of which their common seeds cancel.
    fn colour_of(&self, reference: &Reference) -> String {
        let Some((_, first)) = self.contest.references.first() else { return String::new() };
        let [shown, wanted] = [&reference.image, &first.image].map(|image| self.contest.exposure.show(image));
        let Spread { mean, p99, max } = Spread::of(&delta_e_map(&shown, &wanted));
        format!("against {}: dE mean {mean:.3}, 99 % within {p99:.2}, worst {max:.2}", first.label)
    }

    /// One line per contender at its most samples, and the references with their own errors.
    pub fn table(&self) -> String {
        let mut text = String::new();
        let [width, height] = self.contest.setting.camera.size;
        let seconds = if self.clock == Clock::Cpu { "CPU seconds / threads" } else { "wall seconds" };
        let _ = writeln!(text, "{width}x{height}, {} repeats, s = {seconds}", self.contest.repeats);
        for (i, (_, reference)) in self.contest.references.iter().enumerate() {
            let _ = writeln!(text, "reference {}", described(reference));
            if i > 0 {
                let _ = writeln!(text, "  {}", self.colour_of(reference));
            }
        }
        let colour = self.contest.references.first().map_or("", |(_, reference)| &reference.label);
        let width = self.contest.contenders.iter().map(|c| c.name.chars().count()).max().unwrap_or(0).max(13);
        let _ = writeln!(
            text,
            "\n{:width$}  {:>6} {:>8}  {:<16} {:>9} {:>9} {:>10} {:>6} {:>6}  {:>9} {:>7} {:>7}",
            "", "", "", "noise against", "", "", "", "", "", "relMSE", "dE", "FLIP"
        );
        let _ = writeln!(
            text,
            "{:width$}  {:>6} {:>8}  {:<16} {:>9} {:>9} {:>10} {:>6} {:>6}  against {colour}",
            "configuration", "spp", "s", "reference", "MSE", "relMSE", "1/(MSE s)", "ratio", "slope"
        );
        let last: Vec<Option<Step>> = (0..self.contest.contenders.len()).map(|i| self.steps(i).pop()).collect();
        let efficiency = |step: &Step| step.noise_mse.map(|mse| 1.0 / (mse.at * step.seconds.at));
        let first = last.iter().flatten().find_map(efficiency).unwrap_or(1.0);
        for (i, (contender, step)) in self.contest.contenders.iter().zip(&last).enumerate() {
            let Some(step) = step else { continue };
            let (name, spp, s) = (&contender.name, step.spp, step.seconds.at);
            let _ = write!(text, "{name:width$}  {spp:>6} {s:>8.3}  ");
            match (&contender.mean, step.noise_mse, step.noise_rel_mse, efficiency(step)) {
                (Some(mean), Some(mse), Some(rel_mse), Some(efficiency)) => {
                    let (label, mse, ratio) = (mean.label(), mse.at, efficiency / first);
                    let slope = self.slope(i).map_or("-".to_owned(), |slope| format!("{slope:.2}"));
                    let _ = write!(
                        text,
                        "{label:<16} {mse:>9.2e} {rel_mse:>9.2e} {efficiency:>10.3e} {ratio:>6.2} {slope:>6}"
                    );
                }
                _ => {
                    let _ = write!(text, "{:<16} {:>9} {:>9} {:>10} {:>6} {:>6}", "-", "-", "-", "-", "-", "-");
                }
            }
            let _ = writeln!(text, "  {:>9.2e} {:>7.3} {:>7.4}", step.rel_mse.at, step.delta_e.at, step.flip.at);
        }
        text
    }

    /// The exponent of error over seconds: -1 for independent samples.
    fn slope(&self, contender: usize) -> Option<f64> {
        let points: Vec<(f64, f64)> =
            self.steps(contender).iter().filter_map(|step| Some((step.seconds.at, step.noise_mse?.at))).collect();
        exponent(&points)
    }

    /// Names of the contenders whose error comes near that of the reference they are measured against.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        for (i, contender) in self.contest.contenders.iter().enumerate() {
            let Some(mean) = &contender.mean else { continue };
            let Some((_, reference)) = self.contest.references.iter().find(|(other, _)| other == mean) else {
                continue;
            };
            let (Some(squared), Some(step)) = (reference.squared, self.steps(i).pop()) else { continue };
            if step.noise_mse.is_some_and(|mse| mse.at < CONVERGED * squared.mse) {
                let (name, spp, label) = (&contender.name, step.spp, &reference.label);
                warnings.push(format!(
                    "{name} at {spp} spp comes within {CONVERGED} times the error of reference {label}; raise --reference-spp"
                ));
            }
        }
        warnings
    }

    /// # Errors
    /// What the drawing library says.
    pub fn draw(&self, title: &str) -> Result<(String, Picture), StudyError> {
        let x_name = if self.clock == Clock::Cpu { "CPU seconds / threads" } else { "seconds" };
        let steps: Vec<Vec<Step>> = (0..self.contest.contenders.len()).map(|i| self.steps(i)).collect();
        let panel = |title: String, y_name, floor: Option<f64>, value: fn(&Step) -> Option<Value>| Panel {
            title,
            x_name,
            y_name,
            series: steps
                .iter()
                .enumerate()
                .map(|(name, steps)| Series {
                    name,
                    points: steps.iter().filter_map(|step| Some((step.seconds, value(step)?))).collect(),
                })
                .collect(),
            floor,
            linear: false,
            legend: Vec::new(),
            front: false,
        };
        let references = &self.contest.references;
        let own = references.iter().filter_map(|(_, reference)| Some(reference.squared?.mse)).fold(0.0, f64::max);
        let first = references.first().map(|(_, reference)| reference);
        let (label, squared) = first.map_or(("", None), |reference| (reference.label.as_str(), reference.squared));
        let seen = first.and_then(|reference| reference.seen);
        let against = |what: &str| format!("{what}, against {label}");
        let chart = Chart {
            title: title.to_owned(),
            columns: 2,
            names: self.contest.contenders.iter().map(|contender| contender.name.clone()).collect(),
            panels: vec![
                panel("noise: MSE, against own mode".to_owned(), "MSE", Some(own), |step| step.noise_mse),
                panel(against("relMSE"), "relMSE", squared.map(|errors| errors.rel_mse), |step| Some(step.rel_mse)),
                panel(against("mean CIEDE2000"), "CIEDE2000", seen.map(|seen| seen[0]), |step| Some(step.delta_e)),
                panel(against("mean FLIP"), "FLIP", seen.map(|seen| seen[1]), |step| Some(step.flip)),
            ],
        };
        Ok((chart.svg()?, chart.png()?))
    }
}

fn described(reference: &Reference) -> String {
    let Reference { label, spp, squared, seen, cached, .. } = reference;
    let samples = if *spp > 0 { format!("{spp} spp") } else { "as given".to_owned() };
    let from = if *cached { ", from the cache" } else { "" };
    let mut text = format!("{label}: {samples}{from}; its own error: ");
    match squared {
        Some(errors) => {
            let _ = write!(text, "MSE {:.1e}, relMSE {:.1e}", errors.mse, errors.rel_mse);
        }
        None => text.push_str("not known (no variance layers)"),
    }
    if let Some([delta_e, flip]) = seen {
        let _ = write!(text, ", dE {delta_e:.3}, FLIP {flip:.4}");
    }
    text
}

fn mean(rows: &[&Row], value: impl Fn(&Row) -> f64) -> Value {
    Value::mean_of(&rows.iter().map(|row| value(row)).collect::<Vec<_>>())
}
