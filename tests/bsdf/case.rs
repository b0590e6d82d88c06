//! A surface to be tested: a base, a film and the shape of the facets, compiled for one colour mode.

use glam::Vec3;
use pellicle::bsdf::{
    Bsdf, BsdfSample, Coat, CoatedDiffuse, Conductor, Dielectric, Diffuse, Interface, Microfacets, Missing, Multiple,
    is_straight, multiple_color,
};
use pellicle::color::{Emission, Index, Sensor};
use pellicle::document::Distribution;
use pellicle::film::{Layer, Range, Side, Stack};
use pellicle::math::Sampler;
use pellicle::mode::{FilmPlan, Lanes, Mode};

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Diffuse,
    CoatedDiffuse,
    Conductor { n: f32, k: f32 },
    Dielectric { eta: f32 },
}

/// What the case is made of.
#[derive(Clone, Debug)]
pub struct Recipe {
    pub kind: Kind,
    pub alpha: f32,
    pub distribution: Distribution,
    /// (n, k, nm), outermost first.
    pub layers: Vec<(f32, f32, f64)>,
}

impl std::fmt::Display for Recipe {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{:?} under {:?}, {:?} {}", self.kind, self.layers, self.distribution, self.alpha)
    }
}

pub struct Case<M: Mode> {
    pub recipe: Recipe,
    pub waves: M::Waves,
    film: M::Film,
    missing: Option<Missing>,
    interface: Option<(Interface, M::Profile)>,
}

impl<M: Mode> Case<M> {
    pub fn new(recipe: Recipe, waves: M::Waves) -> Self {
        let curve = |n: f32, k: f32| Index::Constant { n, k }.curve().unwrap();
        let layers = &recipe.layers;
        let layers = layers.iter().map(|&(n, k, thickness_nm)| Layer { index: curve(n, k), thickness_nm }).collect();
        let base = match recipe.kind {
            Kind::Diffuse | Kind::CoatedDiffuse => curve(1.5, 0.0),
            Kind::Conductor { n, k } => curve(n, k),
            // What bends nothing is compiled as if it were not there.
            Kind::Dielectric { eta } => curve(if is_straight(eta) { 1.0 } else { eta }, 0.0),
        };
        let stack = Stack { outside: curve(1.0, 0.0), layers, base, varying: None, weight: 1.0 };
        let sensor = Sensor::new(&Emission::D65);
        let range = Range { min_nm: 0.0, max_nm: 0.0 };
        let film = M::film(&stack, &FilmPlan { range, sensor: &sensor, tolerance: 1.0, forced: None }).0;
        let (distribution, alpha) = (recipe.distribution, Some(recipe.alpha));
        let missing =
            matches!(recipe.kind, Kind::Conductor { .. }).then(|| Missing::new(distribution, alpha)).flatten();
        let interface = match recipe.kind {
            Kind::Dielectric { eta } if recipe.alpha > 0.0 => {
                Some((Interface::new(distribution, alpha, eta), M::profile(&film, &stack, range)))
            }
            _ => None,
        };
        Self { recipe, waves, film, missing, interface }
    }

    pub fn bsdf(&self) -> Bsdf<'_, M> {
        let one = M::Light::ONE;
        let coat = Coat { film: &self.film, thickness_nm: 0.0, reflect_tint: one, transmit_tint: one };
        let alpha = self.recipe.alpha;
        let microfacets = Microfacets { distribution: self.recipe.distribution, alpha };
        match self.recipe.kind {
            Kind::Diffuse => Bsdf::Diffuse(Diffuse { albedo: M::Light::splat(0.8) }),
            Kind::CoatedDiffuse => Bsdf::CoatedDiffuse(CoatedDiffuse {
                coat,
                albedo: one,
                ior: 1.5,
                internal_reflectance: self.average(Side::Inside),
                mirrors: true,
            }),
            Kind::Conductor { .. } => {
                let color = |missing: &Missing| multiple_color(self.average(Side::Outside), missing.mean(alpha));
                let multiple = self.missing.as_ref().map(|missing| (missing, color(missing)));
                Bsdf::Conductor(Conductor { coat, microfacets, multiple })
            }
            Kind::Dielectric { eta } => {
                let multiple =
                    self.interface.as_ref().filter(|_| !microfacets.is_smooth()).map(|(interface, profile)| {
                        Multiple::new(interface, alpha, eta, M::profiled(profile, 0.0, &self.waves))
                    });
                Bsdf::Dielectric(Dielectric { coat, microfacets, refraction: (eta, false), multiple, mirrors: true })
            }
        }
    }

    pub fn average(&self, side: Side) -> M::Light {
        M::average(&self.film, side, 0.0, &self.waves)
    }

    /// Reflectance of a facet from outside.
    pub fn reflectance(&self, cos: f32) -> M::Light {
        M::split(&self.film, Side::Outside, cos, 0.0, &self.waves).reflect
    }

    /// Directions to look from: above, and below where there is a below.
    pub fn views(&self) -> Vec<Vec3> {
        let above = [8.0f32, 50.0, 85.0].map(|deg: f32| {
            let (sin, cos) = deg.to_radians().sin_cos();
            Vec3::new(sin * 0.6, sin * 0.8, cos)
        });
        let mut views = above.to_vec();
        if matches!(self.recipe.kind, Kind::Dielectric { .. }) {
            views.extend(above.map(|w| Vec3::new(w.x, w.y, -w.z)));
        }
        views
    }

    pub fn draw(&self, bsdf: &Bsdf<M>, wo: Vec3, index: u32) -> Option<BsdfSample<M>> {
        let mut sampler = Sampler::new(7, index, 11);
        let [a, b, c, _] = sampler.next_4d();
        bsdf.sample(wo, [a, b, c], &self.waves)
    }

    /// Mean weight: the share of light from everywhere that the surface returns.
    pub fn albedo(&self, wo: Vec3, draws: u32) -> M::Light {
        let bsdf = self.bsdf();
        let mut total = M::Light::ZERO;
        // Sums of thousands of f32 lose digits; sums of sums do not.
        for block in 0..draws.div_ceil(256) {
            let mut sum = M::Light::ZERO;
            for index in block * 256..((block + 1) * 256).min(draws) {
                if let Some(sample) = self.draw(&bsdf, wo, index) {
                    // Radiance into a denser body is compressed; energy is not.
                    let crossing = sample.wi.z * wo.z < 0.0;
                    sum += sample.weight * if crossing { bsdf.compression(sample.wi.z < 0.0) } else { 1.0 };
                }
            }
            total += sum;
        }
        total * (1.0 / draws as f32)
    }
}
