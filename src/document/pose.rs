//! Setting a document to a moment of its animation.

use std::collections::BTreeSet;

use glam::{Mat4, Vec3};
use thiserror::Error;

use super::animation::{CameraPart, EnvironmentPart, FilmPart, MaterialPart, Quantity};
use super::{Base, Document, Projection, THICKEST_NM, Thickness, TransformKind};
use crate::color::Index;

/// What has changed, so that no more is built anew than must be.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// Transforms of nodes.
    pub nodes: bool,
    pub cameras: bool,
    /// Colours of lights, of surfaces that shine, of the environment.
    pub lights: bool,
    /// Materials whose surfaces are others.
    pub materials: BTreeSet<usize>,
}

/// A curve that leads out of what its target can be.
#[derive(Clone, Debug, Error)]
#[error("animation of `{target}` at {time_s:.4} s: {reason}")]
pub struct PoseError {
    pub target: String,
    pub time_s: f64,
    pub reason: String,
}

impl Document {
    /// Sets everything that channels drive to its value at a time, and adds to `changes` what that has changed. Channels set
    /// values, they do not add to them: the outcome does not depend on earlier poses.
    ///
    /// # Errors
    /// A value out of range, with the channel's target; channels before it have been applied then.
    pub fn pose(&mut self, time_s: f64, changes: &mut Changes) -> Result<(), PoseError> {
        let channels = std::mem::take(&mut self.channels);
        let mut applied = Ok(());
        for channel in &channels {
            let values = channel.at(time_s);
            let set = self.set(channel.drives, channel.member, &values, changes);
            if let Err(reason) = set {
                applied = Err(PoseError { target: channel.target.clone(), time_s, reason });
                break;
            }
        }
        self.channels = channels;
        applied
    }

    fn set(
        &mut self,
        quantity: Quantity,
        member: Option<usize>,
        values: &[f32],
        changes: &mut Changes,
    ) -> Result<(), String> {
        let Some(old) = self.numbers(quantity) else { return Err("the scene has nothing of that kind".to_owned()) };
        let mut new = old.clone();
        match member {
            Some(member) => *new.get_mut(member).ok_or("it has fewer numbers")? = values[0],
            // One number for three colour channels.
            None if values.len() == 1 => new.fill(values[0]),
            None => new.iter_mut().zip(values).for_each(|(number, value)| *number = *value),
        }
        check(quantity, &new)?;
        if new == old {
            return Ok(());
        }
        if let Quantity::Transform { node, transform } = quantity {
            if !self.nodes[node].transforms[transform].kind.with_numbers(&new).matrix().is_finite() {
                return Err("its numbers make no transform".to_owned());
            }
        }
        self.set_numbers(quantity, &new);
        match quantity {
            Quantity::Transform { .. } => changes.nodes = true,
            Quantity::Camera { .. } => changes.cameras = true,
            Quantity::LightColor { .. }
            | Quantity::Environment(_)
            | Quantity::Material { part: MaterialPart::Emission, .. } => changes.lights = true,
            Quantity::Material { material, .. } | Quantity::Film { material, .. } => {
                changes.materials.insert(material);
            }
        }
        Ok(())
    }

    /// The numbers of a quantity as the file has them; `None` where the document has no such thing.
    pub fn numbers(&self, quantity: Quantity) -> Option<Vec<f32>> {
        let colour = |colour: Vec3| Some(colour.to_array().to_vec());
        let number = |number: f32| Some(vec![number]);
        match quantity {
            Quantity::Transform { node, transform } => {
                Some(self.nodes.get(node)?.transforms.get(transform)?.kind.numbers())
            }
            Quantity::Camera { camera, part } => {
                let camera = self.cameras.get(camera)?;
                match (part, &camera.projection) {
                    (CameraPart::XFov, Projection::Perspective { xfov_deg, .. }) => number((*xfov_deg)?),
                    (CameraPart::YFov, Projection::Perspective { yfov_deg, .. }) => number((*yfov_deg)?),
                    (CameraPart::XMag, Projection::Orthographic { xmag, .. }) => number((*xmag)?),
                    (CameraPart::YMag, Projection::Orthographic { ymag, .. }) => number((*ymag)?),
                    (CameraPart::ApertureRadius, _) => number(camera.lens?.aperture_radius_m),
                    (CameraPart::FNumber { focal_mm }, _) => number(focal_mm / 2000.0 / camera.lens?.aperture_radius_m),
                    (CameraPart::FocusDistance, _) => number(camera.lens?.focus_distance_m),
                    _ => None,
                }
            }
            Quantity::LightColor { light, scale } => colour(self.lights.get(light)?.color / scale),
            Quantity::Material { material, part } => {
                let material = self.materials.get(material)?;
                match (part, &material.base) {
                    (MaterialPart::Reflectance, Base::Diffuse { reflectance, .. }) => colour(reflectance.value),
                    (
                        MaterialPart::Roughness,
                        Base::Conductor { microfacets, .. } | Base::Dielectric { microfacets, .. },
                    ) => number(microfacets.roughness.value),
                    (MaterialPart::Absorption, Base::Dielectric { absorption_per_m, .. }) => colour(*absorption_per_m),
                    (MaterialPart::Emission, _) => colour(material.emission.as_ref()?.radiance.value),
                    _ => None,
                }
            }
            Quantity::Film { material, film, part } => {
                let film = self.materials.get(material)?.films.get(film)?;
                match (part, &film.thickness) {
                    (FilmPart::Thickness, Thickness::Constant { nm } | Thickness::Noise { nm, .. }) => number(*nm),
                    (FilmPart::Amplitude, Thickness::Noise { amplitude, .. }) => number(*amplitude),
                    (FilmPart::Top, Thickness::Drain { top_nm, .. }) => number(*top_nm),
                    (FilmPart::Bottom, Thickness::Drain { bottom_nm, .. }) => number(*bottom_nm),
                    (FilmPart::Min, Thickness::Map { min_nm, .. }) => number(*min_nm),
                    (FilmPart::Max, Thickness::Map { max_nm, .. }) => number(*max_nm),
                    (FilmPart::Weight, _) => number(film.weight),
                    (FilmPart::Ior, _) => match film.index {
                        Index::Constant { n, .. } => number(n),
                        _ => None,
                    },
                    _ => None,
                }
            }
            Quantity::Environment(part) => {
                let environment = self.environment.as_ref()?;
                match part {
                    EnvironmentPart::Radiance => colour(environment.radiance),
                    EnvironmentPart::Strength => number(environment.strength),
                    EnvironmentPart::Rotation => number(environment.rotation_deg),
                }
            }
        }
    }

    /// Writes back what [`numbers`](Self::numbers) has read.
    fn set_numbers(&mut self, quantity: Quantity, new: &[f32]) {
        let colour = || Vec3::from_slice(new);
        match quantity {
            Quantity::Transform { node, transform } => {
                let kind = &mut self.nodes[node].transforms[transform].kind;
                *kind = kind.with_numbers(new);
            }
            Quantity::Camera { camera, part } => {
                let camera = &mut self.cameras[camera];
                match (part, &mut camera.projection, &mut camera.lens) {
                    (CameraPart::XFov, Projection::Perspective { xfov_deg, .. }, _) => *xfov_deg = Some(new[0]),
                    (CameraPart::YFov, Projection::Perspective { yfov_deg, .. }, _) => *yfov_deg = Some(new[0]),
                    (CameraPart::XMag, Projection::Orthographic { xmag, .. }, _) => *xmag = Some(new[0]),
                    (CameraPart::YMag, Projection::Orthographic { ymag, .. }, _) => *ymag = Some(new[0]),
                    (CameraPart::ApertureRadius, _, Some(lens)) => lens.aperture_radius_m = new[0],
                    (CameraPart::FNumber { focal_mm }, _, Some(lens)) => {
                        lens.aperture_radius_m = focal_mm / 2000.0 / new[0];
                    }
                    (CameraPart::FocusDistance, _, Some(lens)) => lens.focus_distance_m = new[0],
                    _ => {}
                }
            }
            Quantity::LightColor { light, scale } => self.lights[light].color = colour() * scale,
            Quantity::Material { material, part } => {
                let material = &mut self.materials[material];
                match (part, &mut material.base, &mut material.emission) {
                    (MaterialPart::Reflectance, Base::Diffuse { reflectance, .. }, _) => reflectance.value = colour(),
                    (
                        MaterialPart::Roughness,
                        Base::Conductor { microfacets, .. } | Base::Dielectric { microfacets, .. },
                        _,
                    ) => microfacets.roughness.value = new[0],
                    (MaterialPart::Absorption, Base::Dielectric { absorption_per_m, .. }, _) => {
                        *absorption_per_m = colour();
                    }
                    (MaterialPart::Emission, _, Some(emission)) => emission.radiance.value = colour(),
                    _ => {}
                }
            }
            Quantity::Film { material, film, part } => {
                let film = &mut self.materials[material].films[film];
                match (part, &mut film.thickness, &mut film.index) {
                    (FilmPart::Thickness, Thickness::Constant { nm } | Thickness::Noise { nm, .. }, _) => *nm = new[0],
                    (FilmPart::Amplitude, Thickness::Noise { amplitude, .. }, _) => *amplitude = new[0],
                    (FilmPart::Top, Thickness::Drain { top_nm, .. }, _) => *top_nm = new[0],
                    (FilmPart::Bottom, Thickness::Drain { bottom_nm, .. }, _) => *bottom_nm = new[0],
                    (FilmPart::Min, Thickness::Map { min_nm, .. }, _) => *min_nm = new[0],
                    (FilmPart::Max, Thickness::Map { max_nm, .. }, _) => *max_nm = new[0],
                    (FilmPart::Weight, _, _) => film.weight = new[0],
                    (FilmPart::Ior, _, Index::Constant { n, .. }) => *n = new[0],
                    _ => {}
                }
            }
            Quantity::Environment(part) => {
                let Some(environment) = &mut self.environment else { return };
                match part {
                    EnvironmentPart::Radiance => environment.radiance = colour(),
                    EnvironmentPart::Strength => environment.strength = new[0],
                    EnvironmentPart::Rotation => environment.rotation_deg = new[0],
                }
            }
        }
    }
}

/// The ranges that the loader keeps as well: a curve between two valid keys may still swing out of them.
fn check(quantity: Quantity, numbers: &[f32]) -> Result<(), String> {
    let (low, high) = match quantity {
        Quantity::Transform { .. } | Quantity::Environment(EnvironmentPart::Rotation) => {
            (f32::NEG_INFINITY, f32::INFINITY)
        }
        Quantity::Camera { part: CameraPart::XFov | CameraPart::YFov, .. } => (f32::MIN_POSITIVE, 179.999),
        Quantity::Camera { part: CameraPart::ApertureRadius, .. } => (0.0, f32::INFINITY),
        Quantity::Camera { .. } => (f32::MIN_POSITIVE, f32::INFINITY),
        Quantity::LightColor { .. } | Quantity::Environment(_) => (0.0, f32::INFINITY),
        Quantity::Material { part: MaterialPart::Emission | MaterialPart::Absorption, .. } => (0.0, f32::INFINITY),
        Quantity::Material { .. } => (0.0, 1.0),
        Quantity::Film { part: FilmPart::Weight | FilmPart::Amplitude, .. } => (0.0, 1.0),
        Quantity::Film { part: FilmPart::Ior, .. } => (0.01, 10.0),
        Quantity::Film { .. } => (0.0, THICKEST_NM),
    };
    match numbers.iter().find(|number| !(**number >= low && **number <= high)) {
        None => Ok(()),
        Some(number) => Err(format!("{number} must lie in {low}..{high}")),
    }
}

impl TransformKind {
    /// The numbers of the element, in the file's order.
    fn numbers(&self) -> Vec<f32> {
        let triples = |vectors: &[Vec3]| vectors.iter().flat_map(|vector| vector.to_array()).collect();
        match *self {
            Self::Matrix(matrix) => matrix.transpose().to_cols_array().to_vec(),
            Self::Translate(vector) | Self::Scale(vector) => triples(&[vector]),
            Self::Rotate { axis, angle_deg } => vec![axis.x, axis.y, axis.z, angle_deg],
            Self::LookAt { eye, target, up } => triples(&[eye, target, up]),
            Self::Skew { angle_deg, rotation, translation } => {
                let [a, b, c] = rotation.to_array();
                let [d, e, f] = translation.to_array();
                vec![angle_deg, a, b, c, d, e, f]
            }
        }
    }

    /// The same kind of element with other numbers, as many as [`numbers`](Self::numbers) gives.
    fn with_numbers(self, new: &[f32]) -> Self {
        let vector = |start: usize| Vec3::from_slice(&new[start..]);
        match self {
            // `new` comes from a Vec of 16, changed in place.
            Self::Matrix(_) => Self::Matrix(Mat4::from_cols_slice(new).transpose()),
            Self::Translate(_) => Self::Translate(vector(0)),
            Self::Scale(_) => Self::Scale(vector(0)),
            Self::Rotate { .. } => Self::Rotate { axis: vector(0), angle_deg: new[3] },
            Self::LookAt { .. } => Self::LookAt { eye: vector(0), target: vector(3), up: vector(6) },
            Self::Skew { .. } => Self::Skew { angle_deg: new[0], rotation: vector(1), translation: vector(4) },
        }
    }
}
