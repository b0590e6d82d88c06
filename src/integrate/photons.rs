//! Light that mirrors and lenses throw onto other surfaces, followed from the lamps.

use arrayvec::ArrayVec;
use glam::Vec3;
use rayon::prelude::*;

use super::vertex::Vertex;
use crate::bsdf::{Bsdf, Pdf};
use crate::embree::Ray;
use crate::math::Sampler;
use crate::mode::{Lanes, Mode};
use crate::scene::{Aim, Interior, Scene, Shot};

/// Surfaces that a photon may pass or be thrown by.
const MAX_SURFACES: u32 = 32;
/// Any number: photons are the same in every render of a scene.
const SEED: u32 = 0x70_68_6f_74;

/// Surfaces that a photon may land on: the second shows where what the first scatters goes, which is bright where light
/// was gathered in one place.
const LANDINGS: usize = 2;

/// Where thrown light lands.
#[derive(Clone, Copy)]
pub(super) struct Photon {
    pub position: Vec3,
    /// The point that threw it here.
    pub thrower: Vec3,
    /// W, mean of the lanes.
    pub power: f32,
    /// W/m2 that light sampling would find there, and what would come from elsewhere that it lights, if nothing stood in
    /// between.
    pub direct: f32,
    pub indirect: f32,
}

/// Sends out `count` photons towards mirrors and lenses; those that are thrown onto a surface of another kind come back, and
/// again where it scatters them to.
/// They tell where to look for light, not how much there is: how radiance and importance differ at crossed surfaces does
/// not matter here.
pub(super) fn trace<M: Mode>(scene: &Scene<M>, aim: &Aim, count: u32) -> Vec<Photon> {
    let photons = |index: u32| {
        let mut sampler = Sampler::new(0, index, SEED);
        let [u_wave, ..] = sampler.next_4d();
        let waves = M::waves(u_wave);
        let u = [sampler.next_4d(), sampler.next_4d()];
        let Shot { ray, light, density, lamp, .. } = aim.shoot(scene, u, &waves)?;
        // Camera paths cannot run into the others, wherever they look.
        (!lamp.is_singular()).then(|| follow(scene, ray, light.mean() / (density * count as f32), sampler, &waves))
    };
    let counts = |photon: &Photon| {
        photon.power > 0.0 && photon.power.is_finite() && (photon.direct + photon.indirect).is_finite()
    };
    (0..count).into_par_iter().filter_map(photons).flatten_iter().filter(counts).collect()
}

/// Follows a photon until it is lost or has landed often enough.
fn follow<M: Mode>(
    scene: &Scene<M>,
    mut ray: Ray,
    mut power: f32,
    mut sampler: Sampler,
    waves: &M::Waves,
) -> ArrayVec<Photon, LANDINGS> {
    let mut photons = ArrayVec::new();
    let mut thrower = None;
    let mut interior = Interior::AIR;
    for _ in 0..MAX_SURFACES {
        let Some(mut surface) = scene.intersect(&ray) else { break };
        let [u_x, u_y, u_lobe, u_hole] = sampler.next_4d();
        let (material, beyond) = scene.meet(&ray, &mut surface, &interior);
        let there = material.filter(|material| u_hole < material.coverage(&surface, scene.textures()));
        let Some(material) = there else {
            ray = Ray::new(surface.leave(ray.dir), ray.dir);
            interior = beyond;
            continue;
        };
        let mut vertex = Vertex::new(scene, (surface, material), -ray.dir, [interior, beyond], waves);
        let is_first = thrower.is_none();
        if !throws(&vertex, is_first) {
            let position = vertex.surface.position;
            let Some(thrower) = thrower else { break };
            let direct = direct(scene, &vertex, &mut sampler, waves);
            let indirect = indirect(scene, &vertex, &mut sampler, waves);
            photons.push(Photon { position, thrower, power, direct, indirect });
            if photons.is_full() {
                break;
            }
        }
        let Some(sample) = vertex.sample_thrown(is_first, [u_lobe, u_x, u_y], waves) else { break };
        let wi = vertex.frame.to_world(sample.wi);
        power *= sample.weight.mean();
        if !matches!(sample.pdf, Pdf::Through(_)) {
            thrower = Some(vertex.surface.position);
        }
        if sample.wi.z * vertex.wo.z < 0.0 {
            interior = beyond;
        }
        ray = Ray::new(vertex.surface.leave(wi), wi);
    }
    photons
}

/// True for mirrors and lenses, and for coats that come first; photons land on the others.
fn throws<M: Mode>(vertex: &Vertex<M>, is_first: bool) -> bool {
    match &vertex.bsdf {
        Bsdf::Conductor(_) | Bsdf::Dielectric(_) => true,
        Bsdf::CoatedDiffuse(_) => is_first,
        Bsdf::Black | Bsdf::Diffuse(_) => false,
    }
}

/// W/m2 from a lamp, if nothing stands in between.
fn direct<M: Mode>(scene: &Scene<M>, vertex: &Vertex<M>, sampler: &mut Sampler, waves: &M::Waves) -> f32 {
    let [u_light, u_light_x, u_light_y, _] = sampler.next_4d();
    scene.stage.lights.sample(vertex.surface.position, [u_light, u_light_x, u_light_y]).map_or(0.0, |(_, light)| {
        let Some(wi) = vertex.local(light.wi) else { return 0.0 };
        scene.arriving(&light.light, waves).mean() * wi.z.abs() / light.pdf
    })
}

/// W/m2 from another surface that lamps light, if nothing stands in between.
fn indirect<M: Mode>(scene: &Scene<M>, vertex: &Vertex<M>, sampler: &mut Sampler, waves: &M::Waves) -> f32 {
    let [u_x, u_y, u_lobe, _] = sampler.next_4d();
    let Some(sample) = vertex.bsdf.sample(vertex.wo, [u_lobe, u_x, u_y], waves) else { return 0.0 };
    let wi = vertex.frame.to_world(sample.wi);
    let ray = Ray::new(vertex.surface.leave(wi), wi);
    let Some(mut surface) = scene.intersect(&ray) else { return 0.0 };
    let (Some(material), beyond) = scene.meet(&ray, &mut surface, &vertex.interior) else { return 0.0 };
    let other = Vertex::new(scene, (surface, material), -wi, [vertex.interior, beyond], waves);
    if throws(&other, false) {
        return 0.0;
    }
    direct(scene, &other, sampler, waves) * other.bsdf.albedo(waves).mean()
}
