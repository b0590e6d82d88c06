//! Transmittance over angle in a few numbers, for what microfacets do with light on the whole: it is linear in T, so a short
//! expansion of T replaces an integral over facets by a short sum.
//!
//! T is expanded over the cosine of the *rarer* side, in which it is the same from both sides and never cut off by total
//! reflection: the least-squares fit by hats at even steps of u = sqrt(mu).

use std::sync::LazyLock;

use super::grid::Axis;
use super::lane_table::LaneTable;
use super::rgb::RgbFilm;
use super::spectral::SpectralFilm;
use super::stack::{Range, Side, Split, Stack};
use super::table::thickness_axis;

/// Hats of the expansion.
pub const HATS: usize = 12;

/// Angles at which T is sampled for the fit.
const SAMPLES: usize = 44;

/// What an interface transmits over angle, and what its layers absorb.
#[derive(Clone, Copy, Debug)]
pub struct Profile<L> {
    /// Heights of the hats ([`hats`]).
    pub transmit: [L; HATS],
    /// Share absorbed of light from everywhere, from outside and from inside.
    pub absorbed: [L; 2],
}

/// Values of two adjacent hats, the first of them `.0`, at a cosine in the rarer medium; all others are 0.
#[inline]
pub fn hats(mu: f32) -> (usize, [f32; 2]) {
    let x = mu.clamp(0.0, 1.0).sqrt() * (HATS - 1) as f32;
    let low = (x as usize).min(HATS - 2);
    let t = x - low as f32;
    (low, [1.0 - t, t])
}

/// 2 * integral of each hat times mu dmu: weights of the mean transmittance of light from everywhere.
pub fn hat_means() -> &'static [f32; HATS] {
    static MEANS: LazyLock<[f32; HATS]> = LazyLock::new(|| {
        const STEPS: usize = 4096;
        let mut means = [0.0; HATS];
        for step in 0..STEPS {
            let mu = (step as f64 + 0.5) / STEPS as f64;
            let (low, values) = hats(mu as f32);
            for (i, value) in values.into_iter().enumerate() {
                means[low + i] += 2.0 * mu * f64::from(value) / STEPS as f64;
            }
        }
        means.map(|mean| mean as f32)
    });
    &MEANS
}

/// Cosine of a sample.
fn cosine(sample: usize) -> f32 {
    ((sample as f32 + 0.5) / SAMPLES as f32).powi(2)
}

/// Least-squares fit: heights = `fit` times samples.
fn fit() -> &'static [[f32; HATS]; SAMPLES] {
    static FIT: LazyLock<[[f32; HATS]; SAMPLES]> = LazyLock::new(|| {
        // The normal equations of hats are tridiagonal (Thomas' algorithm), with one right side per sample.
        let values: [[f64; HATS]; SAMPLES] = std::array::from_fn(|sample| {
            let mut row = [0.0; HATS];
            let (low, pair) = hats(cosine(sample));
            row[low] = f64::from(pair[0]);
            row[low + 1] = f64::from(pair[1]);
            row
        });
        let product = |i: usize, j: usize| values.iter().map(|row| row[i] * row[j]).sum::<f64>();
        std::array::from_fn(|sample| {
            let mut right = values[sample];
            let mut diagonal: [f64; HATS] = std::array::from_fn(|i| product(i, i));
            for i in 1..HATS {
                let off = product(i - 1, i);
                let factor = off / diagonal[i - 1];
                diagonal[i] -= factor * off;
                right[i] -= factor * right[i - 1];
            }
            for i in (0..HATS).rev() {
                let after = if i + 1 < HATS { product(i, i + 1) * right[i + 1] } else { 0.0 };
                right[i] = (right[i] - after) / diagonal[i];
            }
            right.map(|height| height as f32)
        })
    });
    &FIT
}

/// A profile as a table holds it: heights, then absorbed shares.
const CELL: usize = HATS + 2;

impl<L: Copy> Profile<L> {
    /// From the entries of one cell.
    #[inline]
    fn new(entry: impl Fn(usize) -> L) -> Self {
        Self { transmit: std::array::from_fn(&entry), absorbed: [entry(HATS), entry(HATS + 1)] }
    }

    #[inline]
    pub fn map<T>(self, f: impl Fn(L) -> T) -> Profile<T> {
        Profile { transmit: self.transmit.map(&f), absorbed: self.absorbed.map(&f) }
    }

    #[inline]
    pub fn zip<R: Copy, T: Copy>(self, other: Profile<R>, f: impl Fn(L, R) -> T) -> Profile<T> {
        let entry = |i: usize| {
            if i < HATS {
                f(self.transmit[i], other.transmit[i])
            } else {
                f(self.absorbed[i - HATS], other.absorbed[i - HATS])
            }
        };
        Profile::new(entry)
    }
}

/// The cell of W lanes from what they reflect and transmit.
fn cells<const W: usize>(stack: &Stack, split: impl Fn(Side, f32) -> Split<[f32; W]>) -> [[f32; CELL]; W] {
    let (rare, lossless) = (stack.rarer_side(), stack.lossless_layers());
    let mut cells = [[0.0; CELL]; W];
    for (sample, weights) in fit().iter().enumerate() {
        let mu = cosine(sample);
        let transmit = split(rare, mu).transmit;
        for (cell, transmit) in cells.iter_mut().zip(transmit) {
            for (height, weight) in cell.iter_mut().zip(weights) {
                *height += weight * transmit;
            }
        }
        if lossless {
            continue;
        }
        // mu = u^2, so 2 mu dmu = 4 u^3 du.
        let weight = 4.0 * mu * mu.sqrt() / SAMPLES as f32;
        for (i, side) in [Side::Outside, Side::Inside].into_iter().enumerate() {
            let split = split(side, mu);
            for (lane, cell) in cells.iter_mut().enumerate() {
                cell[HATS + i] += weight * (1.0 - split.reflect[lane] - split.transmit[lane]).max(0.0);
            }
        }
    }
    cells
}

/// Profiles of a film compiled for RGB, over thickness.
#[derive(Clone, Debug)]
pub struct RgbProfile {
    axis: Axis,
    rows: Vec<[[f32; 3]; CELL]>,
}

impl RgbProfile {
    pub fn new(film: &RgbFilm, stack: &Stack, range: Range) -> Self {
        let range = range.of(stack);
        let axis = thickness_axis(stack, range);
        let row = |row: usize| {
            let thickness_nm = axis.thickness_nm(row, range.min_nm) as f32;
            let channels = cells(stack, |side, mu| film.split(side, mu, thickness_nm));
            std::array::from_fn(|entry| channels.map(|channel| channel[entry]))
        };
        Self { rows: (0..axis.rows()).map(row).collect(), axis }
    }

    /// `thickness_nm` is that of the varying layer, ignored when none varies.
    #[inline]
    pub fn at(&self, thickness_nm: f32) -> Profile<[f32; 3]> {
        let place = self.axis.place(thickness_nm);
        Profile::new(|entry| place.between(|row| self.rows.get(row).map_or([0.0; 3], |row| row[entry])))
    }
}

/// Profiles of a film per wavelength.
#[derive(Clone, Debug)]
pub struct SpectralProfile(LaneTable<CELL>);

impl SpectralProfile {
    pub fn new(film: &SpectralFilm, stack: &Stack, range: Range) -> Self {
        Self(LaneTable::new(stack, film, range.of(stack), |media, depths| {
            depths.iter().map(|depths| cells(stack, |side, mu| media.split_depths(side, mu, depths))).collect()
        }))
    }

    /// At N wavelengths in nm; `thickness_nm` is that of the varying layer, ignored when none varies.
    #[inline]
    pub fn lanes<const N: usize>(&self, thickness_nm: f32, nm: &[f32; N]) -> Profile<[f32; N]> {
        let lanes = self.0.lanes(thickness_nm, nm);
        Profile::new(|entry| lanes.map(|cell| cell[entry]))
    }
}
