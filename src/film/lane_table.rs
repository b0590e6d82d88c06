//! Properties of a film per wavelength, tabulated at load.
//!
//! For one layer they depend on thickness and wavelength through their ratio, apart from dispersion, so the table runs over
//! wavelength (slowly varying) and thickness / wavelength (the fringes). A stack with one varying layer has no such scaling
//! and runs over wavelength and thickness. A constant thickness needs wavelength alone.

use rayon::prelude::*;

use crate::color::{MAX_NM, MIN_NM};

use super::lanes::cell;
use super::spectral::{Gathered, SpectralFilm};
use super::stack::{Range, Stack};

/// W numbers over wavelength x thickness coordinate, interpolated linearly.
#[derive(Clone, Debug, Default)]
pub(super) struct LaneTable<const W: usize> {
    /// Row-major: one row of `columns` per wavelength.
    cells: Vec<[f32; W]>,
    rows: usize,
    columns: usize,
    per_step: f32,
    /// The second coordinate is thickness / wavelength instead of thickness.
    scaled: bool,
    first: f32,
    per_cell: f32,
}

/// Samples per fringe of the second coordinate; the hemisphere has already smoothed it.
const PER_FRINGE: f64 = 16.0;
const MAX_COLUMNS: f64 = 1024.0;
/// Wavelengths that are evaluated together.
pub(super) const WIDTH: usize = 8;

impl<const W: usize> LaneTable<W> {
    /// `values(media, depths)` gives, for each of `depths`, the values of the wavelengths of `media`; a depth is the varying
    /// layer's thickness / wavelength of each.
    pub(super) fn new(
        stack: &Stack,
        film: &SpectralFilm,
        range: Range,
        values: impl Fn(&Gathered<WIDTH>, &[[f32; WIDTH]]) -> Vec<[[f32; W]; WIDTH]> + Sync,
    ) -> Self {
        let varying = stack.varying.filter(|_| !range.is_constant());
        let scaled = varying.is_some() && stack.layers.len() == 1;
        let step_nm = match (varying, scaled) {
            (None, _) => 1.0,
            (Some(_), true) => 10.0,
            (Some(_), false) => 5.0,
        };
        let (first, last) =
            if scaled { (range.min_nm / MAX_NM, range.max_nm / MIN_NM) } else { (range.min_nm, range.max_nm) };
        let intervals = varying.map_or(0.0, |layer| {
            let n = stack.layers[layer].index.range_of_n().1.max(0.1);
            let fringe = 0.5 / n * if scaled { 1.0 } else { MIN_NM };
            ((last - first) / fringe * PER_FRINGE).ceil().clamp(1.0, MAX_COLUMNS)
        });
        let (rows, columns) = (((MAX_NM - MIN_NM) / step_nm) as usize + 1, intervals as usize + 1);
        let per_cell = if columns > 1 { (last - first) / intervals } else { 1.0 };

        let block = |block: usize| {
            let media = film.gather(&std::array::from_fn(|i| (MIN_NM + step_nm * (block * WIDTH + i) as f64) as f32));
            let depths: Vec<[f32; WIDTH]> = (0..columns)
                .map(|column| {
                    let coordinate = (first + per_cell * column as f64) as f32;
                    media.nm().map(|nm| if scaled { coordinate } else { coordinate / nm })
                })
                .collect();
            let values = values(&media, &depths);
            (0..WIDTH.min(rows - block * WIDTH))
                .flat_map(|i| values.iter().map(move |lanes| lanes[i]).collect::<Vec<_>>())
                .collect::<Vec<_>>()
        };
        let blocks: Vec<Vec<[f32; W]>> = (0..rows.div_ceil(WIDTH)).into_par_iter().map(block).collect();
        let (per_step, per_cell) = ((1.0 / step_nm) as f32, (1.0 / per_cell) as f32);
        Self { cells: blocks.concat(), rows, columns, per_step, scaled, first: first as f32, per_cell }
    }

    #[inline]
    pub(super) fn lanes<const N: usize>(&self, thickness_nm: f32, nm: &[f32; N]) -> [[f32; W]; N] {
        const fn zero<const W: usize>() -> [f32; W] {
            [0.0; W]
        }
        nm.map(|nm| {
            let (row, s) = cell((nm - MIN_NM as f32) * self.per_step, (self.rows - 1) as f32);
            let value = |place: usize| self.cells.get(place).copied().unwrap_or(zero());
            let mix = |a: [f32; W], b: [f32; W], t: f32| std::array::from_fn(|i| a[i] + t * (b[i] - a[i]));
            if self.columns == 1 {
                return mix(value(row as usize), value(row as usize + 1), s);
            }
            let coordinate = if self.scaled { thickness_nm / nm } else { thickness_nm };
            let (column, t) = cell((coordinate - self.first) * self.per_cell, (self.columns - 1) as f32);
            let place = row as usize * self.columns + column as usize;
            let along = |place: usize| mix(value(place), value(place + 1), t);
            mix(along(place), along(place + self.columns), s)
        })
    }
}
