//! Eight rays at once: where they start near each other and go about the same way, Embree answers them faster together.

use std::ptr;

use embree4_sys as sys;
use glam::Vec3;
use wide::{CmpEq, CmpLt, f32x8, i32x8};

use super::accel::Accel;
use super::layout::{INVALID_ID, LEVELS, RTCHit8, RTCRay8, RTCRayHit8};
use super::ray::{GAP, Hit, Ray};
use crate::math::Vec3x8;

/// Rays in a batch.
pub const BATCH: usize = 8;
/// The bit of each lane.
const BITS: [i32; BATCH] = [1, 2, 4, 8, 16, 32, 64, 128];

/// Eight rays, each number of all side by side.
pub struct Rays(RTCRay8);

impl Rays {
    #[inline]
    fn new(origin: Vec3x8, dir: Vec3x8, [tnear, tfar]: [f32x8; 2]) -> Self {
        Self(RTCRay8 {
            org_x: origin.x.to_array(),
            org_y: origin.y.to_array(),
            org_z: origin.z.to_array(),
            tnear: tnear.to_array(),
            dir_x: dir.x.to_array(),
            dir_y: dir.y.to_array(),
            dir_z: dir.z.to_array(),
            time: [0.0; BATCH],
            tfar: tfar.to_array(),
            mask: [u32::MAX; BATCH],
            id: [0; BATCH],
            flags: [0; BATCH],
        })
    }

    /// As [`Ray::between`].
    #[inline]
    pub fn between(from: Vec3x8, to: Vec3x8) -> Self {
        let way = to - from;
        let length = way.length_squared().sqrt();
        Self::new(from, way * (f32x8::ONE / length), [f32x8::ZERO, length * f32x8::splat(1.0 - GAP)])
    }
}

impl From<&[Ray; BATCH]> for Rays {
    #[inline]
    fn from(rays: &[Ray; BATCH]) -> Self {
        let rows = rays.map(|Ray { origin, dir, tnear, tfar }| {
            f32x8::new([origin.x, origin.y, origin.z, dir.x, dir.y, dir.z, tnear, tfar])
        });
        let [x, y, z, dir_x, dir_y, dir_z, tnear, tfar] = f32x8::transpose(rows);
        Self::new(Vec3x8 { x, y, z }, Vec3x8 { x: dir_x, y: dir_y, z: dir_z }, [tnear, tfar])
    }
}

/// -1 for the lanes that count, 0 for the others; Embree wants it aligned like the rays.
#[repr(C, align(32))]
struct Lanes([i32; BATCH]);

impl Lanes {
    #[inline]
    fn new(mask: u8) -> Self {
        let bits = i32x8::new(BITS);
        Self((i32x8::splat(i32::from(mask)) & bits).cmp_eq(bits).to_array())
    }
}

impl Accel {
    /// Puts the first surface along each of the rays whose bit is set in `active` (bit i for ray i) into `hits`; nothing for
    /// the others, and as in [`Accel::intersect`]. Where two surfaces tie, which one is met may depend on the other rays of
    /// the batch.
    #[inline]
    pub fn intersect_batch(&self, rays: impl Into<Rays>, active: u8, hits: &mut Hits) {
        let Hits(query) = hits;
        query.ray = rays.into().0;
        (query.hit.geomID, query.hit.instID) = ([INVALID_ID; BATCH], [[INVALID_ID; BATCH]; LEVELS]);
        let lanes = Lanes::new(self.lanes(&query.ray, active));
        let pointer: *mut RTCRayHit8 = query;
        // SAFETY: as in `occluded_batch`, with the RTCRayHit8 of the installed Embree.
        unsafe { sys::rtcIntersect8(lanes.0.as_ptr(), self.world.raw(), pointer.cast(), ptr::null_mut()) };
    }

    /// Which of the rays whose bit is set in `active` meet anything: bit i for ray i, as in [`Accel::occluded`].
    #[inline]
    pub fn occluded_batch(&self, rays: impl Into<Rays>, active: u8) -> u8 {
        if active == 0 {
            return 0;
        }
        let Rays(mut query) = rays.into();
        let mask = self.lanes(&query, active);
        let lanes = Lanes::new(mask);
        let pointer: *mut RTCRay8 = &mut query;
        // SAFETY: as in `Accel::occluded`, with a whole, 32-byte aligned RTCRay8 of the installed Embree and eight ints as
        // aligned; all lanes hold numbers, whether they count or not. An unbuilt scene has none that count.
        unsafe { sys::rtcOccluded8(lanes.0.as_ptr(), self.world.raw(), pointer.cast(), ptr::null_mut()) };
        f32x8::new(query.tfar).cmp_lt(f32x8::ZERO).move_mask() as u8 & mask
    }

    /// The bits of the lanes that Embree may see.
    #[inline]
    fn lanes(&self, rays: &RTCRay8, active: u8) -> u8 {
        // As in `Ray::is_finite`.
        let zero = |numbers: [f32; BATCH]| f32x8::new(numbers) * f32x8::ZERO;
        let origin = zero(rays.org_x) + zero(rays.org_y) + zero(rays.org_z);
        let dir = zero(rays.dir_x) + zero(rays.dir_y) + zero(rays.dir_z);
        let tfar = f32x8::new(rays.tfar);
        let finite = (origin + dir + zero(rays.tnear)).cmp_eq(f32x8::ZERO) & tfar.cmp_eq(tfar);
        if self.built { active & finite.move_mask() as u8 } else { 0 }
    }
}

/// What the rays of a batch met: room for one batch after the other.
pub struct Hits(RTCRayHit8);

impl Default for Hits {
    fn default() -> Self {
        let hit = RTCHit8 { geomID: [INVALID_ID; BATCH], ..RTCHit8::default() };
        Self(RTCRayHit8 { ray: RTCRay8::default(), hit })
    }
}

impl Hits {
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

    #[test]
    fn eight_rays_between_points_are_those_of_one() {
        let from: [Vec3; BATCH] = std::array::from_fn(|i| Vec3::new(0.1, 0.7, -0.3) * i as f32);
        let to = Vec3::new(1.3, -0.2, 2.9);
        let eight = Rays::between(from.into(), Vec3x8::splat(to)).0;
        let single = Rays::from(&from.map(|from| Ray::between(from, to))).0;
        assert_eq!((eight.org_x, eight.org_y, eight.org_z), (single.org_x, single.org_y, single.org_z));
        assert_eq!((eight.dir_x, eight.dir_y, eight.dir_z), (single.dir_x, single.dir_y, single.dir_z));
        assert_eq!((eight.tnear, eight.tfar), (single.tnear, single.tfar));
    }

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

        let mut guarded = Guarded { before: [0xA5; 64], hits: Hits::default(), after: [0x5A; 64] };
        accel.intersect_batch(&rays, 0b0111_1111, &mut guarded.hits);
        for lane in 0..BATCH - 1 {
            let hit = guarded.hits.get(lane).unwrap();
            assert_eq!((hit.prim, hit.geom, hit.instance), (0, 0, 0));
            assert!((hit.t - 1.0).abs() < 1e-6);
        }
        assert_eq!(guarded.hits.get(BATCH - 1), None);
        assert_eq!((guarded.before, guarded.after), ([0xA5; 64], [0x5A; 64]));
    }
}
