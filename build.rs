//! Reads the struct layouts of the installed Embree 4.
//!
//! `embree4-sys` brings headers of its own (Embree 4.2), whose `RTCRayHit` is 16 bytes shorter than what newer libraries
//! write. So the structs that cross the boundary by pointer are generated from the header that is installed beside the
//! library; `src/embree/layout.rs` checks them.

use std::{env, panic, path::PathBuf, process::ExitCode};

const STRUCTS: [&str; 9] = [
    "RTCRay",
    "RTCHit",
    "RTCRayHit",
    "RTCRay8",
    "RTCHit8",
    "RTCRayHit8",
    "RTCBounds",
    "RTCIntersectArguments",
    "RTCFilterFunctionNArguments",
];
const NUMBERS: [&str; 3] = ["RTC_VERSION_MAJOR", "RTC_VERSION_MINOR", "RTC_MAX_INSTANCE_LEVEL_COUNT"];

fn main() -> ExitCode {
    println!("cargo::rerun-if-changed=build.rs");
    match generate() {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            for line in reason.lines() {
                println!("cargo::error={line}");
            }
            println!("cargo::error=run ./setup.sh, which installs what is missing, and build again");
            ExitCode::FAILURE
        }
    }
}

fn generate() -> Result<(), String> {
    // bindgen panics where it cannot load libclang; asking for the version is the cheapest way to find out.
    panic::catch_unwind(bindgen::clang_version)
        .map_err(|_| "libclang, which bindgen needs to read Embree's header, was not found".to_string())?;

    let mut builder = bindgen::Builder::default()
        .header_contents("pellicle_embree.h", "#include <embree4/rtcore.h>")
        .parse_callbacks(Box::new(bindgen::CargoCallbacks::new()))
        .derive_default(true)
        .prepend_enum_name(false)
        .layout_tests(false);
    for name in STRUCTS {
        builder = builder.allowlist_type(name);
    }
    for name in NUMBERS {
        builder = builder.allowlist_var(name);
    }
    let layout = builder
        .generate()
        .map_err(|error| format!("Embree 4's header <embree4/rtcore.h> is missing or cannot be read: {error}"))?;

    let folder = env::var_os("OUT_DIR").ok_or("cargo sets OUT_DIR for build scripts; run this through cargo")?;
    let path = PathBuf::from(folder).join("embree_layout.rs");
    layout.write_to_file(&path).map_err(|error| format!("cannot write {}: {error}", path.display()))
}
