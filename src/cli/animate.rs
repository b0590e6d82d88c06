//! `pellicle animate`: the file's own animation.

use clap::Args;

use super::render::{PictureArgs, TalkArgs};
use super::scene_args::SceneArgs;
use super::sequence::{SequenceArgs, Work};
use crate::batch::animate::Animation;
use crate::batch::frames::FrameList;
use crate::batch::sequence::Motion;
use crate::error::Error;

/// Render the animation that a scene file brings along
///
/// Plays the channels of its `animation` elements: transforms of nodes, cameras, the colours of lights, films and other
/// values of materials. Frame n is n / fps seconds into the animation. The scene is loaded and built once; each frame builds
/// anew only what has changed. Reports and exit codes are those of `pellicle turntable`.
#[derive(Args)]
#[command(after_help = "Examples:
  pellicle animate scene.dae -o frames/f.####.exr --frames 1-240
  pellicle animate scene.dae -o f.####.png --frames 1-240x10 --spp 16 --size 480x")]
pub struct AnimateArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Frames: `1-240`, `1,5,10-20x2` [default: from the first key to the last]
    #[arg(long, value_name = "LIST", value_parser = FrameList::parse)]
    frames: Option<FrameList>,
    #[command(flatten)]
    sequence: SequenceArgs,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    talk: TalkArgs,
}

pub fn run(args: &AnimateArgs) -> Result<(), Error> {
    let mut work = Work::load(&args.scene, &args.picture, &args.sequence, &args.talk)?;
    let fps = args.sequence.fps;
    let Some((first, last)) = Animation::range(&work.document, fps) else {
        return Err(Error::Usage(
            "the scene has no animation that could be played; `pellicle check` lists it".to_owned(),
        ));
    };
    let frames = args.frames.clone().unwrap_or_else(|| FrameList((first..=last).collect()));
    let channels = work.document.channels.len();
    args.talk
        .inform(&format!("{channels} channels move the scene from frame {first} to {last} at {fps} frames a second"));
    let mut animation = Animation::new(&work.document, fps);
    // The scene is built as its animation begins, whatever frames are wanted: all parts of a batch agree.
    animation.pose(&mut work.document, f64::from(first))?;
    animation.changes = Default::default();
    work.run(Motion::Animation(animation), frames, &format!("animate {fps} fps"))
}
