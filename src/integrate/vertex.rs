//! A surface point with its scattering, ready for one step of a path.

use glam::Vec3;

use crate::bsdf::{Bsdf, BsdfSample, Pdf};
use crate::math::Frame;
use crate::mode::{Lanes, Mode};
use crate::scene::{Cones, Material, Scene, Surface};

/// Smallest cosine between a bent shading normal and the viewer.
const GRAZING: f32 = 1e-3;

pub(super) struct Vertex<'s, M: Mode> {
    pub surface: Surface<'s>,
    pub material: &'s Material<M>,
    pub frame: Frame,
    pub bsdf: Bsdf<'s, M>,
    /// Towards where the path came from, local frame.
    pub wo: Vec3,
    /// Absorption on the side of `wo`, linear RGB per metre.
    pub absorption_per_m: Vec3,
    /// True when the interpolated normal had to be bent to face the viewer: scattering then depends on where that is.
    pub bent: bool,
    /// Where a matte surface sees shapes that gather light.
    cones: Option<Cones>,
}

impl<'s, M: Mode> Vertex<'s, M> {
    #[inline]
    pub fn new(
        scene: &'s Scene<M>,
        surface: Surface<'s>,
        toward_viewer: Vec3,
        absorption_per_m: Vec3,
        waves: &M::Waves,
    ) -> Self {
        let material = scene.material(&surface);
        let (frame, bent) = facing(material.normal(&surface, scene.textures()), surface.ng, toward_viewer);
        let bsdf = material.bsdf(&surface, scene.textures(), waves);
        let wo = frame.to_local(toward_viewer);
        let cones = match bsdf {
            Bsdf::Diffuse(_) | Bsdf::CoatedDiffuse(_) => scene.stage.casters.cones(surface.position),
            Bsdf::Black | Bsdf::Conductor(_) | Bsdf::Dielectric(_) => None,
        };
        Self { surface, material, frame, bsdf, wo, absorption_per_m, bent, cones }
    }

    /// The local direction, unless interpolated normal and real surface disagree about its side.
    #[inline]
    pub fn local(&self, wi: Vec3) -> Option<Vec3> {
        let local = self.frame.to_local(wi);
        (local.z * wi.dot(self.surface.ng) > 0.0).then_some(local)
    }

    /// (f |cos theta_i|, density of [`Vertex::sample`] in 1/sr) for a direction in world and local space.
    #[inline]
    pub fn eval(&self, wi: Vec3, local: Vec3, waves: &M::Waves) -> (M::Light, f32) {
        let (value, pdf) = self.bsdf.eval(self.wo, local, waves);
        match &self.cones {
            Some(cones) => (value, cones.mixed_pdf(pdf, wi)),
            None => (value, pdf),
        }
    }

    /// Draws a direction, as [`Bsdf::sample`] does, from the surface's scattering and what there is to aim at.
    #[inline]
    pub fn sample(&self, [u_lobe, u_x, u_y]: [f32; 3], waves: &M::Waves) -> Option<BsdfSample<M>> {
        let Some(cones) = &self.cones else { return self.bsdf.sample(self.wo, [u_lobe, u_x, u_y], waves) };
        match cones.sample([u_lobe, u_x, u_y]) {
            Ok(direction) => {
                let wi = self.frame.to_local(direction);
                let (value, pdf) = self.eval(direction, wi, waves);
                let seen = !value.is_black();
                seen.then(|| BsdfSample {
                    wi,
                    weight: value * (1.0 / pdf),
                    pdf: Pdf::SolidAngle(pdf),
                    collapses: false,
                })
            }
            Err(u_lobe) => {
                let mut sample = self.bsdf.sample(self.wo, [u_lobe, u_x, u_y], waves)?;
                let factor = match sample.pdf {
                    Pdf::SolidAngle(own) => {
                        let pdf = cones.mixed_pdf(own, self.frame.to_world(sample.wi));
                        sample.pdf = Pdf::SolidAngle(pdf);
                        own / pdf
                    }
                    Pdf::Delta | Pdf::Through(_) => cones.own_weight(),
                };
                sample.weight = sample.weight * factor;
                Some(sample)
            }
        }
    }

    /// True when a viewer in direction `toward` would see this surface from the same side and through the same normal.
    #[inline]
    pub fn looks_the_same(&self, toward: Vec3) -> bool {
        let side = 1.0f32.copysign(self.wo.z);
        !self.bent && self.frame.normal.dot(toward) * side >= GRAZING && self.surface.ng.dot(toward) * side > 0.0
    }
}

/// The shading frame, its normal on the outward side and bent as far as needed to face the viewer on the side that is
/// really seen: an interpolated normal near a silhouette may not.
#[inline]
fn facing(normal: Vec3, ng: Vec3, toward_viewer: Vec3) -> (Frame, bool) {
    let normal = normal * 1.0f32.copysign(normal.dot(ng));
    let side = 1.0f32.copysign(toward_viewer.dot(ng));
    let cos = normal.dot(toward_viewer) * side;
    if cos >= GRAZING {
        return (Frame::new(normal), false);
    }
    let across = normal - toward_viewer * normal.dot(toward_viewer);
    (Frame::new((across + toward_viewer * (side * GRAZING)).normalize()), true)
}
