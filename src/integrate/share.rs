//! Pixels that lie close together share what their paths find.
//!
//! A path sees a first rough surface at x and a matte one at y. What y scatters does not depend on who looks, so every
//! other path of the group may look at it too: from its own x, through one visibility ray, a fraction of what a path costs.
//! Each y is weighed by how likely all the paths together were to find it (the balance heuristic), so the means stay what
//! they were, and indirect light has about 1 / [`GROUP`] of its variance. Bekaert, Sbert & Halton 2002, "Accelerating Path
//! Tracing by Re-Using Paths".
//!
//! Which pairs may be shared depends on the pair alone (matte, unobstructed, seen through the same normal), never on the
//! path that found it: others count as light that only their own path can find.

use glam::Vec3;

use super::path::{Path, SURE_BOUNCES};
use super::vertex::Vertex;
use super::{PathLimits, Strategy, Tally};
use crate::bsdf::Bsdf;
use crate::embree::Ray;
use crate::mode::{Lanes, Mode};
use crate::scene::Scene;

/// Largest number of paths that share.
pub const GROUP: usize = 8;
/// Visibility rays end this share of their length before the surface they look at.
const GAP: f32 = 1e-4;

/// The first surface of a path that can look at what others found.
struct Lookout<'s, M: Mode> {
    x: Vertex<'s, M>,
    /// Of the path up to x.
    throughput: M::Light,
    bounce: u32,
}

/// The matte surface that a path found from its lookout; the path goes on as its tail.
struct Find<'s, M: Mode> {
    y: Vertex<'s, M>,
    /// Light that the path found up to and including y's emission.
    radiance: M::Light,
}

/// Estimates the radiance of a group of paths of neighbouring pixels, into [`Path::radiance`]. They must have the same
/// waves; how many they are changes the noise, not the mean.
///
/// # Panics
/// Never; paths beyond [`GROUP`] are followed alone.
pub fn radiances<M: Mode>(scene: &Scene<M>, paths: &mut [Path<M>], limits: &PathLimits, tally: &mut Tally) {
    let mut lookouts: [Option<Lookout<M>>; GROUP] = std::array::from_fn(|_| None);
    let mut finds: [Option<Find<M>>; GROUP] = std::array::from_fn(|_| None);
    let shared = limits.strategy == Strategy::Shared;
    for (i, path) in paths.iter_mut().enumerate() {
        if shared && i < GROUP {
            (lookouts[i], finds[i]) = head(scene, path, limits, tally);
        } else {
            path.finish(scene, limits, tally);
        }
    }
    if !shared {
        return;
    }
    let mut gathered = [M::Light::ZERO; GROUP];
    for (j, find) in finds.iter().enumerate() {
        if let Some(find) = find {
            hand_out(scene, &lookouts, j, find, paths[j].radiance, &paths[j].waves, &mut gathered, tally);
        }
    }
    for (i, path) in paths.iter_mut().enumerate().take(GROUP) {
        if let Some(find) = &finds[i] {
            path.radiance = find.radiance;
        }
        path.radiance += gathered[i];
    }
}

/// Follows a path to its end. With a find, the path's radiance is what y scatters; without, what the path found.
fn head<'s, M: Mode>(
    scene: &'s Scene<M>,
    path: &mut Path<M>,
    limits: &PathLimits,
    tally: &mut Tally,
) -> (Option<Lookout<'s, M>>, Option<Find<'s, M>>) {
    while let Some(x) = path.arrive(scene, limits, tally) {
        let (throughput, bounce, passed) = (path.throughput, path.bounce, path.passed);
        let can_look = looks_around(&x, path) && bounce + 1 < limits.max_bounces;
        let goes_on = path.scatter(scene, &x, limits, tally);
        if !can_look {
            if goes_on {
                continue;
            }
            return (None, None);
        }
        // Take what x leads to apart from what was found before.
        let mut find = None;
        if goes_on && let Some(y) = path.arrive(scene, limits, tally) {
            let toward_x = y.frame.to_world(y.wo);
            let direct = path.passed == passed && path.was_spread();
            if direct && is_matte(&y) && y.looks_the_same(toward_x) {
                path.importance *= path.throughput.max();
                path.throughput = M::Light::ONE;
                find = Some(std::mem::replace(&mut path.radiance, M::Light::ZERO));
            }
            if path.scatter(scene, &y, limits, tally) {
                path.finish(scene, limits, tally);
            }
            let find = find.map(|radiance| Find { y, radiance });
            return (Some(Lookout { x, throughput, bounce }), find);
        }
        return (Some(Lookout { x, throughput, bounce }), None);
    }
    (None, None)
}

/// True where a path scatters into all directions of its side, in clear air, and no roulette has yet been played.
fn looks_around<M: Mode>(x: &Vertex<M>, path: &Path<M>) -> bool {
    let scatters = match &x.bsdf {
        Bsdf::Diffuse(_) | Bsdf::CoatedDiffuse(_) => true,
        Bsdf::Conductor(_) => !x.bsdf.is_delta(),
        Bsdf::Black | Bsdf::Dielectric(_) => false,
    };
    scatters && path.bounce < SURE_BOUNCES && !path.collapsed && x.absorption_per_m == Vec3::ZERO
}

fn is_matte<M: Mode>(y: &Vertex<M>) -> bool {
    matches!(y.bsdf, Bsdf::Diffuse(_))
}

/// Gives all lookouts their part of the `scattered` radiance of the j-th find.
#[allow(clippy::too_many_arguments)]
fn hand_out<M: Mode>(
    scene: &Scene<M>,
    lookouts: &[Option<Lookout<M>>; GROUP],
    j: usize,
    find: &Find<M>,
    scattered: M::Light,
    waves: &M::Waves,
    gathered: &mut [M::Light; GROUP],
    tally: &mut Tally,
) {
    let y = &find.y.surface;
    let bounce = lookouts[j].as_ref().map(|own| own.bounce);
    let mut seen = [M::Light::ZERO; GROUP];
    let mut density = 0.0;
    for (k, lookout) in lookouts.iter().enumerate() {
        let Some(Lookout { x, throughput, .. }) = lookout.as_ref().filter(|l| Some(l.bounce) == bounce) else {
            continue;
        };
        let offset = y.position - x.surface.position;
        let distance2 = offset.length_squared();
        let distance_m = distance2.sqrt();
        let wi = offset * (1.0 / distance_m);
        if !find.y.looks_the_same(-wi) {
            continue;
        }
        let Some(local) = x.local(wi) else { continue };
        let (value, pdf) = x.bsdf.eval(x.wo, local, waves);
        if pdf <= 0.0 {
            continue;
        }
        if k != j {
            let origin = x.surface.leave(wi);
            tally.shadow_rays += 1;
            if scene.stage.occluded(&Ray { tfar: distance_m * (1.0 - GAP), ..Ray::new(origin, wi) }) {
                continue;
            }
        }
        // Per area of y instead of solid angle at x.
        let geometry = y.ng.dot(wi).abs() / distance2;
        density += pdf * geometry;
        seen[k] = *throughput * value * geometry;
    }
    if density > 0.0 && density.is_finite() {
        let scale = 1.0 / density;
        for (sum, part) in gathered.iter_mut().zip(seen) {
            *sum += part * scattered * scale;
        }
    }
}
