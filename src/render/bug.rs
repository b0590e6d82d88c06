//! Panics while rendering: the bug that one sample in a billion meets must not lose the others.

use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::OnceLock;

use super::RenderError;

/// Where a thread is: the pixels of a group, by their numbers in the tile, and the sample.
pub type At<'a> = Cell<Option<(&'a [u32], u32)>>;

/// A pixel and one of its samples.
pub type Place = ([u32; 2], u32);

/// The first panic of a render: where, where that is known, and why.
#[derive(Default)]
pub struct Bug(OnceLock<(Option<Place>, String)>);

impl Bug {
    /// True once a thread has met it: the others have no reason to go on.
    pub fn is_met(&self) -> bool {
        self.0.get().is_some()
    }

    /// What `work` gives, or `None` where it panics; `culprit` then finds the pixel and the sample.
    pub fn guard<T>(&self, work: impl FnOnce() -> T, culprit: impl FnOnce() -> Option<Place>) -> Option<T> {
        // A tile takes over what was rendered only once all of it is there: half of it is never seen.
        match catch_unwind(AssertUnwindSafe(work)) {
            Ok(done) => Some(done),
            Err(panic) => {
                self.0.get_or_init(|| (culprit(), words(&*panic)));
                None
            }
        }
    }

    pub fn into_result(self) -> Result<(), RenderError> {
        match self.0.into_inner() {
            None => Ok(()),
            Some((at, reason)) => Err(RenderError::Bug { at, reason }),
        }
    }
}

/// True where `work` panics.
pub fn panics(work: impl FnOnce()) -> bool {
    catch_unwind(AssertUnwindSafe(work)).is_err()
}

fn words(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied().or(panic.downcast_ref::<String>().map(String::as_str));
    text.unwrap_or("no reason given").to_owned()
}
