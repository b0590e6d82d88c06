//! Samples where they help most, for a picture that is to stop at a noise.
//!
//! Whole tiles are doubled, never single pixels, and only where the picture's error can be lowered at the least cost: for a
//! given error that cost is least when every tile has samples in proportion to the square root of the variance of one.
//!
//! A decision that looks at the very samples that are kept is biased: a tile that has missed its rare bright paths so far
//! looks quiet, and stops too dark. Three rules keep that small: nothing is decided before [`LEAST_SPP`]; a decision looks
//! at the mean over a tile's 256 pixels; and no tile has less than half the samples of a neighbour.
//!
//! Decisions are made when all tiles are where the last one sent them, from sums that are exact: they are the same for any
//! number of threads, and after any interruption.

use std::collections::HashMap;

use super::noise::Noise;
use super::tile::{TILE_SIDE, Tile};

/// Samples per pixel before which nothing is decided.
pub const LEAST_SPP: u32 = 32;
/// Tiles whose best number of samples is this far above the present one are doubled: half of a doubling, in powers of two.
const WORTH: f64 = std::f64::consts::SQRT_2;
/// Halvings of the interval in which the common price of samples is looked for.
const STEPS: u32 = 60;

/// Sends tiles on, from sample index `first` and at most to `end`, that the picture's error may come down to `target`
/// (relative, as [`Noise::of_picture`]). False where nothing is left to do.
pub fn set_goals(tiles: &mut [Tile], first: u32, end: u32, target: f64) -> bool {
    let noise = Noise::of(tiles, first);
    if noise.of_picture(tiles) <= target {
        return false;
    }
    let factors = factors(tiles, &noise, [first, end], (target * noise.light).powi(2));
    let least = factors.iter().copied().fold(0.0, f64::max).min(WORTH);
    let mut goals: Vec<u32> = tiles
        .iter()
        .zip(&factors)
        .map(|(tile, &factor)| if factor >= least { doubled(tile.next, first, end) } else { tile.next })
        .collect();
    level(tiles, &mut goals, first, end);
    let mut any = false;
    for (tile, goal) in tiles.iter_mut().zip(goals) {
        any |= goal > tile.next;
        tile.goal = goal;
    }
    any
}

/// By how much the samples of each tile are to grow, at least 1, so that the mean variance becomes `wanted` at the least
/// cost. Tiles that have all their samples stay. Variance is taken to fall as 1 / n: where it falls faster, fewer will do, which the next
/// look shows.
fn factors(tiles: &[Tile], noise: &Noise, [first, end]: [u32; 2], wanted: f64) -> Vec<f64> {
    let pixels: f64 = tiles.iter().map(|tile| tile.sums.len() as f64).sum();
    // The gain of one more sample: V / n.
    let gain = |(tile, variance): (&Tile, &f64)| {
        if tile.next < end { variance / f64::from(tile.next - first) } else { 0.0 }
    };
    let gains: Vec<f64> = tiles.iter().zip(&noise.variances).map(gain).collect();
    let factor = |gain: f64, price: f64| (gain / price).sqrt().max(1.0);
    let (mut low, mut high) = (0.0, gains.iter().copied().fold(0.0, f64::max));
    for _ in 0..STEPS {
        let price = 0.5 * (low + high);
        let left: f64 = tiles
            .iter()
            .zip(&noise.variances)
            .zip(&gains)
            .map(|((tile, variance), &gain)| tile.sums.len() as f64 * variance / factor(gain, price))
            .sum();
        if left > wanted * pixels { high = price } else { low = price }
    }
    let price = if low > 0.0 { low } else { high };
    gains.into_iter().map(|gain| factor(gain, price)).collect()
}

fn doubled(next: u32, first: u32, end: u32) -> u32 {
    (first + 2 * (next - first)).min(end)
}

/// Raises goals to half of what the neighbours have, by doublings.
fn level(tiles: &[Tile], goals: &mut [u32], first: u32, end: u32) {
    let place = |tile: &Tile| [(tile.x0 / TILE_SIDE) as i64, (tile.y0 / TILE_SIDE) as i64];
    let at: HashMap<[i64; 2], usize> = tiles.iter().enumerate().map(|(i, tile)| (place(tile), i)).collect();
    let decided = goals.to_vec();
    for (tile, goal) in tiles.iter().zip(goals) {
        let [x, y] = place(tile);
        let around = (0..9).filter_map(|i| at.get(&[x + i % 3 - 1, y + i / 3 - 1]));
        let most = around.map(|&i| decided[i] - first).max().unwrap_or(0);
        if *goal - first < most / 2 {
            *goal = doubled(*goal, first, end);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::super::sums::Samples;
    use super::*;
    use crate::render::Doublings;
    use crate::scene::Window;

    /// Six tiles in a row of luminance 1 after 32 samples, the last one with a hundred times the variance.
    fn row() -> Vec<Tile> {
        let size = [6 * TILE_SIDE, TILE_SIDE];
        let mut tiles = Tile::grid(size, &Window::whole(size), 0..1000);
        for tile in &mut tiles {
            tile.next = LEAST_SPP;
            let change = if tile.x0 == 5 * TILE_SIDE { 1e-2 } else { 1e-4 };
            tile.doublings = Doublings { spp: LEAST_SPP, changes: [change, 2.0 * change], luminance: Vec::new() };
            let mut light = Samples::default();
            (0..LEAST_SPP).for_each(|_| assert!(light.add(Vec3::ONE)));
            (0..tile.sums.len()).for_each(|pixel| tile.sums.add_samples(pixel, &light));
        }
        tiles
    }

    fn goals(tiles: &[Tile]) -> Vec<u32> {
        let mut goals: Vec<_> = tiles.iter().map(|tile| (tile.x0, tile.goal)).collect();
        goals.sort_unstable();
        goals.into_iter().map(|(_, goal)| goal).collect()
    }

    #[test]
    fn samples_go_where_the_noise_is_and_neighbours_follow() {
        let mut tiles = row();
        // The variances' mean is 1.75e-3.
        assert!(!set_goals(&mut tiles, 0, 1000, 0.042));
        assert!(set_goals(&mut tiles, 0, 1000, 0.03));
        assert_eq!(goals(&tiles), [32, 32, 32, 32, 32, 64]);
        tiles.iter_mut().for_each(|tile| tile.next = tile.goal);
        assert!(set_goals(&mut tiles, 0, 1000, 0.02));
        assert_eq!(goals(&tiles), [32, 32, 32, 32, 64, 128]);
        // The most samples hold.
        assert!(set_goals(&mut tiles, 0, 100, 0.001));
        assert_eq!(goals(&tiles), [64, 64, 64, 64, 64, 100]);
    }
}
