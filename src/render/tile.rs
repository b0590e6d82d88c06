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
pub const BLOCK: u32 = GROUP as u32;
/// Ways to cut a block: the column in which each row has the first group; the others follow, around the block. No pixel has
/// neighbours in its group, and hardly two pairs lie alike: what is bright and shared would be seen as a lattice.
const COLUMNS: [[u32; GROUP]; 4] =
    [[0, 3, 6, 4, 2, 7, 1, 5], [0, 4, 2, 5, 7, 1, 6, 3], [0, 4, 6, 3, 1, 7, 2, 5], [0, 5, 2, 4, 6, 1, 7, 3]];

/// The pixels of a group of a block, both by their numbers; a group has one in each row.
pub fn group([column, row]: [u32; 2], number: u32) -> impl Iterator<Item = [u32; 2]> {
    let first = COLUMNS[(column + 2 * row) as usize % COLUMNS.len()];
    first.into_iter().zip(0..).map(move |(x, y)| [BLOCK * column + (x + number) % BLOCK, BLOCK * row + y])
}

impl Tile {
    /// Pixel numbers of the groups that share paths: close together, but never neighbours, so that what they share is not
    /// seen as blotches.
    pub fn groups(&self) -> Vec<ArrayVec<u32, GROUP>> {
        let blocks = |start: u32, length: u32| start / BLOCK..(start + length).div_ceil(BLOCK);
        let (columns, rows) = (blocks(self.x0, self.width), blocks(self.y0, self.height()));
        let blocks = rows.flat_map(|row| columns.clone().map(move |column| [column, row]));
        let pixels = |block, number| group(block, number).filter_map(|place| self.pixel_at(place)).collect();
        blocks.flat_map(|block| (0..BLOCK).map(move |number| pixels(block, number))).collect()
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

    /// The number of the pixel that lies at a place not above or left of the tile, if it is one of its.
    fn pixel_at(&self, [x, y]: [u32; 2]) -> Option<u32> {
        let (column, row) = (x - self.x0, y - self.y0);
        (column < self.width && row < self.height()).then(|| row * self.width + column)
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
    fn groups_have_every_pixel_of_a_tile_once_and_no_neighbours() {
        for size in [[16, 16], [64, 32], [21, 13], [3, 2]] {
            for tile in Tile::grid(size, &Window::whole(size), 0..1) {
                let groups = tile.groups();
                let mut pixels: Vec<u32> = groups.iter().flatten().copied().collect();
                pixels.sort_unstable();
                assert!(pixels.into_iter().eq(0..tile.sums.len() as u32));
                for group in groups {
                    let apart = |a, b| {
                        let ([ax, ay], [bx, by]) = (tile.place(a), tile.place(b));
                        ax.abs_diff(bx).max(ay.abs_diff(by)) > 1
                    };
                    let mut pairs = group.iter().flat_map(|&a| group.iter().map(move |&b| (a, b)));
                    assert!(pairs.all(|(a, b)| a == b || apart(a, b)));
                }
            }
        }
    }

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
