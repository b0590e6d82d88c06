//! Progress on stderr: a bar on a terminal, a line now and then elsewhere, or JSON lines.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::say;
use crate::render::Watch;

/// Seconds between lines when there is no terminal to draw a bar on.
const LINE_INTERVAL: Duration = Duration::from_secs(10);

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
    total: u64,
    done: AtomicU64,
    start: Instant,
    last_line: Mutex<Instant>,
    /// The signal that arrived, 0 for none.
    signal: Arc<AtomicUsize>,
}

impl Progress {
    /// `total` is in pixel samples.
    pub fn new(style: ProgressArg, total: u64, signal: Arc<AtomicUsize>) -> Self {
        let target = match style {
            ProgressArg::Auto => ProgressDrawTarget::stderr(),
            ProgressArg::Bar => ProgressDrawTarget::stderr_with_hz(10),
            ProgressArg::Json | ProgressArg::None => ProgressDrawTarget::hidden(),
        };
        let bar = ProgressBar::with_draw_target(Some(total), target);
        let template = "{bar:32} {percent:>3} %  {elapsed} elapsed, {eta} left  {msg}";
        bar.set_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()));
        let start = Instant::now();
        Self { style, bar, total, done: AtomicU64::new(0), start, last_line: Mutex::new(start), signal }
    }

    pub fn finish(&self) {
        self.bar.finish_and_clear();
        if self.style == ProgressArg::Json {
            self.report(self.done.load(Ordering::Relaxed));
        }
    }

    /// Reports where the last line is some time ago.
    fn line(&self, done: u64) {
        let Ok(mut last) = self.last_line.try_lock() else { return };
        let now = Instant::now();
        if now - *last < LINE_INTERVAL {
            return;
        }
        *last = now;
        self.report(done);
    }

    fn report(&self, done: u64) {
        let elapsed_s = self.start.elapsed().as_secs_f64();
        let share = done as f64 / self.total.max(1) as f64;
        let left_s = elapsed_s * (1.0 - share) / share.max(1e-9);
        if self.style == ProgressArg::Json {
            say(&format!(r#"{{"done":{share:.4},"elapsed_s":{elapsed_s:.1},"left_s":{left_s:.1}}}"#));
        } else {
            say(&format!("{:3.0} %  {elapsed_s:.0} s elapsed, {left_s:.0} s left", share * 100.0));
        }
    }
}

impl Watch for Progress {
    fn advanced(&self, samples: u64) {
        let done = self.done.fetch_add(samples, Ordering::Relaxed) + samples;
        self.bar.inc(samples);
        let lines = match self.style {
            ProgressArg::Auto => self.bar.is_hidden(),
            ProgressArg::Json => true,
            ProgressArg::Bar | ProgressArg::None => false,
        };
        if lines {
            self.line(done);
        }
    }

    fn stop(&self) -> bool {
        self.signal.load(Ordering::Relaxed) != 0
    }
}
