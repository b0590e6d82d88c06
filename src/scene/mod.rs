//! The scene as the path loop sees it.
//!
//! A [`Stage`] is built once from a [`Document`]: shapes, images, lights. A [`Scene`] adds the
//! materials, compiled for one colour mode.

mod assembly;
mod camera;
mod caster;
mod environment;
mod light;
mod lighting;
mod material;
mod stage;
mod surface;
mod texture;
mod thickness;

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Instant;

pub use camera::{Camera, Framing, Placed, cameras};
pub use caster::Caster;
use glam::Vec3;
use light::Source;
pub use light::{LightAt, LightSample, Lights};
pub use material::Material;
pub use stage::{Pose, Stage};
pub use surface::{Place, Surface};
use texture::{Texture, lookup_rgb};
use thiserror::Error;

use crate::color::IndexError;
use crate::document::Document;
use crate::embree::{EmbreeError, Hits, Ray};
use crate::film::{Rung, Verdict};
use crate::math::Frame;
use crate::mode::{Lanes, Mode};

/// Surfaces that one shadow ray may pass through.
const MAX_THROUGH: u32 = 64;

/// How films are compiled.
#[derive(Clone, Copy, Debug)]
pub struct FilmOptions {
    /// Largest CIEDE2000 that a cheaper film model may cost.
    pub tolerance: f32,
    /// Force one film model.
    pub rung: Option<Rung>,
}

pub struct Scene<M: Mode> {
    pub stage: Arc<Stage>,
    materials: Vec<Material<M>>,
    spectra: Vec<M::Spectrum>,
    lets_through: bool,
    /// Seconds that compiling the materials took.
    pub materials_s: f64,
}

/// Why a scene cannot be built.
#[derive(Debug, Error)]
pub enum BuildError {
    #[error("image `{uri}`: {reason}")]
    Image { uri: String, reason: String },
    #[error("material `{material}`: {source}")]
    Index { material: String, source: IndexError },
    #[error(transparent)]
    Embree(#[from] EmbreeError),
    /// A scene can be posed only by its one owner.
    #[error("the stage is in use by another scene and cannot be moved")]
    Shared,
}

impl<M: Mode> Scene<M> {
    /// Compiles the materials of a stage.
    ///
    /// # Errors
    /// An unknown refractive index.
    pub fn new(stage: Arc<Stage>, options: &FilmOptions) -> Result<Self, BuildError> {
        let start = Instant::now();
        let compile = |material| Material::<M>::new(material, &stage.sensor, options);
        let materials = stage.materials.iter().map(compile).collect::<Result<Vec<_>, _>>()?;
        let spectra = stage.spectra.iter().map(|emission| M::spectrum(emission, &stage.sensor)).collect();
        let lets_through = materials.iter().any(Material::lets_through);
        let materials_s = start.elapsed().as_secs_f64();
        Ok(Self { stage, materials, spectra, lets_through, materials_s })
    }

    /// As [`Stage::pose`].
    ///
    /// # Errors
    /// As [`Stage::pose`]; [`BuildError::Shared`] while another scene uses the stage.
    pub fn pose(&mut self, document: &Document, pose: &Pose) -> Result<usize, BuildError> {
        Arc::get_mut(&mut self.stage).ok_or(BuildError::Shared)?.pose(document, pose)
    }

    /// Compiles these materials of the document again.
    ///
    /// # Errors
    /// An unknown refractive index.
    pub fn recompile(
        &mut self,
        document: &Document,
        materials: &BTreeSet<usize>,
        options: &FilmOptions,
    ) -> Result<(), BuildError> {
        for &index in materials {
            self.materials[index] = Material::new(&document.materials[index], &self.stage.sensor, options)?;
        }
        self.lets_through = self.materials.iter().any(Material::lets_through);
        Ok(())
    }

    /// What was chosen for each interface: (material id, verdict).
    pub fn verdicts(&self) -> impl Iterator<Item = (&str, &Verdict)> {
        let named = self.stage.materials.iter().zip(&self.materials);
        named.filter_map(|(source, compiled)| Some((source.id.as_str(), compiled.verdict.as_ref()?)))
    }

    /// The first surface along a ray.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<Surface<'_>> {
        let hit = self.stage.accel.intersect(ray)?;
        Some(Surface::new(&self.stage.accel, &self.stage.places[hit.place() as usize], &hit))
    }

    /// The surface that a ray of a batch met.
    #[inline]
    pub fn surface(&self, hits: &Hits, lane: usize) -> Option<Surface<'_>> {
        let hit = hits.get(lane)?;
        Some(Surface::new(&self.stage.accel, &self.stage.places[hit.place() as usize], &hit))
    }

    /// True when shadow rays must look at what they meet ([`Scene::transmittance`]) instead of only whether they meet
    /// anything.
    #[inline]
    pub fn lets_through(&self) -> bool {
        self.lets_through
    }

    #[inline]
    pub fn material(&self, surface: &Surface) -> &Material<M> {
        &self.materials[surface.material as usize]
    }

    #[inline]
    pub fn textures(&self) -> &[Arc<Texture>] {
        &self.stage.textures
    }

    /// Radiance that a shining surface sends out on the side of `cos`, the cosine to its outward normal.
    pub fn emitted(&self, surface: &Surface, cos: f32, waves: &M::Waves) -> M::Light {
        match &self.stage.glows[surface.material as usize] {
            Some(glow) if cos > 0.0 || glow.two_sided => {
                let tint = match &glow.radiance.map {
                    Some(map) => lookup_rgb(&self.stage.textures, map, surface.uv),
                    None => Vec3::ONE,
                };
                self.light(&Source { rgb: glow.radiance.value * tint, spectrum: glow.spectrum }, waves)
            }
            _ => M::Light::ZERO,
        }
    }

    #[inline]
    fn light(&self, source: &Source, waves: &M::Waves) -> M::Light {
        M::emitted(&self.spectra[source.spectrum as usize], source.rgb, waves)
    }

    /// What a drawn light sends towards the point that it was drawn for.
    #[inline]
    pub fn arriving(&self, light: &LightAt, waves: &M::Waves) -> M::Light {
        match *light {
            LightAt::Radiance(ref source) => self.light(source, waves),
            LightAt::Surface { place, material, prim, barycentric, cos } => {
                match &self.stage.glows[material as usize] {
                    Some(glow) if glow.radiance.map.is_some() => {
                        let place = &self.stage.places[place as usize];
                        self.emitted(&Surface::at(&self.stage.accel, place, prim, barycentric), cos, waves)
                    }
                    Some(glow) => self.light(&Source { rgb: glow.radiance.value, spectrum: glow.spectrum }, waves),
                    None => M::Light::ZERO,
                }
            }
        }
    }

    /// Calls `add` with radiance and light-sampling density of each distant light that lies in direction `toward`.
    pub fn escape(&self, toward: Vec3, waves: &M::Waves, mut add: impl FnMut(M::Light, f32)) {
        self.stage.lights.escape(toward, |source, pdf| add(self.light(&source, waves), pdf));
    }

    /// Share of light that gets from the end of the shadow ray to its origin, and the probability that a scattered ray
    /// would have passed everything in between. Shadow rays count in `rays`.
    pub fn transmittance(&self, ray: &Ray, waves: &M::Waves, rays: &mut u64) -> (M::Light, f32) {
        *rays += 1;
        let (mut light, mut probability) = (M::Light::ONE, 1.0);
        let mut ray = *ray;
        for _ in 0..MAX_THROUGH {
            let Some(surface) = self.intersect(&ray) else { return (light, probability) };
            let Some((share, chance)) = self.through(&surface, -ray.dir, waves) else { break };
            light *= share;
            probability *= chance;
            // The end point stays where it is while the origin moves on.
            let origin = surface.leave(ray.dir);
            let left = if ray.tfar.is_finite() { (ray.at(ray.tfar) - origin).dot(ray.dir) } else { f32::INFINITY };
            if left <= 0.0 {
                return (light, probability);
            }
            ray = Ray { origin, tfar: left, ..ray };
            *rays += 1;
        }
        (M::Light::ZERO, 0.0)
    }

    /// Light that passes a surface unbent, and the chance that the path loop lets it: `None` where it never does.
    fn through(&self, surface: &Surface, wo: Vec3, waves: &M::Waves) -> Option<(M::Light, f32)> {
        let material = self.material(surface);
        if !material.lets_through() {
            return None;
        }
        let textures = self.textures();
        let coverage = material.coverage(surface, textures);
        let frame = Frame::new(material.normal(surface, textures));
        let straight = material.bsdf(surface, textures, waves).through(frame.to_local(wo), waves);
        let hole = 1.0 - coverage;
        match straight {
            None if hole > 0.0 => Some((M::Light::splat(hole), hole)),
            None => None,
            Some((light, chance)) => Some((light * coverage + M::Light::splat(hole), hole + coverage * chance)),
        }
    }
}
