//! Pixels that lie close together share what their paths find.
//!
//! A path sees a first rough surface at x and another at y. What y scatters towards x hardly depends on which path found it,
//! so every other path of the group may look at y too: from its own x, through one visibility ray, a fraction of what a path
//! costs. Each y is weighed by how likely all the paths together were to find it (the balance heuristic), so the means stay
//! what they were, and indirect light has about 1 / [`GROUP`] of its variance. Bekaert, Sbert & Halton 2002, "Accelerating
//! Path Tracing by Re-Using Paths".
//!
//! A matte y sends the same light to all. A glossy one is asked anew for each viewer, about the light that arrived at it: from
//! the source that was drawn, weighed as its finder weighs it, and along the way that the finder's path went on, weighed by
//! how likely all viewers together were to take it.
//!
//! Which pairs may be shared depends on the pair alone (broadly scattering, unobstructed, seen through the same normal),
//! never on the path that found it: others count as light that only their own path can find.

use glam::Vec3;
use wide::{CmpGe, f32x8};

use super::Tally;
use super::direct::Direct;
use super::path::{Path, SURE_BOUNCES};
use super::share::GROUP;
use super::throw::Find;
use super::vertex::Vertex;
use crate::bsdf::Bsdf;
use crate::embree::Rays;
use crate::math::{Vec3x8, set_bits};
use crate::mode::{Lanes, Mode};
use crate::scene::{Scene, Surface};

/// Where one path of a group looks from, and what it found.
pub(super) struct Post<'s, M: Mode> {
    progress: Progress,
    /// The first surface that can look around.
    pub x: Option<Vertex<'s, M>>,
    /// The surface that the path found from x; the path goes on as its tail.
    y: Option<Vertex<'s, M>>,
    /// What arrives at a glossy y.
    turn: Option<Turn<M::Light>>,
    /// True for the step that finds a glossy y.
    turning: bool,
    /// Of the path up to x.
    throughput: M::Light,
    bounce: u32,
    /// Light found up to and including y's emission.
    radiance: M::Light,
    /// Of x, where that is the path's first surface; else 0 ([`Throw::footprint`](super::throw::Throw::footprint)).
    footprint: f32,
}

/// Where the posts of a group look from, side by side; anything for those that do not.
pub(super) struct Viewers {
    position: Vec3x8,
    ng: Vec3x8,
    offset: Vec3x8,
}

/// Light that a glossy surface can scatter to any viewer; directions in its frame.
struct Turn<L> {
    /// Where the drawn source is, and what arrives from it.
    toward: Vec3,
    arriving: L,
    /// Where the path went on.
    onward: Vec3,
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

/// What a vertex is to its group.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kept {
    X,
    Matte,
    Glossy,
    Nothing,
}

impl<'s, M: Mode> Post<'s, M> {
    pub fn new(shares: bool) -> Self {
        Self {
            progress: if shares { Progress::Out } else { Progress::Tail },
            x: None,
            y: None,
            turn: None,
            turning: false,
            throughput: M::Light::ONE,
            bounce: 0,
            radiance: M::Light::ZERO,
            footprint: 0.0,
        }
    }

    /// Whether a path's next vertex is one to look from or one that was found. From a find on the path's radiance is what y
    /// scatters, or for a glossy y what arrives there; before, and without one, what the path found.
    #[inline]
    pub fn judge(&mut self, vertex: &Vertex<M>, path: &mut Path<M>) -> Kept {
        self.turning = false;
        match self.progress {
            Progress::Out if looks_around(vertex, path) => {
                self.progress = Progress::Left { passed: path.passed };
                (self.throughput, self.bounce) = (path.throughput, path.bounce);
                self.footprint = if path.bounce == 0 { path.footprint } else { 0.0 };
                Kept::X
            }
            Progress::Left { passed } => {
                self.progress = Progress::Tail;
                let toward_x = vertex.frame.to_world(vertex.wo);
                let straight = path.was_spread() && path.passed == passed;
                let kept = find(vertex);
                if kept == Kept::Nothing || !straight || !vertex.looks_the_same(toward_x) {
                    return Kept::Nothing;
                }
                path.importance *= path.throughput.max();
                path.throughput = M::Light::ONE;
                self.radiance = path.take_found();
                self.turning = kept == Kept::Glossy;
                kept
            }
            _ => Kept::Nothing,
        }
    }

    /// Takes the path's part of what is seen from its post: others have the rest.
    #[inline]
    pub fn share_with_others(&mut self, path: &Path<M>) {
        self.throughput = path.throughput;
    }

    /// Of a light that was drawn at the path's vertex, what is to be added to the post if nothing stands in between.
    #[inline]
    pub fn incoming(&mut self, direct: &Direct<M::Light>) -> Find<M::Light> {
        if !self.turning {
            return direct.find;
        }
        self.turn = Some(Turn { toward: direct.wi, arriving: M::Light::ZERO, onward: Vec3::Z });
        Find { light: direct.arriving, density: 0.0 }
    }

    #[inline]
    pub fn add(&mut self, find: Find<M::Light>, path: &mut Path<M>) {
        match &mut self.turn {
            Some(turn) if self.turning => turn.arriving = find.light,
            _ => path.add(find),
        }
    }

    /// Takes a vertex that the path has just left.
    #[inline]
    pub fn keep(&mut self, kept: Kept, vertex: Vertex<'s, M>, path: &Path<M>) {
        match kept {
            Kept::X => self.x = Some(vertex),
            Kept::Matte | Kept::Glossy => {
                if let Some(turn) = &mut self.turn {
                    turn.onward = vertex.frame.to_local(path.ray.dir);
                }
                self.y = Some(vertex);
            }
            Kept::Nothing => {}
        }
    }

    /// Light that the path does not share.
    pub fn own(&self, path: &Path<M>) -> M::Light {
        if self.y.is_some() { self.radiance } else { path.found(path.footprint) }
    }
}

impl Viewers {
    pub fn new<M: Mode>(posts: &[Post<M>; GROUP]) -> Self {
        let of = |what: fn(&Surface) -> Vec3| {
            posts.each_ref().map(|post| post.x.as_ref().map_or(Vec3::ZERO, |x| what(&x.surface))).into()
        };
        Self { position: of(|x| x.position), ng: of(|x| x.ng), offset: of(|x| x.offset()) }
    }

    /// As [`Surface::leave`], each in its direction.
    #[inline]
    fn leave(&self, directions: Vec3x8) -> Vec3x8 {
        let outward = directions.dot(self.ng).cmp_ge(f32x8::ZERO);
        self.position + self.offset * outward.blend(f32x8::ONE, f32x8::splat(-1.0))
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

/// What a surface is to those who find it.
fn find<M: Mode>(y: &Vertex<M>) -> Kept {
    match &y.bsdf {
        Bsdf::Diffuse(_) => Kept::Matte,
        Bsdf::Conductor(bsdf) if bsdf.microfacets.is_broad() => Kept::Glossy,
        _ => Kept::Nothing,
    }
}

/// Gives all posts their part of what path number `finder` found.
pub(super) fn hand_out<M: Mode>(
    scene: &Scene<M>,
    (posts, viewers): (&[Post<M>; GROUP], &Viewers),
    finder: usize,
    path: &Path<M>,
    gathered: &mut [M::Light; GROUP],
    tally: &mut Tally,
) {
    let Post { y: Some(y), turn, bounce, .. } = &posts[finder] else { return };
    // Where nothing is scattered there is nothing to look at.
    let turned = turn.as_ref().filter(|turn| !(turn.arriving.is_black() && path.apart.is_black()));
    if turned.is_none() && path.radiance.is_black() && path.thrown.is_empty() {
        return;
    }

    // Look at y from all posts. Rays start beside x and end beside y: near where surfaces touch, a ray to y itself would be
    // stopped by it for those who are close, and they would be left out.
    let offset = Vec3x8::splat(y.surface.position) - viewers.position;
    let distance2 = offset.length_squared();
    let toward = offset * (f32x8::ONE / distance2.sqrt());
    // Per area of y instead of solid angle at x.
    let geometry = (Vec3x8::splat(y.surface.ng).dot(toward).abs() / distance2).to_array();
    let target = y.surface.leave(y.frame.to_world(y.wo));
    let rays = Rays::between(viewers.leave(toward), Vec3x8::splat(target));

    // What each would make of y, if it sees it, and how likely it was to find it, were nothing guided.
    let mut seen = [M::Light::ZERO; GROUP];
    let mut onward = [M::Light::ZERO; GROUP];
    let mut densities = [0.0; GROUP];
    let mut onward_densities = [0.0; GROUP];
    let mut looking = 0u8;
    let (mut finders_share, mut finders_turn) = (1.0, 1.0);
    for k in set_bits(y.looks_the_same_along(toward)) {
        let (post, wi, geometry) = (&posts[k], toward.lane(k), geometry[k]);
        let Some(x) = post.x.as_ref().filter(|_| post.bounce == *bounce) else { continue };
        let Some(local) = x.local(wi) else { continue };
        let (value, pdf) = x.bsdf.eval(x.wo, local, &path.waves);
        looking |= 1 << k;
        densities[k] = pdf * geometry;
        seen[k] = post.throughput * value * geometry;
        let mut turn_pdf = 1.0;
        if let Some(turn) = turn {
            let wo = y.frame.to_local(-wi);
            let (value, pdf) = y.bsdf.eval(wo, turn.onward, &path.waves);
            (onward[k], onward_densities[k]) = (seen[k] * value, densities[k] * pdf);
            turn_pdf = pdf;
            seen[k] = match turn.arriving.is_black() {
                true => M::Light::ZERO,
                false => seen[k] * y.bsdf.eval(wo, turn.toward, &path.waves).0 * turn.arriving,
            };
        }
        if k == finder {
            (finders_share, finders_turn) = (pdf / x.density(wi, pdf), turn_pdf);
        }
    }
    // The finder has seen it.
    let doubtful = looking & !(1 << finder);
    tally.shadow_rays += u64::from(doubtful.count_ones());
    let visible = looking & !scene.stage.occluded_batch(rays, doubtful);
    let sum = |densities: &[f32; GROUP]| set_bits(visible).map(|k| densities[k]).sum::<f32>();

    // Weigh by the sums over those that see it.
    let per_density = |density: f32| {
        let share = finders_share / density;
        if density > 0.0 && share.is_finite() { share } else { 0.0 }
    };
    let share = per_density(sum(&densities));
    let onward_share = if turn.is_some() { per_density(sum(&onward_densities)) } else { 0.0 };
    let apart = if finders_turn > 0.0 { path.apart * (share / finders_turn) } else { M::Light::ZERO };
    for k in set_bits(visible) {
        // What lies behind a matte y, or behind a glossy one.
        let behind = path.found(posts[k].footprint);
        gathered[k] += match turn {
            None => seen[k] * behind * share,
            Some(_) => seen[k] * share + onward[k] * (apart + behind * onward_share),
        };
    }
}
