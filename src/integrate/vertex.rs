//! A surface point with its scattering, ready for one step of a path.

use glam::Vec3;
use wide::{CmpGe, CmpGt, f32x8};

use super::guide::{Guide, Leaf};
use crate::bsdf::{Bsdf, BsdfSample};
use crate::math::{Frame, Vec3x8};
use crate::mode::Mode;
use crate::scene::{Interior, Material, Scene, Surface};

/// Smallest cosine between a bent shading normal and the viewer.
const GRAZING: f32 = 1e-3;

pub(super) struct Vertex<'s, M: Mode> {
    pub surface: Surface<'s>,
    pub frame: Frame,
    pub bsdf: Bsdf<'s, M>,
    /// Towards where the path came from, local frame.
    pub wo: Vec3,
    /// What lies on the side of `wo`, and beyond the surface.
    pub interior: Interior,
    pub beyond: Interior,
    /// True when the interpolated normal had to be bent to face the viewer: scattering then depends on where that is.
    pub bent: bool,
    /// Where else to look for light, besides where the surface scatters.
    pub guide: Option<&'s Leaf>,
}

impl<'s, M: Mode> Vertex<'s, M> {
    /// `interior` and `beyond`: what lies on the viewer's side and on the other.
    #[inline]
    pub fn new(
        scene: &'s Scene<M>,
        (surface, material): (Surface<'s>, &'s Material<M>),
        toward_viewer: Vec3,
        [interior, beyond]: [Interior; 2],
        waves: &M::Waves,
    ) -> Self {
        let (frame, bent) = facing(material.normal(&surface, scene.textures()), surface.ng, toward_viewer);
        let bsdf = material.bsdf(&surface, scene.textures(), waves);
        let wo = frame.to_local(toward_viewer);
        Self { surface, frame, bsdf, wo, interior, beyond, bent, guide: None }
    }

    /// Lets a matte surface know where to look for thrown light.
    #[inline]
    pub fn consult(&mut self, guide: Option<&'s Guide>) {
        if let Some(guide) = guide.filter(|_| self.is_matte()) {
            self.guide = guide.at(self.surface.position);
        }
    }

    /// Density of scattering into `wi` (world space), where the surface alone would scatter with density `pdf`.
    #[inline]
    pub fn density(&self, wi: Vec3, pdf: f32) -> f32 {
        match self.guide {
            Some(leaf) => leaf.mixed(pdf, leaf.pdf(self.surface.position, wi)),
            None => pdf,
        }
    }

    /// The local direction, unless interpolated normal and real surface disagree about its side.
    #[inline]
    pub fn local(&self, wi: Vec3) -> Option<Vec3> {
        let local = self.frame.to_local(wi);
        (local.z * wi.dot(self.surface.ng) > 0.0).then_some(local)
    }

    /// True for mirrors and lenses, also rough ones: all that they scatter may be thrown. On very rough metal neighbours share
    /// what they find, and find it often enough.
    #[inline]
    pub fn is_thrower(&self) -> bool {
        match &self.bsdf {
            Bsdf::Conductor(_) => !self.is_broad_metal(),
            Bsdf::Dielectric(_) => true,
            Bsdf::Black | Bsdf::Diffuse(_) | Bsdf::CoatedDiffuse(_) => false,
        }
    }

    /// True on matte bodies, with a coat or without.
    #[inline]
    pub fn is_matte(&self) -> bool {
        matches!(self.bsdf, Bsdf::Diffuse(_) | Bsdf::CoatedDiffuse(_))
    }

    /// True on very rough metal.
    #[inline]
    pub fn is_broad_metal(&self) -> bool {
        matches!(&self.bsdf, Bsdf::Conductor(bsdf) if bsdf.microfacets.is_broad())
    }

    /// True where light may be followed in either direction by the same rules.
    #[inline]
    pub fn is_reversible(&self) -> bool {
        !self.bent && (self.is_thrower() || self.is_matte())
    }

    /// True where light from `toward` meets a mirror, a lens from outside, or the coat of a matte body: that mirrors only.
    #[inline]
    pub fn throws(&self, toward: Vec3, mirrors: bool) -> bool {
        match &self.bsdf {
            Bsdf::CoatedDiffuse(_) => mirrors,
            Bsdf::Dielectric(_) => toward.dot(self.surface.ng) > 0.0,
            _ => self.is_thrower(),
        }
    }

    /// Draws where light goes that comes from a lamp, straight from it where this is the `first` surface: of a coated body that
    /// throws only what the coat mirrors.
    #[inline]
    pub fn sample_thrown(&mut self, first: bool, u: [f32; 3], waves: &M::Waves) -> Option<BsdfSample<M>> {
        match self.bsdf {
            Bsdf::CoatedDiffuse(_) if first => self.bsdf.split_mirror(self.wo, 0.0, waves),
            _ => self.bsdf.sample(self.wo, u, waves),
        }
    }

    /// What scattering from `wo` into `wi` (world space) is to be multiplied with where it is light that comes from `wo`: on
    /// surfaces with interpolated normals the two directions differ. Veach 1997, equation 5.19.
    #[inline]
    pub fn adjoint(&self, wi: Vec3) -> f32 {
        let (ng, normal) = (self.surface.ng, self.frame.normal);
        let wo = self.frame.to_world(self.wo);
        ((wo.dot(normal) * wi.dot(ng)) / (wo.dot(ng) * wi.dot(normal))).abs()
    }

    /// True when a viewer in direction `toward` would see this surface from the same side and through the same normal.
    #[inline]
    pub fn looks_the_same(&self, toward: Vec3) -> bool {
        let side = 1.0f32.copysign(self.wo.z);
        !self.bent && self.frame.normal.dot(toward) * side >= GRAZING && self.surface.ng.dot(toward) * side > 0.0
    }

    /// Which of eight viewers would, who look along these directions: bit i for viewer i.
    #[inline]
    pub fn looks_the_same_along(&self, directions: Vec3x8) -> u8 {
        let facing = f32x8::splat(-1.0f32.copysign(self.wo.z));
        let cos = Vec3x8::splat(self.frame.normal).dot(directions) * facing;
        let cos_ng = Vec3x8::splat(self.surface.ng).dot(directions) * facing;
        let same = cos.cmp_ge(f32x8::splat(GRAZING)) & cos_ng.cmp_gt(f32x8::ZERO);
        if self.bent { 0 } else { same.move_mask() as u8 }
    }
}

/// The shading frame, its normal on the outward side and bent as far as needed to face the viewer on the side that is
/// really seen: an interpolated normal near a silhouette may not.
#[inline]
pub(super) fn facing(normal: Vec3, ng: Vec3, toward_viewer: Vec3) -> (Frame, bool) {
    let normal = normal * 1.0f32.copysign(normal.dot(ng));
    let side = 1.0f32.copysign(toward_viewer.dot(ng));
    let cos = normal.dot(toward_viewer) * side;
    if cos >= GRAZING {
        return (Frame::new(normal), false);
    }
    let across = normal - toward_viewer * normal.dot(toward_viewer);
    (Frame::new((across + toward_viewer * (side * GRAZING)).normalize()), true)
}
