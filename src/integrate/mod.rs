//! Light transport: a path tracer with next-event estimation and multiple importance sampling, and light paths besides.

mod direct;
mod guide;
mod path;
mod photons;
mod post;
mod seen;
mod share;
mod sight;
mod throw;
mod vertex;

pub use direct::MOST_DRAWS_LOG2;
pub use path::Path;
pub use seen::seen_light;
pub use share::{GROUP, radiances};
pub use sight::{Clue, Looker, Sight, Wanted};
use std::ops::AddAssign;
pub use throw::{Landing, Throw};

/// How light is found. The others are kept to check the last: all agree in the mean, but for what smooth mirrors and lenses
/// throw of lamps without extent, which only paths from the lamps find.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Strategy {
    /// Only by rays that happen to hit it (and by light sampling for what no ray can hit).
    Bsdf,
    /// Only by sampling the lights (and by rays after perfectly smooth surfaces, which light sampling cannot serve).
    Light,
    /// Both, weighted by the power heuristic.
    Mis,
    /// Both; and neighbouring pixels look at what each other's paths found, paths from the lamps bring what mirrors and lenses
    /// throw, and lights are drawn several times, each where it pays: less noise, the same mean.
    #[default]
    Shared,
}

#[derive(Clone, Copy, Debug)]
pub struct PathLimits {
    /// Scattering events on a path: 0 sees emitters only, 1 adds direct light.
    pub max_bounces: u32,
    pub strategy: Strategy,
}

/// How paths are followed. Except for the limits nothing of it changes the mean.
pub struct Tactics {
    pub limits: PathLimits,
    /// The paths of a group look at each other's finds.
    pub shares: bool,
    /// Several paths go on from matte surfaces that are seen in mirrors or through lenses.
    pub fans_out: bool,
    /// The first surface of a path draws 2^this sources of light, the others one.
    pub draws_log2: u32,
    /// Light paths that are followed besides, where they help.
    pub throw: Option<Throw>,
}

/// What was done on the way; a plain value, summed over tiles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Camera and scattered rays.
    pub rays: u64,
    pub shadow_rays: u64,
    /// Lights that were drawn to be looked at.
    pub draws: u64,
    /// Surfaces from which several paths went on.
    pub fans: u64,
    /// Samples whose radiance was not a number or infinite; they count as black.
    pub non_finite: u64,
    /// Samples brighter than 2^32 (4.3e9), which count as that.
    pub beyond_range: u64,
    /// Samples that were brighter than the render allows.
    pub clamped: u64,
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.shadow_rays += other.shadow_rays;
        self.draws += other.draws;
        self.fans += other.fans;
        self.non_finite += other.non_finite;
        self.beyond_range += other.beyond_range;
        self.clamped += other.clamped;
    }
}

/// Weight of a sample drawn with density `a` that a second strategy would have drawn with density `b`: the power heuristic
/// with exponent 2. Veach 1997, section 9.2.4.
#[inline]
fn mis_weight(a: f32, b: f32) -> f32 {
    // Through the ratio: the squares of densities overflow.
    let ratio = b / a;
    1.0 / (1.0 + ratio * ratio)
}
