//! Pictures that other programs render.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde::Deserialize;

use crate::error::Error;
use crate::output::{HeaderValue, read_exr};
use crate::study::metrics::Image;

/// A picture of a series that was rendered elsewhere.
#[derive(Clone, Debug, PartialEq)]
pub struct SeriesFile {
    pub path: PathBuf,
    /// Wall seconds; `None`: `renderTimeSeconds` in its header.
    pub seconds: Option<f64>,
}

/// A picture and what it cost.
pub(super) struct Timed {
    pub image: Image,
    /// 0 where it is not known.
    pub spp: u32,
    pub wall_s: f64,
    pub cpu_s: Option<f64>,
    pub threads: usize,
}

/// The fields of `--stats` that matter here.
#[derive(Deserialize)]
struct Stats {
    render_s: f64,
    render_cpu_s: f64,
    spp: u32,
    threads: usize,
}

/// Runs `BINARY render WORDS`, with its picture and its stats in `folder`.
///
/// # Errors
/// What the program said.
pub(super) fn run_other(binary: &Path, words: &[String], folder: &Path) -> Result<Timed, Error> {
    let (picture, stats) = (folder.join("other.exr"), folder.join("other.json"));
    let mut command = Command::new(binary);
    command.arg("render").args(words).arg("--float").arg("--quiet");
    command.arg("-o").arg(&picture).arg("--stats").arg(&stats);
    let failed = |reason: String| Error::Usage(format!("--vs {}: {reason}", binary.display()));
    let output = command.output().map_err(|error| failed(error.to_string()))?;
    if !output.status.success() {
        return Err(failed(String::from_utf8_lossy(&output.stderr).trim().to_owned()));
    }
    let text = std::fs::read_to_string(&stats).map_err(|error| failed(error.to_string()))?;
    let Stats { render_s, render_cpu_s, spp, threads } =
        serde_json::from_str(&text).map_err(|error| failed(format!("its stats: {error}")))?;
    let image = Image::from(&read_exr(&picture)?);
    Ok(Timed { image, spp, wall_s: render_s, cpu_s: Some(render_cpu_s), threads })
}

impl SeriesFile {
    /// # Errors
    /// A picture that cannot be read, is biased, or does not say how long it took.
    pub(super) fn read(&self) -> Result<Timed, Error> {
        let picture = read_exr(&self.path)?;
        let noted = |name: &str| picture.header.iter().find(|(key, _)| key == name).map(|(_, value)| value);
        let file = self.path.display();
        if let Some(HeaderValue::Text(how)) = noted("pellicle/biased") {
            let problem = format!("--series: {file} is biased ({how})");
            return Err(Error::Usage(format!("{problem}; only unbiased pictures can be charted")));
        }
        let wall_s = match (self.seconds, noted("renderTimeSeconds")) {
            (Some(seconds), _) => seconds,
            (None, Some(HeaderValue::Float(seconds))) => f64::from(*seconds),
            (None, _) => {
                let fix = format!("give them, like {file}@12.5");
                return Err(Error::Usage(format!("--series: {file} does not say how many seconds it took; {fix}")));
            }
        };
        let spp = match noted("samplesPerPixel") {
            Some(HeaderValue::Int(spp)) => u32::try_from(*spp).unwrap_or(0),
            _ => 0,
        };
        Ok(Timed { image: Image::from(&picture), spp, wall_s, cpu_s: None, threads: 1 })
    }
}
