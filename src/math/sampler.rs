//! The sample stream: a pure function of (pixel, sample index, dimension, seed).
//!
//! Owen-scrambled Sobol points (Burley 2020, "Practical Hash-based Owen Scrambling"), padded: every call of
//! [`Sampler::next_4d`] takes the first four Sobol dimensions under a fresh scramble, so each group of four is well
//! stratified within itself and independent of the others.

use super::sobol::{LENGTH_LOG2, owen_sobol_4d};

#[derive(Clone, Debug)]
pub struct Sampler {
    /// Bits reversed.
    index_rev: u32,
    seed: u32,
    set: u32,
}

impl Sampler {
    /// The stream of sample `index` of `pixel` (any number that identifies it).
    #[inline]
    pub fn new(pixel: u32, index: u32, seed: u32) -> Self {
        let block = index >> LENGTH_LOG2;
        let seed = hash(pixel ^ hash(seed ^ hash(block)));
        Self { index_rev: (index & ((1 << LENGTH_LOG2) - 1)).reverse_bits(), seed, set: 0 }
    }

    /// The stream of one of 2^`parts_log2` parts of this sample, for what is drawn several times at once. The parts of all
    /// samples together are as well stratified as the samples. Streams that part at different places have nothing in common.
    #[inline]
    pub fn part(&self, parts_log2: u32, part: u32) -> Self {
        let index = self.index_rev.reverse_bits() << parts_log2 | part;
        let seed = hash(self.set_seed() ^ hash(!(index >> LENGTH_LOG2)));
        Self { index_rev: (index & ((1 << LENGTH_LOG2) - 1)).reverse_bits(), seed, set: self.set }
    }

    #[inline]
    fn set_seed(&self) -> u32 {
        self.seed.wrapping_add(self.set.wrapping_mul(0x9e37_79b9))
    }

    /// Four numbers in [0, 1), jointly stratified over the samples of a pixel.
    #[inline]
    pub fn next_4d(&mut self) -> [f32; 4] {
        let seed = self.set_seed();
        self.set += 1;
        owen_sobol_4d(self.index_rev, seed)
    }
}

/// A bijective integer hash. Wellons, "Prospecting for Hash Functions": lowbias32.
#[inline]
fn hash(mut x: u32) -> u32 {
    x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixels_samples_are_stratified_in_every_group() {
        for group in 0..3 {
            let mut seen = [[false; 16]; 16];
            for index in 0..256 {
                let mut sampler = Sampler::new(12, index, 3);
                for _ in 0..group {
                    sampler.next_4d();
                }
                let [x, y, ..] = sampler.next_4d();
                seen[(x * 16.0) as usize][(y * 16.0) as usize] = true;
            }
            assert!(seen.iter().flatten().all(|&cell| cell));
        }
    }

    #[test]
    fn parts_are_stratified_together() {
        let mut seen = [[false; 16]; 16];
        for (index, part) in (0..64).flat_map(|index| (0..4).map(move |part| (index, part))) {
            let [x, y, ..] = Sampler::new(12, index, 3).part(2, part).next_4d();
            seen[(x * 16.0) as usize][(y * 16.0) as usize] = true;
        }
        assert!(seen.iter().flatten().all(|&cell| cell));
        let beyond = |index| Sampler::new(12, index, 3).part(2, 1).next_4d();
        assert_ne!(beyond(1), beyond(1 + (1 << 14)));
    }

    #[test]
    fn streams_go_on_beyond_one_sequence() {
        let first = Sampler::new(1, 5, 0).next_4d();
        let later = Sampler::new(1, 5 + (1 << 16), 0).next_4d();
        assert_ne!(first, later);
    }
}
