//! Metal: reflection from a smooth or microfaceted surface, with or without films.

use glam::Vec3;

use super::{BsdfSample, Coat, Microfacets, Pdf};
use crate::film::Side;
use crate::mode::{Lanes, Mode};

/// f = R(wo.h) D(h) G2 / (4 cos_o cos_i): the film is seen by each facet (Walter et al. 2007, eq. 20).
pub struct Conductor<'s, M: Mode> {
    pub coat: Coat<'s, M>,
    pub microfacets: Microfacets,
}

impl<M: Mode> Conductor<'_, M> {
    #[inline]
    pub(super) fn eval(&self, wo: Vec3, wi: Vec3, waves: &M::Waves) -> (M::Light, f32) {
        if wo.z * wi.z <= 0.0 || self.microfacets.is_smooth() {
            return (M::Light::ZERO, 0.0);
        }
        let (wo, wi) = (upper(wo), upper(wi));
        let h = (wo + wi).normalize();
        let cos_h = wo.dot(h);
        let reflect = self.coat.split(Side::Outside, cos_h, waves).reflect;
        let scale = self.microfacets.d(h) / (4.0 * wo.z);
        (reflect * (scale * self.microfacets.g2_reflect(wo, wi)), scale * self.microfacets.g1(wo))
    }

    #[inline]
    pub(super) fn sample(&self, wo: Vec3, u: [f32; 3], waves: &M::Waves) -> Option<BsdfSample<M>> {
        if self.microfacets.is_smooth() {
            let weight = self.coat.split(Side::Outside, wo.z.abs(), waves).reflect;
            return Some(BsdfSample { wi: Vec3::new(-wo.x, -wo.y, wo.z), weight, pdf: Pdf::Delta, collapses: false });
        }
        let up = upper(wo);
        let h = self.microfacets.sample_visible(up, [u[1], u[2]]);
        let cos_h = up.dot(h);
        let wi = h * (2.0 * cos_h) - up;
        if wi.z <= 0.0 || cos_h <= 0.0 {
            return None;
        }
        let reflect = self.coat.split(Side::Outside, cos_h, waves).reflect;
        let g1 = self.microfacets.g1(up);
        let pdf = g1 * self.microfacets.d(h) / (4.0 * up.z);
        let weight = reflect * (self.microfacets.g2_reflect(up, wi) / g1);
        Some(BsdfSample {
            wi: Vec3::new(wi.x, wi.y, wi.z.copysign(wo.z)),
            weight,
            pdf: Pdf::SolidAngle(pdf),
            collapses: false,
        })
    }
}

/// The direction mirrored to the upper side.
#[inline]
fn upper(w: Vec3) -> Vec3 {
    Vec3::new(w.x, w.y, w.z.abs())
}
