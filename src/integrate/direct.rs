//! Next-event estimation: light that comes straight from a source.

use super::vertex::Vertex;
use super::{PathLimits, Strategy, Tally, mis_weight};
use crate::embree::Ray;
use crate::mode::{Lanes, Mode};
use crate::scene::Scene;

/// Shadow rays end this share of their length before the light's own surface.
const SHADOW_GAP: f32 = 1e-4;

/// Light from one drawn source, scattered towards the viewer.
pub(super) struct Direct<L> {
    pub light: L,
    /// The light counts only if nothing lies on this ray; `None` when that is settled.
    pub shadow: Option<Ray>,
}

impl<L: Lanes> Direct<L> {
    pub const NONE: Self = Self { light: L::ZERO, shadow: None };
}

/// Draws a source, and leaves it to the caller to trace the shadow ray where no surface lets light through.
#[inline]
pub(super) fn direct_light<M: Mode>(
    scene: &Scene<M>,
    vertex: &Vertex<M>,
    u: [f32; 3],
    waves: &M::Waves,
    limits: &PathLimits,
    tally: &mut Tally,
) -> Direct<M::Light> {
    let Some(sample) = scene.stage.lights.sample(vertex.surface.position, u) else { return Direct::NONE };
    if limits.strategy == Strategy::Bsdf && !sample.alone {
        return Direct::NONE;
    }

    // Evaluate the surface for that direction.
    let Some(wi) = vertex.local(sample.wi) else { return Direct::NONE };
    let (value, scatter_pdf) = vertex.bsdf.eval(vertex.wo, wi, waves);
    if value.is_black() {
        return Direct::NONE;
    }
    let arriving = scene.arriving(&sample.light, waves);
    if arriving.is_black() {
        return Direct::NONE;
    }

    // Look at what stands between, where it may let some light pass.
    let origin = vertex.surface.leave(sample.wi);
    let tfar = sample.distance_m * (1.0 - SHADOW_GAP);
    let shadow = Ray { tfar, ..Ray::new(origin, sample.wi) };
    let interior = if wi.z * vertex.wo.z > 0.0 { &vertex.interior } else { &vertex.beyond };
    let (mut passed, mut chance) = (M::Light::ONE, 1.0);
    if scene.lets_through() {
        (passed, chance) = scene.transmittance(&shadow, interior, waves, &mut tally.shadow_rays);
        if passed.is_black() {
            return Direct::NONE;
        }
    } else {
        tally.shadow_rays += 1;
        if sample.distance_m.is_finite() && interior.absorption_per_m != glam::Vec3::ZERO {
            passed = Scene::<M>::left_over(interior, sample.distance_m, waves);
        }
    }

    let alone = sample.alone || limits.strategy == Strategy::Light;
    let weight = if alone { 1.0 } else { mis_weight(sample.pdf, scatter_pdf * chance) };
    let light = value * arriving * passed * (weight / sample.pdf);
    Direct { light, shadow: (!scene.lets_through()).then_some(shadow) }
}
