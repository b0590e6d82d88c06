//! The animation that a file brings along.

use crate::document::{Changes, Document, PoseError, Quantity};

/// Plays the channels of a document.
pub struct Animation {
    fps: f64,
    /// For each placement, whether a channel moves it.
    pub moves: Vec<bool>,
    /// What has changed in the document since the scene last followed.
    pub changes: Changes,
}

impl Animation {
    pub fn new(document: &Document, fps: f64) -> Self {
        let mut marked = vec![false; document.nodes.len()];
        for channel in &document.channels {
            if let Quantity::Transform { node, .. } = channel.drives {
                marked[node] = true;
            }
        }
        Self { fps, moves: document.placed_under(&marked), changes: Changes::default() }
    }

    /// Frame n is n / fps seconds into the animation, as exporters count.
    pub fn time_s(&self, frame: f64) -> f64 {
        frame / self.fps
    }

    /// Frames from the first key to the last.
    pub fn range(document: &Document, fps: f64) -> Option<(u32, u32)> {
        let times = document.channels.iter().flat_map(|channel| channel.times_s.iter().copied());
        let [first, last] = times.fold([f32::INFINITY, f32::NEG_INFINITY], |[a, b], t| [a.min(t), b.max(t)]);
        let frame = |time_s: f32| (f64::from(time_s) * fps).round().max(0.0) as u32;
        (first <= last).then(|| (frame(first), frame(last)))
    }

    /// Sets the document to a frame.
    ///
    /// # Errors
    /// As [`Document::pose`].
    pub fn pose(&mut self, document: &mut Document, frame: f64) -> Result<(), PoseError> {
        document.pose(self.time_s(frame), &mut self.changes)
    }
}
