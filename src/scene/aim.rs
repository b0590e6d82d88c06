//! Rays from lamps that are aimed at mirrors and lenses, and how likely each is.

use std::collections::HashMap;
use std::f32::consts::{PI, TAU};
use std::f64::consts::SQRT_2;

use glam::Vec3;

use super::light::{LampPoint, visible_cap};
use super::surface::Body;
use super::{Interior, Scene};
use crate::embree::{Ray, Shape};
use crate::math::warp::{cone_pdf, square_to_cone, square_to_disk};
use crate::math::{Frame, GOLDEN, extent};
use crate::mode::{Lanes, Mode};

/// A ball around a shape that throws light.
struct Caster {
    /// [`Place::number`](super::Place::number) of the shape.
    place: u32,
    center: Vec3,
    radius_m: f32,
    /// The chance that it is aimed at.
    chance: f32,
}

/// Lamps that are drawn to learn how much light comes to a caster.
const DRAWS: usize = 16;

/// Aims at every shape that has a mirror, a lens or a coat among its materials, as often as it throws light.
pub struct Aim {
    casters: Vec<Caster>,
    /// Of the chances up to and including each caster's.
    sums: Vec<f32>,
    /// The caster that each place is, if it is one.
    of_place: Vec<Option<u32>>,
}

/// Light on its way from a lamp.
pub struct Shot<M: Mode> {
    pub ray: Ray,
    pub interior: Interior,
    /// Along the ray.
    pub radiance: M::Light,
    /// Of such rays, per m2 across them and sr.
    pub density: f32,
    /// The place that it is aimed at: whatever else it meets first was aimed at in its own right.
    pub place: u32,
    /// Where it comes from; `None` beyond the scene.
    pub lamp: Option<LampPoint>,
}

impl Aim {
    /// `None` where there is nothing to aim at.
    pub fn new<M: Mode>(scene: &Scene<M>) -> Option<Self> {
        let stage = &scene.stage;
        let mut boxes = HashMap::<Shape, (Vec3, Vec3)>::new();
        let mut casters = Vec::new();
        for (place, number) in stage.places.iter().zip(0..) {
            let casts = place.parts.iter().map(|part| scene.materials[part.material as usize].casts());
            let casts = casts.fold(0.0, f32::max);
            if casts == 0.0 {
                continue;
            }
            let (center, radius) = match &place.body {
                Body::Sphere { center, radius } => (*center, *radius),
                Body::Mesh(_) => {
                    let positions = stage.accel.positions(place.shape);
                    let (low, high) = *boxes.entry(place.shape).or_insert_with(|| extent(positions.iter().copied()));
                    (0.5 * (low + high), 0.5 * low.distance(high))
                }
            };
            // A little larger, so that rounding puts no vertex outside.
            let (center, radius_m) = (place.to_world.transform_point3(center), 1.0001 * radius * place.scale);
            let mut caster = Caster { place: number, center, radius_m, chance: 0.0 };
            caster.chance = casts * caster.flux(scene);
            if caster.chance > 0.0 && caster.chance.is_finite() {
                casters.push(caster);
            }
        }
        let total: f32 = casters.iter().map(|caster| caster.chance).sum();
        let mut sum = 0.0;
        let mut sums = Vec::with_capacity(casters.len());
        let mut of_place = vec![None; stage.places.len()];
        for (caster, index) in casters.iter_mut().zip(0..) {
            caster.chance /= total;
            sum += caster.chance;
            sums.push(sum);
            of_place[caster.place as usize] = Some(index);
        }
        (!casters.is_empty()).then_some(Self { casters, sums, of_place })
    }

    /// Light from a lamp, drawn by eight numbers; `None` where a draw finds none.
    pub fn shoot<M: Mode>(
        &self,
        scene: &Scene<M>,
        [[u_caster, u_light, u_light_x, u_light_y], [u_x, u_y, ..]]: [[f32; 4]; 2],
        waves: &M::Waves,
    ) -> Option<Shot<M>> {
        let at = self.sums.partition_point(|&sum| sum <= u_caster);
        let caster = &self.casters[at.min(self.casters.len() - 1)];
        let (emitter, light) = scene.stage.lights.sample(caster.center, [u_light, u_light_x, u_light_y])?;
        if light.alone {
            return None;
        }
        let place = caster.place;
        let Some(lamp) = light.lamp(emitter, caster.center) else {
            let (radiance, density) = self.from_afar(scene, place, light.wi, waves);
            let aim =
                caster.center + Frame::new(light.wi).to_world(square_to_disk([u_x, u_y]).extend(0.0)) * caster.radius_m;
            let (low, high) = scene.stage.bounds;
            let ray = Ray::new(aim + light.wi * low.distance(high), -light.wi);
            let counts = density > 0.0 && !radiance.is_black();
            return counts.then_some(Shot { ray, interior: Interior::AIR, radiance, density, place, lamp: None });
        };
        let dir = Frame::new(-light.wi).to_world(square_to_cone([u_x, u_y], caster.cone(light.distance_m)));
        let density = caster.density(&lamp, dir, light.pdf);
        let radiance = scene.arriving(&light.light, waves);
        if density <= 0.0 || radiance.is_black() {
            return None;
        }
        // A lamp's own surface does not hold its light back.
        let origin = lamp.position + lamp.ng * (2e-6 * (lamp.position.abs().max_element() + caster.radius_m));
        let ray = Ray::new(origin, dir);
        Some(Shot { ray, interior: scene.interior_at(origin), radiance, density, place, lamp: Some(lamp) })
    }

    /// Density with which [`shoot`](Self::shoot) sends light from a point of a lamp in a direction, where it meets this place
    /// first; 0 where it never does.
    pub fn density<M: Mode>(&self, scene: &Scene<M>, place: u32, lamp: &LampPoint, dir: Vec3) -> f32 {
        let Some(caster) = self.caster(place) else { return 0.0 };
        caster.density(lamp, dir, scene.stage.lights.surface_pdf(caster.center, lamp))
    }

    /// Radiance that comes from a direction beyond the scene, and the density with which [`shoot`](Self::shoot) sends it.
    pub fn from_afar<M: Mode>(&self, scene: &Scene<M>, place: u32, toward: Vec3, waves: &M::Waves) -> (M::Light, f32) {
        let (mut radiance, mut density) = (M::Light::ZERO, 0.0);
        let caster = self.caster(place);
        scene.escape(caster.map_or(Vec3::ZERO, |caster| caster.center), toward, waves, |light, pdf| {
            radiance += light;
            density += caster.map_or(0.0, |caster| caster.chance * pdf / (PI * caster.radius_m * caster.radius_m));
        });
        (radiance, density)
    }

    fn caster(&self, place: u32) -> Option<&Caster> {
        self.of_place.get(place as usize).copied().flatten().map(|index| &self.casters[index as usize])
    }
}

impl Caster {
    /// Of lamps that rays can hit, about what comes into the ball.
    fn flux<M: Mode>(&self, scene: &Scene<M>) -> f32 {
        let from_lamp = |k: usize| {
            let k = k as f64 + 0.5;
            let u = [k / DRAWS as f64, (k * GOLDEN).fract(), (k * SQRT_2).fract()].map(|u| u as f32);
            let (_, light) = scene.stage.lights.sample(self.center, u).filter(|(_, light)| !light.alone)?;
            let area_m2 = match light.distance_m.is_finite() {
                true => TAU * self.cone(light.distance_m) * light.distance_m * light.distance_m,
                false => PI * self.radius_m * self.radius_m,
            };
            Some(scene.arriving(&light.light, &M::waves(0.5)).mean() / light.pdf * area_m2)
        };
        (0..DRAWS).filter_map(from_lamp).sum()
    }

    /// 1 - cos of the half angle of the cone around the ball, seen from so far from its centre: all directions from inside.
    fn cone(&self, distance_m: f32) -> f32 {
        visible_cap(distance_m, self.radius_m).unwrap_or(2.0)
    }

    /// Of rays that leave a point of a lamp in a direction. `pdf`: of drawing the point, per sr at the centre.
    fn density(&self, lamp: &LampPoint, dir: Vec3, pdf: f32) -> f32 {
        let to_center = self.center - lamp.position;
        let distance_m = to_center.length();
        let (cos, cos_at_center) = (dir.dot(lamp.ng), to_center.dot(lamp.ng) / distance_m);
        // Only what shines towards both.
        if cos <= 0.0 || cos_at_center <= 0.0 {
            return 0.0;
        }
        let at_lamp = pdf * cos_at_center / (distance_m * distance_m);
        self.chance * at_lamp * cone_pdf(self.cone(distance_m)) / cos
    }
}
