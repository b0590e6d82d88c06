//! Light that mirrors and lenses throw onto other surfaces, followed from the lamps.
//!
//! A caustic is bright, small, and a path from the camera finds the way to the lamp that makes it by luck alone. A path that
//! begins at the lamp finds it at once: wherever it lands on a matte surface it adds to the pixel that sees it there. Both find
//! the same light, so each is weighed by how likely it was to find it (the balance heuristic). Veach 1997, chapter 10, where
//! light paths are the strategy with one vertex on the lens.
//!
//! Only light that comes to a thrower straight from a lamp is weighed: what others scatter is drawn by next-event estimation,
//! and found well. Camera paths may draw the lamp at a rough thrower, too; a thrower is the last before the lamp in all three
//! ways. The ratio of their densities is taken to be that of the ends alone: along smooth surfaces flux keeps its spread in
//! area and direction, matte ones scatter alike both ways, and rough ones nearly so. Means are kept as all use the same
//! ratio.
//!
//! Lamps without extent (points, spots, parallel light) are drawn, but no camera path runs into them: what smooth surfaces
//! throw of them comes by light paths alone, and whole.

use std::f32::consts::PI;
use std::ops::Range;

use arrayvec::ArrayVec;
use glam::{Vec2, Vec3};

use super::guide::Guide;
use super::vertex::Vertex;
use super::{PathLimits, Tally};
use crate::bsdf::Pdf;
use crate::embree::{BATCH, Hits, Ray};
use crate::math::{Sampler, set_bits};
use crate::mode::{Lanes, Mode};
use crate::scene::{Aim, Camera, Interior, Lamp, Scene, Shot, Surface, View};

/// Surfaces that a light path may meet.
const MAX_SURFACES: u32 = 64;
/// Mirrors and lenses that are not smooth which a light path may be sent on by: camera paths draw a lamp at each, and keep
/// apart what they find.
pub(super) const MOST_ROUGH: u32 = 6;
/// Photons are a small part of a picture's rays.
const PATHS_PER_PHOTON: u32 = 2;
const MAX_PHOTONS: u32 = 1 << 18;
/// Salt of the numbers that light paths draw: those of pixels are others.
const SALT: u32 = 0x6c_69_67_68;

/// The light paths of a picture.
pub struct Throw {
    pub(super) aim: Aim,
    camera: Camera,
    /// Where to look for what is not seen from the camera.
    pub(super) guide: Option<Guide>,
    /// Paths in a round; each round adds to one sample of every pixel.
    pub count: u32,
}

/// What a light path brings to a point of the picture, in pixels from the upper left: its share of a round's radiance there,
/// per pixel.
pub struct Landing<M: Mode> {
    pub at: Vec2,
    pub radiance: M::Light,
    /// Density of the path in relation to that of a camera path that finds the same; infinite where none does.
    pub share: f32,
    pub waves: M::Waves,
    /// For whoever needs to choose a pixel.
    pub u: [f32; 2],
}

/// Light that a camera path found.
#[derive(Clone, Copy)]
pub(super) struct Find<L> {
    pub light: L,
    /// Of light paths that bring it, too, where they leave the lamp: per m2 across them and sr, over how many times as likely
    /// camera paths were to find it in one of their ways as by running into the lamp. 0 where none do.
    pub density: f32,
}

/// The last surface before a lamp.
#[derive(Clone, Copy)]
pub(super) struct Thrower {
    /// [`Place::number`](crate::scene::Place::number).
    pub place: u32,
    pub at: Vec3,
    /// Density with which camera paths are scattered towards the lamp; infinite where it is smooth.
    pub pdf: f32,
}

impl Thrower {
    /// How likely camera paths that come here are to be scattered towards a lamp in direction `toward`, over how likely they
    /// are to find it, by running into it or drawing it; infinite where they cannot.
    fn scattered_per_find<M: Mode>(&self, scene: &Scene<M>, lamp: &Lamp, toward: Vec3) -> f32 {
        let lights = &scene.stage.lights;
        if self.pdf.is_infinite() {
            return if lamp.is_singular() { f32::INFINITY } else { 1.0 };
        }
        let drawn = match lamp {
            Lamp::Surface(lamp) => lights.surface_pdf(self.at, lamp),
            Lamp::Point { emitter, .. } | Lamp::Parallel { emitter } => lights.probability(self.at, *emitter),
            Lamp::Beyond => lights.distant_pdf(self.at, toward),
        };
        let hit = if lamp.is_singular() { 0.0 } else { self.pdf };
        if self.pdf > 0.0 { self.pdf / (hit + drawn) } else { 0.0 }
    }
}

impl<L: Lanes> Find<L> {
    pub const NOTHING: Self = Self { light: L::ZERO, density: 0.0 };

    /// What counts of it where the path's first surface has this footprint ([`Throw::footprint`]).
    #[inline]
    pub fn weighed(&self, footprint_m2_sr: f32) -> L {
        self.light * (1.0 / (1.0 + footprint_m2_sr * self.density))
    }
}

impl Throw {
    /// `None` where nothing throws light.
    pub fn new<M: Mode>(scene: &Scene<M>, camera: &Camera, count: u32) -> Option<Self> {
        Some(Self { aim: Aim::new(scene)?, camera: camera.clone(), guide: None, count })
    }

    /// True where there is light that camera paths cannot find, whatever they cost.
    pub fn is_needed(&self) -> bool {
        self.aim.has_singular_lamps()
    }

    /// Learns from photons where to look for what light paths cannot bring.
    pub fn send_photons<M: Mode>(&mut self, scene: &Scene<M>) {
        self.guide = Guide::new(scene, &self.aim, (self.count / PATHS_PER_PHOTON).min(MAX_PHOTONS));
    }

    /// What the density of light paths at a surface is to be multiplied with to be compared with the density of camera paths
    /// that see it first and are scattered there: 0 where light paths add nothing.
    pub(super) fn footprint<M: Mode>(&self, vertex: &Vertex<M>) -> f32 {
        let seen = self.camera.see(vertex.surface.position, [0.5; 2]);
        let Some(seen) = seen.filter(|_| vertex.is_matte() && !vertex.bent) else { return 0.0 };
        let cos = seen.toward.dot(vertex.surface.ng).abs();
        self.count as f32 * PI * seen.pixel_m2 / cos.max(1e-6)
    }

    /// [`Find::density`] of light from a lamp in direction `toward`, sent on by a thrower.
    pub(super) fn density<M: Mode>(
        &self,
        scene: &Scene<M>,
        thrower: &Thrower,
        lamp: &Lamp,
        toward: Vec3,
        waves: &M::Waves,
    ) -> f32 {
        let density = self.aim.density(scene, thrower.place, thrower.at, lamp, toward, waves);
        if density > 0.0 { density * thrower.scattered_per_find(scene, lamp, toward) } else { 0.0 }
    }

    /// Follows up to [`BATCH`] light paths of a round, by their numbers, and tells `land` what they bring.
    pub fn follow<M: Mode>(
        &self,
        scene: &Scene<M>,
        limits: &PathLimits,
        (round, numbers, seed): (u32, Range<u32>, u32),
        tally: &mut Tally,
        mut land: impl FnMut(Landing<M>),
    ) {
        let send = |number| LightPath::new(scene, &self.aim, Sampler::new(round, number, seed ^ SALT));
        let mut paths: ArrayVec<LightPath<M>, BATCH> = numbers.filter_map(send).collect();
        let (mut rays, mut shadows) = ([Ray::NONE; BATCH], [Ray::NONE; BATCH]);
        let mut hits = Hits::default();
        let mut active = 0u8;
        for (i, path) in paths.iter().enumerate() {
            rays[i] = path.ray;
            active |= 1 << i;
        }
        for _ in 0..MAX_SURFACES {
            if active == 0 {
                break;
            }
            tally.rays += u64::from(active.count_ones());
            scene.stage.intersect_batch(&rays, active, &mut hits);
            let mut landings = ArrayVec::<(usize, Landing<M>), BATCH>::new();
            let mut doubtful = 0;
            for i in set_bits(active) {
                let path = &mut paths[i];
                let goes_on = scene.surface(&hits, i).is_some_and(|surface| {
                    let Some(mut vertex) = path.arrive(scene, surface) else { return true };
                    if let Some((landing, way)) = self.land(scene, &vertex, path, tally) {
                        landings.push((i, landing));
                        shadows[i] = way;
                        doubtful |= u8::from(!scene.lets_through()) << i;
                    }
                    path.send_on(scene, &mut vertex, (self, limits))
                });
                rays[i] = path.ray;
                if !goes_on {
                    active &= !(1 << i);
                }
            }
            tally.shadow_rays += u64::from(doubtful.count_ones());
            let hidden = scene.stage.occluded_batch(&shadows, doubtful);
            for (i, landing) in landings {
                if hidden >> i & 1 == 0 {
                    land(landing);
                }
            }
        }
    }

    /// What light that arrives at a surface brings to the picture, if nothing lies on the ray to the camera.
    fn land<M: Mode>(
        &self,
        scene: &Scene<M>,
        vertex: &Vertex<M>,
        path: &mut LightPath<M>,
        tally: &mut Tally,
    ) -> Option<(Landing<M>, Ray)> {
        let footprint = self.footprint(vertex);
        let lands = footprint > 0.0 || path.is_unrivalled() && vertex.is_broad_metal() && !vertex.bent;
        let share = if path.is_unrivalled() { f32::INFINITY } else { footprint * path.density };
        if path.bounce == 0 || !lands || share == 0.0 {
            return None;
        }
        let [u_lens_x, u_lens_y, u_x, u_y] = path.sampler.next_4d();
        let View { at, toward, distance_m, pixel_m2 } =
            self.camera.see(vertex.surface.position, [u_lens_x, u_lens_y])?;
        let local = vertex.local(toward).filter(|_| vertex.looks_the_same(toward))?;
        let (value, _) = vertex.bsdf.eval(vertex.wo, local, &path.waves);
        let caught = if share.is_finite() { share / (1.0 + share) } else { 1.0 };
        let weight = caught * vertex.adjoint(toward) / (pixel_m2 * self.count as f32);
        let mut radiance = path.power * value * weight;
        let way = Ray { tfar: distance_m, ..Ray::new(vertex.surface.leave(toward), toward) };
        if scene.lets_through() {
            radiance *= scene.transmittance(&way, &vertex.interior, &path.waves, &mut tally.shadow_rays).0;
        } else if vertex.interior.absorption_per_m != Vec3::ZERO {
            radiance *= Scene::<M>::left_over(&vertex.interior, distance_m, &path.waves);
        }
        let counts = !radiance.is_black() && radiance.is_finite();
        counts.then_some((Landing { at, radiance, share, waves: path.waves, u: [u_x, u_y] }, way))
    }
}

/// A path that begins at a lamp.
struct LightPath<M: Mode> {
    ray: Ray,
    interior: Interior,
    waves: M::Waves,
    sampler: Sampler,
    /// W: light over the density of all that was drawn.
    power: M::Light,
    /// Where it comes from and the place that it was aimed at.
    lamp: Lamp,
    place: u32,
    /// [`Find::density`] of what it brings, once it has been thrown.
    density: f32,
    bounce: u32,
    rough_throwers: u32,
    /// For the surface and its holes.
    u_surface: [f32; 4],
}

impl<M: Mode> LightPath<M> {
    fn new(scene: &Scene<M>, aim: &Aim, mut sampler: Sampler) -> Option<Self> {
        let [u_wave, ..] = sampler.next_4d();
        let waves = M::waves(u_wave);
        let u = [sampler.next_4d(), sampler.next_4d()];
        let Shot { ray, interior, light, density, place, lamp } = aim.shoot(scene, u, &waves)?;
        let (power, density) = (light * (1.0 / density), 0.0);
        let (bounce, rough_throwers, u_surface) = (0, 0, [0.0; 4]);
        Some(Self { ray, interior, waves, sampler, power, lamp, place, density, bounce, rough_throwers, u_surface })
    }

    /// True where no camera path finds what it brings: a smooth surface threw light of a lamp without extent.
    fn is_unrivalled(&self) -> bool {
        self.density.is_infinite()
    }

    /// Takes the path to what its ray met: the vertex there, or nothing where it goes through a hole.
    fn arrive<'s>(&mut self, scene: &'s Scene<M>, mut surface: Surface<'s>) -> Option<Vertex<'s, M>> {
        self.u_surface = self.sampler.next_4d();
        let (material, beyond) = scene.meet(&self.ray, &mut surface, &self.interior);
        if self.interior.absorption_per_m != Vec3::ZERO {
            let distance_m = surface.position.distance(self.ray.origin);
            self.power *= Scene::<M>::left_over(&self.interior, distance_m, &self.waves);
        }
        let there = material.filter(|material| self.u_surface[3] < material.coverage(&surface, scene.textures()));
        if there.is_none() {
            self.ray = Ray::new(surface.leave(self.ray.dir), self.ray.dir);
            self.interior = beyond;
        }
        let interiors = [self.interior, beyond];
        there.map(|material| Vertex::new(scene, (surface, material), -self.ray.dir, interiors, &self.waves))
    }

    /// Samples the surface; false where the path ends.
    fn send_on(&mut self, scene: &Scene<M>, vertex: &mut Vertex<M>, (throw, limits): (&Throw, &PathLimits)) -> bool {
        let [u_x, u_y, u_lobe, _] = self.u_surface;
        let u = [u_lobe, u_x, u_y];
        let Some(sample) = vertex.sample_thrown(self.bounce == 0, u, &self.waves) else { return false };
        let wi = vertex.frame.to_world(sample.wi);
        let crosses = sample.wi.z * vertex.wo.z < 0.0;
        if let Pdf::Through(_) = sample.pdf {
            self.power *= sample.weight;
        } else {
            let toward = -self.ray.dir;
            let is_smooth = sample.pdf == Pdf::Delta;
            let throws = vertex.throws(toward, is_smooth) || is_smooth && self.lamp.is_singular();
            let aimed = self.bounce > 0 || throws && vertex.surface.place.number == self.place;
            let same_side = wi.dot(vertex.surface.ng) * sample.wi.z > 0.0;
            self.rough_throwers += u32::from(vertex.is_thrower() && !is_smooth);
            let is_followed = vertex.is_reversible() || self.is_unrivalled() && !vertex.bent;
            if !aimed || !same_side || !is_followed || self.rough_throwers > MOST_ROUGH {
                return false;
            }
            if self.bounce == 0 {
                // As camera paths that come this way see it.
                let pdf = match sample.pdf {
                    Pdf::SolidAngle(_) => vertex.bsdf.eval(sample.wi, vertex.wo, &self.waves).1,
                    Pdf::Delta | Pdf::Through(_) => f32::INFINITY,
                };
                let thrower = Thrower { place: self.place, at: vertex.surface.position, pdf };
                self.density = throw.density(scene, &thrower, &self.lamp, toward, &self.waves);
                if let Lamp::Point { emitter, position } = self.lamp {
                    self.power = self.power * scene.stage.lights.gain(emitter, position.distance(thrower.at));
                }
            }
            self.bounce += 1;
            if self.bounce >= limits.max_bounces {
                return false;
            }
            // Light is not compressed in dense bodies as radiance is.
            let scale = if crosses { vertex.bsdf.compression(sample.wi.z < 0.0) } else { 1.0 };
            self.power *= sample.weight * (scale * vertex.adjoint(wi));
            if sample.collapses {
                M::collapse(&mut self.waves);
            }
            // Where light is absorbed paths end, so that all that are left carry about as much.
            if let Pdf::SolidAngle(_) = sample.pdf {
                let survival = sample.weight.max().min(0.95);
                let [u_survival, ..] = self.sampler.next_4d();
                if u_survival >= survival {
                    return false;
                }
                self.power = self.power * (1.0 / survival);
            }
        }
        if crosses {
            self.interior = vertex.beyond;
        }
        self.ray = Ray::new(vertex.surface.leave(wi), wi);
        true
    }
}
