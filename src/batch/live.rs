//! A picture to look at while it is rendered: in a viewer, and as a file that is renewed.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::still::{self, Look};
use crate::output::{Format, Picture, Viewer};
use crate::render::{Accumulation, Watch};
use crate::scene::Window;

/// A viewer gets the picture no more often than this.
const VIEW_EVERY: Duration = Duration::from_millis(500);
/// Showing may take this share of the time: one in so many seconds.
const SHARE: u32 = 50;

/// Where a picture is shown.
#[derive(Default)]
pub struct Shows {
    pub viewer: Option<Viewer>,
    pub preview: Option<Preview>,
}

/// A picture file, and the least time between two versions of it.
pub struct Preview {
    pub path: PathBuf,
    pub format: Format,
    pub look: Look,
    pub every: Duration,
}

/// Shows the picture between passes and at the end, within a small share of the time. What can no longer be shown is told
/// once, by `tell`, and the render goes on.
pub struct Live<'a, T: Fn(&str) + Sync> {
    watch: &'a dyn Watch,
    shows: Mutex<(Shows, Due)>,
    tell: T,
}

/// When each is shown next.
struct Due {
    viewer: Instant,
    preview: Instant,
}

impl<'a, T: Fn(&str) + Sync> Live<'a, T> {
    pub fn new(watch: &'a dyn Watch, shows: Shows, tell: T) -> Self {
        let now = Instant::now();
        Self { watch, shows: Mutex::new((shows, Due { viewer: now, preview: now })), tell }
    }

    /// `last`: whatever was shown just now.
    fn show(&self, sums: &Accumulation, last: bool) {
        let mut shows = self.shows.lock().unwrap_or_else(PoisonError::into_inner);
        let (Shows { viewer, preview }, due) = &mut *shows;
        let now = Instant::now();
        let views = viewer.is_some() && (last || now >= due.viewer);
        let writes = preview.is_some() && (last || now >= due.preview);
        if !(views || writes) || sums.spp() == 0 {
            return;
        }
        let rgb = sums.rgb();
        if let Some(open) = viewer.as_mut().filter(|_| views) {
            if let Err(error) = open.update(&rgb) {
                (self.tell)(&format!("warning: the viewer is gone ({error}); rendering goes on without it"));
                *viewer = None;
            }
            due.viewer = next(now, VIEW_EVERY);
        }
        if let Some(file) = preview.as_mut().filter(|_| writes) {
            let rgba = rgb.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect();
            let Window { width, height, .. } = sums.window;
            let picture = Picture { width, height, rgba, header: still::progress(sums), ..Picture::default() };
            let (every, written) = (file.every, still::write(&file.path, file.format, &picture, file.look));
            if let Err(error) = written {
                (self.tell)(&format!("warning: no more previews: {error}"));
                *preview = None;
            }
            due.preview = next(now, every);
        }
    }
}

/// When to show again what was begun to be shown at `begun`.
fn next(begun: Instant, every: Duration) -> Instant {
    begun + every.max(begun.elapsed() * SHARE)
}

impl<T: Fn(&str) + Sync> Watch for Live<'_, T> {
    fn advanced(&self, samples: u64) {
        self.watch.advanced(samples);
    }

    fn stop(&self) -> bool {
        self.watch.stop()
    }

    fn pass(&self, so_far: &Accumulation) -> u32 {
        self.show(so_far, false);
        self.watch.pass(so_far)
    }

    fn done(&self, sums: &Accumulation) {
        self.show(sums, true);
        self.watch.done(sums);
    }
}
