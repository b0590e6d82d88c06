//! What a surface is painted in, for people and denoisers.

use super::Bsdf;
use crate::film::Side;
use crate::mode::{Lanes, Mode};

impl<M: Mode> Bsdf<'_, M> {
    /// Share of light from straight above that comes back or goes through: a coated metal's is the film's reflectance at
    /// normal incidence, so that bands of its thickness show; that of clear glass is 1.
    pub fn albedo(&self, waves: &M::Waves) -> M::Light {
        match self {
            Self::Black => M::Light::ZERO,
            Self::Diffuse(bsdf) => bsdf.albedo,
            Self::Conductor(bsdf) => bsdf.coat.split(Side::Outside, 1.0, waves).reflect,
            Self::Dielectric(bsdf) => {
                let split = bsdf.coat.split(Side::Outside, 1.0, waves);
                split.reflect + split.transmit
            }
            Self::CoatedDiffuse(bsdf) => {
                let split = bsdf.coat.split(Side::Outside, 1.0, waves);
                split.reflect + bsdf.body_albedo(split.transmit)
            }
        }
    }
}
