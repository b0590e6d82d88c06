//! Long stills that can be stopped: the sums so far in a part file beside the output, and on from there. The finished picture
//! has the same bits as that of an unbroken render.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::part::{self, Part, PartHeader, Settings};
use super::still::{Prepared, StillPlan};
use crate::document::Document;
use crate::error::Error;
use crate::mode::Mode;
use crate::output::OutputError;
use crate::render::{Accumulation, RenderError, Watch};

/// Saves the sums of a render to part files, and finds them again.
pub struct Saver<'a, M: Mode> {
    prepared: &'a Prepared<M>,
    document: &'a Document,
    plan: &'a StillPlan,
    settings: Settings,
    /// Where the sums of the unfinished render are kept.
    pub checkpoint: PathBuf,
}

impl<'a, M: Mode> Saver<'a, M> {
    /// `reading` tells how the scene file was read, `output` where the render will go.
    ///
    /// # Errors
    /// An image that can no longer be read.
    pub fn new(
        prepared: &'a Prepared<M>,
        document: &'a Document,
        plan: &'a StillPlan,
        reading: String,
        output: &Path,
    ) -> Result<Self, Error> {
        let settings = Settings::new(document, plan, reading, prepared.camera.size, M::NAME)?;
        let mut checkpoint = output.as_os_str().to_owned();
        checkpoint.push(".checkpoint");
        Ok(Self { prepared, document, plan, settings, checkpoint: checkpoint.into() })
    }

    /// # Errors
    /// The file cannot be written.
    pub fn save(&self, path: &Path, sums: &Accumulation) -> Result<(), Error> {
        part::save(path, &PartHeader::new(&self.settings, self.prepared, self.document, self.plan, sums), sums)
    }

    /// The sums that a part file holds, finished or not; `None`, after telling why, where it is missing or damaged.
    ///
    /// # Errors
    /// A part of other settings.
    pub fn restore(
        &self,
        path: &Path,
        samples: &Range<u32>,
        tell: impl Fn(&str),
    ) -> Result<Option<Accumulation>, Error> {
        if !path.exists() {
            return Ok(None);
        }
        let restored = Part::open(path).and_then(|part| {
            let other = self.settings.difference(&part.header.settings).or_else(|| {
                let [ours, theirs] = [samples, &part.header.samples].map(|range| format!("{range:?}"));
                (ours != theirs).then(|| ("samples".to_owned(), ours, theirs))
            });
            match other {
                None => part.restore(),
                Some((name, ours, theirs)) => Err(Error::Usage(format!(
                    "cannot go on from {}: {name} was {theirs} there and is {ours} now; use the same options, or remove that file to start anew",
                    path.display()
                ))),
            }
        });
        match restored {
            Err(Error::Output(error @ OutputError::Damaged { .. })) => {
                tell(&format!("warning: {error}; rendering it again"));
                Ok(None)
            }
            Ok(sums) => {
                tell(&format!("going on from {} at {} samples per pixel", path.display(), sums.spp()));
                Ok(Some(sums))
            }
            Err(error) => Err(error),
        }
    }

    /// Renders what `sums` lacks; saves the checkpoint every so often, and when the watch or a bug stops it before the end:
    /// false, or the error, then.
    ///
    /// # Errors
    /// As rendering; or the checkpoint cannot be written.
    pub fn accumulate(&self, sums: &mut Accumulation, every: Duration, watch: &dyn Watch) -> Result<bool, Error> {
        loop {
            let pause = Pause { watch, at: Instant::now().checked_add(every) };
            let whole = self.prepared.accumulate(self.plan, sums, &pause);
            if !matches!(whole, Ok(false) | Err(Error::Render(RenderError::Bug { .. }))) {
                return whole;
            }
            self.save(&self.checkpoint, sums)?;
            if whole.is_err() || watch.stop() {
                return whole;
            }
        }
    }

    /// The render is done, and its result written.
    pub fn forget(&self) {
        // A checkpoint that stays is only in the way of other settings, and then says so.
        let _ = std::fs::remove_file(&self.checkpoint);
    }
}

/// Stops at a time, or when the other watch does.
struct Pause<'a> {
    watch: &'a dyn Watch,
    at: Option<Instant>,
}

impl Watch for Pause<'_> {
    fn advanced(&self, samples: u64) {
        self.watch.advanced(samples);
    }

    fn stop(&self) -> bool {
        self.watch.stop() || self.at.is_some_and(|at| Instant::now() >= at)
    }

    fn pass(&self, so_far: &Accumulation) -> u32 {
        self.watch.pass(so_far)
    }

    fn done(&self, sums: &Accumulation) {
        self.watch.done(sums);
    }
}
