//! `pellicle chart`: error against time, cost against size.

mod convergence;
mod films;
mod growth;

use std::path::Path;

use clap::{Args, Subcommand};

use crate::error::Error;
use crate::output::{self, Display, Picture, PngDepth};

/// Chart error against time, of film models or of whole renders; or cost against size
#[derive(Args)]
#[command(after_help = "Examples:
  pellicle chart films -o films
  pellicle chart convergence scenes/bubbles.dae -o bubbles
  pellicle chart growth -o growth")]
pub struct ChartArgs {
    #[command(subcommand)]
    chart: ChartCommand,
}

#[derive(Subcommand)]
enum ChartCommand {
    Films(films::FilmsArgs),
    Convergence(convergence::ConvergenceArgs),
    Growth(growth::GrowthArgs),
}

pub fn run(args: &ChartArgs) -> Result<(), Error> {
    match &args.chart {
        ChartCommand::Films(args) => films::run(args),
        ChartCommand::Convergence(args) => convergence::run(args),
        ChartCommand::Growth(args) => growth::run(args),
    }
}

/// The files of a chart: NAME.csv, NAME.svg, NAME.png.
const EXTENSIONS: [&str; 3] = ["csv", "svg", "png"];

/// Proves before any work that all three can be written.
fn check_base(base: &Path) -> Result<(), Error> {
    for extension in EXTENSIONS {
        output::check_writable(&named(base, extension))?;
    }
    Ok(())
}

fn write(base: &Path, csv: &str, svg: &str, png: &Picture) -> Result<(), Error> {
    output::write_text(&named(base, "csv"), csv)?;
    output::write_text(&named(base, "svg"), svg)?;
    output::write_png(&named(base, "png"), png, Display::PLAIN, PngDepth::Eight)?;
    Ok(())
}

/// Adds an extension and replaces none: `run.2` becomes `run.2.csv`.
fn named(base: &Path, extension: &str) -> std::path::PathBuf {
    let mut name = base.as_os_str().to_owned();
    name.push(".");
    name.push(extension);
    name.into()
}
