//! `pellicle merge`: the parts of one picture.

use std::path::PathBuf;

use clap::Args;

use super::render::{AovArg, aovs, check_aovs};
use super::{print, say};
use crate::batch::merge::Merge;
use crate::batch::still::{self, Look};
use crate::error::Error;
use crate::output::{self, PngDepth};

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
    /// Bits per channel of PNG pictures
    #[arg(long, value_name = "BITS", value_parser = ["8", "16"], default_value = "8")]
    png_depth: String,
    /// Write 32-bit instead of 16-bit floats to EXR
    #[arg(long)]
    float: bool,
    /// More layers for EXR, with commas between them
    #[arg(long = "aov", value_name = "LIST", value_enum, value_delimiter = ',')]
    aovs: Vec<AovArg>,
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
    check_aovs(&args.output, format, &args.aovs)?;
    let merge = Merge::plan(&args.parts, args.partial)?;
    let sums = merge.run(|part| inform(&format!("adding {}", part.display())))?;

    let frame = sums.into_frame();
    let look = Look {
        exposure_ev: args.exposure.unwrap_or(merge.header.exposure_ev),
        png_depth: if args.png_depth == "16" { PngDepth::Sixteen } else { PngDepth::Eight },
        float: args.float,
    };
    let picture = still::picture(&frame, &aovs(&args.aovs), merge.header.picture.clone());
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
