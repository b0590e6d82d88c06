//! The scene as the path loop sees it: built once from a [`Document`](crate::document::Document) for one colour mode.

mod build;
mod camera;
mod environment;
mod light;
mod lighting;
mod material;
mod surface;
mod texture;
mod thickness;

pub use build::{BuildOptions, BuildTimes, build};
pub use camera::{Camera, Framing, Placed, cameras};
use glam::Vec3;
pub use light::{LightAt, LightSample, Lights};
pub use material::Material;
pub use surface::{Place, Surface};
use texture::Texture;
use thiserror::Error;

use crate::color::{IndexError, Sensor};
use crate::embree::{Accel, EmbreeError, Ray};
use crate::film::Verdict;
use crate::mode::{Lanes, Mode};

/// Surfaces that one shadow ray may pass through.
const MAX_THROUGH: u32 = 64;

pub struct Scene<M: Mode> {
    accel: Accel,
    places: Vec<Place>,
    materials: Vec<Material<M>>,
    textures: Vec<Texture>,
    pub lights: Lights<M>,
    pub sensor: Sensor,
    /// Corners of a box around everything, world space; a unit box when the scene is empty.
    pub bounds: (Vec3, Vec3),
    /// True when shadow rays must look at what they meet instead of only whether they meet anything.
    lets_through: bool,
    /// Seconds that each part of building took.
    pub times: BuildTimes,
    /// What was chosen for each coated or bare interface: (material id, verdict).
    pub verdicts: Vec<(String, Verdict)>,
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
}

impl<M: Mode> Scene<M> {
    /// The first surface along a ray.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<Surface<'_>> {
        let hit = self.accel.intersect(ray)?;
        Some(Surface::new(&self.accel, &self.places[hit.place() as usize], &hit))
    }

    #[inline]
    pub fn material(&self, surface: &Surface) -> &Material<M> {
        &self.materials[surface.material as usize]
    }

    #[inline]
    pub fn textures(&self) -> &[Texture] {
        &self.textures
    }

    /// What a drawn light sends towards the point that it was drawn for.
    pub fn arriving(&self, light: &LightAt<M::Light>, waves: &M::Waves) -> M::Light {
        match *light {
            LightAt::Radiance(radiance) => radiance,
            LightAt::Surface { place, material, prim, barycentric, cos } => {
                let material = &self.materials[material as usize];
                match &material.emission {
                    Some(emission) if emission.radiance.map.is_some() => {
                        let surface = Surface::at(&self.accel, &self.places[place as usize], prim, barycentric);
                        material.emitted(&surface, cos, &self.textures, waves)
                    }
                    Some(emission) => emission.uniform(cos, waves),
                    None => M::Light::ZERO,
                }
            }
        }
    }

    /// Share of light that gets from the end of the shadow ray to its origin, and the probability that a scattered ray
    /// would have passed everything in between. Shadow rays count in `rays`.
    pub fn transmittance(&self, ray: &Ray, waves: &M::Waves, rays: &mut u64) -> (M::Light, f32) {
        *rays += 1;
        if !self.lets_through {
            return if self.accel.occluded(ray) { (M::Light::ZERO, 0.0) } else { (M::Light::ONE, 1.0) };
        }
        let (mut light, mut probability) = (M::Light::ONE, 1.0);
        let mut ray = *ray;
        for _ in 0..MAX_THROUGH {
            let Some(surface) = self.intersect(&ray) else { return (light, probability) };
            let Some((share, chance)) = self.through(&surface, -ray.dir, waves) else { break };
            light *= share;
            probability *= chance;
            // The end point stays where it is while the origin moves on.
            let end = ray.at(ray.tfar);
            let origin = surface.leave(ray.dir);
            let left = if ray.tfar.is_finite() {
                (end - origin).dot(ray.dir) / ray.dir.length_squared()
            } else {
                f32::INFINITY
            };
            if left <= 0.0 {
                return (light, probability);
            }
            ray = Ray { origin, tfar: left, ..ray };
            *rays += 1;
        }
        (M::Light::ZERO, 0.0)
    }

    /// Light that passes a surface unbent, and the chance that the path loop lets it: `None` where it never does.
    pub fn through(&self, surface: &Surface, wo: Vec3, waves: &M::Waves) -> Option<(M::Light, f32)> {
        let material = self.material(surface);
        let coverage = material.coverage(surface, &self.textures);
        let frame = material.frame(surface, &self.textures);
        let bsdf = material.bsdf(surface, &self.textures, waves);
        let straight = bsdf.through(frame.to_local(wo), waves);
        let hole = 1.0 - coverage;
        match straight {
            None if hole > 0.0 => Some((M::Light::splat(hole), hole)),
            None => None,
            Some((light, chance)) => Some((light * coverage + M::Light::splat(hole), hole + coverage * chance)),
        }
    }
}
