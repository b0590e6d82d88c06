//! Tiles keep their own sums, so that threads never share a cache line.

use super::sums::Sums;

pub const TILE_SIDE: u32 = 16;

/// A rectangle of the picture; pixels row by row.
pub struct Tile {
    pub x0: u32,
    pub y0: u32,
    pub width: u32,
    /// The sample index that each pixel goes on with.
    pub next: u32,
    pub sums: Sums,
}

impl Tile {
    /// All tiles of a picture, without samples before index `first`, along a Z-order curve: neighbours in time are neighbours in space.
    pub fn grid([width, height]: [u32; 2], first: u32) -> Vec<Self> {
        let (columns, rows) = (width.div_ceil(TILE_SIDE), height.div_ceil(TILE_SIDE));
        let mut places: Vec<[u32; 2]> =
            (0..rows).flat_map(|row| (0..columns).map(move |column| [column, row])).collect();
        places.sort_by_key(|&[column, row]| spread_bits(column) | spread_bits(row) << 1);
        let tile = |[column, row]: [u32; 2]| {
            let (x0, y0) = (column * TILE_SIDE, row * TILE_SIDE);
            let (tile_width, tile_height) = ((width - x0).min(TILE_SIDE), (height - y0).min(TILE_SIDE));
            let sums = Sums::new((tile_width * tile_height) as usize);
            Self { x0, y0, width: tile_width, next: first, sums }
        };
        places.into_iter().map(tile).collect()
    }
}

/// Moves bit i to bit 2i.
fn spread_bits(x: u32) -> u64 {
    let mut x = u64::from(x);
    for (shift, mask) in [(16, 0x0000_ffff_0000_ffff), (8, 0x00ff_00ff_00ff_00ff), (4, 0x0f0f_0f0f_0f0f_0f0f)] {
        x = (x | x << shift) & mask;
    }
    x = (x | x << 2) & 0x3333_3333_3333_3333;
    (x | x << 1) & 0x5555_5555_5555_5555
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once() {
        for size in [[1, 1], [16, 16], [17, 33], [100, 3]] {
            let tiles = Tile::grid(size, 0);
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
