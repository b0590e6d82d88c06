//! Pictures from paths: passes over tiles, accumulation, stopping, clocks.
//!
//! Samples are drawn per pixel in index order and added in f64, tiles share nothing: any number of threads gives the same
//! bits, however the samples are cut into passes.

mod clock;
mod edge;
mod filter;
mod frame;
mod tile;

use arrayvec::ArrayVec;
pub use clock::{available_memory, cpu_seconds, peak_rss_mb};
pub use filter::Filter;
pub use frame::Frame;
use glam::Vec2;
use rayon::prelude::*;
use thiserror::Error;

use crate::integrate::{GROUP, Path, PathLimits, Tally, radiances};
use crate::math::Sampler;
use crate::mode::{Lanes, Mode};
use crate::scene::{Camera, Scene};
use edge::Edges;
use tile::Tile;

/// Largest number of samples that a pass adds to each pixel. A render stops between tiles: no pixel is then more than this
/// ahead of another.
const PASS_SPP: u32 = 16;

/// What to render.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    pub spp: u32,
    pub seed: u32,
    /// 0 = all processors.
    pub threads: usize,
    pub filter: Filter,
    pub limits: PathLimits,
}

/// Told of progress; may stop the render.
pub trait Watch: Sync {
    /// `samples` more pixel samples are done; called from render threads.
    fn advanced(&self, samples: u64);
    /// Asked before each tile of a pass: true ends the render with the samples it has. Called from render threads; once
    /// true, always true.
    fn stop(&self) -> bool;
}

#[derive(Debug, Error)]
pub enum RenderError {
    #[error("cannot start {threads} render threads: {reason}")]
    Threads { threads: usize, reason: String },
    #[error(
        "a {width}x{height} picture needs {bytes} bytes of memory, but only {limit} are available; choose a smaller size or raise --max-memory"
    )]
    Memory { width: u32, height: u32, bytes: u64, limit: u64 },
}

/// Bytes per pixel at the peak, where the sums become a [`Frame`]: 72 by their types, with room for the rest.
const BYTES_PER_PIXEL: u64 = 80;

/// Refuses pictures that would not fit into `limit` bytes: a failed allocation could only abort the program, after hours.
///
/// # Errors
/// The bytes that the picture needs and those that there are.
pub fn check_memory([width, height]: [u32; 2], limit: u64) -> Result<(), RenderError> {
    let bytes = u64::from(width) * u64::from(height) * BYTES_PER_PIXEL;
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
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(plan.threads)
        .build()
        .map_err(|e| RenderError::Threads { threads: plan.threads, reason: e.to_string() })?;
    let mut tiles = Tile::grid(camera.size);
    let clock = std::time::Instant::now();
    let cpu_start = cpu_seconds();
    let mut tally = Tally::default();
    let mut done = 0;
    while done < plan.spp {
        // Small passes first, so that a short render shows something early.
        let count = done.clamp(1, PASS_SPP).min(plan.spp - done);
        let pass = pool.install(|| {
            tiles
                .par_iter_mut()
                .map(|tile| {
                    if watch.stop() {
                        return Tally::default();
                    }
                    let tally = render_tile(scene, camera, plan, tile, done..done + count);
                    watch.advanced(u64::from(count) * tile.pixels.len() as u64);
                    tally
                })
                .reduce(Tally::default, |mut a, b| {
                    a += b;
                    a
                })
        });
        tally += pass;
        done += count;
        if watch.stop() {
            break;
        }
    }
    let render_s = clock.elapsed().as_secs_f64();
    let render_cpu_s = cpu_seconds() - cpu_start;
    Ok(Frame::resolve(camera.size, tiles, tally, pool.current_num_threads(), render_s, render_cpu_s))
}

fn render_tile<M: Mode>(
    scene: &Scene<M>,
    camera: &Camera,
    plan: &Plan,
    tile: &mut Tile,
    samples: std::ops::Range<u32>,
) -> Tally {
    let mut tally = Tally::default();
    let edges = match tile.edges.take() {
        Some(edges) => edges,
        None => Edges::find(scene, camera, plan, tile, &mut tally),
    };
    for group in tile.groups() {
        for index in samples.clone() {
            render_group(scene, camera, plan, (tile, &edges), &group, index, &mut tally);
        }
    }
    tile.edges = Some(edges);
    tile.spp = samples.end;
    tally
}

/// Adds one sample to each pixel of a group.
#[inline]
fn render_group<M: Mode>(
    scene: &Scene<M>,
    camera: &Camera,
    plan: &Plan,
    (tile, edges): (&mut Tile, &Edges),
    group: &[u32],
    index: u32,
    tally: &mut Tally,
) {
    let number = |[x, y]: [u32; 2]| y.wrapping_mul(camera.size[0]).wrapping_add(x);
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
        let mut sampler = Sampler::new(number([x, y]), index, plan.seed);
        let [u_x, u_y, lens_x, lens_y] = sampler.next_4d();
        let offset = Vec2::new(plan.filter.sample(u_x), plan.filter.sample(u_y));
        let position = Vec2::new(x as f32, y as f32) + 0.5 + offset;
        let blind = edges.cross(x - tile.x0, y - tile.y0);
        paths.push(Path::new(camera.ray(position, [lens_x, lens_y]), waves, sampler, blind));
    }
    radiances(scene, &mut paths, &plan.limits, tally);
    for (&member, path) in group.iter().zip(&mut paths) {
        let [x, y] = tile.place(member);
        if edges.cross(x - tile.x0, y - tile.y0) {
            path.radiance += edge::seen_sample(scene, camera, plan, ([x, y], number([x, y])), index, &waves, tally);
        }
    }
    for (&member, path) in group.iter().zip(&paths) {
        if path.radiance.is_finite() {
            let rgb = M::to_rgb(path.radiance, &path.waves, &scene.stage.sensor);
            tile.pixels[member as usize].add(rgb);
        } else {
            tally.non_finite += 1;
        }
    }
}
