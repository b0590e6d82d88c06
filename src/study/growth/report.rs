//! Growth as table, CSV and chart.

use std::fmt::Write;

use super::series::{Kind, Series, Step};
use crate::output::Picture;
use crate::study::error::StudyError;
use crate::study::exponent::exponent;
use crate::study::log_chart::{Chart, Panel, Series as Line, Value};
use crate::study::number::ten_digits;

/// What is measured at every size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Quantity {
    Build,
    Sample,
    Memory,
    Noise,
    /// What a picture of a given noise costs: relMSE times time.
    Work,
}

pub struct GrowthChart {
    series: Vec<Series>,
}

impl Quantity {
    fn name(self) -> &'static str {
        match self {
            Self::Build => "build",
            Self::Sample => "time per sample",
            Self::Memory => "memory",
            Self::Noise => "noise",
            Self::Work => "noise x time",
        }
    }

    /// The head of a column.
    fn head(self) -> &'static str {
        match self {
            Self::Build => "build s",
            Self::Sample => "us/sample",
            Self::Memory => "MB",
            Self::Noise => "relMSE",
            Self::Work => "relMSE*us",
        }
    }

    fn of(self, kind: Kind, step: &Step) -> Option<f64> {
        let cost = &step.cost;
        match self {
            Self::Build => Some(cost.build_s),
            Self::Sample => Some(cost.sample_us),
            Self::Memory if kind == Kind::Pixels => Some(cost.render_mb),
            Self::Memory => Some(cost.build_mb),
            Self::Noise => cost.rel_mse,
            Self::Work => cost.rel_mse.map(|rel_mse| rel_mse * cost.sample_us),
        }
    }
}

impl Kind {
    fn quantities(self) -> &'static [Quantity] {
        match self {
            Self::Triangles => &[Quantity::Build, Quantity::Sample, Quantity::Memory],
            Self::Lights => &[Quantity::Build, Quantity::Sample, Quantity::Noise, Quantity::Work],
            Self::Pixels => &[Quantity::Sample, Quantity::Memory],
            Self::Bounces => &[Quantity::Sample],
            Self::Lanes => &[Quantity::Sample, Quantity::Noise, Quantity::Work],
        }
    }
}

impl Series {
    fn points(&self, quantity: Quantity, steps: &[Step]) -> Vec<(f64, f64)> {
        let point = |step: &Step| Some((step.size as f64, quantity.of(self.kind, step)?));
        steps.iter().filter_map(point).collect()
    }

    /// Exponents are those of one mode: RGB is another way to compute, not three wavelengths.
    fn fitted(&self) -> &[Step] {
        let from = self.steps.iter().position(|step| self.kind != Kind::Lanes || step.mode != "rgb");
        &self.steps[from.unwrap_or(0)..]
    }

    /// What costs a little at any size hides in small ones how large ones grow.
    fn larger(&self) -> &[Step] {
        let fitted = self.fitted();
        &fitted[fitted.len().saturating_sub(1) / 2..]
    }

    fn label(&self, step: &Step) -> String {
        if self.kind == Kind::Lanes { format!("{} {}", step.size, step.mode) } else { step.size.to_string() }
    }

    fn panel(&self) -> Panel {
        let mut panel = Panel {
            title: if self.kind == Kind::Lanes { "lanes (3: RGB)".to_owned() } else { self.kind.name().to_owned() },
            x_name: self.kind.name(),
            y_name: "times the first",
            series: Vec::new(),
            floor: None,
            linear: true,
            legend: Vec::new(),
            front: false,
        };
        for &quantity in self.kind.quantities() {
            let Some(&(_, first)) = self.points(quantity, &self.steps).first() else { continue };
            let name = quantity as usize;
            // No line joins RGB with the wavelengths.
            for steps in self.steps.chunk_by(|a, b| a.mode == b.mode) {
                let points = self.points(quantity, steps).into_iter();
                let points = points.map(|(x, y)| (Value::exact(x), Value::exact(y / first))).collect();
                panel.series.push(Line { name, points });
            }
            let power = |steps| exponent(&self.points(quantity, steps)).map_or("-".to_owned(), |p| format!("{p:.2}"));
            let (all, larger) = (power(self.fitted()), power(self.larger()));
            panel.legend.push((name, format!("{}: {all} ({larger})", quantity.name())));
        }
        panel
    }
}

impl GrowthChart {
    pub fn new(series: Vec<Series>) -> Self {
        Self { series }
    }

    /// One row per size.
    pub fn csv(&self) -> String {
        let mut csv =
            "series,mode,size,threads,build_s,build_wall_s,build_mb,us_per_sample,rays_per_sample,render_mb,relmse\n"
                .to_owned();
        for series in &self.series {
            for Step { mode, size, cost } in &series.steps {
                let built = [cost.build_s, cost.build_wall_s, cost.build_mb];
                let rendered = [cost.sample_us, cost.sample_rays, cost.render_mb];
                let numbers = built.into_iter().chain(rendered).map(ten_digits).collect::<Vec<_>>().join(",");
                let rel_mse = cost.rel_mse.map(ten_digits).unwrap_or_default();
                let (name, threads) = (series.kind.name(), cost.threads);
                // Writing to a String cannot fail.
                let _ = writeln!(csv, "{name},{mode},{size},{threads},{numbers},{rel_mse}");
            }
        }
        csv
    }

    /// The sizes of each series with what they cost, and the exponents.
    pub fn table(&self) -> String {
        let threads = self.series.iter().flat_map(|series| &series.steps).map(|step| step.cost.threads).max();
        let mut text = format!("s, us = processor seconds / {} threads\n", threads.unwrap_or(0));
        for series in &self.series {
            let quantities = series.kind.quantities();
            let _ = write!(text, "\n{:<16}", series.kind.name());
            for quantity in quantities {
                let _ = write!(text, " {:>10}", quantity.head());
            }
            text.push('\n');
            for step in &series.steps {
                let _ = write!(text, "{:<16}", series.label(step));
                for quantity in quantities {
                    let value = quantity.of(series.kind, step);
                    let _ = write!(text, " {:>10}", value.map_or("-".to_owned(), short));
                }
                text.push('\n');
            }
            for (name, steps) in [("exponent", series.fitted()), ("larger half", series.larger())] {
                let _ = write!(text, "{name:<16}");
                for quantity in quantities {
                    let power = exponent(&series.points(*quantity, steps));
                    let _ = write!(text, " {:>10}", power.map_or("-".to_owned(), |power| format!("{power:.2}")));
                }
                if let (Some(first), Some(last)) = (steps.first(), steps.last()) {
                    let _ = writeln!(text, "  over {}..{}", first.size, last.size);
                }
            }
        }
        text
    }

    /// # Errors
    /// What the drawing library says.
    pub fn draw(&self) -> Result<(String, Picture), StudyError> {
        let chart = Chart {
            title: "cost over size, with the exponent over all sizes (over the larger half), dashed: linear".to_owned(),
            columns: 3,
            names: Vec::new(),
            panels: self.series.iter().map(Series::panel).collect(),
        };
        Ok((chart.svg()?, chart.png()?))
    }
}

/// Three digits or more.
fn short(value: f64) -> String {
    if !(1e-4..1e6).contains(&value) {
        return format!("{value:.2e}");
    }
    let digits = (2.0 - value.log10().floor()).max(0.0) as usize;
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::growth::trial::Cost;

    /// Costs that follow powers, and noise that ends after the third size.
    fn measured(kind: Kind, sizes: &[u64]) -> Series {
        let step = |&size: &u64| {
            let n = size as f64;
            let mode = if kind == Kind::Lanes && size == 3 { "rgb" } else { "spectral" };
            let cost = Cost {
                threads: 2,
                build_s: 3e-5 * n,
                build_wall_s: 6e-5 * n,
                build_mb: 0.5 * n.powf(0.8),
                sample_us: if mode == "rgb" { 9.0 } else { 0.2 * n.sqrt() },
                sample_rays: 3.0,
                render_mb: n,
                rel_mse: Some(n.min(100.0)),
            };
            Step { mode: mode.to_owned(), size, cost }
        };
        Series { kind, steps: sizes.iter().map(step).collect() }
    }

    /// What stands in a table below the heads of a series.
    fn words(table: &str, series: &str, row: &str) -> Vec<String> {
        let mut lines = table.lines().skip_while(|line| !line.starts_with(series));
        let line = lines.find(|line| line.starts_with(row)).unwrap();
        line[row.len()..].split_whitespace().map(str::to_owned).collect()
    }

    #[test]
    fn exponents_stand_in_the_table_and_in_the_chart() {
        let lights = measured(Kind::Lights, &[1, 10, 100, 1000, 10_000]);
        let chart = GrowthChart::new(vec![lights, measured(Kind::Lanes, &[3, 4, 8, 16])]);
        let table = chart.table();
        // Noise of 1, 10, 100, 100, 100: 0, 1, 2, 2, 2 over 0..4 rises by 1/2.
        assert_eq!(words(&table, "lights", "exponent"), ["1.00", "0.50", "0.50", "1.00", "over", "1..10000"]);
        assert_eq!(words(&table, "lights", "larger half"), ["1.00", "0.50", "0.00", "0.50", "over", "100..10000"]);
        assert_eq!(words(&table, "lights", "100 "), ["0.00300", "2.00", "100", "200"]);
        // Three channels are no three wavelengths.
        assert_eq!(words(&table, "lanes", "exponent")[0], "0.50");
        assert_eq!(words(&table, "lanes", "exponent")[4], "4..16");
        assert_eq!(words(&table, "lanes", "3 rgb")[0], "9.00");
        let (svg, _) = chart.draw().unwrap();
        assert!(svg.contains("noise: 0.50 (0.00)") && svg.contains("build: 1.00 (1.00)"), "{svg}");
        assert_eq!(chart.csv().lines().nth(3).unwrap(), "lights,spectral,100,2,0.003,0.006,19.90535853,2,3,100,100");
    }

    #[test]
    fn a_single_size_has_no_exponent() {
        let chart = GrowthChart::new(vec![measured(Kind::Bounces, &[4])]);
        assert_eq!(words(&chart.table(), "bounces", "exponent")[0], "-");
        assert!(chart.draw().unwrap().0.contains("time per sample: - (-)"));
    }

    #[test]
    fn numbers_are_short() {
        let texts = [8.8e-5, 0.000_357, 0.353, 1.379, 21.44, 1412.3, 9.9e6].map(short);
        assert_eq!(texts, ["8.80e-5", "0.000357", "0.353", "1.38", "21.4", "1412", "9.90e6"]);
    }
}
