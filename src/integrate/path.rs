//! The path loop.

use glam::Vec3;

use super::direct::direct_light;
use super::{PathLimits, Strategy, Tally, mis_weight};
use crate::bsdf::{Bsdf, Pdf};
use crate::embree::Ray;
use crate::math::{Frame, Sampler};
use crate::mode::{Lanes, Mode};
use crate::scene::{Material, Scene, Surface};

/// Surfaces that one path segment may pass straight through.
const MAX_THROUGH: u32 = 256;
/// Bounces before Russian roulette begins.
const SURE_BOUNCES: u32 = 3;
/// Smallest cosine between a bent shading normal and the viewer.
const GRAZING: f32 = 1e-3;

/// A surface point with its scattering, ready for one step of a path.
pub(super) struct Vertex<'s, M: Mode> {
    pub surface: &'s Surface<'s>,
    pub frame: Frame,
    pub bsdf: Bsdf<'s, M>,
    /// Towards where the path came from, local frame.
    pub wo: Vec3,
    /// Absorption on the side of `wo`, linear RGB per metre.
    pub absorption_per_m: Vec3,
}

/// Radiance along a ray, estimated with one path.
pub fn radiance<M: Mode>(
    scene: &Scene<M>,
    mut ray: Ray,
    waves: &mut M::Waves,
    sampler: &mut Sampler,
    limits: &PathLimits,
    tally: &mut Tally,
) -> M::Light {
    let mut radiance = M::Light::ZERO;
    let mut throughput = M::Light::ONE;
    // Where the ray was scattered and with what density; `None` when light sampling could not have drawn it.
    let mut scattered: Option<(Vec3, f32)> = None;
    let mut absorption_per_m = Vec3::ZERO;
    // Radiance is compressed inside dense bodies; roulette must not mistake that for loss.
    let mut compression = 1.0f32;
    let (mut bounce, mut passed) = (0, 0);

    loop {
        // Find the next surface, or the light beyond the scene.
        tally.rays += 1;
        let Some(surface) = scene.intersect(&ray) else {
            scene.escape(ray.dir, waves, |light, light_pdf| {
                radiance += throughput * light * hit_weight(scattered.map(|(_, pdf)| (pdf, light_pdf)), limits);
            });
            return radiance;
        };
        if absorption_per_m != Vec3::ZERO {
            throughput *= transmission::<M>(absorption_per_m, surface.position.distance(ray.origin), waves);
        }

        // Add what the surface emits.
        let material = scene.material(&surface);
        if surface.emitter != u32::MAX {
            let light = scene.emitted(&surface, -ray.dir.dot(surface.ng), waves);
            if !light.is_black() {
                let densities = scattered.map(|(from, pdf)| (pdf, scene.stage.lights.surface_pdf(from, &surface)));
                radiance += throughput * light * hit_weight(densities, limits);
            }
        }
        if bounce >= limits.max_bounces {
            return radiance;
        }

        // Pass through holes.
        let [u_lobe, u_x, u_y, u_hole] = sampler.next_4d();
        let coverage = material.coverage(&surface, scene.textures());
        if u_hole >= coverage && passed < MAX_THROUGH {
            passed += 1;
            scattered = scattered.map(|(from, pdf)| (from, pdf * (1.0 - coverage)));
            ray = Ray::new(surface.leave(ray.dir), ray.dir);
            continue;
        }

        // Sample the lights.
        let vertex = Vertex::new(scene, material, &surface, -ray.dir, absorption_per_m, waves);
        let [u_light, u_light_x, u_light_y, u_roulette] = sampler.next_4d();
        if !vertex.bsdf.is_delta() {
            radiance +=
                throughput * direct_light(scene, &vertex, [u_light, u_light_x, u_light_y], waves, limits, tally);
        }

        // Sample the surface.
        let Some(sample) = vertex.bsdf.sample(vertex.wo, [u_lobe, u_x, u_y], waves) else { return radiance };
        let wi = vertex.frame.to_world(sample.wi);
        if wi.dot(surface.ng) * sample.wi.z <= 0.0 && !matches!(sample.pdf, Pdf::Through(_)) {
            // An interpolated normal sent the ray to the wrong side of the real surface.
            return radiance;
        }
        throughput *= sample.weight;
        if sample.collapses {
            M::collapse(waves);
        }
        if sample.wi.z * vertex.wo.z < 0.0 {
            let entering = sample.wi.z < 0.0;
            absorption_per_m = if entering { material.absorption_per_m() } else { Vec3::ZERO };
            compression *= vertex.bsdf.compression(entering);
        }
        ray = Ray::new(surface.leave(wi), wi);
        match sample.pdf {
            Pdf::Through(chance) if passed < MAX_THROUGH => {
                passed += 1;
                scattered = scattered.map(|(from, pdf)| (from, pdf * chance));
                continue;
            }
            Pdf::Through(_) => return radiance,
            Pdf::Delta => scattered = None,
            Pdf::SolidAngle(pdf) => scattered = Some((surface.position, pdf)),
        }
        bounce += 1;

        // Play Russian roulette with what is left.
        if bounce > SURE_BOUNCES {
            let survival = (throughput.max() * compression).min(0.95);
            if u_roulette >= survival {
                return radiance;
            }
            throughput = throughput * (1.0 / survival);
        }
    }
}

/// Weight of light that a ray ran into. `densities`: of the scattered ray, and of light sampling for the same direction.
#[inline]
fn hit_weight(densities: Option<(f32, f32)>, limits: &PathLimits) -> f32 {
    match (densities, limits.strategy) {
        (None, _) | (_, Strategy::Bsdf) => 1.0,
        (Some(_), Strategy::Light) => 0.0,
        (Some((scatter_pdf, light_pdf)), Strategy::Mis) => mis_weight(scatter_pdf, light_pdf),
    }
}

/// Beer-Lambert.
pub(super) fn transmission<M: Mode>(absorption_per_m: Vec3, distance_m: f32, waves: &M::Waves) -> M::Light {
    M::reflectance((-absorption_per_m * distance_m).exp(), waves)
}

impl<'s, M: Mode> Vertex<'s, M> {
    #[inline]
    fn new(
        scene: &'s Scene<M>,
        material: &'s Material<M>,
        surface: &'s Surface<'s>,
        toward_viewer: Vec3,
        absorption_per_m: Vec3,
        waves: &M::Waves,
    ) -> Self {
        let frame = facing(material.normal(surface, scene.textures()), surface.ng, toward_viewer);
        let bsdf = material.bsdf(surface, scene.textures(), waves);
        let wo = frame.to_local(toward_viewer);
        Self { surface, frame, bsdf, wo, absorption_per_m }
    }
}

/// The shading frame, its normal on the outward side and bent as far as needed to face the viewer on the side that is
/// really seen: an interpolated normal near a silhouette may not.
#[inline]
fn facing(normal: Vec3, ng: Vec3, toward_viewer: Vec3) -> Frame {
    let normal = normal * 1.0f32.copysign(normal.dot(ng));
    let side = 1.0f32.copysign(toward_viewer.dot(ng));
    let cos = normal.dot(toward_viewer) * side;
    if cos >= GRAZING {
        return Frame::new(normal);
    }
    let across = normal - toward_viewer * normal.dot(toward_viewer);
    Frame::new((across + toward_viewer * (side * GRAZING)).normalize())
}
