//! Tables over a cosine and a thickness, interpolated linearly.

use glam::Vec4;
use rayon::prelude::*;

use super::lanes::cell;

/// Rows of thickness, each a run of cosine nodes; a node holds K groups of three channels and padding. One look-up reads two
/// adjacent nodes of two rows.
#[derive(Clone, Debug)]
pub(super) struct Grid<const K: usize> {
    nodes: Vec<[Vec4; K]>,
    /// Nodes per row, at least 2.
    columns: u32,
    /// Columns - 1.
    span: f32,
}

/// A place on a thickness axis.
#[derive(Clone, Copy, Debug)]
pub(super) enum Place {
    /// The one row of an axis that has no other.
    Only,
    /// The share `t` of the way from a row to the next.
    Between { row: u32, t: f32 },
}

impl Place {
    /// Linear interpolation of a value per row.
    #[inline(always)]
    pub(super) fn between(self, value: impl Fn(usize) -> [f32; 3]) -> [f32; 3] {
        let Self::Between { row, t } = self else { return value(0) };
        let (low, high) = (value(row as usize), value(row as usize + 1));
        std::array::from_fn(|i| low[i] + t * (high[i] - low[i]))
    }
}

/// Thickness nodes in up to [`RUNS`] runs of equal spacing, each run wider than the one before: fringes fade as the path
/// difference grows past the coherence of the eye's own channels, about 10 um. Together in vectors, so that a place is found
/// without a branch; runs that are not used have no length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    first_nm: Vec4,
    length_nm: Vec4,
    per_nm: Vec4,
    /// Rows - 1.
    span: f32,
}

const RUNS: usize = 4;

impl Axis {
    /// One row: the thickness does not vary.
    pub(super) fn point() -> Self {
        Self { first_nm: Vec4::ZERO, length_nm: Vec4::ZERO, per_nm: Vec4::ZERO, span: 0.0 }
    }

    /// Consecutive runs of (first nm, last nm, spacing nm), at most [`RUNS`]; spacings are shrunk to fit.
    pub(super) fn new(spans: &[(f64, f64, f64)]) -> Self {
        let mut axis = Self::point();
        for (run, &(first, last, spacing)) in spans.iter().take(RUNS).enumerate() {
            let intervals = ((last - first) / spacing).ceil().max(1.0);
            axis.first_nm[run] = first as f32;
            axis.length_nm[run] = (last - first) as f32;
            axis.per_nm[run] = (intervals / (last - first)) as f32;
            axis.span += intervals as f32;
        }
        axis
    }

    pub(super) fn rows(&self) -> usize {
        self.span as usize + 1
    }

    /// The thickness of a row in nm; `constant_nm` on a single-row axis.
    pub(super) fn thickness_nm(&self, row: usize, constant_nm: f64) -> f64 {
        let mut row = row as f64;
        for run in 0..RUNS {
            let [first_nm, length_nm, per_nm] = [self.first_nm, self.length_nm, self.per_nm].map(|v| f64::from(v[run]));
            let intervals = (length_nm * per_nm).round();
            if intervals > 0.0 && row <= intervals {
                return first_nm + row / per_nm;
            }
            row -= intervals;
        }
        constant_nm
    }

    #[inline(always)]
    pub(super) fn place(&self, thickness_nm: f32) -> Place {
        if self.span == 0.0 {
            return Place::Only;
        }
        // Runs before the thickness count whole, those after it not at all.
        let within_nm = (Vec4::splat(thickness_nm) - self.first_nm).max(Vec4::ZERO).min(self.length_nm);
        let (row, t) = cell(within_nm.dot(self.per_nm), self.span);
        Place::Between { row, t }
    }
}

impl<const K: usize> Grid<K> {
    /// Fills the table in parallel; `value(row, u)` for u = 0..1 along the cosine axis.
    pub(super) fn new(rows: usize, columns: usize, value: impl Fn(usize, f32) -> [[f32; 3]; K] + Sync) -> Self {
        let u = |index: usize| (index % columns) as f32 / (columns - 1) as f32;
        let node = |index: usize| value(index / columns, u(index)).map(pad);
        let nodes = (0..rows * columns).into_par_iter().with_min_len(16).map(node).collect();
        Self { nodes, columns: columns as u32, span: (columns - 1) as f32 }
    }

    /// A one-row table with a new node between every two.
    pub(super) fn refined(&self, value: impl Fn(f32) -> [[f32; 3]; K] + Sync) -> Self {
        let columns = 2 * self.nodes.len() - 1;
        let between = |index: usize| value((2 * index + 1) as f32 / (columns - 1) as f32).map(pad);
        let new: Vec<_> = (0..self.nodes.len() - 1).into_par_iter().with_min_len(16).map(between).collect();
        let mut nodes = Vec::with_capacity(columns);
        for (old, new) in self.nodes.iter().zip(new) {
            nodes.extend([*old, new]);
        }
        nodes.extend(self.nodes.last());
        Self { nodes, columns: columns as u32, span: (columns - 1) as f32 }
    }

    /// Nodes per row.
    pub(super) fn columns(&self) -> usize {
        self.columns as usize
    }

    /// For each row, the integral over u of `weight` times the first group, linear between nodes.
    pub(super) fn integrals(&self, weight: impl Fn(f64) -> f64) -> Vec<[f32; 3]> {
        // The integral of weight times each node's hat, by Simpson's rule on either side.
        let span = f64::from(self.span);
        let hat = |node: usize, towards: f64| {
            let u = node as f64 / span;
            if !(0.0..=1.0).contains(&(u + towards / span)) {
                return 0.0;
            }
            (weight(u) + 2.0 * weight(u + 0.5 * towards / span)) / (6.0 * span)
        };
        let weights: Vec<f32> = (0..self.columns()).map(|node| (hat(node, -1.0) + hat(node, 1.0)) as f32).collect();
        let sum = |row: &[[Vec4; K]]| {
            row.iter()
                .zip(&weights)
                .fold([0.0; 3], |sum: [f32; 3], (node, w)| std::array::from_fn(|c| sum[c] + w * node[0][c]))
        };
        self.nodes.chunks(self.columns()).map(sum).collect()
    }

    /// The groups at u (0..1) and a place on the thickness axis.
    #[inline(always)]
    pub(super) fn at(&self, u: f32, place: Place) -> [Vec4; K] {
        let (low, s) = cell(u * self.span, self.span);
        let Place::Between { row, t } = place else { return pair(&self.nodes, low as usize, s) };
        let start = (row * self.columns + low) as usize;
        mix(pair(&self.nodes, start, s), pair(&self.nodes, start + self.columns as usize, s), t)
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice())
    }
}

fn pad([a, b, c]: [f32; 3]) -> Vec4 {
    Vec4::new(a, b, c, 0.0)
}

#[inline(always)]
fn pair<const K: usize>(nodes: &[[Vec4; K]], start: usize, s: f32) -> [Vec4; K] {
    match nodes.get(start..start + 2) {
        Some([a, b]) => mix(*a, *b, s),
        _ => [Vec4::ZERO; K],
    }
}

#[inline(always)]
fn mix<const K: usize>(a: [Vec4; K], b: [Vec4; K], t: f32) -> [Vec4; K] {
    // Fused where the processor can: elsewhere a fused product is a slow library call.
    if cfg!(target_feature = "fma") {
        std::array::from_fn(|k| (b[k] - a[k]).mul_add(Vec4::splat(t), a[k]))
    } else {
        std::array::from_fn(|k| a[k] + t * (b[k] - a[k]))
    }
}
