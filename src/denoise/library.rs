//! The library's functions, found by their names. Versions 1.x and 2.x differ in a few of them.

use std::ffi::{CStr, c_char, c_int, c_void};
use std::path::{Path, PathBuf};

use libloading::os::unix::{Library as Loaded, RTLD_GLOBAL, RTLD_NOW};

/// The library's opaque objects.
pub(super) type Handle = *mut c_void;

/// `OIDN_DEVICE_TYPE_CPU`: the pictures lie in its memory.
const CPU: c_int = 1;

// SAFETY: these are the types of OIDN's C headers; they promise nothing until a function of theirs is called.
type NewDevice = unsafe extern "C" fn(c_int) -> Handle;
type Act = unsafe extern "C" fn(Handle);
type GetInt = unsafe extern "C" fn(Handle, *const c_char) -> c_int;
type SetInt = unsafe extern "C" fn(Handle, *const c_char, c_int);
type SetBool = unsafe extern "C" fn(Handle, *const c_char, bool);
type GetError = unsafe extern "C" fn(Handle, *mut *const c_char) -> c_int;
type NewFilter = unsafe extern "C" fn(Handle, *const c_char) -> Handle;
/// Name, pixels, format, width, height, offset of the first byte, bytes from pixel to pixel, from row to row.
type SetImage = unsafe extern "C" fn(Handle, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize);

pub(super) struct Library {
    new_device: NewDevice,
    set_device_int: SetInt,
    get_device_int: GetInt,
    commit_device: Act,
    release_device: Act,
    pub(super) get_error: GetError,
    pub(super) new_filter: NewFilter,
    pub(super) set_image: SetImage,
    pub(super) set_bool: SetBool,
    pub(super) commit_filter: Act,
    pub(super) execute_filter: Act,
    pub(super) release_filter: Act,
    version: [i32; 3],
    /// The functions above live in it.
    _loaded: Loaded,
    /// What it leans on.
    _threading: Option<Loaded>,
}

/// One device of the library.
pub(super) struct Device<'l> {
    pub(super) library: &'l Library,
    pub(super) handle: Handle,
}

impl Library {
    /// The error tells what is missing.
    pub(super) fn open(path: &Path) -> Result<Self, String> {
        let threading = threading_beside(path).and_then(|path| load(&path).ok());
        let loaded = load(path)?;
        // SAFETY: each type above is that of the function of these names in OIDN's C headers, versions 1.4 and 2.x; a file in
        // which all of them are found is that library.
        let library = unsafe {
            Self {
                new_device: find(&loaded, &[c"oidnNewDevice"])?,
                set_device_int: find(&loaded, &[c"oidnSetDeviceInt", c"oidnSetDevice1i"])?,
                get_device_int: find(&loaded, &[c"oidnGetDeviceInt", c"oidnGetDevice1i"])?,
                commit_device: find(&loaded, &[c"oidnCommitDevice"])?,
                release_device: find(&loaded, &[c"oidnReleaseDevice"])?,
                get_error: find(&loaded, &[c"oidnGetDeviceError"])?,
                new_filter: find(&loaded, &[c"oidnNewFilter"])?,
                set_image: find(&loaded, &[c"oidnSetSharedFilterImage"])?,
                set_bool: find(&loaded, &[c"oidnSetFilterBool", c"oidnSetFilter1b"])?,
                commit_filter: find(&loaded, &[c"oidnCommitFilter"])?,
                execute_filter: find(&loaded, &[c"oidnExecuteFilter"])?,
                release_filter: find(&loaded, &[c"oidnReleaseFilter"])?,
                version: [0; 3],
                _loaded: loaded,
                _threading: threading,
            }
        };
        let version = library.device(0)?.version();
        let [major, minor, patch] = version;
        if !((1, 4)..(3, 0)).contains(&(major, minor)) {
            return Err(format!("{} is version {major}.{minor}.{patch}, and 1.4 to 2.x are known", path.display()));
        }
        Ok(Self { version, ..library })
    }

    pub(super) fn version(&self) -> [i32; 3] {
        self.version
    }

    /// A device with so many threads; 0 = all.
    pub(super) fn device(&self, threads: usize) -> Result<Device<'_>, String> {
        // SAFETY: the function makes a device of a known type, or gives a null pointer.
        let handle = unsafe { (self.new_device)(CPU) };
        if handle.is_null() {
            return Err("it has no device for this processor".to_owned());
        }
        let device = Device { library: self, handle };
        if threads > 0 {
            // SAFETY: the handle is a device that is not yet committed, the name a C string.
            unsafe { (self.set_device_int)(handle, c"numThreads".as_ptr(), threads as c_int) };
        }
        // SAFETY: the handle is a device.
        unsafe { (self.commit_device)(handle) };
        device.check()?;
        Ok(device)
    }
}

impl Device<'_> {
    fn version(&self) -> [i32; 3] {
        // SAFETY: the handle is a committed device, the name a C string.
        let number = unsafe { (self.library.get_device_int)(self.handle, c"version".as_ptr()) };
        [number / 10_000, number / 100 % 100, number % 100]
    }

    /// The first thing that went wrong since the last look, if any.
    pub(super) fn check(&self) -> Result<(), String> {
        let mut message: *const c_char = std::ptr::null();
        // SAFETY: the handle is a device; the library writes a pointer to a string that lives until the next call.
        let code = unsafe { (self.library.get_error)(self.handle, &mut message) };
        if code == 0 {
            return Ok(());
        }
        if message.is_null() {
            return Err(format!("error {code}"));
        }
        // SAFETY: not null, and as above.
        Err(unsafe { CStr::from_ptr(message) }.to_string_lossy().into_owned())
    }
}

impl Drop for Device<'_> {
    fn drop(&mut self) {
        // SAFETY: the handle is a device that nothing uses any longer: filters borrow it.
        unsafe { (self.library.release_device)(self.handle) };
    }
}

fn load(path: &Path) -> Result<Loaded, String> {
    // SAFETY: loading runs the code of a library by a name that is OIDN's or that the user gave; OIDN and TBB set up nothing
    // there that other code could trip over.
    unsafe { Loaded::open(Some(path), RTLD_NOW | RTLD_GLOBAL) }.map_err(|error| error.to_string())
}

/// PyPI's package brings its threading library along under a name that the loader does not look for: once it is loaded, the
/// loader knows it by its own.
fn threading_beside(path: &Path) -> Option<PathBuf> {
    let entries = std::fs::read_dir(path.parent().filter(|folder| !folder.as_os_str().is_empty())?).ok()?;
    let is_threading = |path: &PathBuf| {
        path.file_name().and_then(|name| name.to_str()).is_some_and(|name| name.starts_with("libtbb.so.12"))
    };
    entries.flatten().map(|entry| entry.path()).find(is_threading)
}

/// The first of the functions of these names.
///
/// # Safety
/// `F` must be the type of all of them.
unsafe fn find<F: Copy>(loaded: &Loaded, names: &[&CStr]) -> Result<F, String> {
    for name in names {
        // SAFETY: the caller's promise.
        if let Ok(function) = unsafe { loaded.get::<F>(name.to_bytes_with_nul()) } {
            return Ok(*function);
        }
    }
    let names: Vec<_> = names.iter().map(|name| name.to_string_lossy()).collect();
    Err(format!("a library without {} is not Open Image Denoise", names.join(" or ")))
}
