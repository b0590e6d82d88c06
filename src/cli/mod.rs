//! The command line. The only room that prints.

mod animate;
mod batch_progress;
mod chart;
mod check;
mod compare;
mod denoise_args;
mod encode;
mod file_args;
mod film;
mod memory_args;
mod merge;
mod progress;
mod raster_args;
mod render;
mod sampling;
mod scene_args;
mod sequence;
mod stack_args;
mod stops;
mod turntable;

use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;
use std::sync::LazyLock;

use clap::{Parser, Subcommand};

use crate::embree;
use crate::error::Error;

/// A path tracer for iridescence: light interfering in thin films.
#[derive(Parser)]
#[command(version = VERSION.as_str(), propagate_version = true, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Render(Box<render::RenderArgs>),
    Turntable(Box<turntable::TurntableArgs>),
    Animate(Box<animate::AnimateArgs>),
    Check(check::CheckArgs),
    Film(Box<film::FilmArgs>),
    Merge(merge::MergeArgs),
    Encode(encode::EncodeArgs),
    Compare(compare::CompareArgs),
    Chart(Box<chart::ChartArgs>),
}

/// Understands a command line, the program's name first.
///
/// # Errors
/// What is wrong with it, or the help that it asks for.
pub fn parse(words: impl IntoIterator<Item = OsString>) -> Result<Cli, clap::Error> {
    Cli::try_parse_from(words)
}

/// Runs the program: 0 when all is done, else the code that [`Error::exit_code`] documents.
pub fn main() -> ExitCode {
    let cli = parse(std::env::args_os()).unwrap_or_else(|error| error.exit());
    let result = match cli.command {
        Command::Render(args) => render::run(&args),
        Command::Turntable(args) => turntable::run(&args),
        Command::Animate(args) => animate::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Film(args) => film::run(&args),
        Command::Merge(args) => merge::run(&args),
        Command::Encode(args) => encode::run(&args),
        Command::Chart(args) => chart::run(&args),
        Command::Compare(args) => compare::run(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            say(&format!("error: {error}"));
            ExitCode::from(error.exit_code())
        }
    }
}

/// One line for people, on stderr; a closed stderr is no reason to stop.
fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Text that was asked for, on stdout; a reader that went away (`| head`) is no error.
fn print(text: &str) -> Result<(), Error> {
    let _ = std::io::stdout().write_all(text.as_bytes());
    Ok(())
}

static VERSION: LazyLock<String> = LazyLock::new(|| {
    let mut features = Vec::new();
    #[cfg(target_arch = "x86_64")]
    {
        for (name, present) in [
            ("avx512f", std::arch::is_x86_feature_detected!("avx512f")),
            ("avx2", std::arch::is_x86_feature_detected!("avx2")),
            ("fma", std::arch::is_x86_feature_detected!("fma")),
            ("sse4.2", std::arch::is_x86_feature_detected!("sse4.2")),
        ] {
            if present {
                features.push(name);
            }
        }
    }
    format!("{} (Embree {}; CPU: {})", env!("CARGO_PKG_VERSION"), embree::version(), features.join(" "))
});
