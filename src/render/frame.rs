//! A finished picture with what it cost.

use super::noise;
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
    /// Estimated error of the picture: root mean square of the standard errors of its pixels' luminances, over their mean.
    /// Samples count as independent; as they are stratified, the true error is lower. Infinite below two samples.
    pub fn noise(&self) -> f64 {
        noise::of_picture(self.estimates())
    }

    /// The relative standard error that 95 % of the pixels stay below, each against its own luminance or a tenth of the
    /// picture's mean, whichever is more.
    pub fn noise_p95(&self) -> f64 {
        noise::p95(self.estimates())
    }

    fn estimates(&self) -> impl Iterator<Item = [(f64, f64); 3]> + Clone + '_ {
        let pair = |(mean, variance): (&[f32; 3], &[f32; 3])| {
            std::array::from_fn(|channel| (f64::from(mean[channel]), f64::from(variance[channel])))
        };
        self.rgb.iter().zip(&self.variance).map(pair)
    }

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
            for (i, pixel) in tile.pixels.iter().enumerate() {
                let (x, y) = (tile.x0 + i as u32 % tile.width, tile.y0 + i as u32 / tile.width);
                let index = y as usize * width as usize + x as usize;
                for (channel, (mean, spread)) in pixel.estimate(tile.spp).into_iter().enumerate() {
                    rgb[index][channel] = mean as f32;
                    variance[index][channel] = spread as f32;
                }
            }
        }
        Self { width, height, spp, rgb, variance, tally, threads, render_s, render_cpu_s }
    }
}
