//! `pellicle merge`: the parts of one picture.

use std::path::PathBuf;

use clap::Args;

use super::file_args::FileArgs;
use super::memory_args::MemoryArgs;
use super::{print, say};
use crate::batch::aov::{Aov, Layers};
use crate::batch::merge::Merge;
use crate::batch::still;
use crate::error::Error;
use crate::output::{self, Display};

/// Merge the parts that `render --samples` wrote into one picture
///
/// The picture has the same bits as one that was rendered in one piece, however it was split.
#[derive(Args)]
#[command(after_help = "Examples:
  pellicle render scene.dae --spp 1024 --samples 0:512 -o a.part
  pellicle render scene.dae --spp 1024 --samples 512:1024 -o b.part
  pellicle merge a.part b.part -o still.exr")]
pub struct MergeArgs {
    /// Parts of one picture, in any order
    #[arg(value_name = "PARTS", required = true)]
    parts: Vec<PathBuf>,
    /// Where to write the picture: .exr or .png
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Merge what is there, even if samples are missing
    #[arg(long)]
    partial: bool,
    /// Print the SHA-256 of the pixels' values
    #[arg(long)]
    hash: bool,
    /// Brightness of PNG pictures, in stops [default: as rendered]
    #[arg(long, value_name = "EV", allow_negative_numbers = true)]
    exposure: Option<f32>,
    #[command(flatten)]
    file: FileArgs,
    #[command(flatten)]
    memory: MemoryArgs,
    /// Say nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

pub fn run(args: &MergeArgs) -> Result<(), Error> {
    let inform = |line: &str| {
        if !args.quiet {
            say(line);
        }
    };
    let format = output::check_picture(&args.output)?;
    args.file.check_merge()?;
    let merge = Merge::plan(&args.parts, args.partial, args.memory.most())?;
    let sums = merge.run(|part| inform(&format!("adding {}", part.display())))?;

    let aovs = args.file.aovs();
    let frame = sums.into_frame(aovs.contains(&Aov::Variance));
    let shown = merge.header.display;
    let look = args.file.look(Display { exposure_ev: args.exposure.unwrap_or(shown.exposure_ev), ..shown });
    let layers = Layers::of_frame(&aovs, &frame);
    let picture = still::picture(&frame, layers, merge.header.picture.clone());
    still::write(&args.output, format, &picture, look)?;
    inform(&format!(
        "{}: {}x{}, {} of {} spp from {} parts",
        args.output.display(),
        frame.width,
        frame.height,
        frame.spp,
        merge.header.settings.spp,
        args.parts.len()
    ));
    if args.hash {
        print(&format!("{}\n", frame.sha256()))?;
    }
    Ok(())
}
