//! What camera rays see first, for layers beside the picture's colour, and what a denoiser wants to know.

use glam::{Vec2, Vec3};

use super::vertex::{Vertex, facing};
use crate::embree::{BATCH, Hits, Ray};
use crate::math::{Sampler, set_bits};
use crate::mode::{Lanes, Mode};
use crate::scene::{Interior, Material, Scene};

/// Surfaces that one ray goes on from: mirrors, clear glass, holes.
const MAX_FOLLOWED: u32 = 32;

/// The surface that a ray met, seen from the camera.
#[derive(Clone, Copy, Debug)]
pub struct Sight {
    pub position: Vec3,
    /// Shading normal and geometric normal, world space, on the viewer's side.
    pub normal: Vec3,
    pub ng: Vec3,
    pub uv: Vec2,
    /// Linear sRGB under the picture's white ([`Bsdf::albedo`](crate::bsdf::Bsdf::albedo)).
    pub albedo: Vec3,
    /// Of all films together.
    pub film_nm: f32,
    /// Index into the document's nodes.
    pub node: u32,
    /// Index into the document's materials; beyond them for surfaces without one.
    pub material: u32,
}

/// What tells a denoiser where edges and textures are: at the first surface that is not perfectly smooth, seen in mirrors
/// and through glass.
#[derive(Clone, Copy, Debug, Default)]
pub struct Clue {
    /// Linear sRGB within 0..1; of lamps and the sky their light, as far as it goes.
    pub albedo: Vec3,
    /// On the viewer's side; zero where there is no surface.
    pub normal: Vec3,
}

/// What is to be found out besides where things are: each costs a look at the material.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wanted {
    pub albedo: bool,
    pub film: bool,
    pub clues: bool,
}

/// One ray on its way to what it shows.
struct Look<M: Mode> {
    ray: Ray,
    interior: Interior,
    sampler: Sampler,
    waves: M::Waves,
    throughput: M::Light,
    /// The first surface that is there.
    sight: Option<Sight>,
    clue: Clue,
}

/// Looks along camera rays.
pub struct Looker<'s, M: Mode> {
    scene: &'s Scene<M>,
    white: M::Spectrum,
    wanted: Wanted,
}

impl<'s, M: Mode> Looker<'s, M> {
    pub fn new(scene: &'s Scene<M>, wanted: Wanted) -> Self {
        Self { scene, white: M::spectrum(&scene.stage.white, &scene.stage.sensor), wanted }
    }

    /// What the first `count` of these camera rays show, which start in `interior`, each with the rest of its sample's
    /// numbers and one that picks wavelengths: the first surface that is there (holes are passed as the path loop passes
    /// them, by the same numbers), and a clue.
    pub fn look(
        &self,
        rays: &[(Ray, Sampler, f32); BATCH],
        interior: Interior,
        count: usize,
    ) -> [(Option<Sight>, Clue); BATCH] {
        let mut looks: [Look<M>; BATCH] = std::array::from_fn(|i| {
            let (ray, ref sampler, u_waves) = rays[i];
            let (sight, clue) = (None, Clue::default());
            let (sampler, waves, throughput) = (sampler.clone(), M::waves(u_waves), M::Light::ONE);
            Look { ray, interior, sampler, waves, throughput, sight, clue }
        });
        let mut active = ((1u32 << count) - 1) as u8;
        let mut hits = Hits::default();
        for _ in 0..MAX_FOLLOWED {
            if active == 0 {
                break;
            }
            let rays: [Ray; BATCH] = std::array::from_fn(|i| looks[i].ray);
            self.scene.stage.intersect_batch(&rays, active, &mut hits);
            for i in set_bits(active) {
                if !self.follow(&mut looks[i], &hits, i) {
                    active &= !(1 << i);
                }
            }
        }
        looks.map(|look| (look.sight, look.clue))
    }

    /// Takes note of what ray `lane` has met; true if it goes on from there.
    fn follow(&self, look: &mut Look<M>, hits: &Hits, lane: usize) -> bool {
        let scene = self.scene;
        let Some(mut surface) = scene.surface(hits, lane) else {
            if !self.wanted.clues {
                return false;
            }
            let mut sky = M::Light::ZERO;
            scene.escape(look.ray.origin, look.ray.dir, &look.waves, |light, _| sky += light);
            look.clue = Clue { albedo: self.shown(look, sky), normal: Vec3::ZERO };
            return false;
        };
        let (material, beyond) = scene.meet(&look.ray, &mut surface, &look.interior);
        let u = look.sampler.next_4d();
        let covers = |material: &&Material<M>| u[3] < material.coverage(&surface, scene.textures());
        let Some(material) = material.filter(covers) else {
            look.interior = beyond;
            look.ray = Ray::new(surface.leave(look.ray.dir), look.ray.dir);
            return true;
        };

        let toward = -look.ray.dir;
        let side = 1.0f32.copysign(surface.ng.dot(toward));
        let painting = self.wanted.albedo || self.wanted.clues;
        let vertex =
            painting.then(|| Vertex::new(scene, (surface, material), toward, [look.interior, beyond], &look.waves));
        let albedo = vertex.as_ref().map_or(M::Light::ZERO, |vertex| vertex.bsdf.albedo(&look.waves));
        let painted = M::emitted(&self.white, Vec3::ONE, &look.waves) * albedo;
        look.sight.get_or_insert_with(|| {
            let normal = material.normal(&surface, scene.textures());
            Sight {
                position: surface.position,
                normal: facing(normal, surface.ng, toward).0.normal * side,
                ng: surface.ng * side,
                uv: scene.uv(hits, lane),
                albedo: M::to_rgb(painted, &look.waves, &scene.stage.sensor),
                film_nm: if self.wanted.film { scene.film_nm(&surface) } else { 0.0 },
                node: surface.place.node,
                material: surface.material,
            }
        });
        let Some(vertex) = vertex.filter(|_| self.wanted.clues) else { return false };

        // Tell a denoiser more, and go on from what is perfectly smooth, by the numbers that the path loop would take.
        let emitted = match surface.emitter {
            u32::MAX => M::Light::ZERO,
            _ => scene.emitted(&surface, toward.dot(surface.ng), &look.waves),
        };
        look.clue = Clue { albedo: self.shown(look, painted + emitted), normal: vertex.frame.normal * side };
        if !vertex.bsdf.is_delta() {
            return false;
        }
        look.sampler.next_4d();
        let Some(sample) = vertex.bsdf.sample(vertex.wo, [u[2], u[0], u[1]], &look.waves) else { return false };
        let wi = vertex.frame.to_world(sample.wi);
        look.throughput *= sample.weight;
        if sample.collapses {
            M::collapse(&mut look.waves);
        }
        if sample.wi.z * vertex.wo.z < 0.0 {
            look.interior = vertex.beyond;
        }
        look.ray = Ray::new(surface.leave(wi), wi);
        true
    }

    /// As a denoiser takes it.
    fn shown(&self, look: &Look<M>, light: M::Light) -> Vec3 {
        let rgb = M::to_rgb(look.throughput * light, &look.waves, &self.scene.stage.sensor);
        rgb.clamp(Vec3::ZERO, Vec3::ONE)
    }
}
