//! Options for stills that are rendered in pieces: on several machines, or with interruptions.

use std::ops::Range;
use std::path::Path;
use std::time::Duration;

use clap::Args;

use super::sequence::parse_duration;
use crate::error::Error;
use crate::output::{self, Format};

#[derive(Args)]
pub struct SamplingArgs {
    /// Only samples A to B - 1 of the --spp of each pixel, into a .part for `pellicle merge`
    #[arg(long, value_name = "A:B", value_parser = parse_range, help_heading = "In pieces")]
    samples: Option<Range<u32>>,
    /// Save the render so far to OUTPUT.checkpoint this often (`90s`, `5m`, `2h`), and when a signal ends it (exit code 75)
    #[arg(long, value_name = "TIME", value_parser = parse_interval, help_heading = "In pieces")]
    checkpoint: Option<Duration>,
    /// Go on from OUTPUT.checkpoint where there is one; implies --checkpoint 5m
    #[arg(long, help_heading = "In pieces")]
    pub resume: bool,
    /// Print the SHA-256 of the pixels' values
    #[arg(long, help_heading = "In pieces")]
    pub hash: bool,
}

/// What becomes of the samples.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Target {
    Picture(Format),
    Part,
}

impl SamplingArgs {
    /// Proves that the output can be written.
    pub fn target(&self, output: &Path) -> Result<Target, Error> {
        let is_part = output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("part"));
        if is_part {
            output::check_writable(output)?;
            return Ok(Target::Part);
        }
        if let Some(Range { start, end }) = &self.samples {
            return Err(Error::Usage(format!(
                "--samples gives a part of a picture, to be merged with others: name it like `-o {}`",
                output.with_extension(format!("{start}-{end}.part")).display()
            )));
        }
        Ok(Target::Picture(output::check_picture(output)?))
    }

    /// How often the render is saved, if at all.
    pub fn checkpoint(&self) -> Option<Duration> {
        self.checkpoint.or(self.resume.then_some(Duration::from_secs(300)))
    }

    pub fn range(&self, spp: u32) -> Result<Range<u32>, Error> {
        match &self.samples {
            None => Ok(0..spp),
            Some(range) if range.end <= spp => Ok(range.clone()),
            Some(Range { start, end }) => Err(Error::Usage(format!(
                "--samples {start}:{end} goes beyond the {spp} samples per pixel of the whole picture; set --spp to the whole's"
            ))),
        }
    }
}

fn parse_range(text: &str) -> Result<Range<u32>, String> {
    let range = text.split_once(':').and_then(|(start, end)| Some(start.parse().ok()?..end.parse().ok()?));
    match range {
        Some(range) if range.start < range.end => Ok(range),
        _ => Err("write it as FIRST:END with FIRST < END, like 0:256".to_owned()),
    }
}

pub fn parse_interval(text: &str) -> Result<Duration, String> {
    Duration::try_from_secs_f64(parse_duration(text)?).map_err(|error| error.to_string())
}
