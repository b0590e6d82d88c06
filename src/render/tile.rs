//! Tiles keep their own sums, so that threads never share a cache line.

use std::ops::Range;

use arrayvec::ArrayVec;
use glam::DVec3;

use super::doublings::Doublings;
use super::edge::Edges;
use super::sums::Sums;
use crate::integrate::GROUP;
use crate::math::distribution::spread_bits;
use crate::scene::Window;

pub const TILE_SIDE: u32 = 16;

/// A rectangle of the picture; pixels row by row.
pub struct Tile {
    pub x0: u32,
    pub y0: u32,
    pub width: u32,
    /// The sample index that each pixel goes on with.
    pub next: u32,
    /// The sample index up to which it has been decided to go.
    pub goal: u32,
    pub sums: Sums,
    pub doublings: Doublings,
    /// Of each pixel the sums of each light group; empty where they are not told apart.
    pub lights: Vec<DVec3>,
    /// Found with the first samples.
    pub edges: Option<Edges>,
}

/// Side of the blocks that are cut into groups; each row and column of a block has one pixel of each group.
const BLOCK: u32 = GROUP as u32;

impl Tile {
    /// Pixel numbers of the groups that share paths: close together, but never neighbours, so that what they share is not
    /// seen as blotches.
    pub fn groups(&self) -> Vec<ArrayVec<u32, GROUP>> {
        let (columns, height) = (self.width.div_ceil(BLOCK), self.height());
        let mut groups = vec![ArrayVec::new(); (columns * height.div_ceil(BLOCK) * BLOCK) as usize];
        for pixel in 0..self.sums.len() as u32 {
            let (x, y) = (pixel % self.width, pixel / self.width);
            let block = y / BLOCK * columns + x / BLOCK;
            groups[(block * BLOCK + (x + 3 * y) % BLOCK) as usize].push(pixel);
        }
        groups
    }

    /// Light groups that are told apart.
    pub fn groups_of_lights(&self) -> usize {
        self.lights.len() / self.sums.len()
    }

    /// What a light group has in a pixel: the mean of `spp` samples.
    pub fn light_mean(&self, pixel: usize, group: usize, spp: u32) -> [f32; 3] {
        let sum = self.lights[pixel * self.groups_of_lights() + group];
        (sum / f64::from(spp.max(1))).as_vec3().to_array()
    }

    pub fn height(&self) -> u32 {
        self.sums.len() as u32 / self.width
    }

    /// Where a pixel lies in the picture.
    pub fn place(&self, pixel: u32) -> [u32; 2] {
        [self.x0 + pixel % self.width, self.y0 + pixel / self.width]
    }

    /// All tiles of a picture that a window touches, to be given these samples, along a Z-order curve: neighbours in time are
    /// neighbours in space.
    pub fn grid([width, height]: [u32; 2], window: &Window, samples: Range<u32>) -> Vec<Self> {
        let (columns, rows) = (width.div_ceil(TILE_SIDE), height.div_ceil(TILE_SIDE));
        let mut places: Vec<[u32; 2]> =
            (0..rows).flat_map(|row| (0..columns).map(move |column| [column, row])).collect();
        places.sort_by_key(|&[column, row]| spread_bits(column) | spread_bits(row) << 1);
        let tile = |[column, row]: [u32; 2]| {
            let (x0, y0) = (column * TILE_SIDE, row * TILE_SIDE);
            let (tile_width, tile_height) = ((width - x0).min(TILE_SIDE), (height - y0).min(TILE_SIDE));
            if !window.touches(&Window { x: x0, y: y0, width: tile_width, height: tile_height }) {
                return None;
            }
            let sums = Sums::new((tile_width * tile_height) as usize);
            let (next, goal) = (samples.start, samples.end);
            let (doublings, lights) = (Doublings::default(), Vec::new());
            Some(Self { x0, y0, width: tile_width, next, goal, sums, doublings, lights, edges: None })
        };
        places.into_iter().filter_map(tile).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once() {
        for size in [[1, 1], [16, 16], [17, 33], [100, 3]] {
            let tiles = Tile::grid(size, &Window::whole(size), 0..1);
            let mut seen = vec![0; (size[0] * size[1]) as usize];
            for tile in &tiles {
                for i in 0..tile.sums.len() as u32 {
                    let (x, y) = (tile.x0 + i % tile.width, tile.y0 + i / tile.width);
                    seen[(y * size[0] + x) as usize] += 1;
                }
            }
            assert!(seen.iter().all(|&count| count == 1));
        }
    }
}
