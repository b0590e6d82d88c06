//! Transmittance over angle in a few numbers, for what microfacets do with light on the whole: it is linear in T, so a short
//! expansion of T replaces an integral over facets by a short sum.
//!
//! T is expanded over the cosine of the *rarer* side, in which it is the same from both sides and never cut off by total
//! reflection: in Chebyshev polynomials of 2 u - 1, u = sqrt(mu), which follow smooth fringes to far more digits than as many
//! straight pieces would.

use std::f64::consts::PI;
use std::sync::LazyLock;

use super::grid::Axis;
use super::lane_table::LaneTable;
use super::rgb::RgbFilm;
use super::spectral::SpectralFilm;
use super::stack::{Range, Side, Split, Stack};
use super::table::thickness_axis;

/// Terms of the expansion.
pub const TERMS: usize = 16;

/// Angles at which T is sampled for the fit.
const SAMPLES: usize = 44;

/// What an interface transmits over angle, and what its layers absorb.
#[derive(Clone, Copy, Debug)]
pub struct Profile<L> {
    /// Factors of the polynomials ([`terms`]).
    pub transmit: [L; TERMS],
    /// Share absorbed of light from everywhere, from outside and from inside.
    pub absorbed: [L; 2],
}

/// The polynomials at a cosine in the rarer medium.
#[inline]
pub fn terms(mu: f32) -> [f32; TERMS] {
    polynomials(2.0 * mu.clamp(0.0, 1.0).sqrt() - 1.0)
}

#[inline]
fn polynomials(x: f32) -> [f32; TERMS] {
    let mut values = [1.0, x, 0.0];
    std::array::from_fn(|term| {
        if term >= 2 {
            values = [values[1], 2.0 * x * values[1] - values[0], 0.0];
        }
        values[term.min(1)]
    })
}

/// 2 * integral of each polynomial times mu dmu: weights of the mean transmittance of light from everywhere.
pub fn term_means() -> &'static [f32; TERMS] {
    static MEANS: LazyLock<[f32; TERMS]> = LazyLock::new(|| {
        const STEPS: usize = 4096;
        let mut means = [0.0f64; TERMS];
        for step in 0..STEPS {
            let mu = (step as f64 + 0.5) / STEPS as f64;
            for (mean, value) in means.iter_mut().zip(terms(mu as f32)) {
                *mean += 2.0 * mu * f64::from(value) / STEPS as f64;
            }
        }
        means.map(|mean| mean as f32)
    });
    &MEANS
}

/// Where the fit samples: a cosine, and what its sample adds to each factor. The nodes of Chebyshev's polynomials, on which
/// these are orthogonal.
fn fit() -> &'static [(f32, [f32; TERMS]); SAMPLES] {
    static FIT: LazyLock<[(f32, [f32; TERMS]); SAMPLES]> = LazyLock::new(|| {
        std::array::from_fn(|sample| {
            let angle = PI * (sample as f64 + 0.5) / SAMPLES as f64;
            let weight = |term: usize| if term == 0 { 1.0 } else { 2.0 * (term as f64 * angle).cos() };
            let u = 0.5 * (1.0 + angle.cos());
            ((u * u) as f32, std::array::from_fn(|term| (weight(term) / SAMPLES as f64) as f32))
        })
    });
    &FIT
}

/// A profile as a table holds it: factors, then absorbed shares.
const CELL: usize = TERMS + 2;

impl<L: Copy> Profile<L> {
    /// From the entries of one cell.
    #[inline]
    fn new(entry: impl Fn(usize) -> L) -> Self {
        Self { transmit: std::array::from_fn(&entry), absorbed: [entry(TERMS), entry(TERMS + 1)] }
    }

    #[inline]
    pub fn map<T>(self, f: impl Fn(L) -> T) -> Profile<T> {
        Profile { transmit: self.transmit.map(&f), absorbed: self.absorbed.map(&f) }
    }

    #[inline]
    pub fn zip<R: Copy, T: Copy>(self, other: Profile<R>, f: impl Fn(L, R) -> T) -> Profile<T> {
        let entry = |i: usize| {
            if i < TERMS {
                f(self.transmit[i], other.transmit[i])
            } else {
                f(self.absorbed[i - TERMS], other.absorbed[i - TERMS])
            }
        };
        Profile::new(entry)
    }
}

/// The cell of W lanes from what they reflect and transmit.
fn cells<const W: usize>(stack: &Stack, split: impl Fn(Side, f32) -> Split<[f32; W]>) -> [[f32; CELL]; W] {
    let (rare, lossless) = (stack.rarer_side(), stack.lossless_layers());
    let mut cells = [[0.0; CELL]; W];
    for (mu, weights) in fit() {
        let transmit = split(rare, *mu).transmit;
        for (cell, transmit) in cells.iter_mut().zip(transmit) {
            for (factor, weight) in cell.iter_mut().zip(weights) {
                *factor += weight * transmit;
            }
        }
        if lossless {
            continue;
        }
        // The mean of the fit, which is linear in its samples.
        let weight: f32 = weights.iter().zip(term_means()).map(|(weight, mean)| weight * mean).sum();
        for (i, side) in [Side::Outside, Side::Inside].into_iter().enumerate() {
            let split = split(side, *mu);
            for (lane, cell) in cells.iter_mut().enumerate() {
                cell[TERMS + i] += weight * (1.0 - split.reflect[lane] - split.transmit[lane]).max(0.0);
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
