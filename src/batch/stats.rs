//! What a picture cost, as JSON for programs and as one line for people.

use std::path::Path;

use serde::Serialize;

use crate::film::Verdict;
use crate::output::Written;
use crate::render::Survey;

/// Everything measured about one picture. Seconds end in `_s`.
#[derive(Clone, Debug, Serialize)]
pub struct Stats {
    pub version: &'static str,
    pub scene: String,
    pub scene_sha256: String,
    pub width: u32,
    pub height: u32,
    /// Samples that every pixel has, and their mean over the pixels.
    pub spp: u32,
    pub mean_spp: f64,
    /// Estimated relative error of the picture; none from less than two samples.
    pub noise: Option<f64>,
    pub seed: u32,
    pub mode: &'static str,
    pub max_bounces: u32,
    pub threads: usize,
    pub triangles: u64,
    /// Reading and interpreting the scene file.
    pub parse_s: f64,
    pub textures_s: f64,
    pub materials_s: f64,
    pub bvh_s: f64,
    /// All of the above.
    pub load_s: f64,
    /// Wall and user + system seconds of rendering alone.
    pub render_s: f64,
    pub render_cpu_s: f64,
    /// Looking at the scene for further layers.
    pub survey_s: f64,
    pub survey_cpu_s: f64,
    pub denoise_s: f64,
    pub write_s: f64,
    /// Since the process began to load.
    pub total_s: f64,
    pub rays: u64,
    pub shadow_rays: u64,
    pub samples_per_s: f64,
    pub mrays_per_s: f64,
    /// Samples that were not numbers; they count as black.
    pub non_finite: u64,
    /// Samples brighter than 2^32 (4.3e9), which count as that.
    pub beyond_range: u64,
    /// Samples that were scaled down to `--clamp`: the picture is too dark there.
    pub clamped_samples: u64,
    /// Values that were too large for the file's half floats.
    pub clamped: u64,
    /// Pixels whose colour sRGB cannot show (PNG).
    pub out_of_gamut: u64,
    pub peak_rss_mb: f64,
    pub films: Vec<FilmStats>,
}

#[derive(Clone, Debug, Serialize)]
pub struct FilmStats {
    pub material: String,
    pub verdict: Verdict,
}

impl Stats {
    pub fn to_json(&self) -> String {
        let mut text = serde_json::to_string_pretty(self).unwrap_or_default();
        text.push('\n');
        text
    }

    /// Adds what the further layers took.
    pub fn add_layers(&mut self, survey: Option<&Survey>, denoise_s: f64) {
        (self.survey_s, self.survey_cpu_s) = survey.map_or((0.0, 0.0), |survey| (survey.survey_s, survey.survey_cpu_s));
        self.denoise_s = denoise_s;
        self.total_s += self.survey_s + denoise_s;
    }

    /// Adds what writing the picture told.
    pub fn finish(&mut self, written: &Written, write_s: f64) {
        self.clamped = written.clamped;
        self.out_of_gamut = written.out_of_gamut;
        self.write_s = write_s;
        self.total_s += write_s;
    }

    /// The closing line of a render.
    pub fn summary(&self, output: &Path) -> String {
        let noise = self.noise.map(|noise| format!(", noise {:.2} %,", 100.0 * noise)).unwrap_or_default();
        let mut line = format!(
            "{}: {}x{}, {:.0} spp{noise} in {:.2} s (load {:.2} s, write {:.2} s), {:.2} M samples/s, {:.0} MB",
            output.display(),
            self.width,
            self.height,
            self.mean_spp,
            self.render_s,
            self.load_s,
            self.write_s,
            self.samples_per_s * 1e-6,
            self.peak_rss_mb
        );
        for (count, what) in [
            (self.non_finite, "samples were not numbers (please report this)"),
            (self.beyond_range, "samples were brighter than 4.3e9 and count as that"),
            (self.clamped_samples, "samples were clamped: the picture is biased"),
            (self.clamped, "values were too large for half floats (use --float)"),
            (self.out_of_gamut, "pixels are outside sRGB and were brought inside"),
        ] {
            if count > 0 {
                line.push_str(&format!("; {count} {what}"));
            }
        }
        line
    }
}
