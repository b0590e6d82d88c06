//! Light sources: emitting surfaces, points, spots, the sun, the sky. Each can be drawn from a point that it lights, and tells
//! the density with which it would have been.

use std::f32::consts::PI;

use glam::{Affine3A, Vec3};

use super::beam::Beam;
use super::environment::Sky;
use crate::document::{Falloff, SpotEdge};
use crate::math::Frame;
use crate::math::warp::{cone_pdf, square_to_cone, square_to_disk, square_to_sphere, square_to_triangle};

/// One source that light sampling can choose.
pub enum Emitter {
    /// A triangle of an emitting mesh, world space.
    Triangle(Triangle),
    /// An emitting sphere.
    Sphere(Sphere),
    Point {
        position: Vec3,
        intensity: Source,
        falloff: Falloff,
    },
    Spot(Spot),
    /// From a disc of directions around `toward`; parallel when `one_minus_cos` is 0. `color` is irradiance.
    Directional {
        toward: Vec3,
        one_minus_cos: f32,
        irradiance: Source,
    },
    Sky(Sky),
}

#[derive(Clone, Copy)]
pub struct Sphere {
    pub place: u32,
    pub material: u32,
    pub center: Vec3,
    pub radius: f32,
    /// Not in the BVH: only light sampling finds it.
    pub hidden: bool,
}

pub struct Triangle {
    pub place: u32,
    pub material: u32,
    pub prim: u32,
    pub corner: Vec3,
    pub edges: [Vec3; 2],
    /// Unit length, on the outward side.
    pub normal: Vec3,
    pub area_m2: f32,
    pub two_sided: bool,
    /// Not in the BVH: only light sampling finds it.
    pub hidden: bool,
}

pub struct Spot {
    pub position: Vec3,
    /// Of the disc that it shines from.
    pub radius_m: f32,
    pub axis: Vec3,
    pub cos_half_cone: f32,
    pub edge: SpotEdge,
    pub intensity: Source,
    pub falloff: Falloff,
}

/// A colour with the spectrum it is painted in; any colour mode can read it.
#[derive(Clone, Copy)]
pub struct Source {
    pub rgb: Vec3,
    /// Index into the scene's spectra.
    pub spectrum: u32,
}

impl Source {
    /// Mean over the colour channels, for choosing between lights.
    pub fn strength(&self) -> f32 {
        self.rgb.element_sum() / 3.0
    }

    fn scaled(self, factor: f32) -> Self {
        Self { rgb: self.rgb * factor, ..self }
    }
}

/// A direction drawn towards a light.
pub struct LightSample {
    pub wi: Vec3,
    pub distance_m: f32,
    pub light: LightAt,
    /// Density of the direction in 1/sr (1 for points and parallel light), times the chance of choosing this light.
    pub pdf: f32,
    /// True when no scattered ray can find the light: it is a point, parallel, or an invisible surface.
    pub alone: bool,
    /// Outward normal of a shining surface; zero for the others.
    pub ng: Vec3,
}

impl LightSample {
    /// Where it comes from, having been drawn for `from` on this emitter; `None` on a surface that no ray can hit.
    #[inline]
    pub fn lamp(&self, emitter: u32, from: Vec3) -> Option<Lamp> {
        let position = from + self.wi * self.distance_m;
        match (self.alone, self.distance_m.is_finite()) {
            (true, true) => (self.ng == Vec3::ZERO).then_some(Lamp::Point { emitter, position }),
            (true, false) => Some(Lamp::Parallel { emitter }),
            (false, true) => Some(Lamp::Surface(LampPoint { emitter, position, ng: self.ng })),
            (false, false) => Some(Lamp::Beyond),
        }
    }
}

/// Where light comes from; numbers of emitters are those of [`Lights`](super::Lights).
#[derive(Clone, Copy)]
pub enum Lamp {
    Surface(LampPoint),
    /// Without a surface: a point, or one of the disc that a spot shines from.
    Point {
        emitter: u32,
        position: Vec3,
    },
    /// From a single direction.
    Parallel {
        emitter: u32,
    },
    /// Skies and suns: all that lie in a direction.
    Beyond,
}

impl Lamp {
    /// True where no ray can run into it.
    #[inline]
    pub fn is_singular(&self) -> bool {
        matches!(self, Self::Point { .. } | Self::Parallel { .. })
    }
}

/// A point of a shining surface, world space.
#[derive(Clone, Copy)]
pub struct LampPoint {
    /// Its number among the emitters of [`Lights`](super::Lights).
    pub emitter: u32,
    pub position: Vec3,
    /// Outward.
    pub ng: Vec3,
}

/// What arrives along a drawn direction.
pub enum LightAt {
    /// Radiance, or irradiance over the cosine for a light without extent.
    Radiance(Source),
    /// Emission of a surface: its material and where on it.
    Surface { place: u32, material: u32, prim: u32, barycentric: [f32; 2], cos: f32 },
}

/// Radiance of a disc of directions that gives this irradiance: E / (pi sin^2).
pub(super) fn disc_radiance(irradiance: &Source, one_minus_cos: f32) -> Source {
    irradiance.scaled(1.0 / (PI * one_minus_cos * (2.0 - one_minus_cos)))
}

impl Emitter {
    /// What it sends into the scene, if it has a place there and fades with the distance. `strength`: greatest intensity, mean
    /// over the colours.
    pub(super) fn beam(&self, strength: f32) -> Option<Beam> {
        match self {
            Self::Triangle(triangle) => Some(triangle.beam(strength)),
            Self::Sphere(Sphere { center, radius, .. }) => {
                Some(Beam::all_around(*center - *radius, *center + *radius, strength))
            }
            Self::Point { position, falloff, .. } => {
                Some(Beam::all_around(*position, *position, strength * fading(*falloff)?))
            }
            Self::Spot(spot) => Some(Beam {
                low: spot.position - spot.radius_m,
                high: spot.position + spot.radius_m,
                axis: spot.axis,
                half_angle: 0.0,
                spread: spot.cos_half_cone.acos(),
                two_sided: false,
                intensity: strength * fading(spot.falloff)?,
            }),
            Self::Directional { .. } | Self::Sky(_) => None,
        }
    }

    /// Irradiance from a light without a [`Emitter::beam`], of this strength, in a scene of this size; mean over the colours.
    pub(super) fn far_irradiance(&self, strength: f32, size_m: f32) -> f32 {
        match self {
            Self::Point { falloff, .. } | Self::Spot(Spot { falloff, .. }) => strength * attenuation(*falloff, size_m),
            _ => strength,
        }
    }

    /// True for what shines from points or in a single direction: no ray can run into it.
    pub(super) fn is_singular(&self) -> bool {
        matches!(self, Self::Point { .. } | Self::Spot(_) | Self::Directional { one_minus_cos: 0.0, .. })
    }

    /// A point that it shines from, if it has no surface.
    pub(super) fn point(&self, u: [f32; 2]) -> Option<Vec3> {
        match self {
            Self::Point { position, .. } => Some(*position),
            Self::Spot(spot) => Some(spot.on_disc(u)),
            _ => None,
        }
    }

    /// What a point sends into a direction: W/sr, times what [`attenuation`] makes of it.
    pub(super) fn intensity(&self, dir: Vec3) -> Option<Source> {
        match self {
            Self::Point { intensity, .. } => Some(*intensity),
            Self::Spot(spot) => Some(spot.intensity.scaled(spot.edge_factor(dir.dot(spot.axis)))),
            _ => None,
        }
    }

    /// What its light is more or less at a distance than if it faded with the square.
    pub(super) fn gain(&self, distance_m: f32) -> f32 {
        match self {
            Self::Point { falloff, .. } | Self::Spot(Spot { falloff, .. }) => {
                attenuation(*falloff, distance_m) * distance_m * distance_m
            }
            _ => 1.0,
        }
    }

    pub(super) fn sample(&self, from: Vec3, u: [f32; 2]) -> Option<LightSample> {
        match self {
            Self::Triangle(triangle) => triangle.sample(from, u),
            Self::Sphere(sphere) => sphere.sample(from, u),
            Self::Point { position, intensity, falloff } => {
                let (wi, distance_m) = toward(from, *position)?;
                let light = LightAt::Radiance(intensity.scaled(attenuation(*falloff, distance_m)));
                Some(LightSample { wi, distance_m, light, pdf: 1.0, alone: true, ng: Vec3::ZERO })
            }
            Self::Spot(spot) => {
                let (wi, distance_m) = toward(from, spot.on_disc(u))?;
                let edge = spot.edge_factor(-wi.dot(spot.axis));
                let strength = edge * attenuation(spot.falloff, distance_m);
                let light = LightAt::Radiance(spot.intensity.scaled(strength));
                (edge > 0.0).then_some(LightSample { wi, distance_m, light, pdf: 1.0, alone: true, ng: Vec3::ZERO })
            }
            Self::Directional { toward, one_minus_cos, irradiance } => {
                if *one_minus_cos == 0.0 {
                    let light = LightAt::Radiance(*irradiance);
                    return Some(LightSample {
                        wi: *toward,
                        distance_m: f32::INFINITY,
                        light,
                        pdf: 1.0,
                        alone: true,
                        ng: Vec3::ZERO,
                    });
                }
                let wi = Frame::new(*toward).to_world(square_to_cone(u, *one_minus_cos));
                let light = LightAt::Radiance(disc_radiance(irradiance, *one_minus_cos));
                Some(LightSample {
                    wi,
                    distance_m: f32::INFINITY,
                    light,
                    pdf: cone_pdf(*one_minus_cos),
                    alone: false,
                    ng: Vec3::ZERO,
                })
            }
            Self::Sky(sky) => {
                let (wi, pdf, radiance) = sky.sample(u)?;
                let light = LightAt::Radiance(radiance);
                Some(LightSample { wi, distance_m: f32::INFINITY, light, pdf, alone: false, ng: Vec3::ZERO })
            }
        }
    }
}

impl Triangle {
    /// `outward` is -1 where the winding is turned around. A triangle without area is kept, and never chosen.
    pub fn new(source: (u32, u32, u32), corners: [Vec3; 3], outward: f32, two_sided: bool, hidden: bool) -> Self {
        let (place, material, prim) = source;
        let [corner, b, c] = corners;
        let edges = [b - corner, c - corner];
        let cross = edges[0].cross(edges[1]) * outward;
        let normal = cross.try_normalize().unwrap_or(Vec3::Y);
        Self { place, material, prim, corner, edges, normal, area_m2: 0.5 * cross.length(), two_sided, hidden }
    }

    fn beam(&self, intensity: f32) -> Beam {
        let corners = [self.corner, self.corner + self.edges[0], self.corner + self.edges[1]];
        let [low, high] =
            [Vec3::min, Vec3::max].map(|of: fn(Vec3, Vec3) -> Vec3| of(of(corners[0], corners[1]), corners[2]));
        let Self { normal: axis, two_sided, .. } = *self;
        Beam { low, high, axis, half_angle: 0.0, spread: 0.5 * PI, two_sided, intensity }
    }

    /// Density in 1/sr of the direction from a point to another, which lies on the triangle.
    pub(super) fn pdf(&self, offset: Vec3) -> f32 {
        let distance2 = offset.length_squared();
        let cos = (offset.dot(self.normal) / distance2.sqrt()).abs();
        distance2 / (cos * self.area_m2)
    }

    fn sample(&self, from: Vec3, u: [f32; 2]) -> Option<LightSample> {
        let barycentric = square_to_triangle(u);
        let point = self.corner + self.edges[0] * barycentric[0] + self.edges[1] * barycentric[1];
        let (wi, distance_m) = toward(from, point)?;
        let cos = -wi.dot(self.normal);
        if cos == 0.0 || (cos < 0.0 && !self.two_sided) {
            return None;
        }
        let pdf = distance_m * distance_m / (cos.abs() * self.area_m2);
        let light = LightAt::Surface { place: self.place, material: self.material, prim: self.prim, barycentric, cos };
        Some(LightSample { wi, distance_m, light, pdf, alone: self.hidden, ng: self.normal })
    }
}

impl Spot {
    /// A point that it shines from.
    pub(super) fn on_disc(&self, u: [f32; 2]) -> Vec3 {
        self.position + Frame::new(self.axis).to_world(square_to_disk(u).extend(0.0) * self.radius_m)
    }

    /// Share of the intensity at an angle from the axis.
    fn edge_factor(&self, cos: f32) -> f32 {
        if cos <= self.cos_half_cone {
            return 0.0;
        }
        match self.edge {
            SpotEdge::Exponent(exponent) => cos.max(0.0).powf(exponent),
            SpotEdge::Blend(blend) => {
                // Blender's: a smooth step in 1/cos-scaled distance from the cone's edge.
                let width = (1.0 - self.cos_half_cone) * blend.max(1e-4);
                let t = ((cos - self.cos_half_cone) / width).clamp(0.0, 1.0);
                t * t * (3.0 - 2.0 * t)
            }
        }
    }
}

/// What to take the intensity times to have irradiance over the square of the distance; `None` where light fades otherwise.
fn fading(falloff: Falloff) -> Option<f32> {
    match falloff {
        Falloff::Physical => Some(1.0),
        Falloff::Attenuation { constant: 0.0, linear: 0.0, quadratic } if quadratic > 0.0 => Some(1.0 / quadratic),
        Falloff::Attenuation { .. } => None,
    }
}

fn attenuation(falloff: Falloff, distance_m: f32) -> f32 {
    match falloff {
        Falloff::Physical => 1.0 / (distance_m * distance_m),
        Falloff::Attenuation { constant, linear, quadratic } => {
            let sum = constant + distance_m * (linear + distance_m * quadratic);
            if sum > 0.0 { 1.0 / sum } else { 0.0 }
        }
    }
}

/// Unit direction and distance; `None` when the points coincide.
fn toward(from: Vec3, to: Vec3) -> Option<(Vec3, f32)> {
    let offset = to - from;
    let distance_m = offset.length();
    (distance_m > 0.0 && distance_m.is_finite()).then(|| (offset / distance_m, distance_m))
}

impl Sphere {
    /// From outside the visible cap is drawn by solid angle, from inside the whole surface by area.
    fn sample(&self, from: Vec3, u: [f32; 2]) -> Option<LightSample> {
        let (Self { place, material, center, radius, hidden }, prim) = (*self, 0);
        let surface = |cos| LightAt::Surface { place, material, prim, barycentric: [0.0; 2], cos };
        let (axis, to_center_m) = toward(from, center).unwrap_or((Vec3::Z, 0.0));
        let Some(one_minus_cos) = visible_cap(to_center_m, radius) else {
            let normal = square_to_sphere(u);
            let (wi, distance_m) = toward(from, center + normal * radius)?;
            let cos = -wi.dot(normal);
            let pdf = distance_m * distance_m / (cos.abs() * 4.0 * PI * radius * radius);
            return (cos != 0.0).then_some(LightSample {
                wi,
                distance_m,
                light: surface(cos),
                pdf,
                alone: hidden,
                ng: normal,
            });
        };
        let local = square_to_cone(u, one_minus_cos);
        let wi = Frame::new(axis).to_world(local);
        // The near intersection; clamped because the cone's edge touches the sphere.
        let miss2 = to_center_m * to_center_m * (1.0 - local.z) * (1.0 + local.z);
        let half_chord = (radius * radius - miss2).max(0.0).sqrt();
        let distance_m = to_center_m * local.z - half_chord;
        let light = surface(half_chord / radius);
        let ng = (from + wi * distance_m - center) * (1.0 / radius);
        Some(LightSample { wi, distance_m, light, pdf: cone_pdf(one_minus_cos), alone: hidden, ng })
    }

    pub(super) fn pdf(&self, from: Vec3, lamp: &LampPoint) -> f32 {
        if let Some(one_minus_cos) = visible_cap(from.distance(self.center), self.radius) {
            return cone_pdf(one_minus_cos);
        }
        let offset = lamp.position - from;
        let distance2 = offset.length_squared();
        let cos = (offset.dot(lamp.ng) / distance2.sqrt()).abs();
        distance2 / (cos * 4.0 * PI * self.radius * self.radius)
    }
}

/// 1 - cos of the half angle of the cone that holds a sphere; `None` from inside (or on) it.
pub(super) fn visible_cap(distance_m: f32, radius: f32) -> Option<f32> {
    let sin2 = (radius / distance_m).powi(2);
    // 1 - sqrt(1 - x) without cancellation.
    (sin2 < 0.999_99).then(|| sin2 / (1.0 + (1.0 - sin2).sqrt()))
}

/// The direction that a light node shines along: local -Z in world space.
pub fn shining_direction(to_world: &Affine3A) -> Vec3 {
    to_world.transform_vector3(-Vec3::Z).try_normalize().unwrap_or(-Vec3::Y)
}
