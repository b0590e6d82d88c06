//! Light that bounces between microfacets several times, which the single-scattering lobes lose.
//!
//! Kulla & Conty 2017, "Revisiting Physically Based Shading at Imageworks": a broad lobe gives back exactly what is
//! missing from every direction, coloured by what the facets reflect on average. Reciprocal, and white stays white.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::dielectric::refract;
use super::microfacet::Microfacets;
use crate::document::Distribution;
use crate::film::Side;
use crate::math::Sampler;

/// Roughnesses that a table holds where an image varies them.
const ALPHAS: usize = 9;
/// Cosines per roughness, squares of even steps: losses change fastest near grazing.
const COSINES: usize = 32;
/// Facets per entry. The integrand varies little, and the points are stratified: errors stay below 0.001.
const FACETS: u32 = 512;
/// Losses below this share of the light are left alone.
const NEGLIGIBLE: f32 = 0.002;

/// Share of light that single scattering loses, over roughness and cosine, seen from one side of a surface.
pub struct Missing {
    /// Row by row, `COSINES` entries each; one row where the roughness is constant, else `ALPHAS` from 0 to 1.
    shares: Vec<f32>,
    /// Cosine-weighted mean of each row.
    means: Vec<f32>,
}

/// What a facet does with light: (side, cosine) -> (reflected, transmitted).
type Facet<'a> = &'a dyn Fn(Side, f32) -> (f32, f32);

impl Missing {
    /// For a constant `alpha`, or for all where `None`. `eta` is the index inside over outside of a transparent body;
    /// `None` for metals. What facets absorb is not counted as missing. `None` where nothing worth mentioning is lost.
    pub fn new(
        distribution: Distribution,
        alpha: Option<f32>,
        side: Side,
        eta: Option<f32>,
        facet: Facet,
    ) -> Option<Self> {
        let alphas: Vec<f32> = match alpha {
            Some(alpha) => vec![alpha],
            None => (0..ALPHAS).map(|i| i as f32 / (ALPHAS - 1) as f32).collect(),
        };
        let (mut shares, mut means) = (Vec::new(), Vec::new());
        for alpha in alphas {
            let microfacets = Microfacets { distribution, alpha };
            let row: Vec<f32> = (0..COSINES).map(|i| lost(&microfacets, cosine(i), side, eta, facet)).collect();
            // 2 Int m mu dmu of what `share` will interpolate, by the midpoint rule.
            let steps = 256;
            let midpoints = (0..steps).map(|i| (i as f32 + 0.5) / steps as f32);
            means.push(midpoints.map(|mu| 2.0 * mu * interpolate(&row, mu)).sum::<f32>() / steps as f32);
            shares.extend(row);
        }
        let missing = Self { shares, means };
        missing.means.iter().any(|&mean| mean > NEGLIGIBLE).then_some(missing)
    }

    /// Share lost from a direction at this (positive) cosine.
    #[inline]
    pub fn share(&self, alpha: f32, cos: f32) -> f32 {
        let (row, t) = self.row(alpha);
        let at = |row: usize| interpolate(&self.shares[row * COSINES..(row + 1) * COSINES], cos);
        if t == 0.0 { at(row) } else { at(row) + (at(row + 1) - at(row)) * t }
    }

    /// Share lost from diffuse light.
    #[inline]
    pub fn mean(&self, alpha: f32) -> f32 {
        let (row, t) = self.row(alpha);
        let low = self.means[row];
        let mean = if t == 0.0 { low } else { low + (self.means[row + 1] - low) * t };
        mean.max(1e-6)
    }

    #[inline]
    fn row(&self, alpha: f32) -> (usize, f32) {
        if self.means.len() == 1 {
            return (0, 0.0);
        }
        let x = alpha.clamp(0.0, 1.0) * (ALPHAS - 1) as f32;
        let row = (x as usize).min(ALPHAS - 2);
        (row, x - row as f32)
    }

    /// Share of the broad lobe's light per steradian towards `cos_i`, cosine included: in proportion to what is missing
    /// there, which makes the lobe reciprocal.
    #[inline]
    pub fn lobe(&self, alpha: f32, cos_i: f32) -> f32 {
        self.share(alpha, cos_i) * cos_i * FRAC_1_PI / self.mean(alpha)
    }
}

/// Value of a row at a cosine.
#[inline]
fn interpolate(row: &[f32], cos: f32) -> f32 {
    let x = cos.clamp(0.0, 1.0).sqrt() * (COSINES - 1) as f32;
    let i = (x as usize).min(COSINES - 2);
    row[i] + (row[i + 1] - row[i]) * (x - i as f32)
}

fn cosine(i: usize) -> f32 {
    // Looking exactly along the surface has no visible facets.
    (i as f32 / (COSINES - 1) as f32).powi(2).max(1e-3)
}

/// Light that visible facets send where other facets stand in the way.
fn lost(microfacets: &Microfacets, cos: f32, side: Side, eta: Option<f32>, facet: Facet) -> f32 {
    if microfacets.is_smooth() {
        return 0.0;
    }
    let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let g1 = microfacets.g1(wo);
    let across = eta.map(|eta| if side == Side::Outside { eta } else { 1.0 / eta });
    let mut lost = 0.0;
    for index in 0..FACETS {
        let [u, v, ..] = Sampler::new(0, index, 0).next_4d();
        let h = microfacets.sample_visible(wo, [u, v]);
        let cos_h = wo.dot(h).max(0.0);
        let (reflect, transmit) = facet(side, cos_h);
        let up = h * (2.0 * cos_h) - wo;
        let reflected = if up.z > 0.0 { microfacets.g2_reflect(wo, up) / g1 } else { 0.0 };
        lost += reflect * (1.0 - reflected);
        if let Some(across) = across {
            let passed = match refract(wo, h, cos_h, across) {
                Some(down) if down.z < 0.0 => microfacets.g2_transmit(wo, down) / g1,
                _ => 0.0,
            };
            lost += transmit * (1.0 - passed);
        }
    }
    (lost / FACETS as f32).clamp(0.0, 1.0)
}
