//! Mirrors and lenses, as far as light is aimed at them.

use std::collections::HashMap;

use glam::Vec3;

use super::Scene;
use super::surface::Body;
use crate::embree::Shape;
use crate::math::extent;
use crate::mode::Mode;

/// A ball around something that may throw light onto other surfaces.
#[derive(Clone, Copy, Debug)]
pub struct Caster {
    pub center: Vec3,
    pub radius_m: f32,
}

impl<M: Mode> Scene<M> {
    /// A ball around each shape that has a mirror or a lens among its materials.
    pub fn casters(&self) -> Vec<Caster> {
        let accel = &self.stage.accel;
        let mut boxes = HashMap::<Shape, (Vec3, Vec3)>::new();
        let casting =
            |place: &&super::Place| place.parts.iter().any(|part| self.materials[part.material as usize].casts());
        let ball = |place: &super::Place| {
            let (center, radius) = match &place.body {
                Body::Sphere { center, radius } => (*center, *radius),
                Body::Mesh(_) => {
                    let positions = accel.positions(place.shape);
                    let (low, high) = *boxes.entry(place.shape).or_insert_with(|| extent(positions.iter().copied()));
                    (0.5 * (low + high), 0.5 * low.distance(high))
                }
            };
            Caster { center: place.to_world.transform_point3(center), radius_m: radius * place.scale }
        };
        self.stage.places.iter().filter(casting).map(ball).filter(|caster| caster.radius_m > 0.0).collect()
    }
}
