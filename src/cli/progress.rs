//! Progress on stderr: a bar on a terminal, a line now and then elsewhere, or JSON lines.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::say;
use crate::render::{Accumulation, Watch};

/// Seconds between lines when there is no terminal to draw a bar on.
const LINE_INTERVAL: Duration = Duration::from_secs(10);
/// Steps of the bar.
const STEPS: u64 = 1000;

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ProgressArg {
    /// A bar on a terminal, lines elsewhere
    Auto,
    Bar,
    /// One JSON object per line
    Json,
    None,
}

/// Watches a render: shows how far it is, and stops it after SIGINT or SIGTERM.
pub struct Progress {
    style: ProgressArg,
    bar: ProgressBar,
    pixels: u64,
    /// Samples of all pixels: that there may be in the end, and that there are.
    total: u64,
    done: AtomicU64,
    start: Instant,
    /// Samples and seconds of earlier runs.
    earlier: (u64, f64),
    time_s: Option<f64>,
    noise: Option<f64>,
    last: Mutex<Last>,
    /// The signal that arrived, 0 for none.
    signal: Arc<AtomicUsize>,
}

/// What was known at the last look.
struct Last {
    line: Instant,
    /// Estimated error of the picture.
    noise: Option<f64>,
}

impl Progress {
    /// Of a render that goes on from `sums`, and may end earlier at a time (seconds, earlier runs included) or a noise.
    pub fn new(
        style: ProgressArg,
        sums: &Accumulation,
        (time_s, noise): (Option<f64>, Option<f64>),
        signal: Arc<AtomicUsize>,
    ) -> Self {
        let target = match style {
            ProgressArg::Auto => ProgressDrawTarget::stderr(),
            ProgressArg::Bar => ProgressDrawTarget::stderr_with_hz(10),
            ProgressArg::Json | ProgressArg::None => ProgressDrawTarget::hidden(),
        };
        let bar = ProgressBar::with_draw_target(Some(STEPS), target);
        let template = "{bar:32} {percent:>3} %  {msg}";
        bar.set_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()));
        let start = Instant::now();
        let pixels = sums.pixels();
        Self {
            style,
            bar,
            pixels,
            total: pixels * sums.samples.len() as u64,
            done: AtomicU64::new(sums.total()),
            start,
            earlier: (sums.total(), sums.render_s),
            time_s,
            noise,
            last: Mutex::new(Last { line: start, noise: None }),
            signal,
        }
    }

    pub fn finish(&self) {
        self.bar.finish_and_clear();
        if self.style == ProgressArg::Json {
            let noise = self.last.lock().unwrap_or_else(PoisonError::into_inner).noise;
            say(&self.report(self.done.load(Ordering::Relaxed), noise));
        }
    }

    /// The one status line: samples per pixel, time, noise, and how long it will take.
    fn report(&self, done: u64, noise: Option<f64>) -> String {
        let elapsed_s = self.start.elapsed().as_secs_f64();
        let share = self.share(done, elapsed_s, noise);
        // What earlier runs did does not count for the speed of this one.
        let earlier = self.share(self.earlier.0, 0.0, None).min(share);
        let left_s = elapsed_s * (1.0 - share) / (share - earlier).max(1e-9);
        let spp = done as f64 / self.pixels as f64;
        if self.style == ProgressArg::Json {
            let noise = noise.map(|noise| format!(r#","noise":{noise:.5}"#)).unwrap_or_default();
            return format!(
                r#"{{"done":{share:.4},"spp":{spp:.1}{noise},"elapsed_s":{elapsed_s:.1},"left_s":{left_s:.1}}}"#
            );
        }
        let noise = noise.map(|noise| format!("noise {:.2} %, ", 100.0 * noise)).unwrap_or_default();
        format!("{spp:.0} spp, {noise}{elapsed_s:.0} s elapsed, about {left_s:.0} s left")
    }

    /// How far the render is: by what will end it first.
    fn share(&self, done: u64, elapsed_s: f64, noise: Option<f64>) -> f64 {
        let samples = done as f64 / self.total.max(1) as f64;
        let time = self.time_s.map_or(0.0, |time_s| (elapsed_s + self.earlier.1) / time_s);
        // Variance falls about as the samples grow.
        let noise = noise.zip(self.noise).map_or(0.0, |(noise, wanted)| (wanted / noise).powi(2));
        samples.max(time).max(noise).min(1.0)
    }
}

impl Watch for Progress {
    fn advanced(&self, samples: u64) {
        let done = self.done.fetch_add(samples, Ordering::Relaxed) + samples;
        // Whoever comes while another looks has nothing to add.
        let Ok(mut last) = self.last.try_lock() else { return };
        if self.style == ProgressArg::None {
            return;
        }
        if self.style == ProgressArg::Bar || (self.style == ProgressArg::Auto && !self.bar.is_hidden()) {
            let share = self.share(done, self.start.elapsed().as_secs_f64(), last.noise);
            self.bar.set_position((share * STEPS as f64) as u64);
            self.bar.set_message(self.report(done, last.noise));
            return;
        }
        if last.line.elapsed() >= LINE_INTERVAL {
            last.line = Instant::now();
            let line = self.report(done, last.noise);
            let percent = 100.0 * self.share(done, self.start.elapsed().as_secs_f64(), last.noise);
            say(&if self.style == ProgressArg::Json { line } else { format!("{percent:3.0} %  {line}") });
        }
    }

    fn stop(&self) -> bool {
        self.signal.load(Ordering::Relaxed) != 0
    }

    fn pass(&self, so_far: &Accumulation) -> u32 {
        if self.style != ProgressArg::None {
            let noise = Some(so_far.noise()).filter(|noise| noise.is_finite());
            self.last.lock().unwrap_or_else(PoisonError::into_inner).noise = noise;
        }
        so_far.usual_pass()
    }
}
