//! What serves a picture best, tried on a few of its pixels before it is rendered.
//!
//! Depends on the scene, the size of the picture and the seed alone, never on which of its pixels or samples are wanted:
//! parts that other machines render are rendered in the same way.

use arrayvec::ArrayVec;
use glam::Vec3;
use rayon::prelude::*;

use super::tile::{self, BLOCK};
use super::{Plan, camera_sample, number};
use crate::integrate::{GROUP, Guide, MOST_DRAWS_LOG2, Path, Strategy, Tactics, Tally, radiances};
use crate::math::{GOLDEN, Sampler};
use crate::mode::Mode;
use crate::scene::{Camera, Scene};

/// Photons are a small part of a picture's rays.
const PIXELS_PER_PHOTON: u32 = 2;
const MAX_PHOTONS: u32 = 1 << 18;
/// One group of so many is tried.
const GROUPS_PER_TRIAL: u32 = 256;
/// No picture needs more trials; with fewer, nothing is learned.
const MOST_TRIALS: u32 = 64;
const FEWEST_TRIALS: u32 = 16;
/// Half the samples of a pixel: enough to see what stratification does without more draws.
const HALF: u32 = 16;
/// What drawing a light and looking at a neighbour's find cost, with all that they take, in rays that are followed.
const DRAW_COST: f64 = 0.9;
const LOOK_COST: f64 = 0.25;
/// A pixel's error counts in relation to its group's brightness and this share of the picture's.
const DARK: f32 = 0.1;
/// A pixel whose error is so many times the brightness is as bad as can be: one must not decide for all. At 10 times, caustics
/// in which sharing is twice as efficient had it left out by one seed in four.
const WORST: f32 = 1.0;
/// Changes for less than this ratio are not worth making: few pixels cannot tell.
const WORTHWHILE: f64 = 0.95;

/// What two halves of some samples make of each pixel of a group.
struct Trial {
    pixels: ArrayVec<[Vec3; 2], GROUP>,
    tally: Tally,
}

/// How the paths of a picture are best followed.
pub fn tactics<M: Mode>(scene: &Scene<M>, camera: &Camera, plan: &Plan) -> Tactics {
    let [width, height] = camera.size;
    let shares = plan.limits.strategy == Strategy::Shared;
    let photons = (width.saturating_mul(height) / PIXELS_PER_PHOTON).min(MAX_PHOTONS);
    let guide = if shares { Guide::new(scene, photons) } else { None };
    let mut tactics = Tactics { limits: plan.limits, shares, draws_log2: 0, guide };
    let groups = groups(camera.size);
    if !shares || groups.len() < FEWEST_TRIALS as usize {
        return tactics;
    }

    let run = |tactics: &Tactics| -> Vec<Trial> {
        groups.par_iter().with_max_len(1).map(|group| trial(scene, camera, plan, tactics, group)).collect()
    };
    let base = run(&tactics);
    let weights = weights(&base);
    let mut best = cost(&base, &weights);
    for draws_log2 in 1..=MOST_DRAWS_LOG2 {
        tactics.draws_log2 = draws_log2;
        let cost = cost(&run(&tactics), &weights);
        if cost >= best * WORTHWHILE {
            tactics.draws_log2 -= 1;
            break;
        }
        best = cost;
    }
    tactics.shares = false;
    tactics.shares = cost(&run(&tactics), &weights) >= best * WORTHWHILE;
    tactics
}

/// Groups of tiles from all over the picture.
fn groups([width, height]: [u32; 2]) -> Vec<ArrayVec<[u32; 2], GROUP>> {
    let (columns, rows) = (width / BLOCK, height / BLOCK);
    let count = (columns * rows * BLOCK / GROUPS_PER_TRIAL).min(MOST_TRIALS);
    let group = |i: u32| {
        // Evenly over the picture's rows and columns of blocks (a lattice of the golden ratio), and over the groups of a block.
        let row = u64::from(2 * i + 1) * u64::from(rows) / u64::from(2 * count);
        let column = ((f64::from(i) + 0.5) * GOLDEN).fract() * f64::from(columns);
        tile::group([column as u32, row as u32], i % BLOCK).collect()
    };
    (0..count).map(group).collect()
}

fn trial<M: Mode>(scene: &Scene<M>, camera: &Camera, plan: &Plan, tactics: &Tactics, group: &[[u32; 2]]) -> Trial {
    let mut pixels: ArrayVec<[Vec3; 2], GROUP> = group.iter().map(|_| [Vec3::ZERO; 2]).collect();
    let mut tally = Tally::default();
    for index in 0..2 * HALF {
        let waves = M::waves(Sampler::new(number(camera, group[0]), index, !plan.seed).next_4d()[0]);
        let path = |&pixel: &[u32; 2]| {
            let (ray, sampler) = camera_sample(camera, plan, pixel, index);
            // What is seen directly is the same for all tactics.
            Path::new(ray, camera.interior, waves, sampler, true)
        };
        let mut paths = group.iter().map(path).collect();
        radiances(scene, tactics, &mut paths, &mut tally);
        for (pixel, path) in pixels.iter_mut().zip(&paths) {
            let rgb = M::to_rgb(path.radiance, &path.waves, &scene.stage.sensor);
            pixel[(index / HALF) as usize] += if rgb.is_finite() { rgb } else { Vec3::ZERO };
        }
    }
    Trial { pixels, tally }
}

/// What an error counts in each group: the inverse of its brightness.
fn weights(trials: &[Trial]) -> Vec<f32> {
    let mean = |trial: &Trial| {
        let sum: Vec3 = trial.pixels.iter().flatten().sum();
        sum.max_element().max(0.0) / (2 * trial.pixels.len().max(1)) as f32
    };
    let means: Vec<f32> = trials.iter().map(mean).collect();
    let whole = means.iter().sum::<f32>() / means.len() as f32;
    means.iter().map(|mean| 1.0 / (mean + DARK * whole).max(f32::MIN_POSITIVE)).collect()
}

/// Variance times work: the variance is the geometric mean of the absolute one and of that in relation to brightness.
fn cost(trials: &[Trial], weights: &[f32]) -> f64 {
    let (mut absolute, mut relative, mut work) = (0.0, 0.0, 0.0);
    for (trial, &weight) in trials.iter().zip(weights) {
        for [a, b] in &trial.pixels {
            let error2 = ((*a - *b) * weight).length_squared().min(WORST * WORST);
            relative += f64::from(error2);
            absolute += f64::from(error2 / (weight * weight));
        }
        let Tally { rays, shadow_rays, draws, .. } = trial.tally;
        work += rays as f64 + DRAW_COST * draws as f64 + LOOK_COST * (shadow_rays - draws.min(shadow_rays)) as f64;
    }
    (absolute * relative).sqrt() * work
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trials_lie_in_the_picture_and_are_groups_of_tiles() {
        for size in [[16, 16], [64, 48], [1000, 301], [7680, 4320]] {
            let groups = groups(size);
            assert!(groups.len() <= MOST_TRIALS as usize);
            for group in &groups {
                assert!(group.iter().all(|&[x, y]| x < size[0] && y < size[1]));
                let block = group[0].map(|at| at / BLOCK);
                let is_of_tiles = |number| tile::group(block, number).eq(group.iter().copied());
                assert_eq!((0..BLOCK).filter(|&number| is_of_tiles(number)).count(), 1);
            }
        }
        assert_eq!(groups([7, 500]).len(), 0);
    }

    /// Also of pictures whose sides are powers of two: steps of so many blocks would come back to the same column.
    #[test]
    fn trials_look_at_all_of_the_picture() {
        for [width, height] in [[256, 256], [512, 512], [1024, 512], [1920, 1080], [1080, 1920], [7680, 4320]] {
            let mut seen = [[false; 4]; 4];
            for group in groups([width, height]) {
                let [x, y] = group[0];
                seen[(4 * y / height) as usize][(4 * x / width) as usize] = true;
            }
            assert_eq!(seen, [[true; 4]; 4], "{width}x{height}");
        }
    }

    #[test]
    fn one_wild_pixel_does_not_decide_for_all() {
        let trials = |noise: f32| -> Vec<Trial> {
            let pixels = |_| [Vec3::ONE, Vec3::new(1.0 + noise, 1.0, 1.0)];
            let tally = Tally { rays: 100, ..Tally::default() };
            (0..MOST_TRIALS).map(|_| Trial { pixels: (0..GROUP).map(pixels).collect(), tally }).collect()
        };
        let cost = |trials: &[Trial]| cost(trials, &weights(trials));
        let (mut calm, noisy) = (trials(0.2), trials(0.4));
        assert!(cost(&noisy) > 3.0 * cost(&calm));
        calm[7].pixels[3][0] = Vec3::splat(100.0);
        assert!(cost(&noisy) > 1.5 * cost(&calm));
    }
}
