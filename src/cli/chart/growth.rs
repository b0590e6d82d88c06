//! `pellicle chart growth`.

use std::path::PathBuf;
use std::process::Command;

use clap::Args;

use super::{check_base, write};
use crate::cli::memory_args::MemoryArgs;
use crate::cli::render::parse_threads;
use crate::cli::{print, say};
use crate::error::Error;
use crate::study::growth::{GrowthChart, Kind, Machine, Reach, Series, Step, step};

/// How cost grows: over triangles, lights, pixels, bounces and lanes
///
/// Builds and renders scenes that are made in memory and grow in one thing each: up to 10 million triangles, 10 000 lights,
/// 4096 x 4096 pixels, 64 bounces, 16 wavelengths. Takes minutes and about 2 GB of memory.
#[derive(Args)]
#[command(after_help = "Examples:
  pellicle chart growth -o growth
  pellicle chart growth --quick

Seconds are processor seconds over threads. Exponents are those of size^exponent, fitted over all sizes and over the larger
half of them.")]
pub struct GrowthArgs {
    /// Write NAME.csv, NAME.svg and NAME.png; without it only the table is printed
    #[arg(short, long, value_name = "NAME")]
    output: Option<PathBuf>,
    /// Only the small end of each range, in seconds: for a first look
    #[arg(long)]
    quick: bool,
    /// Threads; 0 = all processors
    #[arg(short, long, value_name = "N", default_value_t = 0, value_parser = parse_threads)]
    threads: usize,
    #[command(flatten)]
    memory: MemoryArgs,
    /// Measure one size and print it as JSON: this command runs itself so, to begin each with the same empty memory
    #[arg(long, value_name = "SERIES:SIZE", hide = true, value_parser = parse_one)]
    one: Option<(Kind, u64)>,
}

pub fn run(args: &GrowthArgs) -> Result<(), Error> {
    if let Some((kind, size)) = args.one {
        let step = step(kind, size, args.reach(), &args.machine())?;
        return print(&serde_json::to_string(&step).unwrap_or_default());
    }
    if let Some(base) = &args.output {
        check_base(base)?;
    }
    let mut all = Vec::new();
    for kind in Kind::ALL {
        let mut steps = Vec::new();
        for size in kind.sizes(args.reach()) {
            say(&kind.label(size));
            steps.push(args.apart(kind, size)?);
        }
        all.push(Series { kind, steps });
    }
    let chart = GrowthChart::new(all);
    print(&chart.table())?;
    if let Some(base) = &args.output {
        let (svg, png) = chart.draw().map_err(|error| Error::Usage(error.to_string()))?;
        write(base, &chart.csv(), &svg, &png)?;
    }
    Ok(())
}

impl GrowthArgs {
    fn reach(&self) -> Reach {
        if self.quick { Reach::Quick } else { Reach::Full }
    }

    fn machine(&self) -> Machine {
        Machine { threads: self.threads, max_memory: self.memory.most() }
    }

    /// Measures a size in a process of its own.
    fn apart(&self, kind: Kind, size: u64) -> Result<Step, Error> {
        let label = kind.label(size);
        let failed = |reason: &str| Error::Beyond(format!("{label}: {reason}"));
        let Machine { threads, max_memory } = self.machine();
        let mut command = Command::new(std::env::current_exe().map_err(|error| failed(&error.to_string()))?);
        command.args(["chart", "growth", "--one", &format!("{}:{size}", kind.name())]);
        command.args(["--threads", &threads.to_string(), "--max-memory", &max_memory.to_string()]);
        command.args(self.quick.then_some("--quick"));
        let output = command.output().map_err(|error| failed(&error.to_string()))?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            let reason = said.trim().strip_prefix("error: ").map(str::to_owned);
            // Without a word: killed, most likely for the memory that it took.
            return Err(Error::Beyond(reason.unwrap_or_else(|| format!("{label}: {}", output.status))));
        }
        serde_json::from_slice(&output.stdout).map_err(|error| failed(&error.to_string()))
    }
}

/// `SERIES:SIZE`
fn parse_one(text: &str) -> Result<(Kind, u64), String> {
    let parts = text.split_once(':').and_then(|(name, size)| {
        let kind = Kind::ALL.into_iter().find(|kind| kind.name() == name)?;
        Some((kind, size.parse().ok()?))
    });
    parts.filter(|(_, size)| *size > 0).ok_or_else(|| "write it as SERIES:SIZE, like `lights:100`".to_owned())
}
