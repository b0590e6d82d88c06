//! A group of paths of neighbouring pixels.
//!
//! They go on side by side, one surface at a time, so that their rays can be traced together, and share what they find
//! (`post.rs`).

use arrayvec::ArrayVec;

use super::direct::MOST_DRAWS_LOG2;
use super::path::{Arrival, MOST_OTHERS, Path};
use super::post::{Kept, Post, Viewers, hand_out};
use super::throw::Find;
use super::{Tactics, Tally};
use crate::embree::{BATCH, Hits, Ray};
use crate::math::set_bits;
use crate::mode::{Lanes, Mode};
use crate::scene::Scene;

/// Largest number of paths that go together.
pub const GROUP: usize = BATCH;
/// Sources of light that one surface draws at most.
const DRAWS: usize = 1 << MOST_DRAWS_LOG2;
/// Paths split off from a group that may wait for their turn: a photographic lens has many surfaces, and four groups would
/// not do. While there is no room for more, chance chooses.
const MOST_SPLIT_OFF: usize = 16 * GROUP;

/// Light that counts unless something stands in its way, of each draw and path.
struct Doubts<L> {
    shadows: [[Ray; GROUP]; DRAWS],
    finds: [[Find<L>; GROUP]; DRAWS],
    /// Of each draw, the paths that have such light.
    lanes: [u8; DRAWS],
}

/// What smooth surfaces mirror of what goes through, and what goes on from matte ones in other directions, by the number of the
/// path that is followed first.
type SplitOff<M> = ArrayVec<(usize, Path<M>), MOST_SPLIT_OFF>;

/// Estimates the radiance of a group of paths, into [`Path::radiance`]. They must have the same waves; how many they are
/// changes the noise, not the mean.
pub fn radiances<M: Mode>(
    scene: &Scene<M>,
    tactics: &Tactics,
    paths: &mut ArrayVec<Path<M>, GROUP>,
    tally: &mut Tally,
) {
    let mut split_off = SplitOff::new();
    radiances_of_group(scene, tactics, paths, &mut split_off, tally);
    while !split_off.is_empty() {
        let rest = split_off.len().saturating_sub(GROUP);
        let (of, mut group): (ArrayVec<usize, GROUP>, ArrayVec<Path<M>, GROUP>) = split_off.drain(rest..).unzip();
        radiances_of_group(scene, tactics, &mut group, &mut split_off, tally);
        // What split off from these belongs to the same paths.
        for (number, _) in &mut split_off[rest..] {
            *number = of[*number];
        }
        for (of, path) in of.into_iter().zip(&group) {
            paths[of].radiance += path.radiance;
        }
    }
}

/// As [`radiances`], but for what is followed apart, which `split_off` gets.
fn radiances_of_group<M: Mode>(
    scene: &Scene<M>,
    tactics: &Tactics,
    paths: &mut ArrayVec<Path<M>, GROUP>,
    split_off: &mut SplitOff<M>,
    tally: &mut Tally,
) {
    let mut posts: [Post<M>; GROUP] = std::array::from_fn(|_| Post::new(tactics.shares));
    walk(scene, tactics, paths, &mut posts, split_off, tally);

    let mut gathered = [M::Light::ZERO; GROUP];
    let viewers = Viewers::new(&posts);
    for (finder, path) in paths.iter().enumerate() {
        hand_out(scene, (&posts, &viewers), finder, path, &mut gathered, tally);
    }
    for ((path, post), gathered) in paths.iter_mut().zip(&posts).zip(gathered) {
        path.radiance = post.own(path) + gathered;
    }
}

/// Takes paths on until all have ended.
fn walk<'s, M: Mode>(
    scene: &'s Scene<M>,
    tactics: &'s Tactics,
    paths: &mut ArrayVec<Path<M>, GROUP>,
    posts: &mut [Post<'s, M>; GROUP],
    split_off: &mut SplitOff<M>,
    tally: &mut Tally,
) {
    let (shadows, finds) = ([[Ray::NONE; GROUP]; DRAWS], [[Find::NOTHING; GROUP]; DRAWS]);
    let mut doubts = Doubts { shadows, finds, lanes: [0; DRAWS] };
    let mut rays = [Ray::NONE; GROUP];
    let mut hits = Hits::default();
    let mut active = 0u8;
    for (i, path) in paths.iter().enumerate() {
        rays[i] = path.ray;
        active |= 1 << i;
    }
    while active != 0 {
        // Move every path to its next surface and on.
        tally.rays += u64::from(active.count_ones());
        scene.stage.intersect_batch(&rays, active, &mut hits);
        for i in set_bits(active) {
            let (path, post) = (&mut paths[i], &mut posts[i]);
            let goes_on = match path.arrive(scene, scene.surface(&hits, i), tactics) {
                Arrival::End => false,
                Arrival::Through => true,
                Arrival::At(surface, material, beyond) => {
                    let mut vertex = path.vertex(scene, (surface, material), beyond);
                    path.prepare(&mut vertex, tactics);
                    let kept = post.judge(&vertex, path);
                    if !split_off.is_full() {
                        split_off.extend(path.split(&mut vertex, tactics).map(|mirrored| (i, mirrored)));
                    }
                    for draw in 0..1 << path.draws_log2(tactics) {
                        let direct = path.direct(scene, (&vertex, kept), draw, tactics, tally);
                        match direct.shadow {
                            Some(shadow) => {
                                let draw = draw as usize;
                                (doubts.shadows[draw][i], doubts.finds[draw][i]) = (shadow, post.incoming(&direct));
                                doubts.lanes[draw] |= 1 << i;
                            }
                            None => {
                                let find = post.incoming(&direct);
                                post.add(find, path);
                            }
                        }
                    }
                    if path.fans_out(&vertex, tactics) && split_off.remaining_capacity() >= MOST_OTHERS {
                        tally.fans += 1;
                        split_off.extend(path.fan_out(&vertex, tactics).into_iter().map(|other| (i, other)));
                        if kept == Kept::X {
                            post.share_with_others(path);
                        }
                    }
                    let goes_on = path.send_on((&vertex, kept), tactics);
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
            for i in set_bits(lanes & !hidden) {
                posts[i].add(doubts.finds[draw][i], &mut paths[i]);
            }
        }
    }
}
