//! Surfaces: a base under films.

use glam::Vec3;

use super::texture::{Map, NormalMap, Scalar, Texture};
use crate::color::{Emission, Index};

/// A surface: one base under any number of films, outermost first.
#[derive(Clone, Debug)]
pub struct Material {
    pub id: String,
    pub base: Base,
    pub films: Vec<Film>,
    pub emission: Option<SurfaceEmission>,
    /// Multiplies reflected and transmitted light (CGL tints); 1 = none.
    pub tint: Tint,
    pub normal_map: Option<NormalMap>,
    /// Coverage: 0 lets everything through unbent.
    pub opacity: Scalar,
}

impl Default for Material {
    /// Grey, opaque, without films.
    fn default() -> Self {
        Self {
            id: String::new(),
            base: Base::default(),
            films: Vec::new(),
            emission: None,
            tint: Tint::default(),
            normal_map: None,
            opacity: Scalar::constant(1.0),
        }
    }
}

impl Material {
    /// Every image reference.
    pub fn maps(&self) -> impl Iterator<Item = &Map> {
        let base = match &self.base {
            Base::Diffuse { reflectance, .. } => reflectance.map.as_ref(),
            Base::Conductor { microfacets, .. } | Base::Dielectric { microfacets, .. } => {
                microfacets.roughness.map.as_ref()
            }
            Base::Black => None,
        };
        let films = self.films.iter().filter_map(|film| match &film.thickness {
            Thickness::Map { map, .. } => Some(map),
            _ => None,
        });
        let emission = self.emission.as_ref().and_then(|emission| emission.radiance.map.as_ref());
        let normal = self.normal_map.as_ref().map(|normal_map| &normal_map.map);
        base.into_iter().chain(films).chain(emission).chain(normal).chain(&self.opacity.map)
    }

    /// What it takes in memory.
    pub fn bytes(&self) -> usize {
        let base = match &self.base {
            Base::Conductor { index, .. } | Base::Dielectric { index, .. } => Some(index),
            Base::Diffuse { .. } | Base::Black => None,
        };
        let indices = base.into_iter().chain(self.films.iter().map(|film| &film.index));
        let rows: usize = indices.map(|index| if let Index::Table(rows) = index { rows.len() } else { 0 }).sum();
        let spectrum = self.emission.as_ref().map_or(0, |emission| match &emission.spectrum {
            Emission::Table(rows) => rows.len(),
            _ => 0,
        });
        size_of::<Self>() + rows * size_of::<(f32, f32, f32)>() + spectrum * size_of::<(f32, f32)>()
    }

    fn maps_mut(&mut self) -> impl Iterator<Item = &mut Map> {
        let base = match &mut self.base {
            Base::Diffuse { reflectance, .. } => reflectance.map.as_mut(),
            Base::Conductor { microfacets, .. } | Base::Dielectric { microfacets, .. } => {
                microfacets.roughness.map.as_mut()
            }
            Base::Black => None,
        };
        let films = self.films.iter_mut().filter_map(|film| match &mut film.thickness {
            Thickness::Map { map, .. } => Some(map),
            _ => None,
        });
        let emission = self.emission.as_mut().and_then(|emission| emission.radiance.map.as_mut());
        let normal = self.normal_map.as_mut().map(|normal_map| &mut normal_map.map);
        base.into_iter().chain(films).chain(emission).chain(normal).chain(&mut self.opacity.map)
    }

    /// The distinct texture coordinates of its maps, by their slots.
    pub fn texcoords(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for map in self.maps() {
            if !names.contains(&map.texcoord.as_str()) {
                names.push(&map.texcoord);
            }
        }
        names
    }

    /// Gives each map the number of its texture coordinates among the material's.
    pub fn number_texcoords(&mut self) {
        let names: Vec<String> = self.texcoords().into_iter().map(str::to_owned).collect();
        for map in self.maps_mut() {
            map.slot = names.iter().position(|name| *name == map.texcoord).unwrap_or(0);
        }
    }
}

#[derive(Clone, Debug)]
pub enum Base {
    /// Reflects nothing (a pure emitter).
    Black,
    /// Lambertian. Under a film it becomes an interfaced diffuse base whose inside has refractive index `ior`.
    Diffuse {
        reflectance: Texture,
        ior: f32,
    },
    Conductor {
        index: Index,
        microfacets: Microfacets,
    },
    Dielectric {
        index: Index,
        microfacets: Microfacets,
        /// Beer-Lambert absorption inside, linear RGB, 1/m.
        absorption_per_m: Vec3,
        /// False for CGL `<refraction>`, which transmits everything and reflects nothing.
        fresnel: bool,
        /// Makes it a medium: where bodies overlap, the one of the highest priority is there. `None`: in air, whatever lies
        /// around it.
        priority: Option<u8>,
    },
}

impl Base {
    /// Absorption of what lies inside, linear RGB per metre; zero for opaque bodies.
    pub fn absorption_per_m(&self) -> Vec3 {
        match self {
            Self::Dielectric { absorption_per_m, .. } => *absorption_per_m,
            _ => Vec3::ZERO,
        }
    }
}

impl Default for Base {
    fn default() -> Self {
        Self::Diffuse { reflectance: Texture::constant(Vec3::splat(0.5)), ior: 1.5 }
    }
}

#[derive(Clone, Debug)]
pub struct Microfacets {
    pub distribution: Distribution,
    /// The distribution's alpha itself, 0..1; 0 is perfectly smooth.
    pub roughness: Scalar,
}

impl Default for Microfacets {
    /// Perfectly smooth.
    fn default() -> Self {
        Self { distribution: Distribution::default(), roughness: Scalar::constant(0.0) }
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Distribution {
    #[default]
    Ggx,
    Beckmann,
}

#[derive(Clone, Copy, Debug)]
pub struct Tint {
    pub reflect: Vec3,
    pub transmit: Vec3,
}

impl Default for Tint {
    fn default() -> Self {
        Self { reflect: Vec3::ONE, transmit: Vec3::ONE }
    }
}

/// Light that a surface sends out.
#[derive(Clone, Debug)]
pub struct SurfaceEmission {
    /// W/(sr m2) per channel.
    pub radiance: Texture,
    pub spectrum: Emission,
    pub two_sided: bool,
}

/// Thickest film, nm.
pub const THICKEST_NM: f32 = 50_000.0;

/// One homogeneous thin layer.
#[derive(Clone, Debug)]
pub struct Film {
    pub index: Index,
    pub thickness: Thickness,
    /// Coverage of the film, 0..1.
    pub weight: f32,
}

#[derive(Clone, Debug)]
pub enum Thickness {
    Constant {
        nm: f32,
    },
    /// nm * (1 + amplitude * noise(frequency * p)), improved Perlin noise in [-1, 1] at the object-space point.
    Noise {
        nm: f32,
        amplitude: f32,
        frequency: f32,
        octaves: u32,
        seed: u32,
    },
    /// Gravity drainage between the object's highest and lowest point along world up.
    Drain {
        top_nm: f32,
        bottom_nm: f32,
        exponent: f32,
    },
    /// mix(min, max, texel), the texel read as linear data.
    Map {
        min_nm: f32,
        max_nm: f32,
        map: Map,
    },
}
