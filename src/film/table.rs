//! The table rung: the exact spectral integral under the sensor's white, over cos theta, times thickness where it varies.
//!
//! The cosine is always that of the *rarer* side: it covers every direction in which light gets through, so nothing is spent
//! on total reflection and no node straddles its kink. Light from the denser side looks its conjugate cosine up; for
//! lossless layers R is the same there (reciprocity), so one table serves both sides, and beyond the critical angle R is
//! exactly 1. Absorbing layers reflect differently from the two sides and have tables of their own, with one more for
//! total reflection, over nu = sqrt(-mu_rare^2), in which R is smooth.
//!
//! Values are unclamped: saturated reflectances leave sRGB, so a channel may be negative or above 1.

use glam::Vec4;

use crate::color::{Lab, NOMINAL_NM, Sensor, delta_e_2000};

use super::grid::{Axis, Grid, Place};
use super::quadrature::{Integrand, ONE_NM, Spectral};
use super::spectral::SpectralFilm;
use super::stack::{Range, Side, Split, Stack};

#[derive(Clone, Debug)]
pub(super) struct Table {
    axis: Axis,
    /// The side whose cosine is tabulated.
    rare: Side,
    /// (n_dense / n_rare)^2.
    ratio: f32,
    form: Form,
    /// Per thickness row: outside, inside.
    averages: Vec<[[f32; 3]; 2]>,
}

#[derive(Clone, Debug)]
enum Form {
    /// Lossless layers: R only, T = 1 - R.
    Lossless { grid: Grid<1>, opaque: bool },
    /// Absorbing layers on a metal: R and T from outside.
    OneSided(Grid<2>),
    /// Absorbing layers on a transparent base: R and T from the rare side, from the dense side, and R beyond the critical
    /// angle.
    TwoSided { rare: Grid<2>, dense: Grid<2>, beyond: Grid<1> },
}

/// Least and most cosine nodes of a refined row, with a constant and with a varying thickness.
const COLUMNS_1D: [usize; 2] = [33, 513];
const COLUMNS_2D: [usize; 2] = [65, 513];
/// A row is refined until no midpoint of two nodes is further than this from the truth, CIEDE2000; constant and varying.
const MIDPOINT_DELTA_E: [f64; 2] = [0.1, 1.5];
/// Thickness nodes per fringe at 450 nm where fringes are sinusoidal; and the path differences (nm) from which twice the
/// spacing does and from which fringes have faded.
const PER_FRINGE: f64 = 24.0;
const COARSER_NM: f64 = 5_000.0;
const FADED_NM: f64 = 13_000.0;
/// The first nanometres change most at grazing, where a film between equal media turns from nothing into a mirror.
const THIN_NM: f64 = 24.0;
const THIN_SPACING_NM: f64 = 1.5;
/// Spacing in the faded region, where only absorption changes with thickness, as a share of the range.
const FADED_ROWS: f64 = 32.0;

impl Table {
    pub(super) fn new(stack: &Stack, range: Range, sensor: &Sensor) -> Self {
        let film = SpectralFilm::without_averages(stack);
        let opaque = stack.opaque_base();
        let (outside, base) = (stack.outside.at(NOMINAL_NM).re, stack.base.at(NOMINAL_NM).re);
        let rare = stack.rarer_side();
        let ratio = if opaque { 1.0 } else { (outside.max(base) / outside.min(base)).powi(2) as f32 };
        let axis = thickness_axis(stack, range);

        // Rows of similar thickness share a rule; a single row can afford 1 nm.
        let least = if axis.rows() == 1 { ONE_NM } else { 0 };
        let thickness = |row: usize| axis.thickness_nm(row, range.min_nm);
        let counts: Vec<usize> =
            (0..axis.rows()).map(|row| Spectral::count(stack, thickness(row)).max(least)).collect();
        let mut used = counts.clone();
        used.dedup();
        let rules: Vec<Spectral> = used.iter().map(|&count| Spectral::new(sensor, count)).collect();
        let integrands: Vec<Integrand> = rules.iter().map(|rule| rule.gather(&film)).collect();
        let rule = |row: usize| &integrands[used.iter().position(|&count| count == counts[row]).unwrap_or(0)];
        let reflect = |side: Side, row: usize, mu: f32| [rule(row).reflect(side, mu, thickness(row) as f32)];
        let both = |side: Side, row: usize, mu: f32| rule(row).both(side, mu, thickness(row) as f32);

        let rows = axis.rows();
        let form = if stack.lossless_layers() {
            Form::Lossless { grid: fill(rows, |row, u| reflect(rare, row, u * u)), opaque }
        } else if opaque {
            Form::OneSided(fill(rows, |row, u| both(rare, row, u * u)))
        } else {
            let other = if rare == Side::Outside { Side::Inside } else { Side::Outside };
            let below = |mu: f32| (1.0 - (1.0 - mu * mu) / ratio).max(0.0).sqrt();
            let critical = 1.0 - 1.0 / ratio;
            let beyond = |u: f32| (critical * (1.0 - u * u)).max(0.0).sqrt();
            Form::TwoSided {
                rare: fill(rows, |row, u| both(rare, row, u * u)),
                dense: fill(rows, |row, u| both(other, row, below(u * u))),
                beyond: fill(rows, |row, u| reflect(other, row, beyond(u))),
            }
        };
        let averages = averages(&form, rare, ratio);
        Self { axis, rare, ratio, form, averages }
    }

    pub(super) fn bytes(&self) -> usize {
        let grids = match &self.form {
            Form::Lossless { grid, .. } => grid.bytes(),
            Form::OneSided(grid) => grid.bytes(),
            Form::TwoSided { rare, dense, beyond } => rare.bytes() + dense.bytes() + beyond.bytes(),
        };
        grids + size_of_val(self.averages.as_slice())
    }

    #[inline(always)]
    pub(super) fn split(&self, side: Side, cos_i: f32, thickness_nm: f32) -> Split<[f32; 3]> {
        let place = self.axis.place(thickness_nm);
        let mu = cos_i.abs();
        if side == self.rare {
            return match &self.form {
                Form::Lossless { grid, .. } => lossless(grid, mu, place),
                Form::OneSided(grid) | Form::TwoSided { rare: grid, .. } => lossy(grid, mu, place),
            };
        }
        // The conjugate cosine: n_rare^2 (1 - mu_rare^2) = n_dense^2 (1 - mu^2).
        let square = 1.0 - self.ratio * (1.0 - mu * mu);
        match &self.form {
            // Nothing travels inside a metal.
            Form::Lossless { opaque: true, .. } | Form::OneSided(_) => TOTAL,
            // Between equal media the cosine is its own conjugate.
            Form::Lossless { grid, .. } if self.ratio == 1.0 => lossless(grid, mu, place),
            Form::Lossless { .. } if square <= 0.0 => TOTAL,
            Form::Lossless { grid, .. } => lossless(grid, square.sqrt(), place),
            Form::TwoSided { beyond, .. } if square <= 0.0 => {
                let [reflect] = beyond.at((-square / (self.ratio - 1.0).max(1e-6)).sqrt(), place);
                Split { reflect: rgb(reflect), transmit: [0.0; 3] }
            }
            Form::TwoSided { dense, .. } => lossy(dense, square.sqrt(), place),
        }
    }

    #[inline(always)]
    pub(super) fn average(&self, side: Side, thickness_nm: f32) -> [f32; 3] {
        let place = self.axis.place(thickness_nm);
        place.between(|row| self.averages.get(row).map_or([0.0; 3], |pair| pair[(side == Side::Inside) as usize]))
    }
}

/// 2 * integral of R mu dmu from each side (outside, inside) of each row, over the tables themselves.
fn averages(form: &Form, rare: Side, ratio: f32) -> Vec<[[f32; 3]; 2]> {
    // mu = u^2, so 2 mu dmu = 4 u^3 du.
    let cosine = |u: f64| 4.0 * u * u * u;
    let pairs: Vec<[[f32; 3]; 2]> = match form {
        Form::Lossless { grid, opaque: true } => grid.integrals(cosine).into_iter().map(|r| [r, [1.0; 3]]).collect(),
        Form::OneSided(grid) => grid.integrals(cosine).into_iter().map(|r| [r, [1.0; 3]]).collect(),
        // What enters one way leaves the other: n_dense^2 (1 - F_dense) = n_rare^2 (1 - F_rare).
        Form::Lossless { grid, .. } => {
            grid.integrals(cosine).into_iter().map(|r| [r, r.map(|r| 1.0 - (1.0 - r) / ratio)]).collect()
        }
        // Transmitted directions by their conjugate cosine, total reflection by nu: 2 mu dmu = 2 nu dnu up to its sign.
        Form::TwoSided { rare, dense, beyond } => {
            let (below, beyond) = (dense.integrals(cosine), beyond.integrals(|u| 2.0 * u));
            let total = |i: usize| std::array::from_fn(|c| below[i][c] / ratio + (1.0 - 1.0 / ratio) * beyond[i][c]);
            rare.integrals(cosine).into_iter().enumerate().map(|(i, r)| [r, total(i)]).collect()
        }
    };
    if rare == Side::Outside { pairs } else { pairs.into_iter().map(|[rare, dense]| [dense, rare]).collect() }
}

const TOTAL: Split<[f32; 3]> = Split { reflect: [1.0; 3], transmit: [0.0; 3] };

#[inline(always)]
fn lossless(grid: &Grid<1>, mu: f32, place: Place) -> Split<[f32; 3]> {
    let [reflect] = grid.at(mu.sqrt(), place);
    Split { reflect: rgb(reflect), transmit: rgb(Vec4::ONE - reflect) }
}

#[inline(always)]
fn lossy(grid: &Grid<2>, mu: f32, place: Place) -> Split<[f32; 3]> {
    let [reflect, transmit] = grid.at(mu.sqrt(), place);
    Split { reflect: rgb(reflect), transmit: rgb(transmit) }
}

#[inline(always)]
fn rgb(value: Vec4) -> [f32; 3] {
    [value.x, value.y, value.z]
}

/// Fills a table. Rows are refined until the old nodes interpolate the new ones well enough: a single row strictly; several
/// by the looks of three of them.
fn fill<const K: usize>(rows: usize, value: impl Fn(usize, f32) -> [[f32; 3]; K] + Sync) -> Grid<K> {
    if rows == 1 {
        return refine(&COLUMNS_1D, MIDPOINT_DELTA_E[0], |u| value(0, u));
    }
    let samples = [rows / 8, rows / 2, rows - 1];
    let columns = samples.map(|row| refine(&COLUMNS_2D, MIDPOINT_DELTA_E[1], |u| value(row, u)).columns());
    // The last refinement only showed that the one before it was enough.
    let columns = columns.into_iter().fold(0, usize::max).div_ceil(2);
    Grid::new(rows, columns, value)
}

/// One row with as many nodes as it takes.
fn refine<const K: usize>(
    columns: &[usize; 2],
    midpoint_delta_e: f64,
    value: impl Fn(f32) -> [[f32; 3]; K] + Sync,
) -> Grid<K> {
    let mut grid = Grid::new(1, columns[0], |_, u| value(u));
    let color = |node: [Vec4; K]| Lab::from_linear_srgb(rgb(node[0]).map(f64::from));
    while grid.columns() < columns[1] {
        let finer = grid.refined(&value);
        let midpoint = |i: usize| (2 * i + 1) as f32 / (finer.columns() - 1) as f32;
        let error = |u: f32| delta_e_2000(color(grid.at(u, Place::Only)), color(finer.at(u, Place::Only)));
        let worst = (0..grid.columns() - 1).map(|i| error(midpoint(i))).fold(0.0, f64::max);
        // Kept in any case: it is paid for.
        grid = finer;
        if worst < midpoint_delta_e {
            break;
        }
    }
    grid
}

/// Thickness nodes for a range, fine where fringes are visible.
pub(super) fn thickness_axis(stack: &Stack, range: Range) -> Axis {
    let Some(layer) = stack.varying.filter(|_| !range.is_constant()) else { return Axis::point() };
    let n = stack.layers[layer].index.range_of_n().1.max(0.2);
    // Strong reflections on both faces of the layer make narrow fringes.
    let media = [&stack.outside, &stack.layers[layer].index, &stack.base].map(|curve| curve.at(450.0));
    let contrast = ((media[0] - media[1]) / (media[0] + media[1])) * ((media[1] - media[2]) / (media[1] + media[2]));
    let sharpness = if stack.layers.len() == 1 { 1.0 + 4.0 * contrast.norm() } else { 2.0 };
    let spacing = 450.0 / (2.0 * n) / (PER_FRINGE * sharpness);
    // At grazing the path difference is the least.
    let around = stack.outside.at(450.0).re;
    let grazing = (n * n - around * around).max(0.0).sqrt().max(0.4 * n);
    let (Range { min_nm, max_nm }, coarser, faded) = (range, 0.5 * COARSER_NM / grazing, 0.5 * FADED_NM / grazing);
    let spans = [
        (min_nm, max_nm.min(THIN_NM), spacing.min(THIN_SPACING_NM)),
        (min_nm.max(THIN_NM), max_nm.min(coarser), spacing),
        (min_nm.max(coarser), max_nm.min(faded), 2.0 * spacing),
        (min_nm.max(faded), max_nm, (max_nm - faded) / FADED_ROWS),
    ];
    let used: Vec<_> = spans.into_iter().filter(|(first, last, _)| last - first > 1e-6).collect();
    Axis::new(&used)
}
