//! Denoising by Intel's Open Image Denoise, where a user has it: looked up when the program runs, never linked.
//!
//! This room and `embree` alone hold unsafe code, for the same reason: they speak to C. What comes out has no promise of
//! equal bits between machines or versions; the noisy picture is what is measured and compared.

#![allow(unsafe_code)]

mod filter;
mod library;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use glam::{Mat3, Vec3};
use library::Library;
use thiserror::Error;

/// The environment variable that names the library, where no option does.
pub const LIBRARY_VARIABLE: &str = "PELLICLE_OIDN_LIB";

/// Linear sRGB to linear Rec. 2020 (ITU-R BT.2087), column by column: the network knows no negative colours, and films make
/// colours that have none there.
const TO_REC2020: Mat3 = Mat3::from_cols_array(&[
    0.627_403_9,
    0.069_097_29,
    0.016_391_44,
    0.329_283_04,
    0.919_540_4,
    0.088_013_31,
    0.043_313_066,
    0.011_362_316,
    0.895_595_25,
]);

#[derive(Debug, Error)]
pub enum DenoiseError {
    #[error(
        "cannot denoise: {reason}; get Open Image Denoise 1.4 or 2.x from openimagedenoise.org (or `pip install pyoidn`), and name its library by --denoise=FILE or ${LIBRARY_VARIABLE}"
    )]
    Library { reason: String },
    #[error("cannot denoise: {version} says: {reason}")]
    Failed { version: String, reason: String },
}

/// A picture and what its pixels show; `width * height` values each, row by row.
pub struct Noisy<'a> {
    pub width: usize,
    pub height: usize,
    /// Linear sRGB, of any brightness.
    pub rgb: &'a [[f32; 3]],
    /// Linear sRGB within 0..1.
    pub albedo: Vec<Vec3>,
    /// Up to unit length; zero where there is no surface.
    pub normal: Vec<Vec3>,
}

/// The library, loaded.
pub struct Denoiser {
    library: Library,
}

impl Denoiser {
    /// Loads `file`, else what [`LIBRARY_VARIABLE`] names, else what the system knows as `libOpenImageDenoise.so.2` or `.1`.
    ///
    /// # Errors
    /// There is no such library, or it is another one.
    pub fn load(file: Option<&Path>) -> Result<Self, DenoiseError> {
        let named = file.map(PathBuf::from).or_else(|| std::env::var_os(LIBRARY_VARIABLE).map(PathBuf::from));
        let usual = || ["libOpenImageDenoise.so.2", "libOpenImageDenoise.so.1"].map(OsString::from).to_vec();
        let names = named.map_or_else(usual, |path| vec![path.into_os_string()]);
        let mut reasons = Vec::new();
        for name in names {
            match Library::open(Path::new(&name)) {
                Ok(library) => return Ok(Self { library }),
                Err(reason) => reasons.push(reason),
            }
        }
        Err(DenoiseError::Library { reason: reasons.join("; ") })
    }

    /// `Open Image Denoise 2.3.0`.
    pub fn version(&self) -> String {
        let [major, minor, patch] = self.library.version();
        format!("Open Image Denoise {major}.{minor}.{patch}")
    }

    /// The picture without its noise, linear sRGB. Albedo and normals are denoised first, as the library's makers advise for
    /// final pictures. `threads`: 0 = all.
    ///
    /// # Errors
    /// What the library says.
    pub fn denoise(&self, noisy: Noisy, threads: usize) -> Result<Vec<[f32; 3]>, DenoiseError> {
        let failed = |reason| DenoiseError::Failed { version: self.version(), reason };
        let Noisy { width, height, rgb, albedo, normal } = noisy;
        let size = [width, height];
        let device = self.library.device(threads).map_err(failed)?;
        let wide = |rgb: Vec3| (TO_REC2020 * rgb).max(Vec3::ZERO).to_array();
        let color: Vec<[f32; 3]> = rgb.iter().map(|&rgb| wide(rgb.into())).collect();
        let albedo: Vec<[f32; 3]> = albedo.into_iter().map(wide).collect();
        let normal: Vec<[f32; 3]> = normal.iter().map(Vec3::to_array).collect();
        let albedo = device.filter(size, &[(c"albedo", &albedo)], &[]).map_err(failed)?;
        let normal = device.filter(size, &[(c"normal", &normal)], &[]).map_err(failed)?;
        let images = [(c"color", &color), (c"albedo", &albedo), (c"normal", &normal)];
        let clean = device.filter(size, &images, &[c"hdr", c"cleanAux"]).map_err(failed)?;
        let back = TO_REC2020.inverse();
        Ok(clean.into_iter().map(|rgb| (back * Vec3::from(rgb)).to_array()).collect())
    }
}
