//! The cheapest rung: Fresnel's equations for two lossless media.

use super::quadrature::gauss_legendre;
use super::stack::{Side, Split, Stack};
use crate::color::NOMINAL_NM;

/// A bare dielectric interface; dispersive media are taken at the d line.
#[derive(Clone, Debug)]
pub(super) struct Bare {
    outside: f32,
    base: f32,
    /// Outside, inside.
    averages: [f32; 2],
}

impl Bare {
    /// None where a medium absorbs: its reflectance is coloured and phase-shifted, which a table does better.
    pub(super) fn new(stack: &Stack) -> Option<Self> {
        if stack.base.max_k() > 0.0 || stack.outside.max_k() > 0.0 {
            return None;
        }
        let (outside, base) = (stack.outside.at(NOMINAL_NM).re as f32, stack.base.at(NOMINAL_NM).re as f32);
        let mut bare = Self { outside, base, averages: [0.0; 2] };
        let rare = if outside <= base { Side::Outside } else { Side::Inside };
        let mean: f32 = gauss_legendre()
            .iter()
            .map(|&(mu, w)| 2.0 * (w * mu) as f32 * bare.split(rare, mu as f32).reflect[0])
            .sum();
        let ratio = (outside.min(base) / outside.max(base)).powi(2);
        let dense = 1.0 - ratio * (1.0 - mean);
        bare.averages = if rare == Side::Outside { [mean, dense] } else { [dense, mean] };
        Some(bare)
    }

    #[inline(always)]
    pub(super) fn split(&self, side: Side, cos_i: f32) -> Split<[f32; 3]> {
        let (n0, n2) = if side == Side::Outside { (self.outside, self.base) } else { (self.base, self.outside) };
        // mu = 0 would be 0/0 where the indices are equal.
        let q0 = n0 * cos_i.abs().clamp(1e-6, 1.0);
        // Beyond the critical angle q2 = 0 gives R = 1 by itself.
        let q2 = ((n2 - n0) * (n2 + n0) + q0 * q0).max(0.0).sqrt();
        let s = (q0 - q2) / (q0 + q2);
        let (a, b) = (n2 * n2 * q0, n0 * n0 * q2);
        let p = (a - b) / (a + b);
        let reflect = 0.5 * (s * s + p * p);
        Split { reflect: [reflect; 3], transmit: [1.0 - reflect; 3] }
    }

    #[inline(always)]
    pub(super) fn average(&self, side: Side) -> [f32; 3] {
        [self.averages[(side == Side::Inside) as usize]; 3]
    }
}
