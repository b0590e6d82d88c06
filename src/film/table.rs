//! The table rung: the exact spectral integral under the sensor's white, over cos theta, times thickness where it varies.
//!
//! The cosine is always that of the *rarer* side: it covers every direction in which light gets through, so nothing is spent
//! on total reflection and no node straddles its kink. Light from the denser side looks its conjugate cosine up; for
//! lossless layers R is the same there (reciprocity), so one table serves both sides, and beyond the critical angle R is
//! exactly 1. Absorbing layers reflect differently from the two sides and have tables of their own, with one more for
//! total reflection, over nu = sqrt(-mu_rare^2), in which R is smooth.
//!
//! Values are unclamped: saturated reflectances leave sRGB, so a channel may be negative or above 1.

use crate::color::{Lab, NOMINAL_NM, Sensor, delta_e_2000};

use super::grid::{Axis, Grid, Place};
use super::quadrature::{Integrand, Spectral};
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

/// Cosine nodes with a varying thickness, and the least and most with a constant one.
const COLUMNS_2D: usize = 65;
const COLUMNS_1D: [usize; 2] = [33, 513];
/// A 1-D table is refined until no midpoint of two nodes is further than this from the truth, CIEDE2000.
const MIDPOINT_DELTA_E: f64 = 0.1;
/// Thickness nodes per fringe at 450 nm where fringes are sinusoidal; and the path differences (nm) from which twice the
/// spacing does and from which fringes have faded.
const PER_FRINGE: f64 = 24.0;
const COARSER_NM: f64 = 5_000.0;
const FADED_NM: f64 = 13_000.0;
/// Spacing in the faded region, where only absorption changes with thickness, as a share of the range.
const FADED_ROWS: f64 = 32.0;

impl Table {
    pub(super) fn new(stack: &Stack, range: Range, sensor: &Sensor) -> Self {
        let film = SpectralFilm::without_averages(stack);
        let opaque = stack.opaque_base();
        let (outside, base) = (stack.outside.at(NOMINAL_NM).re, stack.base.at(NOMINAL_NM).re);
        let rare = if opaque || outside <= base { Side::Outside } else { Side::Inside };
        let ratio = if opaque { 1.0 } else { (outside.max(base) / outside.min(base)).powi(2) as f32 };
        let axis = thickness_axis(stack, range);

        // Rows of similar thickness share a rule; a single row can afford 1 nm.
        let coarsest = if axis.rows() == 1 { 1.0 } else { f64::INFINITY };
        let thickness = |row: usize| axis.thickness_nm(row, range.min_nm);
        let steps: Vec<f64> =
            (0..axis.rows()).map(|row| Spectral::step_nm(stack, thickness(row)).min(coarsest)).collect();
        let mut used = steps.clone();
        used.dedup();
        let rules: Vec<Spectral> = used.iter().map(|&step| Spectral::new(sensor, step)).collect();
        let integrands: Vec<Integrand> = rules.iter().map(|rule| rule.gather(&film)).collect();
        // Steps only ever shrink along the axis.
        let rule = |row: usize| &integrands[used.iter().rposition(|&step| step >= steps[row]).unwrap_or(0)];
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
            Form::Lossless { .. } if square <= 0.0 => TOTAL,
            Form::Lossless { grid, .. } => lossless(grid, square.sqrt(), place),
            Form::TwoSided { beyond, .. } if square <= 0.0 => {
                let [[r, g, b, _]] = beyond.at((-square / (self.ratio - 1.0).max(1e-6)).sqrt(), place);
                Split { reflect: [r, g, b], transmit: [0.0; 3] }
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
    let [[r, g, b, _]] = grid.at(mu.sqrt(), place);
    Split { reflect: [r, g, b], transmit: [1.0 - r, 1.0 - g, 1.0 - b] }
}

#[inline(always)]
fn lossy(grid: &Grid<2>, mu: f32, place: Place) -> Split<[f32; 3]> {
    let [[r, g, b, _], [tr, tg, tb, _]] = grid.at(mu.sqrt(), place);
    Split { reflect: [r, g, b], transmit: [tr, tg, tb] }
}

/// Fills a table. A single row is refined until the old table interpolates the new nodes well enough.
fn fill<const K: usize>(rows: usize, value: impl Fn(usize, f32) -> [[f32; 3]; K] + Sync) -> Grid<K> {
    if rows > 1 {
        return Grid::new(rows, COLUMNS_2D, value);
    }
    let mut grid = Grid::new(1, COLUMNS_1D[0], &value);
    let color = |node: [[f32; 4]; K]| Lab::from_linear_srgb([node[0][0], node[0][1], node[0][2]].map(f64::from));
    while grid.columns() < COLUMNS_1D[1] {
        let finer = grid.refined(|u| value(0, u));
        let midpoint = |i: usize| (2 * i + 1) as f32 / (finer.columns() - 1) as f32;
        let error = |u: f32| delta_e_2000(color(grid.at(u, Place::first())), color(finer.at(u, Place::first())));
        let worst = (0..grid.columns() - 1).map(|i| error(midpoint(i))).fold(0.0, f64::max);
        // The finer one is paid for.
        grid = finer;
        if worst < MIDPOINT_DELTA_E {
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
    let (Range { min_nm, max_nm }, coarser, faded) = (range, 0.5 * COARSER_NM / n, 0.5 * FADED_NM / n);
    let spans = [
        (min_nm, max_nm.min(coarser), spacing),
        (min_nm.max(coarser), max_nm.min(faded), 2.0 * spacing),
        (min_nm.max(faded), max_nm, (max_nm - faded) / FADED_ROWS),
    ];
    let used: Vec<_> = spans.into_iter().filter(|(first, last, _)| last - first > 1e-6).collect();
    Axis::new(&used)
}
