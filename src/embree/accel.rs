//! The finished structure that answers rays.

use std::ptr;

use embree4_sys as sys;
use glam::{Affine3A, Vec3};

use super::builder::{Placement, Shape, Solid, check_transform, set_transform};
use super::error::EmbreeError;
use super::handle::{Device, Geometry, Scene};
use super::layout::{RTCBounds, RTCRay, RTCRayHit};
use super::ray::{Hit, Ray};

/// Everything that rays can hit, built. Rays may come from any number of threads at once.
pub struct Accel {
    // Order matters for dropping: scenes, then what they hold, then the buffers, then the device.
    pub(super) world: Scene,
    placements: Vec<Placement>,
    solids: Vec<Solid>,
    device: Device,
    /// False after a failed rebuild: nothing is hit then, rather than tracing a half-built scene.
    pub(super) built: bool,
}

// SAFETY: Embree's objects belong to no thread. The error slot is behind a mutex, and the shared buffers move with us.
unsafe impl Send for Accel {}
// SAFETY: after the commit that ends each `&mut` method, scene, geometries and shared buffers are only read through `&self`.
// rtcIntersect1 and 8, rtcOccluded1 and 8 and rtcGetSceneBounds may run concurrently on a committed scene (Embree's manual,
// "Thread Safety"); the error slot that they might write is behind a mutex.
unsafe impl Sync for Accel {}

impl Accel {
    pub(super) fn commit_new(
        world: Scene,
        placements: Vec<Placement>,
        solids: Vec<Solid>,
        device: Device,
    ) -> Result<Self, EmbreeError> {
        let mut accel = Self { world, placements, solids, device, built: false };
        accel.commit()?;
        Ok(accel)
    }

    fn commit(&mut self) -> Result<(), EmbreeError> {
        self.built = false;
        // SAFETY: the scene is alive, and `&mut self` keeps rays away.
        unsafe { sys::rtcCommitScene(self.world.raw()) };
        self.device.check("build the BVH of the scene")?;
        self.built = true;
        Ok(())
    }

    /// The first surface along the ray, or `None` if it meets none or is not finite ([`Ray::is_finite`]).
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        if !(self.built & ray.is_finite()) {
            return None;
        }
        let mut query = ray.query();
        self.trace(&mut query);
        Hit::from_raw(&query)
    }

    /// True if anything lies on the ray between `tnear` and `tfar`; false for a ray that is not finite.
    #[inline]
    pub fn occluded(&self, ray: &Ray) -> bool {
        if !(self.built & ray.is_finite()) {
            return false;
        }
        let mut query = ray.raw();
        let pointer: *mut RTCRay = &mut query;
        // SAFETY: the scene is built and alive. The pointer is to a whole, 16-byte aligned RTCRay of the installed
        // Embree; embree4-sys's name for it is only a label here. Null arguments mean the defaults.
        unsafe { sys::rtcOccluded1(self.world.raw(), pointer.cast(), ptr::null_mut()) };
        query.tfar < 0.0
    }

    #[inline]
    fn trace(&self, query: &mut RTCRayHit) {
        let pointer: *mut RTCRayHit = query;
        // SAFETY: as in `occluded`, with the RTCRayHit of the installed Embree (not embree4-sys's shorter one).
        unsafe { sys::rtcIntersect1(self.world.raw(), pointer.cast(), ptr::null_mut()) };
    }

    /// Corners (min, max) of an axis-aligned box around everything, in world space; `None` when there is nothing.
    /// Instances count with the box of their transformed box, which may be wider than they are.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let mut bounds = RTCBounds::default();
        let pointer: *mut RTCBounds = &mut bounds;
        // SAFETY: the scene is alive, the pointer is to a whole RTCBounds of the installed Embree.
        unsafe { sys::rtcGetSceneBounds(self.world.raw(), pointer.cast()) };
        let min = Vec3::new(bounds.lower_x, bounds.lower_y, bounds.lower_z);
        let max = Vec3::new(bounds.upper_x, bounds.upper_y, bounds.upper_z);
        (self.built && min.cmple(max).all()).then_some((min, max))
    }

    /// Moves instances and rebuilds what depends on it: the BVH over the instances, and that of the directly placed
    /// shapes (so place what is large and many as instances where frames are many). Instanced shapes keep theirs.
    ///
    /// # Errors
    /// A placement that is not an instance or a transform that cannot be inverted: nothing has changed then. After
    /// "out of memory" nothing is hit any more.
    pub fn move_instances(&mut self, moves: &[(u32, Affine3A)]) -> Result<(), EmbreeError> {
        for (place, transform) in moves {
            check_transform(*place, transform)?;
            self.instance(*place)?;
        }
        for (place, transform) in moves {
            set_transform(self.instance(*place)?, transform);
        }
        self.commit()
    }

    fn instance(&self, place: u32) -> Result<&Geometry, EmbreeError> {
        match self.placements.get(place as usize) {
            Some(Placement::Instance(geometry)) => Ok(geometry),
            _ => Err(EmbreeError::NotAnInstance { place }),
        }
    }

    /// The vertices of a mesh as they were handed over; none for a sphere or a shape of another builder.
    pub fn positions(&self, shape: Shape) -> &[Vec3] {
        match self.solids.get(shape.index()).map(|solid| solid.buffers.positions.as_slice()) {
            // Without the padding at the end.
            Some([positions @ .., _]) => positions,
            _ => &[],
        }
    }

    /// The triangles of a mesh as they were handed over; none for a sphere or a shape of another builder.
    pub fn triangles(&self, shape: Shape) -> &[[u32; 3]] {
        self.solids.get(shape.index()).map_or(&[], |solid| &solid.buffers.triangles)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::embree::AccelBuilder;

    /// Embree writes the whole struct of its own build: nothing beyond ours may change.
    #[test]
    fn a_hit_leaves_the_bytes_around_it_untouched() {
        #[repr(C)]
        struct Guarded<T> {
            before: [u8; 64],
            query: T,
            after: [u8; 64],
        }
        let mut builder = AccelBuilder::new(1).unwrap();
        let triangle = builder.mesh(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]).unwrap();
        builder.place_instance(triangle, Affine3A::IDENTITY).unwrap();
        let accel = builder.build().unwrap();
        let ray = Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z);

        let mut guarded = Guarded { before: [0xA5; 64], query: ray.query(), after: [0x5A; 64] };
        accel.trace(&mut guarded.query);
        let hit = Hit::from_raw(&guarded.query).unwrap();
        assert_eq!((hit.prim, hit.geom, hit.instance), (0, 0, 0));
        assert!((hit.t - 1.0).abs() < 1e-6);
        assert_eq!(guarded.before, [0xA5; 64]);
        assert_eq!(guarded.after, [0x5A; 64]);
    }
}
