//! Shapes and lights of a document, being placed in the world.

use std::sync::Arc;
use std::vec;

use glam::{Affine3A, Mat3, Mat4, Vec3};

use super::BuildError;
use super::environment::{Sky, SkyImage};
use super::groups::LightGroups;
use super::light::{Emitter, Source};
use super::lighting::{self, PlacedLight};
use super::surface::{Body, Glow, NO_MAPS, Part, Place, Shading, UV_SLOTS, normal_matrix};
use super::texture::Texture;
use crate::color::Emission;
use crate::document::{self, Document, Geometry, Item, Mesh, Shape};
use crate::embree::{self, AccelBuilder};

/// A mesh that Embree holds, with what shading needs of it.
type Held = (embree::Shape, Arc<Shading>);

/// Meshes that are placed several times become instances above this many triangles in total; below, copies trace faster
/// than instances do and cost next to nothing.
const COPY_TRIANGLES: usize = 20_000;

/// What the shapes go into.
pub(super) enum Ground<'a> {
    /// A BVH that is being put together.
    New(&'a mut AccelBuilder),
    Built(&'a mut Built),
}

/// The BVH that is there.
pub(super) struct Built {
    /// Its places, in the order in which they were made.
    pub places: vec::IntoIter<Place>,
    /// The instances that have to move.
    pub moves: Vec<(u32, Affine3A)>,
    /// After a move that failed it is unknown where they stand, and all have to.
    pub stale: bool,
}

/// What is being put together, or gone through again for another pose. Both take the same way through the document, so
/// places, materials and emitters keep their numbers.
pub(super) struct Assembly<'a> {
    pub ground: Ground<'a>,
    pub groups: &'a LightGroups,
    /// The group of what is added right now.
    pub group: usize,
    /// For each placement, whether it may move later; shorter or empty: the others do not.
    pub moving: &'a [bool],
    /// Whether what is placed right now is one of those: it becomes an instance then.
    pub mobile: bool,
    /// The document's node that is placed right now.
    pub node: u32,
    pub places: Vec<Place>,
    /// The document's materials, a grey one for what has none, and a black one per area light.
    pub materials: Vec<document::Material>,
    /// What each material emits.
    pub glows: Vec<Option<Glow>>,
    pub emitters: Vec<Emitter>,
    /// The distinct spectra of all lights.
    pub spectra: Vec<(Emission, usize)>,
    /// Of each emitter, as [`Lights::new`](super::Lights::new) takes it.
    pub strength: Vec<f32>,
}

impl<'a> Assembly<'a> {
    pub fn new(ground: Ground<'a>, moving: &'a [bool], groups: &'a LightGroups) -> Self {
        Self {
            ground,
            groups,
            group: 0,
            moving,
            mobile: false,
            node: 0,
            places: Vec::new(),
            materials: Vec::new(),
            glows: Vec::new(),
            emitters: Vec::new(),
            spectra: Vec::new(),
            strength: Vec::new(),
        }
    }

    /// Everything of a document in this order: materials, shapes, lights, the environment. `again`, in another pose: the
    /// image of the environment that is there, and how it is turned.
    pub fn gather(
        &mut self,
        document: &Document,
        placements: &[(usize, Mat4)],
        textures: &[Arc<Texture>],
        again: Option<(Option<Box<SkyImage>>, Mat3)>,
    ) -> Result<(), BuildError> {
        let fallback = document::Material { opacity: document::Scalar::constant(1.0), ..document::Material::default() };
        for (number, material) in document.materials.iter().chain([&fallback]).enumerate() {
            self.group = self.groups.of_material(number);
            self.add_material(material.clone());
        }
        self.place_geometry(document, placements)?;
        self.place_lights(document, placements)?;
        let Some(environment) = &document.environment else { return Ok(()) };
        self.group = self.groups.of_environment();
        let tint = self.source(environment.radiance * environment.strength, &environment.spectrum);
        let (image, turn) = again.unwrap_or((None, Mat3::IDENTITY));
        let sky = match environment.image {
            Some(index) => {
                let mut image = image.unwrap_or_else(|| Box::new(SkyImage::new(&textures[index])));
                image.set(tint, environment.rotation_deg, turn);
                Sky::Image(image)
            }
            None => Sky::Constant(tint),
        };
        self.strength.push(sky.irradiance());
        self.emitters.push(Emitter::Sky(sky));
        Ok(())
    }

    /// Registers a material and what it emits.
    pub fn add_material(&mut self, material: document::Material) -> u32 {
        let glow = material.emission.as_ref().map(|emission| Glow {
            radiance: emission.radiance.clone(),
            spectrum: self.spectrum(&emission.spectrum),
            two_sided: emission.two_sided,
            opacity: material.opacity.clone(),
        });
        self.glows.push(glow);
        self.materials.push(material);
        self.materials.len() as u32 - 1
    }

    pub fn source(&mut self, rgb: Vec3, emission: &Emission) -> Source {
        Source { rgb, spectrum: self.spectrum(emission) }
    }

    fn spectrum(&mut self, emission: &Emission) -> u32 {
        let known = self.spectra.iter().position(|(known, group)| known == emission && *group == self.group);
        known.unwrap_or_else(|| {
            self.spectra.push((emission.clone(), self.group));
            self.spectra.len() - 1
        }) as u32
    }

    pub fn place_geometry(&mut self, document: &Document, placements: &[(usize, Mat4)]) -> Result<(), BuildError> {
        let mut uses = vec![0usize; document.geometries.len()];
        for (node, _) in placements {
            for item in &document.nodes[*node].items {
                if let Item::Geometry { geometry, .. } = item {
                    uses[*geometry] += 1;
                }
            }
        }
        let mut shared: Vec<Option<Held>> = vec![None; document.geometries.len()];
        for (number, (node, to_world)) in placements.iter().enumerate() {
            self.mobile = self.moving.get(number).copied().unwrap_or(false);
            self.node = *node as u32;
            for item in &document.nodes[*node].items {
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
                        let total = copies * mesh.triangles.len();
                        // Where anything moves, what is large gets a BVH of its own, so that it is not built anew each time.
                        let large = total > COPY_TRIANGLES && (copies > 1 || !self.moving.is_empty());
                        if large || self.mobile {
                            self.place_instance(mesh, object_to_world, parts, &mut shared[*index])?;
                        } else {
                            self.place_copy(mesh, object_to_world, parts)?;
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// A mesh that belongs to no geometry of the document.
    pub(super) fn place_mesh(&mut self, mesh: &Mesh, to_world: Affine3A, parts: Vec<Part>) -> Result<(), BuildError> {
        if self.mobile {
            self.place_instance(mesh, to_world, parts, &mut None)
        } else {
            self.place_copy(mesh, to_world, parts)
        }
    }

    /// A mesh in world coordinates: the fastest to trace.
    fn place_copy(&mut self, mesh: &Mesh, to_world: Affine3A, parts: Vec<Part>) -> Result<(), BuildError> {
        let Ground::New(builder) = &mut self.ground else {
            self.place_again(Some(mesh), to_world, to_world);
            return Ok(());
        };
        let positions = mesh.positions.iter().map(|p| to_world.transform_point3(*p)).collect();
        let shape = builder.mesh(positions, mesh.triangles.clone())?;
        builder.place(shape)?;
        let normal_to_world = normal_matrix(&to_world);
        let normals = mesh.normals.iter().map(|n| (normal_to_world * *n).normalize_or_zero()).collect();
        let shading = Arc::new(Shading { normals, uv_sets: uv_sets(mesh) });
        self.add_mesh_place(mesh, (shape, shading), Affine3A::IDENTITY, to_world, parts);
        Ok(())
    }

    /// A mesh in its own coordinates, with a transform. `held` is what earlier instances of it have left, or takes what later
    /// ones will use.
    fn place_instance(
        &mut self,
        mesh: &Mesh,
        to_world: Affine3A,
        parts: Vec<Part>,
        held: &mut Option<Held>,
    ) -> Result<(), BuildError> {
        let Ground::New(builder) = &mut self.ground else {
            self.place_again(Some(mesh), to_world, to_world);
            return Ok(());
        };
        let (shape, shading) = match held {
            Some(held) => held.clone(),
            None => {
                let shape = builder.mesh(mesh.positions.clone(), mesh.triangles.clone())?;
                let shading = Shading { normals: mesh.normals.clone(), uv_sets: uv_sets(mesh) };
                held.insert((shape, Arc::new(shading))).clone()
            }
        };
        builder.place_instance(shape, to_world)?;
        self.add_mesh_place(mesh, (shape, shading), to_world, to_world, parts);
        Ok(())
    }

    /// `to_world` maps what Embree holds, `object_to_world` what the file holds.
    fn add_mesh_place(
        &mut self,
        mesh: &Mesh,
        (shape, shading): Held,
        to_world: Affine3A,
        object_to_world: Affine3A,
        parts: Vec<Part>,
    ) {
        let mut place = Place::new(shape, Body::Mesh(shading), parts, to_world, object_to_world);
        if self.drains(&place.parts) {
            place.height_m = heights(mesh, &object_to_world);
        }
        self.add_place(place, Some(mesh), &object_to_world);
    }

    /// True where a film drains: only then it matters how high a place reaches, which takes a look at each vertex.
    fn drains(&self, parts: &[Part]) -> bool {
        let drains = |film: &document::Film| matches!(film.thickness, document::Thickness::Drain { .. });
        parts.iter().any(|part| self.materials[part.material as usize].films.iter().any(drains))
    }

    /// Adds a place with the emitters of its shining parts.
    fn add_place(&mut self, mut place: Place, mesh: Option<&Mesh>, object_to_world: &Affine3A) {
        let number = self.places.len() as u32;
        (place.number, place.node) = (number, self.node);
        match (mesh, &place.body) {
            (Some(mesh), _) => {
                // What the file holds may be mirrored where Embree holds it as it is.
                let handedness = 1.0f32.copysign(object_to_world.matrix3.determinant());
                lighting::add_mesh_emitters(self, mesh, &mut place.parts, number, object_to_world, handedness, false);
            }
            (None, Body::Sphere { radius, .. }) => {
                let (center, radius) = (Vec3::from(object_to_world.translation), radius * place.scale);
                let material = place.parts[0].material;
                place.parts[0].emitter = lighting::add_sphere_emitter(self, number, material, center, radius, false);
                place.height_m = [center.y - radius, center.y + radius];
            }
            (None, Body::Mesh(_)) => {}
        }
        self.places.push(place);
    }

    /// Goes on to the next place of the BVH that is there, and moves it where it has to stand elsewhere. `to_world` maps what
    /// Embree holds, if it is an instance.
    fn place_again(&mut self, mesh: Option<&Mesh>, to_world: Affine3A, object_to_world: Affine3A) {
        let number = self.places.len() as u32;
        let Ground::Built(built) = &mut self.ground else { return };
        let Some(mut place) = built.places.next() else { return };
        if self.mobile && (built.stale || place.to_world != to_world || place.to_object != object_to_world.inverse()) {
            built.moves.push((number, to_world));
            place.stand(to_world, object_to_world);
            if let Some(mesh) = mesh.filter(|_| self.drains(&place.parts)) {
                place.height_m = heights(mesh, &object_to_world);
            }
        }
        self.add_place(place, mesh, &object_to_world);
    }

    pub(super) fn place_sphere(&mut self, to_world: Affine3A, radius: f32, material: u32) -> Result<(), BuildError> {
        let center = Vec3::from(to_world.translation);
        let builder = match &mut self.ground {
            Ground::New(builder) => builder,
            Ground::Built(built) => {
                // Embree keeps the sphere's first size; the transform makes up for a change.
                let scale = match built.places.as_slice().first().map(|place| &place.body) {
                    Some(Body::Sphere { radius: held, .. }) => radius / held,
                    _ => 1.0,
                };
                let stands = Affine3A::from_translation(center) * Affine3A::from_scale(Vec3::splat(scale));
                self.place_again(None, stands, to_world);
                return Ok(());
            }
        };
        let (held_center, stands) = match self.mobile {
            true => (Vec3::ZERO, Affine3A::from_translation(center)),
            false => (center, Affine3A::IDENTITY),
        };
        let shape = builder.sphere(held_center, radius)?;
        match self.mobile {
            true => builder.place_instance(shape, stands)?,
            false => builder.place(shape)?,
        };
        let uv_sets = uv_slots(&self.materials[material as usize], |_| 0);
        let parts = vec![Part { end: u32::MAX, material, first: 0, emitter: u32::MAX, uv_sets }];
        let body = Body::Sphere { center: held_center, radius };
        self.add_place(Place::new(shape, body, parts, stands, to_world), None, &to_world);
        Ok(())
    }

    pub fn place_lights(&mut self, document: &Document, placements: &[(usize, Mat4)]) -> Result<(), BuildError> {
        for (number, (node, to_world)) in placements.iter().enumerate() {
            self.mobile = self.moving.get(number).copied().unwrap_or(false);
            self.node = *node as u32;
            for item in &document.nodes[*node].items {
                if let Item::Light(index) = item {
                    self.group = self.groups.of_light(*index);
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
        let set_of = |texcoord: &str| {
            let bound = binding.and_then(|b| b.uv_sets.iter().find(|(semantic, _)| semantic == texcoord));
            bound.and_then(|(_, set)| mesh.uv_sets.iter().position(|uvs| uvs.set == *set)).unwrap_or(0) as u32
        };
        Part {
            end: group.triangles.end as u32,
            material: material as u32,
            first: group.triangles.start as u32,
            emitter: u32::MAX,
            uv_sets: document.materials.get(material).map_or([NO_MAPS; UV_SLOTS], |m| uv_slots(m, set_of)),
        }
    };
    debug_assert!(!mesh.groups.is_empty(), "mesh `{}` has no groups", geometry.id);
    mesh.groups.iter().map(part).collect()
}

/// For each slot of a material's maps the set of texture coordinates. No material has more maps than there are slots.
fn uv_slots(material: &document::Material, set_of: impl Fn(&str) -> u32) -> [u32; UV_SLOTS] {
    let mut slots = [NO_MAPS; UV_SLOTS];
    slots.iter_mut().zip(material.texcoords()).for_each(|(slot, texcoord)| *slot = set_of(texcoord));
    slots
}

/// Lowest and highest point along world up.
fn heights(mesh: &Mesh, object_to_world: &Affine3A) -> [f32; 2] {
    let heights = mesh.positions.iter().map(|p| object_to_world.transform_point3(*p).y);
    heights.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], y| [low.min(y), high.max(y)])
}

fn uv_sets(mesh: &Mesh) -> Vec<Vec<glam::Vec2>> {
    mesh.uv_sets.iter().map(|set| set.uvs.clone()).collect()
}
