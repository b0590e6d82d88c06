//! The colour of a stack by every RGB model, beside the exact one.

use std::fmt::Write;

use rayon::prelude::*;

use crate::color::{Lab, MAX_NM, MIN_NM, Sensor, delta_e_2000};
use crate::film::{Range, RgbFilm, Rung, Side, Split, choose, exact};

use super::coating::Coating;
use super::number::ten_digits;

/// R and T as linear sRGB (unclamped; a flat reflector is 1, 1, 1) at one angle and thickness.
#[derive(Clone, Debug)]
pub struct ColourRow {
    /// `exact`, or the name of a rung.
    pub rung: &'static str,
    pub angle_deg: f64,
    pub thickness_nm: f64,
    pub split: Split<[f64; 3]>,
    /// CIEDE2000 of R, as a surface colour, against the exact row.
    pub delta_e: f64,
}

/// Rungs in the order in which they are shown.
const SHOWN: [Rung; 4] = [Rung::Bare, Rung::Table, Rung::ThreeWave, Rung::Gaussian];

/// One row per rung, angle and thickness, the exact ones first, and the rungs that do not apply, each with the reason.
///
/// The film of a rung is built for `whole` (a thickness that varies over a surface) where it is given, else for each
/// thickness alone, as rendering would.
pub fn colour_rows(
    coating: &Coating,
    angles_deg: &[f64],
    thicknesses_nm: &[f64],
    whole: Option<Range>,
    sensor: &Sensor,
) -> (Vec<ColourRow>, Vec<(Rung, &'static str)>) {
    let pairs: Vec<(f64, f64)> =
        angles_deg.iter().flat_map(|&angle| thicknesses_nm.iter().map(move |&nm| (angle, nm))).collect();
    let mut rows: Vec<ColourRow> = pairs
        .into_par_iter()
        .map(|(angle_deg, thickness_nm)| {
            let split = exact_colour(coating, angle_deg, thickness_nm, sensor);
            ColourRow { rung: "exact", angle_deg, thickness_nm, split, delta_e: 0.0 }
        })
        .collect();

    let truth = rows.clone();
    let mut not_offered = Vec::new();
    for rung in SHOWN {
        let ranges: Vec<Range> = match whole {
            Some(range) => vec![range],
            None => thicknesses_nm.iter().map(|&nm| Range::constant(nm)).collect(),
        };
        let films: Result<Vec<RgbFilm>, &'static str> =
            ranges.iter().map(|&range| build(coating, rung, range, sensor)).collect();
        let films = match films {
            Ok(films) => films,
            Err(reason) => {
                not_offered.push((rung, reason));
                continue;
            }
        };
        for (i, row) in truth.iter().enumerate() {
            // Thicknesses change fastest; the one film of a whole range serves all of them.
            let film = &films[i % thicknesses_nm.len() % films.len()];
            let mu = row.angle_deg.to_radians().cos() as f32;
            let got = film.split(Side::Outside, mu, row.thickness_nm as f32);
            let split = Split { reflect: got.reflect.map(f64::from), transmit: got.transmit.map(f64::from) };
            let [seen, truth] = [split.reflect, row.split.reflect].map(Lab::from_linear_srgb);
            rows.push(ColourRow { rung: rung.name(), split, delta_e: delta_e_2000(truth, seen), ..row.clone() });
        }
    }
    (rows, not_offered)
}

/// The table of [`colour_rows`].
pub fn colour_csv(rows: &[ColourRow]) -> String {
    let mut csv = "rung,theta_deg,thickness,R_lin_r,R_lin_g,R_lin_b,T_lin_r,T_lin_g,T_lin_b,delta_e\n".to_owned();
    for row in rows {
        let place = [row.angle_deg, row.thickness_nm];
        let numbers = place.iter().chain(&row.split.reflect).chain(&row.split.transmit).chain([&row.delta_e]);
        let fields: Vec<String> = numbers.map(|&number| ten_digits(number)).collect();
        // Writing to a String cannot fail.
        let _ = writeln!(csv, "{},{}", row.rung, fields.join(","));
    }
    csv
}

/// The integral at 1 nm over 380..780 nm: good for layers of up to about 12 um of optical thickness.
pub(super) fn exact_colour(coating: &Coating, angle_deg: f64, thickness_nm: f64, sensor: &Sensor) -> Split<[f64; 3]> {
    let cos_i = angle_deg.to_radians().cos();
    let steps = (MAX_NM - MIN_NM) as usize;
    let at = |step: usize| exact(&coating.stack, Side::Outside, cos_i, thickness_nm, MIN_NM + step as f64).mean();
    let spectrum: Vec<Split<f64>> = (0..=steps).map(at).collect();
    let sample = |nm: f64| spectrum[(nm - MIN_NM) as usize];
    Split {
        reflect: sensor.rgb_of_reflectance(|nm| sample(nm).reflect),
        transmit: sensor.rgb_of_reflectance(|nm| sample(nm).transmit),
    }
}

fn build(coating: &Coating, rung: Rung, range: Range, sensor: &Sensor) -> Result<RgbFilm, &'static str> {
    let (film, verdict) = choose(&coating.stack, range, sensor, f64::INFINITY, Some(rung));
    match verdict.not_offered.iter().find(|(refused, _)| *refused == rung) {
        Some((_, reason)) => Err(reason),
        None => Ok(film),
    }
}
