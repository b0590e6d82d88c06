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
use crate::embree::{BATCH, Ray};
use crate::mode::{Lanes, Mode};
use crate::scene::Scene;

/// Largest number of paths that share.
pub const GROUP: usize = BATCH;
/// Visibility rays end this share of their length before the surface they look at.
const GAP: f32 = 1e-4;

/// Where one path of a group looks from, and what it found.
struct Post<'s, M: Mode> {
    /// The first surface that can look around.
    x: Option<Vertex<'s, M>>,
    /// The matte surface that the path found from x; the path goes on as its tail.
    y: Option<Vertex<'s, M>>,
    /// Of the path up to x.
    throughput: M::Light,
    bounce: u32,
    /// Light found up to and including y's emission.
    radiance: M::Light,
}

/// Estimates the radiance of a group of paths of neighbouring pixels, into [`Path::radiance`]. They must have the same
/// waves; how many they are changes the noise, not the mean. Paths beyond [`GROUP`] are followed alone.
pub fn radiances<M: Mode>(scene: &Scene<M>, paths: &mut [Path<M>], limits: &PathLimits, tally: &mut Tally) {
    if limits.strategy != Strategy::Shared {
        for path in paths {
            path.finish(scene, limits, tally);
        }
        return;
    }
    let (group, alone) = paths.split_at_mut(GROUP.min(paths.len()));
    for path in alone {
        path.finish(scene, limits, tally);
    }
    let (throughput, radiance) = (M::Light::ONE, M::Light::ZERO);
    let mut posts: [Post<M>; GROUP] =
        std::array::from_fn(|_| Post { x: None, y: None, throughput, bounce: 0, radiance });
    for (path, post) in group.iter_mut().zip(&mut posts) {
        post.occupy(scene, path, limits, tally);
    }
    let mut gathered = [M::Light::ZERO; GROUP];
    for (finder, path) in posts.iter().zip(&*group) {
        if let Some(y) = &finder.y {
            hand_out(scene, &posts, (finder, y), path, &mut gathered, tally);
        }
    }
    for ((path, post), gathered) in group.iter_mut().zip(&posts).zip(gathered) {
        if post.y.is_some() {
            path.radiance = post.radiance;
        }
        path.radiance += gathered;
    }
}

impl<'s, M: Mode> Post<'s, M> {
    /// Follows a path to its end. With a find, the path's radiance is what y scatters; without, what the path found.
    fn occupy(&mut self, scene: &'s Scene<M>, path: &mut Path<M>, limits: &PathLimits, tally: &mut Tally) {
        loop {
            // Find a surface that can look around.
            self.x = path.arrive(scene, limits, tally);
            let Some(x) = &self.x else { return };
            let (throughput, bounce, passed) = (path.throughput, path.bounce, path.passed);
            let looks_around = looks_around(x, path);
            let goes_on = path.scatter(scene, x, limits, tally);
            if !looks_around {
                if goes_on {
                    continue;
                }
                self.x = None;
                return;
            }
            (self.throughput, self.bounce) = (throughput, bounce);
            if !goes_on {
                return;
            }

            // See what this path finds from there.
            let spread = path.was_spread();
            self.y = path.arrive(scene, limits, tally);
            let Some(y) = &self.y else { return };
            let toward_x = y.frame.to_world(y.wo);
            let found = spread && path.passed == passed && is_matte(y) && y.looks_the_same(toward_x);
            if found {
                path.importance *= path.throughput.max();
                path.throughput = M::Light::ONE;
                self.radiance = std::mem::replace(&mut path.radiance, M::Light::ZERO);
            }
            if path.scatter(scene, y, limits, tally) {
                path.finish(scene, limits, tally);
            }
            if !found {
                self.y = None;
            }
            return;
        }
    }
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

/// Gives all posts their part of what the find scatters, which is the radiance of the finder's path.
fn hand_out<M: Mode>(
    scene: &Scene<M>,
    posts: &[Post<M>; GROUP],
    (finder, y): (&Post<M>, &Vertex<M>),
    path: &Path<M>,
    gathered: &mut [M::Light; GROUP],
    tally: &mut Tally,
) {
    // What each post would make of y, if it sees it.
    let mut seen = [M::Light::ZERO; GROUP];
    let mut densities = [0.0; GROUP];
    let mut rays = [Ray::new(Vec3::ZERO, Vec3::Z); GROUP];
    let mut doubtful = 0u8;
    for (k, post) in posts.iter().enumerate() {
        let Some(x) = post.x.as_ref().filter(|_| post.bounce == finder.bounce) else { continue };
        let offset = y.surface.position - x.surface.position;
        let distance2 = offset.length_squared();
        let distance_m = distance2.sqrt();
        let wi = offset * (1.0 / distance_m);
        if !y.looks_the_same(-wi) {
            continue;
        }
        let Some(local) = x.local(wi) else { continue };
        let (value, pdf) = x.bsdf.eval(x.wo, local, &path.waves);
        // Per area of y instead of solid angle at x.
        let geometry = y.surface.ng.dot(wi).abs() / distance2;
        densities[k] = pdf * geometry;
        seen[k] = post.throughput * value * geometry;
        if !std::ptr::eq(post, finder) {
            rays[k] = Ray { tfar: distance_m * (1.0 - GAP), ..Ray::new(x.surface.leave(wi), wi) };
            doubtful |= 1 << k;
        }
    }
    tally.shadow_rays += u64::from(doubtful.count_ones());
    let hidden = scene.stage.occluded_batch(&rays, doubtful);
    let visible = |k: &usize| hidden >> k & 1 == 0;
    let density: f32 = (0..GROUP).filter(visible).map(|k| densities[k]).sum();
    if density > 0.0 && density.is_finite() {
        let scattered = path.radiance * (1.0 / density);
        for k in (0..GROUP).filter(visible) {
            gathered[k] += seen[k] * scattered;
        }
    }
}
