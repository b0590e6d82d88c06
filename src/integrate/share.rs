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

use arrayvec::ArrayVec;
use glam::Vec3;

use super::guide::Guide;
use super::path::{Arrival, Path, SURE_BOUNCES};
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

/// In place of a ray where there is none.
const NO_RAY: Ray = Ray { origin: Vec3::ZERO, dir: Vec3::Z, tnear: 0.0, tfar: 0.0 };

/// Where one path of a group looks from, and what it found.
struct Post<'s, M: Mode> {
    progress: Progress,
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

/// How far a path has come.
#[derive(Clone, Copy)]
enum Progress {
    /// No surface yet that could look around.
    Out,
    /// Just left its post, having passed straight through so many surfaces until then.
    Left { passed: u32 },
    /// Followed for its own sake only.
    Tail,
}

/// Estimates the radiance of a group of paths of neighbouring pixels, into [`Path::radiance`]. They must have the same
/// waves; how many they are changes the noise, not the mean. The paths go on side by side, one surface at a time, so that
/// their rays can be traced together.
pub fn radiances<M: Mode>(
    scene: &Scene<M>,
    guide: Option<&Guide>,
    paths: &mut ArrayVec<Path<M>, GROUP>,
    limits: &PathLimits,
    tally: &mut Tally,
) {
    let (throughput, radiance) = (M::Light::ONE, M::Light::ZERO);
    let progress = if limits.strategy == Strategy::Shared { Progress::Out } else { Progress::Tail };
    let mut posts: [Post<M>; GROUP] =
        std::array::from_fn(|_| Post { progress, x: None, y: None, throughput, bounce: 0, radiance });
    let mut rays = [NO_RAY; GROUP];
    let mut active = 0u8;
    for (i, path) in paths.iter().enumerate() {
        rays[i] = path.ray;
        active |= 1 << i;
    }
    while active != 0 {
        // Move every path to its next surface and on.
        tally.rays += u64::from(active.count_ones());
        let hits = scene.stage.intersect_batch(&rays, active);
        let mut shadows = [NO_RAY; GROUP];
        let mut lights = [M::Light::ZERO; GROUP];
        let mut doubtful = 0u8;
        for (i, (path, post)) in paths.iter_mut().zip(&mut posts).enumerate() {
            if active >> i & 1 == 0 {
                continue;
            }
            let goes_on = match path.arrive(scene, scene.surface(&hits, i), limits) {
                Arrival::End => false,
                Arrival::Through => true,
                Arrival::At(surface, material, beyond) => {
                    let vertex = path.vertex(scene, guide, (surface, material), beyond);
                    let kept = post.judge(&vertex, path);
                    let (direct, goes_on) = path.scatter(scene, &vertex, limits, tally);
                    match direct.shadow {
                        Some(shadow) => {
                            (shadows[i], lights[i]) = (shadow, direct.light);
                            doubtful |= 1 << i;
                        }
                        None => path.radiance += direct.light,
                    }
                    match kept {
                        Kept::X => post.x = Some(vertex),
                        Kept::Y => post.y = Some(vertex),
                        Kept::Nothing => {}
                    }
                    goes_on
                }
            };
            rays[i] = path.ray;
            if !goes_on {
                active &= !(1 << i);
            }
        }

        // Add the light that nothing stands in the way of.
        let hidden = scene.stage.occluded_batch(&shadows, doubtful);
        for (i, path) in paths.iter_mut().enumerate() {
            if (doubtful & !hidden) >> i & 1 == 1 {
                path.radiance += lights[i];
            }
        }
    }

    let mut gathered = [M::Light::ZERO; GROUP];
    for (finder, path) in posts.iter().zip(&*paths) {
        // Where nothing is scattered there is nothing to look at.
        if let Some(y) = finder.y.as_ref().filter(|_| !path.radiance.is_black()) {
            hand_out(scene, &posts, (finder, y), path, &mut gathered, tally);
        }
    }
    for ((path, post), gathered) in paths.iter_mut().zip(&posts).zip(gathered) {
        if post.y.is_some() {
            path.radiance = post.radiance;
        }
        path.radiance += gathered;
    }
}

/// What a vertex is to its group.
enum Kept {
    X,
    Y,
    Nothing,
}

impl<M: Mode> Post<'_, M> {
    /// Whether a path's next vertex is one to look from or one that was found. From a find on the path's radiance is what y
    /// scatters; before, and without one, what the path found.
    #[inline]
    fn judge(&mut self, vertex: &Vertex<M>, path: &mut Path<M>) -> Kept {
        match self.progress {
            Progress::Out if looks_around(vertex, path) => {
                self.progress = Progress::Left { passed: path.passed };
                (self.throughput, self.bounce) = (path.throughput, path.bounce);
                Kept::X
            }
            Progress::Left { passed } => {
                self.progress = Progress::Tail;
                let toward_x = vertex.frame.to_world(vertex.wo);
                let straight = path.was_spread() && path.passed == passed;
                if !(straight && is_matte(vertex) && vertex.looks_the_same(toward_x)) {
                    return Kept::Nothing;
                }
                path.importance *= path.throughput.max();
                path.throughput = M::Light::ONE;
                self.radiance = std::mem::replace(&mut path.radiance, M::Light::ZERO);
                Kept::Y
            }
            _ => Kept::Nothing,
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
    scatters && path.bounce < SURE_BOUNCES && !path.collapsed && x.interior.absorption_per_m == Vec3::ZERO
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
    let mut rays = [NO_RAY; GROUP];
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
        densities[k] = x.density(wi, pdf) * geometry;
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
