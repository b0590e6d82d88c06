//! Pixels in which a lamp or the sky ends.
//!
//! Light that the camera sees directly may be a thousand times brighter than what is beside it: however clean the rest of a
//! picture, its edges would stay ragged. In pixels that such an edge crosses, directly seen light is averaged over
//! [`BATCH`] rays a sample instead of one. Which pixels these are is found with rays through fixed points, not with the
//! samples themselves, so the mean stays what it was.

use glam::Vec2;

use super::tile::{TILE_SIDE, Tile};
use super::{Filter, Plan};
use crate::embree::BATCH;
use crate::integrate::{Tally, seen_light};
use crate::math::Sampler;
use crate::mode::{Lanes, Mode};
use crate::scene::{Camera, Scene};

/// Ratio of directly seen light between the corners of a pixel that makes an edge.
const CONTRAST: f32 = 1.5;

/// Of a tile: bit x of row y is set where an edge crosses the pixel.
pub struct Edges([u32; TILE_SIDE as usize]);

impl Edges {
    pub fn find<M: Mode>(scene: &Scene<M>, camera: &Camera, plan: &Plan, tile: &Tile, tally: &mut Tally) -> Self {
        // Wide filters reach into the neighbours.
        let margin = if plan.filter == Filter::Box { 0 } else { 1 };
        let (columns, rows) = (tile.width + 1 + 2 * margin, tile.height() + 1 + 2 * margin);
        let waves = M::waves(0.5);
        let corner = |i: u32| {
            let (x, y) = ((tile.x0 + i % columns) as f32, (tile.y0 + i / columns) as f32);
            camera.ray(Vec2::new(x, y) - margin as f32, [0.5; 2])
        };
        let count = columns * rows;
        let mut seen = Vec::with_capacity((count as usize).next_multiple_of(BATCH));
        for first in (0..count).step_by(BATCH) {
            let rays = std::array::from_fn(|k| corner((first + k as u32).min(count - 1)));
            seen.extend(seen_light(scene, &rays, &waves, tally).map(|light| light.mean()));
        }
        let mut edges = [0; TILE_SIDE as usize];
        for pixel in 0..tile.sums.len() as u32 {
            let (x, y) = (pixel % tile.width, pixel / tile.width);
            let reach = 2 + 2 * margin;
            let around = (0..reach * reach).map(|i| seen[((y + i / reach) * columns + x + i % reach) as usize]);
            let (low, high) =
                around.fold((f32::INFINITY, 0.0f32), |(low, high), light| (low.min(light), high.max(light)));
            edges[y as usize] |= u32::from(high > CONTRAST * low) << x;
        }
        Self(edges)
    }

    pub fn cross(&self, x: u32, y: u32) -> bool {
        self.0[y as usize] >> x & 1 == 1
    }
}

/// Directly seen light of one sample of the pixel that is number `pixel` of the picture, at [x, y].
pub fn seen_sample<M: Mode>(
    scene: &Scene<M>,
    camera: &Camera,
    plan: &Plan,
    ([x, y], pixel): ([u32; 2], u32),
    index: u32,
    waves: &M::Waves,
    tally: &mut Tally,
) -> M::Light {
    // All samples of a pixel go through one sequence, so that together they are stratified too.
    let ray = |k: usize| {
        let index = index.wrapping_mul(BATCH as u32).wrapping_add(k as u32);
        let [u_x, u_y, lens_x, lens_y] = Sampler::new(pixel, index, plan.seed ^ 0x5eed_ed9e).next_4d();
        let offset = Vec2::new(plan.filter.sample(u_x), plan.filter.sample(u_y));
        camera.ray(Vec2::new(x as f32, y as f32) + 0.5 + offset, [lens_x, lens_y])
    };
    let lights = seen_light(scene, &std::array::from_fn(ray), waves, tally);
    lights.into_iter().fold(M::Light::ZERO, |sum, light| sum + light) * (1.0 / BATCH as f32)
}
