//! The scene as the path loop sees it.
//!
//! A [`Stage`] is built once from a [`Document`]: shapes, images, lights. A [`Scene`] adds the
//! materials, compiled for one colour mode.

mod aim;
mod assembly;
mod beam;
mod camera;
mod environment;
mod groups;
mod light;
mod light_tree;
mod lighting;
mod lights;
mod material;
mod memory;
mod nesting;
mod raster;
mod stage;
mod surface;
mod texture;
mod thickness;

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Instant;

pub use aim::{Aim, Shot};
pub use camera::{Camera, Framing, Placed, View, cameras};
use glam::{Vec2, Vec3};
pub use groups::LightGroups;
use light::Source;
pub use light::{Lamp, LampPoint, LightAt, LightSample};
pub use lights::Lights;
pub use material::Material;
pub use nesting::Interior;
use nesting::Nesting;
pub use raster::{Raster, Window};
pub use stage::{Pose, Stage};
pub use surface::{Place, Surface};
pub use texture::Texture;
use texture::{lookup_rgb, scalar};
use thiserror::Error;

use crate::color::{Emission, IndexError};
use crate::document::Document;
use crate::embree::{EmbreeError, Hit, Hits, Ray};
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
    /// `None` where no body is a medium.
    nesting: Option<Nesting<M>>,
    lets_through: bool,
    /// Seconds that compiling the materials took.
    pub materials_s: f64,
}

/// Why a scene cannot be built.
#[derive(Debug, Error)]
pub enum BuildError {
    #[error("image `{uri}` of {user}: {reason}")]
    Image { uri: String, user: String, reason: String },
    #[error(
        "the scene needs about {bytes} bytes of memory, but only {limit} are available; simplify it or raise --max-memory"
    )]
    Memory { bytes: u64, limit: u64 },
    #[error("material `{material}`: {source}")]
    Index { material: String, source: IndexError },
    #[error("{count} materials have a `priority`; at most {} can", nesting::MOST_MEDIA)]
    Media { count: usize },
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
    /// An unknown refractive index, or too many media.
    pub fn new(stage: Arc<Stage>, options: &FilmOptions) -> Result<Self, BuildError> {
        let start = Instant::now();
        let compile = |material| Material::<M>::new(material, &material::AIR, &stage.sensor, options);
        let materials = stage.materials.iter().map(compile).collect::<Result<Vec<_>, _>>()?;
        let nesting = Nesting::new(&stage, options)?;
        let compile = |(emission, group): &(Emission, usize)| M::group_spectrum(emission, *group, &stage.sensor);
        let spectra = stage.spectra.iter().map(compile).collect();
        let lets_through = nesting.is_some() || materials.iter().any(Material::lets_through);
        let materials_s = start.elapsed().as_secs_f64();
        Ok(Self { stage, materials, spectra, nesting, lets_through, materials_s })
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
            self.materials[index] =
                Material::new(&document.materials[index], &material::AIR, &self.stage.sensor, options)?;
        }
        if self.nesting.as_ref().is_some_and(|nesting| materials.iter().any(|&index| nesting.has(index))) {
            self.nesting = Nesting::new(&self.stage, options)?;
        }
        self.lets_through = self.nesting.is_some() || self.materials.iter().any(Material::lets_through);
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

    /// Of all films of the material at a surface point together, nm; 0 where there is none.
    pub fn film_nm(&self, surface: &Surface) -> f32 {
        let films = &self.stage.materials[surface.material as usize].films;
        films.iter().map(|film| film.thickness.at(surface, self.textures())).sum()
    }

    /// Texture coordinates of the surface that a ray of a batch met, whether or not its material has maps.
    pub fn uv(&self, hits: &Hits, lane: usize) -> Vec2 {
        let uv = |hit: Hit| self.stage.places[hit.place() as usize].uv(&self.stage.accel, &hit);
        hits.get(lane).map_or(Vec2::ZERO, uv)
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

    /// The material that a ray travelling in `interior` finds at the first surface that it meets, and what lies beyond. Of
    /// several surfaces in the same place, `surface` becomes the one that counts. `None` inside a body that takes the
    /// surface's place: light goes on as if nothing were there.
    #[inline]
    pub fn meet<'s>(
        &'s self,
        ray: &Ray,
        surface: &mut Surface<'s>,
        interior: &Interior,
    ) -> (Option<&'s Material<M>>, Interior) {
        if let Some(nesting) = &self.nesting {
            return nesting.meet(self, ray, surface, interior);
        }
        let material = self.material(surface);
        let beyond = match material.absorption_per_m() {
            None => *interior,
            Some(inside) if ray.dir.dot(surface.ng) < 0.0 => Interior::of(inside),
            Some(_) => Interior::AIR,
        };
        (Some(material), beyond)
    }

    /// What surrounds a point.
    pub fn interior_at(&self, point: Vec3) -> Interior {
        self.nesting.as_ref().map_or(Interior::AIR, |nesting| nesting.around(&self.stage, point))
    }

    #[inline]
    pub fn textures(&self) -> &[Arc<Texture>] {
        &self.stage.textures
    }

    /// Radiance that a shining surface sends out on the side of `cos`, the cosine to its outward normal.
    pub fn emitted(&self, surface: &Surface, cos: f32, waves: &M::Waves) -> M::Light {
        match &self.stage.glows[surface.material as usize] {
            Some(glow) if cos > 0.0 || glow.two_sided => {
                let textures = &self.stage.textures;
                let tint = match &glow.radiance.map {
                    Some(map) => lookup_rgb(textures, map, &surface.uv),
                    None => Vec3::ONE,
                };
                let tint = tint * scalar(&glow.opacity, surface, textures).clamp(0.0, 1.0);
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
                    Some(glow) if !glow.is_even() => {
                        let place = &self.stage.places[place as usize];
                        self.emitted(&Surface::at(&self.stage.accel, place, prim, barycentric), cos, waves)
                    }
                    Some(glow) => self.light(&Source { rgb: glow.radiance.value, spectrum: glow.spectrum }, waves),
                    None => M::Light::ZERO,
                }
            }
        }
    }

    /// Calls `add` with radiance and light-sampling density from `from` of each distant light that lies in direction
    /// `toward`.
    pub fn escape(&self, from: Vec3, toward: Vec3, waves: &M::Waves, mut add: impl FnMut(M::Light, f32)) {
        self.stage.lights.escape(from, toward, |source, pdf| add(self.light(&source, waves), pdf));
    }

    /// What absorption leaves over of light on its way through a medium (Beer-Lambert).
    #[inline]
    pub fn left_over(interior: &Interior, distance_m: f32, waves: &M::Waves) -> M::Light {
        M::reflectance((-interior.absorption_per_m * distance_m).exp(), waves)
    }

    /// Share of light that gets from the end of the shadow ray to its origin, which lies in `interior`, and the probability
    /// that a scattered ray would have passed everything in between. Shadow rays count in `rays`.
    pub fn transmittance(&self, ray: &Ray, interior: &Interior, waves: &M::Waves, rays: &mut u64) -> (M::Light, f32) {
        *rays += 1;
        let (mut light, mut probability) = (M::Light::ONE, 1.0);
        let (mut ray, mut interior) = (*ray, *interior);
        for _ in 0..MAX_THROUGH {
            let surface = self.intersect(&ray);
            if interior.absorption_per_m != Vec3::ZERO {
                let distance_m = surface.map_or(ray.tfar, |surface| surface.position.distance(ray.origin));
                if distance_m.is_finite() {
                    light *= Self::left_over(&interior, distance_m, waves);
                }
            }
            let Some(mut surface) = surface else { return (light, probability) };
            let (material, beyond) = self.meet(&ray, &mut surface, &interior);
            if let Some(material) = material {
                let Some((share, chance)) = self.through(material, &surface, -ray.dir, waves) else { break };
                light *= share;
                probability *= chance;
            }
            interior = beyond;
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
    fn through(
        &self,
        material: &Material<M>,
        surface: &Surface,
        wo: Vec3,
        waves: &M::Waves,
    ) -> Option<(M::Light, f32)> {
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
