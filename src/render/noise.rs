//! How noisy a picture is, from its own samples.

use super::doublings::{decay, luminance};
use super::tile::Tile;

/// Darker pixels are judged as if they had this share of the mean luminance.
const DARKEST: f64 = 0.1;

/// Estimated errors of a picture's luminance, with what they are made of.
pub struct Noise {
    /// Of each tile, the mean over its pixels of the variance of their means; infinite below two samples.
    pub variances: Vec<f64>,
    /// Mean luminance of the picture.
    pub light: f64,
}

impl Noise {
    /// Of the samples from index `first` on.
    pub fn of(tiles: &[Tile], first: u32) -> Self {
        let decay = decay(tiles.iter().map(|tile| (&tile.doublings, tile.sums.len() as f64)));
        let (mut light, mut pixels) = (0.0, 0);
        let mut variances = Vec::with_capacity(tiles.len());
        for tile in tiles {
            let spp = tile.next - first;
            pixels += tile.sums.len();
            light += luminances(tile, spp).sum::<f64>();
            let variance = tile.doublings.variance(spp, decay);
            variances.push(if variance.is_finite() { variance } else { independent(tile, spp) });
        }
        Self { variances, light: light / pixels.max(1) as f64 }
    }

    /// Root mean square of the errors of all pixels, over the mean luminance.
    pub fn of_picture(&self, tiles: &[Tile]) -> f64 {
        let weighed = tiles.iter().zip(&self.variances).map(|(tile, variance)| (tile.sums.len() as f64, variance));
        let (pixels, squares) = weighed.fold((0.0, 0.0), |(n, sum), (len, variance)| (n + len, sum + len * variance));
        // A black picture without spread is exact.
        if squares == 0.0 { 0.0 } else { (squares / pixels).sqrt() / self.light }
    }

    /// The relative error that 95 % of the pixels stay below, each with its tile's error against its own luminance or a
    /// tenth of the picture's mean, whichever is more.
    pub fn p95(&self, tiles: &[Tile], first: u32) -> f64 {
        let mut errors = Vec::new();
        for (tile, variance) in tiles.iter().zip(&self.variances) {
            let relative = |light: f64| {
                if *variance == 0.0 { 0.0 } else { variance.sqrt() / light.max(DARKEST * self.light) }
            };
            errors.extend(luminances(tile, tile.next - first).map(relative));
        }
        if errors.is_empty() {
            return 0.0;
        }
        let rank = (errors.len() * 95).div_ceil(100) - 1;
        *errors.select_nth_unstable_by(rank, f64::total_cmp).1
    }
}

fn luminances(tile: &Tile, spp: u32) -> impl Iterator<Item = f64> + '_ {
    (0..tile.sums.len()).map(move |pixel| luminance(tile.sums.means(pixel, spp)))
}

/// Mean variance of a tile whose doublings are not known, as if its samples were independent and its channels rose and fell
/// together: too much, never too little.
fn independent(tile: &Tile, spp: u32) -> f64 {
    let of_pixel = |pixel| luminance(tile.sums.variances(pixel, spp).map(f64::sqrt)).powi(2);
    (0..tile.sums.len()).map(of_pixel).sum::<f64>() / tile.sums.len() as f64
}
