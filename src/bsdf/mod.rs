//! Surface scattering: a closed set of BSDFs in a local frame, z along the outward normal.
//!
//! `wo` points to where the light goes (the camera's side of the path), `wi` to where it comes from; both point away from
//! the surface and have unit length. For opaque surfaces only |z| counts: both sides look alike. For dielectrics z < 0 is
//! the inside.

mod albedo;
mod conductor;
mod dielectric;
mod diffuse;
mod microfacet;
mod multiple;

pub use conductor::{Conductor, multiple_color};
use dielectric::side_of;
pub use dielectric::{Dielectric, is_straight};
pub use diffuse::{CoatedDiffuse, Diffuse};
use glam::Vec3;
pub use microfacet::Microfacets;
pub use multiple::{Interface, Missing, Multiple};

use crate::film::{Side, Split};
use crate::mode::{Lanes, Mode};

/// Scattering at one point of a surface, ready to be evaluated.
pub enum Bsdf<'s, M: Mode> {
    /// Absorbs everything.
    Black,
    Diffuse(Diffuse<M>),
    Conductor(Conductor<'s, M>),
    Dielectric(Dielectric<'s, M>),
    CoatedDiffuse(CoatedDiffuse<'s, M>),
}

/// A direction drawn from a BSDF.
pub struct BsdfSample<M: Mode> {
    pub wi: Vec3,
    /// f |cos theta_i| / pdf for an ordinary direction; the lobe's share of the light for a delta one.
    pub weight: M::Light,
    pub pdf: Pdf,
    /// True when only the lane that decided the direction travels on ([`Mode::collapse`]).
    pub collapses: bool,
}

impl<M: Mode> BsdfSample<M> {
    /// What a smooth interface mirrors.
    #[inline]
    fn mirrored(wo: Vec3, weight: M::Light) -> Self {
        Self { wi: Vec3::new(-wo.x, -wo.y, wo.z), weight, pdf: Pdf::Delta, collapses: false }
    }
}

/// How likely a direction was to be drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pdf {
    /// Density per steradian.
    SolidAngle(f32),
    /// The only direction of a perfectly smooth lobe: light sampling can never find it.
    Delta,
    /// Straight on, as if nothing were there; the number is the probability of passing. The density of the ray's
    /// direction stays what it was.
    Through(f32),
}

impl<M: Mode> Bsdf<'_, M> {
    /// (f |cos theta_i|, density of `wi` in 1/sr) without the delta lobes.
    #[inline]
    pub fn eval(&self, wo: Vec3, wi: Vec3, waves: &M::Waves) -> (M::Light, f32) {
        match self {
            Self::Black => (M::Light::ZERO, 0.0),
            Self::Diffuse(bsdf) => bsdf.eval(wo, wi),
            Self::Conductor(bsdf) => bsdf.eval(wo, wi, waves),
            Self::Dielectric(bsdf) => bsdf.eval(wo, wi, waves),
            Self::CoatedDiffuse(bsdf) => bsdf.eval(wo, wi, waves),
        }
    }

    /// Draws a direction from three numbers in [0, 1): the first picks the lobe. `None`: the light is absorbed.
    #[inline]
    pub fn sample(&self, wo: Vec3, u: [f32; 3], waves: &M::Waves) -> Option<BsdfSample<M>> {
        match self {
            Self::Black => None,
            Self::Diffuse(bsdf) => bsdf.sample(wo, [u[1], u[2]]),
            Self::Conductor(bsdf) => bsdf.sample(wo, u, waves),
            Self::Dielectric(bsdf) => bsdf.sample(wo, u, waves),
            Self::CoatedDiffuse(bsdf) => bsdf.sample(wo, u, waves),
        }
    }

    /// What goes straight through for light seen along `wo`, and the probability that [`Bsdf::sample`] lets it pass;
    /// `None` where nothing does. Shadow rays use it to see through soap films.
    #[inline]
    pub fn through(&self, wo: Vec3, waves: &M::Waves) -> Option<(M::Light, f32)> {
        match self {
            Self::Dielectric(bsdf) => bsdf.through(wo, waves),
            _ => None,
        }
    }

    /// All that a smooth interface mirrors, which is never sampled from then on; `None`, and nothing changes, where there is no
    /// such interface, or the chance of mirroring or that of anything else is below `least`.
    #[inline]
    pub fn split_mirror(&mut self, wo: Vec3, least: f32, waves: &M::Waves) -> Option<BsdfSample<M>> {
        let (reflect, chance, mirrors) = match self {
            Self::Dielectric(bsdf) if bsdf.multiple.is_none() => {
                let split = bsdf.coat.split(side_of(wo), wo.z.abs(), waves);
                (split.reflect, bsdf.mirror_chance(&split), &mut bsdf.mirrors)
            }
            Self::CoatedDiffuse(bsdf) => {
                let split = bsdf.coat.split(Side::Outside, wo.z.abs(), waves);
                (split.reflect, bsdf.mirror_chance(&split), &mut bsdf.mirrors)
            }
            _ => return None,
        };
        (chance.min(1.0 - chance) >= least).then(|| {
            *mirrors = false;
            BsdfSample::mirrored(wo, reflect)
        })
    }

    /// Factor by which radiance is diluted when light crosses the surface: eta^2 of the side that the path enters over the
    /// other.
    #[inline]
    pub fn compression(&self, entering: bool) -> f32 {
        match self {
            Self::Dielectric(bsdf) if entering => bsdf.eta() * bsdf.eta(),
            Self::Dielectric(bsdf) => 1.0 / (bsdf.eta() * bsdf.eta()),
            _ => 1.0,
        }
    }

    /// True when every lobe is a delta, so that light sampling is useless.
    #[inline]
    pub fn is_delta(&self) -> bool {
        match self {
            Self::Black => true,
            Self::Diffuse(_) | Self::CoatedDiffuse(_) => false,
            Self::Conductor(bsdf) => bsdf.microfacets.is_smooth(),
            Self::Dielectric(bsdf) => bsdf.multiple.is_none(),
        }
    }
}

/// The interface of a base with its films, at one point.
pub struct Coat<'s, M: Mode> {
    pub film: &'s M::Film,
    /// Of the layer that varies over the surface.
    pub thickness_nm: f32,
    pub reflect_tint: M::Light,
    pub transmit_tint: M::Light,
}

impl<M: Mode> Clone for Coat<'_, M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M: Mode> Copy for Coat<'_, M> {}

impl<M: Mode> Coat<'_, M> {
    /// Reflected and transmitted shares of light that meets a (micro)facet at this cosine.
    #[inline]
    fn split(&self, side: Side, cos_i: f32, waves: &M::Waves) -> Split<M::Light> {
        let split = M::split(self.film, side, cos_i, self.thickness_nm, waves);
        Split { reflect: split.reflect * self.reflect_tint, transmit: split.transmit * self.transmit_tint }
    }
}

/// Probability of choosing the first of two lobes with these lane values: their mean, so that one choice serves all lanes.
/// Table values may be slightly negative out of gamut.
#[inline]
fn lobe_probability<L: Lanes>(first: L, second: L) -> f32 {
    let a = first.map(|x| x.max(0.0)).mean();
    let b = second.map(|x| x.max(0.0)).mean();
    if a + b > 0.0 { a / (a + b) } else { 0.0 }
}
