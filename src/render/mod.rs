//! Pictures from paths: passes over tiles, accumulation, stopping, clocks.
//!
//! Samples are drawn per pixel in index order and added in f64, tiles share nothing: any number of threads gives the same
//! bits.

mod clock;
mod filter;
mod frame;
mod tile;

pub use clock::{cpu_seconds, peak_rss_mb};
pub use filter::Filter;
pub use frame::Frame;
use glam::Vec2;
use rayon::prelude::*;
use thiserror::Error;

use crate::integrate::{PathLimits, Tally, radiance};
use crate::math::Sampler;
use crate::mode::{Lanes, Mode};
use crate::scene::{Camera, Scene};
use tile::{Pixel, Tile};

/// Largest number of samples that a pass adds to each pixel: passes are where a render can stop and report.
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

/// Told of progress; may stop the render between passes.
pub trait Watch: Sync {
    /// `tiles` more tiles of the current pass are done; called from render threads.
    fn advanced(&self, samples: u64);
    /// Asked after each pass: true ends the render with the samples it has.
    fn stop(&self) -> bool;
}

#[derive(Debug, Error)]
pub enum RenderError {
    #[error("cannot start {threads} render threads: {reason}")]
    Threads { threads: usize, reason: String },
    #[error(
        "a {width}x{height} picture needs {bytes} bytes for its samples, more than this machine can give; choose a smaller size"
    )]
    Memory { width: u32, height: u32, bytes: u64 },
}

/// Renders a picture.
///
/// # Errors
/// Threads or memory that the machine cannot give.
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
    let mut tiles = Tile::grid(camera.size)?;
    let clock = std::time::Instant::now();
    let cpu_start = cpu_seconds();
    let mut tally = Tally::default();
    let mut done = 0;
    while done < plan.spp {
        // Small passes first, so that a short render shows something early.
        let count = done.max(1).min(PASS_SPP).min(plan.spp - done);
        let pass = pool.install(|| {
            tiles
                .par_iter_mut()
                .map(|tile| {
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
    Ok(Frame::resolve(camera.size, done, tiles, tally, pool.current_num_threads(), render_s, render_cpu_s))
}

fn render_tile<M: Mode>(
    scene: &Scene<M>,
    camera: &Camera,
    plan: &Plan,
    tile: &mut Tile,
    samples: std::ops::Range<u32>,
) -> Tally {
    let mut tally = Tally::default();
    let (x0, y0, width) = (tile.x0, tile.y0, tile.width);
    for (i, pixel) in tile.pixels.iter_mut().enumerate() {
        let (x, y) = (x0 + i as u32 % width, y0 + i as u32 / width);
        for index in samples.clone() {
            render_sample(scene, camera, plan, [x, y], index, pixel, &mut tally);
        }
    }
    tally
}

#[inline]
fn render_sample<M: Mode>(
    scene: &Scene<M>,
    camera: &Camera,
    plan: &Plan,
    [x, y]: [u32; 2],
    index: u32,
    pixel: &mut Pixel,
    tally: &mut Tally,
) {
    let mut sampler = Sampler::new(y.wrapping_mul(camera.size[0]).wrapping_add(x), index, plan.seed);
    let [u_x, u_y, lens_x, lens_y] = sampler.next_4d();
    let offset = Vec2::new(plan.filter.sample(u_x), plan.filter.sample(u_y));
    let position = Vec2::new(x as f32, y as f32) + 0.5 + offset;
    let mut waves = if M::SAMPLES_WAVES { M::waves(sampler.next_4d()[0]) } else { M::waves(0.0) };
    let ray = camera.ray(position, [lens_x, lens_y]);
    let light = radiance(scene, ray, &mut waves, &mut sampler, &plan.limits, tally);
    if light.is_finite() {
        pixel.add(M::to_rgb(light, &waves, &scene.stage.sensor));
    } else {
        tally.non_finite += 1;
    }
}
