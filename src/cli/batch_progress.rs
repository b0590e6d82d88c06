//! Progress of a batch on stderr: which frame, how long one takes, how long it will take.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::progress::ProgressArg;
use super::say;
use crate::batch::Row;
use crate::render::Watch;

/// Seconds between lines when there is no terminal to draw a bar on.
const LINE_INTERVAL: Duration = Duration::from_secs(10);

/// Shows how far a batch is, and stops its frames after SIGINT or SIGTERM.
pub struct BatchProgress {
    style: ProgressArg,
    bar: ProgressBar,
    count: usize,
    signal: Arc<AtomicUsize>,
    state: Mutex<State>,
}

struct State {
    start: Instant,
    last_line: Instant,
    /// Frames that are done, and the seconds that they took without loading.
    done: usize,
    spent_s: f64,
}

impl BatchProgress {
    pub fn new(style: ProgressArg, count: usize, signal: Arc<AtomicUsize>) -> Self {
        let target = match style {
            ProgressArg::Auto => ProgressDrawTarget::stderr(),
            ProgressArg::Bar => ProgressDrawTarget::stderr_with_hz(10),
            ProgressArg::Json | ProgressArg::None => ProgressDrawTarget::hidden(),
        };
        let bar = ProgressBar::with_draw_target(Some(count as u64), target);
        let template = "{bar:32} {elapsed} elapsed  {msg}";
        bar.set_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()));
        let now = Instant::now();
        let state = Mutex::new(State { start: now, last_line: now, done: 0, spent_s: 0.0 });
        Self { style, bar, count, signal, state }
    }

    /// The next frame begins.
    pub fn begin(&self, frame: u32) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let message = state.message(frame, self.count);
        self.bar.set_message(message.clone());
        let lines = match self.style {
            ProgressArg::Auto => self.bar.is_hidden(),
            ProgressArg::Json => true,
            ProgressArg::Bar | ProgressArg::None => false,
        };
        if lines && (state.done == 0 || state.last_line.elapsed() >= LINE_INTERVAL) {
            state.last_line = Instant::now();
            let line = if self.style == ProgressArg::Json { state.json(frame, self.count) } else { message };
            say(&line);
        }
    }

    /// A frame has been made.
    pub fn end(&self, row: &Row) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.done += 1;
        // What was spent once does not come again.
        let once_s = if row.bvh_builds > 0 {
            row.parse_s + row.textures_s + row.bvh_s + row.materials_s + row.pilot_s
        } else {
            0.0
        };
        state.spent_s += row.total_s - once_s;
        self.bar.inc(1);
    }

    pub fn finish(&self) {
        self.bar.finish_and_clear();
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if self.style == ProgressArg::Json {
            say(&format!(r#"{{"done":{},"of":{},"left_s":0}}"#, state.done, self.count));
        }
    }
}

impl State {
    fn each_s(&self) -> Option<f64> {
        (self.done > 0).then(|| self.spent_s / self.done as f64)
    }

    fn message(&self, frame: u32, count: usize) -> String {
        let place = format!("frame {} of {count}", self.done + 1);
        // The number says more only where the list does not begin at 0 or 1 and go on from there.
        let is_plain = [self.done, self.done + 1].contains(&(frame as usize));
        let number = if is_plain { String::new() } else { format!(" (number {frame})") };
        match self.each_s() {
            None => format!("{place}{number}"),
            Some(each_s) => {
                let left_s = each_s * (count - self.done) as f64;
                format!("{place}{number}, {each_s:.1} s each, {} left", in_words(left_s))
            }
        }
    }

    fn json(&self, frame: u32, count: usize) -> String {
        let elapsed_s = self.start.elapsed().as_secs_f64();
        let times = match self.each_s() {
            None => String::new(),
            Some(each_s) => format!(r#","each_s":{each_s:.2},"left_s":{:.1}"#, each_s * (count - self.done) as f64),
        };
        format!(r#"{{"frame":{frame},"done":{},"of":{count},"elapsed_s":{elapsed_s:.1}{times}}}"#, self.done)
    }
}

/// As people say it: "35 s", "4 min", "2 h 10 min".
fn in_words(seconds: f64) -> String {
    let minutes = (seconds / 60.0).round() as u64;
    match minutes {
        _ if seconds < 90.0 => format!("{seconds:.0} s"),
        0..90 => format!("{minutes} min"),
        _ => format!("{} h {} min", minutes / 60, minutes % 60),
    }
}

impl Watch for BatchProgress {
    fn advanced(&self, _samples: u64) {
        self.bar.tick();
    }

    fn stop(&self) -> bool {
        self.signal.load(Ordering::Relaxed) != 0
    }
}
