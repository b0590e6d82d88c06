//! Eight rays at once: where they start near each other and go about the same way, Embree answers them faster together.

use std::ptr;

use embree4_sys as sys;
use glam::Vec3;

use super::accel::Accel;
use super::layout::{INVALID_ID, LEVELS, RTCHit8, RTCRay8, RTCRayHit8};
use super::ray::{Hit, Ray};

/// Rays in a batch.
pub const BATCH: usize = 8;

/// -1 for the lanes that count, 0 for the others; Embree wants it aligned like the rays.
#[repr(C, align(32))]
struct Lanes([i32; BATCH]);

impl Accel {
    /// The first surface along each of the rays whose bit is set in `active` (bit i for ray i); nothing for the others, and
    /// as in [`Accel::intersect`]. Where two surfaces tie, which one is met may depend on the other rays of the batch.
    #[inline]
    pub fn intersect_batch(&self, rays: &[Ray; BATCH], active: u8) -> Hits {
        let mut hits = Hits::none(pack(rays));
        self.trace_batch(&self.lanes(&hits.0.ray, active), &mut hits.0);
        hits
    }

    /// Which of the rays whose bit is set in `active` meet anything: bit i for ray i, as in [`Accel::occluded`].
    #[inline]
    pub fn occluded_batch(&self, rays: &[Ray; BATCH], active: u8) -> u8 {
        let mut query = pack(rays);
        let lanes = self.lanes(&query, active);
        let pointer: *mut RTCRay8 = &mut query;
        // SAFETY: as in `Accel::occluded`, with a whole, 32-byte aligned RTCRay8 of the installed Embree and eight ints as
        // aligned; all lanes hold numbers, whether they count or not. An unbuilt scene has none that count.
        unsafe { sys::rtcOccluded8(lanes.0.as_ptr(), self.world.raw(), pointer.cast(), ptr::null_mut()) };
        (0..BATCH).fold(0, |mask, lane| mask | u8::from(lanes.0[lane] != 0 && query.tfar[lane] < 0.0) << lane)
    }

    #[inline]
    fn trace_batch(&self, lanes: &Lanes, query: &mut RTCRayHit8) {
        let pointer: *mut RTCRayHit8 = query;
        // SAFETY: as in `occluded_batch`, with the RTCRayHit8 of the installed Embree.
        unsafe { sys::rtcIntersect8(lanes.0.as_ptr(), self.world.raw(), pointer.cast(), ptr::null_mut()) };
    }

    /// The lanes that Embree may see.
    #[inline]
    fn lanes(&self, rays: &RTCRay8, active: u8) -> Lanes {
        let active = if self.built { active } else { 0 };
        Lanes(std::array::from_fn(|lane| {
            // As in `Ray::is_finite`.
            let origin = rays.org_x[lane] * 0.0 + rays.org_y[lane] * 0.0 + rays.org_z[lane] * 0.0;
            let dir = rays.dir_x[lane] * 0.0 + rays.dir_y[lane] * 0.0 + rays.dir_z[lane] * 0.0;
            let finite = (origin + dir + rays.tnear[lane] * 0.0 == 0.0) & !rays.tfar[lane].is_nan();
            -i32::from((active >> lane & 1 != 0) & finite)
        }))
    }
}

#[inline]
fn pack(rays: &[Ray; BATCH]) -> RTCRay8 {
    RTCRay8 {
        org_x: rays.map(|ray| ray.origin.x),
        org_y: rays.map(|ray| ray.origin.y),
        org_z: rays.map(|ray| ray.origin.z),
        tnear: rays.map(|ray| ray.tnear),
        dir_x: rays.map(|ray| ray.dir.x),
        dir_y: rays.map(|ray| ray.dir.y),
        dir_z: rays.map(|ray| ray.dir.z),
        time: [0.0; BATCH],
        tfar: rays.map(|ray| ray.tfar),
        mask: [u32::MAX; BATCH],
        id: [0; BATCH],
        flags: [0; BATCH],
    }
}

/// What the rays of a batch met.
pub struct Hits(RTCRayHit8);

impl Hits {
    #[inline]
    fn none(ray: RTCRay8) -> Self {
        let hit = RTCHit8 { geomID: [INVALID_ID; BATCH], instID: [[INVALID_ID; BATCH]; LEVELS], ..RTCHit8::default() };
        Self(RTCRayHit8 { ray, hit })
    }

    /// What ray `lane` met.
    #[inline]
    pub fn get(&self, lane: usize) -> Option<Hit> {
        let RTCRayHit8 { ray, hit } = &self.0;
        (hit.geomID[lane] != INVALID_ID).then(|| Hit {
            t: ray.tfar[lane],
            u: hit.u[lane],
            v: hit.v[lane],
            ng: Vec3::new(hit.Ng_x[lane], hit.Ng_y[lane], hit.Ng_z[lane]),
            prim: hit.primID[lane],
            geom: hit.geomID[lane],
            instance: hit.instID[0][lane],
        })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use glam::Affine3A;

    use super::*;
    use crate::embree::AccelBuilder;

    /// As for a single ray: Embree writes the whole struct of its own build.
    #[test]
    fn a_batch_leaves_the_bytes_around_it_untouched() {
        #[repr(C)]
        struct Guarded {
            before: [u8; 64],
            hits: Hits,
            after: [u8; 64],
        }
        let mut builder = AccelBuilder::new(1).unwrap();
        let triangle = builder.mesh(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]).unwrap();
        builder.place_instance(triangle, Affine3A::IDENTITY).unwrap();
        let accel = builder.build().unwrap();
        let rays = [Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z); BATCH];

        let mut guarded = Guarded { before: [0xA5; 64], hits: Hits::none(pack(&rays)), after: [0x5A; 64] };
        accel.trace_batch(&accel.lanes(&pack(&rays), 0b0111_1111), &mut guarded.hits.0);
        for lane in 0..BATCH - 1 {
            let hit = guarded.hits.get(lane).unwrap();
            assert_eq!((hit.prim, hit.geom, hit.instance), (0, 0, 0));
            assert!((hit.t - 1.0).abs() < 1e-6);
        }
        assert_eq!(guarded.hits.get(BATCH - 1), None);
        assert_eq!((guarded.before, guarded.after), ([0xA5; 64], [0x5A; 64]));
    }
}
