//! All surfaces on a ray, where the first is not enough: several may lie in the same place.

use embree4_sys as sys;

use super::accel::Accel;
use super::layout::{
    ALL_FEATURES, ASK_FOR_EACH_HIT, INVALID_ID, LEVELS, RTCFilterFunctionNArguments, RTCHit, RTCIntersectArguments,
    RTCRay, RTCRayHit, RTCRayQueryContext,
};
use super::ray::{Hit, Ray};

/// What Embree hands back to [`note`]: its own context first, so that a pointer to one is a pointer to the other.
#[repr(C)]
struct Noting<'a, F> {
    context: RTCRayQueryContext,
    found: &'a mut F,
}

impl Accel {
    /// Calls `found` for every surface along the ray, in no order; one that the ray meets on an edge of two triangles may come
    /// twice. Nothing for a ray that is not finite ([`Ray::is_finite`]). `found` must not panic: that would end the program.
    pub fn every_hit<F: FnMut(Hit)>(&self, ray: &Ray, mut found: F) {
        if !(self.built & ray.is_finite()) {
            return;
        }
        let context = RTCRayQueryContext { instID: [INVALID_ID; LEVELS], ..RTCRayQueryContext::default() };
        let mut noting = Noting { context, found: &mut found };
        let mut arguments = RTCIntersectArguments {
            flags: ASK_FOR_EACH_HIT,
            feature_mask: ALL_FEATURES,
            context: (&raw mut noting).cast(),
            filter: Some(note::<F>),
            ..RTCIntersectArguments::default()
        };
        let mut query = ray.query();
        let pointer: *mut RTCRayHit = &mut query;
        // SAFETY: as in `Accel::intersect`. The arguments, laid out as the installed Embree wants them, and the context behind
        // them outlive the call; Embree passes the context on to `note` alone.
        unsafe { sys::rtcIntersect1(self.world.raw(), pointer.cast(), (&raw mut arguments).cast()) };
    }
}

/// Notes a hit and turns it down, so that Embree goes on looking.
unsafe extern "C" fn note<F: FnMut(Hit)>(arguments: *const RTCFilterFunctionNArguments) {
    // SAFETY: Embree calls this from `rtcIntersect1` only, with pointers to one ray and one hit (N = 1), whose layout then is
    // that of RTCRay and RTCHit (the manual promises no alignment, so none is relied on), and with the context of
    // `every_hit`, which nobody else uses meanwhile. A panic of `found` ends the program here: it never unwinds into Embree.
    unsafe {
        let arguments = &*arguments;
        let ray = arguments.ray.cast::<RTCRay>().read_unaligned();
        let hit = arguments.hit.cast::<RTCHit>().read_unaligned();
        let noting = &mut *arguments.context.cast::<Noting<F>>();
        if let Some(hit) = Hit::from_raw(&RTCRayHit { ray, hit }) {
            (noting.found)(hit);
        }
        *arguments.valid = 0;
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use glam::{Affine3A, Vec3};

    use super::*;
    use crate::embree::AccelBuilder;

    #[test]
    fn surfaces_in_the_same_place_are_all_found() {
        let mut builder = AccelBuilder::new(1).unwrap();
        let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
        let triangle = builder.mesh(corners.clone(), vec![[0, 1, 2]]).unwrap();
        let twin = builder.mesh(corners, vec![[2, 0, 1]]).unwrap();
        let ball = builder.sphere(Vec3::new(0.25, 0.25, -2.0), 0.5).unwrap();
        builder.place(triangle).unwrap();
        builder.place_instance(twin, Affine3A::IDENTITY).unwrap();
        builder.place(ball).unwrap();
        let accel = builder.build().unwrap();

        let ray = Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z);
        let mut hits = Vec::new();
        accel.every_hit(&ray, |hit| hits.push((hit.place(), (hit.t * 8.0).round())));
        hits.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(hits, [(0, 8.0), (1, 8.0), (2, 20.0), (2, 28.0)]);
        let mut count = 0;
        accel.every_hit(&Ray { tfar: 1.5, ..ray }, |_| count += 1);
        assert_eq!(count, 2);
    }
}
