//! The structs that cross the boundary by pointer, as the installed Embree lays them out (see `build.rs`).
//!
//! `embree4-sys` has the same names with the layout of Embree 4.2: there `RTCRayHit` is 80 bytes, while Embree 4.3 with
//! instance arrays writes `instPrimID` at bytes 80..84 of a 96-byte struct. Never pass `embree4-sys`'s own structs.

use std::mem::{align_of, offset_of, size_of};

use glam::Vec3;

mod installed {
    // Enums come with all their values.
    #![allow(non_snake_case, dead_code)]
    include!(concat!(env!("OUT_DIR"), "/embree_layout.rs"));
}

pub(super) use installed::{
    RTC_FEATURE_FLAG_ALL as ALL_FEATURES, RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER as ASK_FOR_EACH_HIT,
};
pub(super) use installed::{
    RTC_VERSION_MAJOR, RTC_VERSION_MINOR, RTCBounds, RTCFilterFunctionNArguments, RTCHit, RTCHit8,
    RTCIntersectArguments, RTCRay, RTCRay8, RTCRayHit, RTCRayHit8, RTCRayQueryContext,
};

/// Embree's "no such geometry", "no such instance".
pub(super) const INVALID_ID: u32 = u32::MAX;
/// Depth of the instance stack in `RTCHit`.
pub(super) const LEVELS: usize = installed::RTC_MAX_INSTANCE_LEVEL_COUNT as usize;

const _: () = {
    assert!(RTC_VERSION_MAJOR == 4, "pellicle needs Embree 4: run ./setup.sh");

    assert!(size_of::<RTCRay>() == 48 && align_of::<RTCRay>() == 16);
    assert!(offset_of!(RTCRay, org_x) == 0 && offset_of!(RTCRay, tnear) == 12);
    assert!(offset_of!(RTCRay, dir_x) == 16 && offset_of!(RTCRay, time) == 28);
    assert!(offset_of!(RTCRay, tfar) == 32 && offset_of!(RTCRay, mask) == 36);

    // 48 bytes with instance arrays (Embree 4.3 as Debian builds it), 32 without.
    assert!(align_of::<RTCHit>() == 16 && size_of::<RTCHit>() >= 28 + 4 * LEVELS);
    assert!(offset_of!(RTCHit, Ng_x) == 0 && offset_of!(RTCHit, u) == 12 && offset_of!(RTCHit, v) == 16);
    assert!(offset_of!(RTCHit, primID) == 20 && offset_of!(RTCHit, geomID) == 24 && offset_of!(RTCHit, instID) == 28);

    assert!(offset_of!(RTCRayHit, ray) == 0 && offset_of!(RTCRayHit, hit) == size_of::<RTCRay>());
    assert!(size_of::<RTCRayHit>() == size_of::<RTCRay>() + size_of::<RTCHit>() && align_of::<RTCRayHit>() == 16);

    // Packets hold eight of each number, aligned for 256-bit registers.
    assert!(size_of::<RTCRay8>() == 12 * 32 && align_of::<RTCRay8>() == 32);
    assert!(offset_of!(RTCRay8, tnear) == 3 * 32 && offset_of!(RTCRay8, dir_x) == 4 * 32);
    assert!(offset_of!(RTCRay8, tfar) == 8 * 32 && offset_of!(RTCRay8, flags) == 11 * 32);
    assert!(size_of::<RTCHit8>() >= (7 + LEVELS) * 32 && align_of::<RTCHit8>() == 32);
    assert!(offset_of!(RTCHit8, u) == 3 * 32 && offset_of!(RTCHit8, primID) == 5 * 32);
    assert!(offset_of!(RTCHit8, geomID) == 6 * 32 && offset_of!(RTCHit8, instID) == 7 * 32);
    assert!(offset_of!(RTCRayHit8, ray) == 0 && offset_of!(RTCRayHit8, hit) == size_of::<RTCRay8>());
    assert!(size_of::<RTCRayHit8>() == size_of::<RTCRay8>() + size_of::<RTCHit8>() && align_of::<RTCRayHit8>() == 32);

    assert!(size_of::<RTCBounds>() == 32 && align_of::<RTCBounds>() == 16 && offset_of!(RTCBounds, upper_x) == 16);

    // Vertex and index buffers are handed over as they are.
    assert!(size_of::<Vec3>() == 12 && size_of::<[u32; 3]>() == 12);
};
