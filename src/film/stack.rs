//! What a coated surface is made of.

use crate::color::{IndexCurve, NOMINAL_NM};

/// Light reflected from a surface and transmitted into the medium behind it, as shares of what arrives. What is missing to
/// 1 was absorbed in the layers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Split<L> {
    pub reflect: L,
    pub transmit: L,
}

/// Where the light comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The ambient side: it meets the outermost layer first.
    Outside,
    /// The base.
    Inside,
}

/// One homogeneous layer.
#[derive(Clone, Debug)]
pub struct Layer {
    pub index: IndexCurve,
    pub thickness_nm: f64,
}

/// A base under any number of layers.
#[derive(Clone, Debug)]
pub struct Stack {
    pub outside: IndexCurve,
    /// Outermost first; none is a bare surface.
    pub layers: Vec<Layer>,
    pub base: IndexCurve,
    /// The one layer whose thickness varies over the surface.
    pub varying: Option<usize>,
    /// Coverage, 0..1: the share of the surface that carries the layers. The rest is bare.
    pub weight: f64,
}

/// Thicknesses of the varying layer in use, in nm; equal when it is constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    pub min_nm: f64,
    pub max_nm: f64,
}

/// s and p polarised light, kept apart.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Polarised {
    pub s: Split<f64>,
    pub p: Split<f64>,
}

impl Polarised {
    /// Unpolarised light.
    pub fn mean(&self) -> Split<f64> {
        Split { reflect: 0.5 * (self.s.reflect + self.p.reflect), transmit: 0.5 * (self.s.transmit + self.p.transmit) }
    }
}

/// An extinction coefficient above which nothing travels far enough inside a base to come back: 1/e in 0.05 mm.
const OPAQUE_K: f64 = 1e-3;

impl Stack {
    /// A surface without layers.
    pub fn bare(outside: IndexCurve, base: IndexCurve) -> Self {
        Self { outside, layers: Vec::new(), base, varying: None, weight: 1.0 }
    }

    /// Thickness of a layer in nm, where `thickness_nm` is that of the varying one. Never negative: a noise or an image may
    /// undershoot.
    pub(super) fn thickness(&self, layer: usize, thickness_nm: f64) -> f64 {
        let nm = if self.varying == Some(layer) { thickness_nm } else { self.layers[layer].thickness_nm };
        nm.max(0.0)
    }

    /// True when no layer absorbs at any wavelength: what is not reflected enters the base.
    pub(super) fn lossless_layers(&self) -> bool {
        self.layers.iter().all(|layer| layer.index.max_k() == 0.0)
    }

    /// The side with the smaller index (at the d line), whose cosine covers every direction in which light gets through;
    /// outside for metals.
    pub(super) fn rarer_side(&self) -> Side {
        let [outside, base] = [&self.outside, &self.base].map(|medium| medium.at(NOMINAL_NM).re);
        if self.opaque_base() || outside <= base { Side::Outside } else { Side::Inside }
    }

    /// True when light inside the base never reaches the surface: metals.
    pub(super) fn opaque_base(&self) -> bool {
        self.base.max_k() > OPAQUE_K
    }
}

impl Range {
    pub fn constant(nm: f64) -> Self {
        Self { min_nm: nm, max_nm: nm }
    }

    /// The range that a stack really uses: a point where no layer varies.
    pub(super) fn of(self, stack: &Stack) -> Self {
        match stack.varying {
            None => Self::constant(0.0),
            Some(_) => Self { min_nm: self.min_nm.max(0.0), max_nm: self.max_nm.max(self.min_nm).max(0.0) },
        }
    }

    pub fn is_constant(self) -> bool {
        self.max_nm - self.min_nm < 1e-3
    }
}
