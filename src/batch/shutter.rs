//! Motion blur: the samples of a frame are spread over the time that the shutter is open.
//!
//! Each sample index has its moment, for which the scene is posed anew. That costs a fraction of a millisecond, and
//! everything that can move blurs: cameras, lights and films as well as shapes, along curves as well as lines. Time carried
//! by rays through motion segments would blur straight movements of shapes alone.

use crate::render::{Accumulation, Watch};

/// How long the shutter is open, in frames: half of it before the frame's own moment, half after.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shutter {
    pub open: f64,
}

impl Shutter {
    /// When sample `index` is taken, in frames from the frame's own moment. Any number of samples from 0 on is spread evenly:
    /// van der Corput's sequence.
    pub fn moment(self, index: u32) -> f64 {
        let share = f64::from(index.reverse_bits()) / f64::from(u32::MAX);
        self.open * (share - 0.5)
    }
}

/// Ends a render when every pixel has so many samples.
pub struct Until<'a> {
    pub watch: &'a dyn Watch,
    pub spp: u32,
}

impl Watch for Until<'_> {
    fn advanced(&self, samples: u64) {
        self.watch.advanced(samples);
    }

    fn stop(&self) -> bool {
        self.watch.stop()
    }

    fn pass(&self, so_far: &Accumulation) -> u32 {
        let left = self.spp.saturating_sub(so_far.spp());
        // Nobody is asked about a pass that is not due.
        if left == 0 { 0 } else { self.watch.pass(so_far).min(left) }
    }

    /// Of the picture, not of each of its moments.
    fn done(&self, sums: &Accumulation) {
        if sums.is_complete() || sums.spp() < self.spp {
            self.watch.done(sums);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_number_of_samples_covers_the_time_evenly() {
        let shutter = Shutter { open: 0.5 };
        for count in [8u32, 100, 256] {
            let moments: Vec<f64> = (0..count).map(|index| shutter.moment(index)).collect();
            assert!(moments.iter().all(|moment| moment.abs() <= 0.25));
            let mean = moments.iter().sum::<f64>() / f64::from(count);
            // The discrepancy of the sequence is of the order of log(n) / n.
            assert!(mean.abs() <= 1.0 / f64::from(count), "{count}: {mean}");
            let early = moments.iter().filter(|moment| **moment < -0.125).count();
            assert!(early.abs_diff(count as usize / 4) <= 2, "{count}: {early}");
        }
    }
}
