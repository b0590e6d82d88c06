//! Light sources of a document, turned into emitters.

use std::f32::consts::PI;

use glam::{Affine3A, Vec3};

use super::BuildError;
use super::assembly::Assembly;
use super::environment::Sky;
use super::light::{self, Emitter, Sphere, Spot, Triangle};
use super::surface::{NO_MAPS, Part, UV_SLOTS};
use crate::color::Emission;
use crate::document::{
    self, AreaShape, Base, Document, Falloff, Item, Light, LightKind, Mesh, Presence, SurfaceEmission,
};

/// Sides of the polygon that stands for a disc; it has the disc's area.
const DISK_SIDES: u32 = 96;

/// A light with the place of its node.
pub struct PlacedLight<'a> {
    pub light: &'a Light,
    pub to_world: Affine3A,
}

/// The white of the picture: the spectrum that all lights share; D65 where they differ.
pub fn white(document: &Document, placements: &[(usize, glam::Mat4)]) -> Emission {
    let lights = placements.iter().flat_map(|(node, _)| &document.nodes[*node].items).filter_map(|item| match item {
        Item::Light(index) => Some(&document.lights[*index].spectrum),
        _ => None,
    });
    let surfaces = document.materials.iter().filter_map(|m| m.emission.as_ref()).map(|e| &e.spectrum);
    let sky = document.environment.as_ref().map(|e| &e.spectrum);
    let mut spectra = lights.chain(surfaces).chain(sky);
    let Some(first) = spectra.next() else { return Emission::E };
    if spectra.all(|spectrum| spectrum == first) { first.clone() } else { Emission::D65 }
}

/// Gives the emitting parts of a mesh their emitters, one per triangle.
pub(super) fn add_mesh_emitters(
    assembly: &mut Assembly,
    mesh: &Mesh,
    parts: &mut [Part],
    place: u32,
    to_world: &Affine3A,
    handedness: f32,
    hidden: bool,
) {
    for part in parts {
        let Some(glow) = assembly.glows[part.material as usize].as_ref() else { continue };
        let (strength, two_sided) = (glow.strength(), glow.two_sided);
        part.emitter = assembly.emitters.len() as u32;
        for prim in part.first..part.end {
            let corners = mesh.triangles[prim as usize].map(|i| to_world.transform_point3(mesh.positions[i as usize]));
            let triangle = Triangle::new((place, part.material, prim), corners, handedness, two_sided, hidden);
            assembly.strength.push(triangle.area_m2 * strength);
            assembly.emitters.push(Emitter::Triangle(triangle));
        }
    }
}

/// The emitter number of a sphere, `u32::MAX` when its material does not shine.
pub(super) fn add_sphere_emitter(
    assembly: &mut Assembly,
    place: u32,
    material: u32,
    center: Vec3,
    radius: f32,
    hidden: bool,
) -> u32 {
    let Some(glow) = assembly.glows[material as usize].as_ref() else { return u32::MAX };
    let strength = glow.strength();
    let emitter = assembly.emitters.len() as u32;
    assembly.strength.push(PI * radius * radius * strength);
    assembly.emitters.push(Emitter::Sphere(Sphere { place, material, center, radius, hidden }));
    emitter
}

pub(super) fn place_light(assembly: &mut Assembly, placed: &PlacedLight) -> Result<(), BuildError> {
    let PlacedLight { light, to_world } = placed;
    let position = Vec3::from(to_world.translation);
    let intensity = assembly.source(light.color, &light.spectrum);
    let strength = light.color.element_sum() / 3.0;
    let mut add = |emitter, strength| {
        assembly.emitters.push(emitter);
        assembly.strength.push(strength);
    };
    match light.kind {
        LightKind::Area { shape, presence } => place_area(assembly, placed, shape, presence, light.color)?,
        LightKind::Point { radius_m, falloff: Falloff::Physical } if radius_m > 0.0 => {
            // A sphere of radiance L has intensity L pi r^2.
            let radiance = light.color / (PI * radius_m * radius_m);
            let unit = Affine3A::from_translation(position) * Affine3A::from_scale(Vec3::splat(2.0 * radius_m));
            let placed = PlacedLight { light, to_world: unit };
            place_area(assembly, &placed, AreaShape::Sphere, Presence::Ghost, radiance)?;
        }
        LightKind::Point { falloff, .. } => {
            add(Emitter::Point { position, intensity, falloff }, strength);
        }
        LightKind::Spot { cone_deg, edge, radius_m, falloff } => {
            let cos_half_cone = (0.5 * cone_deg.to_radians()).cos();
            let axis = light::shining_direction(to_world);
            let spot = Spot { position, radius_m, axis, cos_half_cone, edge, intensity, falloff };
            add(Emitter::Spot(spot), strength);
        }
        LightKind::Directional { angle_deg } => {
            let half_angle = 0.5 * angle_deg.to_radians();
            let one_minus_cos = 2.0 * (0.5 * half_angle).sin().powi(2);
            let toward = -light::shining_direction(to_world);
            add(Emitter::Directional { toward, one_minus_cos, irradiance: intensity }, strength);
        }
        LightKind::Ambient => {
            let sky = Sky::Hemisphere(intensity);
            let strength = sky.irradiance();
            add(Emitter::Sky(sky), strength);
        }
    }
    Ok(())
}

/// A rectangle, disc or sphere that radiates, with a black material of its own.
fn place_area(
    assembly: &mut Assembly,
    placed: &PlacedLight,
    shape: AreaShape,
    presence: Presence,
    radiance: Vec3,
) -> Result<(), BuildError> {
    let emission = SurfaceEmission {
        radiance: document::Texture::constant(radiance),
        spectrum: placed.light.spectrum.clone(),
        two_sided: false,
    };
    let description = document::Material {
        id: placed.light.id.clone(),
        base: Base::Black,
        emission: Some(emission),
        opacity: document::Scalar::constant(if presence == Presence::Ghost { 0.0 } else { 1.0 }),
        ..document::Material::default()
    };
    let material = assembly.add_material(description);
    if let Some(glow) = &mut assembly.glows[material as usize] {
        // A ghost stands in nothing's way, but all of it shines.
        glow.opacity = document::Scalar::constant(1.0);
    }
    let to_world = placed.to_world;
    if shape == AreaShape::Sphere {
        let radius = 0.5 * to_world.matrix3.x_axis.length();
        if presence != Presence::Hidden {
            return assembly.place_sphere(to_world, radius, material);
        }
        add_sphere_emitter(assembly, u32::MAX, material, Vec3::from(to_world.translation), radius, true);
        return Ok(());
    }
    let mesh = if shape == AreaShape::Disk { disk() } else { rectangle() };
    let count = mesh.triangles.len() as u32;
    let mut parts = vec![Part { end: count, material, first: 0, emitter: u32::MAX, uv_sets: [NO_MAPS; UV_SLOTS] }];
    if presence != Presence::Hidden {
        return assembly.place_mesh(&mesh, to_world, parts);
    }
    let handedness = 1.0f32.copysign(to_world.matrix3.determinant());
    add_mesh_emitters(assembly, &mesh, &mut parts, u32::MAX, &to_world, handedness, true);
    Ok(())
}

/// The unit square in XY, facing -Z.
fn rectangle() -> Mesh {
    let positions = [(-0.5, -0.5), (-0.5, 0.5), (0.5, 0.5), (0.5, -0.5)].map(|(x, y)| Vec3::new(x, y, 0.0));
    Mesh { positions: positions.to_vec(), triangles: vec![[0, 1, 2], [0, 2, 3]], ..Mesh::default() }
}

/// The disc of unit diameter in XY, facing -Z, as a polygon of the same area.
fn disk() -> Mesh {
    let step = 2.0 * PI / DISK_SIDES as f32;
    let radius = 0.5 * (step / step.sin()).sqrt();
    let mut positions = vec![Vec3::ZERO];
    positions.extend((0..DISK_SIDES).map(|k| {
        let (sin, cos) = (step * k as f32).sin_cos();
        Vec3::new(radius * cos, radius * sin, 0.0)
    }));
    let triangles = (0..DISK_SIDES).map(|k| [0, 1 + (k + 1) % DISK_SIDES, 1 + k]).collect();
    Mesh { positions, triangles, ..Mesh::default() }
}
