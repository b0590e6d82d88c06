//! `pellicle turntable`: once around the object.

use clap::{Args, ValueEnum};

use super::render::{PictureArgs, TalkArgs};
use super::scene_args::SceneArgs;
use super::sequence::{SequenceArgs, Work};
use crate::batch::frames::Ring;
use crate::batch::sequence::Motion;
use crate::batch::turntable::{Axis, Pivot, Turning, Turntable, TurntablePlan};
use crate::error::Error;

/// Render a turntable: camera, object or light go around once
///
/// The frames close to a ring: frame i stands at i x 360 / N degrees, and frame N, which would be frame 0 again, is not
/// rendered. The scene is loaded and built once. Beside the frames grow frames.csv and frames.json with the time and cost of
/// each, and in the end frames.html.
///
/// Exit codes: 0 all frames are there, 1 some failed (frames.csv has the reasons), 2 usage, 3 a full disk, 75 stopped by a
/// signal: the same command with --resume goes on.
#[derive(Args)]
// `--mode` says what turns here.
#[command(mut_arg("mode", |arg| arg.long("transport")), after_help = "Examples:
  pellicle turntable scenes/titanium.dae -o frames/titanium.####.png --frames 120
  pellicle turntable scene.dae -o f.####.exr --frames 120 --mode light --total-time 2h
  pellicle turntable scene.dae -o f.####.exr --frames 30-59/120 --resume")]
pub struct TurntableArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Frames of the ring: `120`, or `30-59/120` for some of them
    #[arg(long, value_name = "N", value_parser = Ring::parse, default_value = "120")]
    frames: Ring,
    /// Angle from the first frame to the one after the last, anticlockwise seen from above
    #[arg(long, value_name = "DEG", default_value_t = 360.0, allow_negative_numbers = true)]
    degrees: f64,
    /// What goes around; for a film these are three different things
    #[arg(long = "mode", value_name = "WHAT", value_enum, default_value = "camera")]
    turning: TurningArg,
    /// What it goes around: the middle of the object (`auto`), a node's origin, or `x,y,z` in the file's axes and units
    #[arg(long, value_name = "auto|ID|x,y,z", value_parser = parse_pivot, default_value = "auto", allow_hyphen_values = true)]
    pivot: Pivot,
    /// Axis to turn about: world up, or an axis of the file
    #[arg(long, value_name = "AXIS", value_enum, default_value = "up")]
    axis: AxisArg,
    /// Node that belongs to the object (repeatable) [default: every shape but lamps, ground and room]
    #[arg(long, value_name = "ID")]
    object: Vec<String>,
    #[command(flatten)]
    sequence: SequenceArgs,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    talk: TalkArgs,
}

#[derive(Clone, Copy, ValueEnum)]
enum TurningArg {
    /// The camera: light stays on the object, the angle to the eye changes
    Camera,
    /// The object: it moves through the light
    Object,
    /// Lamps and environment: only the angle to the light changes
    Light,
}

#[derive(Clone, Copy, ValueEnum)]
enum AxisArg {
    Up,
    X,
    Y,
    Z,
}

fn parse_pivot(text: &str) -> Result<Pivot, String> {
    if text == "auto" {
        return Ok(Pivot::Auto);
    }
    let numbers: Vec<f32> = text.split(',').map_while(|number| number.trim().parse().ok()).collect();
    match <[f32; 3]>::try_from(numbers) {
        Ok(point) if text.split(',').count() == 3 && point.iter().all(|x| x.is_finite()) => Ok(Pivot::Point(point)),
        _ if text.contains(',') => Err("write a point as x,y,z".to_owned()),
        _ => Ok(Pivot::Node(text.to_owned())),
    }
}

pub fn run(args: &TurntableArgs) -> Result<(), Error> {
    let plan = TurntablePlan {
        turning: match args.turning {
            TurningArg::Camera => Turning::Camera,
            TurningArg::Object => Turning::Object,
            TurningArg::Light => Turning::Light,
        },
        count: args.frames.count,
        degrees: args.degrees,
        pivot: args.pivot.clone(),
        axis: match args.axis {
            AxisArg::Up => Axis::Up,
            AxisArg::X => Axis::X,
            AxisArg::Y => Axis::Y,
            AxisArg::Z => Axis::Z,
        },
        objects: args.object.clone(),
    };
    let mut work = Work::load(&args.scene, &args.picture, &args.sequence, &args.talk)?;
    let (table, line) = Turntable::new(&work.document, &plan)?;
    args.talk.inform(&line);
    work.suffix = format!("/{}", args.frames.count);
    work.run(Motion::Turntable(table), args.frames.frames.clone(), &format!("{plan:?}"))
}
