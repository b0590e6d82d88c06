//! A finished picture with what it cost.

use super::tile::Tile;
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
    pub(super) fn resolve(
        [width, height]: [u32; 2],
        tiles: Vec<Tile>,
        tally: Tally,
        threads: usize,
        render_s: f64,
        render_cpu_s: f64,
    ) -> Self {
        let count = width as usize * height as usize;
        let mut rgb = vec![[0.0; 3]; count];
        let mut variance = vec![[f32::INFINITY; 3]; count];
        let spp = tiles.iter().map(|tile| tile.spp).min().unwrap_or(0);
        for tile in tiles {
            // A tile that was never reached stays black.
            let n = f64::from(tile.spp.max(1));
            for (i, pixel) in tile.pixels.iter().enumerate() {
                let (x, y) = (tile.x0 + i as u32 % tile.width, tile.y0 + i as u32 / tile.width);
                let index = y as usize * width as usize + x as usize;
                for channel in 0..3 {
                    let mean = pixel.sum[channel] / n;
                    rgb[index][channel] = mean as f32;
                    if tile.spp > 1 {
                        let spread = (pixel.sum_squares[channel] / n - mean * mean).max(0.0);
                        variance[index][channel] = (spread / (n - 1.0)) as f32;
                    }
                }
            }
        }
        Self { width, height, spp, rgb, variance, tally, threads, render_s, render_cpu_s }
    }
}
