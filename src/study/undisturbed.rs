//! Renders that are timed.

use crate::render::Watch;

/// Nobody looks on: what is timed is rendering alone.
pub(super) struct Undisturbed;

impl Watch for Undisturbed {
    fn advanced(&self, _samples: u64) {}
    fn stop(&self) -> bool {
        false
    }
}
