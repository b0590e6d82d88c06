//! `pellicle encode`: frames to a video.

use std::path::PathBuf;

use clap::Args;

use super::file_args::ViewArg;
use super::say;
use crate::batch::encode::{EncodePlan, Footage, Target};
use crate::error::Error;
use crate::output::{Container, Display};

/// Make a video of frames
///
/// .mp4 is H.264, .mov ProRes 422 HQ, .webm VP9, .mkv FFV1 (exact), all with their colours tagged, by ffmpeg; .png is an
/// animated PNG of 8 bits, without ffmpeg.
#[derive(Args)]
#[command(after_help = "Examples:
  pellicle encode frames/f.####.png -o turntable.mp4
  pellicle encode frames -o archive.mkv --fps 25
  pellicle encode f.%04d.exr -o web.webm --exposure 1 --quality 24")]
pub struct EncodeArgs {
    /// Frames: a pattern like f.####.png or f.%04d.exr, or a folder that holds one sequence
    #[arg(value_name = "FRAMES")]
    frames: PathBuf,
    /// Where to write the video: .mp4, .mov, .webm, .mkv or .png
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Frames per second
    #[arg(long, value_name = "N", default_value = "24", value_parser = parse_fps)]
    fps: f64,
    /// Quality on the codec's own scale, lower is better: CRF, usually 16 for .mp4 and 20 for .webm; quantiser of .mov, usually 9
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=63))]
    quality: Option<u32>,
    /// Brightness of EXR frames, in stops
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_negative_numbers = true)]
    exposure: f32,
    /// How EXR frames show colours
    #[arg(long, value_name = "NAME", value_enum, default_value = "srgb")]
    view: ViewArg,
    /// Say nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

fn parse_fps(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(fps) if (0.1..=1000.0).contains(&fps) => Ok(fps),
        _ => Err("write a number from 0.1 to 1000, like 24 or 23.976".to_owned()),
    }
}

pub fn run(args: &EncodeArgs) -> Result<(), Error> {
    let inform = |line: &str| {
        if !args.quiet {
            say(line);
        }
    };
    let target = Target::of(&args.output)?;
    if args.quality.is_some() && matches!(target, Target::Apng | Target::Ffmpeg(Container::Mkv)) {
        return Err(Error::Usage(format!("{} loses nothing; leave --quality out", args.output.display())));
    }
    let footage = Footage::find(&args.frames)?;
    let display = Display { exposure_ev: args.exposure, view: args.view.into() };
    let plan = EncodePlan { fps: args.fps, quality: args.quality, display };
    let count = footage.encode(&args.output, target, &plan, inform)?;
    let [width, height] = footage.size;
    let seconds = count as f64 / args.fps;
    inform(&format!("{}: {count} frames of {width}x{height}, {seconds:.2} s", args.output.display()));
    Ok(())
}
