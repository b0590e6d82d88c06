//! The chart of film models: error over time per evaluation.

use std::fmt::Write;

use crate::film::Range;
use crate::output::Picture;

use super::coating::Coating;
use super::error::StudyError;
use super::film_cost::{FilmCost, PATHS};
use super::log_chart::{Chart, Panel, Series, Value, pareto_front};
use super::medium::Medium;
use super::metrics::Spread;
use super::number::ten_digits;

/// Errors below this are drawn here: nobody sees them, and the axis stays readable.
const LEAST_SHOWN: f64 = 1e-3;

/// Models over all stacks that they apply to.
pub struct FilmChart {
    costs: Vec<FilmCost>,
}

/// One model over all its stacks.
struct Pooled {
    model: String,
    paths: u32,
    stacks: usize,
    ns: Value,
    error: Spread,
}

/// Stacks that stand for what films are used for, each with a thickness that varies and with a constant one.
///
/// # Errors
/// Never for the tables that the program carries.
pub fn typical_coatings() -> Result<Vec<(Coating, Range)>, StudyError> {
    let air = Medium::parse("air")?;
    let mut coatings = Vec::new();
    for (film, base, most_nm) in [
        ("1.33", "air", 1200.0),
        ("soap", "BK7", 1200.0),
        ("2.4", "Au", 500.0),
        ("TiO2", "Ti", 300.0),
        ("Fe3O4", "Fe", 200.0),
        ("1.6+0.3i", "1.5", 500.0),
    ] {
        let (film, base) = (Medium::parse(film)?, Medium::parse(base)?);
        for nm in [0.0..most_nm, 0.5 * most_nm..0.5 * most_nm] {
            let range = Range { min_nm: nm.start, max_nm: nm.end };
            let mut coating = Coating::new(&air, &[(film.clone(), nm.end)], &base);
            if range.is_constant() {
                coating.stack.varying = None;
            }
            coating.label = format!("{} {}..{} nm", coating.label, nm.start, nm.end);
            coatings.push((coating, range));
        }
    }
    Ok(coatings)
}

impl FilmChart {
    pub fn new(costs: Vec<FilmCost>) -> Self {
        Self { costs }
    }

    /// One row per stack and model.
    pub fn csv(&self) -> String {
        let mut csv =
            "stack,model,paths,ns_q1,ns_median,ns_q3,de_mean,de_p99,de_worst,table_bytes,build_ms\n".to_owned();
        for cost in &self.costs {
            let Spread { mean, p99, max } = cost.spread();
            let numbers = cost.ns.iter().chain([&mean, &p99, &max]).map(|&number| ten_digits(number));
            let numbers = numbers.collect::<Vec<_>>().join(",");
            let (bytes, build_ms) = (cost.table_bytes, ten_digits(1e3 * cost.build_s));
            // Writing to a String cannot fail.
            let _ = writeln!(csv, "\"{}\",{},{},{numbers},{bytes},{build_ms}", cost.stack, cost.model, cost.paths);
        }
        csv
    }

    /// One line per model over all stacks, with a star where nothing is both faster and better in the mean.
    pub fn table(&self) -> String {
        let pooled = self.pooled();
        let places: Vec<(f64, f64)> = pooled.iter().map(|model| (model.ns.at, model.error.mean)).collect();
        let front = pareto_front(&places);
        let mut text = format!(
            "  {:<26} {:>6} {:>8} {:>9} {:>9} {:>9}\n",
            "model", "stacks", "ns", "dE mean", "dE p99", "dE worst"
        );
        for (model, place) in pooled.iter().zip(&places) {
            let star = if front.contains(place) { '*' } else { ' ' };
            let (Spread { mean, p99, max }, name) = (model.error, model.name());
            let (ns, stacks) = (model.ns.at, model.stacks);
            let _ = writeln!(text, "{star} {name:<26} {stacks:>6} {ns:>8.1} {mean:>9.4} {p99:>9.4} {max:>9.4}");
        }
        text.push_str("* no other model is both faster and better in the mean\n");
        text
    }

    /// # Errors
    /// What the drawing library says.
    pub fn draw(&self, title: &str) -> Result<(String, Picture), StudyError> {
        let pooled = self.pooled();
        let panel = |title: &str, error: fn(&Spread) -> f64| Panel {
            title: title.to_owned(),
            x_name: "ns per evaluation",
            y_name: "CIEDE2000",
            series: pooled
                .iter()
                .enumerate()
                .map(|(name, model)| {
                    let shown = error(&model.error).max(LEAST_SHOWN);
                    Series { name, points: vec![(model.ns, Value::exact(shown))] }
                })
                .collect(),
            floor: None,
            linear: false,
            legend: Vec::new(),
            front: true,
        };
        let chart = Chart {
            title: title.to_owned(),
            columns: 3,
            names: pooled.iter().map(Pooled::name).collect(),
            panels: vec![
                panel("mean error", |error| error.mean),
                panel("99th percentile", |error| error.p99),
                panel("worst error", |error| error.max),
            ],
        };
        Ok((chart.svg()?, chart.png()?))
    }

    /// In the order in which models first appear. Times are means over the stacks; their ends are the fastest and the
    /// slowest stack.
    fn pooled(&self) -> Vec<Pooled> {
        let mut models: Vec<(&str, u32)> = Vec::new();
        for cost in &self.costs {
            if !models.contains(&(&cost.model, cost.paths)) {
                models.push((&cost.model, cost.paths));
            }
        }
        let pool = |(model, paths): (&str, u32)| {
            let mine: Vec<&FilmCost> =
                self.costs.iter().filter(|cost| cost.model == model && cost.paths == paths).collect();
            let errors: Vec<f64> = mine.iter().flat_map(|cost| cost.errors.iter().copied()).collect();
            let ns: Vec<f64> = mine.iter().map(|cost| cost.ns[1]).collect();
            Pooled {
                model: model.to_owned(),
                paths,
                stacks: mine.len(),
                ns: Value::mean_of(&ns),
                error: Spread::of(&errors),
            }
        };
        models.into_iter().map(pool).collect()
    }
}

impl Pooled {
    fn name(&self) -> String {
        match self.paths {
            0 => self.model.clone(),
            1 => format!("{}, 1 path", self.model),
            PATHS => format!("{}, {PATHS} paths", self.model),
            paths => format!("{}, {paths} paths", self.model),
        }
    }
}
