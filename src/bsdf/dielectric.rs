//! Transparent bodies: reflection and refraction at a smooth or microfaceted interface, with or without films.
//!
//! A body of relative index 1 (a soap film with air on both sides) bends nothing: what its facets transmit goes straight
//! through, whatever their tilt, and counts as passing through rather than as scattering.

use glam::Vec3;

use super::multiple::{broad_pdf, square_to_broad};
use super::{BsdfSample, Coat, Microfacets, Multiple, Pdf, lobe_probability};
use crate::film::{Side, Split};
use crate::mode::{Lanes, Mode};

pub struct Dielectric<'s, M: Mode> {
    pub coat: Coat<'s, M>,
    pub microfacets: Microfacets,
    /// Refractive index inside over outside, and whether it differs between the lanes of this path.
    pub refraction: (f32, bool),
    /// What the facets lose; `None` exactly where the interface is smooth.
    pub multiple: Option<Multiple<'s, M>>,
    /// False where what a smooth interface mirrors is followed apart: it is still there, but never sampled.
    pub mirrors: bool,
}

/// How light from one direction is shared out.
struct Shares<L> {
    /// What goes straight on without being scattered.
    straight: L,
    /// Probability of being scattered.
    scatters: f32,
    /// Scattered light that single scattering loses, and the probability that scattering is by the broad lobe.
    missing: L,
    broadly: f32,
}

/// Indices closer to 1 than this bend light by less than a twentieth of a degree, and leave half vectors without digits.
const STRAIGHT: f32 = 1e-3;

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

    /// Of light at this (positive) cosine on `side`.
    fn shares(&self, side: Side, cos: f32, waves: &M::Waves) -> Shares<M::Light> {
        let missing = self.multiple.as_ref().map_or(M::Light::ZERO, |multiple| multiple.missing(side, cos));
        if self.bends() {
            let broadly = missing.mean().clamp(0.0, 1.0);
            return Shares { straight: M::Light::ZERO, scatters: 1.0, missing, broadly };
        }
        let split = self.coat.split(side, cos, waves);
        let (straight, scatters) = match &self.multiple {
            Some(multiple) => {
                let straight = multiple.straight(cos, split.transmit);
                (straight, lobe_probability(straight.map(|t| 1.0 - t), straight))
            }
            None => (split.transmit, self.mirror_chance(&split)),
        };
        let broadly = if scatters > 0.0 { (missing.mean() / scatters).clamp(0.0, 1.0) } else { 0.0 };
        Shares { straight, scatters, missing, broadly }
    }

    pub(super) fn through(&self, wo: Vec3, waves: &M::Waves) -> Option<(M::Light, f32)> {
        if self.bends() {
            return None;
        }
        let shares = self.shares(side_of(wo), wo.z.abs(), waves);
        Some((shares.straight * self.coat.transmit_tint, 1.0 - shares.scatters))
    }

    /// The chance that a smooth interface mirrors what comes from a direction, given what becomes of it.
    #[inline]
    pub(super) fn mirror_chance(&self, split: &Split<M::Light>) -> f32 {
        if self.mirrors { lobe_probability(split.reflect, split.transmit) } else { 0.0 }
    }

    pub(super) fn eval(&self, wo: Vec3, wi: Vec3, waves: &M::Waves) -> (M::Light, f32) {
        let Some(multiple) = self.multiple.as_ref().filter(|_| wo.z != 0.0 && wi.z != 0.0) else {
            return (M::Light::ZERO, 0.0);
        };
        // Work on the upper side: mirror the z axis when the light leaves from below.
        let flip = 1.0f32.copysign(wo.z);
        let (up, other, side) = (mirror(wo, flip), mirror(wi, flip), side_of(wo));
        let h = if other.z > 0.0 {
            up + other
        } else {
            // The half vector of refraction points to the thinner side; turn it up. Walter et al. 2007, eq. 16.
            let h = up + other * self.eta_across(side);
            h * 1.0f32.copysign(h.z)
        };
        let h = h.normalize_or(Vec3::Z);
        let split = self.coat.split(side, up.dot(h).clamp(0.0, 1.0), waves);
        let shares = self.shares(side, up.z, waves);
        self.scatter(multiple, &shares, side, [up, other], (h, &split), waves)
    }

    /// Value and density of scattering between two directions by the facet `h`, with what it does to light, and by the broad
    /// lobe.
    fn scatter(
        &self,
        multiple: &Multiple<M>,
        shares: &Shares<M::Light>,
        side: Side,
        [wo, wi]: [Vec3; 2],
        (h, facet): (Vec3, &Split<M::Light>),
        waves: &M::Waves,
    ) -> (M::Light, f32) {
        let [reflect, transmit] = multiple.shares(side);
        let hemisphere_pdf = broad_pdf(self.microfacets.alpha, wi.z.abs());
        let stays = lobe_probability(reflect, transmit);
        let (value, pdf, broad, broad_pdf) = if wi.z > 0.0 {
            let (value, pdf) = self.reflection(wo, wi, h, facet);
            let broad = reflect * multiple.lobe(side, wi.z) * self.coat.reflect_tint;
            (value, pdf, broad, stays * hemisphere_pdf)
        } else {
            let (value, pdf) =
                if self.bends() { self.refraction(wo, wi, h, facet, side) } else { (M::Light::ZERO, 0.0) };
            let across = self.eta_across(side);
            let broad = transmit * multiple.lobe(beyond(side), -wi.z) * self.coat.transmit_tint;
            let broad = broad * (1.0 / (across * across));
            (self.refracted(value, waves), pdf, self.refracted(broad, waves), (1.0 - stays) * hemisphere_pdf)
        };
        (value + shares.missing * broad, shares.scatters * (pdf + (broad_pdf - pdf) * shares.broadly))
    }

    fn reflection(&self, wo: Vec3, wi: Vec3, h: Vec3, facet: &Split<M::Light>) -> (M::Light, f32) {
        let scale = self.microfacets.d(h) / (4.0 * wo.z);
        let value = facet.reflect * (scale * self.microfacets.g2_reflect(wo, wi));
        (value, scale * self.microfacets.g1(wo) * self.reflect_probability(facet))
    }

    fn refraction(&self, wo: Vec3, wi: Vec3, h: Vec3, facet: &Split<M::Light>, side: Side) -> (M::Light, f32) {
        let eta = self.eta_across(side);
        let (cos_o, cos_i) = (wo.dot(h), wi.dot(h));
        if cos_o <= 0.0 || cos_i >= 0.0 {
            return (M::Light::ZERO, 0.0);
        }
        let jacobian = refraction_jacobian(cos_o, cos_i, eta);
        let d = self.microfacets.d(h);
        // eq. 21, times cos_i; radiance is compressed by eta^-2 when it enters the denser side.
        let value = facet.transmit * (d * self.microfacets.g2_transmit(wo, wi) * cos_o * jacobian / (wo.z * eta * eta));
        let pass = 1.0 - self.reflect_probability(facet);
        (value, self.microfacets.visible_pdf(wo, h) * jacobian * pass)
    }

    /// Chance that a facet reflects rather than refracts what it scatters.
    #[inline]
    fn reflect_probability(&self, facet: &Split<M::Light>) -> f32 {
        if self.bends() { lobe_probability(facet.reflect, facet.transmit) } else { 1.0 }
    }

    pub(super) fn sample(&self, wo: Vec3, mut u: [f32; 3], waves: &M::Waves) -> Option<BsdfSample<M>> {
        if self.bends() && self.multiple.is_none() {
            return self.sample_smooth(wo, u[0], waves);
        }
        let shares = self.shares(side_of(wo), wo.z.abs(), waves);
        if u[0] >= shares.scatters {
            let pass = 1.0 - shares.scatters;
            let weight = shares.straight * self.coat.transmit_tint * (1.0 / pass);
            return Some(BsdfSample { wi: -wo, weight, pdf: Pdf::Through(pass), collapses: false });
        }
        let Some(multiple) = &self.multiple else {
            let weight = self.coat.split(side_of(wo), wo.z.abs(), waves).reflect * (1.0 / shares.scatters);
            return Some(BsdfSample::mirrored(wo, weight));
        };
        u[0] /= shares.scatters;
        self.sample_rough(multiple, &shares, wo, u, waves)
    }

    /// A smooth interface that bends light.
    fn sample_smooth(&self, wo: Vec3, u: f32, waves: &M::Waves) -> Option<BsdfSample<M>> {
        let flip = 1.0f32.copysign(wo.z);
        let (up, side) = (mirror(wo, flip), side_of(wo));
        let split = self.coat.split(side, up.z, waves);
        let reflect = self.mirror_chance(&split);
        if u < reflect {
            return Some(BsdfSample::mirrored(wo, split.reflect * (1.0 / reflect)));
        }
        let eta = self.eta_across(side);
        let wi = refract(up, Vec3::Z, up.z, eta)?;
        let weight = self.refracted(split.transmit * (1.0 / ((1.0 - reflect) * eta * eta)), waves);
        Some(BsdfSample { wi: mirror(wi, flip), weight, pdf: Pdf::Delta, collapses: self.refraction.1 })
    }

    /// Draws from the facets or from the broad lobe; the weight is the whole value over the whole density, because both may
    /// lead to the same direction.
    fn sample_rough(
        &self,
        multiple: &Multiple<M>,
        shares: &Shares<M::Light>,
        wo: Vec3,
        u: [f32; 3],
        waves: &M::Waves,
    ) -> Option<BsdfSample<M>> {
        let flip = 1.0f32.copysign(wo.z);
        let (up, side) = (mirror(wo, flip), side_of(wo));
        let broadly = shares.broadly;
        if u[0] < broadly {
            let [reflect, transmit] = multiple.shares(side);
            let stays = u[0] < broadly * lobe_probability(reflect, transmit);
            let wi = square_to_broad(self.microfacets.alpha, [u[1], u[2]]);
            let wi = mirror(wi, if stays { flip } else { -flip });
            let (value, pdf) = self.eval(wo, wi, waves);
            return self.drawn(wo, wi, value, pdf);
        }
        let h = self.microfacets.sample_visible(up, [u[1], u[2]]);
        let cos_o = up.dot(h);
        if cos_o <= 0.0 {
            return None;
        }
        let facet = self.coat.split(side, cos_o, waves);
        let wi = if (u[0] - broadly) / (1.0 - broadly) < self.reflect_probability(&facet) {
            Some(h * (2.0 * cos_o) - up).filter(|wi| wi.z > 0.0)?
        } else {
            refract(up, h, cos_o, self.eta_across(side)).filter(|wi| wi.z < 0.0)?
        };
        // With the very facet that was drawn: found again from the directions, it has no digits where they nearly oppose.
        let (value, pdf) = self.scatter(multiple, shares, side, [up, wi], (h, &facet), waves);
        self.drawn(wo, mirror(wi, flip), value, pdf)
    }

    #[inline]
    fn drawn(&self, wo: Vec3, wi: Vec3, value: M::Light, pdf: f32) -> Option<BsdfSample<M>> {
        let collapses = self.refraction.1 && wi.z * wo.z < 0.0;
        (pdf > 0.0).then(|| BsdfSample { wi, weight: value * (1.0 / pdf), pdf: Pdf::SolidAngle(pdf), collapses })
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
fn beyond(side: Side) -> Side {
    if side == Side::Outside { Side::Inside } else { Side::Outside }
}

#[inline]
pub(super) fn side_of(wo: Vec3) -> Side {
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
pub(super) fn refract(wo: Vec3, h: Vec3, cos_o: f32, eta: f32) -> Option<Vec3> {
    // cos_t^2 = 1 - sin_o^2 / eta^2, arranged so that eta near 1 and grazing angles lose no digits.
    let cos2_t = ((eta - 1.0) * (eta + 1.0) + cos_o * cos_o) / (eta * eta);
    if cos2_t <= 0.0 {
        return None;
    }
    Some((h * (cos_o / eta - cos2_t.sqrt()) - wo / eta).normalize())
}
