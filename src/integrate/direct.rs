//! Next-event estimation: light that comes straight from a source.

use glam::Vec3;

use super::throw::{Find, Throw, Thrower};
use super::vertex::Vertex;
use super::{Strategy, Tally, mis_weight};
use crate::embree::Ray;
use crate::mode::{Lanes, Mode};
use crate::scene::Scene;

/// A surface draws no more than 2^this sources of light at once.
pub const MOST_DRAWS_LOG2: u32 = 2;

/// Light from one drawn source, scattered towards the viewer.
pub(super) struct Direct<L> {
    pub find: Find<L>,
    /// Where it comes from, in the frame of the vertex, and what arrives from there before it is scattered.
    pub wi: Vec3,
    pub arriving: L,
    /// The light counts only if nothing lies on this ray; `None` when that is settled.
    pub shadow: Option<Ray>,
}

impl<L: Lanes> Direct<L> {
    pub const NONE: Self = Self { find: Find::NOTHING, wi: Vec3::Z, arriving: L::ZERO, shadow: None };
}

/// How a source is drawn.
pub(super) struct Draw<'t> {
    pub strategy: Strategy,
    /// The light is that of one draw of so many.
    pub of: u32,
    /// True where others look at the vertex too: they may see what its own path does not.
    pub others_look: bool,
    /// Light paths that may come to the vertex, too.
    pub throw: Option<&'t Throw>,
}

/// Draws a source, and leaves it to the caller to trace the shadow ray where no surface lets light through.
#[inline]
pub(super) fn direct_light<M: Mode>(
    scene: &Scene<M>,
    vertex: &Vertex<M>,
    draw: Draw,
    u: [f32; 3],
    waves: &M::Waves,
    tally: &mut Tally,
) -> Direct<M::Light> {
    let at = vertex.surface.position;
    let Some((emitter, sample)) = scene.stage.lights.sample(at, u) else { return Direct::NONE };
    let Draw { strategy, of, others_look, throw } = draw;
    if strategy == Strategy::Bsdf && !sample.alone {
        return Direct::NONE;
    }

    // Evaluate the surface for that direction.
    let Some(wi) = vertex.local(sample.wi) else { return Direct::NONE };
    let (value, scatter_pdf) = vertex.bsdf.eval(vertex.wo, wi, waves);
    if value.is_black() && !others_look {
        return Direct::NONE;
    }
    let arriving = scene.arriving(&sample.light, waves);
    if arriving.is_black() {
        return Direct::NONE;
    }

    tally.draws += 1;
    // Look at what stands between, where it may let some light pass.
    let origin = vertex.surface.leave(sample.wi);
    let shadow = match sample.distance_m.is_finite() {
        true => Ray::between(origin, at + sample.wi * sample.distance_m),
        false => Ray::new(origin, sample.wi),
    };
    let interior = if wi.z * vertex.wo.z > 0.0 { &vertex.interior } else { &vertex.beyond };
    let (mut passed, mut chance) = (M::Light::ONE, 1.0);
    if scene.lets_through() {
        (passed, chance) = scene.transmittance(&shadow, interior, waves, &mut tally.shadow_rays);
        if passed.is_black() {
            return Direct::NONE;
        }
    } else {
        tally.shadow_rays += 1;
        if sample.distance_m.is_finite() && interior.absorption_per_m != Vec3::ZERO {
            passed = Scene::<M>::left_over(interior, sample.distance_m, waves);
        }
    }

    let alone = sample.alone || strategy == Strategy::Light;
    let pdf = sample.pdf * of as f32;
    let weight = if alone { 1.0 } else { mis_weight(pdf, scatter_pdf * chance) };
    let arriving = arriving * passed * (weight / pdf);

    // Ask how likely light paths are to bring the same.
    let thrown = throw.filter(|_| vertex.throws(sample.wi, false)).zip(sample.lamp(emitter, at));
    let density = thrown.map_or(0.0, |(throw, lamp)| {
        let thrower = Thrower { place: vertex.surface.place.number, at, pdf: scatter_pdf };
        throw.density(scene, &thrower, &lamp, sample.wi, waves)
    });
    let find = Find { light: value * arriving, density };
    Direct { find, wi, arriving, shadow: (!scene.lets_through()).then_some(shadow) }
}
