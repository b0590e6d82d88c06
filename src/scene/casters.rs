//! Shiny and transparent shapes, as seen from matte surfaces: where caustics come from.
//!
//! Light that reaches a matte surface over glass or metal can only be found by scattered rays, and from afar few happen to
//! go there: such light would come as rare bright specks. Matte surfaces therefore send a share of their rays into the cones
//! in which they see those shapes (the projection maps of Jensen & Christensen 1995, followed from the other end).

use arrayvec::ArrayVec;
use glam::Vec3;

use super::surface::{Body, Place};
use crate::bsdf::is_straight;
use crate::document::{Base, Material, Scalar};
use crate::embree::Accel;
use crate::math::Frame;
use crate::math::warp::{cone_pdf, square_to_cone};

/// Shapes that count: the largest ones.
const MOST: usize = 8;
/// Largest roughness that still gathers light.
const SHINY_ALPHA: f32 = 0.3;
/// Largest 1 - cos of a cone's half angle: wider ones are found well enough without help.
const WIDEST: f32 = 0.5;
/// Share of the rays that go into cones where there are some.
const SHARE: f32 = 0.3;

/// Bounding spheres (centre, radius) of what gathers light, world space.
pub struct Casters(ArrayVec<(Vec3, f32), MOST>);

/// What casters look like from one point: an axis and 1 - cos of the half angle for each.
pub struct Cones(ArrayVec<(Vec3, f32), MOST>);

impl Casters {
    pub(super) fn new(places: &[Place], materials: &[Material], accel: &Accel) -> Self {
        let shiny: Vec<bool> = materials.iter().map(is_shiny).collect();
        let is_caster = |place: &&Place| place.parts.iter().any(|part| shiny[part.material as usize]);
        let mut of_shape = std::collections::HashMap::new();
        let mut spheres: Vec<(Vec3, f32)> = Vec::new();
        for place in places.iter().filter(is_caster) {
            let (center, radius) = match place.body {
                Body::Sphere { center, radius } => (center, radius),
                Body::Mesh(_) => *of_shape.entry(place.shape).or_insert_with(|| around(accel.positions(place.shape))),
            };
            spheres.push((place.to_world.transform_point3(center), radius * place.scale));
        }
        spheres.sort_by(|a, b| b.1.total_cmp(&a.1));
        Self(spheres.into_iter().take(MOST).collect())
    }

    /// The cones seen from a point; `None` where there are none worth aiming at.
    #[inline]
    pub fn cones(&self, from: Vec3) -> Option<Cones> {
        let cone = |&(center, radius): &(Vec3, f32)| {
            let offset = center - from;
            let distance2 = offset.length_squared();
            let sin2 = radius * radius / distance2;
            let one_minus_cos = sin2 / (1.0 + (1.0 - sin2).max(0.0).sqrt());
            (one_minus_cos < WIDEST && one_minus_cos > 0.0).then(|| (offset / distance2.sqrt(), one_minus_cos))
        };
        let cones: ArrayVec<_, MOST> = self.0.iter().filter_map(cone).collect();
        (!cones.is_empty()).then_some(Cones(cones))
    }
}

impl Cones {
    /// Density of a direction that is drawn from a surface's own density and from the cones together, 1/sr.
    #[inline]
    pub fn mixed_pdf(&self, own_pdf: f32, wi: Vec3) -> f32 {
        let inside = |(axis, one_minus_cos): &&(Vec3, f32)| 1.0 - axis.dot(wi) <= *one_minus_cos;
        let sum: f32 = self.0.iter().filter(inside).map(|cone| cone_pdf(cone.1)).sum();
        own_pdf + SHARE * (sum / self.0.len() as f32 - own_pdf)
    }

    /// Where to draw from: a direction in one of the cones, or what is left of the first number for the surface itself.
    #[inline]
    pub fn sample(&self, [u_choice, u_x, u_y]: [f32; 3]) -> Result<Vec3, f32> {
        if u_choice >= SHARE {
            return Err((u_choice - SHARE) / (1.0 - SHARE));
        }
        let index = (u_choice / SHARE * self.0.len() as f32) as usize;
        let (axis, one_minus_cos) = self.0[index.min(self.0.len() - 1)];
        Ok(Frame::new(axis).to_world(square_to_cone([u_x, u_y], one_minus_cos)))
    }

    /// Factor for what can only be drawn from the surface itself.
    pub fn own_weight(&self) -> f32 {
        1.0 / (1.0 - SHARE)
    }
}

fn is_shiny(material: &Material) -> bool {
    let smooth = |alpha: &Scalar| alpha.map.is_none() && alpha.value <= SHINY_ALPHA;
    match &material.base {
        Base::Conductor { microfacets, .. } => smooth(&microfacets.roughness),
        Base::Dielectric { microfacets, index, .. } => {
            let straight = index.curve().is_ok_and(|c| c.as_constant().is_some_and(|n| is_straight(n.re as f32)));
            smooth(&microfacets.roughness) && !straight
        }
        Base::Black | Base::Diffuse { .. } => false,
    }
}

/// A sphere around points: the middle of their box, and the farthest of them.
fn around(points: &[Vec3]) -> (Vec3, f32) {
    let (low, high) = points.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
    let center = 0.5 * (low + high);
    let radius2 = points.iter().map(|p| p.distance_squared(center)).fold(0.0, f32::max);
    (center, radius2.sqrt())
}
