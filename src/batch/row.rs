//! What one frame cost: a line of the report.

use serde::{Deserialize, Serialize};

/// Seconds end in `_s`; the parts from `parse_s` to `other_s` add up to `total_s`. A frame that failed has zeros.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    pub frame: u32,
    /// Turntable: degrees. Animation: seconds.
    pub moment: f64,
    pub file: String,
    /// `ok`, `failed`, or `unrecorded`: the frame is there, but the program ended before its row was written.
    pub status: String,
    /// Why it failed, or why it is noisy though it should not be.
    pub reason: String,
    pub seed: u32,
    /// Samples per pixel that were taken.
    pub spp: u32,
    /// Rendering time that the frame was allowed, where there was a budget.
    pub budget_s: Option<f64>,
    /// Reading the scene: in the first frame only, as the next four, but for what has changed from frame to frame.
    pub parse_s: f64,
    pub textures_s: f64,
    /// Building BVHs in the first frame, posing the scene in all.
    pub bvh_s: f64,
    pub materials_s: f64,
    /// Choosing the colour mode.
    pub pilot_s: f64,
    pub render_s: f64,
    /// User and system time of all threads; not part of `total_s`.
    pub render_cpu_s: f64,
    pub denoise_s: f64,
    pub write_s: f64,
    /// Everything else.
    pub other_s: f64,
    pub total_s: f64,
    pub rays: u64,
    pub shadow_rays: u64,
    pub mrays_per_s: f64,
    pub samples_per_s: f64,
    /// Estimated relative error of the picture ([`crate::render::Frame::noise`]); none below two samples.
    pub noise: Option<f64>,
    /// The relative error that 95 % of the pixels stay below.
    pub noise_p95: Option<f64>,
    pub non_finite: u64,
    pub clamped: u64,
    pub out_of_gamut: u64,
    /// Whether the scene's BVHs were built for this frame: 1 or 0.
    pub bvh_builds: u32,
    pub instances_moved: usize,
    pub materials_compiled: usize,
    pub peak_rss_mb: f64,
    pub width: u32,
    pub height: u32,
    pub mode: String,
    pub threads: usize,
    pub host: String,
    /// Of the linear pixels.
    pub pixel_sha256: String,
    pub scene_sha256: String,
    /// Stands for everything that decides what the frame looks like.
    pub settings: String,
}

impl Row {
    /// The parts that are stacked in the chart, with their names.
    pub fn parts(&self) -> [(&'static str, f64); 6] {
        [
            ("load", self.parse_s + self.textures_s + self.pilot_s),
            ("bvh", self.bvh_s),
            ("materials", self.materials_s),
            ("render", self.render_s + self.denoise_s),
            ("write", self.write_s),
            ("other", self.other_s),
        ]
    }

    pub fn is_ok(&self) -> bool {
        self.status == "ok"
    }

    pub fn is_failed(&self) -> bool {
        self.status == "failed"
    }

    /// Finds what is left of the total, and cuts seconds to whole microseconds.
    pub(super) fn settle(&mut self) {
        let known: f64 = self.parts().iter().filter(|(name, _)| *name != "other").map(|(_, seconds)| seconds).sum();
        self.other_s = (self.total_s - known).max(0.0);
        for seconds in [
            &mut self.parse_s,
            &mut self.textures_s,
            &mut self.bvh_s,
            &mut self.materials_s,
            &mut self.pilot_s,
            &mut self.render_s,
            &mut self.denoise_s,
            &mut self.write_s,
            &mut self.other_s,
            &mut self.total_s,
        ] {
            *seconds = (*seconds * 1e6).round() / 1e6;
        }
    }
}
