//! Everything of a scene that does not depend on the colour mode: shapes, images, lights. Built once, shared by all modes.

use std::sync::Arc;
use std::time::Instant;

use glam::Vec3;

use super::BuildError;
use super::assembly::Assembly;
use super::environment::{Sky, SkyImage};
use super::light::{Emitter, Lights};
use super::lighting;
use super::surface::{Glow, Place};
use super::texture::Texture;
use crate::color::{Emission, Sensor};
use crate::document::{self, Document, Scalar};
use crate::embree::{Accel, AccelBuilder, BATCH, Hits, Ray};

pub struct Stage {
    pub(super) accel: Accel,
    pub(super) places: Vec<Place>,
    /// Descriptions, by the material numbers that surfaces carry.
    pub(super) materials: Vec<document::Material>,
    /// What each material emits.
    pub(super) glows: Vec<Option<Glow>>,
    pub(super) textures: Vec<Arc<Texture>>,
    /// The distinct spectra of all lights, by the numbers that sources carry.
    pub spectra: Vec<Emission>,
    pub lights: Lights,
    pub sensor: Sensor,
    /// Corners of a box around everything, world space; a unit box when the scene is empty.
    pub bounds: (Vec3, Vec3),
    pub textures_s: f64,
    pub bvh_s: f64,
}

impl Stage {
    /// What the `active` rays (bit i for ray i) meet first, for [`Scene::surface`](super::Scene::surface).
    #[inline]
    pub fn intersect_batch(&self, rays: &[Ray; BATCH], active: u8) -> Hits {
        self.accel.intersect_batch(rays, active)
    }

    /// Which of the `active` rays (bit i for ray i) meet any surface, whatever it is made of.
    #[inline]
    pub fn occluded_batch(&self, rays: &[Ray; BATCH], active: u8) -> u8 {
        self.accel.occluded_batch(rays, active)
    }

    /// `threads` share the building; 0 = all.
    ///
    /// # Errors
    /// An image that cannot be decoded, or Embree running out of memory.
    pub fn new(document: &Document, threads: usize) -> Result<Self, BuildError> {
        let start = Instant::now();
        let decode = |image| Texture::load(image).map(Arc::new);
        let textures = document.images.iter().map(decode).collect::<Result<Vec<_>, _>>()?;
        let textures_s = start.elapsed().as_secs_f64();

        let start = Instant::now();
        let placements = document.placements();
        let mut assembly = Assembly {
            builder: AccelBuilder::new(threads)?,
            places: Vec::new(),
            materials: Vec::new(),
            glows: Vec::new(),
            emitters: Vec::new(),
            spectra: Vec::new(),
            power: Vec::new(),
        };
        let fallback = document::Material { opacity: Scalar::constant(1.0), ..document::Material::default() };
        for material in document.materials.iter().chain([&fallback]) {
            assembly.add_material(material.clone());
        }
        assembly.place_geometry(document, &placements)?;
        assembly.place_lights(document, &placements)?;
        if let Some(environment) = &document.environment {
            let tint = assembly.source(environment.radiance * environment.strength, &environment.spectrum);
            let sky = match environment.image {
                Some(image) => Sky::Image(Box::new(SkyImage::new(&textures[image], tint, environment.rotation_deg))),
                None => Sky::Constant(tint),
            };
            assembly.emitters.push(Emitter::Sky(sky));
            assembly.power.push(f32::NAN);
        }
        let Assembly { builder, places, materials, glows, emitters, spectra, mut power } = assembly;
        let accel = builder.build()?;
        let bounds = accel.bounds().unwrap_or((Vec3::splat(-0.5), Vec3::splat(0.5)));
        lighting::weigh_distant(&emitters, &mut power, bounds);
        Ok(Self {
            accel,
            places,
            materials,
            glows,
            textures,
            spectra,
            lights: Lights::new(emitters, &power),
            sensor: Sensor::new(&lighting::white(document, &placements)),
            bounds,
            textures_s,
            bvh_s: start.elapsed().as_secs_f64(),
        })
    }
}
