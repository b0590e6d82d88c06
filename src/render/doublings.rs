//! What a tile's own samples tell of its noise.
//!
//! The samples of a pixel are one low-discrepancy sequence, so their spread says little about the error of their mean: at 32
//! samples it is often ten times too large. What every doubling of their number changes says more. Of the first n samples
//! and the next n, the means differ by twice what the doubling changes; the change c has the variance that it takes away:
//!
//!   E[c^2] = V(n) - V(2 n),  so where V falls by a factor r per doubling,  V(2 n) = E[c^2] / (r - 1).
//!
//! r is 2 for independent samples and more for stratified ones; it is measured from one doubling to the next. This costs the
//! sequence nothing, unlike two halves with seeds of their own. Pixels are scrambled independently, so a tile's mean over its
//! pixels has some hundred degrees of freedom.

use super::sums::Sums;

/// Doublings of a tile's samples, in luminance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Doublings {
    /// Samples of the last power of two, 0 before the first.
    pub spp: u32,
    /// Mean over the pixels of the square of what the last doubling changed, and the one before.
    pub changes: [f64; 2],
    /// Of each pixel at the last power of two.
    pub luminance: Vec<f32>,
}

/// Linear sRGB to luminance.
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];
/// The variance falls at least as for independent samples, and no measurement shall promise more than this.
const DECAY: [f64; 2] = [2.0, 4.0];

impl Doublings {
    /// Looks at the sums of `spp` samples; to be asked at every power of two.
    pub fn note(&mut self, sums: &Sums, spp: u32) {
        if !spp.is_power_of_two() || spp == self.spp {
            return;
        }
        let luminance: Vec<f32> = (0..sums.len()).map(|pixel| luminance(sums.means(pixel, spp)) as f32).collect();
        if self.spp * 2 == spp {
            let squares = luminance.iter().zip(&self.luminance).map(|(now, before)| f64::from(now - before).powi(2));
            self.changes = [squares.sum::<f64>() / luminance.len() as f64, self.changes[0]];
        }
        (self.spp, self.luminance) = (spp, luminance);
    }

    /// Mean variance of the means of `spp` samples, for a `decay` of the picture; infinite before the second doubling.
    pub fn variance(&self, spp: u32, decay: f64) -> f64 {
        if self.spp < 4 {
            return f64::INFINITY;
        }
        // Both doublings, brought to the last: twice the degrees of freedom.
        let change = 0.5 * (self.changes[0] + self.changes[1] / decay);
        change / (decay - 1.0) * f64::from(self.spp) / f64::from(spp)
    }
}

impl Doublings {
    /// As bytes: samples (u32), changes (2 x f64), luminance (f32 each), little-endian.
    pub fn to_bytes(&self) -> Vec<u8> {
        let changes = self.changes.iter().flat_map(|change| change.to_le_bytes());
        let luminance = self.luminance.iter().flat_map(|value| value.to_le_bytes());
        self.spp.to_le_bytes().into_iter().chain(changes).chain(luminance).collect()
    }

    /// The inverse; `None` where the bytes are too few.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (spp, rest) = bytes.split_first_chunk()?;
        let (now, rest) = rest.split_first_chunk()?;
        let (before, rest) = rest.split_first_chunk()?;
        let luminance = rest.chunks_exact(4).filter_map(|value| Some(f32::from_le_bytes(value.try_into().ok()?)));
        let changes = [now, before].map(|change| f64::from_le_bytes(*change));
        Some(Self { spp: u32::from_le_bytes(*spp), changes, luminance: luminance.collect() })
    }
}

/// How much the variance falls per doubling, over all tiles, each by its weight.
pub fn decay<'a>(tiles: impl Iterator<Item = (&'a Doublings, f64)>) -> f64 {
    let [now, before] = tiles.fold([0.0; 2], |[now, before], (doublings, weight)| {
        [now + weight * doublings.changes[0], before + weight * doublings.changes[1]]
    });
    if now > 0.0 { (before / now).clamp(DECAY[0], DECAY[1]) } else { DECAY[0] }
}

/// Of a colour in linear sRGB.
pub fn luminance(rgb: [f64; 3]) -> f64 {
    (0..3).map(|channel| LUMINANCE[channel] * rgb[channel]).sum()
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::super::sums::Samples;
    use super::*;

    /// Grey samples, independent and uniform in 0..2, of many pixels: the variance of a mean of n is 1 / (3 n).
    #[test]
    fn independent_samples_have_the_variance_of_their_mean() {
        let pixels = 256;
        let mut sums = Sums::new(pixels);
        let mut doublings = Doublings::default();
        let mut state = 1u32;
        for spp in 1..=96 {
            for pixel in 0..pixels {
                state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
                let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
                let mut sample = Samples::default();
                sample.add(Vec3::splat((word >> 8) as f32 / (1 << 23) as f32));
                sums.add_samples(pixel, &sample);
            }
            doublings.note(&sums, spp);
            let decay = decay([(&doublings, 1.0)].into_iter());
            let variance = doublings.variance(spp, decay);
            assert_eq!(variance.is_infinite(), spp < 4);
            let ratio = variance * 3.0 * f64::from(spp);
            assert!(spp < 16 || (0.6..1.4).contains(&ratio), "{ratio} at {spp}");
        }
        assert_eq!(Doublings::from_bytes(&doublings.to_bytes()), Some(doublings));
        assert_eq!(Doublings::from_bytes(&[0; 19]), None);
    }

    /// Means whose errors fall as 1 / n have variances that fall four times as fast per doubling.
    #[test]
    fn a_faster_fall_is_seen() {
        let fast = Doublings { spp: 64, changes: [1.0, 4.0], luminance: Vec::new() };
        assert_eq!(decay([(&fast, 256.0)].into_iter()), 4.0);
        assert!((fast.variance(64, 4.0) - 1.0 / 3.0).abs() < 1e-12);
        let slow = Doublings { spp: 64, changes: [1.0, 1.0], luminance: Vec::new() };
        assert_eq!(decay([(&slow, 256.0)].into_iter()), 2.0, "no slower than independent samples");
    }
}
