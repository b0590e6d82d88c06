//! `pellicle chart convergence`.

use std::path::{Path, PathBuf};

use clap::{Args, Parser, ValueEnum};
use sha2::{Digest, Sha256};

use super::{check_base, write};
use crate::batch::still::{self, StillPlan};
use crate::cli::raster_args::{Size, parse_size};
use crate::cli::render::RenderArgs;
use crate::cli::{print, say};
use crate::document::Document;
use crate::error::Error;
use crate::math::hex;
use crate::output::read_exr;
use crate::study::convergence::{Cache, Clock, Contender, Contest, How, Mean, Reference, Report, SeriesFile, Setting};
use crate::study::metrics::Exposure;

/// Error against seconds of a scene's renders, in several configurations
///
/// Renders the scene in each configuration, with growing numbers of samples, several times with new seeds, all in turns; the
/// clock runs only while rendering. Errors are measured against pictures with many more samples, which are kept for the next
/// run: noise against the same mode (an RGB picture converges to something slightly else than a spectral one), colours
/// against the spectral one. What the references' own noise adds is taken off and drawn as a floor.
#[derive(Args)]
#[command(after_help = "Examples:
  pellicle chart convergence scenes/bubbles.dae -o bubbles
  pellicle chart convergence scene.dae --config 'mis=--mode rgb' --config 'light=--mode rgb --strategy light'
  pellicle chart convergence scene.dae --config 'rgb=--mode rgb' --vs ./pellicle-before --spp 16,64 --repeats 5
  pellicle chart convergence scene.dae --size 320x200 --series 'other=a.exr@1.5,b.exr@6.1'

The table: MSE and relMSE of the noise at the most samples, efficiency 1/(MSE s) and its ratio to the first
configuration, the slope of log MSE over log s (-1 for independent samples), errors against the spectral picture.")]
pub struct ConvergenceArgs {
    /// The scene: COLLADA .dae or .zae
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// Write NAME.csv, NAME.svg and NAME.png; without it only the table is printed
    #[arg(short, long, value_name = "NAME")]
    output: Option<PathBuf>,
    /// A configuration: a name and options of `pellicle render` (repeatable) [default: rgb, its strategies mis, light and
    /// bsdf, and spectral with 8 and 4 wavelengths]
    #[arg(long = "config", value_name = "NAME=OPTIONS")]
    configs: Vec<String>,
    /// Options of `pellicle render` for all configurations
    #[arg(long, value_name = "OPTIONS", default_value = "", hide_default_value = true, allow_hyphen_values = true)]
    all: String,
    /// Picture size in pixels [default: the scene's, reduced to 160 on the long side]
    #[arg(short = 'r', long, value_name = "WxH", value_parser = parse_size)]
    size: Option<Size>,
    /// Samples per pixel, with commas
    #[arg(short, long, value_name = "LIST", value_delimiter = ',', default_value = "4,16,64",
          value_parser = clap::value_parser!(u32).range(1..))]
    spp: Vec<u32>,
    /// Renders of each configuration and number of samples
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeats: u32,
    /// Run every configuration also with this second pellicle
    #[arg(long, value_name = "BINARY")]
    vs: Option<PathBuf>,
    /// Pictures from elsewhere with their seconds, which may also be in the header as renderTimeSeconds (repeatable)
    #[arg(long, value_name = "NAME=FILE[@S],...")]
    series: Vec<String>,
    /// Samples per pixel of the references [default: 16 times the most of --spp]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..))]
    reference_spp: Option<u32>,
    /// Take this EXR instead of a spectral reference
    #[arg(long, value_name = "FILE")]
    reference: Option<PathBuf>,
    /// Keep references here [default: ~/.cache/pellicle]
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Brightness for CIEDE2000 and FLIP in stops [default: the scene's, or the mean at mid grey]
    #[arg(long, value_name = "EV", allow_negative_numbers = true)]
    exposure: Option<f32>,
    /// The seconds that are charted
    #[arg(long, value_name = "CLOCK", value_enum, default_value = "cpu")]
    clock: ClockArg,
}

#[derive(Clone, Copy, ValueEnum)]
enum ClockArg {
    /// CPU seconds / threads, which other programs on the machine hardly disturb
    Cpu,
    Wall,
}

const DEFAULT_CONFIGS: [&str; 6] = [
    "rgb=--mode rgb",
    "rgb mis=--mode rgb --strategy mis",
    "rgb light=--mode rgb --strategy light",
    "rgb bsdf=--mode rgb --strategy bsdf",
    "spectral 8=--mode spectral",
    "spectral 4=--mode spectral --wavelengths 4",
];
/// Long side in pixels where no size is asked for.
const SIDE: u32 = 160;

/// Options of `pellicle render` as a text.
#[derive(Parser)]
#[command(no_binary_name = true)]
struct Words {
    #[command(flatten)]
    render: RenderArgs,
}

pub fn run(args: &ConvergenceArgs) -> Result<(), Error> {
    if let Some(base) = &args.output {
        check_base(base)?;
    }
    // Settle what is common to all: the scene, where it is seen from, how large.
    let common = args.parse("--all", "", [None; 2])?;
    let (document, warnings) = common.scene.load()?;
    for warning in &warnings {
        say(&format!("warning: {warning}"));
    }
    let size = args.size.map_or([None; 2], |size| [size.width, size.height]);
    let mut plan = common.picture.plan(&document.render, common.scene.memory.most());
    plan.raster.size = size;
    let (stage, camera, notes) = still::stage(&document, &plan)?;
    for note in &notes {
        say(note);
    }
    // Of the whole picture, whatever else is asked for.
    let camera = camera.resized(if args.size.is_some() { camera.size } else { reduced(camera.size) });
    let setting = Setting { document: &document, stage, camera };

    let contenders = args.contenders(&setting, &common)?;
    let references = args.references(&setting, &plan, &contenders)?;
    let Some((_, first)) = references.first() else { return Ok(()) };
    let exposure = args.exposure(&document).unwrap_or_else(|| Exposure::of(&first.image));
    let mut spps = args.spp.clone();
    spps.sort_unstable();
    spps.dedup();
    let contest = Contest { setting, contenders, references, exposure, spps, repeats: args.repeats };

    let folder = Folder::new()?;
    let rows = contest.run(&folder.0, say)?;
    let clock = match args.clock {
        ClockArg::Cpu => Clock::Cpu,
        ClockArg::Wall => Clock::Wall,
    };
    let report = Report { contest: &contest, rows: &rows, clock };
    let name = args.scene.file_name().unwrap_or_default().to_string_lossy();
    print(&format!("{name}, {}", report.table()))?;
    for warning in report.warnings() {
        say(&format!("warning: {warning}"));
    }
    if let Some(base) = &args.output {
        let [width, height] = contest.setting.camera.size;
        let title = format!("{name}, {width}x{height}, {} repeats", args.repeats);
        let (svg, png) = report.draw(&title).map_err(|error| Error::Usage(error.to_string()))?;
        write(base, &report.csv(), &svg, &png)?;
    }
    Ok(())
}

/// A folder for what other programs write, removed in the end.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Result<Self, Error> {
        let path = std::env::temp_dir().join(format!("pellicle-chart-{}", std::process::id()));
        std::fs::create_dir_all(&path).map_err(|error| Error::Usage(format!("{}: {error}", path.display())))?;
        Ok(Self(path))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What is left behind does no harm.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn reduced([width, height]: [u32; 2]) -> [u32; 2] {
    let scale = (SIDE as f32 / width.max(height) as f32).min(1.0);
    [width, height].map(|side| ((side as f32 * scale).round() as u32).max(1))
}

impl ConvergenceArgs {
    /// Options as `pellicle render` understands them, after those of --all; sizes, samples and seeds are the chart's own.
    fn words(&self, options: &str, [width, height]: [Option<u32>; 2]) -> Vec<String> {
        let mut words = vec![self.scene.display().to_string()];
        words.extend(self.all.split_whitespace().chain(options.split_whitespace()).map(str::to_owned));
        if let (Some(width), Some(height)) = (width, height) {
            words.extend(["--size".to_owned(), format!("{width}x{height}")]);
        }
        words
    }

    fn parse(&self, name: &str, options: &str, size: [Option<u32>; 2]) -> Result<RenderArgs, Error> {
        let mut words = self.words(options, size);
        words.extend(["-o", "chart.exr", "--spp", "1", "--seed", "0"].map(str::to_owned));
        let refused = |reason: &str| Error::Usage(format!("{name}: {reason}"));
        let args = Words::try_parse_from(words).map_err(|error| {
            let text = error.to_string();
            let reason = text.lines().next().unwrap_or_default();
            refused(reason.strip_prefix("error: ").unwrap_or(reason))
        })?;
        let args = args.render;
        if args.picture.clamp.is_some() {
            return Err(refused("--clamp makes renders biased; only unbiased ones can be charted"));
        }
        Ok(args)
    }

    fn contenders(&self, setting: &Setting, common: &RenderArgs) -> Result<Vec<Contender>, Error> {
        let defaults = DEFAULT_CONFIGS.map(str::to_owned);
        let configs = if self.configs.is_empty() { &defaults[..] } else { &self.configs };
        let size = setting.camera.size.map(Some);
        let mut contenders = Vec::new();
        for config in configs {
            let Some((name, options)) = config.split_once('=') else {
                let problem = format!("--config {config}: write NAME=OPTIONS, like 'light=--strategy light'");
                return Err(Error::Usage(problem));
            };
            let args = self.parse(&format!("--config {name}"), options, size)?;
            if !args.sees_like(common) {
                let problem = format!("--config {name}: options about the scene and the camera hold for all");
                return Err(Error::Usage(format!("{problem}; give them in --all")));
            }
            let plan = args.picture.plan(&setting.document.render, args.scene.memory.most());
            let picture = &args.picture;
            let transport = picture.transport(setting.document, &plan, &setting.stage, &setting.camera, &args.talk)?;
            let mean = Some(Mean::of(&plan, transport));
            let wavelengths = picture.wavelengths();
            contenders.push(Contender {
                name: name.to_owned(),
                how: How::Own { plan: Box::new(plan), transport, wavelengths },
                mean,
            });
            if let Some(binary) = &self.vs {
                let how = How::Other { binary: binary.clone(), words: self.words(options, size) };
                contenders.push(Contender { name: format!("{name} (vs)"), how, mean });
            }
        }
        for series in &self.series {
            contenders.push(series_of(series)?);
        }
        Ok(contenders)
    }

    /// The spectral reference (or the one that is given), then those of the other means that contenders have.
    fn references(
        &self,
        setting: &Setting,
        base: &StillPlan,
        contenders: &[Contender],
    ) -> Result<Vec<(Mean, Reference)>, Error> {
        let most = self.spp.iter().copied().max().unwrap_or(1);
        let spp = self.reference_spp.unwrap_or(16 * most);
        let cache = self.cache(setting.document);
        let exposure = self.exposure(setting.document);
        let mut means = vec![Mean::of(base, crate::batch::Transport::Spectral)];
        for mean in contenders.iter().filter_map(|contender| contender.mean) {
            if !means.contains(&mean) {
                means.push(mean);
            }
        }
        let mut references = Vec::new();
        for (i, mean) in means.into_iter().enumerate() {
            let reference = match &self.reference {
                Some(path) if i == 0 => Reference::of_picture(&read_exr(path)?, "the given picture".to_owned(), 0),
                _ => {
                    say(&format!("reference {}, {spp} spp", mean.label()));
                    Reference::new(setting, base, &mean, spp, exposure, cache.as_ref())?
                }
            };
            references.push((mean, reference));
        }
        Ok(references)
    }

    fn exposure(&self, document: &Document) -> Option<Exposure> {
        self.exposure.or(document.render.exposure_ev).map(Exposure::from_stops)
    }

    /// Told apart by the scene, the options that it is read with, and this very program.
    fn cache(&self, document: &Document) -> Option<Cache> {
        let home = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        let shared = || Some(home("XDG_CACHE_HOME").or_else(|| Some(home("HOME")?.join(".cache")))?.join("pellicle"));
        let folder = self.cache.clone().or_else(shared)?;
        let program = std::fs::read(std::env::current_exe().ok()?).ok()?;
        let program = hex(&Sha256::digest(program));
        Some(Cache { folder, key: format!("{} {} {program}", document.sha256, self.all) })
    }
}

/// `NAME=FILE[@SECONDS],...`
fn series_of(text: &str) -> Result<Contender, Error> {
    let wrong = |what: &str| Error::Usage(format!("--series {text}: {what}"));
    let Some((name, files)) = text.split_once('=') else {
        return Err(wrong("write NAME=FILE@SECONDS,FILE@SECONDS, like 'other=a.exr@1.5,b.exr@6'"));
    };
    let mut series = Vec::new();
    for file in files.split(',') {
        let (path, seconds) = match file.rsplit_once('@') {
            Some((path, seconds)) => match seconds.parse::<f64>() {
                Ok(seconds) if seconds > 0.0 && seconds.is_finite() => (path, Some(seconds)),
                _ => return Err(wrong(&format!("`{seconds}` is no number of seconds"))),
            },
            None => (file, None),
        };
        series.push(SeriesFile { path: Path::new(path).to_owned(), seconds });
    }
    Ok(Contender { name: name.to_owned(), how: How::Series(series), mean: None })
}
