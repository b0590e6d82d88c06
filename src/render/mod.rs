//! Pictures from paths: passes over tiles, accumulation, stopping, clocks.
//!
//! A sample is a function of pixel and index alone, and sums are exact (`sums.rs`): any number of threads gives the same
//! bits, however the samples are cut into passes, or into parts that other machines render.

mod accumulation;
mod adaptive;
mod bug;
mod clock;
mod doublings;
mod edge;
mod filter;
mod frame;
mod noise;
mod pilot;
mod splats;
mod sums;
mod survey;
mod tile;

use std::collections::BTreeSet;
use std::ops::Range;

pub use accumulation::{Accumulation, Block};
use arrayvec::ArrayVec;
use bug::{At, Bug, panics};
pub use clock::{CpuClock, available_memory, peak_rss_mb};
pub use doublings::Doublings;
pub use filter::Filter;
pub use frame::Frame;
use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use sums::Samples;
pub use sums::Totals;
pub use survey::{FAR_M, Seen, Survey};
use thiserror::Error;

use crate::embree::Ray;
use crate::integrate::{GROUP, Path, PathLimits, Tactics, Tally, radiances};
use crate::math::Sampler;
use crate::mode::Mode;
use crate::scene::{Camera, Scene};
use edge::Edges;
use splats::{Splats, SplatsOfTile};
use tile::Tile;

/// What to render.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    pub spp: u32,
    pub seed: u32,
    /// 0 = all processors.
    pub threads: usize,
    pub filter: Filter,
    pub limits: PathLimits,
    /// Largest channel of one sample, linear sRGB; brighter ones are scaled down to it, which loses light. `None`: unbiased.
    pub clamp: Option<f32>,
    /// Estimated error ([`Frame::noise`]) at which the render ends, with the samples where they help most (`adaptive.rs`);
    /// `spp` is the most that a pixel gets then. `None`: every pixel gets them all.
    pub noise: Option<f64>,
}

/// Told of progress; may stop the render.
pub trait Watch: Sync {
    /// `samples` more pixel samples are done; called from render threads.
    fn advanced(&self, samples: u64);
    /// Asked before each tile of a pass: true ends the render with the samples it has. Called from render threads; once
    /// true, always true.
    fn stop(&self) -> bool;
    /// Asked before each pass after the first: samples per pixel that it shall add; 0 ends the render.
    fn pass(&self, so_far: &Accumulation) -> u32 {
        so_far.usual_pass()
    }
    /// Told when the render ends, for whatever reason.
    fn done(&self, _sums: &Accumulation) {}
}

/// Nobody looks on: a render that is a part of something else, or that is timed.
pub struct Unwatched;

impl Watch for Unwatched {
    fn advanced(&self, _samples: u64) {}
    fn stop(&self) -> bool {
        false
    }
}

#[derive(Debug, Error)]
pub enum RenderError {
    /// A panic. The sums hold whole tiles: what was rendered besides is there, and can be saved.
    #[error("a bug in pellicle{}: {reason}; please report it with the scene", bug_place(at))]
    Bug { at: Option<([u32; 2], u32)>, reason: String },
    #[error("cannot start {threads} render threads: {reason}")]
    Threads { threads: usize, reason: String },
    #[error(
        "a {width}x{height} picture needs {bytes} bytes of memory, but only {limit} are available; choose a smaller size or raise --max-memory"
    )]
    Memory { width: u32, height: u32, bytes: u64, limit: u64 },
}

fn bug_place(at: &Option<([u32; 2], u32)>) -> String {
    at.map_or(String::new(), |([x, y], sample)| format!(", met at sample {sample} of pixel {x},{y}"))
}

/// Bytes per pixel at the peak, where the sums become a [`Frame`]: 72 by their types, 80 where variances are wanted.
/// (Tiles that go on in 128 bits take 48 more; they are those of lamps and fireflies.)
const BYTES_PER_PIXEL: u64 = 80;
/// What a [`Survey`], or the sums of light groups, and the layers that are made of them take besides.
const LAYER_BYTES_PER_PIXEL: u64 = 240;

/// Refuses pictures that would not fit into `limit` bytes: a failed allocation could only abort the program, after hours.
///
/// # Errors
/// The bytes that the picture needs and those that there are.
pub fn check_memory([width, height]: [u32; 2], layered: bool, limit: u64) -> Result<(), RenderError> {
    let per_pixel = BYTES_PER_PIXEL + if layered { LAYER_BYTES_PER_PIXEL } else { 0 };
    let bytes = u64::from(width) * u64::from(height) * per_pixel;
    if bytes > limit { Err(RenderError::Memory { width, height, bytes, limit }) } else { Ok(()) }
}

/// Renders a picture. When the watch stops it, pixels have their own numbers of samples, and [`Frame::spp`] is the least.
///
/// # Errors
/// Threads that the machine cannot give.
pub fn render<M: Mode>(
    scene: &Scene<M>,
    camera: &Camera,
    plan: &Plan,
    watch: &dyn Watch,
) -> Result<Frame, RenderError> {
    let mut sums = Accumulation::cropped(camera.size, camera.window(), 0..plan.spp);
    accumulate(scene, camera, plan, &mut sums, watch)?;
    Ok(sums.into_frame(true))
}

/// Adds to `sums` the samples that it lacks of its range, or as many of them as there are until the watch or the noise ends
/// the render. False where the watch stopped it in the middle.
///
/// # Errors
/// Threads that the machine cannot give; a panic, which leaves `sums` as if the watch had stopped there.
pub fn accumulate<M: Mode>(
    scene: &Scene<M>,
    camera: &Camera,
    plan: &Plan,
    sums: &mut Accumulation,
    watch: &dyn Watch,
) -> Result<bool, RenderError> {
    let pool = pool(plan)?;
    sums.threads = pool.current_num_threads();
    let camera = &camera.settled(scene);
    let clock = std::time::Instant::now();
    let cpu_clock = CpuClock::start();
    let view = View { scene, camera, plan, tactics: pool.install(|| pilot::tactics(scene, camera, plan)) };
    let bug = Bug::default();
    while !watch.stop() && !bug.is_met() && sums.wants_more(plan.noise) {
        let mut count = if sums.spp() == 0 { 1 } else { watch.pass(sums) };
        if count == 0 {
            break;
        }
        if let Some(throw) = &view.tactics.throw {
            count = count.min(splats::rounds_at_once(throw));
        }
        let behind = sums.behind(count);
        let first = sums.samples.start;
        let end_of = |tile: &Tile| tile.goal - behind.min(tile.goal - first);
        let thrown = pool.install(|| bug.guard(|| splats_of_pass(&view, sums, end_of), || None));
        let Some((splats, tally)) = thrown else { break };
        sums.tally += tally;
        sums.tally += pool.install(|| {
            sums.tiles
                .par_iter_mut()
                .enumerate()
                // Tile by tile: of longer runs one is left over when the other threads have no more to do.
                .with_max_len(1)
                .map(|(number, tile)| {
                    let end = end_of(tile);
                    if tile.next >= end || watch.stop() || bug.is_met() {
                        return Tally::default();
                    }
                    let samples = tile.next..end;
                    let Some(tally) = render_tile(&view, tile, (samples.clone(), splats.of_tile(number)), &bug) else {
                        return Tally::default();
                    };
                    tile.doublings.note(&tile.sums, tile.next - first);
                    watch.advanced(samples.len() as u64 * tile.sums.len() as u64);
                    tally
                })
                .reduce(Tally::default, |mut a, b| {
                    a += b;
                    a
                })
        });
    }
    sums.render_s += clock.elapsed().as_secs_f64();
    sums.render_cpu_s += cpu_clock.seconds();
    watch.done(sums);
    bug.into_result()?;
    Ok(!watch.stop() || !sums.wants_more(plan.noise))
}

/// What light paths bring to the samples that tiles are to be given, up to the `end_of` each.
fn splats_of_pass<M: Mode>(view: &View<M>, sums: &Accumulation, end_of: impl Fn(&Tile) -> u32) -> (Splats<M>, Tally) {
    let Some(throw) = &view.tactics.throw else { return (Splats::NONE, Tally::default()) };
    let ranges: BTreeSet<(u32, u32)> = sums.tiles.iter().map(|tile| (tile.next, end_of(tile))).collect();
    let rounds: BTreeSet<u32> = ranges.into_iter().flat_map(|(next, end)| next..end).collect();
    let rounds: Vec<u32> = rounds.into_iter().collect();
    Splats::of_rounds(view.scene, view.plan, throw, (sums.size, &sums.tiles), &rounds)
}

fn pool(plan: &Plan) -> Result<ThreadPool, RenderError> {
    let failed = |e: ThreadPoolBuildError| RenderError::Threads { threads: plan.threads, reason: e.to_string() };
    ThreadPoolBuilder::new().num_threads(plan.threads).build().map_err(failed)
}

/// What every sample of a render needs.
struct View<'a, M: Mode> {
    scene: &'a Scene<M>,
    camera: &'a Camera,
    plan: &'a Plan,
    tactics: Tactics,
}

/// `None` after a panic: the tile is as before then.
fn render_tile<M: Mode>(
    view: &View<M>,
    tile: &mut Tile,
    (samples, splats): (Range<u32>, SplatsOfTile<M>),
    bug: &Bug,
) -> Option<Tally> {
    let View { scene, camera, plan, .. } = view;
    let mut tally = Tally::default();
    let edges = match tile.edges.take() {
        Some(edges) => edges,
        None => bug.guard(|| Edges::find(scene, camera, plan, tile, &mut tally), || None)?,
    };
    let groups = tile.groups();
    let (end, at) = (samples.end, At::new(None));
    let rendered = bug.guard(
        || render_groups(view, (tile, &edges), &groups, (samples, &splats), &at),
        || at.get().map(|(group, index)| (culprit(view, (tile, &edges), group, index), index)),
    );
    tile.edges = Some(edges);
    let (sums, lights, more) = rendered?;
    for (pixel, sum) in &sums {
        tile.sums.add_samples(*pixel as usize, sum);
    }
    (tile.lights, tile.next) = (lights, end);
    tally += more;
    Some(tally)
}

/// What some samples add to each pixel of a tile, and what its light groups have with them.
fn render_groups<'g, M: Mode>(
    view: &View<M>,
    (tile, edges): (&Tile, &Edges),
    groups: &'g [ArrayVec<u32, GROUP>],
    (samples, splats): (Range<u32>, &SplatsOfTile<M>),
    at: &At<'g>,
) -> (Vec<(u32, Samples)>, Vec<DVec3>, Tally) {
    let mut tally = Tally::default();
    let mut lights = tile.lights.clone();
    lights.resize(tile.sums.len() * M::GROUPS, DVec3::ZERO);
    let mut all = Vec::with_capacity(tile.sums.len());
    for group in groups {
        let mut sums: [Samples; GROUP] = Default::default();
        for index in samples.clone() {
            at.set(Some((group, index)));
            render_group(view, (tile, edges), (group, index), splats, &mut sums, &mut lights, &mut tally);
        }
        all.extend(group.iter().copied().zip(sums));
    }
    (all, lights, tally)
}

/// The pixel of a group whose sample panics: the first that does so by itself; else one of those that do together.
fn culprit<M: Mode>(view: &View<M>, (tile, edges): (&Tile, &Edges), group: &[u32], index: u32) -> [u32; 2] {
    let alone = |pixel: u32| {
        let mut lights = vec![DVec3::ZERO; tile.sums.len() * M::GROUPS];
        let (mut sums, mut tally) = (Default::default(), Tally::default());
        render_group(view, (tile, edges), (&[pixel], index), &SplatsOfTile::NONE, &mut sums, &mut lights, &mut tally);
    };
    let culprit = group.iter().copied().find(|&pixel| panics(|| alone(pixel)));
    tile.place(culprit.or(group.first().copied()).unwrap_or(0))
}

/// The number by which a pixel draws its samples.
#[inline]
fn number(camera: &Camera, [x, y]: [u32; 2]) -> u32 {
    y.wrapping_mul(camera.size[0]).wrapping_add(x)
}

/// The camera ray of one sample of a pixel, and the numbers that its path goes on with.
#[inline]
fn camera_sample(camera: &Camera, plan: &Plan, [x, y]: [u32; 2], index: u32) -> (Ray, Sampler) {
    let mut sampler = Sampler::new(number(camera, [x, y]), index, plan.seed);
    let [u_x, u_y, lens_x, lens_y] = sampler.next_4d();
    let offset = Vec2::new(plan.filter.sample(u_x), plan.filter.sample(u_y));
    (camera.ray(Vec2::new(x as f32, y as f32) + 0.5 + offset, [lens_x, lens_y]), sampler)
}

/// Adds one sample to the sums of each pixel of a group.
#[inline]
fn render_group<M: Mode>(
    view: &View<M>,
    (tile, edges): (&Tile, &Edges),
    (group, index): (&[u32], u32),
    splats: &SplatsOfTile<M>,
    sums: &mut [Samples; GROUP],
    lights: &mut [DVec3],
    tally: &mut Tally,
) {
    let View { scene, camera, plan, tactics } = view;
    let number = |place| number(camera, place);
    // All paths of a group carry the same wavelengths: they look at each other's finds.
    let waves = match group.first() {
        Some(&first) if M::SAMPLES_WAVES => {
            M::waves(Sampler::new(number(tile.place(first)), index, !plan.seed).next_4d()[0])
        }
        _ => M::waves(0.0),
    };
    let mut paths = ArrayVec::<Path<M>, GROUP>::new();
    for &member in group {
        let [x, y] = tile.place(member);
        let (ray, sampler) = camera_sample(camera, plan, [x, y], index);
        let blind = edges.cross(x - tile.x0, y - tile.y0);
        paths.push(Path::new(ray, camera.interior, waves, sampler, blind));
    }
    radiances(scene, tactics, &mut paths, tally);
    for (&member, path) in group.iter().zip(&mut paths) {
        let [x, y] = tile.place(member);
        if edges.cross(x - tile.x0, y - tile.y0) {
            path.radiance += edge::seen_sample(scene, camera, plan, ([x, y], number([x, y])), index, &waves, tally);
        }
    }
    for ((path, sum), &member) in paths.iter().zip(sums).zip(group) {
        let lights = &mut lights[member as usize * M::GROUPS..(member as usize + 1) * M::GROUPS];
        let own = (path.radiance, path.waves);
        let parts = std::iter::once(own).chain(splats.of(member, index).map(|splat| (splat.radiance, splat.waves)));
        add_sample(view, parts, sum, lights, tally);
    }
}

/// Adds a sample, given in parts, to the sums of a pixel and of its light groups.
#[inline]
fn add_sample<M: Mode>(
    View { scene, plan, .. }: &View<M>,
    parts: impl Iterator<Item = (M::Light, M::Waves)> + Clone,
    sum: &mut Samples,
    lights: &mut [DVec3],
    tally: &mut Tally,
) {
    let sensor = &scene.stage.sensor;
    let mut rgb: Vec3 = parts.clone().map(|(light, waves)| M::to_rgb(light, &waves, sensor)).sum();
    if !rgb.is_finite() {
        tally.non_finite += 1;
        return;
    }
    let mut scale = 1.0;
    if let Some(limit) = plan.clamp.filter(|&limit| rgb.abs().max_element() > limit) {
        scale = limit / rgb.abs().max_element();
        rgb *= scale;
        tally.clamped += 1;
    }
    for (number, sum) in lights.iter_mut().enumerate() {
        let part: Vec3 = parts.clone().map(|(light, waves)| M::group_to_rgb(&light, number, &waves, sensor)).sum();
        *sum += (part * scale).as_dvec3();
    }
    tally.beyond_range += u64::from(!sum.add(rgb));
}
