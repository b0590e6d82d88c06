//! All lights of a scene, and how often each is drawn.

use glam::Vec3;

use super::light::{Emitter, LampPoint, LightSample, Source, disc_radiance};
use super::light_tree::LightTree;
use crate::math::distribution::Alias;
use crate::math::warp::cone_pdf;

/// Where lights with a place and lights without one shine, neither is drawn less often than this: what is expected to be
/// the stronger one may stand behind a wall.
const LEAST_SHARE: f32 = 0.125;

/// Lights with a place are drawn by what they can do where they are asked for; those without one (skies, suns, lamps that
/// do not fade) by their irradiance, which is the same everywhere.
pub struct Lights {
    pub emitters: Vec<Emitter>,
    near: LightTree,
    /// Emitters without a place, and how one is chosen.
    everywhere: Vec<u32>,
    choice: Option<Alias>,
    /// Sum over those, mean over the colours.
    irradiance: f32,
}

impl Lights {
    /// `strength`: for each emitter the greatest intensity or, for skies and suns, the irradiance on a surface that faces
    /// them; mean over the colours. `size_m`: of the scene, at which lamps count that fade in a way of their own.
    pub fn new(emitters: Vec<Emitter>, strength: &[f32], size_m: f32) -> Self {
        let beams: Vec<_> = emitters.iter().zip(strength).map(|(emitter, &strength)| emitter.beam(strength)).collect();
        let everywhere: Vec<u32> = (0u32..).zip(&beams).filter(|(_, beam)| beam.is_none()).map(|(i, _)| i).collect();
        let irradiance = |index: u32| emitters[index as usize].far_irradiance(strength[index as usize], size_m);
        let irradiance: Vec<f32> = everywhere.iter().map(|&index| irradiance(index)).collect();
        let choice = Alias::new(&irradiance);
        let irradiance = irradiance.iter().filter(|value| value.is_finite()).sum();
        Self { near: LightTree::new(&beams), emitters, everywhere, choice, irradiance }
    }

    /// The chance that a light with a place is chosen, at this point.
    #[inline]
    fn near_share(&self, from: Vec3) -> f32 {
        if self.choice.is_none() {
            return 1.0;
        }
        let near = self.near.irradiance(from);
        if near == 0.0 {
            return 0.0;
        }
        (near / (near + self.irradiance)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE)
    }

    /// Chooses an emitter, and tells the chance of it; `None` where none shines.
    pub(super) fn choose(&self, from: Vec3, u: f32) -> Option<(u32, f32)> {
        let share = self.near_share(from);
        if u < share {
            let (index, probability) = self.near.sample(from, u / share)?;
            return Some((index as u32, probability * share));
        }
        let rest = 1.0 - share;
        let (which, probability) = self.choice.as_ref()?.sample((u - share) / rest);
        Some((self.everywhere[which], probability * rest))
    }

    /// The chance that [`Lights::sample`] chooses this emitter.
    pub fn probability(&self, from: Vec3, emitter: u32) -> f32 {
        match (self.everywhere.binary_search(&emitter), &self.choice) {
            (Ok(which), Some(choice)) => (1.0 - self.near_share(from)) * choice.probability(which),
            (Ok(_), None) => 0.0,
            (Err(_), _) => self.near.probability(from, emitter as usize) * self.near_share(from),
        }
    }

    /// Chooses an emitter and a direction towards it from `from`; `None` when there is none or it faces away.
    pub fn sample(&self, from: Vec3, [u, u_x, u_y]: [f32; 3]) -> Option<(u32, LightSample)> {
        let (index, probability) = self.choose(from, u)?;
        let mut sample = self.emitters[index as usize].sample(from, [u_x, u_y])?;
        sample.pdf *= probability;
        Some((index, sample))
    }

    /// The density with which [`Lights::sample`] would have drawn the direction from `from` to this point.
    pub fn surface_pdf(&self, from: Vec3, lamp: &LampPoint) -> f32 {
        self.emitter_pdf(from, lamp) * self.probability(from, lamp.emitter)
    }

    /// As [`Lights::surface_pdf`], once the emitter has been chosen.
    pub(super) fn emitter_pdf(&self, from: Vec3, lamp: &LampPoint) -> f32 {
        match &self.emitters[lamp.emitter as usize] {
            Emitter::Triangle(triangle) => triangle.pdf(lamp.position - from),
            Emitter::Sphere(sphere) => sphere.pdf(from, lamp),
            _ => 0.0,
        }
    }

    /// What the light of a lamp is more or less at a distance than if it faded with the square.
    pub fn gain(&self, emitter: u32, distance_m: f32) -> f32 {
        self.emitters[emitter as usize].gain(distance_m)
    }

    /// The density with which [`Lights::sample`] would have drawn this direction from `from` towards any distant light.
    pub fn distant_pdf(&self, from: Vec3, toward: Vec3) -> f32 {
        let mut sum = 0.0;
        self.escape(from, toward, |_, pdf| sum += pdf);
        sum
    }

    /// Calls `add` with radiance and light-sampling density from `from` of each distant light that lies in direction
    /// `toward`.
    pub fn escape(&self, from: Vec3, toward: Vec3, mut add: impl FnMut(Source, f32)) {
        let Some(choice) = &self.choice else { return };
        let share = 1.0 - self.near_share(from);
        for (which, &index) in self.everywhere.iter().enumerate() {
            let seen = match &self.emitters[index as usize] {
                Emitter::Sky(sky) => Some(sky.seen(toward)),
                Emitter::Directional { toward: axis, one_minus_cos, irradiance } => {
                    let inside = *one_minus_cos > 0.0 && 1.0 - axis.dot(toward) <= *one_minus_cos;
                    inside.then(|| (disc_radiance(irradiance, *one_minus_cos), cone_pdf(*one_minus_cos)))
                }
                _ => None,
            };
            if let Some((radiance, pdf)) = seen {
                add(radiance, pdf * share * choice.probability(which));
            }
        }
    }
}
