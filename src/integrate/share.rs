//! A group of paths of neighbouring pixels.
//!
//! They go on side by side, one surface at a time, so that their rays can be traced together, and share what they find
//! (`post.rs`).

use arrayvec::ArrayVec;

use super::direct::MOST_DRAWS_LOG2;
use super::guide::Leaf;
use super::path::{Arrival, Path};
use super::post::{Kept, Post, hand_out};
use super::vertex::Vertex;
use super::{Tactics, Tally};
use crate::embree::{BATCH, Ray};
use crate::mode::{Lanes, Mode};
use crate::scene::Scene;

/// Largest number of paths that go together.
pub const GROUP: usize = BATCH;
/// Sources of light that one surface draws at most.
const DRAWS: usize = 1 << MOST_DRAWS_LOG2;
/// Mirrored paths of a group that may wait for their turn: a photographic lens has many surfaces, and four groups would not do.
/// While there is no room for more, chance chooses.
const MIRRORED: usize = 16 * GROUP;

/// Light that counts unless something stands in its way, of each draw and path.
struct Doubts<L> {
    shadows: [[Ray; GROUP]; DRAWS],
    lights: [[L; GROUP]; DRAWS],
    /// Of each draw, the paths that have such light.
    lanes: [u8; DRAWS],
}

/// What is to be followed besides the paths of a group.
struct Besides<M: Mode> {
    /// Paths whose way on from x is one of several to be tried, as they were before they took it, by their numbers.
    forks: ArrayVec<(usize, Path<M>), GROUP>,
    /// What smooth surfaces mirror of what goes through, by the number of the path that goes through.
    mirrored: ArrayVec<(usize, Path<M>), MIRRORED>,
}

impl<M: Mode> Besides<M> {
    fn new() -> Self {
        Self { forks: ArrayVec::new(), mirrored: ArrayVec::new() }
    }
}

/// Estimates the radiance of a group of paths, into [`Path::radiance`]. They must have the same waves; how many they are
/// changes the noise, not the mean.
pub fn radiances<M: Mode>(
    scene: &Scene<M>,
    tactics: &Tactics,
    paths: &mut ArrayVec<Path<M>, GROUP>,
    tally: &mut Tally,
) {
    let mut besides = Besides::new();
    radiances_of_group(scene, tactics, paths, &mut besides, tally);
    while !besides.mirrored.is_empty() {
        let rest = besides.mirrored.len().saturating_sub(GROUP);
        let (of, mut group): (ArrayVec<usize, GROUP>, ArrayVec<Path<M>, GROUP>) =
            besides.mirrored.drain(rest..).unzip();
        radiances_of_group(scene, tactics, &mut group, &mut besides, tally);
        // What split off from these belongs to the same paths.
        for (number, _) in &mut besides.mirrored[rest..] {
            *number = of[*number];
        }
        for (of, path) in of.into_iter().zip(&group) {
            paths[of].radiance += path.radiance;
        }
    }
}

/// As [`radiances`], but for what is mirrored apart, which `besides` gets.
fn radiances_of_group<M: Mode>(
    scene: &Scene<M>,
    tactics: &Tactics,
    paths: &mut ArrayVec<Path<M>, GROUP>,
    besides: &mut Besides<M>,
    tally: &mut Tally,
) {
    let mut posts: [Post<M>; GROUP] = std::array::from_fn(|_| Post::new(tactics.shares));
    walk(scene, tactics, paths, &mut posts, besides, tally);

    let mut gathered = [M::Light::ZERO; GROUP];
    for (finder, path) in paths.iter().enumerate() {
        hand_out(scene, &posts, finder, path, &mut gathered, tally);
    }
    for (i, fork) in besides.forks.drain(..) {
        if let Some((x, leaf)) = posts[i].x.as_ref().and_then(|x| Some((x, x.fork()?))) {
            gathered[i] += other_ways(scene, tactics, &fork, (x, leaf), tally);
        }
    }
    for ((path, post), gathered) in paths.iter_mut().zip(&posts).zip(gathered) {
        path.radiance = post.own(path) + gathered;
    }
}

/// Light that comes to x by other ways than the one that its path took from there, as far as nobody shares it.
fn other_ways<M: Mode>(
    scene: &Scene<M>,
    tactics: &Tactics,
    fork: &Path<M>,
    (x, leaf): (&Vertex<M>, &Leaf),
    tally: &mut Tally,
) -> M::Light {
    let mut sum = M::Light::ZERO;
    let mut ways = (0..leaf.ways).filter_map(|way| fork.way(way, (x, leaf), tactics)).peekable();
    while ways.peek().is_some() {
        let mut group: ArrayVec<Path<M>, GROUP> = ways.by_ref().take(GROUP).collect();
        let mut posts: [Post<M>; GROUP] = std::array::from_fn(|_| Post::after_x(fork));
        walk(scene, tactics, &mut group, &mut posts, &mut Besides::new(), tally);
        sum = group.iter().fold(sum, |sum, way| sum + way.radiance);
    }
    sum
}

/// Takes paths on until all have ended.
fn walk<'s, M: Mode>(
    scene: &'s Scene<M>,
    tactics: &'s Tactics,
    paths: &mut ArrayVec<Path<M>, GROUP>,
    posts: &mut [Post<'s, M>; GROUP],
    besides: &mut Besides<M>,
    tally: &mut Tally,
) {
    let (shadows, lights) = ([[Ray::NONE; GROUP]; DRAWS], [[M::Light::ZERO; GROUP]; DRAWS]);
    let mut doubts = Doubts { shadows, lights, lanes: [0; DRAWS] };
    let mut rays = [Ray::NONE; GROUP];
    let mut active = 0u8;
    for (i, path) in paths.iter().enumerate() {
        rays[i] = path.ray;
        active |= 1 << i;
    }
    while active != 0 {
        // Move every path to its next surface and on.
        tally.rays += u64::from(active.count_ones());
        let hits = scene.stage.intersect_batch(&rays, active);
        for (i, (path, post)) in paths.iter_mut().zip(&mut *posts).enumerate() {
            if active >> i & 1 == 0 {
                continue;
            }
            let goes_on = match path.arrive(scene, scene.surface(&hits, i), &tactics.limits) {
                Arrival::End => false,
                Arrival::Through => true,
                Arrival::At(surface, material, beyond) => {
                    let mut vertex = path.vertex(scene, tactics.guide.as_ref(), (surface, material), beyond);
                    let kept = post.judge(&vertex, path);
                    if post.has_met(kept) {
                        active &= !(1 << i);
                        continue;
                    }
                    if !besides.mirrored.is_full() {
                        besides.mirrored.extend(path.split(&mut vertex, tactics).map(|mirrored| (i, mirrored)));
                    }
                    for draw in 0..1 << path.draws_log2(tactics) {
                        let direct = path.direct(scene, (&vertex, kept), draw, tactics, tally);
                        match direct.shadow {
                            Some(shadow) => {
                                let draw = draw as usize;
                                (doubts.shadows[draw][i], doubts.lights[draw][i]) = (shadow, post.incoming(&direct));
                                doubts.lanes[draw] |= 1 << i;
                            }
                            None => {
                                let light = post.incoming(&direct);
                                post.add(light, path);
                            }
                        }
                    }
                    let fork = if kept == Kept::X { vertex.fork() } else { None };
                    if fork.is_some() {
                        besides.forks.push((i, path.clone()));
                    }
                    let goes_on = path.send_on((&vertex, kept), tactics);
                    if let (true, Some(leaf)) = (goes_on, fork) {
                        path.thin((&vertex, leaf));
                    }
                    post.keep(kept, vertex, path);
                    goes_on
                }
            };
            rays[i] = path.ray;
            if !goes_on {
                active &= !(1 << i);
            }
        }

        // Add the light that nothing stands in the way of.
        for draw in 0..DRAWS {
            let lanes = std::mem::take(&mut doubts.lanes[draw]);
            let hidden = scene.stage.occluded_batch(&doubts.shadows[draw], lanes);
            for (i, (path, post)) in paths.iter_mut().zip(&mut *posts).enumerate() {
                if (lanes & !hidden) >> i & 1 == 1 {
                    post.add(doubts.lights[draw][i], path);
                }
            }
        }
    }
}
