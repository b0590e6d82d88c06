//! Owned Embree objects: device, scene, geometry. Each releases its reference when dropped.

use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr;
use std::sync::{Mutex, PoisonError};

use embree4_sys as sys;

use super::error::EmbreeError;
use super::layout::{RTC_VERSION_MAJOR, RTC_VERSION_MINOR};

/// The Embree that this program was built for, "4.3".
pub fn version() -> String {
    format!("{RTC_VERSION_MAJOR}.{RTC_VERSION_MINOR}")
}

/// The first error since the last look, written by Embree from any of its threads.
type ErrorSlot = Mutex<Option<String>>;

pub(super) struct Device {
    raw: sys::RTCDevice,
    /// Embree keeps its address until the device is released.
    errors: Box<ErrorSlot>,
}

impl Device {
    /// `threads` builds BVHs in parallel; 0 means all of the machine.
    pub(super) fn new(threads: usize) -> Result<Self, EmbreeError> {
        let config = CString::new(format!("threads={threads}"))
            .map_err(|error| EmbreeError::Start { reason: error.to_string() })?;
        // SAFETY: the string ends with NUL and lives through the call.
        let raw = unsafe { sys::rtcNewDevice(config.as_ptr()) };
        if raw.is_null() {
            // SAFETY: a null device asks for this thread's error. The codes beyond the enum belong to SYCL devices,
            // which only rtcNewSYCLDevice makes.
            let code = unsafe { sys::rtcGetDeviceError(ptr::null_mut()) };
            return Err(EmbreeError::Start { reason: describe(code).to_string() });
        }
        let device = Self { raw, errors: Box::default() };
        let slot: *const ErrorSlot = &*device.errors;
        // SAFETY: the slot lives in a box that `device` owns and that is dropped after the device is released; it is
        // Sync, so any thread of Embree may write to it.
        unsafe { sys::rtcSetDeviceErrorFunction(raw, Some(note_error), slot.cast_mut().cast()) };
        device.check_version()?;
        Ok(device)
    }

    /// A library with another minor version may write longer structs than we hand it.
    fn check_version(&self) -> Result<(), EmbreeError> {
        // SAFETY: the device is alive.
        let property = |property| unsafe { sys::rtcGetDeviceProperty(self.raw, property) };
        let major = property(sys::RTCDeviceProperty::VERSION_MAJOR);
        let minor = property(sys::RTCDeviceProperty::VERSION_MINOR);
        let found = format!("{major}.{minor}");
        if found == version() { Ok(()) } else { Err(EmbreeError::Version { built: version(), found }) }
    }

    /// Fails if Embree reported an error since the last check.
    pub(super) fn check(&self, task: &'static str) -> Result<(), EmbreeError> {
        match self.errors.lock().unwrap_or_else(PoisonError::into_inner).take() {
            None => Ok(()),
            Some(reason) => Err(EmbreeError::Embree { task, reason }),
        }
    }

    pub(super) fn geometry(&self, kind: sys::RTCGeometryType) -> Result<Geometry, EmbreeError> {
        // SAFETY: the device is alive.
        let raw = unsafe { sys::rtcNewGeometry(self.raw, kind) };
        self.check("create a geometry")?;
        Ok(Geometry(raw))
    }

    pub(super) fn scene(&self) -> Result<Scene, EmbreeError> {
        // SAFETY: the device is alive.
        let raw = unsafe { sys::rtcNewScene(self.raw) };
        self.check("create a scene")?;
        Ok(Scene(raw))
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: `raw` is ours and released once. Scenes and geometries that outlive this handle keep the device alive
        // inside Embree, so it is told to forget the slot first.
        unsafe {
            sys::rtcSetDeviceErrorFunction(self.raw, None, ptr::null_mut());
            sys::rtcReleaseDevice(self.raw);
        }
    }
}

/// Embree's error callback: `slot` is the device's [`ErrorSlot`].
// SAFETY: only Embree calls it, with the slot that was registered and a text that ends in 0.
unsafe extern "C" fn note_error(slot: *mut c_void, code: sys::RTCError, text: *const c_char) {
    // SAFETY: `Device` registered the slot and outlives its registration.
    let slot = unsafe { &*slot.cast_const().cast::<ErrorSlot>() };
    let detail = if text.is_null() {
        String::new()
    } else {
        // SAFETY: Embree passes a NUL-terminated string that lives through the call.
        unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned()
    };
    let reason = if detail.is_empty() { describe(code).to_string() } else { format!("{}: {detail}", describe(code)) };
    slot.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(reason);
}

fn describe(code: sys::RTCError) -> &'static str {
    match code {
        sys::RTCError::NONE => "no error",
        sys::RTCError::UNKNOWN => "unknown error",
        sys::RTCError::INVALID_ARGUMENT => "invalid argument",
        sys::RTCError::INVALID_OPERATION => "invalid operation",
        sys::RTCError::OUT_OF_MEMORY => "out of memory",
        sys::RTCError::UNSUPPORTED_CPU => "this processor is not supported",
        sys::RTCError::CANCELLED => "cancelled",
    }
}

pub(super) struct Geometry(sys::RTCGeometry);

impl Geometry {
    pub(super) fn raw(&self) -> sys::RTCGeometry {
        self.0
    }
}

impl Drop for Geometry {
    fn drop(&mut self) {
        // SAFETY: ours, released once; scenes that hold it keep their own reference.
        unsafe { sys::rtcReleaseGeometry(self.0) };
    }
}

pub(super) struct Scene(sys::RTCScene);

impl Scene {
    pub(super) fn raw(&self) -> sys::RTCScene {
        self.0
    }
}

impl Drop for Scene {
    fn drop(&mut self) {
        // SAFETY: ours, released once.
        unsafe { sys::rtcReleaseScene(self.0) };
    }
}
