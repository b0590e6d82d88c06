//! What the camera sees in each pixel besides light: a pass of its own over the first samples of the picture.
//!
//! It takes the very camera rays of those samples, so that edges are where the picture has them; a picture without such
//! layers pays nothing. What can be mixed (albedo, normals) is averaged over the samples; what cannot (depth, position,
//! texture coordinates, thickness) is that of the sample nearest to the camera; who covers how much of a pixel is counted.

use std::collections::BTreeMap;
use std::ops::Range;
use std::time::Instant;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::clock::CpuClock;
use super::{Plan, RenderError, camera_sample, pool};
use crate::embree::BATCH;
use crate::integrate::{Clue, Looker, Sight, Wanted};
use crate::math::GOLDEN;
use crate::mode::Mode;
use crate::scene::{Camera, Scene, Window};

/// Samples that are looked at: enough for smooth edges, and a small share of what long renders take.
const MOST_SAMPLES: u32 = 64;

/// Depth where there is no surface, metres.
pub const FAR_M: f32 = 1e10;

/// What one pixel shows.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Means over the samples (sums, as long as they come in); nothing counts as 0.
    pub albedo: Vec3,
    pub normal: Vec3,
    pub ng: Vec3,
    pub clue: Clue,
    /// Of the nearest sample: distance along the viewing direction ([`FAR_M`] where there is no surface), ...
    pub depth_m: f32,
    pub position: Vec3,
    pub uv: Vec2,
    pub film_nm: f32,
}

impl Seen {
    const NOTHING: Self = Self {
        albedo: Vec3::ZERO,
        normal: Vec3::ZERO,
        ng: Vec3::ZERO,
        clue: Clue { albedo: Vec3::ZERO, normal: Vec3::ZERO },
        depth_m: FAR_M,
        position: Vec3::ZERO,
        uv: Vec2::ZERO,
        film_nm: 0.0,
    };
}

/// How many samples of each pixel of a row met what: by column and number.
type Counts = BTreeMap<(u32, u32), u32>;

/// One row of pixels.
#[derive(Clone)]
struct Row {
    pixels: Vec<Seen>,
    nodes: Counts,
    materials: Counts,
}

/// What all pixels show.
pub struct Survey {
    rows: Vec<Row>,
    window: Window,
    samples: u32,
    wanted: Wanted,
    /// Wall and user + system seconds.
    pub survey_s: f64,
    pub survey_cpu_s: f64,
}

impl Survey {
    /// Of a part of a picture.
    pub fn new(window: Window, wanted: Wanted) -> Self {
        let Window { width, height, .. } = window;
        let row = Row { pixels: vec![Seen::NOTHING; width as usize], nodes: Counts::new(), materials: Counts::new() };
        Self { rows: vec![row; height as usize], window, samples: 0, wanted, survey_s: 0.0, survey_cpu_s: 0.0 }
    }

    /// Looks along the camera rays of these samples of every pixel, up to the first 64.
    ///
    /// # Errors
    /// Threads that the machine cannot give.
    pub fn add<M: Mode>(
        &mut self,
        scene: &Scene<M>,
        camera: &Camera,
        plan: &Plan,
        samples: Range<u32>,
    ) -> Result<(), RenderError> {
        let samples = samples.start..samples.end.min(MOST_SAMPLES);
        let pool = pool(plan)?;
        let (clock, cpu_clock) = (Instant::now(), CpuClock::start());
        let camera = &camera.settled(scene);
        let Window { x: x0, y: y0, .. } = self.window;
        let looker = Looker::new(scene, self.wanted);
        pool.install(|| {
            self.rows.par_iter_mut().with_max_len(1).enumerate().for_each(|(y, row)| {
                for x in 0..row.pixels.len() as u32 {
                    row.add(&looker, camera, plan, (x, [x0 + x, y0 + y as u32]), samples.clone());
                }
            });
        });
        self.samples += samples.len() as u32;
        self.survey_s += clock.elapsed().as_secs_f64();
        self.survey_cpu_s += cpu_clock.seconds();
        Ok(())
    }

    /// All pixels, row by row.
    pub fn pixels(&self) -> impl Iterator<Item = Seen> + '_ {
        let share = 1.0 / self.samples.max(1) as f32;
        self.rows.iter().flat_map(|row| &row.pixels).map(move |&sum| Seen {
            albedo: sum.albedo * share,
            // Directions, not lengths, are what is wanted.
            normal: sum.normal.normalize_or_zero(),
            ng: sum.ng.normalize_or_zero(),
            clue: Clue { albedo: sum.clue.albedo * share, normal: sum.clue.normal * share },
            ..sum
        })
    }

    /// (pixel, node, share of its samples) for everything that is seen, pixel by pixel.
    pub fn nodes(&self) -> impl Iterator<Item = (usize, u32, f32)> + '_ {
        self.shares(|row| &row.nodes)
    }

    /// The same for materials.
    pub fn materials(&self) -> impl Iterator<Item = (usize, u32, f32)> + '_ {
        self.shares(|row| &row.materials)
    }

    fn shares(&self, counts: fn(&Row) -> &Counts) -> impl Iterator<Item = (usize, u32, f32)> + '_ {
        let samples = self.samples.max(1) as f32;
        self.rows.iter().enumerate().flat_map(move |(y, row)| {
            let first = y * row.pixels.len();
            counts(row).iter().map(move |(&(x, id), &count)| (first + x as usize, id, count as f32 / samples))
        })
    }
}

impl Row {
    fn add<M: Mode>(
        &mut self,
        looker: &Looker<M>,
        camera: &Camera,
        plan: &Plan,
        (x, place): (u32, [u32; 2]),
        samples: Range<u32>,
    ) {
        let pixel = &mut self.pixels[x as usize];
        let mut met: Vec<((u32, u32), u32)> = Vec::new();
        for first in samples.clone().step_by(BATCH) {
            let count = BATCH.min((samples.end - first) as usize);
            let rays = std::array::from_fn(|i| {
                let index = (first + i as u32).min(samples.end - 1);
                let (ray, sampler) = camera_sample(camera, plan, place, index);
                (ray, sampler, (f64::from(index) * GOLDEN).fract() as f32)
            });
            for (sight, clue) in looker.look(&rays, camera.interior, count).into_iter().take(count) {
                pixel.clue.albedo += clue.albedo;
                pixel.clue.normal += clue.normal;
                let Some(sight) = sight else { continue };
                pixel.add(&sight, camera.depth_m(sight.position));
                let this = (sight.node, sight.material);
                match met.iter_mut().find(|(known, _)| *known == this) {
                    Some((_, count)) => *count += 1,
                    None => met.push((this, 1)),
                }
            }
        }
        for ((node, material), count) in met {
            *self.nodes.entry((x, node)).or_default() += count;
            *self.materials.entry((x, material)).or_default() += count;
        }
    }
}

impl Seen {
    fn add(&mut self, sight: &Sight, depth_m: f32) {
        self.albedo += sight.albedo;
        self.normal += sight.normal;
        self.ng += sight.ng;
        if depth_m < self.depth_m {
            let Sight { position, uv, film_nm, .. } = *sight;
            *self = Self { depth_m, position, uv, film_nm, ..*self };
        }
    }
}
