//! Rays from lamps that are aimed at mirrors and lenses, and how likely each is.

use std::collections::HashMap;
use std::f32::consts::{PI, TAU};
use std::f64::consts::SQRT_2;

use glam::Vec3;

use super::light::{Emitter, Lamp, LampPoint, visible_cap};
use super::lights::Lights;
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
/// Where there are lamps without extent, the share of draws in which each of them is as likely. Nothing else brings what they
/// throw, and a spot may shine on a caster beside its middle.
const EVEN_SHARE: f32 = 0.125;

/// Aims at every shape that has a mirror, a lens or a coat among its materials, as often as it throws light.
pub struct Aim {
    casters: Vec<Caster>,
    /// Of the chances up to and including each caster's.
    sums: Vec<f32>,
    /// The caster that each place is, if it is one.
    of_place: Vec<Option<u32>>,
    lamps: Lamps,
}

/// How a lamp is drawn for a caster: about as what it does at its middle tells.
struct Lamps {
    /// Emitters without extent.
    singular: Vec<u32>,
    even_share: f32,
}

/// Light on its way from a lamp.
pub struct Shot<M: Mode> {
    pub ray: Ray,
    pub interior: Interior,
    /// Radiance along the ray; of a point intensity, of parallel light irradiance.
    pub light: M::Light,
    /// Of such rays, per m2 across them and sr; of a point per sr, of parallel light per m2.
    pub density: f32,
    /// The place that it is aimed at: whatever else it meets first was aimed at in its own right.
    pub place: u32,
    pub lamp: Lamp,
}

impl Aim {
    /// `None` where there is nothing to aim at.
    pub fn new<M: Mode>(scene: &Scene<M>) -> Option<Self> {
        let stage = &scene.stage;
        let lamps = Lamps::of(&stage.lights);
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
            caster.chance = casts * caster.flux(scene, &lamps);
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
        (!casters.is_empty()).then_some(Self { casters, sums, of_place, lamps })
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
        let (place, center) = (caster.place, caster.center);
        let lights = &scene.stage.lights;
        let (emitter, chance) = self.lamps.choose(lights, center, u_light)?;
        let (source, chance) = (&lights.emitters[emitter as usize], caster.chance * chance);

        // Send light of a point or a spot into the cone that meets the ball.
        if let Some(position) = source.point([u_light_x, u_light_y]) {
            let (axis, width) = caster.cone_from(source, position)?;
            let dir = Frame::new(axis).to_world(square_to_cone([u_x, u_y], width));
            let light = scene.light(&source.intensity(dir)?, waves);
            let density = chance * cone_pdf(width);
            let (ray, interior) = (Ray::new(position, dir), scene.interior_at(position));
            let lamp = Lamp::Point { emitter, position };
            return (!light.is_black()).then_some(Shot { ray, interior, light, density, place, lamp });
        }

        let sample = source.sample(center, [u_light_x, u_light_y])?;
        let lamp = sample.lamp(emitter, center)?;
        let Lamp::Surface(point) = lamp else {
            // Send light from far away onto the ball's disc.
            let across = Frame::new(sample.wi).to_world(square_to_disk([u_x, u_y]).extend(0.0)) * caster.radius_m;
            let (low, high) = scene.stage.bounds;
            let ray = Ray::new(center + across + sample.wi * low.distance(high), -sample.wi);
            let (light, density) = match lamp {
                Lamp::Beyond => self.afar(scene, place, sample.wi, waves),
                _ => (scene.arriving(&sample.light, waves), chance * caster.density_across()),
            };
            let counts = density > 0.0 && !light.is_black();
            return counts.then_some(Shot { ray, interior: Interior::AIR, light, density, place, lamp });
        };

        // Send light from a shining surface towards the ball.
        let dir = Frame::new(-sample.wi).to_world(square_to_cone([u_x, u_y], caster.cone(sample.distance_m)));
        let density = lights.emitter_pdf(center, &point) * chance * caster.density_from(&point, dir);
        let light = scene.arriving(&sample.light, waves);
        if density <= 0.0 || light.is_black() {
            return None;
        }
        // A lamp's own surface does not hold its light back.
        let origin = point.position + point.ng * (2e-6 * (point.position.abs().max_element() + caster.radius_m));
        Some(Shot { ray: Ray::new(origin, dir), interior: scene.interior_at(origin), light, density, place, lamp })
    }

    /// Density with which [`shoot`](Self::shoot) sends light from a lamp in direction `toward`, that meets this place first and
    /// does so `at` this point; 0 where it never does. Per m2 and sr there; of a lamp without extent per m2 across its light.
    pub fn density<M: Mode>(
        &self,
        scene: &Scene<M>,
        place: u32,
        at: Vec3,
        lamp: &Lamp,
        toward: Vec3,
        waves: &M::Waves,
    ) -> f32 {
        let Some(caster) = self.caster(place) else { return 0.0 };
        let lights = &scene.stage.lights;
        let chance = |emitter| caster.chance * self.lamps.probability(lights, caster.center, emitter);
        match *lamp {
            Lamp::Surface(lamp) => {
                let at_lamp = lights.emitter_pdf(caster.center, &lamp) * chance(lamp.emitter);
                at_lamp * caster.density_from(&lamp, -toward)
            }
            Lamp::Point { emitter, position } => {
                let cone = caster.cone_from(&lights.emitters[emitter as usize], position);
                let per_sr = cone.map_or(0.0, |(_, width)| cone_pdf(width));
                chance(emitter) * per_sr / position.distance_squared(at)
            }
            Lamp::Parallel { emitter } => chance(emitter) * caster.density_across(),
            Lamp::Beyond => self.afar(scene, place, toward, waves).1,
        }
    }

    /// Radiance that comes from a direction beyond the scene, and the density with which [`shoot`](Self::shoot) sends it.
    fn afar<M: Mode>(&self, scene: &Scene<M>, place: u32, toward: Vec3, waves: &M::Waves) -> (M::Light, f32) {
        let (mut radiance, mut density) = (M::Light::ZERO, 0.0);
        let caster = self.caster(place);
        scene.escape(caster.map_or(Vec3::ZERO, |caster| caster.center), toward, waves, |light, pdf| {
            radiance += light;
            density += caster.map_or(0.0, |caster| caster.chance * pdf * caster.density_across());
        });
        (radiance, density * (1.0 - self.lamps.even_share))
    }

    /// True where light of lamps without extent may be thrown: camera paths cannot find it.
    pub fn has_singular_lamps(&self) -> bool {
        !self.lamps.singular.is_empty()
    }

    fn caster(&self, place: u32) -> Option<&Caster> {
        self.of_place.get(place as usize).copied().flatten().map(|index| &self.casters[index as usize])
    }
}

impl Lamps {
    fn of(lights: &Lights) -> Self {
        let singular: Vec<u32> =
            (0u32..).zip(&lights.emitters).filter(|(_, emitter)| emitter.is_singular()).map(|(i, _)| i).collect();
        let even_share = if singular.is_empty() { 0.0 } else { EVEN_SHARE };
        Self { singular, even_share }
    }

    /// An emitter for a caster with this middle, and the chance of it.
    fn choose(&self, lights: &Lights, center: Vec3, u: f32) -> Option<(u32, f32)> {
        let emitter = if u < self.even_share {
            let at = (u / self.even_share * self.singular.len() as f32) as usize;
            self.singular[at.min(self.singular.len() - 1)]
        } else {
            lights.choose(center, (u - self.even_share) / (1.0 - self.even_share))?.0
        };
        Some((emitter, self.probability(lights, center, emitter)))
    }

    fn probability(&self, lights: &Lights, center: Vec3, emitter: u32) -> f32 {
        let even = match lights.emitters[emitter as usize].is_singular() {
            true => self.even_share / self.singular.len() as f32,
            false => 0.0,
        };
        even + (1.0 - self.even_share) * lights.probability(center, emitter)
    }
}

impl Caster {
    /// About what comes into the ball from lamps that can be seen in mirrors, and those without extent.
    fn flux<M: Mode>(&self, scene: &Scene<M>, lamps: &Lamps) -> f32 {
        let from_lamp = |k: usize| {
            let k = k as f64 + 0.5;
            let u = [k / DRAWS as f64, (k * GOLDEN).fract(), (k * SQRT_2).fract()].map(|u| u as f32);
            let (emitter, chance) = lamps.choose(&scene.stage.lights, self.center, u[0])?;
            Some(self.flux_of(scene, emitter, [u[1], u[2]])? / chance)
        };
        (0..DRAWS).filter_map(from_lamp).sum()
    }

    /// Of one lamp.
    fn flux_of<M: Mode>(&self, scene: &Scene<M>, emitter: u32, u: [f32; 2]) -> Option<f32> {
        let source = &scene.stage.lights.emitters[emitter as usize];
        if let Some(position) = source.point(u) {
            let (axis, width) = self.cone_from(source, position)?;
            let distance_m = position.distance(self.center).max(self.radius_m);
            // In the middle of a spot's beam, wherever it meets the ball.
            let brightest = if let Emitter::Spot(spot) = source { spot.axis } else { axis };
            let intensity = scene.light(&source.intensity(brightest)?, &M::waves(0.5));
            return Some(intensity.mean() * source.gain(distance_m) * TAU * width);
        }
        let light = source.sample(self.center, u)?;
        let area_m2 = match light.lamp(emitter, self.center)? {
            Lamp::Surface(_) => TAU * self.cone(light.distance_m) * light.distance_m * light.distance_m,
            _ => PI * self.radius_m * self.radius_m,
        };
        Some(scene.arriving(&light.light, &M::waves(0.5)).mean() / light.pdf * area_m2)
    }

    /// 1 - cos of the half angle of the cone around the ball, seen from so far from its centre: all directions from inside.
    fn cone(&self, distance_m: f32) -> f32 {
        visible_cap(distance_m, self.radius_m).unwrap_or(2.0)
    }

    /// Where a point of a lamp shines, if it does so on the ball: the cone around that, or that of the lamp where it is
    /// narrower; its axis, and 1 - cos of its half angle.
    fn cone_from(&self, source: &Emitter, position: Vec3) -> Option<(Vec3, f32)> {
        let to_center = self.center - position;
        let axis = to_center.try_normalize().unwrap_or(Vec3::Z);
        let width = self.cone(to_center.length());
        let Emitter::Spot(spot) = source else { return Some((axis, width)) };
        let half_angles = [1.0 - width, spot.cos_half_cone].map(f32::acos);
        let reaches = axis.dot(spot.axis).clamp(-1.0, 1.0).acos() < half_angles[0] + half_angles[1];
        let own = (spot.axis, 1.0 - spot.cos_half_cone);
        reaches.then_some(if own.1 < width { own } else { (axis, width) })
    }

    /// Of rays from one direction, per m2 across them.
    fn density_across(&self) -> f32 {
        1.0 / (PI * self.radius_m * self.radius_m)
    }

    /// Of rays that leave a point of a lamp in a direction, once it has been drawn with density 1 per sr at the centre.
    fn density_from(&self, lamp: &LampPoint, dir: Vec3) -> f32 {
        let to_center = self.center - lamp.position;
        let distance_m = to_center.length();
        let (cos, cos_at_center) = (dir.dot(lamp.ng), to_center.dot(lamp.ng) / distance_m);
        // Only what shines towards both.
        if cos <= 0.0 || cos_at_center <= 0.0 {
            return 0.0;
        }
        let at_lamp = cos_at_center / (distance_m * distance_m);
        at_lamp * cone_pdf(self.cone(distance_m)) / cos
    }
}
