//! Light that the camera sees directly.

use super::Tally;
use crate::embree::{BATCH, Hits, Ray};
use crate::mode::{Lanes, Mode};
use crate::scene::Scene;

/// What the first surface along each ray emits, or what comes from beyond the scene: the part of the radiance that
/// blind paths leave out ([`Path::new`](super::Path::new)).
pub fn seen_light<M: Mode>(
    scene: &Scene<M>,
    rays: &[Ray; BATCH],
    waves: &M::Waves,
    tally: &mut Tally,
) -> [M::Light; BATCH] {
    tally.rays += BATCH as u64;
    let mut hits = Hits::default();
    scene.stage.intersect_batch(rays, u8::MAX, &mut hits);
    std::array::from_fn(|i| match scene.surface(&hits, i) {
        Some(surface) if surface.emitter != u32::MAX => scene.emitted(&surface, -rays[i].dir.dot(surface.ng), waves),
        Some(_) => M::Light::ZERO,
        None => {
            let mut sum = M::Light::ZERO;
            scene.escape(rays[i].origin, rays[i].dir, waves, |light, _| sum += light);
            sum
        }
    })
}
