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
const COLUMNS_1D: [usize; 2] = [65, 513];
/// A 1-D table is refined until no midpoint of two nodes is further than this from the truth, CIEDE2000.
const MIDPOINT_DELTA_E: f64 = 0.05;
/// Thickness nodes per fringe at 450 nm, and the path differences (nm) from which twice the spacing does and from which
/// fringes have faded.
const PER_FRINGE: f64 = 32.0;
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

        // Rows of similar thickness share a rule.
        let steps: Vec<f64> =
            (0..axis.rows()).map(|row| Spectral::step_nm(stack, axis.thickness_nm(row, range.min_nm))).collect();
        let mut used = steps.clone();
        used.dedup();
        let rules: Vec<(f64, Spectral)> = used
            .into_iter()
            .map(|step| if axis.rows() == 1 { step.min(1.0) } else { step })
            .map(|step| (step, Spectral::new(sensor, step)))
            .collect();
        let integrands: Vec<(f64, Integrand)> = rules.iter().map(|(step, rule)| (*step, rule.gather(&film))).collect();
        let integrate = |side: Side, row: usize, cos_i: f32| {
            let wanted = steps[row];
            let rule = integrands.iter().find(|(step, _)| *step <= wanted).or(integrands.last());
            let nm = axis.thickness_nm(row, range.min_nm) as f32;
            rule.map_or(Split { reflect: [0.0; 3], transmit: [0.0; 3] }, |(_, rule)| rule.rgb(side, cos_i, nm))
        };
        let both = |side: Side, row: usize, cos_i: f32| {
            let split = integrate(side, row, cos_i);
            [split.reflect, split.transmit]
        };

        let (rows, constant) = (axis.rows(), axis.rows() == 1);
        let form = if stack.lossless_layers() {
            let grid =
                refine(constant, |columns| Grid::new(rows, columns, |row, u| [integrate(rare, row, u * u).reflect]));
            Form::Lossless { grid, opaque }
        } else if opaque {
            Form::OneSided(refine(constant, |columns| Grid::new(rows, columns, |row, u| both(rare, row, u * u))))
        } else {
            let other = if rare == Side::Outside { Side::Inside } else { Side::Outside };
            let below = |mu: f32| (1.0 - (1.0 - mu * mu) / ratio).max(0.0).sqrt();
            let critical = 1.0 - 1.0 / ratio;
            let beyond = |u: f32| (critical * (1.0 - u * u)).max(0.0).sqrt();
            Form::TwoSided {
                rare: refine(constant, |columns| Grid::new(rows, columns, |row, u| both(rare, row, u * u))),
                dense: refine(constant, |columns| Grid::new(rows, columns, |row, u| both(other, row, below(u * u)))),
                beyond: refine(constant, |columns| {
                    Grid::new(rows, columns, |row, u| [integrate(other, row, beyond(u)).reflect])
                }),
            }
        };
        let mut table = Self { axis, rare, ratio, form, averages: Vec::new() };
        table.averages =
            (0..rows).map(|row| table.row_averages(table.axis.thickness_nm(row, range.min_nm) as f32)).collect();
        table
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

    /// 2 * integral of R mu dmu from each side (outside, inside), over this very table.
    fn row_averages(&self, thickness_nm: f32) -> [[f32; 3]; 2] {
        const STEPS: usize = 256;
        let dense_side = if self.rare == Side::Outside { Side::Inside } else { Side::Outside };
        let (mut rare, mut below, mut beyond) = ([0.0f32; 3], [0.0f32; 3], [0.0f32; 3]);
        let critical = 1.0 - 1.0 / self.ratio;
        for step in 0..STEPS {
            let mu = (step as f32 + 0.5) / STEPS as f32;
            let weight = 2.0 * mu / STEPS as f32;
            let add = |sum: &mut [f32; 3], side: Side, mu: f32| {
                let reflect = self.split(side, mu, thickness_nm).reflect;
                *sum = std::array::from_fn(|c| sum[c] + weight * reflect[c]);
            };
            add(&mut rare, self.rare, mu);
            add(&mut below, dense_side, (1.0 - (1.0 - mu * mu) / self.ratio).max(0.0).sqrt());
            add(&mut beyond, dense_side, (critical * (1.0 - mu * mu)).max(0.0).sqrt());
        }
        let dense: [f32; 3] = match &self.form {
            Form::Lossless { opaque: true, .. } | Form::OneSided(_) => [1.0; 3],
            // What enters one way leaves the other; no table edge is involved.
            Form::Lossless { .. } => rare.map(|rare| 1.0 - (1.0 - rare) / self.ratio),
            Form::TwoSided { .. } => std::array::from_fn(|c| below[c] / self.ratio + critical * beyond[c]),
        };
        if self.rare == Side::Outside { [rare, dense] } else { [dense, rare] }
    }
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

/// Doubles the columns of a one-row table until the old one interpolates the new nodes well enough. The grid of `columns`
/// nodes is contained in that of 2 * columns - 1.
fn refine<const K: usize>(constant: bool, build: impl Fn(usize) -> Grid<K>) -> Grid<K> {
    if !constant {
        return build(COLUMNS_2D);
    }
    let mut columns = COLUMNS_1D[0];
    let mut grid = build(columns);
    let color = |node: [[f32; 4]; K]| Lab::from_linear_srgb([node[0][0], node[0][1], node[0][2]].map(f64::from));
    while columns < COLUMNS_1D[1] {
        let finer = 2 * columns - 1;
        let next = build(finer);
        let worst = (1..finer)
            .step_by(2)
            .map(|i| i as f32 / (finer - 1) as f32)
            .map(|u| delta_e_2000(color(grid.at(u, Place::first())), color(next.at(u, Place::first()))))
            .fold(0.0, f64::max);
        if worst < MIDPOINT_DELTA_E {
            break;
        }
        (columns, grid) = (finer, next);
    }
    grid
}

/// Thickness nodes for a range, fine where fringes are visible.
fn thickness_axis(stack: &Stack, range: Range) -> Axis {
    let Some(layer) = stack.varying.filter(|_| !range.is_constant()) else { return Axis::point() };
    let n = stack.layers[layer].index.range_of_n().1.max(0.2);
    let spacing = 450.0 / (2.0 * n) / PER_FRINGE;
    let (Range { min_nm, max_nm }, coarser, faded) = (range, 0.5 * COARSER_NM / n, 0.5 * FADED_NM / n);
    let spans = [
        (min_nm, max_nm.min(coarser), spacing),
        (min_nm.max(coarser), max_nm.min(faded), 2.0 * spacing),
        (min_nm.max(faded), max_nm, (max_nm - faded) / FADED_ROWS),
    ];
    let used: Vec<_> = spans.into_iter().filter(|(first, last, _)| last - first > 1e-6).collect();
    Axis::new(&used)
}
