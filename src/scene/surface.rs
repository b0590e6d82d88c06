//! What a ray finds: position, normals, texture coordinates and the material there.

use std::f32::consts::{PI, TAU};
use std::sync::Arc;

use glam::{Affine3A, Mat3, Vec2, Vec3};

use super::light::LampPoint;
use crate::document;
use crate::embree::{Accel, Hit, Shape};

/// A shape in the world, as shading sees it.
pub struct Place {
    /// Its own number in the scene.
    pub number: u32,
    /// The document's node that it stands in.
    pub node: u32,
    pub shape: Shape,
    pub body: Body,
    /// World from the coordinates that Embree holds; identity where they are world coordinates.
    pub to_world: Affine3A,
    /// The largest stretch of `to_world`.
    pub scale: f32,
    pub normal_to_world: Mat3,
    /// -1 where `to_world` mirrors, which turns a triangle's winding around.
    pub handedness: f32,
    /// Object space (the file's own) from world.
    pub to_object: Affine3A,
    pub parts: Vec<Part>,
    /// Lowest and highest point along world up: where drainage starts and ends.
    pub height_m: [f32; 2],
}

/// What shading needs of a shape beyond what Embree holds.
pub enum Body {
    /// Shared by all places of the mesh.
    Mesh(Arc<Shading>),
    /// Centre in the coordinates that Embree holds.
    Sphere { center: Vec3, radius: f32 },
}

/// What a material emits.
pub struct Glow {
    /// W/(sr m2) per channel.
    pub radiance: document::Texture,
    /// Index into the scene's spectra.
    pub spectrum: u32,
    pub two_sided: bool,
    /// Share of the surface that is there: holes do not shine.
    pub opacity: document::Scalar,
}

impl Glow {
    /// Rough mean radiance, for choosing between lights.
    pub fn strength(&self) -> f32 {
        self.radiance.value.element_sum() / 3.0
    }

    /// True where all of the surface shines alike.
    pub fn is_even(&self) -> bool {
        self.radiance.map.is_none() && self.opacity.map.is_none() && self.opacity.value >= 1.0
    }
}

/// A run of triangles with one material; ends before triangle `end`.
#[derive(Clone, Copy)]
pub struct Part {
    pub end: u32,
    pub material: u32,
    /// Emitter number of the part's first triangle (`first`), the others follow; `u32::MAX` when it does not shine.
    pub first: u32,
    pub emitter: u32,
    /// Indices into [`Shading::uv_sets`] by the slots of the material's maps; [`NO_MAPS`] where a slot is empty.
    pub uv_sets: [u32; UV_SLOTS],
}

/// Texture coordinates that the maps of one material can have between them.
pub const UV_SLOTS: usize = 3;
/// The `uv_set` of a slot that no map uses.
pub const NO_MAPS: u32 = u32::MAX;

/// Vertex data that only shading reads.
#[derive(Default)]
pub struct Shading {
    /// One per vertex, in the coordinates that Embree holds; empty: flat.
    pub normals: Vec<Vec3>,
    pub uv_sets: Vec<Vec<Vec2>>,
}

/// A point on a surface in world space.
#[derive(Clone, Copy)]
pub struct Surface<'s> {
    pub position: Vec3,
    /// Outward geometric normal, unit length.
    pub ng: Vec3,
    /// Shading normal, unit length: the geometric one, or interpolated between vertices.
    pub normal: Vec3,
    /// By the slots of the material's maps; zero where it has none.
    pub uv: [Vec2; UV_SLOTS],
    /// dP/du of the first slot, for tangent-space normals; zero where texture coordinates do not define it.
    pub dpdu: Vec3,
    pub place: &'s Place,
    pub material: u32,
    /// `u32::MAX` when the surface does not shine.
    pub emitter: u32,
    /// Bound on the rounding error of `position`, per axis.
    pub(super) error_m: f32,
}

/// Rounding of an interpolated position against the largest coordinate involved: about eight units in the last place.
const POSITION_ERROR: f32 = 1e-6;

impl<'s> Surface<'s> {
    #[inline]
    pub fn new(accel: &Accel, place: &'s Place, hit: &Hit) -> Self {
        match &place.body {
            Body::Mesh(shading) => Self::on_triangle(accel, place, shading, hit),
            Body::Sphere { center, radius } => Self::on_sphere(place, *center, *radius, hit),
        }
    }

    /// The point of a triangle with these barycentric weights of its second and third corner.
    pub fn at(accel: &Accel, place: &'s Place, prim: u32, barycentric: [f32; 2]) -> Self {
        let corners = accel.triangles(place.shape).get(prim as usize).copied().unwrap_or_default();
        let positions = accel.positions(place.shape);
        let ng = match corners.map(|i| positions.get(i as usize)) {
            [Some(p0), Some(p1), Some(p2)] => (p1 - p0).cross(p2 - p0),
            // A sphere: its maps are read at the pole.
            _ => Vec3::Y,
        };
        let [u, v] = barycentric;
        Self::new(accel, place, &Hit { t: 0.0, u, v, ng, prim, geom: 0, instance: 0 })
    }

    #[inline]
    fn on_triangle(accel: &Accel, place: &'s Place, shading: &Shading, hit: &Hit) -> Self {
        let part = place.part(hit.prim);
        let [i0, i1, i2] = accel.triangles(place.shape)[hit.prim as usize].map(|i| i as usize);
        let positions = accel.positions(place.shape);
        let [p0, p1, p2] = [positions[i0], positions[i1], positions[i2]];
        let (w0, w1, w2) = (1.0 - hit.u - hit.v, hit.u, hit.v);
        let local = p0 * w0 + p1 * w1 + p2 * w2;
        let position = place.to_world.transform_point3(local);
        let largest = p0.abs().max(p1.abs()).max(p2.abs()).max_element();
        let ng = (place.normal_to_world * hit.ng).normalize() * place.handedness;

        let mut normal = ng;
        if !shading.normals.is_empty() {
            let blend = shading.normals[i0] * w0 + shading.normals[i1] * w1 + shading.normals[i2] * w2;
            // Normals that cancel out say nothing.
            normal = (place.normal_to_world * blend).try_normalize().unwrap_or(ng);
        }
        let (mut uv, mut dpdu) = ([Vec2::ZERO; UV_SLOTS], Vec3::ZERO);
        for (slot, &set) in part.uv_sets.iter().enumerate() {
            let Some(uvs) = shading.uv_sets.get(set as usize) else { break };
            let (t0, t1, t2) = (uvs[i0], uvs[i1], uvs[i2]);
            uv[slot] = t0 * w0 + t1 * w1 + t2 * w2;
            let (d1, d2) = (t1 - t0, t2 - t0);
            let determinant = d1.perp_dot(d2);
            if slot == 0 && determinant != 0.0 {
                let object = ((p1 - p0) * d2.y - (p2 - p0) * d1.y) / determinant;
                dpdu = place.to_world.transform_vector3(object);
            }
        }
        Self {
            position,
            ng,
            normal,
            uv,
            dpdu,
            place,
            material: part.material,
            emitter: if part.emitter == u32::MAX { u32::MAX } else { part.emitter + (hit.prim - part.first) },
            error_m: place.rounding_m(largest),
        }
    }

    fn on_sphere(place: &'s Place, center: Vec3, radius: f32, hit: &Hit) -> Self {
        let part = place.part(0);
        // From the centre, not along the ray: that may come from far away, and its rounding put the point on the wrong side.
        let position = place.to_world.transform_point3(center + hit.ng.normalize_or_zero() * radius);
        let ng = (place.normal_to_world * hit.ng).normalize();
        let mut uv = Vec2::ZERO;
        if part.uv_sets[0] != NO_MAPS {
            uv = sphere_uv(place, ng);
        }
        Self {
            position,
            ng,
            normal: ng,
            uv: [uv; UV_SLOTS],
            dpdu: Vec3::new(-ng.z, 0.0, ng.x),
            place,
            material: part.material,
            emitter: part.emitter,
            error_m: place.rounding_m(center.abs().max_element() + radius),
        }
    }

    /// The point as one of a lamp.
    #[inline]
    pub fn lamp(&self) -> LampPoint {
        LampPoint { emitter: self.emitter, position: self.position, ng: self.ng }
    }

    /// Where a ray leaving along `direction` may start without meeting this surface again.
    #[inline]
    pub fn leave(&self, direction: Vec3) -> Vec3 {
        let offset = self.offset();
        if direction.dot(self.ng) >= 0.0 { self.position + offset } else { self.position - offset }
    }

    /// How far beside the surface rays start on its outward side.
    #[inline]
    pub fn offset(&self) -> Vec3 {
        self.ng * self.error_m
    }

    /// The point in the object's own coordinates, where procedural thickness is defined.
    pub fn object_position(&self) -> Vec3 {
        self.place.to_object.transform_point3(self.position)
    }
}

impl Place {
    /// `to_world` maps what Embree holds, `object_to_world` what the file holds.
    pub fn new(shape: Shape, body: Body, parts: Vec<Part>, to_world: Affine3A, object_to_world: Affine3A) -> Self {
        let mut place = Self {
            number: u32::MAX,
            node: u32::MAX,
            shape,
            body,
            to_world,
            scale: 1.0,
            normal_to_world: Mat3::IDENTITY,
            handedness: 1.0,
            to_object: Affine3A::IDENTITY,
            parts,
            height_m: [0.0; 2],
        };
        place.stand(to_world, object_to_world);
        place
    }

    /// Puts the place somewhere else; its heights remain to be found.
    pub fn stand(&mut self, to_world: Affine3A, object_to_world: Affine3A) {
        let m = to_world.matrix3;
        self.to_world = to_world;
        self.scale = m.x_axis.length().max(m.y_axis.length()).max(m.z_axis.length());
        self.normal_to_world = normal_matrix(&to_world);
        self.handedness = 1.0f32.copysign(object_to_world.matrix3.determinant());
        self.to_object = object_to_world.inverse();
    }

    /// The part that a triangle belongs to.
    #[inline]
    pub fn part(&self, prim: u32) -> &Part {
        let index = if self.parts.len() == 1 { 0 } else { self.parts.partition_point(|part| part.end <= prim) };
        &self.parts[index.min(self.parts.len() - 1)]
    }

    /// Texture coordinates of a hit, whether or not the material there has maps: those of the maps, else of the first set.
    pub fn uv(&self, accel: &Accel, hit: &Hit) -> Vec2 {
        match &self.body {
            Body::Sphere { .. } => sphere_uv(self, (self.normal_to_world * hit.ng).normalize()),
            Body::Mesh(shading) => {
                let set = match self.part(hit.prim).uv_sets[0] {
                    NO_MAPS => 0,
                    set => set as usize,
                };
                let Some(uvs) = shading.uv_sets.get(set) else { return Vec2::ZERO };
                let [t0, t1, t2] = accel.triangles(self.shape)[hit.prim as usize].map(|i| uvs[i as usize]);
                t0 * (1.0 - hit.u - hit.v) + t1 * hit.u + t2 * hit.v
            }
        }
    }

    /// Bound on the rounding error of a world coordinate, given the largest coordinate before the transform.
    #[inline]
    fn rounding_m(&self, largest: f32) -> f32 {
        (largest * self.scale + Vec3::from(self.to_world.translation).abs().max_element()) * POSITION_ERROR
    }
}

/// Longitude and latitude in the object's own coordinates, each over 0..1.
fn sphere_uv(place: &Place, ng: Vec3) -> Vec2 {
    let local = (place.to_object.transform_vector3(ng)).normalize();
    Vec2::new(0.5 + local.z.atan2(local.x) / TAU, 0.5 + local.y.clamp(-1.0, 1.0).asin() / PI)
}

/// The inverse transpose, which maps normals.
pub(super) fn normal_matrix(to_world: &Affine3A) -> Mat3 {
    let inverse = Mat3::from(to_world.matrix3).inverse();
    if inverse.is_finite() { inverse.transpose() } else { Mat3::IDENTITY }
}
