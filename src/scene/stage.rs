//! Everything of a scene that does not depend on the colour mode: shapes, images, lights. Built once, shared by all modes.

use std::sync::Arc;
use std::time::Instant;

use glam::{Mat3, Mat4, Vec3};

use super::BuildError;
use super::assembly::{Assembly, Built, Ground};
use super::environment::Sky;
use super::groups::LightGroups;
use super::light::Emitter;
use super::lighting;
use super::lights::Lights;
use super::memory;
use super::nesting::Together;
use super::surface::{Glow, Place, Surface};
use super::texture::Texture;
use crate::color::{Emission, Sensor};
use crate::document::{self, Document};
use crate::embree::{Accel, AccelBuilder, Hits, Ray, Rays};

pub struct Stage {
    pub(super) accel: Accel,
    pub(super) places: Vec<Place>,
    /// Descriptions, by the material numbers that surfaces carry.
    pub(super) materials: Vec<document::Material>,
    /// What each material emits.
    pub(super) glows: Vec<Option<Glow>>,
    pub(super) textures: Vec<Arc<Texture>>,
    /// The distinct spectra of all lights, each with the light group that shines in it, by the numbers that sources carry.
    pub spectra: Vec<(Emission, usize)>,
    pub groups: LightGroups,
    pub lights: Lights,
    /// What looks white in the picture, and the sensor for which it does.
    pub white: Emission,
    pub sensor: Sensor,
    /// Corners of a box around everything, world space; a unit box when the scene is empty.
    pub bounds: (Vec3, Vec3),
    /// For each placement of the document, whether it may move; empty: none may.
    moving: Vec<bool>,
    /// The last move failed: the instances stand where they stood before it.
    stale: bool,
    pub textures_s: f64,
    pub bvh_s: f64,
}

/// The box of an empty scene.
const NOTHING: (Vec3, Vec3) = (Vec3::splat(-0.5), Vec3::splat(0.5));

/// Half the diagonal of a box.
fn size_m((low, high): (Vec3, Vec3)) -> f32 {
    0.5 * (high - low).length()
}

/// Where everything stands.
pub struct Pose {
    /// As [`Document::placements`] gives them, with other matrices.
    pub placements: Vec<(usize, Mat4)>,
    /// Turns the environment; its own rotation comes first.
    pub sky: Mat3,
}

impl Stage {
    /// What the `active` rays (bit i for ray i) meet first, for [`Scene::surface`](super::Scene::surface).
    #[inline]
    pub fn intersect_batch(&self, rays: impl Into<Rays>, active: u8, hits: &mut Hits) {
        self.accel.intersect_batch(rays, active, hits);
    }

    /// Which of the `active` rays (bit i for ray i) meet any surface, whatever it is made of.
    #[inline]
    pub fn occluded_batch(&self, rays: impl Into<Rays>, active: u8) -> u8 {
        self.accel.occluded_batch(rays, active)
    }

    /// Calls `found` for every surface along a ray, in no order.
    pub(super) fn each_surface<'s>(&'s self, ray: &Ray, mut found: impl FnMut(Surface<'s>)) {
        self.accel.every_hit(ray, |hit| found(Surface::new(&self.accel, &self.places[hit.place() as usize], &hit)));
    }

    /// The first surface along a ray and those that lie in the same place, closer than `tolerance` times the rounding of a
    /// hit; a ray that leaves any of them begins beyond all.
    pub(super) fn together<'s>(&'s self, ray: &Ray, first: Surface<'s>, tolerance: f32) -> Together<'s> {
        let mut here = Together::new();
        here.push(first);
        // Errors are measured across the surface; a ray along it takes longer to get through them.
        let rounding = first.error_m / ray.dir.dot(first.ng).abs().max(0.01);
        let origin = first.position - ray.dir * rounding;
        let probe = Ray { origin, tnear: 0.0, tfar: (1.0 + tolerance) * rounding, ..*ray };
        self.each_surface(&probe, |surface| {
            let side = |surface: &Surface| ray.dir.dot(surface.ng) < 0.0;
            let known = |other: &Surface| std::ptr::eq(surface.place, other.place) && side(&surface) == side(other);
            // More than the list holds are more than any scene has use for.
            if !here.is_full() && !here.iter().any(known) {
                here.push(surface);
            }
        });
        if here.len() > 1 {
            here.iter_mut().for_each(|surface| surface.error_m *= 2.0 * tolerance);
        }
        here
    }

    /// `threads` share the building; 0 = all. It takes what memory it takes.
    ///
    /// # Errors
    /// An image that cannot be decoded, or Embree running out of memory.
    pub fn new(document: &Document, threads: usize) -> Result<Self, BuildError> {
        Self::movable(document, threads, Vec::new(), LightGroups::default(), u64::MAX)
    }

    /// A stage of which parts can [`pose`](Self::pose) later: `moving` tells for each of the document's placements whether
    /// it may. What may move is placed as an instance, which is slower to trace. `groups` tells lights apart, where that is
    /// wanted. What would take more than `max_bytes` of memory is refused before it is built.
    ///
    /// # Errors
    /// As [`Stage::new`]; or the bytes that it needs.
    pub fn movable(
        document: &Document,
        threads: usize,
        moving: Vec<bool>,
        groups: LightGroups,
        max_bytes: u64,
    ) -> Result<Self, BuildError> {
        let start = Instant::now();
        let placements = document.placements();
        let mut left = memory::check(document, &placements, max_bytes)?;
        let mut textures = Vec::with_capacity(document.images.len());
        for image in &document.images {
            let texture = Texture::load(image, left)?;
            left = left.saturating_sub(texture.bytes());
            textures.push(Arc::new(texture));
        }
        let textures_s = start.elapsed().as_secs_f64();

        let start = Instant::now();
        let mut builder = AccelBuilder::new(threads)?;
        let mut assembly = Assembly::new(Ground::New(&mut builder), &moving, &groups);
        assembly.gather(document, &placements, &textures, None)?;
        let Assembly { places, materials, glows, emitters, spectra, strength, .. } = assembly;
        let accel = builder.build()?;
        let bounds = accel.bounds().unwrap_or(NOTHING);
        let white = lighting::white(document, &placements);
        Ok(Self {
            accel,
            places,
            materials,
            glows,
            textures,
            spectra,
            groups,
            lights: Lights::new(emitters, &strength, size_m(bounds)),
            sensor: Sensor::new(&white),
            white,
            bounds,
            moving,
            stale: false,
            textures_s,
            bvh_s: start.elapsed().as_secs_f64(),
        })
    }

    /// Brings the stage to another pose of the same document: transforms, colours of lights and values of materials may be
    /// others, everything else is as it was. Instances move where they are movable; nothing else in the BVH changes. Returns
    /// how many moved. The outcome does not depend on earlier poses.
    ///
    /// # Errors
    /// A transform that cannot be inverted, or Embree running out of memory; another pose can follow.
    pub fn pose(&mut self, document: &Document, pose: &Pose) -> Result<usize, BuildError> {
        let emitters = std::mem::take(&mut self.lights.emitters);
        let sky = emitters.into_iter().find_map(|emitter| match emitter {
            Emitter::Sky(Sky::Image(image)) => Some(image),
            _ => None,
        });
        let places = std::mem::take(&mut self.places).into_iter();
        let mut built = Built { places, moves: Vec::new(), stale: self.stale };
        let mut assembly = Assembly::new(Ground::Built(&mut built), &self.moving, &self.groups);
        assembly.gather(document, &pose.placements, &self.textures, Some((sky, pose.sky)))?;
        let Assembly { places, materials, glows, emitters, spectra, strength, .. } = assembly;
        (self.places, self.materials, self.glows, self.spectra) = (places, materials, glows, spectra);

        let moved = if built.moves.is_empty() { Ok(()) } else { self.accel.move_instances(&built.moves) };
        self.stale = moved.is_err();
        self.bounds = self.accel.bounds().unwrap_or(NOTHING);
        self.lights = Lights::new(emitters, &strength, size_m(self.bounds));
        moved?;
        Ok(built.moves.len())
    }
}
