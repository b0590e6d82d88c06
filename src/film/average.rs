//! Average Fresnel reflectance per wavelength: 2 * integral of R mu dmu over the hemisphere, tabulated at load.
//!
//! For one layer R depends on thickness and wavelength through their ratio, apart from dispersion, so the table runs over
//! wavelength (slowly varying) and thickness / wavelength (the fringes). A stack with one varying layer has no such scaling
//! and runs over wavelength and thickness. A constant thickness needs wavelength alone.

use crate::color::{MAX_NM, MIN_NM};

use super::lanes::cell;
use super::quadrature::gauss_legendre;
use super::spectral::{Gathered, SpectralFilm};
use super::stack::{Range, Side, Stack};

/// (outside, inside) over wavelength x thickness coordinate.
#[derive(Clone, Debug, Default)]
pub(super) struct Averages {
    /// Row-major: one row of `columns` per wavelength.
    cells: Vec<[f32; 2]>,
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
/// Wavelengths that are integrated together.
const WIDTH: usize = 8;

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
        let intervals = varying.map_or(0.0, |layer| {
            let n = stack.layers[layer].index.range_of_n().1.max(0.1);
            let fringe = 0.5 / n * if scaled { 1.0 } else { MIN_NM };
            ((last - first) / fringe * PER_FRINGE).ceil().clamp(1.0, MAX_COLUMNS)
        });
        let (rows, columns) = (((MAX_NM - MIN_NM) / step_nm) as usize + 1, intervals as usize + 1);
        let per_cell = if columns > 1 { (last - first) / intervals } else { 1.0 };

        let mut cells = vec![[0.0; 2]; rows * columns];
        for block in (0..rows).step_by(WIDTH) {
            let media = film.gather(&std::array::from_fn(|i| (MIN_NM + step_nm * (block + i) as f64) as f32));
            let ends = Ends::new(stack, &media);
            for column in 0..columns {
                let coordinate = (first + per_cell * column as f64) as f32;
                let depths = media.nm().map(|nm| if scaled { coordinate } else { coordinate / nm });
                let averages = ends.averages(&media, &depths);
                for (i, average) in averages.into_iter().enumerate().take(rows - block) {
                    cells[(block + i) * columns + column] = average;
                }
            }
        }
        let (per_step, per_cell) = ((1.0 / step_nm) as f32, (1.0 / per_cell) as f32);
        Self { cells, rows, columns, per_step, scaled, first: first as f32, per_cell }
    }

    #[inline]
    pub(super) fn lanes<const N: usize>(&self, side: Side, thickness_nm: f32, nm: &[f32; N]) -> [f32; N] {
        let side = (side == Side::Inside) as usize;
        nm.map(|nm| {
            let (row, s) = cell((nm - MIN_NM as f32) * self.per_step, (self.rows - 1) as f32);
            let value = |place: usize| self.cells.get(place).map_or(0.0, |cell| cell[side]);
            if self.columns == 1 {
                let low = value(row as usize);
                return low + s * (value(row as usize + 1) - low);
            }
            let coordinate = if self.scaled { thickness_nm / nm } else { thickness_nm };
            let (column, t) = cell((coordinate - self.first) * self.per_cell, (self.columns - 1) as f32);
            let place = row as usize * self.columns + column as usize;
            let along = |place: usize| value(place) + t * (value(place + 1) - value(place));
            let low = along(place);
            low + s * (along(place + self.columns) - low)
        })
    }
}

/// The media on both sides, and how the average of one follows from the other.
struct Ends {
    /// The rarer medium, whose cosine is the variable of integration: it covers all directions that are transmitted.
    rare: Side,
    /// (n_rare / n_dense)^2 of each lane, at most 1.
    ratio: [f64; WIDTH],
    lossless: bool,
    opaque: bool,
}

impl Ends {
    fn new(stack: &Stack, media: &Gathered<WIDTH>) -> Self {
        let opaque = stack.opaque_base();
        let index = |nm: f32| (stack.outside.at(f64::from(nm)).re, stack.base.at(f64::from(nm)).re);
        let (outside, base) = index(media.nm()[0]);
        let rare = if opaque || outside <= base { Side::Outside } else { Side::Inside };
        let ratio = media.nm().map(|nm| {
            let (outside, base) = index(nm);
            let ratio = if rare == Side::Outside { outside / base } else { base / outside };
            (ratio * ratio).min(1.0)
        });
        Self { rare, ratio, lossless: stack.lossless_layers(), opaque }
    }

    /// (outside, inside) of each lane at thickness / wavelength.
    fn averages(&self, media: &Gathered<WIDTH>, depths: &[f32; WIDTH]) -> [[f32; 2]; WIDTH] {
        let mut rare = [0.0; WIDTH];
        for &(mu, weight) in gauss_legendre() {
            let reflect = media.split_depths(self.rare, mu as f32, depths).reflect;
            rare = std::array::from_fn(|i| rare[i] + 2.0 * weight * mu * f64::from(reflect[i]));
        }
        let dense: [f64; WIDTH] = if self.opaque {
            [1.0; WIDTH]
        } else if self.lossless {
            // What enters one way leaves the other: n_dense^2 (1 - F_dense) = n_rare^2 (1 - F_rare).
            std::array::from_fn(|i| 1.0 - self.ratio[i] * (1.0 - rare[i]))
        } else {
            self.dense(media, depths)
        };
        std::array::from_fn(|i| {
            let (rare, dense) = (rare[i] as f32, dense[i] as f32);
            if self.rare == Side::Outside { [rare, dense] } else { [dense, rare] }
        })
    }

    /// The denser side of absorbing layers: directions that are transmitted, by the conjugate cosine; then total reflection,
    /// by nu with mu^2 = mu_critical^2 - nu^2, in which R is smooth at the critical angle.
    fn dense(&self, media: &Gathered<WIDTH>, depths: &[f32; WIDTH]) -> [f64; WIDTH] {
        let side = if self.rare == Side::Outside { Side::Inside } else { Side::Outside };
        // The angles of a block follow its first lane; its 8 wavelengths have practically one index ratio.
        let (ratio, critical) = (self.ratio[0], 1.0 - self.ratio[0]);
        let mut sum = [0.0; WIDTH];
        for &(t, weight) in gauss_legendre() {
            let below = media.split_depths(side, (1.0 - ratio * (1.0 - t * t)).sqrt() as f32, depths).reflect;
            let beyond = media.split_depths(side, (critical * (1.0 - t * t)).sqrt() as f32, depths).reflect;
            sum = std::array::from_fn(|i| {
                sum[i] + 2.0 * weight * t * (ratio * f64::from(below[i]) + critical * f64::from(beyond[i]))
            });
        }
        sum
    }
}
