//! What light paths bring to the pixels of a picture ([`Throw`]).
//!
//! Round `i` of them belongs to sample `i` of every pixel: a sample is what the pixel's own path finds and what the light paths
//! of its round bring there. So it depends on pixel and index alone, as without them.

use rayon::prelude::*;

use super::Plan;
use super::tile::{TILE_SIDE, Tile};
use crate::embree::BATCH;
use crate::integrate::{Landing, Tally, Throw};
use crate::mode::Mode;
use crate::scene::Scene;

/// Light paths that are followed at once, or a round of them where that is more.
const AT_ONCE: u32 = 1 << 18;

/// Rounds that are followed at once.
pub fn rounds_at_once(throw: &Throw) -> u32 {
    (AT_ONCE / throw.count).max(1)
}

/// What a light path adds to a sample of a pixel.
pub struct Splat<M: Mode> {
    /// Number of the tile, of its pixel, and of the sample.
    at: (u32, u32, u32),
    pub radiance: M::Light,
    pub waves: M::Waves,
}

/// Of some rounds, in the order of tiles, pixels and samples.
pub struct Splats<M: Mode>(Vec<Splat<M>>);

impl<M: Mode> Splats<M> {
    pub const NONE: Self = Self(Vec::new());

    /// Follows rounds of light paths, given in ascending order; what lands outside of the tiles is lost.
    pub fn of_rounds(
        scene: &Scene<M>,
        plan: &Plan,
        throw: &Throw,
        ([width, height], tiles): ([u32; 2], &[Tile]),
        rounds: &[u32],
    ) -> (Self, Tally) {
        let columns = width.div_ceil(TILE_SIDE);
        let mut numbers = vec![u32::MAX; (columns * height.div_ceil(TILE_SIDE)) as usize];
        for (number, tile) in (0u32..).zip(tiles) {
            numbers[(tile.y0 / TILE_SIDE * columns + tile.x0 / TILE_SIDE) as usize] = number;
        }
        let splat = |round: u32, landing: Landing<M>| {
            let (x, across) = plan.filter.pick(landing.at.x, landing.u[0]);
            let (y, down) = plan.filter.pick(landing.at.y, landing.u[1]);
            let inside = x >= 0 && y >= 0 && (x as u32) < width && (y as u32) < height;
            let [x, y] = [x as u32, y as u32];
            let number = *numbers.get(inside.then_some((y / TILE_SIDE * columns + x / TILE_SIDE) as usize)?)?;
            let tile = tiles.get(number as usize)?;
            let pixel = (y - tile.y0) * tile.width + x - tile.x0;
            Some(Splat {
                at: (number, pixel, round),
                radiance: landing.radiance * (across * down),
                waves: landing.waves,
            })
        };
        let batches = throw.count.div_ceil(BATCH as u32) as usize;
        let paths = |mut all: (Vec<Splat<M>>, Tally), batch: usize| {
            let (round, first) = (rounds[batch / batches], (batch % batches * BATCH) as u32);
            let numbers = first..(first + BATCH as u32).min(throw.count);
            throw.follow(scene, &plan.limits, (round, numbers, plan.seed), &mut all.1, |landing| {
                all.0.extend(splat(round, landing));
            });
            all
        };
        let empty = || (Vec::new(), Tally::default());
        let (mut splats, tally) =
            (0..rounds.len() * batches).into_par_iter().fold(empty, paths).reduce(empty, |mut a, b| {
                a.0.extend(b.0);
                a.1 += b.1;
                a
            });
        // Stable: sums of a sample have one order, too.
        splats.par_sort_by_key(|splat| splat.at);
        (Self(splats), tally)
    }

    /// Those of a tile.
    pub fn of_tile(&self, number: usize) -> SplatsOfTile<'_, M> {
        let of = |number: u32| self.0.partition_point(|splat| splat.at.0 < number);
        SplatsOfTile(&self.0[of(number as u32)..of(number as u32 + 1)])
    }
}

/// Of some rounds, in the order of pixels and samples.
pub struct SplatsOfTile<'a, M: Mode>(&'a [Splat<M>]);

impl<'a, M: Mode> SplatsOfTile<'a, M> {
    pub const NONE: Self = Self(&[]);

    /// What is added to a sample of a pixel.
    #[inline]
    pub fn of(&self, pixel: u32, index: u32) -> impl Iterator<Item = &'a Splat<M>> + Clone + use<'a, M> {
        let first = self.0.partition_point(|splat| (splat.at.1, splat.at.2) < (pixel, index));
        self.0[first..].iter().take_while(move |splat| (splat.at.1, splat.at.2) == (pixel, index))
    }
}
