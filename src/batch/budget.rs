//! Time and noise that frames may take, and how a budget is shared among those that are left.

use std::time::Instant;

use crate::render::{Accumulation, Watch};

/// Below this many samples per pixel a variance says little.
const LEAST_SPP_FOR_NOISE: u32 = 16;
/// Samples change by no more than this from one frame to the next: a step would show.
const MOST_STEP: f64 = 1.25;
/// A frame that costs more than those before it may take this many shares of the total before it is cut short.
const MOST_SHARES: f64 = 2.0;

/// When frames stop besides at their number of samples.
#[derive(Clone, Copy, Debug, Default)]
pub struct Budget {
    /// Of rendering one frame, seconds.
    pub time_per_frame_s: Option<f64>,
    /// Estimated error of the picture ([`crate::render::Frame::noise`]).
    pub noise: Option<f64>,
    /// Of the whole batch, seconds from its start.
    pub total_time_s: Option<f64>,
}

/// What one frame may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    pub spp: u32,
    pub time_s: Option<f64>,
    pub noise: Option<f64>,
}

/// Shares the budget of a batch.
///
/// The first frame gets an equal share of the time. From then on the frames that are left get an equal number of samples,
/// as many as the time that is left pays for at the median cost so far, but not many more or fewer than the frame before:
/// neighbours look alike, and slow frames do not lose quality for being slow.
pub struct Schedule {
    budget: Budget,
    /// The most samples per pixel.
    spp: u32,
    start: Instant,
    /// Seconds per sample per pixel of the frames so far, and seconds beside rendering.
    costs_s: Vec<f64>,
    aside_s: Vec<f64>,
    /// Samples per pixel of the frame before.
    last_spp: Option<u32>,
}

impl Schedule {
    pub fn new(budget: Budget, spp: u32, start: Instant) -> Self {
        Self { budget, spp, start, costs_s: Vec::new(), aside_s: Vec::new(), last_spp: None }
    }

    /// For the next frame, when `left` frames are to come, itself included.
    pub fn limit(&self, left: usize) -> Limit {
        let Budget { time_per_frame_s, noise, total_time_s } = self.budget;
        let total = total_time_s.map(|total_s| total_s - self.start.elapsed().as_secs_f64());
        self.share(total, left, Limit { spp: self.spp, time_s: time_per_frame_s, noise })
    }

    fn share(&self, left_s: Option<f64>, left: usize, limit: Limit) -> Limit {
        let Some(left_s) = left_s else { return limit };
        let share_s = (left_s / left.max(1) as f64 - median(&self.aside_s).unwrap_or(0.0)).max(0.0);
        let (most_s, spp) = match median(&self.costs_s) {
            None => (share_s, limit.spp),
            Some(cost_s) => {
                let last = self.last_spp.map_or(share_s / cost_s, f64::from);
                let spp = (share_s / cost_s).clamp(last / MOST_STEP, last * MOST_STEP);
                ((MOST_SHARES * share_s).min(left_s), spp as u32)
            }
        };
        let time_s = limit.time_s.map_or(most_s, |time_s| time_s.min(most_s));
        Limit { spp: spp.clamp(1, limit.spp), time_s: Some(time_s.max(0.0)), ..limit }
    }

    /// Notes what a frame took: `spp` samples per pixel in `render_s`, of `total_s` in all.
    pub fn note(&mut self, spp: u32, render_s: f64, total_s: f64) {
        self.costs_s.push(render_s / f64::from(spp.max(1)));
        self.aside_s.push((total_s - render_s).max(0.0));
        self.last_spp = Some(spp);
    }
}

/// The middle value; the lower one of two.
fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len().saturating_sub(1) / 2).copied()
}

/// Ends a picture at its limit, between passes: every pixel of a frame has the same samples then, and it can be made again
/// from their number alone.
pub struct Limited<'a> {
    pub watch: &'a dyn Watch,
    pub limit: Limit,
    pub start: Instant,
}

impl Watch for Limited<'_> {
    fn advanced(&self, samples: u64) {
        self.watch.advanced(samples);
    }

    fn stop(&self) -> bool {
        self.watch.stop()
    }

    fn pass(&self, so_far: &Accumulation) -> u32 {
        let spp = so_far.spp();
        let mut count = self.watch.pass(so_far).min(self.limit.spp.saturating_sub(spp));
        if let Some(time_s) = self.limit.time_s {
            let elapsed_s = self.start.elapsed().as_secs_f64();
            let affordable = (time_s - elapsed_s) / (elapsed_s / f64::from(spp));
            count = count.min(affordable.max(0.0) as u32);
        }
        match self.limit.noise {
            Some(noise) if spp >= LEAST_SPP_FOR_NOISE && so_far.noise() <= noise => 0,
            _ => count,
        }
    }

    fn done(&self, sums: &Accumulation) {
        self.watch.done(sums);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OPEN: Limit = Limit { spp: 1000, time_s: None, noise: None };

    fn schedule() -> Schedule {
        Schedule::new(Budget::default(), OPEN.spp, Instant::now())
    }

    #[test]
    fn without_a_total_nothing_is_shared() {
        assert_eq!(schedule().share(None, 10, OPEN), OPEN);
    }

    #[test]
    fn the_first_frame_gets_its_share_of_the_time() {
        assert_eq!(schedule().share(Some(100.0), 10, OPEN), Limit { time_s: Some(10.0), ..OPEN });
        let short = Limit { time_s: Some(3.0), ..OPEN };
        assert_eq!(schedule().share(Some(100.0), 10, short), short);
    }

    #[test]
    fn later_frames_get_equal_samples() {
        let mut schedule = schedule();
        // 0.1 s per sample, 1 s beside; and one frame that was three times as slow.
        schedule.note(90, 9.0, 10.0);
        schedule.note(90, 9.0, 10.0);
        schedule.note(90, 27.0, 28.0);
        assert_eq!(schedule.share(Some(70.0), 7, OPEN), Limit { spp: 90, time_s: Some(18.0), noise: None });
        // The last one cannot take more than there is.
        assert_eq!(schedule.share(Some(6.0), 1, OPEN).time_s, Some(6.0));
        // More time or less time: the samples follow step by step, and the clock has the last word.
        assert_eq!(schedule.share(Some(700.0), 7, OPEN).spp, 112);
        assert_eq!(schedule.share(Some(-5.0), 2, OPEN), Limit { spp: 72, time_s: Some(0.0), noise: None });
    }
}
