//! Exact sums: whole numbers, so that any split of a pixel's samples, added in any order, gives the same bits.
//!
//! A sample's radiance is rounded to a multiple of 2^-32 and its square to a multiple of 2^-36; from there on nothing is
//! rounded. The quanta are constants: every process agrees on them without knowing the picture. They are small enough for
//! dark pictures (radiance 2.3e-10 still counts, and a standard deviation down to 4e-6 is told from none), and 64 bits on top
//! of them hold what pictures usually are. A tile where they do not suffice (one sample of 11585, or 65536 samples of 45)
//! goes on in 128 bits, which hold 2^27 samples of any radiance up to [`LARGEST`].

use glam::Vec3;

/// Steps of the sums in a radiance of 1.
const STEPS: f64 = (1u64 << 32) as f64;
/// Steps of the sums of squares in a radiance of 1.
const SQUARE_STEPS: f64 = (1u64 << 36) as f64;
/// Largest radiance that is added without a look at its bits: its square's 50 fit into the mantissa of an f64.
const USUAL: f32 = 128.0;
/// Samples up to [`USUAL`] whose squares 64 bits hold.
const MOST_USUAL: u32 = 1 << 12;
/// Added to an f64 below 2^51 in size, rounds it to a whole number that is then the low bits of the mantissa.
const ROUND: f64 = (3u64 << 51) as f64;
/// Radiance beyond which a sample, in either direction, counts as this; about twice the luminance of the sun in cd/m2.
pub const LARGEST: f32 = (1u64 << 32) as f32;

/// Of the samples of one pixel: of R, G, B in steps of 2^-32, then of their squares in steps of 2^-36.
pub type Totals = [i128; 6];

/// Some samples of one pixel, on their way to its totals: in registers while they are traced.
#[derive(Default)]
pub struct Samples {
    usual: [i64; 6],
    count: u32,
    /// Of samples beyond [`USUAL`], and of others where they were many.
    bright: Option<Totals>,
}

impl Samples {
    /// Adds a sample; false where it was beyond [`LARGEST`].
    #[inline]
    pub fn add(&mut self, rgb: Vec3) -> bool {
        let size = rgb.abs().max_element();
        if size <= USUAL && self.count < MOST_USUAL {
            self.count += 1;
            for (sum, step) in self.usual.iter_mut().zip(steps(rgb)) {
                *sum += ((step + ROUND).to_bits() as i64).wrapping_sub(ROUND.to_bits() as i64);
            }
            return true;
        }
        let limited = rgb.clamp(Vec3::splat(-LARGEST), Vec3::splat(LARGEST));
        let totals = self.bright.get_or_insert_default();
        for (sum, step) in totals.iter_mut().zip(steps(limited)) {
            *sum += step.round_ties_even() as i128;
        }
        size <= LARGEST
    }

    fn totals(&self) -> Totals {
        let bright = self.bright.unwrap_or_default();
        std::array::from_fn(|i| i128::from(self.usual[i]) + bright[i])
    }
}

/// The totals of the pixels of a tile.
pub enum Sums {
    Narrow(Vec<[i64; 6]>),
    Wide(Vec<Totals>),
}

impl Sums {
    pub fn new(pixels: usize) -> Self {
        Self::Narrow(vec![[0; 6]; pixels])
    }

    /// As few bits as hold these totals.
    pub fn from_totals(totals: Vec<Totals>) -> Self {
        totals.iter().map(narrow).collect::<Option<Vec<_>>>().map_or(Self::Wide(totals), Self::Narrow)
    }

    pub fn len(&self) -> usize {
        match self {
            Self::Narrow(pixels) => pixels.len(),
            Self::Wide(pixels) => pixels.len(),
        }
    }

    pub fn get(&self, index: usize) -> Totals {
        match self {
            Self::Narrow(pixels) => pixels[index].map(i128::from),
            Self::Wide(pixels) => pixels[index],
        }
    }

    /// Per channel the mean of a pixel's `spp` samples; black where there are none.
    pub fn means(&self, index: usize, spp: u32) -> [f64; 3] {
        let share = |sum: f64| sum / STEPS / f64::from(spp.max(1));
        match self {
            // The same bits as by way of [`get`](Self::get), in a fraction of the time.
            Self::Narrow(pixels) => std::array::from_fn(|channel| share(pixels[index][channel] as f64)),
            Self::Wide(pixels) => std::array::from_fn(|channel| share(pixels[index][channel] as f64)),
        }
    }

    /// Per channel the variance of that mean, as if samples were independent; infinite below two of them.
    pub fn variances(&self, index: usize, spp: u32) -> [f64; 3] {
        if spp < 2 {
            return [f64::INFINITY; 3];
        }
        let (n, means, totals) = (f64::from(spp), self.means(index, spp), self.get(index));
        std::array::from_fn(|channel| {
            let square = totals[channel + 3] as f64 / SQUARE_STEPS / n;
            (square - means[channel] * means[channel]).max(0.0) / (n - 1.0)
        })
    }

    /// Adds more samples of a pixel.
    #[inline]
    pub fn add_samples(&mut self, index: usize, samples: &Samples) {
        if let (Self::Narrow(pixels), None) = (&mut *self, &samples.bright) {
            if let Some(sum) = narrow_sum(&pixels[index], &samples.usual) {
                pixels[index] = sum;
                return;
            }
        }
        self.add(index, &samples.totals());
    }

    /// Adds totals of the same pixel.
    pub fn add(&mut self, index: usize, totals: &Totals) {
        let mut sum = self.get(index);
        for (value, more) in sum.iter_mut().zip(totals) {
            // 2^27 samples of the largest radiance fit.
            *value = value.saturating_add(*more);
        }
        if let Self::Narrow(pixels) = self {
            match narrow(&sum) {
                Some(sum) => {
                    pixels[index] = sum;
                    return;
                }
                None => *self = Self::Wide(pixels.iter().map(|totals| totals.map(i128::from)).collect()),
            }
        }
        if let Self::Wide(pixels) = self {
            pixels[index] = sum;
        }
    }
}

/// A sample's radiance and its squares, in steps and parts of steps. f64 holds the square of an f32 exactly.
#[inline]
fn steps(rgb: Vec3) -> [f64; 6] {
    let [r, g, b] = rgb.to_array().map(f64::from);
    [r * STEPS, g * STEPS, b * STEPS, r * r * SQUARE_STEPS, g * g * SQUARE_STEPS, b * b * SQUARE_STEPS]
}

/// `None` where 64 bits do not hold them.
fn narrow(totals: &Totals) -> Option<[i64; 6]> {
    let mut values = [0; 6];
    for (value, total) in values.iter_mut().zip(totals) {
        *value = i64::try_from(*total).ok()?;
    }
    Some(values)
}

/// `None` where 64 bits do not hold it.
#[inline]
fn narrow_sum(a: &[i64; 6], b: &[i64; 6]) -> Option<[i64; 6]> {
    let mut overflow = false;
    let sum = std::array::from_fn(|i| {
        let (sum, over) = a[i].overflowing_add(b[i]);
        overflow |= over;
        sum
    });
    (!overflow).then_some(sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Dark, usual, negative, bright and absurd samples, some 2000 times each.
    fn samples() -> Vec<Vec3> {
        let scales = [1e-9, 1e-5, 0.3, 40.0, 3000.0, 2e9, 1e12];
        (0..14_000u32)
            .map(|i| {
                let random = |salt: u32| (i.wrapping_mul(2_654_435_761) ^ salt).wrapping_mul(0x9e37_79b9) as f32 / 4e9;
                Vec3::new(random(1), random(2) - 0.1, random(3)) * scales[i as usize % 7]
            })
            .collect()
    }

    fn sums(samples: impl Iterator<Item = Vec3>) -> Sums {
        let mut sum = Samples::default();
        samples.for_each(|rgb| {
            sum.add(rgb);
        });
        let mut sums = Sums::new(1);
        sums.add_samples(0, &sum);
        sums
    }

    #[test]
    fn any_split_in_any_order_gives_the_same_totals() {
        let samples = samples();
        let whole = sums(samples.iter().copied()).get(0);
        assert_eq!(sums(samples.iter().rev().copied()).get(0), whole);
        for pieces in [2, 3, 7] {
            let mut merged = Sums::new(1);
            for piece in (0..pieces).rev() {
                merged.add(0, &sums(samples.iter().skip(piece).step_by(pieces).copied()).get(0));
            }
            assert_eq!(merged.get(0), whole, "{pieces} pieces");
        }
    }

    #[test]
    fn means_are_those_of_the_samples_at_every_brightness() {
        for scale in [1e-7f32, 1e-3, 1.0, 1e3, 1e6, 1e9] {
            let samples: Vec<Vec3> = (1..=1000).map(|i| Vec3::splat(i as f32 / 500.0 * scale)).collect();
            let sums = sums(samples.iter().copied());
            let (mean, variance) = (sums.means(0, 1000)[0], sums.variances(0, 1000)[0]);
            let exact = samples.iter().map(|rgb| f64::from(rgb.x)).sum::<f64>() / 1000.0;
            assert!((mean / exact - 1.0).abs() < 1e-4, "{scale}: {mean} for {exact}");
            let spread: f64 = samples.iter().map(|rgb| (f64::from(rgb.x) - exact).powi(2)).sum();
            let exact = spread / 1000.0 / 999.0;
            let step = 1.0 / SQUARE_STEPS / 999.0;
            assert!((variance - exact).abs() < 1e-4 * exact + step, "{scale}: {variance} for {exact}");
            let wide = Sums::Wide(vec![sums.get(0)]);
            assert_eq!((wide.means(0, 1000), wide.variances(0, 1000)), (sums.means(0, 1000), sums.variances(0, 1000)));
        }
    }

    #[test]
    fn tiles_widen_only_where_they_must() {
        let mut sums = Sums::new(2);
        let mut many = Samples::default();
        assert!((0..65_536).all(|_| many.add(Vec3::splat(40.0))));
        sums.add_samples(0, &many);
        assert!(matches!(sums, Sums::Narrow(_)));
        let mut bright = Samples::default();
        assert!(bright.add(Vec3::splat(1e6)));
        assert!(!bright.add(Vec3::splat(1e13)));
        sums.add_samples(1, &bright);
        assert!(matches!(sums, Sums::Wide(_)));
        assert_eq!(sums.get(1)[0], (1_000_000i128 + (1 << 32)) << 32);
        assert_eq!(sums.get(0)[0], (65_536 * 40) << 32);
    }
}
