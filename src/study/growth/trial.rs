//! One scene of one size: what it costs to build and to render.

use std::sync::Arc;
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::scenes;
use crate::document::Document;
use crate::error::Error;
use crate::integrate::{PathLimits, Strategy};
use crate::mode::Mode;
use crate::render::{self, CpuClock, Filter, Frame, Plan, Unwatched, peak_rss_mb};
use crate::scene::{BuildError, Camera, FilmOptions, Framing, LightGroups, Scene, Stage};
use crate::study::metrics::{Image, squared_errors};

/// What is built in less is built so many times, to see past what disturbs it. Longer ones are not: memory that has been
/// used before would make them quicker than they are.
const SHORT_S: f64 = 0.01;
const BUILDS: usize = 9;
/// How films are compiled, as where nobody says otherwise.
const FILMS: FilmOptions = FilmOptions { tolerance: 1.0, rung: None };

/// What there is to measure on.
#[derive(Clone, Copy, Debug)]
pub struct Machine {
    /// 0 = all processors.
    pub threads: usize,
    /// Most bytes that a scene, and then its picture, may take.
    pub max_memory: u64,
}

/// How a scene is rendered, and how often: with other seeds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shots {
    /// Pixels of a side of the picture.
    pub side: u32,
    pub spp: u32,
    pub max_bounces: u32,
    pub renders: u32,
}

/// Seconds are processor seconds over threads. Memory is the most that was resident, over what was before the document, in
/// MB (10^6 bytes); 0 where the kernel does not tell.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Cost {
    pub threads: usize,
    /// From the document to the scene, with its BVH: median, where that is short enough to be repeated.
    pub build_s: f64,
    /// The same by the clock on the wall.
    pub build_wall_s: f64,
    /// Of document and scene, while that is built.
    pub build_mb: f64,
    /// Microseconds of a pixel sample: median over the renders.
    pub sample_us: f64,
    /// Rays and shadow rays of a pixel sample.
    pub sample_rays: f64,
    /// Of document, scene and picture, while that is rendered.
    pub render_mb: f64,
    /// Of one picture, by how several differ; `None` where there is just one.
    pub rel_mse: Option<f64>,
}

/// Builds the scene of `document` and renders it. Memory is measured rightly only where the process has done nothing before:
/// what was freed is taken again. `label` names the scene in errors.
///
/// # Errors
/// More memory than there may be; threads that the machine cannot give.
pub(super) fn measure<M: Mode>(
    machine: &Machine,
    label: &str,
    document: impl Fn() -> Document,
    shots: &Shots,
) -> Result<Cost, Error> {
    let failed = |source| Error::Build { scene: label.to_owned(), source };
    render::check_memory([shots.side; 2], false, machine.max_memory)?;
    let plan = Plan {
        spp: shots.spp,
        seed: 0,
        threads: machine.threads,
        filter: Filter::BlackmanHarris,
        limits: PathLimits { max_bounces: shots.max_bounces, strategy: Strategy::Shared },
        clamp: None,
        noise: None,
    };
    let camera_of = |document: &Document, scene: &Scene<M>, side: u32| {
        Camera::new(document, None, [Some(side); 2], Framing::Scene, scene.stage.bounds).map_err(Error::Usage)
    };
    // What the first of all scenes pays for, the others find ready.
    let any = scenes::room();
    let (scene, _) = build::<M>(machine, &any).map_err(failed)?;
    render::render(&scene, &camera_of(&any, &scene, 8)?.0, &plan, &Unwatched)?;
    drop((any, scene));

    let before_mb = peak_rss_mb();
    // The kernel counts in batches: what takes nothing may seem to give some back.
    let grown_mb = || (peak_rss_mb() - before_mb).max(0.0);
    let document = document();
    let (scene, first) = build::<M>(machine, &document).map_err(failed)?;
    let build_mb = grown_mb();
    let mut builds = vec![first];
    while builds[0].wall_s < SHORT_S && builds.len() < BUILDS {
        builds.push(build::<M>(machine, &document).map_err(failed)?.1);
    }
    let (camera, _) = camera_of(&document, &scene, shots.side)?;
    // The first render brings the scene into the caches.
    render::render(&scene, &camera.resized([64; 2]), &Plan { spp: 1, ..plan }, &Unwatched)?;
    let mut frames = Vec::new();
    for seed in 0..shots.renders {
        frames.push(render::render(&scene, &camera, &Plan { seed, ..plan }, &Unwatched)?);
    }
    let threads = frames.first().map_or(1, |frame| frame.threads);
    let sample_us = |frame: &Frame| 1e6 * frame.render_cpu_s / (threads as f64 * frame.total as f64);
    let sample_rays = |frame: &Frame| (frame.tally.rays + frame.tally.shadow_rays) as f64 / frame.total as f64;
    Ok(Cost {
        threads,
        build_s: median(builds.iter().map(|took| took.cpu_s / threads as f64)),
        build_wall_s: median(builds.iter().map(|took| took.wall_s)),
        build_mb,
        sample_us: median(frames.iter().map(sample_us)),
        sample_rays: median(frames.iter().map(sample_rays)),
        render_mb: grown_mb(),
        rel_mse: rel_mse(&frames),
    })
}

struct Took {
    cpu_s: f64,
    wall_s: f64,
}

fn build<M: Mode>(machine: &Machine, document: &Document) -> Result<(Scene<M>, Took), BuildError> {
    let (clock, cpu_clock) = (Instant::now(), CpuClock::start());
    let Machine { threads, max_memory } = *machine;
    let stage = Stage::movable(document, threads, Vec::new(), LightGroups::default(), max_memory)?;
    let scene = Scene::new(Arc::new(stage), &FILMS)?;
    // While the threads of the building still live.
    let took = Took { cpu_s: cpu_clock.seconds(), wall_s: clock.elapsed().as_secs_f64() };
    Ok((scene, took))
}

/// The relMSE of one of several independent pictures, from how they differ.
fn rel_mse(frames: &[Frame]) -> Option<f64> {
    let images: Vec<Image> = frames.iter().map(Image::from).collect();
    let (first, others) = images.split_first()?;
    if others.is_empty() {
        return None;
    }
    let mut mean = Image { variance: None, ..first.clone() };
    for (i, pixel) in mean.rgb.iter_mut().enumerate() {
        *pixel = std::array::from_fn(|c| images.iter().map(|image| image.rgb[i][c]).sum::<f64>() / images.len() as f64);
    }
    // Pictures are nearer to their own mean than to the truth: by one in their number.
    let sum: f64 = images.iter().map(|image| squared_errors(image, &mean, None).rel_mse).sum();
    Some(sum / others.len() as f64)
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
