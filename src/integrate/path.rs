//! One path from the camera: it arrives at a surface, is scattered, arrives at the next.

use arrayvec::ArrayVec;
use glam::Vec3;

use super::direct::{Direct, Draw, direct_light};
use super::guide::Leaf;
use super::post::Kept;
use super::throw::{Find, MOST_ROUGH, Thrower};
use super::vertex::Vertex;
use super::{PathLimits, Strategy, Tactics, Tally, mis_weight};
use crate::bsdf::{Bsdf, BsdfSample, Pdf};
use crate::embree::Ray;
use crate::math::Sampler;
use crate::mode::{Lanes, Mode};
use crate::scene::{Interior, Lamp, Material, Scene, Surface};

/// Surfaces that one path may pass straight through.
const MAX_THROUGH: u32 = 256;
/// Two ways on from a smooth interface are both followed where each carries this share of what the pixel sees, as far as
/// interfaces tell. Three times as much costs bubbles a quarter of the gain, ten times half of it; a third gains nothing.
const WORTH_TWO: f32 = 3e-3;
/// While all that turned a path is smooth and it carries this share, it plays no Russian roulette: lenses and bubbles split
/// such paths off to keep their noise out, and it would come back. A tenth as much gains bubbles 1.4 and costs wine 0.8 of
/// the efficiency.
const SURE_SHARP: f32 = 0.1;
/// Finds whose light others weigh for themselves: one at each thrower, and lamps along one ray, those behind the first shining
/// through it. Of more they take what the finder's own surface makes of it.
const MOST_THROWN: usize = MOST_ROUGH as usize + 3;
/// A path that fans out becomes 2^this.
const FAN_LOG2: u32 = 2;
pub(super) const MOST_OTHERS: usize = (1 << FAN_LOG2) - 1;
/// Bounces before Russian roulette begins.
pub(super) const SURE_BOUNCES: u32 = 3;

/// A path on its way, with the light that it has found so far.
#[derive(Clone)]
pub struct Path<M: Mode> {
    pub(super) ray: Ray,
    pub waves: M::Waves,
    sampler: Sampler,
    pub radiance: M::Light,
    pub(super) throughput: M::Light,
    /// Where the ray was scattered and with what density for each source of light that was drawn there; `None` when light
    /// sampling could not have drawn it.
    scattered: Option<(Vec3, f32)>,
    interior: Interior,
    /// What roulette multiplies the throughput with: radiance is compressed inside dense bodies, which is no loss, and a
    /// tail starts with the importance of the path it belongs to. Likewise with how much likelier directions were than by
    /// the surfaces alone: more light is expected from there, also by what lies there and sends the path on.
    pub(super) importance: f32,
    pub(super) bounce: u32,
    /// Surfaces that were passed as if they were not there.
    pub(super) passed: u32,
    /// True when one wavelength has decided for all.
    pub(super) collapsed: bool,
    /// The next four numbers: for the surface and its holes.
    u_surface: [f32; 4],
    /// The next four: for light, and for roulette.
    u_light: [f32; 4],
    /// At this bounce the light that the ray ran into is kept apart: others look at where it was scattered, and scatter it
    /// in their own way.
    pub(super) apart_at: u32,
    pub(super) apart: M::Light,
    /// True while the path is to leave out the light that its camera ray meets: it is found otherwise ([`seen_light`]).
    ///
    /// [`seen_light`]: super::seen_light
    blind: bool,
    /// True while all that has turned the path is smooth: one sees sharply what it comes to.
    sharp: bool,
    /// Of the first surface ([`Throw::footprint`](super::Throw::footprint)).
    pub(super) footprint: f32,
    /// True while light may have come all the way by light paths ([`Throw`](super::Throw)).
    reversible: bool,
    /// The mirror or lens that sent the path on, if that was the last to turn it.
    thrower: Option<Thrower>,
    /// Those that have sent it on and were not smooth.
    rough_throwers: u32,
    /// Light that light paths find, too: how much of it counts depends on the footprint of the first surface, and others may
    /// look at what this path finds from theirs.
    pub(super) thrown: ArrayVec<Find<M::Light>, MOST_THROWN>,
}

/// What a path comes to at the end of its ray.
pub(super) enum Arrival<'s, M: Mode> {
    /// The path is over.
    End,
    /// A hole: the path goes straight on.
    Through,
    /// With what lies on the far side.
    At(Surface<'s>, &'s Material<M>, Interior),
}

impl<M: Mode> Path<M> {
    /// `interior` is what the ray begins in; `blind` paths leave out what [`seen_light`](super::seen_light) finds.
    pub fn new(ray: Ray, interior: Interior, waves: M::Waves, sampler: Sampler, blind: bool) -> Self {
        Self {
            ray,
            waves,
            sampler,
            radiance: M::Light::ZERO,
            throughput: M::Light::ONE,
            scattered: None,
            interior,
            importance: 1.0,
            bounce: 0,
            passed: 0,
            collapsed: false,
            u_surface: [0.0; 4],
            u_light: [0.0; 4],
            apart_at: u32::MAX,
            apart: M::Light::ZERO,
            blind,
            sharp: true,
            footprint: 0.0,
            reversible: true,
            thrower: None,
            rough_throwers: 0,
            thrown: ArrayVec::new(),
        }
    }

    /// True when the last scattering could have gone anywhere, not only in one direction.
    pub(super) fn was_spread(&self) -> bool {
        self.scattered.is_some()
    }

    /// Takes the path to what its ray met, and adds what that emits.
    #[inline]
    pub(super) fn arrive<'s>(
        &mut self,
        scene: &'s Scene<M>,
        met: Option<Surface<'s>>,
        tactics: &Tactics,
    ) -> Arrival<'s, M> {
        let limits = &tactics.limits;
        let blind = std::mem::take(&mut self.blind);
        let Some(mut surface) = met else {
            if blind {
                return Arrival::End;
            }
            let (scattered, mut sky) = (self.scattered, M::Light::ZERO);
            let from = scattered.map_or(self.ray.origin, |(from, _)| from);
            scene.escape(from, self.ray.dir, &self.waves, |light, light_pdf| {
                sky += light * hit_weight(scattered.map(|(_, pdf)| (pdf, light_pdf)), limits);
            });
            let density = self.thrown_density(scene, tactics, &Lamp::Beyond);
            self.run_into(sky, density);
            return Arrival::End;
        };
        if self.interior.absorption_per_m != Vec3::ZERO {
            let distance_m = surface.position.distance(self.ray.origin);
            self.throughput *= Scene::<M>::left_over(&self.interior, distance_m, &self.waves);
        }

        // Add what the surface emits.
        if surface.emitter != u32::MAX && !blind {
            let light = scene.emitted(&surface, -self.ray.dir.dot(surface.ng), &self.waves);
            if !light.is_black() {
                let (lights, lamp) = (&scene.stage.lights, surface.lamp());
                let densities = self.scattered.map(|(from, pdf)| (pdf, lights.surface_pdf(from, &lamp)));
                let density = self.thrown_density(scene, tactics, &Lamp::Surface(lamp));
                self.run_into(light * hit_weight(densities, limits), density);
            }
        }
        if self.bounce >= limits.max_bounces {
            return Arrival::End;
        }

        // Pass through holes, and through what another body takes the place of.
        self.u_surface = self.sampler.next_4d();
        let (material, beyond) = scene.meet(&self.ray, &mut surface, &self.interior);
        let coverage = material.map_or(0.0, |material| material.coverage(&surface, scene.textures()));
        match material {
            Some(material) if self.u_surface[3] < coverage || self.passed >= MAX_THROUGH => {
                // The number is spent only on which side of the coverage it lies.
                self.u_surface[3] = (self.u_surface[3] / coverage).min(1.0 - f32::EPSILON);
                return Arrival::At(surface, material, beyond);
            }
            None if self.passed >= MAX_THROUGH => return Arrival::End,
            _ => {}
        }
        self.passed += 1;
        self.interior = beyond;
        self.scattered = self.scattered.map(|(from, pdf)| (from, pdf * (1.0 - coverage)));
        self.ray = Ray::new(surface.leave(self.ray.dir), self.ray.dir);
        Arrival::Through
    }

    /// [`Find::density`] of what lies at the end of the ray.
    #[inline]
    fn thrown_density(&self, scene: &Scene<M>, tactics: &Tactics, lamp: &Lamp) -> f32 {
        match (&tactics.throw, &self.thrower) {
            (Some(throw), Some(thrower)) if self.reversible => {
                throw.density(scene, thrower, lamp, self.ray.dir, &self.waves)
            }
            _ => 0.0,
        }
    }

    /// Adds light that lies at the end of the ray.
    #[inline]
    fn run_into(&mut self, light: M::Light, density: f32) {
        let light = self.throughput * light;
        if self.bounce == self.apart_at {
            self.apart += light;
        } else {
            self.add(Find { light, density });
        }
    }

    /// Adds light that the path has found.
    #[inline]
    pub(super) fn add(&mut self, find: Find<M::Light>) {
        if find.density == 0.0 {
            self.radiance += find.light;
        } else if self.thrown.try_push(find).is_err() {
            self.radiance += find.weighed(self.footprint);
        }
    }

    /// Light that the path has found, for whom sees it from a first surface with this footprint.
    #[inline]
    pub(super) fn found(&self, footprint: f32) -> M::Light {
        self.thrown.iter().fold(self.radiance, |sum, find| sum + find.weighed(footprint))
    }

    /// Light that the path has found so far, which it forgets.
    #[inline]
    pub(super) fn take_found(&mut self) -> M::Light {
        let found = self.found(self.footprint);
        self.radiance = M::Light::ZERO;
        self.thrown.clear();
        found
    }

    /// The surface that the path is at, ready to scatter; to be [prepared](Path::prepare).
    #[inline]
    pub(super) fn vertex<'s>(
        &self,
        scene: &'s Scene<M>,
        found: (Surface<'s>, &'s Material<M>),
        beyond: Interior,
    ) -> Vertex<'s, M> {
        Vertex::new(scene, found, -self.ray.dir, [self.interior, beyond], &self.waves)
    }

    /// Lets the surface that the path is at know where light is thrown, and draws numbers for it.
    #[inline]
    pub(super) fn prepare<'s>(&mut self, vertex: &mut Vertex<'s, M>, tactics: &'s Tactics) {
        if let Some(throw) = &tactics.throw {
            if self.bounce == 0 {
                self.footprint = throw.footprint(vertex);
            }
            if !self.reversible || self.footprint == 0.0 {
                vertex.consult(throw.guide.as_ref());
            }
        }
        self.u_light = self.sampler.next_4d();
    }

    /// How many sources of light the path draws at its next surface, as a power of two.
    #[inline]
    pub(super) fn draws_log2(&self, tactics: &Tactics) -> u32 {
        if self.bounce == 0 { tactics.draws_log2 } else { 0 }
    }

    /// Draws light that reaches a vertex straight from a source, to be added by the caller: number `draw` of the path's
    /// [`Path::draws_log2`].
    #[inline]
    pub(super) fn direct(
        &self,
        scene: &Scene<M>,
        (vertex, kept): (&Vertex<M>, Kept),
        draw: u32,
        tactics: &Tactics,
        tally: &mut Tally,
    ) -> Direct<M::Light> {
        if vertex.bsdf.is_delta() {
            return Direct::NONE;
        }
        let draws_log2 = self.draws_log2(tactics);
        let [x, y, u_light, _] =
            if draws_log2 == 0 { self.u_light } else { self.sampler.part(draws_log2, draw).next_4d() };
        let draw = Draw {
            strategy: tactics.limits.strategy,
            of: 1 << draws_log2,
            others_look: kept == Kept::Glossy,
            throw: tactics.throw.as_ref().filter(|_| self.is_thrown_by(vertex)),
        };
        let mut direct = direct_light(scene, vertex, draw, [u_light, x, y], &self.waves, tally);
        direct.find.light = self.throughput * direct.find.light;
        direct
    }

    /// Samples the surface; false where the path ends. What a glossy find does to light is left to those who look at it.
    #[inline]
    pub(super) fn send_on(&mut self, (vertex, kept): (&Vertex<M>, Kept), tactics: &Tactics) -> bool {
        self.draw(vertex).is_some_and(|sample| self.take((vertex, kept), sample, tactics))
    }

    /// Takes a sample of the surface.
    #[inline]
    fn take(&mut self, (vertex, kept): (&Vertex<M>, Kept), sample: BsdfSample<M>, tactics: &Tactics) -> bool {
        let wi = vertex.frame.to_world(sample.wi);
        if wi.dot(vertex.surface.ng) * sample.wi.z <= 0.0 && !matches!(sample.pdf, Pdf::Through(_)) {
            // An interpolated normal sent the ray to the wrong side of the real surface.
            return false;
        }
        if kept == Kept::Glossy {
            self.importance *= sample.weight.max();
            self.apart_at = self.bounce + 1;
        } else {
            self.throughput *= sample.weight;
        }
        if sample.collapses {
            self.collapsed = true;
            M::collapse(&mut self.waves);
        }
        if sample.wi.z * vertex.wo.z < 0.0 {
            let entering = sample.wi.z < 0.0;
            self.interior = vertex.beyond;
            self.importance *= vertex.bsdf.compression(entering);
        }
        self.ray = Ray::new(vertex.surface.leave(wi), wi);
        match sample.pdf {
            Pdf::Through(chance) if self.passed < MAX_THROUGH => {
                self.passed += 1;
                self.scattered = self.scattered.map(|(from, pdf)| (from, pdf * chance));
                return true;
            }
            Pdf::Through(_) => return false,
            Pdf::Delta => {
                self.scattered = None;
                self.be_thrown(vertex, wi, f32::INFINITY);
            }
            Pdf::SolidAngle(pdf) => {
                self.be_thrown(vertex, wi, pdf);
                let draws = (1 << self.draws_log2(tactics)) as f32;
                self.scattered = Some((vertex.surface.position, pdf / draws));
                self.sharp = false;
            }
        }
        self.bounce += 1;

        // Play Russian roulette with what is left.
        let worth = self.worth();
        if self.bounce > SURE_BOUNCES && !(self.sharp && worth >= SURE_SHARP) {
            // The square root: noise grows by more than the time that killing the faint ones as they deserve would save.
            let survival = worth.sqrt().min(0.95);
            if self.u_light[3] >= survival {
                return false;
            }
            self.throughput = self.throughput * (1.0 / survival);
        }
        true
    }

    /// Notes what sends the path on to `wi` (world space), with this density: infinite where that is the only direction.
    #[inline]
    fn be_thrown(&mut self, vertex: &Vertex<M>, wi: Vec3, pdf: f32) {
        if self.bounce == 0 {
            // Light paths bring nothing to first surfaces that are not matte; but others may look from one that is.
            self.reversible = pdf.is_finite();
            return;
        }
        self.reversible &= vertex.is_reversible();
        if vertex.is_thrower() && pdf.is_finite() {
            self.rough_throwers += 1;
            self.reversible &= self.rough_throwers <= MOST_ROUGH;
        }
        let (place, at) = (vertex.surface.place.number, vertex.surface.position);
        self.thrower = vertex.throws(wi, pdf.is_infinite()).then_some(Thrower { place, at, pdf });
    }

    /// True where light paths may come to a vertex and on the whole way back, or to where others look from.
    #[inline]
    fn is_thrown_by(&self, vertex: &Vertex<M>) -> bool {
        self.bounce > 0 && self.reversible && vertex.is_reversible() && self.rough_throwers < MOST_ROUGH
    }

    /// The share of what the pixel sees that the path is expected to bring.
    #[inline]
    fn worth(&self) -> f32 {
        self.throughput.max() * self.importance
    }

    /// The same path, which has found nothing yet.
    fn branch(&self) -> Self {
        Self { radiance: M::Light::ZERO, thrown: ArrayVec::new(), ..self.clone() }
    }

    /// Leaves the path what a smooth interface does not mirror, and returns one for what it does, where both are worth it and
    /// are seen sharply: chosen between at random, bright reflections of lamps and what lies behind them would both be noisy.
    #[inline]
    pub(super) fn split(&self, vertex: &mut Vertex<M>, tactics: &Tactics) -> Option<Self> {
        // A matte base is costly to follow, and little of it is seen in mirrors.
        let is_clear = matches!(vertex.bsdf, Bsdf::Dielectric(_));
        if !self.sharp || !(is_clear || self.bounce == 0) || tactics.limits.strategy != Strategy::Shared {
            return None;
        }
        let least = WORTH_TWO / self.worth();
        let sample = vertex.bsdf.split_mirror(vertex.wo, least, &self.waves)?;
        let mut mirrored = self.branch();
        mirrored.sampler = self.sampler.part(0, 0);
        mirrored.take((vertex, Kept::Nothing), sample, tactics).then_some(mirrored)
    }

    /// True where a path has come a long way to a matte surface: more than one should go on from there.
    #[inline]
    pub(super) fn fans_out(&self, vertex: &Vertex<M>, tactics: &Tactics) -> bool {
        vertex.is_matte() && tactics.fans_out && self.sharp && self.bounce > 0 && self.worth() >= SURE_SHARP
    }

    /// Leaves the path one part of what the surface scatters, and returns paths for the others.
    #[inline(never)]
    pub(super) fn fan_out(&mut self, vertex: &Vertex<M>, tactics: &Tactics) -> ArrayVec<Self, MOST_OTHERS> {
        let parts = 1 << FAN_LOG2;
        self.throughput = self.throughput * (1.0 / parts as f32);
        // Roulette would undo it.
        self.importance *= parts as f32;
        let whole = self.sampler.clone();
        let draw_anew = |path: &mut Self, part| {
            path.sampler = whole.part(FAN_LOG2, part);
            (path.u_surface, path.u_light) = (path.sampler.next_4d(), path.sampler.next_4d());
        };
        let mut others = ArrayVec::new();
        for part in 1..parts {
            let mut other = self.branch();
            draw_anew(&mut other, part);
            if other.send_on((vertex, Kept::Nothing), tactics) {
                others.push(other);
            }
        }
        draw_anew(self, 0);
        others
    }

    /// Draws a direction from the surface, or from what its guide knows.
    #[inline]
    fn draw(&mut self, vertex: &Vertex<M>) -> Option<BsdfSample<M>> {
        if let Some(leaf) = vertex.guide {
            return self.draw_guided(vertex, leaf);
        }
        let [u_x, u_y, u_lobe, _] = self.u_surface;
        vertex.bsdf.sample(vertex.wo, [u_lobe, u_x, u_y], &self.waves)
    }

    /// The density that comes with a direction is that of the surface alone, which light sampling weighs itself against.
    /// Apart from the rest, which it would slow down where nothing is guided.
    #[inline(never)]
    fn draw_guided(&mut self, vertex: &Vertex<M>, leaf: &Leaf) -> Option<BsdfSample<M>> {
        let [u_x, u_y, u_lobe, u_guide] = self.u_surface;
        if u_guide < leaf.chance {
            let toward = leaf.sample(vertex.surface.position, [u_guide / leaf.chance, u_x, u_y])?;
            let wi = vertex.local(toward)?;
            let (value, pdf) = vertex.bsdf.eval(vertex.wo, wi, &self.waves);
            let density = vertex.density(toward, pdf);
            self.importance *= density / pdf;
            let weight = value * (1.0 / density);
            return (pdf > 0.0).then_some(BsdfSample { wi, weight, pdf: Pdf::SolidAngle(pdf), collapses: false });
        }
        let mut sample = vertex.bsdf.sample(vertex.wo, [u_lobe, u_x, u_y], &self.waves)?;
        sample.weight = match sample.pdf {
            Pdf::SolidAngle(pdf) => {
                let expected = vertex.density(vertex.frame.to_world(sample.wi), pdf) / pdf;
                self.importance *= expected;
                sample.weight * (1.0 / expected)
            }
            Pdf::Delta | Pdf::Through(_) => sample.weight * (1.0 / (1.0 - leaf.chance)),
        };
        Some(sample)
    }
}

/// Weight of light that a ray ran into. `densities`: of the scattered ray, and of light sampling for the same direction.
#[inline]
fn hit_weight(densities: Option<(f32, f32)>, limits: &PathLimits) -> f32 {
    match (densities, limits.strategy) {
        (None, _) | (_, Strategy::Bsdf) => 1.0,
        (Some(_), Strategy::Light) => 0.0,
        (Some((scatter_pdf, light_pdf)), Strategy::Mis | Strategy::Shared) => mis_weight(scatter_pdf, light_pdf),
    }
}
