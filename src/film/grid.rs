//! Tables over a cosine and a thickness, interpolated linearly.

use rayon::prelude::*;

/// Rows of thickness, each a run of cosine nodes; a node holds K groups of three channels and padding. One look-up reads two
/// adjacent nodes of two rows.
#[derive(Clone, Debug)]
pub(super) struct Grid<const K: usize> {
    nodes: Vec<[[f32; 4]; K]>,
    /// Nodes per row, at least 2.
    columns: usize,
}

/// A place on a thickness axis: between `row` and `row + 1`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    row: usize,
    t: f32,
}

impl Place {
    /// The first row.
    pub(super) fn first() -> Self {
        Self { row: 0, t: 0.0 }
    }

    /// Linear interpolation of a value per row.
    #[inline(always)]
    pub(super) fn between(self, value: impl Fn(usize) -> [f32; 3]) -> [f32; 3] {
        let low = value(self.row);
        if self.t == 0.0 {
            return low;
        }
        let high = value(self.row + 1);
        std::array::from_fn(|i| low[i] + self.t * (high[i] - low[i]))
    }
}

/// Thickness nodes in runs of equal spacing, each run wider than the one before: fringes fade as the path difference grows
/// past the coherence of the eye's own channels, about 10 um.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    runs: Vec<Run>,
    rows: usize,
}

#[derive(Clone, Copy, Debug)]
struct Run {
    first_nm: f32,
    per_nm: f32,
    first_row: usize,
    last_row: usize,
}

impl Axis {
    /// One row: the thickness does not vary.
    pub(super) fn point() -> Self {
        Self { runs: Vec::new(), rows: 1 }
    }

    /// Consecutive runs of (first nm, last nm, spacing nm); spacings are shrunk to fit.
    pub(super) fn new(spans: &[(f64, f64, f64)]) -> Self {
        let (mut runs, mut row) = (Vec::new(), 0);
        for &(first, last, spacing) in spans {
            let intervals = ((last - first) / spacing).ceil().max(1.0);
            let last_row = row + intervals as usize;
            runs.push(Run {
                first_nm: first as f32,
                per_nm: (intervals / (last - first)) as f32,
                first_row: row,
                last_row,
            });
            row = last_row;
        }
        Self { runs, rows: row + 1 }
    }

    pub(super) fn rows(&self) -> usize {
        self.rows
    }

    /// The thickness of a row in nm; `constant_nm` on a single-row axis.
    pub(super) fn thickness_nm(&self, row: usize, constant_nm: f64) -> f64 {
        match self.runs.iter().find(|run| row <= run.last_row) {
            Some(run) => f64::from(run.first_nm) + (row - run.first_row) as f64 / f64::from(run.per_nm),
            None => constant_nm,
        }
    }

    #[inline(always)]
    pub(super) fn place(&self, thickness_nm: f32) -> Place {
        let mut runs = self.runs.as_slice();
        while let [_, rest @ ..] = runs {
            match rest.first() {
                Some(next) if thickness_nm >= next.first_nm => runs = rest,
                _ => break,
            }
        }
        match runs.first() {
            None => Place { row: 0, t: 0.0 },
            Some(run) => {
                let span = (run.last_row - run.first_row) as f32;
                let x = ((thickness_nm - run.first_nm) * run.per_nm).clamp(0.0, span);
                let low = (x as usize).min(run.last_row - run.first_row - 1);
                Place { row: run.first_row + low, t: x - low as f32 }
            }
        }
    }
}

impl<const K: usize> Grid<K> {
    /// Fills the table in parallel; `value(row, u)` for u = 0..1 along the cosine axis.
    pub(super) fn new(rows: usize, columns: usize, value: impl Fn(usize, f32) -> [[f32; 3]; K] + Sync) -> Self {
        let pad = |[a, b, c]: [f32; 3]| [a, b, c, 0.0];
        let node = |index: usize| {
            let u = (index % columns) as f32 / (columns - 1) as f32;
            value(index / columns, u).map(pad)
        };
        let nodes = (0..rows * columns).into_par_iter().with_min_len(64).map(node).collect();
        Self { nodes, columns }
    }

    /// The groups at u (0..1) and a place on the thickness axis.
    #[inline(always)]
    pub(super) fn at(&self, u: f32, place: Place) -> [[f32; 4]; K] {
        let x = u.clamp(0.0, 1.0) * (self.columns - 1) as f32;
        let low = (x as usize).min(self.columns - 2);
        let s = x - low as f32;
        let start = place.row * self.columns + low;
        let below = pair(&self.nodes, start, s);
        if place.t == 0.0 {
            return below;
        }
        mix(below, pair(&self.nodes, start + self.columns, s), place.t)
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice())
    }
}

#[inline(always)]
fn pair<const K: usize>(nodes: &[[[f32; 4]; K]], start: usize, s: f32) -> [[f32; 4]; K] {
    match nodes.get(start..start + 2) {
        Some([a, b]) => mix(*a, *b, s),
        _ => [[0.0; 4]; K],
    }
}

#[inline(always)]
fn mix<const K: usize>(a: [[f32; 4]; K], b: [[f32; 4]; K], t: f32) -> [[f32; 4]; K] {
    std::array::from_fn(|k| std::array::from_fn(|i| a[k][i] + t * (b[k][i] - a[k][i])))
}
