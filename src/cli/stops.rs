//! What ends a render early, and what shows it on the way.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize};
use std::time::{Duration, Instant};

use clap::Args;
use signal_hook::consts::{SIGINT, SIGTERM};

use super::sampling::{Target, parse_interval};
use super::sequence::{MOST_SPP, parse_duration, parse_positive};
use crate::batch::budget::Limit;
use crate::batch::live::{Preview, Shows};
use crate::batch::still::{Look, StillPlan};
use crate::error::Error;
use crate::output::{self, Format, Viewer};
use crate::render::Accumulation;

/// When a still ends besides at its number of samples.
#[derive(Args)]
pub struct StopArgs {
    /// Stop rendering after this time, like `20s` or `10m`; --spp is the most it takes then
    #[arg(long, value_name = "TIME", value_parser = parse_duration, help_heading = "Progress")]
    time: Option<f64>,
    /// Stop when the picture's estimated relative error is below this, like 0.01, with samples where they help most; --spp is
    /// the most a pixel takes then
    #[arg(long, value_name = "X", value_parser = parse_positive, help_heading = "Progress")]
    noise: Option<f64>,
}

impl StopArgs {
    /// Puts the stops into the plan; `spp` is what the user asked for.
    pub fn apply(&self, plan: &mut StillPlan, spp: Option<u32>, target: Target) -> Result<(), Error> {
        if self.time.is_none() && self.noise.is_none() {
            return Ok(());
        }
        if target == Target::Part {
            let reason = "a part has all the samples that it is asked for: leave --time and --noise to whole pictures";
            return Err(Error::Usage(reason.to_owned()));
        }
        plan.render.noise = self.noise;
        plan.render.spp = spp.unwrap_or(MOST_SPP);
        Ok(())
    }

    /// What is left for these sums, and the moment from which on it counts.
    pub fn limit(&self, sums: &Accumulation) -> (Limit, Instant) {
        let (now, earlier) = (Instant::now(), Duration::try_from_secs_f64(sums.render_s).unwrap_or_default());
        let limit = Limit { spp: sums.samples.len() as u32, time_s: self.time, noise: None };
        (limit, now.checked_sub(earlier).unwrap_or(now))
    }
}

/// Where pictures are shown while they are rendered: shared by every subcommand that renders.
#[derive(Args)]
pub struct DisplayArgs {
    /// Show the picture in the viewer `tev` that listens there, pass by pass; the usual port is 14158
    #[arg(long, value_name = "HOST[:PORT]", help_heading = "Progress")]
    display: Option<String>,
}

impl DisplayArgs {
    /// A picture of this name and size in the viewer, if there is to be one.
    pub fn open(&self, name: &str, size: [u32; 2]) -> Result<Option<Viewer>, Error> {
        Ok(self.display.as_deref().map(|address| Viewer::open(address, name, size)).transpose()?)
    }
}

/// A file to look at.
#[derive(Args)]
pub struct PreviewArgs {
    /// Write the picture as it is so far to this .png or .exr now and then, whole each time
    #[arg(long, value_name = "FILE", help_heading = "Progress")]
    preview: Option<PathBuf>,
    /// Least time between two previews
    #[arg(long, value_name = "TIME", value_parser = parse_interval, default_value = "10s", help_heading = "Progress")]
    preview_every: Duration,
}

impl PreviewArgs {
    /// Proves that the preview can be written.
    pub fn check(&self) -> Result<Option<(PathBuf, Format)>, Error> {
        let checked = self.preview.as_ref().map(|path| Ok((path.clone(), output::check_picture(path)?)));
        checked.transpose()
    }

    pub fn shows(&self, viewer: Option<Viewer>, checked: Option<(PathBuf, Format)>, look: Look) -> Shows {
        let preview = checked.map(|(path, format)| Preview { path, format, look, every: self.preview_every });
        Shows { viewer, preview }
    }
}

/// The number of the signal that asked the program to end, 0 until then. A second one ends it at once.
pub fn signals() -> Arc<AtomicUsize> {
    let signal = Arc::new(AtomicUsize::new(0));
    let armed = Arc::new(AtomicBool::new(false));
    for number in [SIGINT, SIGTERM] {
        // The order matters: the shutdown looks at the flag before the first signal sets it.
        let code = 128 + number;
        let _ = signal_hook::flag::register_conditional_shutdown(number, code, armed.clone());
        let _ = signal_hook::flag::register(number, armed.clone());
        let _ = signal_hook::flag::register_usize(number, signal.clone(), number as usize);
    }
    signal
}
