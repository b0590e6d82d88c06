//! What serves a picture best, tried on a few of its pixels before it is rendered.
//!
//! Depends on the scene, the size of the picture and the seed alone, never on which of its pixels or samples are wanted:
//! parts that other machines render are rendered in the same way.

use arrayvec::ArrayVec;
use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::tile::{self, BLOCK};
use super::{Plan, camera_sample, number};
use crate::embree::BATCH;
use crate::integrate::{GROUP, MOST_DRAWS_LOG2, Path, Strategy, Tactics, Tally, Throw, radiances};
use crate::math::{GOLDEN, Sampler};
use crate::mode::Mode;
use crate::scene::{Camera, Scene};

/// Light paths of a round at most: large pictures have fewer than pixels, so that what they bring can be kept until it is added,
/// in some 60 MB (200 MB of wavelengths).
const MOST_LIGHT_PATHS: u32 = 1 << 20;
/// Pictures that light paths bring little to have up to 2^this times fewer.
const FEWEST_LIGHT_PATHS_LOG2: u32 = 4;
/// Light paths that are tried.
const MOST_LIGHT_TRIALS: u32 = 1 << 13;
/// What it costs to follow a light path by one ray.
const LIGHT_PATH_COST: f64 = 1.3;
/// One group of so many is tried.
const GROUPS_PER_TRIAL: u32 = 256;
/// No picture needs more trials; with fewer, only light paths are judged, which tell of themselves.
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
    let mut tactics = Tactics { limits: plan.limits, shares, fans_out: shares, draws_log2: 0, throw: None };
    let pixels = width.saturating_mul(height).max(1);
    let mut throw = if shares { Throw::new(scene, camera, pixels.min(MOST_LIGHT_PATHS)) } else { None };
    let groups = groups(camera.size);
    if !shares || groups.is_empty() {
        if let Some(throw) = &mut throw {
            throw.send_photons(scene);
        }
        return Tactics { throw, ..tactics };
    }

    let run = |tactics: &Tactics| -> Vec<Trial> {
        groups.par_iter().with_max_len(1).map(|group| trial(scene, camera, plan, tactics, group)).collect()
    };
    tactics.throw = throw;
    let base = run(&tactics);
    let weights = weights(&base);
    let mut camera = Cost::of_trials(&base, &weights);
    let mut light = Cost::default();

    // Follow light paths where they find light sooner, and as many as serve best.
    if let Some(throw) = &mut tactics.throw {
        let [light_paths, finds] = Cost::of_light_paths(scene, plan, throw, (&groups, &weights), pixels);
        let finds = Some(finds).filter(|_| !throw.is_needed());
        match camera.best_with(&light_paths, finds.as_ref()) {
            Some((log2, cost)) => {
                throw.send_photons(scene);
                throw.count = (throw.count >> log2).max(1);
                light = cost;
                camera = Cost::of_trials(&run(&tactics), &weights);
            }
            None => tactics.throw = None,
        }
    }
    if groups.len() < FEWEST_TRIALS as usize {
        return tactics;
    }

    // Draw as many lights, share finds and fan out, as it pays.
    let mut best = camera.with(&light).product();
    let cost = |tactics: &Tactics| Cost::of_trials(&run(tactics), &weights).with(&light).product();
    for draws_log2 in 1..=MOST_DRAWS_LOG2 {
        tactics.draws_log2 = draws_log2;
        let cost = cost(&tactics);
        if cost >= best * WORTHWHILE {
            tactics.draws_log2 -= 1;
            break;
        }
        best = cost;
    }
    tactics.shares = false;
    let unshared = cost(&tactics);
    tactics.shares = unshared >= best * WORTHWHILE;
    if !tactics.shares {
        best = unshared;
    }
    if base.iter().any(|trial| trial.tally.fans > 0) {
        tactics.fans_out = false;
        tactics.fans_out = cost(&tactics) >= best * WORTHWHILE;
    }
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
    // In the dark all count alike.
    means.iter().map(|mean| if whole > 0.0 { 1.0 / (mean + DARK * whole) } else { 1.0 }).collect()
}

/// What some trials cost.
#[derive(Clone, Copy, Default)]
struct Cost {
    /// Variance, absolute and in relation to brightness.
    absolute: f64,
    relative: f64,
    /// In rays that are followed.
    work: f64,
}

impl Cost {
    fn of_trials(trials: &[Trial], weights: &[f32]) -> Self {
        let mut cost = Self::default();
        for (trial, &weight) in trials.iter().zip(weights) {
            for [a, b] in &trial.pixels {
                cost.add_error((*a - *b).length_squared().min((WORST / weight).powi(2)), weight);
            }
            let Tally { rays, shadow_rays, draws, .. } = trial.tally;
            cost.work +=
                rays as f64 + DRAW_COST * draws as f64 + LOOK_COST * (shadow_rays - draws.min(shadow_rays)) as f64;
        }
        cost
    }

    /// Of all light paths that the same pixels and samples have a share of, by some of them; and of camera paths in their place:
    /// trials cannot tell, which hardly ever find what light paths find.
    fn of_light_paths<M: Mode>(
        scene: &Scene<M>,
        plan: &Plan,
        throw: &Throw,
        (groups, weights): (&[ArrayVec<[u32; 2], GROUP>], &[f32]),
        pixels: u32,
    ) -> [Self; 2] {
        let weight_at = |at: Vec2| {
            let distance2 = |group: &[[u32; 2]]| Vec2::from(group[0].map(|x| x as f32)).distance_squared(at);
            let nearest = groups.iter().zip(weights).min_by(|a, b| distance2(a.0).total_cmp(&distance2(b.0)));
            nearest.map_or(1.0, |(_, &weight)| weight)
        };
        let (mut cost, mut finds, mut tally) = (Self::default(), Self::default(), Tally::default());
        let count = throw.count.min(MOST_LIGHT_TRIALS);
        for first in (0..count).step_by(BATCH) {
            let numbers = first..(first + BATCH as u32).min(count);
            throw.follow(scene, &plan.limits, (0, numbers, plan.seed), &mut tally, |landing| {
                let error2 = M::to_rgb(landing.radiance, &landing.waves, &scene.stage.sensor).length_squared();
                let weight = weight_at(landing.at);
                cost.add_error(error2, weight);
                // So many times as rare, and as much brighter.
                if landing.share.is_finite() {
                    finds.add_error(error2 * (1.0 + landing.share).powi(2) / landing.share, weight);
                }
            });
        }
        cost.work = LIGHT_PATH_COST * (tally.rays + tally.shadow_rays) as f64;
        // Of a round to those of so many samples, of the picture to the pixels that are tried.
        let tried: usize = groups.iter().map(|group| group.len()).sum();
        let share = tried as f64 / f64::from(pixels) * f64::from(2 * HALF) * f64::from(throw.count) / f64::from(count);
        [cost, finds].map(|cost| Self {
            absolute: cost.absolute * share,
            relative: cost.relative * share,
            work: cost.work * share,
        })
    }

    fn add_error(&mut self, error2: f32, weight: f32) {
        self.absolute += f64::from(error2);
        self.relative += f64::from(error2 * weight * weight);
    }

    /// Of 2^`log2` times fewer light paths, each of which brings as many times more.
    fn of_fewer(&self, log2: u32) -> Self {
        let times = f64::from(1u32 << log2);
        Self { absolute: self.absolute * times, relative: self.relative * times, work: self.work / times }
    }

    /// By which power of two fewer `light_paths` serve best besides this, and what they cost; `None` where the `finds` of
    /// camera paths in their place, if there are any, serve as well.
    fn best_with(&self, light_paths: &Self, finds: Option<&Self>) -> Option<(u32, Self)> {
        let fewer = (0..=FEWEST_LIGHT_PATHS_LOG2).map(|log2| (log2, light_paths.of_fewer(log2)));
        let product = |light: &Self| self.with(light).product();
        let best = fewer.min_by(|a, b| product(&a.1).total_cmp(&product(&b.1)));
        best.filter(|(_, light)| finds.is_none_or(|finds| product(light) < product(finds) * WORTHWHILE))
    }

    /// Of both together.
    fn with(&self, other: &Self) -> Self {
        Self {
            absolute: self.absolute + other.absolute,
            relative: self.relative + other.relative,
            work: self.work + other.work,
        }
    }

    /// Variance times work: the variance is the geometric mean of the absolute one and of that in relation to brightness.
    fn product(&self) -> f64 {
        (self.absolute * self.relative).sqrt() * self.work
    }
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
    fn light_paths_are_followed_where_they_pay_and_as_many_as_do() {
        let cost = |variance: f64, work: f64| Cost { absolute: variance, relative: variance, work };
        let (camera, useless) = (cost(1.0, 1000.0), cost(0.0, 300.0));
        assert!(camera.best_with(&useless, Some(&cost(1e-3, 0.0))).is_none());
        assert!(camera.best_with(&useless, None).is_some());
        // Rare finds are not to be had by luck.
        let rare = cost(1e3, 0.0);
        for (variance, fewer) in [(1.0, 0), (0.3, 0), (0.05, 1), (0.01, 2), (1e-6, FEWEST_LIGHT_PATHS_LOG2)] {
            let best = camera.best_with(&cost(variance, 300.0), Some(&rare)).map(|(log2, _)| log2);
            assert_eq!(best, Some(fewer), "{variance}");
        }
    }

    #[test]
    fn one_wild_pixel_does_not_decide_for_all() {
        let trials = |noise: f32| -> Vec<Trial> {
            let pixels = |_| [Vec3::ONE, Vec3::new(1.0 + noise, 1.0, 1.0)];
            let tally = Tally { rays: 100, ..Tally::default() };
            (0..MOST_TRIALS).map(|_| Trial { pixels: (0..GROUP).map(pixels).collect(), tally }).collect()
        };
        let cost = |trials: &[Trial]| Cost::of_trials(trials, &weights(trials)).product();
        let (mut calm, noisy) = (trials(0.2), trials(0.4));
        assert!(cost(&noisy) > 3.0 * cost(&calm));
        calm[7].pixels[3][0] = Vec3::splat(100.0);
        assert!(cost(&noisy) > 1.5 * cost(&calm));
    }
}
