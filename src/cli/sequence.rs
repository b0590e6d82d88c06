//! What `turntable` and `animate` share: options, and the way from a scene to its frames.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use clap::Args;
use signal_hook::consts::SIGINT;

use super::batch_progress::BatchProgress;
use super::print;
use super::render::{PictureArgs, TalkArgs};
use super::scene_args::SceneArgs;
use super::stops::{DisplayArgs, signals};
use crate::batch::budget::Budget;
use crate::batch::encode::{EncodePlan, Footage, Target};
use crate::batch::frames::{FrameList, Pattern};
use crate::batch::live::{Live, Shows};
use crate::batch::record::Record;
use crate::batch::resume;
use crate::batch::sequence::{Loading, Motion, Sequence, SequencePlan, Staged};
use crate::batch::shutter::Shutter;
use crate::batch::still::{self, StillPlan};
use crate::batch::{Thumbnail, Transport};
use crate::denoise::Denoiser;
use crate::document::Document;
use crate::error::Error;
use crate::mode::{Grouped, Mode, Rgb, Spectral};
use crate::output::{self, Display, Format};
use crate::study::report;

/// Samples per pixel where time or noise end a frame and nobody says how many there may be.
pub const MOST_SPP: u32 = 1 << 16;

#[derive(Args)]
pub struct SequenceArgs {
    /// Where the frames go: f.####.png, f.%04d.exr; a name without a place for the number gets one
    #[arg(short, long, value_name = "PATTERN")]
    output: PathBuf,
    /// Frames per second
    #[arg(long, value_name = "N", default_value_t = 24.0, value_parser = parse_positive)]
    pub fps: f64,
    /// Motion blur: how long the shutter is open, in degrees of the 360 that a frame lasts (180 is usual)
    #[arg(long, value_name = "DEG", value_parser = parse_shutter)]
    shutter: Option<Shutter>,
    /// Make a video of the frames when all are there: .mp4, .mov, .webm, .mkv or .png, as `pellicle encode` does
    #[arg(long, value_name = "FILE")]
    video: Option<PathBuf>,
    /// Skip frames that are there, whole, and made with the same settings
    #[arg(long, help_heading = "Batch")]
    resume: bool,
    /// Print the frames that --resume would render, in the form that --frames reads, and exit
    #[arg(long, help_heading = "Batch")]
    missing: bool,
    /// The same sample pattern in every frame, to compare frames; otherwise frame n has the seed plus n
    #[arg(long, help_heading = "Batch")]
    seed_lock: bool,
    /// Stop rendering a frame after this time, like `20s` or `1m30s`; --spp is the most it takes then
    #[arg(long, value_name = "TIME", value_parser = parse_duration, help_heading = "Batch")]
    time_per_frame: Option<f64>,
    /// Stop rendering a frame when its estimated relative error is below this, like 0.01
    #[arg(long, value_name = "X", value_parser = parse_positive, help_heading = "Batch")]
    noise: Option<f64>,
    /// Share this time among all frames, so that they look alike, like `2h`
    #[arg(long, value_name = "TIME", value_parser = parse_duration, help_heading = "Batch")]
    total_time: Option<f64>,
    #[command(flatten)]
    display: DisplayArgs,
    /// Where the report goes: a folder, or the beginning of its files' names [default: `frames` beside the frames]
    #[arg(long, value_name = "DIR|BASE", help_heading = "Batch")]
    report: Option<PathBuf>,
}

pub fn parse_positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 && number.is_finite() => Ok(number),
        _ => Err("write a number greater than 0".to_owned()),
    }
}

fn parse_shutter(text: &str) -> Result<Shutter, String> {
    match text.parse::<f64>() {
        Ok(deg) if deg > 0.0 && deg <= 360.0 => Ok(Shutter { open: deg / 360.0 }),
        _ => Err("write degrees above 0, up to 360".to_owned()),
    }
}

/// Seconds from `90`, `90s`, `1m30s`, `2h`.
pub fn parse_duration(text: &str) -> Result<f64, String> {
    let wrong = || "write a time like 20s, 1m30s or 2h".to_owned();
    let mut seconds = 0.0;
    let mut rest = text;
    while !rest.is_empty() {
        let end = rest.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(rest.len());
        let (number, unit) = rest.split_at(end);
        let (unit, left) = unit.split_at(unit.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(unit.len()));
        let factor = match unit {
            "" | "s" => 1.0,
            "m" | "min" => 60.0,
            "h" => 3600.0,
            _ => return Err(wrong()),
        };
        seconds += number.parse::<f64>().map_err(|_| wrong())? * factor;
        rest = left;
    }
    if seconds > 0.0 && seconds.is_finite() { Ok(seconds) } else { Err(wrong()) }
}

impl SequenceArgs {
    fn budget(&self) -> Budget {
        Budget { time_per_frame_s: self.time_per_frame, noise: self.noise, total_time_s: self.total_time }
    }

    fn has_budget(&self) -> bool {
        self.time_per_frame.is_some() || self.noise.is_some() || self.total_time.is_some()
    }

    /// The report's files without their extensions.
    fn report_base(&self, pattern: &Pattern) -> PathBuf {
        match &self.report {
            None => pattern.folder().join("frames"),
            Some(folder) if folder.is_dir() => folder.join("frames"),
            Some(base) => base.clone(),
        }
    }
}

/// A scene that is loaded, on its way to frames.
pub struct Work<'a> {
    pub document: Document,
    /// What comes after a list of frames where `--frames` reads it.
    pub suffix: String,
    still: StillPlan,
    pattern: Pattern,
    format: Format,
    scene: &'a SceneArgs,
    picture: &'a PictureArgs,
    args: &'a SequenceArgs,
    talk: &'a TalkArgs,
    start: Instant,
    parse_s: f64,
    denoiser: Option<Denoiser>,
}

/// What rendering needs besides the sequence.
struct Rest<'a> {
    todo: FrameList,
    all: FrameList,
    record: Record,
    pattern: Pattern,
    talk: &'a TalkArgs,
    display: Display,
    suffix: String,
    video: Option<(PathBuf, Target)>,
    fps: f64,
    shows: Shows,
}

impl<'a> Work<'a> {
    /// Loads the scene and settles what does not depend on the motion.
    pub fn load(
        scene: &'a SceneArgs,
        picture: &'a PictureArgs,
        args: &'a SequenceArgs,
        talk: &'a TalkArgs,
    ) -> Result<Self, Error> {
        picture.file.check_lights(picture.wavelengths(), false)?;
        let start = Instant::now();
        let (pattern, inserted) = Pattern::parse(&args.output).map_err(Error::Usage)?;
        if inserted {
            talk.inform(&format!("frames go to {pattern}"));
        }
        let format = Format::of(&pattern.path(0))?;
        let (document, warnings) = scene.load()?;
        let parse_s = start.elapsed().as_secs_f64();
        talk.warn(&warnings);
        let mut still = picture.plan(&document.render, scene.memory.most());
        let denoiser = picture.denoise.load(false, talk)?;
        still.denoise &= denoiser.is_some();
        if args.has_budget() && picture.spp.is_none() {
            still.render.spp = MOST_SPP;
        }
        let suffix = String::new();
        Ok(Self { document, suffix, still, pattern, format, scene, picture, args, talk, start, parse_s, denoiser })
    }

    /// Renders what is to be rendered. `motion_words` tell motions apart.
    pub fn run(self, motion: Motion, frames: FrameList, motion_words: &str) -> Result<(), Error> {
        let settings = resume::settings(&self.document, &self.choices(motion_words));
        let resumes = self.args.resume || self.args.missing;
        let todo = if resumes { resume::missing(&frames, &self.pattern, &settings) } else { frames.clone() };
        if self.args.missing {
            return if todo.0.is_empty() { Ok(()) } else { print(&format!("{todo}{}\n", self.suffix)) };
        }

        // Find out now, not after hours, whether the results can be written.
        make_folder(self.pattern.folder())?;
        let video = match &self.args.video {
            Some(path) => Some((path.clone(), Target::of(path)?)),
            None => None,
        };
        let base = self.args.report_base(&self.pattern);
        output::check_picture(&self.pattern.path(frames.0.first().copied().unwrap_or(0)))?;
        let scene = self.document.path.display().to_string();
        let mut record = Record::open(&base, &scene, &settings, &frames, &todo)?;
        if self.args.resume {
            let there = frames.0.iter().copied().filter(|frame| todo.0.binary_search(frame).is_err());
            record.fill(there.clone(), &self.pattern)?;
            self.talk.inform(&format!("{} of {} frames are there", there.count(), frames.0.len()));
        }
        let mut rest = Rest {
            todo,
            all: frames,
            record,
            pattern: self.pattern.clone(),
            talk: self.talk,
            display: self.still.look.display,
            suffix: self.suffix,
            video,
            fps: self.args.fps,
            shows: Shows::default(),
        };
        if rest.todo.0.is_empty() {
            rest.report(Vec::new())?;
            return rest.encode();
        }

        let moving = motion.moving();
        let (stage, camera, placed, notes) = still::movable_stage(&self.document, &self.still, moving)?;
        for note in &notes {
            self.talk.inform(note);
        }
        let pilot = Instant::now();
        let stage = Arc::new(stage);
        let transport = self.picture.transport(&self.document, &self.still, &stage, &camera, self.talk)?;
        let loading = Loading { parse_s: self.parse_s, pilot_s: pilot.elapsed().as_secs_f64() };
        rest.shows.viewer = self.args.display.open(&self.pattern.to_string(), camera.window().size())?;
        let plan = SequencePlan {
            pattern: self.pattern,
            format: self.format,
            seed_lock: self.args.seed_lock,
            budget: self.args.budget(),
            shutter: self.args.shutter,
            denoiser: self.denoiser,
            settings,
        };
        let scene = Staged {
            document: self.document,
            plan,
            still: self.still,
            motion,
            stage,
            camera,
            placed,
            loading,
            start: self.start,
        };
        let lights = scene.still.tells_lights_apart();
        match (transport, self.picture.wavelengths.as_str()) {
            (Transport::Rgb, _) if lights => rest.render(scene.sequence::<Grouped<Rgb>>()?),
            (Transport::Spectral, _) if lights => rest.render(scene.sequence::<Grouped<Spectral<8>>>()?),
            (Transport::Rgb, _) => rest.render(scene.sequence::<Rgb>()?),
            (Transport::Spectral, "4") => rest.render(scene.sequence::<Spectral<4>>()?),
            (Transport::Spectral, "16") => rest.render(scene.sequence::<Spectral<16>>()?),
            (Transport::Spectral, _) => rest.render(scene.sequence::<Spectral<8>>()?),
        }
    }

    /// Everything that the user chose and that a frame shows.
    fn choices(&self, motion_words: &str) -> String {
        let mut still = self.still.clone();
        (still.render.threads, still.max_memory) = (0, 0);
        let reading = self.scene.reading();
        let (budget, lock, shutter) = (self.args.budget(), self.args.seed_lock, self.args.shutter);
        let mode = self.picture.mode_words(&self.document.render);
        format!("{still:?} {reading} {mode} {budget:?} {lock} {shutter:?} {motion_words}")
    }
}

impl Rest<'_> {
    fn render<M: Mode>(mut self, mut sequence: Sequence<M>) -> Result<(), Error> {
        // Until here a signal simply ends the program: there is nothing to save yet.
        let signal = signals();
        self.talk.inform(&sequence.summary());
        let count = self.todo.0.len();
        let progress = BatchProgress::new(self.talk.style(), count, signal.clone());
        let talk = self.talk;
        let live = Live::new(&progress, std::mem::take(&mut self.shows), |line| talk.inform(line));
        let mut thumbnails = Vec::new();
        let mut stopped = None;
        for (number, &frame) in self.todo.0.iter().enumerate() {
            progress.begin(frame);
            let left = count - number;
            let Some(done) = (if is_set(&signal) { None } else { sequence.render(frame, left, &live)? }) else {
                stopped = Some(left);
                break;
            };
            if done.row.is_failed() {
                self.talk.inform(&format!("frame {frame} failed: {}", done.row.reason));
            }
            progress.end(&done.row);
            thumbnails.extend(done.thumbnail.map(|thumbnail| (frame, thumbnail)));
            self.record.add(done.row)?;
        }
        progress.finish();
        self.report(thumbnails)?;
        if let Some(left) = stopped {
            let name = if signal.load(Ordering::Relaxed) as i32 == SIGINT { "SIGINT" } else { "SIGTERM" };
            return Err(Error::Paused { name, left });
        }
        let failed = self.record.summary().failed;
        if failed.is_empty() {
            return self.encode();
        }
        let report = self.record.path("csv").display().to_string();
        Err(Error::Frames { frames: failed + &self.suffix, report })
    }

    /// Makes the video, if one is wanted.
    fn encode(&self) -> Result<(), Error> {
        let Some((path, target)) = &self.video else { return Ok(()) };
        let footage = Footage::of(self.all.0.iter().map(|&frame| self.pattern.path(frame)).collect())?;
        let plan = EncodePlan { fps: self.fps, quality: None, display: self.display };
        let count = footage.encode(path, *target, &plan, |line| self.talk.inform(line))?;
        self.talk.inform(&format!("{}: {count} frames, {:.2} s", path.display(), count as f64 / self.fps));
        Ok(())
    }

    /// Writes the report with everything that is known now.
    fn report(&mut self, mut thumbnails: Vec<(u32, Thumbnail)>) -> Result<(), Error> {
        self.record.finish()?;
        for &frame in &self.all.0 {
            if !thumbnails.iter().any(|(known, _)| *known == frame) {
                let read = Thumbnail::read(&self.pattern.path(frame), self.display);
                thumbnails.extend(read.map(|thumbnail| (frame, thumbnail)));
            }
        }
        thumbnails.sort_by_key(|(frame, _)| *frame);
        report::write(&self.record, &thumbnails, &self.pattern)?;
        self.talk.inform(&self.record.summary().line());
        self.talk.inform(&format!("report: {}", self.record.path("html").display()));
        Ok(())
    }
}

fn is_set(signal: &AtomicUsize) -> bool {
    signal.load(Ordering::Relaxed) != 0
}

/// Makes the folder of the frames, if its own folder is there.
fn make_folder(folder: &Path) -> Result<(), Error> {
    if folder.exists() {
        return Ok(());
    }
    fs::create_dir(folder)
        .map_err(|source| output::OutputError::Io { task: "create the folder", path: folder.to_owned(), source }.into())
}
