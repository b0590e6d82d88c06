//! Collecting shapes and placing them, before the first ray.

use embree4_sys as sys;
use glam::{Affine3A, Vec3};

use super::accel::Accel;
use super::error::EmbreeError;
use super::handle::{Device, Geometry, Scene};

/// A shape of one builder, to be placed any number of times.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Shape(usize);

/// One shape with the buffers that Embree reads.
pub(super) struct Solid {
    /// The shape alone, with a BVH of its own; there once an instance wants it. Dropped before `geometry`.
    object: Option<Scene>,
    geometry: Geometry,
    /// Shared with Embree: never changed and never moved while `geometry` lives, hence dropped last. Empty for spheres,
    /// whose few numbers Embree keeps itself.
    pub(super) buffers: Buffers,
}

#[derive(Default)]
pub(super) struct Buffers {
    /// One more than the mesh has: Embree reads 16 bytes at each 12-byte vertex.
    pub(super) positions: Vec<Vec3>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// A shape in the world.
pub(super) enum Placement {
    Direct,
    Instance(Geometry),
}

/// Takes shapes and places them. Placements are numbered from 0 in the order they are made.
pub struct AccelBuilder {
    // Order matters for dropping: scenes, then what they hold, then the device.
    world: Scene,
    placements: Vec<Placement>,
    solids: Vec<Solid>,
    device: Device,
}

impl AccelBuilder {
    /// `threads` share the work of [`build`](Self::build); 0 means all processors. What a ray hits does not depend on
    /// it.
    ///
    /// # Errors
    /// Embree cannot start, or is another version than the one this program was built for.
    pub fn new(threads: usize) -> Result<Self, EmbreeError> {
        let device = Device::new(threads)?;
        let world = device.scene()?;
        configure(&world);
        Ok(Self { world, placements: Vec::new(), solids: Vec::new(), device })
    }

    /// A triangle mesh; may be empty. Triangles with a vertex that is not finite are never hit.
    ///
    /// # Errors
    /// An index beyond `positions`, more than 2^32 - 1 of anything, or out of memory.
    pub fn mesh(&mut self, mut positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<Shape, EmbreeError> {
        let vertices = positions.len();
        check_mesh(vertices, &triangles)?;
        positions.reserve_exact(1);
        positions.push(Vec3::ZERO);

        let geometry = self.device.geometry(sys::RTCGeometryType::TRIANGLE)?;
        // SAFETY: `keep` makes both buffers part of the `Solid` that also owns `geometry`: they outlive it, and are neither
        // changed nor moved, as a vector's elements stay where they are when the vector moves. Until then nothing reads. Each
        // read of a vertex stays inside, thanks to the padding; each index was checked. Strides and formats are those of
        // the element types (asserted in `layout`).
        unsafe {
            share(&geometry, sys::RTCBufferType::VERTEX, sys::RTCFormat::FLOAT3, &positions, vertices);
            share(&geometry, sys::RTCBufferType::INDEX, sys::RTCFormat::UINT3, &triangles, triangles.len());
        }
        self.keep(geometry, Buffers { positions, triangles })
    }

    /// An exact sphere, hit from outside and from inside.
    ///
    /// # Errors
    /// A centre or radius that is not finite, a radius that is not positive, or out of memory.
    pub fn sphere(&mut self, center: Vec3, radius: f32) -> Result<Shape, EmbreeError> {
        if !(center.is_finite() && radius.is_finite() && radius > 0.0) {
            return Err(EmbreeError::Sphere { radius });
        }
        let geometry = self.device.geometry(sys::RTCGeometryType::SPHERE_POINT)?;
        let (kind, format) = (sys::RTCBufferType::VERTEX, sys::RTCFormat::FLOAT4);
        // SAFETY: the geometry is alive and keeps the memory.
        let memory = unsafe { sys::rtcSetNewGeometryBuffer(geometry.raw(), kind, 0, format, 16, 1) };
        self.device.check("take a sphere")?;
        // SAFETY: without an error the memory is there: one element of 16 bytes, aligned to 16.
        unsafe { memory.cast::<[f32; 4]>().write(center.extend(radius).to_array()) };
        self.keep(geometry, Buffers::default())
    }

    /// Puts a shape into the world as it is: its coordinates are world coordinates. The fastest to trace.
    ///
    /// # Errors
    /// A shape of another builder, or out of memory.
    pub fn place(&mut self, shape: Shape) -> Result<u32, EmbreeError> {
        let place = self.next_place()?;
        let solid = self.solids.get(shape.0).ok_or(EmbreeError::ForeignShape)?;
        // SAFETY: world and geometry are alive; the world takes a reference of its own.
        unsafe { sys::rtcAttachGeometryByID(self.world.raw(), solid.geometry.raw(), place) };
        self.device.check("place a shape")?;
        self.placements.push(Placement::Direct);
        Ok(place)
    }

    /// Puts a shape into the world through a transform (world from shape). All instances of a shape share one BVH, which
    /// is built here, the first time; rays pay for each instance they come near.
    ///
    /// # Errors
    /// A transform that is not finite or cannot be inverted, a shape of another builder, or out of memory.
    pub fn place_instance(&mut self, shape: Shape, transform: Affine3A) -> Result<u32, EmbreeError> {
        let place = self.next_place()?;
        check_transform(place, &transform)?;
        let solid = self.solids.get_mut(shape.0).ok_or(EmbreeError::ForeignShape)?;
        let object = match &solid.object {
            Some(object) => object,
            None => solid.object.insert(object_scene(&self.device, &solid.geometry)?),
        };
        let instance = self.device.geometry(sys::RTCGeometryType::INSTANCE)?;
        // SAFETY: all handles are alive; instance and world take references of their own.
        unsafe {
            sys::rtcSetGeometryInstancedScene(instance.raw(), object.raw());
            sys::rtcSetGeometryTimeStepCount(instance.raw(), 1);
        }
        set_transform(&instance, &transform);
        // SAFETY: as above.
        unsafe { sys::rtcAttachGeometryByID(self.world.raw(), instance.raw(), place) };
        self.device.check("place an instance")?;
        self.placements.push(Placement::Instance(instance));
        Ok(place)
    }

    /// Builds the BVH of the world, on all threads.
    ///
    /// # Errors
    /// Out of memory.
    pub fn build(self) -> Result<Accel, EmbreeError> {
        Accel::commit_new(self.world, self.placements, self.solids, self.device)
    }

    fn next_place(&self) -> Result<u32, EmbreeError> {
        let count = self.placements.len();
        match u32::try_from(count) {
            Ok(place) if place < u32::MAX => Ok(place),
            _ => Err(EmbreeError::TooLarge { count, what: "placements" }),
        }
    }

    fn keep(&mut self, geometry: Geometry, buffers: Buffers) -> Result<Shape, EmbreeError> {
        // From here on the buffers outlive the geometry, whatever happens.
        let solid = Solid { object: None, geometry, buffers };
        // SAFETY: the geometry is alive and complete.
        unsafe { sys::rtcCommitGeometry(solid.geometry.raw()) };
        self.device.check("take a shape")?;
        self.solids.push(solid);
        Ok(Shape(self.solids.len() - 1))
    }
}

impl Shape {
    /// The shape's place in the list of solids.
    pub(super) fn index(self) -> usize {
        self.0
    }
}

/// ROBUST makes meshes watertight along their edges: of 8 million rays from inside a closed mesh of 80 000 triangles none
/// gets out, without it nine do (only rays aimed at a vertex to the last bit may slip through). That costs a sixth of the
/// trace rate: 5.5 against 6.6 million rays/s on one thread, camera rays and three bounces in a box around a mesh of
/// 100 000 triangles. With ROBUST the quality HIGH gives the same BVH as MEDIUM; without, it took 5 times as long to build
/// (150 against 32 ms) and was traced no faster (5.5 million rays/s).
fn configure(scene: &Scene) {
    // SAFETY: the scene is alive.
    unsafe {
        sys::rtcSetSceneBuildQuality(scene.raw(), sys::RTCBuildQuality::MEDIUM);
        sys::rtcSetSceneFlags(scene.raw(), sys::RTCSceneFlags::ROBUST);
    }
}

/// A scene of one shape, built, to be instanced.
fn object_scene(device: &Device, geometry: &Geometry) -> Result<Scene, EmbreeError> {
    let scene = device.scene()?;
    configure(&scene);
    // SAFETY: both handles are alive; the scene takes a reference of its own.
    unsafe {
        sys::rtcAttachGeometryByID(scene.raw(), geometry.raw(), 0);
        sys::rtcCommitScene(scene.raw());
    }
    device.check("build the BVH of an instanced shape")?;
    Ok(scene)
}

/// Tells an instance where it stands.
pub(super) fn set_transform(instance: &Geometry, transform: &Affine3A) {
    let columns = transform.to_cols_array();
    // SAFETY: the geometry is alive and an instance; Embree copies the 12 floats.
    unsafe {
        let format = sys::RTCFormat::FLOAT3X4_COLUMN_MAJOR;
        sys::rtcSetGeometryTransform(instance.raw(), 0, format, columns.as_ptr().cast());
        sys::rtcCommitGeometry(instance.raw());
    }
}

pub(super) fn check_transform(place: u32, transform: &Affine3A) -> Result<(), EmbreeError> {
    // The inverse as well: Embree divides by the determinant, and NaN must not reach it.
    if transform.is_finite() && transform.matrix3.determinant() != 0.0 && transform.inverse().is_finite() {
        Ok(())
    } else {
        Err(EmbreeError::Transform { place })
    }
}

fn check_mesh(vertices: usize, triangles: &[[u32; 3]]) -> Result<(), EmbreeError> {
    for (count, what) in [(vertices, "vertices"), (triangles.len(), "triangles")] {
        if u32::try_from(count).is_err() {
            return Err(EmbreeError::TooLarge { count, what });
        }
    }
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&vertex| vertex as usize >= vertices) {
            return Err(EmbreeError::Index { triangle, vertex, vertices });
        }
    }
    Ok(())
}

/// Lets Embree read `count` elements of `buffer` in place.
///
/// # Safety
/// The buffer must stay where it is, unchanged, as long as the geometry lives; `T` must be what `format` says; Embree
/// reads 16 bytes at the start of every element of a vertex buffer.
unsafe fn share<T>(geometry: &Geometry, kind: sys::RTCBufferType, format: sys::RTCFormat, buffer: &[T], count: usize) {
    // SAFETY: the caller's promise.
    unsafe {
        sys::rtcSetSharedGeometryBuffer(
            geometry.raw(),
            kind,
            0,
            format,
            buffer.as_ptr().cast(),
            0,
            size_of::<T>(),
            count,
        );
    }
}
