//! Lambertian reflection, bare and under a coated interface.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::{BsdfSample, Coat, Pdf, Split, lobe_probability};
use crate::film::Side;
use crate::math::warp::{cosine_hemisphere_pdf, square_to_cosine_hemisphere};
use crate::mode::{Lanes, Mode};

/// f = albedo / pi, on both sides.
pub struct Diffuse<M: Mode> {
    pub albedo: M::Light,
}

impl<M: Mode> Diffuse<M> {
    #[inline]
    pub(super) fn eval(&self, wo: Vec3, wi: Vec3) -> (M::Light, f32) {
        if wo.z * wi.z <= 0.0 {
            return (M::Light::ZERO, 0.0);
        }
        let pdf = cosine_hemisphere_pdf(wi.z.abs());
        (self.albedo * pdf, pdf)
    }

    #[inline]
    pub(super) fn sample(&self, wo: Vec3, u: [f32; 2]) -> Option<BsdfSample<M>> {
        let wi = square_to_cosine_hemisphere(u);
        let pdf = cosine_hemisphere_pdf(wi.z);
        if pdf == 0.0 {
            return None;
        }
        let wi = Vec3::new(wi.x, wi.y, wi.z.copysign(wo.z));
        Some(BsdfSample { wi, weight: self.albedo, pdf: Pdf::SolidAngle(pdf), collapses: false })
    }
}

/// A Lambertian base inside a smooth interface: mirror reflection on top, and light that enters, is scattered to and fro
/// between base and interface, and leaves again.
///
/// f = T(wi) T(wo) rho / (pi n^2 (1 - rho F)), F the interface's average reflectance from inside: the interfaced Lambertian
/// model of Elias & Simonot 2006, with the film in T and F. Its albedo is R + T rho (1 - F) / (1 - rho F), 1 for rho = 1.
pub struct CoatedDiffuse<'s, M: Mode> {
    pub coat: Coat<'s, M>,
    pub albedo: M::Light,
    /// Refractive index of the body under the films, relative to outside.
    pub ior: f32,
    /// The interface's average reflectance from inside, `F` above.
    pub internal_reflectance: M::Light,
    /// False where what it mirrors is followed apart: it is still there, but never sampled.
    pub mirrors: bool,
}

impl<M: Mode> CoatedDiffuse<'_, M> {
    /// The diffuse part's f for a direction that enters with transmittance 1, times pi.
    fn body(&self) -> M::Light {
        let reflected = self.internal_reflectance * self.albedo;
        let n2 = self.ior * self.ior;
        self.albedo * reflected.map(|x| 1.0 / (n2 * (1.0 - x).max(1e-6)))
    }

    /// Share of light from `wo` that the body returns in all directions.
    pub(super) fn body_albedo(&self, transmit: M::Light) -> M::Light {
        // The light that gets out again: n^2 (1 - F) of the cosine-weighted hemisphere.
        let n2 = self.ior * self.ior;
        transmit * self.body() * self.internal_reflectance.map(|f| n2 * (1.0 - f))
    }

    /// The chance that what comes from a direction is mirrored, given what becomes of it.
    #[inline]
    pub(super) fn mirror_chance(&self, out: &Split<M::Light>) -> f32 {
        if self.mirrors { lobe_probability(out.reflect, self.body_albedo(out.transmit)) } else { 0.0 }
    }

    #[inline]
    pub(super) fn eval(&self, wo: Vec3, wi: Vec3, waves: &M::Waves) -> (M::Light, f32) {
        if wo.z * wi.z <= 0.0 {
            return (M::Light::ZERO, 0.0);
        }
        let out = self.coat.split(Side::Outside, wo.z.abs(), waves);
        let into = self.coat.split(Side::Outside, wi.z.abs(), waves);
        let mirror = self.mirror_chance(&out);
        let value = out.transmit * into.transmit * self.body() * (FRAC_1_PI * wi.z.abs());
        (value, (1.0 - mirror) * cosine_hemisphere_pdf(wi.z.abs()))
    }

    #[inline]
    pub(super) fn sample(&self, wo: Vec3, u: [f32; 3], waves: &M::Waves) -> Option<BsdfSample<M>> {
        let out = self.coat.split(Side::Outside, wo.z.abs(), waves);
        let mirror = self.mirror_chance(&out);
        if u[0] < mirror {
            return Some(BsdfSample::mirrored(wo, out.reflect * (1.0 / mirror)));
        }
        let wi = square_to_cosine_hemisphere([u[1], u[2]]);
        let wi = Vec3::new(wi.x, wi.y, wi.z.copysign(wo.z));
        let (value, pdf) = self.eval(wo, wi, waves);
        if pdf <= 0.0 {
            return None;
        }
        Some(BsdfSample { wi, weight: value * (1.0 / pdf), pdf: Pdf::SolidAngle(pdf), collapses: false })
    }
}
