//! A finished picture with what it cost.

use sha2::{Digest, Sha256};

use crate::integrate::Tally;

/// Mean radiance per pixel, row by row from the upper left, linear sRGB.
pub struct Frame {
    pub width: u32,
    pub height: u32,
    /// Samples that every pixel has; where the render was stopped, some have a few more.
    pub spp: u32,
    pub rgb: Vec<[f32; 3]>,
    /// Variance of each pixel's mean, per channel; infinite below two samples.
    pub variance: Vec<[f32; 3]>,
    pub tally: Tally,
    pub threads: usize,
    /// Wall and user + system seconds of rendering alone.
    pub render_s: f64,
    pub render_cpu_s: f64,
}

impl Frame {
    /// SHA-256 over the size (two u32) and all values of [`rgb`](Self::rgb) (f32), little-endian; hexadecimal.
    pub fn sha256(&self) -> String {
        let mut hash = Sha256::new();
        hash.update([self.width.to_le_bytes(), self.height.to_le_bytes()].concat());
        for row in self.rgb.chunks(self.width.max(1) as usize) {
            let bytes: Vec<u8> = row.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
            hash.update(bytes);
        }
        hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}
