//! One run of the library's filter for ray-traced pictures.

use std::ffi::{CStr, c_int};

use super::library::{Device, Handle};

/// `OIDN_FORMAT_FLOAT3`.
const FLOAT3: c_int = 3;

/// A filter that is released at the end, whatever happens.
struct Filter<'d> {
    device: &'d Device<'d>,
    handle: Handle,
}

impl Device<'_> {
    /// Filters the first of the named images with the help of the others; `flags` are set to true.
    pub(super) fn filter(
        &self,
        [width, height]: [usize; 2],
        images: &[(&CStr, &Vec<[f32; 3]>)],
        flags: &[&CStr],
    ) -> Result<Vec<[f32; 3]>, String> {
        let library = self.library;
        let mut output = vec![[0.0f32; 3]; width * height];
        if let Some((name, image)) = images.iter().find(|(_, image)| image.len() != output.len()) {
            return Err(format!("{} pixels of {name:?} for {width}x{height}", image.len()));
        }
        // SAFETY: the handle is a device, the name a C string; a null pointer is checked for.
        let handle = unsafe { (library.new_filter)(self.handle, c"RT".as_ptr()) };
        if handle.is_null() {
            self.check()?;
            return Err("it has no filter for ray-traced pictures".to_owned());
        }
        let filter = Filter { device: self, handle };
        for (name, image) in images {
            // SAFETY: `width * height` tight triples of floats that live until the filter has run. The library only reads
            // its inputs, though C has no way to say so.
            unsafe {
                let pixels = image.as_ptr().cast_mut().cast();
                (library.set_image)(filter.handle, name.as_ptr(), pixels, FLOAT3, width, height, 0, 0, 0);
            }
        }
        // SAFETY: as before, and ours to write: nothing else refers to it while the filter runs.
        unsafe {
            let pixels = output.as_mut_ptr().cast();
            (library.set_image)(filter.handle, c"output".as_ptr(), pixels, FLOAT3, width, height, 0, 0, 0);
        }
        for flag in flags {
            // SAFETY: the handle is a filter, the name a C string.
            unsafe { (library.set_bool)(filter.handle, flag.as_ptr(), true) };
        }
        // SAFETY: the handle is a filter with all its images; execution returns when the output is written.
        unsafe {
            (library.commit_filter)(filter.handle);
            (library.execute_filter)(filter.handle);
        }
        drop(filter);
        self.check()?;
        Ok(output)
    }
}

impl Drop for Filter<'_> {
    fn drop(&mut self) {
        // SAFETY: the handle is a filter that nothing uses any longer.
        unsafe { (self.device.library.release_filter)(self.handle) };
    }
}
