//! Materials compiled for one colour mode, and the BSDF that each gives at a surface point.

use glam::Vec3;

use super::light::Source;
use super::surface::Surface;
use super::texture::{Texture, lookup_rgb, lookup_scalar};
use super::{BuildError, BuildOptions};
use crate::bsdf::{Bsdf, Coat, CoatedDiffuse, Conductor, Dielectric, Diffuse, Microfacets};
use crate::color::{Index, IndexCurve, Sensor};
use crate::document::{self, Base, Distribution, NormalMap, Scalar, Thickness, Tint};
use crate::film::{Layer, Range, Side, Stack, Verdict};
use crate::math::Frame;
use crate::mode::{FilmPlan, Lanes, Mode};

/// Wavelength at which bodies refract in RGB mode: the helium d line, where glass makers quote indices.
const REFRACTION_NM: f64 = 587.56;

pub struct Material<M: Mode> {
    body: Body<M>,
    /// Of the one film that varies (or a constant, which the compiled film ignores).
    thickness: Thickness,
    tint: Tint,
    normal_map: Option<NormalMap>,
    opacity: Scalar,
    pub emission: Option<SurfaceEmission<M>>,
    /// What was chosen for the interface, for people to read; `None` where there is no interface.
    pub verdict: Option<Verdict>,
}

/// Emission of a surface.
pub struct SurfaceEmission<M: Mode> {
    pub radiance: document::Texture,
    spectrum: M::Spectrum,
    pub two_sided: bool,
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
    },
    Dielectric {
        film: M::Film,
        distribution: Distribution,
        roughness: Scalar,
        eta: f32,
        absorption_per_m: Vec3,
    },
    /// Transmits everything, bent but unreflected (CGL `<refraction>`).
    Refractor {
        film: M::Film,
        eta: f32,
        absorption_per_m: Vec3,
    },
}

impl<M: Mode> Material<M> {
    pub fn new(source: &document::Material, sensor: &Sensor, options: &BuildOptions) -> Result<Self, BuildError> {
        let range = source.films.iter().map(|f| &f.thickness).find(|t| t.varies()).map(Thickness::range);
        let plan = FilmPlan {
            range: range.unwrap_or(Range { min_nm: 0.0, max_nm: 0.0 }),
            sensor,
            tolerance: f64::from(options.tolerance),
            forced: options.rung,
        };
        let mut verdict = None;
        let mut compile = |base: &Index| -> Result<M::Film, BuildError> {
            let stack = stack_of(source, base)?;
            let (film, chosen) = M::film(&stack, &plan);
            verdict = Some(chosen);
            Ok(film)
        };
        let body = match &source.base {
            Base::Black => Body::Black,
            Base::Diffuse { reflectance, .. } if source.films.is_empty() => {
                Body::Diffuse { reflectance: reflectance.clone() }
            }
            Base::Diffuse { reflectance, ior } => Body::CoatedDiffuse {
                reflectance: reflectance.clone(),
                film: compile(&Index::Constant { n: *ior, k: 0.0 })?,
                ior: *ior,
            },
            Base::Conductor { index, microfacets } => Body::Conductor {
                film: compile(index)?,
                distribution: microfacets.distribution,
                roughness: microfacets.roughness.clone(),
            },
            Base::Dielectric { index, microfacets, absorption_per_m, fresnel } => {
                let eta = curve_of(source, index)?.at(REFRACTION_NM).re as f32;
                let absorption_per_m = *absorption_per_m;
                if *fresnel || !source.films.is_empty() {
                    Body::Dielectric {
                        film: compile(index)?,
                        distribution: microfacets.distribution,
                        roughness: microfacets.roughness.clone(),
                        eta,
                        absorption_per_m,
                    }
                } else {
                    // No interface at all: air against air transmits everything.
                    let film = compile(&Index::Constant { n: 1.0, k: 0.0 })?;
                    Body::Refractor { film, eta, absorption_per_m }
                }
            }
        };
        let varying = source.films.iter().map(|f| &f.thickness).find(|t| t.varies()).cloned();
        let emission = source.emission.as_ref().map(|emission| SurfaceEmission {
            radiance: emission.radiance.clone(),
            spectrum: M::spectrum(&emission.spectrum, sensor),
            two_sided: emission.two_sided,
        });
        Ok(Self {
            body,
            thickness: varying.unwrap_or(Thickness::Constant { nm: 0.0 }),
            tint: source.tint,
            normal_map: source.normal_map.clone(),
            opacity: source.opacity.clone(),
            emission,
            verdict,
        })
    }

    /// Scattering at a surface point.
    pub fn bsdf<'s>(&'s self, surface: &Surface, textures: &[Texture], waves: &M::Waves) -> Bsdf<'s, M> {
        let rgb = |texture: &document::Texture| match &texture.map {
            Some(map) => texture.value * lookup_rgb(textures, map, surface.uv),
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
                Bsdf::CoatedDiffuse(CoatedDiffuse { coat, albedo, ior: *ior, internal_reflectance })
            }
            Body::Conductor { film, distribution, roughness } => {
                Bsdf::Conductor(Conductor { coat: coat(film), microfacets: microfacets(distribution, roughness) })
            }
            Body::Dielectric { film, distribution, roughness, eta, .. } => Bsdf::Dielectric(Dielectric {
                coat: coat(film),
                microfacets: microfacets(distribution, roughness),
                eta: *eta,
            }),
            Body::Refractor { film, eta, .. } => Bsdf::Dielectric(Dielectric {
                coat: coat(film),
                microfacets: Microfacets { distribution: Distribution::Ggx, alpha: 0.0 },
                eta: *eta,
            }),
        }
    }

    /// Radiance that the surface sends out on the side of `cos` (the cosine to the outward normal).
    pub fn emitted(&self, surface: &Surface, cos: f32, textures: &[Texture], waves: &M::Waves) -> M::Light {
        match &self.emission {
            Some(emission) => match &emission.radiance.map {
                Some(map) => {
                    emission.uniform(cos, waves) * M::reflectance(lookup_rgb(textures, map, surface.uv), waves)
                }
                None => emission.uniform(cos, waves),
            },
            None => M::Light::ZERO,
        }
    }

    /// Share of the surface that is there, 0..1.
    pub fn coverage(&self, surface: &Surface, textures: &[Texture]) -> f32 {
        scalar(&self.opacity, surface, textures).clamp(0.0, 1.0)
    }

    /// Absorption of what lies inside, linear RGB per metre; zero for opaque bodies.
    pub fn absorption_per_m(&self) -> Vec3 {
        match self.body {
            Body::Dielectric { absorption_per_m, .. } | Body::Refractor { absorption_per_m, .. } => absorption_per_m,
            _ => Vec3::ZERO,
        }
    }

    /// True when a ray may go straight through somewhere.
    pub fn lets_through(&self) -> bool {
        let straight =
            matches!(self.body, Body::Dielectric { eta, .. } | Body::Refractor { eta, .. } if (eta - 1.0).abs() < 1e-3);
        straight || self.opacity.map.is_some() || self.opacity.value < 1.0
    }

    /// The shading frame, bent by the normal map where there is one.
    pub fn frame(&self, surface: &Surface, textures: &[Texture]) -> Frame {
        let Some(normal_map) = &self.normal_map else { return surface.frame };
        let normal = surface.frame.normal;
        let Some(tangent) = (surface.dpdu - normal * normal.dot(surface.dpdu)).try_normalize() else {
            return surface.frame;
        };
        let texel = lookup_rgb(textures, &normal_map.map, surface.uv) * 2.0 - 1.0;
        let bent = tangent * (texel.x * normal_map.scale)
            + normal.cross(tangent) * (texel.y * normal_map.scale)
            + normal * texel.z.max(1e-3);
        Frame::new(bent.normalize())
    }
}

impl<M: Mode> SurfaceEmission<M> {
    /// Radiance on the side of `cos` where no image varies it.
    pub fn uniform(&self, cos: f32, waves: &M::Waves) -> M::Light {
        if cos > 0.0 || self.two_sided {
            M::emitted(&self.spectrum, self.radiance.value, waves)
        } else {
            M::Light::ZERO
        }
    }

    /// Rough mean radiance, for choosing between lights.
    pub fn strength(&self) -> f32 {
        self.radiance.value.element_sum() / 3.0
    }
}

fn scalar(value: &Scalar, surface: &Surface, textures: &[Texture]) -> f32 {
    match &value.map {
        Some(map) => lookup_scalar(textures, map, surface.uv),
        None => value.value,
    }
}

fn curve_of(material: &document::Material, index: &Index) -> Result<IndexCurve, BuildError> {
    index.curve().map_err(|source| BuildError::Index { material: material.id.clone(), source })
}

/// The optical stack of a material over this base.
fn stack_of(material: &document::Material, base: &Index) -> Result<Stack, BuildError> {
    let mut layers = Vec::with_capacity(material.films.len());
    for film in &material.films {
        let thickness_nm = match film.thickness {
            Thickness::Constant { nm } => f64::from(nm),
            _ => 0.0,
        };
        layers.push(Layer { index: curve_of(material, &film.index)?, thickness_nm });
    }
    let air = Index::Constant { n: 1.0, k: 0.0 };
    Ok(Stack {
        outside: curve_of(material, &air)?,
        varying: material.films.iter().position(|f| f.thickness.varies()),
        weight: material.films.iter().map(|f| f64::from(f.weight)).product(),
        layers,
        base: curve_of(material, base)?,
    })
}

/// A light source's colour, as scene lights use it.
pub fn source<M: Mode>(rgb: Vec3, emission: &crate::color::Emission, sensor: &Sensor) -> Source<M> {
    Source { rgb, spectrum: M::spectrum(emission, sensor) }
}
