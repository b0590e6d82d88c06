//! Metal: reflection from a smooth or microfaceted surface, with or without films.

use glam::Vec3;

use super::multiple::{broad_pdf, square_to_broad};
use super::{BsdfSample, Coat, Microfacets, Missing, Pdf};
use crate::film::Side;
use crate::mode::{Lanes, Mode};

/// f = R(wo.h) D(h) G2 / (4 cos_o cos_i): the film is seen by each facet (Walter et al. 2007, eq. 20).
pub struct Conductor<'s, M: Mode> {
    pub coat: Coat<'s, M>,
    pub microfacets: Microfacets,
    /// What the lobe above loses, and the colour of the light that comes back from it.
    pub multiple: Option<(&'s Missing, M::Light)>,
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
        let value = reflect * (scale * self.microfacets.g2_reflect(wo, wi));
        let pdf = scale * self.microfacets.g1(wo);
        let Some((missing, color)) = &self.multiple else { return (value, pdf) };
        let alpha = self.microfacets.alpha;
        let share = missing.share(alpha, wo.z);
        let broad = *color * (share * missing.lobe(alpha, wi.z));
        (value + broad, pdf + (broad_pdf(alpha, wi.z) - pdf) * share)
    }

    #[inline]
    pub(super) fn sample(&self, wo: Vec3, u: [f32; 3], waves: &M::Waves) -> Option<BsdfSample<M>> {
        if self.microfacets.is_smooth() {
            let weight = self.coat.split(Side::Outside, wo.z.abs(), waves).reflect;
            return Some(BsdfSample::mirrored(wo, weight));
        }
        let up = upper(wo);
        let Some((missing, _)) = &self.multiple else { return self.sample_facet(wo, up, [u[1], u[2]], waves) };
        // Both lobes may lead to the same direction: the weight is the whole value over the whole density.
        let wi = if u[0] < missing.share(self.microfacets.alpha, up.z) {
            square_to_broad(self.microfacets.alpha, [u[1], u[2]])
        } else {
            let h = self.microfacets.sample_visible(up, [u[1], u[2]]);
            h * (2.0 * up.dot(h)) - up
        };
        if wi.z <= 0.0 {
            return None;
        }
        let wi = Vec3::new(wi.x, wi.y, wi.z.copysign(wo.z));
        let (value, pdf) = self.eval(wo, wi, waves);
        if pdf <= 0.0 {
            return None;
        }
        Some(BsdfSample { wi, weight: value * (1.0 / pdf), pdf: Pdf::SolidAngle(pdf), collapses: false })
    }

    #[inline]
    fn sample_facet(&self, wo: Vec3, up: Vec3, u: [f32; 2], waves: &M::Waves) -> Option<BsdfSample<M>> {
        let h = self.microfacets.sample_visible(up, u);
        let cos_h = up.dot(h);
        let wi = h * (2.0 * cos_h) - up;
        if wi.z <= 0.0 || cos_h <= 0.0 {
            return None;
        }
        let reflect = self.coat.split(Side::Outside, cos_h, waves).reflect;
        let g1 = self.microfacets.g1(up);
        let pdf = g1 * self.microfacets.d(h) / (4.0 * up.z);
        let weight = reflect * (self.microfacets.g2_reflect(up, wi) / g1);
        let wi = Vec3::new(wi.x, wi.y, wi.z.copysign(wo.z));
        Some(BsdfSample { wi, weight, pdf: Pdf::SolidAngle(pdf), collapses: false })
    }
}

/// Colour of light that was reflected by several facets, for an average reflectance and the share that single scattering
/// loses. Kulla & Conty 2017.
pub fn multiple_color<L: Lanes>(average: L, missing: f32) -> L {
    average.map(|f| f * f * (1.0 - missing) / (1.0 - f * missing).max(1e-6))
}

/// The direction mirrored to the upper side.
#[inline]
fn upper(w: Vec3) -> Vec3 {
    Vec3::new(w.x, w.y, w.z.abs())
}
