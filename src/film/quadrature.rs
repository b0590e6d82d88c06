//! Rules of integration: over wavelength under a sensor, and over the cosine of the hemisphere.

use std::sync::LazyLock;

use crate::color::{MAX_NM, MIN_NM, Sensor};

use super::spectral::{Gathered, SpectralFilm};
use super::stack::{Side, Stack};

/// Wavelengths per block: four vectors of four.
const WIDTH: usize = 16;

/// Every 1 nm.
pub(super) const ONE_NM: usize = 401;

/// Points of the hemisphere rule.
const GAUSS: usize = 16;

/// Equally spaced wavelengths with the weights of three channels; each channel's weights sum to 1.
pub(super) struct Spectral {
    blocks: Vec<Block>,
}

struct Block {
    nm: [f32; WIDTH],
    weights: [[f32; WIDTH]; 3],
}

impl Spectral {
    /// A rule of `count` wavelengths, 380 and 780 nm included.
    pub(super) fn new(sensor: &Sensor, count: usize) -> Self {
        let nodes = nodes(sensor, count);
        let blocks = nodes
            .chunks(WIDTH)
            .map(|chunk| {
                // Lanes past the end repeat a wavelength with no weight.
                let node = |i: usize| chunk.get(i).copied().unwrap_or((MAX_NM, [0.0; 3]));
                Block {
                    nm: std::array::from_fn(|i| node(i).0 as f32),
                    weights: std::array::from_fn(|c| std::array::from_fn(|i| node(i).1[c] as f32)),
                }
            })
            .collect();
        Self { blocks }
    }

    /// How many wavelengths integrate a stack's fringes: phase moves by 2 pi OPD step / lambda^2 between samples. Measured
    /// below 0.1 CIEDE2000 at each limit, and far below that on transparent bases. `thickness_nm` is that of the varying
    /// layer.
    pub(super) fn count(stack: &Stack, thickness_nm: f64) -> usize {
        let path_nm: f64 = (0..stack.layers.len())
            .map(|layer| 2.0 * stack.thickness(layer, thickness_nm) * stack.layers[layer].index.range_of_n().1)
            .sum();
        // Whole blocks, but for the 1 nm of the standard observer itself.
        match path_nm {
            ..800.0 => 48,
            ..3_500.0 => 80,
            ..8_000.0 => 208,
            ..20_000.0 => ONE_NM,
            ..50_000.0 => 2 * ONE_NM - 1,
            _ => 4 * ONE_NM - 3,
        }
    }

    /// Looks the media up at this rule's wavelengths.
    pub(super) fn gather<'a>(&'a self, film: &'a SpectralFilm) -> Integrand<'a> {
        Integrand { rule: self, media: self.blocks.iter().map(|block| film.gather(&block.nm)).collect() }
    }
}

/// Equally spaced wavelengths in nm, 380 and 780 included, and the weights of the three channels; each channel's sum to 1.
pub(super) fn nodes(sensor: &Sensor, count: usize) -> Vec<(f64, [f64; 3])> {
    let step_nm = (MAX_NM - MIN_NM) / (count - 1) as f64;
    let nm = |i: usize| MIN_NM + step_nm * i as f64;
    let nodes: Vec<_> = (0..count).map(|i| (nm(i), sensor.reflectance_weight(nm(i)))).collect();
    let sums: [f64; 3] = std::array::from_fn(|c| nodes.iter().map(|node| node.1[c]).sum());
    nodes.into_iter().map(|(nm, weights)| (nm, std::array::from_fn(|c| weights[c] / sums[c]))).collect()
}

/// A stack at the wavelengths of a rule.
pub(super) struct Integrand<'a> {
    rule: &'a Spectral,
    media: Vec<Gathered<'a, WIDTH>>,
}

impl Integrand<'_> {
    /// Linear sRGB of R, unclamped.
    pub(super) fn reflect(&self, side: Side, cos_i: f32, thickness_nm: f32) -> [f32; 3] {
        // Sums stay in lanes until the end: the compiler does not reorder a float reduction.
        let mut sums = [[0.0f32; WIDTH]; 3];
        for (block, media) in self.rule.blocks.iter().zip(&self.media) {
            let reflect = media.split(side, cos_i, thickness_nm).reflect;
            for (sum, weights) in sums.iter_mut().zip(&block.weights) {
                accumulate(sum, weights, &reflect);
            }
        }
        sums.map(|lanes| lanes.iter().sum())
    }

    /// Linear sRGB of R and T, unclamped.
    pub(super) fn both(&self, side: Side, cos_i: f32, thickness_nm: f32) -> [[f32; 3]; 2] {
        let mut sums = [[[0.0f32; WIDTH]; 3]; 2];
        for (block, media) in self.rule.blocks.iter().zip(&self.media) {
            let split = media.split(side, cos_i, thickness_nm);
            for (sums, values) in sums.iter_mut().zip([&split.reflect, &split.transmit]) {
                for (sum, weights) in sums.iter_mut().zip(&block.weights) {
                    accumulate(sum, weights, values);
                }
            }
        }
        sums.map(|sums| sums.map(|lanes| lanes.iter().sum()))
    }
}

#[inline(always)]
fn accumulate(sums: &mut [f32; WIDTH], weights: &[f32; WIDTH], values: &[f32; WIDTH]) {
    for ((sum, weight), value) in sums.iter_mut().zip(weights).zip(values) {
        *sum += weight * value;
    }
}

/// Gauss-Legendre points and weights on [0, 1].
pub(super) fn gauss_legendre() -> &'static [(f64, f64); GAUSS] {
    static RULE: LazyLock<[(f64, f64); GAUSS]> = LazyLock::new(|| std::array::from_fn(point));
    &RULE
}

/// The `i`-th root of the Legendre polynomial by Newton's method (Numerical Recipes, 4.6).
fn point(i: usize) -> (f64, f64) {
    let n = GAUSS as f64;
    let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n + 0.5)).cos();
    let mut slope = 1.0;
    for _ in 0..20 {
        let (mut previous, mut value) = (1.0, x);
        for k in 2..=GAUSS {
            let k = k as f64;
            (previous, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * previous) / k);
        }
        slope = n * (x * value - previous) / (x * x - 1.0);
        x -= value / slope;
    }
    (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
}
