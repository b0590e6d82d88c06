//! From a [`Document`] to a [`Scene`].

use std::sync::Arc;
use std::time::Instant;

use glam::{Affine3A, Mat3, Mat4, Vec3};

use super::environment::{Sky, SkyImage};
use super::light::{Emitter, Lights};
use super::lighting::{self, PlacedLight};
use super::material::{Material, source};
use super::surface::{Body, Part, Place, Shading};
use super::texture::Texture;
use super::{BuildError, Scene};
use crate::color::Sensor;
use crate::document;
use crate::document::{Base, Document, Geometry, Item, Map, Mesh, Scalar, Shape};
use crate::embree::{self, AccelBuilder};
use crate::film::Rung;
use crate::mode::Mode;

/// Meshes that are placed several times become instances above this many triangles in total; below, copies trace faster
/// than instances do and cost next to nothing.
const COPY_TRIANGLES: usize = 20_000;

#[derive(Clone, Debug)]
pub struct BuildOptions {
    /// Largest CIEDE2000 that a cheaper film model may cost.
    pub tolerance: f32,
    /// Force one film model.
    pub rung: Option<Rung>,
    /// Threads for building; 0 = all.
    pub threads: usize,
}

/// Seconds that the parts of building took.
#[derive(Clone, Copy, Debug, Default)]
pub struct BuildTimes {
    pub textures_s: f64,
    pub materials_s: f64,
    pub bvh_s: f64,
}

/// Builds everything that rendering needs.
///
/// # Errors
/// An image that cannot be decoded, an unknown refractive index, or Embree running out of memory.
pub fn build<M: Mode>(document: &Document, options: &BuildOptions) -> Result<Scene<M>, BuildError> {
    let start = Instant::now();
    let textures = document.images.iter().map(Texture::load).collect::<Result<Vec<_>, _>>()?;
    let textures_s = start.elapsed().as_secs_f64();

    let start = Instant::now();
    let placements = document.placements();
    let sensor = Sensor::new(&lighting::white(document, &placements));
    let mut materials = Vec::with_capacity(document.materials.len() + 1);
    let mut verdicts = Vec::new();
    let fallback = document::Material { opacity: Scalar::constant(1.0), ..document::Material::default() };
    for material in document.materials.iter().chain([&fallback]) {
        let compiled = Material::<M>::new(material, &sensor, options)?;
        verdicts.extend(compiled.verdict.clone().map(|verdict| (material.id.clone(), verdict)));
        materials.push(compiled);
    }
    let materials_s = start.elapsed().as_secs_f64();

    let start = Instant::now();
    let mut assembly = Assembly {
        builder: AccelBuilder::new(options.threads)?,
        places: Vec::new(),
        materials,
        emitters: Vec::new(),
        power: Vec::new(),
    };
    assembly.place_geometry(document, &placements)?;
    assembly.place_lights(document, &placements, &sensor, options)?;
    let Assembly { builder, places, materials, mut emitters, mut power } = assembly;
    let accel = builder.build()?;
    let bounds = accel.bounds().unwrap_or((Vec3::splat(-0.5), Vec3::splat(0.5)));
    let bvh_s = start.elapsed().as_secs_f64();

    if let Some(environment) = &document.environment {
        let tint = source::<M>(environment.radiance * environment.strength, &environment.spectrum, &sensor);
        let sky = match environment.image {
            Some(image) => {
                let texture = Texture::load(&document.images[image])?;
                Sky::Image(Box::new(SkyImage::new(texture, tint, environment.rotation_deg)))
            }
            None => Sky::Constant(tint),
        };
        power.push(f32::NAN);
        emitters.push(Emitter::Sky(sky));
    }
    lighting::weigh_distant(&emitters, &mut power, bounds);

    Ok(Scene {
        lets_through: materials.iter().any(Material::lets_through),
        lights: Lights::new(emitters, &power),
        accel,
        places,
        materials,
        textures,
        sensor,
        bounds,
        times: BuildTimes { textures_s, materials_s, bvh_s },
        verdicts,
    })
}

/// What is being put together.
pub(super) struct Assembly<M: Mode> {
    pub builder: AccelBuilder,
    pub places: Vec<Place>,
    pub materials: Vec<Material<M>>,
    pub emitters: Vec<Emitter<M>>,
    /// One weight per emitter; NaN marks distant ones, which are weighed when the scene's size is known.
    pub power: Vec<f32>,
}

impl<M: Mode> Assembly<M> {
    fn place_geometry(&mut self, document: &Document, placements: &[(usize, Mat4)]) -> Result<(), BuildError> {
        let mut uses = vec![0usize; document.geometries.len()];
        let items = || placements.iter().flat_map(|(node, m)| document.nodes[*node].items.iter().map(move |i| (i, m)));
        for (item, _) in items() {
            if let Item::Geometry { geometry, .. } = item {
                uses[*geometry] += 1;
            }
        }
        let mut shared: Vec<Option<(embree::Shape, Arc<Shading>)>> = vec![None; document.geometries.len()];
        for (item, to_world) in items() {
            let Item::Geometry { geometry: index, bindings } = item else { continue };
            let geometry = &document.geometries[*index];
            let object_to_world = Affine3A::from_mat4(*to_world);
            match &geometry.shape {
                Shape::Sphere { radius } => {
                    let radius = radius * to_world.x_axis.truncate().length();
                    let material = bindings.first().map_or(document.materials.len(), |b| b.material);
                    self.place_sphere(object_to_world, radius, material as u32)?;
                }
                Shape::Mesh(mesh) if mesh.triangles.is_empty() => {}
                Shape::Mesh(mesh) => {
                    let parts = parts(document, geometry, mesh, bindings);
                    let copies = uses[*index];
                    if copies == 1 || copies * mesh.triangles.len() <= COPY_TRIANGLES {
                        self.place_copy(mesh, object_to_world, parts)?;
                        continue;
                    }
                    let (shape, shading) = match &shared[*index] {
                        Some(entry) => entry.clone(),
                        None => {
                            let shape = self.builder.mesh(mesh.positions.clone(), mesh.triangles.clone())?;
                            let shading = Shading { normals: mesh.normals.clone(), uv_sets: uv_sets(mesh) };
                            shared[*index].insert((shape, Arc::new(shading))).clone()
                        }
                    };
                    self.builder.place_instance(shape, object_to_world)?;
                    self.add_mesh_place(mesh, shape, shading, object_to_world, object_to_world, parts);
                }
            }
        }
        Ok(())
    }

    /// A mesh in world coordinates: the fastest to trace.
    pub(super) fn place_copy(&mut self, mesh: &Mesh, to_world: Affine3A, parts: Vec<Part>) -> Result<(), BuildError> {
        let positions = mesh.positions.iter().map(|p| to_world.transform_point3(*p)).collect();
        let normal_to_world = normal_matrix(&to_world);
        let normals = mesh.normals.iter().map(|n| (normal_to_world * *n).normalize_or_zero()).collect();
        let shape = self.builder.mesh(positions, mesh.triangles.clone())?;
        self.builder.place(shape)?;
        let shading = Arc::new(Shading { normals, uv_sets: uv_sets(mesh) });
        self.add_mesh_place(mesh, shape, shading, Affine3A::IDENTITY, to_world, parts);
        Ok(())
    }

    /// `to_world` maps what Embree holds, `object_to_world` what the file holds.
    fn add_mesh_place(
        &mut self,
        mesh: &Mesh,
        shape: embree::Shape,
        shading: Arc<Shading>,
        to_world: Affine3A,
        object_to_world: Affine3A,
        mut parts: Vec<Part>,
    ) {
        let heights = mesh.positions.iter().map(|p| object_to_world.transform_point3(*p).y);
        let height_m = heights.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], y| [low.min(y), high.max(y)]);
        let place = self.places.len() as u32;
        let handedness = 1.0f32.copysign(object_to_world.matrix3.determinant());
        lighting::add_mesh_emitters(self, mesh, &mut parts, place, &object_to_world, handedness, false);
        self.places.push(Place {
            shape,
            body: Body::Mesh(shading),
            scale: stretch(&to_world),
            normal_to_world: normal_matrix(&to_world),
            to_world,
            handedness,
            to_object: object_to_world.inverse(),
            parts,
            height_m,
        });
    }

    pub(super) fn place_sphere(&mut self, to_world: Affine3A, radius: f32, material: u32) -> Result<(), BuildError> {
        let center = Vec3::from(to_world.translation);
        let shape = self.builder.sphere(center, radius)?;
        let place = self.builder.place(shape)?;
        let emitter = lighting::add_sphere_emitter(self, place, material, center, radius, false);
        self.places.push(Place {
            shape,
            body: Body::Sphere { center, radius },
            to_world: Affine3A::IDENTITY,
            scale: 1.0,
            normal_to_world: Mat3::IDENTITY,
            handedness: 1.0,
            to_object: to_world.inverse(),
            parts: vec![Part { end: u32::MAX, material, first: 0, emitter, uv_set: 0 }],
            height_m: [center.y - radius, center.y + radius],
        });
        Ok(())
    }

    fn place_lights(
        &mut self,
        document: &Document,
        placements: &[(usize, Mat4)],
        sensor: &Sensor,
        options: &BuildOptions,
    ) -> Result<(), BuildError> {
        for (node, to_world) in placements {
            for item in &document.nodes[*node].items {
                if let Item::Light(index) = item {
                    let light = &document.lights[*index];
                    let placed = PlacedLight { light, to_world: Affine3A::from_mat4(*to_world) };
                    lighting::place_light(self, &placed, sensor, options)?;
                }
            }
        }
        Ok(())
    }
}

/// The mesh's groups with the materials that this instance binds to them.
fn parts(document: &Document, geometry: &Geometry, mesh: &Mesh, bindings: &[document::Binding]) -> Vec<Part> {
    let fallback = document.materials.len();
    let part = |group: &document::Group| {
        let binding = bindings.iter().find(|b| b.symbol == group.symbol);
        let material = binding.map_or(fallback, |b| b.material);
        let texcoord = document.materials.get(material).and_then(first_texcoord);
        let bound_set = binding
            .zip(texcoord)
            .and_then(|(b, name)| b.uv_sets.iter().find(|(semantic, _)| semantic == name).map(|(_, set)| *set));
        let uv_set = bound_set.and_then(|set| mesh.uv_sets.iter().position(|uvs| uvs.set == set)).unwrap_or(0);
        Part {
            end: group.triangles.end as u32,
            material: material as u32,
            first: group.triangles.start as u32,
            emitter: u32::MAX,
            uv_set: uv_set as u32,
        }
    };
    debug_assert!(!mesh.groups.is_empty(), "mesh `{}` has no groups", geometry.id);
    mesh.groups.iter().map(part).collect()
}

/// The texture coordinates that a material's maps ask for (one set serves all maps of a material).
fn first_texcoord(material: &document::Material) -> Option<&str> {
    let base_map: Option<&Map> = match &material.base {
        Base::Diffuse { reflectance, .. } => reflectance.map.as_ref(),
        Base::Conductor { microfacets, .. } | Base::Dielectric { microfacets, .. } => {
            microfacets.roughness.map.as_ref()
        }
        Base::Black => None,
    };
    let film_map = || {
        material.films.iter().find_map(|film| match &film.thickness {
            document::Thickness::Map { map, .. } => Some(map),
            _ => None,
        })
    };
    let emission_map = || material.emission.as_ref().and_then(|e| e.radiance.map.as_ref());
    let normal_map = || material.normal_map.as_ref().map(|n| &n.map);
    let map = base_map.or_else(film_map).or_else(emission_map).or_else(normal_map).or(material.opacity.map.as_ref());
    map.map(|m| m.texcoord.as_str())
}

fn uv_sets(mesh: &Mesh) -> Vec<Vec<glam::Vec2>> {
    mesh.uv_sets.iter().map(|set| set.uvs.clone()).collect()
}

/// The inverse transpose, which maps normals.
pub(super) fn normal_matrix(to_world: &Affine3A) -> Mat3 {
    let inverse = Mat3::from(to_world.matrix3).inverse();
    if inverse.is_finite() { inverse.transpose() } else { Mat3::IDENTITY }
}

fn stretch(to_world: &Affine3A) -> f32 {
    let m = to_world.matrix3;
    m.x_axis.length().max(m.y_axis.length()).max(m.z_axis.length())
}
