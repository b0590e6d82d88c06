//! What a render adds up: exact sums per pixel, with what they cost.

use std::ops::Range;

use super::adaptive;
use super::doublings::Doublings;
use super::frame::Frame;
use super::noise::Noise;
use super::sums::{Sums, Totals};
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
    /// The sample index that each of these pixels goes on with, and up to which they have been decided to go.
    pub next: u32,
    pub goal: u32,
    pub totals: Vec<Totals>,
    pub doublings: Doublings,
}

impl Accumulation {
    pub fn new(size: [u32; 2], samples: Range<u32>) -> Self {
        Self::cropped(size, Window::whole(size), samples)
    }

    /// Of a part of the picture, whose pixels get the bits that they have in the whole.
    pub fn cropped(size: [u32; 2], window: Window, samples: Range<u32>) -> Self {
        let tiles = Tile::grid(size, &window, samples.clone());
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
        Noise::of(&self.tiles, self.samples.start).of_picture(&self.tiles)
    }

    /// Samples of all pixels together.
    pub fn total(&self) -> u64 {
        self.tiles.iter().map(|tile| u64::from(self.spp_of(tile)) * tile.sums.len() as u64).sum()
    }

    /// Whether there is something to render, after deciding how far tiles go where it is to stop at a `noise`.
    pub(super) fn wants_more(&mut self, noise: Option<f64>) -> bool {
        let Range { start, end } = self.samples;
        let Some(noise) = noise else { return self.is_on_its_way() };
        if self.tiles.iter().all(|tile| tile.next == start) {
            let goal = end.min(start + adaptive::LEAST_SPP);
            self.tiles.iter_mut().for_each(|tile| tile.goal = goal);
        }
        self.is_on_its_way() || adaptive::set_goals(&mut self.tiles, start, end, noise)
    }

    /// Some tile has not reached its goal.
    pub(super) fn is_on_its_way(&self) -> bool {
        self.tiles.iter().any(|tile| tile.next < tile.goal)
    }

    /// Samples that tiles are to be behind their goals after a pass of `count` samples per pixel: those that are furthest
    /// behind go first, and no pass leaps over a power of two, where doublings are looked at.
    pub(super) fn behind(&self, count: u32) -> u32 {
        let Some(last) = self.tiles.iter().max_by_key(|tile| tile.goal - tile.next) else { return 0 };
        let done = last.next - self.samples.start;
        let doubled = (done + 1).next_power_of_two();
        (last.goal - last.next).saturating_sub(count.min(doubled - done))
    }

    /// Everything that it is to hold is there.
    pub fn is_complete(&self) -> bool {
        self.tiles.iter().all(|tile| tile.next == self.samples.end)
    }

    /// The sums in pieces, in an order that depends on nothing but the size and the window.
    pub fn blocks(&self) -> impl Iterator<Item = Block> + '_ {
        self.tiles.iter().map(|tile| Block {
            next: tile.next,
            goal: tile.goal,
            totals: (0..tile.sums.len()).map(|index| tile.sums.get(index)).collect(),
            doublings: tile.doublings.clone(),
        })
    }

    /// Puts in the sums that [`blocks`](Self::blocks) gave of the same range, to go on from there. The error tells what does
    /// not fit.
    pub fn restore(&mut self, blocks: &mut dyn Iterator<Item = Block>) -> Result<(), String> {
        let Range { start, end } = self.samples;
        self.zip(blocks, |tile, block| {
            if !(start..=end).contains(&block.next) || !(block.next..=end).contains(&block.goal) {
                return Err(format!("it holds samples up to {}, beyond {start}:{end}", block.next));
            }
            (tile.next, tile.goal) = (block.next, block.goal);
            tile.sums = Sums::from_totals(block.totals);
            tile.doublings = block.doublings;
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

    /// Mean radiance per pixel as it is now, row by row from the upper left, linear sRGB.
    pub fn rgb(&self) -> Vec<[f32; 3]> {
        self.pixels_of_window(|tile, pixel| tile.sums.means(pixel, self.spp_of(tile)).map(|mean| mean as f32))
    }

    /// The picture; with [`Frame::variance`] where that is wanted.
    pub fn into_frame(self, wants_variance: bool) -> Frame {
        let (rgb, spp, total) = (self.rgb(), self.spp(), self.total());
        let noise = Noise::of(&self.tiles, self.samples.start);
        let (noise, noise_p95) = (noise.of_picture(&self.tiles), noise.p95(&self.tiles, self.samples.start));
        let samples = self.pixels_of_window(|tile, _| self.spp_of(tile));
        let variance_of =
            |tile: &Tile, pixel| tile.sums.variances(pixel, self.spp_of(tile)).map(|variance| variance as f32);
        let variance = if wants_variance { self.pixels_of_window(variance_of) } else { Vec::new() };
        let groups = (0..self.tiles.first().map_or(0, Tile::groups_of_lights))
            .map(|group| self.pixels_of_window(|tile, pixel| tile.light_mean(pixel, group, self.spp_of(tile))))
            .collect();
        let Self { size, window, tally, threads, render_s, render_cpu_s, .. } = self;
        let Window { width, height, .. } = window;
        Frame {
            width,
            height,
            size,
            window,
            spp,
            total,
            samples,
            rgb,
            variance,
            noise,
            noise_p95,
            groups,
            tally,
            threads,
            render_s,
            render_cpu_s,
        }
    }

    /// Samples that the pixels of a tile have.
    fn spp_of(&self, tile: &Tile) -> u32 {
        tile.next - self.samples.start
    }

    /// A value for every pixel that is wanted, of its tile and its number there; row by row from the upper left.
    fn pixels_of_window<T: Clone + Default>(&self, value_of: impl Fn(&Tile, usize) -> T) -> Vec<T> {
        let mut values = vec![T::default(); self.window.width as usize * self.window.height as usize];
        for tile in &self.tiles {
            for pixel in 0..tile.sums.len() {
                if let Some(index) = self.window.index_of(tile.place(pixel as u32)) {
                    values[index] = value_of(tile, pixel);
                }
            }
        }
        values
    }
}
