//! A finished picture with what it cost.

use sha2::{Digest, Sha256};

use crate::integrate::Tally;
use crate::math::hex;
use crate::scene::Window;

/// Mean radiance per pixel, row by row from the upper left, linear sRGB.
pub struct Frame {
    pub width: u32,
    pub height: u32,
    /// The whole picture's, and where in it this is.
    pub size: [u32; 2],
    pub window: Window,
    /// Samples that every pixel has; where the render was stopped, or its samples went where they help most, some have more.
    pub spp: u32,
    /// Samples of all pixels together.
    pub total: u64,
    /// Samples that each pixel has.
    pub samples: Vec<u32>,
    pub rgb: Vec<[f32; 3]>,
    /// Variance of each pixel's mean, per channel, as if its samples were independent; infinite below two samples. Empty
    /// where it was not asked for.
    pub variance: Vec<[f32; 3]>,
    /// Estimated error of the picture: root mean square of the standard errors of its pixels' luminances, over their mean
    /// (`doublings.rs`). Infinite below two samples.
    pub noise: f64,
    /// The relative standard error that 95 % of the pixels stay below, each with the error of its surroundings against its
    /// own luminance or a tenth of the picture's mean, whichever is more.
    pub noise_p95: f64,
    /// The part of each light group, where they are told apart.
    pub groups: Vec<Vec<[f32; 3]>>,
    pub tally: Tally,
    pub threads: usize,
    /// Wall and user + system seconds of rendering alone.
    pub render_s: f64,
    pub render_cpu_s: f64,
}

impl Frame {
    /// Samples per pixel on average.
    pub fn mean_spp(&self) -> f64 {
        let total: u64 = self.samples.iter().map(|&spp| u64::from(spp)).sum();
        total as f64 / self.samples.len() as f64
    }

    /// SHA-256 over the size (two u32) and all values of [`rgb`](Self::rgb) (f32), little-endian; hexadecimal.
    pub fn sha256(&self) -> String {
        let mut hash = Sha256::new();
        hash.update([self.width.to_le_bytes(), self.height.to_le_bytes()].concat());
        for row in self.rgb.chunks(self.width.max(1) as usize) {
            let bytes: Vec<u8> = row.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
            hash.update(bytes);
        }
        hex(&hash.finalize())
    }
}
