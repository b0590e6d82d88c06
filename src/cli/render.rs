//! `pellicle render`: one picture.

use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::{Args, ValueEnum};
use signal_hook::consts::SIGINT;

use super::denoise_args::DenoiseArgs;
use super::file_args::FileArgs;
use super::progress::{Progress, ProgressArg};
use super::raster_args::RasterArgs;
use super::sampling::{SamplingArgs, Target};
use super::scene_args::{FramingArg, SceneArgs};
use super::stops::{DisplayArgs, PreviewArgs, StopArgs, signals};
use super::{print, say};
use crate::batch::aov::Aov;
use crate::batch::budget::Limited;
use crate::batch::checkpoint::Saver;
use crate::batch::live::{Live, Shows};
use crate::batch::still::{self, StillPlan};
use crate::batch::{Transport, choose_mode};
use crate::collada::Warning;
use crate::denoise::Denoiser;
use crate::document::{Document, RenderHints};
use crate::error::Error;
use crate::film::Rung;
use crate::integrate::{PathLimits, Strategy};
use crate::mode::{Grouped, Mode, Rgb, Spectral};
use crate::output::{self, Display};
use crate::render::{Accumulation, Filter, Plan, RenderError};
use crate::scene::{Camera, FilmOptions, Stage};

/// Render a picture of a scene
///
/// Writes linear half-float EXR or sRGB PNG, whole or not at all. What the scene file says about size, samples, camera and
/// so on holds unless an option overrides it.
#[derive(Args)]
#[command(after_help = "Examples:
  pellicle render scenes/bubbles.dae -o bubbles.png
  pellicle render model.obj -o gold.png --material \"conductor Au; film 550nm n=1.33\" --environment studio
  pellicle render scene.dae -o still.exr --size 3840x2160 --spp 1024
  pellicle render scene.dae -o quick.png --spp 8 --exposure 1
  pellicle render scene.dae -o still.exr --noise 0.01 --checkpoint 5m --preview still.png")]
pub struct RenderArgs {
    #[command(flatten)]
    pub(super) scene: SceneArgs,
    /// Where to write the picture: .exr or .png
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    pub(super) picture: PictureArgs,
    #[command(flatten)]
    sampling: SamplingArgs,
    #[command(flatten)]
    stops: StopArgs,
    #[command(flatten)]
    display: DisplayArgs,
    #[command(flatten)]
    preview: PreviewArgs,
    /// Write timings, counts and settings as JSON
    #[arg(long, value_name = "FILE")]
    stats: Option<PathBuf>,
    #[command(flatten)]
    pub(super) talk: TalkArgs,
}

/// How pictures are made: shared by every subcommand that renders.
#[derive(Args)]
pub struct PictureArgs {
    #[command(flatten)]
    raster: RasterArgs,
    /// Samples per pixel [default: the scene's, or 128]
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: Option<u32>,
    /// Seed of the sample pattern [default: the scene's, or 0]
    #[arg(long, value_name = "N")]
    seed: Option<u32>,
    /// Threads; 0 = all processors
    #[arg(short, long, value_name = "N", default_value_t = 0, value_parser = parse_threads)]
    threads: usize,
    /// Scattering events on a path: 0 sees lights only, 1 adds direct light [default: the scene's, or 16]
    #[arg(long, value_name = "N")]
    max_bounces: Option<u32>,
    /// Camera, by its id or its node's
    #[arg(long, value_name = "ID")]
    camera: Option<String>,
    /// How the camera is placed
    #[arg(long, value_name = "RULE", value_enum, default_value = "auto")]
    framing: FramingArg,
    /// Pixel filter
    #[arg(long, value_name = "NAME", value_enum, default_value = "blackman-harris")]
    filter: FilterArg,
    /// Colour transport [default: the scene's, or auto]
    #[arg(long, value_name = "NAME", value_enum)]
    mode: Option<ModeArg>,
    /// Wavelengths per path of spectral transport
    #[arg(long, value_name = "N", value_parser = ["4", "8", "16"], default_value = "8")]
    pub wavelengths: String,
    /// Film model, instead of the cheapest one within the tolerance
    #[arg(long, value_name = "RUNG", value_enum)]
    film: Option<RungArg>,
    /// Colour error (CIEDE2000) that a cheaper film model may cost [default: the scene's, or 1]
    #[arg(long, value_name = "DE")]
    tolerance: Option<f32>,
    /// How light is found; the others are there to check `shared`
    #[arg(long, value_name = "NAME", value_enum, default_value = "shared")]
    strategy: StrategyArg,
    /// Scale samples brighter than this down to it, against fireflies; biased, and said so in the picture's header
    #[arg(long, value_name = "RADIANCE", value_parser = parse_clamp)]
    pub(super) clamp: Option<f32>,
    /// Brightness of PNG pictures, in stops [default: the scene's, or 0]
    #[arg(long, value_name = "EV", allow_negative_numbers = true)]
    exposure: Option<f32>,
    #[command(flatten)]
    pub(super) denoise: DenoiseArgs,
    #[command(flatten)]
    pub(super) file: FileArgs,
}

/// What is said on the way.
#[derive(Args)]
pub struct TalkArgs {
    /// How progress is shown on stderr
    #[arg(long, value_name = "STYLE", value_enum, default_value = "auto")]
    pub progress: ProgressArg,
    /// Say nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

impl TalkArgs {
    pub fn inform(&self, line: &str) {
        if !self.quiet {
            say(line);
        }
    }

    pub fn warn(&self, warnings: &[Warning]) {
        for warning in warnings {
            self.inform(&format!("warning: {warning}"));
        }
    }

    pub fn style(&self) -> ProgressArg {
        if self.quiet { ProgressArg::None } else { self.progress }
    }
}

#[derive(Clone, Copy, ValueEnum)]
enum FilterArg {
    Box,
    Gaussian,
    BlackmanHarris,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum ModeArg {
    /// RGB where it is exact enough for the scene, else spectral
    Auto,
    Rgb,
    Spectral,
}

#[derive(Clone, Copy, ValueEnum)]
enum RungArg {
    /// No film at all
    Bare,
    /// One wavelength per channel
    ThreeWave,
    /// Belcour & Barla 2017
    Gaussian,
    /// The exact spectral integral, tabulated
    Table,
}

#[derive(Clone, Copy, ValueEnum)]
enum StrategyArg {
    /// As `mis`, and neighbouring pixels look at what each other's paths found, and paths begin at lamps, where it pays
    Shared,
    /// Light and surface sampling, weighted
    Mis,
    /// Light sampling alone
    Light,
    /// Surface sampling alone
    Bsdf,
}

/// Far more threads than processors only bring a machine to its knees.
const MOST_THREADS: usize = 1024;

pub(super) fn parse_threads(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(threads) if threads <= MOST_THREADS => Ok(threads),
        _ => Err(format!("give a number up to {MOST_THREADS}; 0 takes all processors")),
    }
}

fn parse_clamp(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(limit) if limit.is_finite() && limit > 0.0 => Ok(limit),
        _ => Err("give a radiance above 0, in the scene's units, like 10".to_owned()),
    }
}

pub fn run(args: &RenderArgs) -> Result<(), Error> {
    // Find out now, not after hours, whether the results can be written.
    let target = args.sampling.target(&args.output)?;
    if target == Target::Part {
        args.picture.file.check_part()?;
    }
    args.picture.file.check_lights(args.picture.wavelengths(), args.sampling.checkpoint().is_some())?;
    if let Some(stats) = &args.stats {
        output::check_writable(stats)?;
    }
    let preview = args.preview.check()?;

    let loading = std::time::Instant::now();
    let (document, warnings) = args.scene.load()?;
    let parse_s = loading.elapsed().as_secs_f64();
    args.talk.warn(&warnings);

    let mut plan = args.picture.plan(&document.render, args.scene.memory.most());
    args.stops.apply(&mut plan, args.picture.spp, target)?;
    let denoiser = args.picture.denoise.load(target == Target::Part, &args.talk)?;
    plan.denoise &= denoiser.is_some();
    let plan = plan;
    let (stage, camera, notes) = still::stage(&document, &plan)?;
    for note in &notes {
        args.talk.inform(note);
    }
    let transport = args.picture.transport(&document, &plan, &stage, &camera, &args.talk)?;
    let viewer = args.display.open(&args.output.display().to_string(), camera.window().size())?;
    let shows = args.preview.shows(viewer, preview, plan.look);
    let job = Job { args, document: &document, plan: &plan, stage: &stage, camera: &camera, target, denoiser, parse_s };
    match (transport, args.picture.wavelengths()) {
        (Transport::Rgb, _) if plan.tells_lights_apart() => job.render::<Grouped<Rgb>>(shows),
        (Transport::Spectral, _) if plan.tells_lights_apart() => job.render::<Grouped<Spectral<8>>>(shows),
        (Transport::Rgb, _) => job.render::<Rgb>(shows),
        (Transport::Spectral, 4) => job.render::<Spectral<4>>(shows),
        (Transport::Spectral, 16) => job.render::<Spectral<16>>(shows),
        (Transport::Spectral, _) => job.render::<Spectral<8>>(shows),
    }
}

/// Everything that is settled before the colour mode.
struct Job<'a> {
    args: &'a RenderArgs,
    document: &'a Document,
    plan: &'a StillPlan,
    stage: &'a Arc<Stage>,
    camera: &'a Camera,
    target: Target,
    denoiser: Option<Denoiser>,
    parse_s: f64,
}

impl Job<'_> {
    fn render<M: Mode>(&self, shows: Shows) -> Result<(), Error> {
        let Self { args, document, plan, .. } = self;
        let samples = args.sampling.range(plan.render.spp)?;
        let prepared = still::prepare::<M>(document, plan, self.stage, self.camera)?;
        // Until here a signal simply ends the program: there is nothing to save yet.
        let signal = signals();
        args.talk.inform(&prepared.summary(document, plan));

        let saver = match self.in_pieces() {
            true => Some(Saver::new(&prepared, document, plan, args.scene.reading(), &args.output)?),
            false => None,
        };
        let earlier = match (&saver, args.sampling.resume) {
            (Some(saver), true) => self.earlier(saver, &samples)?,
            _ => None,
        };
        let mut sums = earlier.unwrap_or_else(|| prepared.sums(samples));
        let (limit, start) = args.stops.limit(&sums);
        let progress = Progress::new(args.talk.style(), &sums, (limit.time_s, plan.render.noise), signal.clone());
        let live = Live::new(&progress, shows, |line| args.talk.inform(line));
        let limited = Limited { watch: &live, limit, start };
        let whole = match (&saver, args.sampling.checkpoint()) {
            (Some(saver), Some(every)) => saver.accumulate(&mut sums, every, &limited),
            _ => prepared.accumulate(plan, &mut sums, &limited),
        };
        progress.finish();

        let (whole, stopped) = match whole {
            Ok(true) => (true, Ok(())),
            Ok(false) => (false, self.stopped(saver.as_ref(), &signal, &sums)),
            // What was rendered besides is kept as after a signal.
            Err(bug @ Error::Render(RenderError::Bug { .. })) => (false, Err(bug)),
            Err(error) => return Err(error),
        };
        if !whole && (self.target == Target::Part || sums.spp() == 0) {
            return stopped;
        }
        if let (Some(saver), Target::Part) = (&saver, self.target) {
            saver.save(&args.output, &sums)?;
        }
        let frame = sums.into_frame(plan.wants(Aov::Variance));
        let mut stats = prepared.stats(document, plan, &frame, self.parse_s);
        if let Target::Picture(format) = self.target {
            let mut survey = None;
            prepared.look(plan, &mut survey, 0..frame.spp)?;
            let (layers, denoised) = prepared.layers(document, plan, &frame, survey.as_ref(), self.denoiser.as_ref());
            let denoise_s = denoised.unwrap_or_else(|error| {
                args.talk.inform(&format!("warning: {error}; the picture stays noisy"));
                0.0
            });
            stats.add_layers(survey.as_ref(), denoise_s);
            let picture = still::picture(&frame, layers, prepared.header(document, plan));
            let (written, write_s) = still::write(&args.output, format, &picture, plan.look)?;
            stats.finish(&written, write_s);
        }
        if let Some(saver) = saver.as_ref().filter(|_| whole) {
            saver.forget();
        }
        if let Some(path) = &args.stats {
            output::write_text(path, &stats.to_json())?;
        }
        args.talk.inform(&stats.summary(&args.output));
        if args.sampling.hash {
            print(&format!("{}\n", frame.sha256()))?;
        }
        stopped
    }

    /// What `--resume` goes on from, if anything.
    fn earlier<M: Mode>(&self, saver: &Saver<M>, samples: &Range<u32>) -> Result<Option<Accumulation>, Error> {
        let inform = |line: &str| self.args.talk.inform(line);
        match saver.restore(&saver.checkpoint, samples, inform)? {
            // A part that is done already is not rendered again.
            None if self.target == Target::Part => saver.restore(&self.args.output, samples, inform),
            sums => Ok(sums),
        }
    }

    /// The sums themselves go into a file, or may.
    fn in_pieces(&self) -> bool {
        self.target == Target::Part || self.args.sampling.checkpoint().is_some()
    }

    /// The error that a signal makes of a render that is shorter for it.
    fn stopped<M: Mode>(
        &self,
        saver: Option<&Saver<M>>,
        signal: &AtomicUsize,
        sums: &Accumulation,
    ) -> Result<(), Error> {
        let signal = signal.load(Ordering::Relaxed) as i32;
        let name = if signal == SIGINT { "SIGINT" } else { "SIGTERM" };
        let (done, wanted) = (sums.spp(), sums.samples.len() as u32);
        match saver {
            Some(saver) if self.args.sampling.checkpoint().is_some() => {
                Err(Error::Suspended { name, done, wanted, checkpoint: saver.checkpoint.clone() })
            }
            Some(_) => Err(Error::Interrupted { signal, name, done: 0, wanted }),
            None => Err(Error::Interrupted { signal, name, done, wanted }),
        }
    }
}

impl RenderArgs {
    /// Whether another render reads and views its scene alike.
    pub(super) fn sees_like(&self, other: &Self) -> bool {
        let (a, b) = (&self.picture, &other.picture);
        (&self.scene, &a.camera, a.framing) == (&other.scene, &b.camera, b.framing)
    }
}

impl PictureArgs {
    pub fn wavelengths(&self) -> usize {
        // Clap lets no other values through.
        self.wavelengths.parse().unwrap_or(8)
    }

    /// The colour transport that is asked for, or that a pilot finds to be needed.
    pub fn transport(
        &self,
        document: &Document,
        plan: &StillPlan,
        stage: &Arc<Stage>,
        camera: &Camera,
        talk: &TalkArgs,
    ) -> Result<Transport, Error> {
        match self.mode_of(&document.render)? {
            ModeArg::Rgb => Ok(Transport::Rgb),
            ModeArg::Spectral => Ok(Transport::Spectral),
            ModeArg::Auto => {
                let (transport, reason) = choose_mode(document, plan, stage, camera)?;
                let name = if transport == Transport::Rgb { "rgb" } else { "spectral" };
                talk.inform(&format!("mode: {name} ({reason})"));
                Ok(transport)
            }
        }
    }

    /// The mode that is asked for, in words.
    pub fn mode_words(&self, hints: &RenderHints) -> String {
        let asked = self.mode.map(|mode| format!("{mode:?}")).or_else(|| hints.mode.clone());
        format!("{} {}", asked.unwrap_or_default().to_lowercase(), self.wavelengths)
    }

    fn mode_of(&self, hints: &RenderHints) -> Result<ModeArg, Error> {
        match (self.mode, hints.mode.as_deref()) {
            (Some(mode), _) => Ok(mode),
            (None, None) => Ok(ModeArg::Auto),
            (None, Some(name)) => ModeArg::from_str(name, false)
                .map_err(|_| Error::Usage(format!("the scene asks for mode `{name}`; known are auto, rgb, spectral"))),
        }
    }

    /// What is meant: the command line over the scene's hints over the defaults.
    pub fn plan(&self, hints: &RenderHints, max_memory: u64) -> StillPlan {
        StillPlan {
            raster: self.raster.raster(hints),
            camera: self.camera.clone().or_else(|| hints.camera.clone()),
            framing: self.framing.into(),
            films: FilmOptions {
                tolerance: self.tolerance.or(hints.tolerance).unwrap_or(1.0),
                rung: self.film.map(|rung| match rung {
                    RungArg::Bare => Rung::Bare,
                    RungArg::ThreeWave => Rung::ThreeWave,
                    RungArg::Gaussian => Rung::Gaussian,
                    RungArg::Table => Rung::Table,
                }),
            },
            render: Plan {
                spp: self.spp.or(hints.spp).unwrap_or(128),
                seed: self.seed.or(hints.seed).unwrap_or(0),
                threads: self.threads,
                filter: match self.filter {
                    FilterArg::Box => Filter::Box,
                    FilterArg::Gaussian => Filter::Gaussian,
                    FilterArg::BlackmanHarris => Filter::BlackmanHarris,
                },
                limits: PathLimits {
                    max_bounces: self.max_bounces.or(hints.max_bounces).unwrap_or(16),
                    strategy: match self.strategy {
                        StrategyArg::Shared => Strategy::Shared,
                        StrategyArg::Mis => Strategy::Mis,
                        StrategyArg::Light => Strategy::Light,
                        StrategyArg::Bsdf => Strategy::Bsdf,
                    },
                },
                clamp: self.clamp,
                noise: None,
            },
            look: self.file.look(Display {
                exposure_ev: self.exposure.or(hints.exposure_ev).unwrap_or(0.0),
                ..Display::default()
            }),
            aovs: self.file.aovs(),
            denoise: self.denoise.is_wanted(),
            max_memory,
        }
    }
}
