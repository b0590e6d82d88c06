//! The command line. The only room that prints.

mod animate;
mod batch_progress;
mod chart;
mod check;
mod compare;
mod completions;
mod denoise_args;
mod encode;
mod file_args;
mod film;
mod man;
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
#[command(version, long_version = LONG_VERSION.as_str(), propagate_version = true, max_term_width = 100)]
#[command(after_help = "Examples:
  pellicle render scenes/titanium.dae -o titanium.png
  pellicle render model.obj --material \"conductor Au; film 550nm n=1.33\" --environment studio -o gold.png
  pellicle turntable scenes/titanium.dae -o frames/f.####.png --frames 120 --video titanium.mp4

`pellicle COMMAND --help` explains a command, with examples; `pellicle man | man -l -` is all of it to read.")]
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
    Completions(completions::CompletionsArgs),
    Man(man::ManArgs),
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
        Command::Completions(args) => completions::run(&args),
        Command::Man(args) => man::run(&args),
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

/// The instruction sets that matter here.
macro_rules! instruction_sets {
    ($has:ident) => {
        [("avx512f", $has!("avx512f")), ("avx2", $has!("avx2")), ("fma", $has!("fma")), ("sse4.2", $has!("sse4.2"))]
    };
}

/// Embree picks its own instructions when it starts; the program has those that it was compiled for.
static LONG_VERSION: LazyLock<String> = LazyLock::new(|| {
    macro_rules! compiled {
        ($name:tt) => {
            cfg!(target_feature = $name)
        };
    }
    let names = |sets: [(&'static str, bool); 4]| {
        let present: Vec<&str> = sets.into_iter().filter(|set| set.1).map(|set| set.0).collect();
        if present.is_empty() { "nothing beyond the basics".to_owned() } else { present.join(" ") }
    };
    #[cfg(target_arch = "x86_64")]
    let cpu = names(instruction_sets!(is_x86_feature_detected));
    #[cfg(not(target_arch = "x86_64"))]
    let cpu = std::env::consts::ARCH.to_owned();
    let (version, embree) = (env!("CARGO_PKG_VERSION"), embree::version());
    let compiled = names(instruction_sets!(compiled));
    format!("{version}\nEmbree {embree}\nCPU: {cpu}\ncompiled for: {compiled}")
});
