//! Parts of a still: the sums of some of its samples, with the settings that decide their bits.

use std::ops::Range;
use std::path::Path;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::still::{Prepared, StillPlan};
use crate::document::{Document, ImageSource};
use crate::error::Error;
use crate::integrate::{PathLimits, Tally};
use crate::math::hex;
use crate::mode::Mode;
use crate::output::{self, Display, HeaderValue, OutputError, PartBlock, PartReader};
use crate::render::{Accumulation, Block, Doublings, Plan};
use crate::scene::{FilmOptions, Raster, Window};

/// What a part file says before its sums.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartHeader {
    pub settings: Settings,
    /// First sample index, and the one after the last, that the part is to hold.
    pub samples: Range<u32>,
    /// What the finished picture's header will say, but for samples and times.
    pub picture: Vec<(String, HeaderValue)>,
    /// For PNG, where nothing else is asked for.
    pub display: Display,
    pub cost: Cost,
}

/// Everything that decides the values of the pixels: parts that differ in any of these belong to different pictures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    pub version: String,
    pub scene_sha256: String,
    /// Over all images that the scene uses.
    pub images_sha256: String,
    /// How the scene file was read.
    pub reading: String,
    pub size: [u32; 2],
    pub crop: Option<Window>,
    pub pixel_aspect: f32,
    pub camera: Option<String>,
    pub framing: String,
    pub mode: String,
    pub spp: u32,
    pub seed: u32,
    pub filter: String,
    pub max_bounces: u32,
    pub strategy: String,
    pub clamp: Option<f32>,
    pub noise: Option<f64>,
    pub tolerance: f32,
    pub film: Option<String>,
}

/// What the samples cost: added up by merging.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    pub rays: u64,
    pub shadow_rays: u64,
    pub non_finite: u64,
    pub beyond_range: u64,
    pub clamped: u64,
    pub threads: usize,
    pub render_s: f64,
    pub render_cpu_s: f64,
}

impl Settings {
    /// `reading` tells how the scene file was read, `size` and `mode` what came of the scene and the options.
    ///
    /// # Errors
    /// An image that can no longer be read.
    pub fn new(
        document: &Document,
        plan: &StillPlan,
        reading: String,
        size: [u32; 2],
        mode: &str,
    ) -> Result<Self, Error> {
        // Taken apart, so that a new field asks here whether it changes pixels.
        let StillPlan {
            raster: Raster { size: _, pixel_aspect, crop },
            camera,
            framing,
            films,
            render,
            look: _,
            aovs: _,
            denoise: _,
            max_memory: _,
        } = plan;
        let FilmOptions { tolerance, rung } = films;
        let Plan { spp, seed, threads: _, filter, limits: PathLimits { max_bounces, strategy }, clamp, noise } = render;
        Ok(Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scene_sha256: document.sha256.clone(),
            images_sha256: images_sha256(document)?,
            reading,
            size,
            crop: *crop,
            pixel_aspect: *pixel_aspect,
            camera: camera.clone(),
            framing: format!("{framing:?}"),
            mode: mode.to_owned(),
            spp: *spp,
            seed: *seed,
            filter: format!("{filter:?}"),
            max_bounces: *max_bounces,
            strategy: format!("{strategy:?}"),
            clamp: *clamp,
            noise: *noise,
            tolerance: *tolerance,
            film: rung.map(|rung| rung.to_string()),
        })
    }

    /// Room for some samples of the picture.
    pub fn accumulation(&self, samples: Range<u32>) -> Accumulation {
        Accumulation::cropped(self.size, self.crop.unwrap_or(Window::whole(self.size)), samples)
    }

    /// The first setting that differs: its name, ours and theirs.
    pub fn difference(&self, other: &Self) -> Option<(String, String, String)> {
        let [ours, theirs] = [self, other].map(|settings| serde_json::to_value(settings).unwrap_or_default());
        let differs = |(name, value): (&String, &serde_json::Value)| {
            (theirs[name] != *value).then(|| (name.clone(), value.to_string(), theirs[name].to_string()))
        };
        ours.as_object().into_iter().flatten().find_map(differs)
    }
}

fn images_sha256(document: &Document) -> Result<String, Error> {
    let mut all = Sha256::new();
    for image in &document.images {
        let digest = match &image.source {
            ImageSource::File(path) => Sha256::digest(std::fs::read(path).map_err(|source| {
                Error::Output(OutputError::Damaged { path: path.clone(), reason: source.to_string() })
            })?),
            ImageSource::Bytes(bytes) => Sha256::digest(bytes),
            ImageSource::Missing => Sha256::digest([]),
        };
        all.update(digest);
    }
    Ok(hex(&all.finalize()))
}

impl PartHeader {
    /// Of a render that may be on its way still.
    pub fn new<M: Mode>(
        settings: &Settings,
        prepared: &Prepared<M>,
        document: &Document,
        plan: &StillPlan,
        sums: &Accumulation,
    ) -> Self {
        Self {
            settings: settings.clone(),
            samples: sums.samples.clone(),
            picture: prepared.header(document, plan),
            display: plan.look.display,
            cost: Cost::of(sums),
        }
    }
}

impl PartHeader {
    /// What no render writes is damage.
    fn check(&self) -> Result<(), &'static str> {
        let Settings { size, crop, spp, .. } = &self.settings;
        if self.samples.is_empty() || self.samples.end > *spp {
            return Err("its range of samples is damaged");
        }
        let whole = Window::whole(*size);
        if size.contains(&0) || !crop.unwrap_or(whole).fits(*size) {
            return Err("its size is damaged");
        }
        Ok(())
    }
}

impl Cost {
    pub fn of(sums: &Accumulation) -> Self {
        let Tally { rays, shadow_rays, draws: _, fans: _, non_finite, beyond_range, clamped } = sums.tally;
        let (threads, render_s, render_cpu_s) = (sums.threads, sums.render_s, sums.render_cpu_s);
        Self { rays, shadow_rays, non_finite, beyond_range, clamped, threads, render_s, render_cpu_s }
    }

    pub fn add_to(&self, sums: &mut Accumulation) {
        let Self { rays, shadow_rays, non_finite, beyond_range, clamped, threads, render_s, render_cpu_s } = *self;
        sums.tally += Tally { rays, shadow_rays, draws: 0, fans: 0, non_finite, beyond_range, clamped };
        sums.threads = sums.threads.max(threads);
        sums.render_s += render_s;
        sums.render_cpu_s += render_cpu_s;
    }
}

/// Writes a part, whole or not at all.
///
/// # Errors
/// The file cannot be written.
pub fn save(path: &Path, header: &PartHeader, sums: &Accumulation) -> Result<(), Error> {
    let text = serde_json::to_string(header).unwrap_or_default();
    let done = sums.is_complete();
    let blocks = sums.blocks().map(|block| {
        let note =
            if done { Vec::new() } else { [&block.goal.to_le_bytes()[..], &block.doublings.to_bytes()].concat() };
        PartBlock { next: block.next, values: block.totals, note }
    });
    Ok(output::write_part(path, &text, blocks)?)
}

/// A part whose header has been read.
pub struct Part<'a> {
    path: &'a Path,
    pub header: PartHeader,
    reader: PartReader,
}

impl<'a> Part<'a> {
    /// # Errors
    /// A file that is missing, damaged or no part, or of another version.
    pub fn open(path: &'a Path) -> Result<Self, Error> {
        let reader = PartReader::open(path)?;
        let header: PartHeader =
            serde_json::from_str(&reader.header).map_err(|error| damaged(path, error.to_string()))?;
        header.check().map_err(|reason| damaged(path, reason.to_owned()))?;
        Ok(Self { path, header, reader })
    }

    /// Reads the sums to the end of the file, which proves it whole, into an accumulation of the same range.
    ///
    /// # Errors
    /// A file that is damaged or cut short.
    pub fn restore(self) -> Result<Accumulation, Error> {
        let mut sums = self.header.settings.accumulation(self.header.samples.clone());
        self.header.cost.add_to(&mut sums);
        self.read(|blocks| sums.restore(blocks))?;
        Ok(sums)
    }

    /// Adds the sums to those of other ranges.
    ///
    /// # Errors
    /// A file that is damaged or cut short, or an interrupted render's checkpoint.
    pub fn add_to(self, sums: &mut Accumulation) -> Result<(), Error> {
        self.header.cost.add_to(sums);
        let samples = self.header.samples.clone();
        self.read(|blocks| sums.add(&samples, blocks))
    }

    fn read(self, take: impl FnOnce(&mut dyn Iterator<Item = Block>) -> Result<(), String>) -> Result<(), Error> {
        let mut failure = None;
        let mut blocks = self.reader.map_while(|block| match block {
            Ok(block) => Some(restored(block)),
            Err(error) => {
                failure = Some(error);
                None
            }
        });
        let taken = take(&mut blocks);
        drop(blocks);
        match failure {
            Some(error) => Err(error.into()),
            None => taken.map_err(|reason| damaged(self.path, reason)),
        }
    }
}

/// A block from a file. One without a note belongs to a part that was done.
fn restored(PartBlock { next, values, note }: PartBlock) -> Block {
    let noted = note
        .split_first_chunk()
        .and_then(|(goal, rest)| Some((u32::from_le_bytes(*goal), Doublings::from_bytes(rest)?)));
    let (goal, doublings) = noted.unwrap_or((next, Doublings::default()));
    Block { next, goal, totals: values, doublings }
}

fn damaged(path: &Path, reason: String) -> Error {
    OutputError::Damaged { path: path.to_path_buf(), reason }.into()
}
