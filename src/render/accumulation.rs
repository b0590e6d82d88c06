//! What a render adds up: exact sums per pixel, with what they cost.

use std::ops::Range;

use super::frame::Frame;
use super::noise;
use super::sums::{Sums, Totals, estimate};
use super::tile::Tile;
use crate::integrate::Tally;
use crate::scene::Window;

/// Largest number of samples that a pass adds to each pixel. A render stops between tiles: no pixel is then more than this
/// ahead of another.
const PASS_SPP: u32 = 16;

/// The sums over a range of the samples of every pixel. Ranges can be rendered in any pieces, anywhere, and added in any
/// order: the [`Frame`] is the same to the last bit.
pub struct Accumulation {
    /// Of the whole picture.
    pub size: [u32; 2],
    /// The pixels that are wanted of it; whole tiles are rendered, because their pixels share light.
    pub window: Window,
    /// Sample indices that it is to hold in the end.
    pub samples: Range<u32>,
    pub(super) tiles: Vec<Tile>,
    pub tally: Tally,
    pub threads: usize,
    /// Wall and user + system seconds of rendering alone; of the pieces together, after merging.
    pub render_s: f64,
    pub render_cpu_s: f64,
}

/// The sums of neighbouring pixels, as they are stored in files.
pub struct Block {
    /// The sample index that each of these pixels goes on with.
    pub next: u32,
    pub totals: Vec<Totals>,
}

impl Accumulation {
    pub fn new(size: [u32; 2], samples: Range<u32>) -> Self {
        Self::cropped(size, Window::whole(size), samples)
    }

    /// Of a part of the picture, whose pixels get the bits that they have in the whole.
    pub fn cropped(size: [u32; 2], window: Window, samples: Range<u32>) -> Self {
        let tiles = Tile::grid(size, &window, samples.start);
        Self { size, window, samples, tiles, tally: Tally::default(), threads: 0, render_s: 0.0, render_cpu_s: 0.0 }
    }

    /// Pixels that are rendered.
    pub fn pixels(&self) -> u64 {
        self.tiles.iter().map(|tile| tile.sums.len() as u64).sum()
    }

    /// Samples that every pixel has; where the render was stopped, some have a few more.
    pub fn spp(&self) -> u32 {
        self.tiles.iter().map(|tile| tile.next).min().unwrap_or(self.samples.start) - self.samples.start
    }

    /// Samples that the next pass usually adds. Small passes first, so that a short render shows something early.
    pub fn usual_pass(&self) -> u32 {
        self.spp().clamp(1, PASS_SPP)
    }

    /// As [`Frame::noise`], for the picture as it is now.
    pub fn noise(&self) -> f64 {
        let of_tile = |tile: &'_ Tile| {
            let spp = tile.next - self.samples.start;
            (0..tile.sums.len()).map(|index| estimate(&tile.sums.get(index), spp)).collect::<Vec<_>>()
        };
        noise::of_picture(self.tiles.iter().flat_map(of_tile))
    }

    /// Everything that it is to hold is there.
    pub fn is_complete(&self) -> bool {
        self.tiles.iter().all(|tile| tile.next == self.samples.end)
    }

    /// The sums in pieces, in an order that depends on nothing but the size and the window.
    pub fn blocks(&self) -> impl Iterator<Item = Block> + '_ {
        self.tiles.iter().map(|tile| Block {
            next: tile.next,
            totals: (0..tile.sums.len()).map(|index| tile.sums.get(index)).collect(),
        })
    }

    /// Puts in the sums that [`blocks`](Self::blocks) gave of the same range, to go on from there. The error tells what does
    /// not fit.
    pub fn restore(&mut self, blocks: &mut dyn Iterator<Item = Block>) -> Result<(), String> {
        let Range { start, end } = self.samples;
        self.zip(blocks, |tile, block| {
            if !(start..=end).contains(&block.next) {
                return Err(format!("it holds samples up to {}, beyond {start}:{end}", block.next));
            }
            tile.next = block.next;
            tile.sums = Sums::from_totals(block.totals);
            Ok(())
        })
    }

    /// Adds the complete sums of as many more indices. The error tells what does not fit.
    pub fn add(&mut self, samples: &Range<u32>, blocks: &mut dyn Iterator<Item = Block>) -> Result<(), String> {
        self.zip(blocks, |tile, block| {
            if block.next != samples.end {
                return Err(format!("it was interrupted at sample {} of {}", block.next, samples.end));
            }
            tile.next += samples.end - samples.start;
            for (index, totals) in block.totals.iter().enumerate() {
                tile.sums.add(index, totals);
            }
            Ok(())
        })
    }

    fn zip(
        &mut self,
        blocks: &mut dyn Iterator<Item = Block>,
        mut put: impl FnMut(&mut Tile, Block) -> Result<(), String>,
    ) -> Result<(), String> {
        for tile in &mut self.tiles {
            let block = blocks.next().ok_or("it holds fewer pixels than the picture")?;
            if block.totals.len() != tile.sums.len() {
                return Err(format!("it holds {} pixels where {} belong", block.totals.len(), tile.sums.len()));
            }
            put(tile, block)?;
        }
        match blocks.next() {
            None => Ok(()),
            Some(_) => Err("it holds more pixels than the picture".to_owned()),
        }
    }

    /// The picture.
    pub fn into_frame(self) -> Frame {
        let Window { width, height, .. } = self.window;
        let count = width as usize * height as usize;
        let mut rgb = vec![[0.0; 3]; count];
        let mut variance = vec![[0.0; 3]; count];
        let mut samples = vec![0; count];
        let spp = self.spp();
        let parts = self.tiles.first().map_or(0, |tile| tile.lights.len() / tile.sums.len());
        let mut groups = vec![vec![[0.0; 3]; count]; parts];
        for tile in self.tiles {
            let own = tile.next - self.samples.start;
            for i in 0..tile.sums.len() {
                let Some(index) = self.window.index_of(tile.place(i as u32)) else { continue };
                let channels = estimate(&tile.sums.get(i), own);
                samples[index] = own;
                for (group, mean) in groups.iter_mut().zip(tile.light_means(i, own)) {
                    group[index] = mean;
                }
                rgb[index] = channels.map(|(mean, _)| mean as f32);
                variance[index] = channels.map(|(_, variance)| variance as f32);
            }
        }
        let Self { size, window, tally, threads, render_s, render_cpu_s, .. } = self;
        Frame {
            width,
            height,
            size,
            window,
            spp,
            samples,
            rgb,
            variance,
            groups,
            tally,
            threads,
            render_s,
            render_cpu_s,
        }
    }
}
