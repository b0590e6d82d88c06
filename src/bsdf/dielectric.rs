//! Transparent bodies: reflection and refraction at a smooth or microfaceted interface, with or without films.
//!
//! A body of relative index 1 (a soap film with air on both sides) bends nothing: what it transmits goes straight through,
//! whatever its roughness, and counts as passing through rather than as scattering.

use glam::Vec3;

use super::{BsdfSample, Coat, Microfacets, Pdf, lobe_probability};
use crate::film::Side;
use crate::mode::{Lanes, Mode};

pub struct Dielectric<'s, M: Mode> {
    pub coat: Coat<'s, M>,
    pub microfacets: Microfacets,
    /// Refractive index inside over outside, and whether it differs between the lanes of this path.
    pub refraction: (f32, bool),
}

/// Indices closer to 1 than this bend light by less than f32 directions resolve.
const STRAIGHT: f32 = 1e-4;

/// True for a body that lets light go on as if it were not there.
pub fn is_straight(eta: f32) -> bool {
    (eta - 1.0).abs() <= STRAIGHT
}

impl<M: Mode> Dielectric<'_, M> {
    #[inline]
    pub(super) fn eta(&self) -> f32 {
        self.refraction.0
    }

    #[inline]
    fn bends(&self) -> bool {
        !is_straight(self.eta())
    }

    /// What is left of refracted light: all lanes, or the one that decided the direction.
    #[inline]
    fn refracted(&self, light: M::Light, waves: &M::Waves) -> M::Light {
        if self.refraction.1 { M::survivors(light, waves) } else { light }
    }

    pub(super) fn through(&self, wo: Vec3, waves: &M::Waves) -> Option<(M::Light, f32)> {
        if self.bends() {
            return None;
        }
        let split = self.coat.split(side_of(wo), wo.z.abs(), waves);
        Some((split.transmit, 1.0 - lobe_probability(split.reflect, split.transmit)))
    }

    pub(super) fn eval(&self, wo: Vec3, wi: Vec3, waves: &M::Waves) -> (M::Light, f32) {
        if self.microfacets.is_smooth() || wo.z == 0.0 || wi.z == 0.0 {
            return (M::Light::ZERO, 0.0);
        }
        // Work on the upper side: mirror the z axis when the light leaves from below.
        let flip = 1.0f32.copysign(wo.z);
        let (up, other) = (mirror(wo, flip), mirror(wi, flip));
        let side = side_of(wo);
        if other.z > 0.0 {
            self.eval_reflection(up, other, side, waves)
        } else if self.bends() {
            self.eval_refraction(up, other, side, waves)
        } else {
            (M::Light::ZERO, 0.0)
        }
    }

    fn eval_reflection(&self, wo: Vec3, wi: Vec3, side: Side, waves: &M::Waves) -> (M::Light, f32) {
        let h = (wo + wi).normalize();
        let cos_h = wo.dot(h);
        let split = self.coat.split(side, cos_h, waves);
        let scale = self.microfacets.d(h) / (4.0 * wo.z);
        let value = split.reflect * (scale * self.microfacets.g2_reflect(wo, wi));
        (value, scale * self.microfacets.g1(wo) * self.reflect_probability(&split, wo, side, waves))
    }

    fn eval_refraction(&self, wo: Vec3, wi: Vec3, side: Side, waves: &M::Waves) -> (M::Light, f32) {
        let eta = self.eta_across(side);
        // The half vector of refraction points to the thinner side; turn it up. Walter et al. 2007, eq. 16.
        let mut h = (wo + wi * eta).normalize();
        h *= 1.0f32.copysign(h.z);
        let (cos_o, cos_i) = (wo.dot(h), wi.dot(h));
        if cos_o <= 0.0 || cos_i >= 0.0 {
            return (M::Light::ZERO, 0.0);
        }
        let split = self.coat.split(side, cos_o, waves);
        let jacobian = refraction_jacobian(cos_o, cos_i, eta);
        let d = self.microfacets.d(h);
        // eq. 21, times cos_i; radiance is compressed by eta^-2 when it enters the denser side.
        let value = split.transmit * (d * self.microfacets.g2_transmit(wo, wi) * cos_o * jacobian / (wo.z * eta * eta));
        let pass = 1.0 - self.reflect_probability(&split, wo, side, waves);
        (self.refracted(value, waves), self.microfacets.visible_pdf(wo, h) * jacobian * pass)
    }

    /// Chance of taking the reflection lobe. A straight body decides at the surface, because its transmission knows no
    /// facets; others decide at the facet.
    #[inline]
    fn reflect_probability(&self, facet: &crate::film::Split<M::Light>, wo: Vec3, side: Side, waves: &M::Waves) -> f32 {
        if self.bends() {
            lobe_probability(facet.reflect, facet.transmit)
        } else {
            let surface = self.coat.split(side, wo.z, waves);
            lobe_probability(surface.reflect, surface.transmit)
        }
    }

    pub(super) fn sample(&self, wo: Vec3, u: [f32; 3], waves: &M::Waves) -> Option<BsdfSample<M>> {
        let flip = 1.0f32.copysign(wo.z);
        let up = mirror(wo, flip);
        let side = side_of(wo);
        if !self.bends() {
            let surface = self.coat.split(side, up.z, waves);
            let reflect = lobe_probability(surface.reflect, surface.transmit);
            if u[0] >= reflect {
                let pass = 1.0 - reflect;
                return Some(BsdfSample {
                    wi: -wo,
                    weight: surface.transmit * (1.0 / pass),
                    pdf: Pdf::Through(pass),
                    collapses: false,
                });
            }
        }
        let smooth = self.microfacets.is_smooth();
        let h = if smooth { Vec3::Z } else { self.microfacets.sample_visible(up, [u[1], u[2]]) };
        let cos_o = up.dot(h);
        if cos_o <= 0.0 {
            return None;
        }
        let split = self.coat.split(side, cos_o, waves);
        let reflect = self.reflect_probability(&split, up, side, waves);
        let g1 = self.microfacets_g1(up);
        if u[0] < reflect {
            let wi = h * (2.0 * cos_o) - up;
            if wi.z <= 0.0 {
                return None;
            }
            let weight = split.reflect * (1.0 / reflect);
            let wi_world = mirror(wi, flip);
            if smooth {
                return Some(BsdfSample { wi: wi_world, weight, pdf: Pdf::Delta, collapses: false });
            }
            let pdf = g1 * self.microfacets.d(h) / (4.0 * up.z) * reflect;
            let weight = weight * (self.microfacets.g2_reflect(up, wi) / g1);
            return Some(BsdfSample { wi: wi_world, weight, pdf: Pdf::SolidAngle(pdf), collapses: false });
        }
        let eta = self.eta_across(side);
        let wi = refract(up, h, cos_o, eta)?;
        if wi.z >= 0.0 {
            return None;
        }
        let pass = 1.0 - reflect;
        let weight = self.refracted(split.transmit * (1.0 / (pass * eta * eta)), waves);
        let collapses = self.refraction.1;
        if smooth {
            return Some(BsdfSample { wi: mirror(wi, flip), weight, pdf: Pdf::Delta, collapses });
        }
        let pdf = self.microfacets.visible_pdf(up, h) * refraction_jacobian(cos_o, wi.dot(h), eta) * pass;
        let weight = weight * (self.microfacets.g2_transmit(up, wi) / g1);
        Some(BsdfSample { wi: mirror(wi, flip), weight, pdf: Pdf::SolidAngle(pdf), collapses })
    }

    #[inline]
    fn microfacets_g1(&self, w: Vec3) -> f32 {
        if self.microfacets.is_smooth() { 1.0 } else { self.microfacets.g1(w) }
    }

    /// Index on the far side over index on the side of `wo`.
    #[inline]
    fn eta_across(&self, side: Side) -> f32 {
        match side {
            Side::Outside => self.eta(),
            Side::Inside => 1.0 / self.eta(),
        }
    }
}

#[inline]
fn side_of(wo: Vec3) -> Side {
    if wo.z >= 0.0 { Side::Outside } else { Side::Inside }
}

#[inline]
fn mirror(w: Vec3, flip: f32) -> Vec3 {
    Vec3::new(w.x, w.y, w.z * flip)
}

/// d(omega_h) / d(omega_i) for refraction. Walter et al. 2007, eq. 17.
#[inline]
fn refraction_jacobian(cos_o: f32, cos_i: f32, eta: f32) -> f32 {
    let denominator = cos_o + eta * cos_i;
    eta * eta * cos_i.abs() / (denominator * denominator)
}

/// The direction on the other side of a facet `h`, for `cos_o = wo.h > 0`; `None` beyond the critical angle.
#[inline]
fn refract(wo: Vec3, h: Vec3, cos_o: f32, eta: f32) -> Option<Vec3> {
    // cos_t^2 = 1 - sin_o^2 / eta^2, arranged so that eta near 1 and grazing angles lose no digits.
    let cos2_t = ((eta - 1.0) * (eta + 1.0) + cos_o * cos_o) / (eta * eta);
    if cos2_t <= 0.0 {
        return None;
    }
    Some((h * (cos_o / eta - cos2_t.sqrt()) - wo / eta).normalize())
}
