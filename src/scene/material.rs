//! Materials compiled for one colour mode, and the BSDF that each gives at a surface point.

use std::sync::Arc;

use glam::Vec3;

use super::surface::Surface;
use super::texture::{Texture, lookup_rgb, scalar};
use super::{BuildError, FilmOptions};
use crate::bsdf::{
    Bsdf, Coat, CoatedDiffuse, Conductor, Dielectric, Diffuse, Interface, Microfacets, Missing, Multiple, is_straight,
    multiple_color,
};
use crate::color::{Index, IndexCurve, Sensor};
use crate::document::{self, Base, Distribution, NormalMap, Scalar, Thickness, Tint};
use crate::film::{Layer, Range, Side, Stack, Verdict};
use crate::mode::{FilmPlan, Mode};

/// What surrounds bodies that are no media.
pub(super) const AIR: Index = Index::Constant { n: 1.0, k: 0.0 };

/// About the share of light that the coat of a matte body mirrors.
const COAT: f32 = 0.1;

pub struct Material<M: Mode> {
    body: Body<M>,
    /// Of the one film that varies (or a constant, which the compiled film ignores).
    thickness: Thickness,
    tint: Tint,
    normal_map: Option<NormalMap>,
    opacity: Scalar,
    lets_through: bool,
    /// What was chosen for the interface, for people to read; `None` where there is no interface.
    pub verdict: Option<Verdict>,
}

enum Body<M: Mode> {
    Black,
    Diffuse {
        reflectance: document::Texture,
    },
    CoatedDiffuse {
        reflectance: document::Texture,
        film: M::Film,
        ior: f32,
    },
    Conductor {
        film: M::Film,
        distribution: Distribution,
        roughness: Scalar,
        missing: Option<Missing>,
    },
    Dielectric {
        film: M::Film,
        distribution: Distribution,
        roughness: Scalar,
        eta: M::Eta,
        absorption_per_m: Vec3,
        /// What its facets lose; `None` where it is smooth.
        rough: Option<(Interface, M::Profile)>,
    },
    /// Transmits everything, bent but unreflected (CGL `<refraction>`).
    Refractor {
        film: M::Film,
        eta: M::Eta,
        absorption_per_m: Vec3,
    },
}

impl<M: Mode> Material<M> {
    /// `around` is what a transparent body lies in.
    pub fn new(
        source: &document::Material,
        around: &Index,
        sensor: &Sensor,
        options: &FilmOptions,
    ) -> Result<Self, BuildError> {
        let range = source.films.iter().map(|f| &f.thickness).find(|t| t.varies()).map(Thickness::range);
        let plan = FilmPlan {
            range: range.unwrap_or(Range { min_nm: 0.0, max_nm: 0.0 }),
            sensor,
            tolerance: f64::from(options.tolerance),
            forced: options.rung,
        };
        let mut verdict = None;
        let mut compile = |base: &Index| -> Result<(M::Film, Stack), BuildError> {
            let stack = stack_of(source, around, base)?;
            let (film, chosen) = M::film(&stack, &plan);
            verdict = chosen;
            Ok((film, stack))
        };
        let mut straight = false;
        let body = match &source.base {
            Base::Black => Body::Black,
            Base::Diffuse { reflectance, .. } if source.films.is_empty() => {
                Body::Diffuse { reflectance: reflectance.clone() }
            }
            Base::Diffuse { reflectance, ior } => Body::CoatedDiffuse {
                reflectance: reflectance.clone(),
                film: compile(&Index::Constant { n: *ior, k: 0.0 })?.0,
                ior: *ior,
            },
            Base::Conductor { index, microfacets } => Body::Conductor {
                film: compile(index)?.0,
                distribution: microfacets.distribution,
                roughness: microfacets.roughness.clone(),
                missing: Missing::new(microfacets.distribution, constant_alpha(microfacets)),
            },
            Base::Dielectric { index, microfacets, absorption_per_m, fresnel, .. } => {
                let outside = curve_of(source, around)?;
                let relative = curve_of(source, index)?.relative_to(&outside);
                straight = relative.as_constant().is_some_and(|constant| is_straight(constant.re as f32));
                // What bends nothing reflects nothing by itself, not even all light along its inside.
                let index = if straight { around } else { index };
                let eta = M::eta(&curve_of(source, index)?.relative_to(&outside));
                let absorption_per_m = *absorption_per_m;
                if *fresnel || !source.films.is_empty() {
                    let (film, stack) = compile(index)?;
                    let rough = (constant_alpha(microfacets) != Some(0.0)).then(|| {
                        // Dispersion hardly changes which facets stand in the way: one index serves all paths.
                        let (across, _) = M::refraction(&eta, &M::waves(0.5));
                        let interface = Interface::new(microfacets.distribution, constant_alpha(microfacets), across);
                        (interface, M::profile(&film, &stack, plan.range))
                    });
                    Body::Dielectric {
                        film,
                        rough,
                        distribution: microfacets.distribution,
                        roughness: microfacets.roughness.clone(),
                        eta,
                        absorption_per_m,
                    }
                } else {
                    // No interface at all: a medium against itself transmits everything.
                    let (film, _) = compile(around)?;
                    Body::Refractor { film, eta, absorption_per_m }
                }
            }
        };
        let varying = source.films.iter().map(|f| &f.thickness).find(|t| t.varies()).cloned();
        Ok(Self {
            body,
            lets_through: straight || source.opacity.map.is_some() || source.opacity.value < 1.0,
            thickness: varying.unwrap_or(Thickness::Constant { nm: 0.0 }),
            tint: source.tint,
            normal_map: source.normal_map.clone(),
            opacity: source.opacity.clone(),
            verdict,
        })
    }

    /// Scattering at a surface point.
    #[inline]
    pub fn bsdf<'s>(&'s self, surface: &Surface, textures: &[Arc<Texture>], waves: &M::Waves) -> Bsdf<'s, M> {
        let rgb = |texture: &document::Texture| match &texture.map {
            Some(map) => texture.value * lookup_rgb(textures, map, &surface.uv),
            None => texture.value,
        };
        let microfacets = |distribution: &Distribution, roughness: &Scalar| Microfacets {
            distribution: *distribution,
            alpha: scalar(roughness, surface, textures).clamp(0.0, 1.0),
        };
        let coat = |film: &'s M::Film| Coat {
            film,
            thickness_nm: self.thickness.at(surface, textures),
            reflect_tint: M::reflectance(self.tint.reflect, waves),
            transmit_tint: M::reflectance(self.tint.transmit, waves),
        };
        match &self.body {
            Body::Black => Bsdf::Black,
            Body::Diffuse { reflectance } => {
                Bsdf::Diffuse(Diffuse { albedo: M::reflectance(rgb(reflectance) * self.tint.reflect, waves) })
            }
            Body::CoatedDiffuse { reflectance, film, ior } => {
                let coat = coat(film);
                let albedo = M::reflectance(rgb(reflectance), waves);
                let internal_reflectance = M::average(film, Side::Inside, coat.thickness_nm, waves);
                Bsdf::CoatedDiffuse(CoatedDiffuse { coat, albedo, ior: *ior, internal_reflectance, mirrors: true })
            }
            Body::Conductor { film, distribution, roughness, missing } => {
                let (coat, microfacets) = (coat(film), microfacets(distribution, roughness));
                let multiple = missing.as_ref().map(|missing| {
                    let average = M::average(film, Side::Outside, coat.thickness_nm, waves) * coat.reflect_tint;
                    (missing, multiple_color(average, missing.mean(microfacets.alpha)))
                });
                Bsdf::Conductor(Conductor { coat, microfacets, multiple })
            }
            Body::Dielectric { film, distribution, roughness, eta, rough, .. } => {
                let (coat, microfacets) = (coat(film), microfacets(distribution, roughness));
                let refraction = M::refraction(eta, waves);
                let multiple = rough.as_ref().filter(|_| !microfacets.is_smooth()).map(|(interface, profile)| {
                    let profile = M::profiled(profile, coat.thickness_nm, waves);
                    Multiple::new(interface, microfacets.alpha, refraction.0, profile)
                });
                Bsdf::Dielectric(Dielectric { coat, microfacets, refraction, multiple, mirrors: true })
            }
            Body::Refractor { film, eta, .. } => Bsdf::Dielectric(Dielectric {
                coat: coat(film),
                microfacets: Microfacets { distribution: Distribution::Ggx, alpha: 0.0 },
                refraction: M::refraction(eta, waves),
                multiple: None,
                mirrors: true,
            }),
        }
    }

    /// Share of the surface that is there, 0..1.
    #[inline]
    pub fn coverage(&self, surface: &Surface, textures: &[Arc<Texture>]) -> f32 {
        scalar(&self.opacity, surface, textures).clamp(0.0, 1.0)
    }

    /// Absorption of what lies inside, linear RGB per metre; `None` for opaque bodies.
    #[inline]
    pub fn absorption_per_m(&self) -> Option<Vec3> {
        match self.body {
            Body::Dielectric { absorption_per_m, .. } | Body::Refractor { absorption_per_m, .. } => {
                Some(absorption_per_m)
            }
            _ => None,
        }
    }

    /// True when a ray may go straight through somewhere.
    pub fn lets_through(&self) -> bool {
        self.lets_through
    }

    /// About which share of light it throws in patterns, as mirrors and lenses do.
    pub fn casts(&self) -> f32 {
        match &self.body {
            Body::Conductor { roughness, distribution, .. } => {
                let is_broad = Microfacets { distribution: *distribution, alpha: roughness.value }.is_broad();
                if is_broad && roughness.map.is_none() { 0.0 } else { 1.0 }
            }
            Body::Dielectric { .. } | Body::Refractor { .. } => 1.0,
            Body::CoatedDiffuse { .. } => COAT,
            Body::Black | Body::Diffuse { .. } => 0.0,
        }
    }

    /// The shading normal, bent by the normal map where there is one.
    #[inline]
    pub fn normal(&self, surface: &Surface, textures: &[Arc<Texture>]) -> Vec3 {
        match &self.normal_map {
            Some(normal_map) => bent(normal_map, surface, textures),
            None => surface.normal,
        }
    }
}

/// The shading normal under a normal map.
fn bent(normal_map: &NormalMap, surface: &Surface, textures: &[Arc<Texture>]) -> Vec3 {
    let normal = surface.normal;
    let Some(tangent) = (surface.dpdu - normal * normal.dot(surface.dpdu)).try_normalize() else { return normal };
    let texel = lookup_rgb(textures, &normal_map.map, &surface.uv) * 2.0 - 1.0;
    let bent = tangent * (texel.x * normal_map.scale)
        + normal.cross(tangent) * (texel.y * normal_map.scale)
        + normal * texel.z.max(1e-3);
    bent.normalize()
}

/// The roughness where no image varies it.
fn constant_alpha(microfacets: &document::Microfacets) -> Option<f32> {
    microfacets.roughness.map.is_none().then_some(microfacets.roughness.value.clamp(0.0, 1.0))
}

fn curve_of(material: &document::Material, index: &Index) -> Result<IndexCurve, BuildError> {
    index.curve().map_err(|source| BuildError::Index { material: material.id.clone(), source })
}

/// The optical stack of a material between what lies around it and this base.
fn stack_of(material: &document::Material, around: &Index, base: &Index) -> Result<Stack, BuildError> {
    let mut layers = Vec::with_capacity(material.films.len());
    for film in &material.films {
        let thickness_nm = match film.thickness {
            Thickness::Constant { nm } => f64::from(nm),
            _ => 0.0,
        };
        layers.push(Layer { index: curve_of(material, &film.index)?, thickness_nm });
    }
    Ok(Stack {
        outside: curve_of(material, around)?,
        varying: material.films.iter().position(|f| f.thickness.varies()),
        weight: material.films.iter().map(|f| f64::from(f.weight)).product(),
        layers,
        base: curve_of(material, base)?,
    })
}
