//! Average Fresnel reflectance per wavelength: 2 * integral of R mu dmu over the hemisphere, tabulated at load.
//!
//! For one layer R depends on thickness and wavelength through their ratio, apart from dispersion, so the table runs over
//! wavelength (slowly varying) and thickness / wavelength (the fringes). A stack with one varying layer has no such scaling
//! and runs over wavelength and thickness. A constant thickness needs wavelength alone.

use crate::color::{MAX_NM, MIN_NM};

use super::quadrature::{GAUSS, gauss_legendre};
use super::spectral::SpectralFilm;
use super::stack::{Range, Side, Stack};

/// (outside, inside) over wavelength x thickness coordinate.
#[derive(Clone, Debug, Default)]
pub(super) struct Averages {
    /// Row-major: one row of `columns` per wavelength.
    cells: Vec<[f32; 2]>,
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

impl Averages {
    pub(super) fn new(stack: &Stack, film: &SpectralFilm, range: Range) -> Self {
        let varying = stack.varying.filter(|_| !range.is_constant());
        let scaled = varying.is_some() && stack.layers.len() == 1;
        let step_nm = match (varying, scaled) {
            (None, _) => 1.0,
            (Some(_), true) => 10.0,
            (Some(_), false) => 5.0,
        };
        let (first, last) =
            if scaled { (range.min_nm / MAX_NM, range.max_nm / MIN_NM) } else { (range.min_nm, range.max_nm) };
        let fringe = varying.map_or(f64::INFINITY, |layer| {
            0.5 / stack.layers[layer].index.range_of_n().1.max(0.1) * if scaled { 1.0 } else { MIN_NM }
        });
        let intervals =
            ((last - first) / fringe * PER_FRINGE).ceil().clamp(if varying.is_some() { 1.0 } else { 0.0 }, MAX_COLUMNS);
        let columns = intervals as usize + 1;
        let per_cell = if columns > 1 { (last - first) / intervals } else { 1.0 };
        let rows = ((MAX_NM - MIN_NM) / step_nm) as usize + 1;

        let mut cells = vec![[0.0; 2]; rows * columns];
        for row in 0..rows {
            let nm = MIN_NM + step_nm * row as f64;
            let ends = Ends::new(stack, nm);
            let line = &mut cells[row * columns..][..columns];
            for (column, cell) in line.iter_mut().enumerate() {
                let coordinate = first + per_cell * column as f64;
                let thickness_nm = if scaled { coordinate * nm } else { coordinate };
                *cell = ends.averages(film, thickness_nm as f32, nm as f32);
            }
        }
        Self {
            cells,
            columns,
            per_step: (1.0 / step_nm) as f32,
            scaled,
            first: first as f32,
            per_cell: (1.0 / per_cell) as f32,
        }
    }

    #[inline]
    pub(super) fn lanes<const N: usize>(&self, side: Side, thickness_nm: f32, nm: &[f32; N]) -> [f32; N] {
        let side = (side == Side::Inside) as usize;
        let last_row = (self.cells.len() / self.columns.max(1)).saturating_sub(1);
        let last_column = self.columns.saturating_sub(1);
        nm.map(|nm| {
            let x = ((nm - MIN_NM as f32) * self.per_step).clamp(0.0, last_row as f32);
            let row = (x as usize).min(last_row.saturating_sub(1));
            let s = x - row as f32;
            let coordinate = if self.scaled { thickness_nm / nm } else { thickness_nm };
            let y = ((coordinate - self.first) * self.per_cell).clamp(0.0, last_column as f32);
            let column = (y as usize).min(last_column.saturating_sub(1));
            let t = y - column as f32;
            let at = |row: usize, column: usize| {
                self.cells[row.min(last_row) * self.columns + column.min(last_column)][side]
            };
            let low = at(row, column) + t * (at(row, column + 1) - at(row, column));
            let high = at(row + 1, column) + t * (at(row + 1, column + 1) - at(row + 1, column));
            low + s * (high - low)
        })
    }
}

/// The media on both sides at one wavelength, and how the average of one follows from the other.
struct Ends {
    /// The rarer medium, whose cosine is the variable of integration: it covers all directions that are transmitted.
    rare: Side,
    /// (n_rare / n_dense)^2, at most 1.
    ratio: f64,
    lossless: bool,
    opaque: bool,
}

impl Ends {
    fn new(stack: &Stack, nm: f64) -> Self {
        let (outside, base) = (stack.outside.at(nm).re, stack.base.at(nm).re);
        let opaque = stack.opaque_base();
        let rare = if opaque || outside <= base { Side::Outside } else { Side::Inside };
        let ratio = if rare == Side::Outside { outside / base } else { base / outside };
        Self { rare, ratio: ratio * ratio, lossless: stack.lossless_layers(), opaque }
    }

    /// (outside, inside) at one thickness and wavelength.
    fn averages(&self, film: &SpectralFilm, thickness_nm: f32, nm: f32) -> [f32; 2] {
        let reflect = |side: Side, mu: f64| f64::from(film.split(side, mu as f32, thickness_nm, &[nm]).reflect[0]);
        let (mut rare, mut dense) = (0.0, 0.0);
        for &(mu, weight) in gauss_legendre() {
            rare += 2.0 * weight * mu * reflect(self.rare, mu);
        }
        if self.opaque {
            return [rare as f32, 1.0];
        }
        if self.lossless {
            // What enters one way leaves the other: n_dense^2 (1 - F_dense) = n_rare^2 (1 - F_rare).
            dense = 1.0 - self.ratio * (1.0 - rare);
        } else {
            let other = if self.rare == Side::Outside { Side::Inside } else { Side::Outside };
            for &(t, weight) in gauss_legendre() {
                // Transmitted directions, by the conjugate cosine; then total reflection, by nu with mu^2 = mu_c^2 - nu^2,
                // in which R is smooth at the critical angle.
                let below = (1.0 - self.ratio * (1.0 - t * t)).sqrt();
                dense += 2.0 * weight * t * self.ratio * reflect(other, below);
                let critical = (1.0 - self.ratio).max(0.0);
                let beyond = (critical * (1.0 - t * t)).sqrt();
                dense += 2.0 * weight * t * critical * reflect(other, beyond);
            }
        }
        let (rare, dense) = (rare as f32, dense as f32);
        if self.rare == Side::Outside { [rare, dense] } else { [dense, rare] }
    }
}

const _: () = assert!(GAUSS >= 16);
