//! Shapes and lights of a document, being placed in the world.

use std::sync::Arc;

use glam::{Affine3A, Mat3, Mat4, Vec3};

use super::BuildError;
use super::light::{Emitter, Source};
use super::lighting::{self, PlacedLight};
use super::surface::{Body, Glow, NO_MAPS, Part, Place, Shading};
use crate::color::Emission;
use crate::document::{self, Base, Document, Geometry, Item, Map, Mesh, Shape};
use crate::embree::{self, AccelBuilder};

/// Meshes that are placed several times become instances above this many triangles in total; below, copies trace faster
/// than instances do and cost next to nothing.
const COPY_TRIANGLES: usize = 20_000;

/// What is being put together.
pub(super) struct Assembly {
    pub builder: AccelBuilder,
    pub places: Vec<Place>,
    /// The document's materials, a grey one for what has none, and a black one per area light.
    pub materials: Vec<document::Material>,
    /// What each material emits.
    pub glows: Vec<Option<Glow>>,
    pub emitters: Vec<Emitter>,
    /// The distinct spectra of all lights.
    pub spectra: Vec<Emission>,
    /// One weight per emitter; NaN marks distant ones, which are weighed when the scene's size is known.
    pub power: Vec<f32>,
}

impl Assembly {
    /// Registers a material and what it emits.
    pub fn add_material(&mut self, material: document::Material) -> u32 {
        let glow = material.emission.as_ref().map(|emission| Glow {
            radiance: emission.radiance.clone(),
            spectrum: self.spectrum(&emission.spectrum),
            two_sided: emission.two_sided,
        });
        self.glows.push(glow);
        self.materials.push(material);
        self.materials.len() as u32 - 1
    }

    pub fn source(&mut self, rgb: Vec3, emission: &Emission) -> Source {
        Source { rgb, spectrum: self.spectrum(emission) }
    }

    fn spectrum(&mut self, emission: &Emission) -> u32 {
        let known = self.spectra.iter().position(|s| s == emission);
        known.unwrap_or_else(|| {
            self.spectra.push(emission.clone());
            self.spectra.len() - 1
        }) as u32
    }

    pub fn place_geometry(&mut self, document: &Document, placements: &[(usize, Mat4)]) -> Result<(), BuildError> {
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
        let uv_set = first_texcoord(&self.materials[material as usize]).map_or(NO_MAPS, |_| 0);
        let emitter = lighting::add_sphere_emitter(self, place, material, center, radius, false);
        self.places.push(Place {
            shape,
            body: Body::Sphere { center, radius },
            to_world: Affine3A::IDENTITY,
            scale: 1.0,
            normal_to_world: Mat3::IDENTITY,
            handedness: 1.0,
            to_object: to_world.inverse(),
            parts: vec![Part { end: u32::MAX, material, first: 0, emitter, uv_set }],
            height_m: [center.y - radius, center.y + radius],
        });
        Ok(())
    }

    pub fn place_lights(&mut self, document: &Document, placements: &[(usize, Mat4)]) -> Result<(), BuildError> {
        for (node, to_world) in placements {
            for item in &document.nodes[*node].items {
                if let Item::Light(index) = item {
                    let light = &document.lights[*index];
                    let placed = PlacedLight { light, to_world: Affine3A::from_mat4(*to_world) };
                    lighting::place_light(self, &placed)?;
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
        let uv_set = match texcoord {
            Some(_) => bound_set.and_then(|set| mesh.uv_sets.iter().position(|uvs| uvs.set == set)).unwrap_or(0) as u32,
            None => NO_MAPS,
        };
        Part {
            end: group.triangles.end as u32,
            material: material as u32,
            first: group.triangles.start as u32,
            emitter: u32::MAX,
            uv_set,
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
