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

/// How far a path has come.
#[derive(Clone, Copy)]
enum Stage {
    /// No surface yet that could look around.
    Head,
    /// Just left its lookout, having passed through so many surfaces.
    Left { passed: u32 },
    /// Followed for its own sake only.
    Tail,
}

/// Estimates the radiance of a group of paths of neighbouring pixels, into [`Path::radiance`]. They must have the same
/// waves; how many they are changes the noise, not the mean. The paths go on side by side, one surface at a time, so that
/// their rays are traced together.
pub fn radiances<M: Mode>(
    scene: &Scene<M>,
    paths: &mut ArrayVec<Path<M>, GROUP>,
    limits: &PathLimits,
    tally: &mut Tally,
) {
    let mut lookouts: [Option<Lookout<M>>; GROUP] = std::array::from_fn(|_| None);
    let mut finds: [Option<Find<M>>; GROUP] = std::array::from_fn(|_| None);
    let first = if limits.strategy == Strategy::Shared { Stage::Head } else { Stage::Tail };
    let mut stages = [first; GROUP];
    let mut rays = [NO_RAY; GROUP];
    let mut shadows = [NO_RAY; GROUP];
    let mut lights = [M::Light::ZERO; GROUP];
    let mut active = 0u8;
    for (i, path) in paths.iter().enumerate() {
        rays[i] = path.ray;
        active |= 1 << i;
    }
    while active != 0 {
        tally.rays += u64::from(active.count_ones());
        let hits = scene.stage.intersect_batch(&rays, active);
        let mut waiting = 0u8;
        for (i, path) in paths.iter_mut().enumerate() {
            if active >> i & 1 == 0 {
                continue;
            }
            let vertex = match path.arrive(scene, scene.surface(&hits, i), limits) {
                Arrival::At(surface) => path.vertex(scene, surface),
                Arrival::Through => {
                    rays[i] = path.ray;
                    continue;
                }
                Arrival::End => {
                    active &= !(1 << i);
                    continue;
                }
            };
            // Note what the group will need of this vertex.
            let (mut lookout, mut find) = (None, None);
            match stages[i] {
                Stage::Head if looks_around(&vertex, path) && path.bounce + 1 < limits.max_bounces => {
                    lookout = Some((path.throughput, path.bounce));
                    stages[i] = Stage::Left { passed: path.passed };
                }
                Stage::Left { passed } => {
                    // Take what x leads to apart from what was found before.
                    let toward_x = vertex.frame.to_world(vertex.wo);
                    let direct = path.passed == passed && path.was_spread();
                    if direct && is_matte(&vertex) && vertex.looks_the_same(toward_x) {
                        path.importance *= path.throughput.max();
                        path.throughput = M::Light::ONE;
                        find = Some(std::mem::replace(&mut path.radiance, M::Light::ZERO));
                    }
                    stages[i] = Stage::Tail;
                }
                _ => {}
            }
            let (direct, goes_on) = path.scatter(scene, &vertex, limits, tally);
            if let Some(shadow) = direct.shadow {
                (shadows[i], lights[i]) = (shadow, direct.light);
                waiting |= 1 << i;
            } else {
                path.radiance += direct.light;
            }
            rays[i] = path.ray;
            if !goes_on {
                active &= !(1 << i);
            }
            if let Some((throughput, bounce)) = lookout {
                lookouts[i] = Some(Lookout { x: vertex, throughput, bounce });
            } else if let Some(radiance) = find {
                finds[i] = Some(Find { y: vertex, radiance });
            }
        }
        let blocked = scene.stage.occluded_batch(&shadows, waiting);
        for (i, path) in paths.iter_mut().enumerate() {
            if (waiting & !blocked) >> i & 1 == 1 {
                path.radiance += lights[i];
            }
        }
    }

    let mut gathered = [M::Light::ZERO; GROUP];
    for (j, find) in finds.iter().enumerate() {
        if let Some(find) = find {
            hand_out(scene, &lookouts, j, find, paths[j].radiance, &paths[j].waves, &mut gathered, tally);
        }
    }
    for (i, path) in paths.iter_mut().enumerate() {
        if let Some(find) = &finds[i] {
            path.radiance = find.radiance;
        }
        path.radiance += gathered[i];
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
    let mut densities = [0.0f32; GROUP];
    let mut rays = [NO_RAY; GROUP];
    let mut asked = 0u8;
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
            rays[k] = Ray { tfar: distance_m * (1.0 - GAP), ..Ray::new(x.surface.leave(wi), wi) };
            asked |= 1 << k;
        }
        // Per area of y instead of solid angle at x.
        let geometry = y.ng.dot(wi).abs() / distance2;
        densities[k] = pdf * geometry;
        seen[k] = *throughput * value * geometry;
    }
    tally.shadow_rays += u64::from(asked.count_ones());
    let blocked = scene.stage.occluded_batch(&rays, asked);
    let visible = |k: usize| blocked >> k & 1 == 0;
    let density: f32 = (0..GROUP).filter(|&k| visible(k)).map(|k| densities[k]).sum();
    if density > 0.0 && density.is_finite() {
        let scale = 1.0 / density;
        for k in (0..GROUP).filter(|&k| visible(k)) {
            gathered[k] += seen[k] * scattered * scale;
        }
    }
}
