//! Bodies in, beside and across each other: which medium is where, and which interfaces are there at all.
//!
//! A dielectric that names a `priority` is a medium. Where bodies of several media overlap, the one of the highest rank takes
//! the place: only its interface is real, and lies between its index and that of the medium around it; what others have there
//! is passed as if it were not. Ranks follow the priority, among equals the order of the file. A ray carries the ranks of all
//! bodies that it is in. Schmidt & Budge 2002, "Simple Nested Dielectrics in Ray Traced Images".
//!
//! Interfaces in the same place are crossed as one, whatever their order among the hits: a liquid that fills its glass exactly
//! has no gap of air around it.

use arrayvec::ArrayVec;
use glam::Vec3;

use super::material::Material;
use super::surface::Surface;
use super::{BuildError, FilmOptions, Scene, Stage};
use crate::document::{self, Base};
use crate::embree::Ray;
use crate::mode::Mode;

/// Bodies around one point that a ray remembers; beyond that it forgets the one of the lowest rank.
const DEPTH: usize = 8;
/// Media in one scene: each pair of them is compiled.
pub(super) const MOST_MEDIA: usize = 64;
/// Interfaces that are closer than this many times the rounding error of a hit lie in the same place.
const TOGETHER: f32 = 4.0;

/// What a ray travels in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interior {
    /// Beer-Lambert absorption, linear RGB per metre.
    pub absorption_per_m: Vec3,
    /// Ranks of the bodies that the ray is in, highest first, then zeros.
    ranks: [u8; DEPTH],
}

/// The media of a scene and their interfaces.
pub(super) struct Nesting<M: Mode> {
    /// Rank of each material; 0: not a medium.
    ranks: Vec<u8>,
    /// Of each rank; the first is for air.
    absorption_per_m: Vec<Vec3>,
    /// Each medium, from the second on, within each of lower rank: 2 in 1, 3 in 1, 3 in 2, 4 in 1, ...
    within: Vec<Material<M>>,
}

impl Interior {
    pub const AIR: Self = Self::of(Vec3::ZERO);

    /// A body that is no medium, in air.
    pub(super) const fn of(absorption_per_m: Vec3) -> Self {
        Self { absorption_per_m, ranks: [0; DEPTH] }
    }

    fn top(&self) -> u8 {
        self.ranks[0]
    }

    fn enter(&mut self, rank: u8) {
        let place = self.ranks.partition_point(|&other| other >= rank);
        if place < DEPTH {
            self.ranks.copy_within(place..DEPTH - 1, place + 1);
            self.ranks[place] = rank;
        }
    }

    fn leave(&mut self, rank: u8) {
        if let Some(place) = self.ranks.iter().position(|&other| other == rank) {
            self.ranks.copy_within(place + 1.., place);
            self.ranks[DEPTH - 1] = 0;
        }
    }
}

impl<M: Mode> Nesting<M> {
    /// `None` where no material is a medium.
    pub fn new(stage: &Stage, options: &FilmOptions) -> Result<Option<Self>, BuildError> {
        let priority = |material: &document::Material| match material.base {
            Base::Dielectric { priority, .. } => priority,
            _ => None,
        };
        let mut media: Vec<&document::Material> = stage.materials.iter().filter(|m| priority(m).is_some()).collect();
        if media.is_empty() {
            return Ok(None);
        }
        if media.len() > MOST_MEDIA {
            return Err(BuildError::Media { count: media.len() });
        }
        media.sort_by_key(|material| priority(material));
        let rank = |material: &document::Material| media.iter().position(|m| std::ptr::eq(*m, material));
        let ranks = stage.materials.iter().map(|m| rank(m).map_or(0, |place| place as u8 + 1)).collect();
        let mut absorption_per_m = vec![Vec3::ZERO];
        let mut within = Vec::new();
        for (place, inner) in media.iter().enumerate() {
            for outer in &media[..place] {
                let Base::Dielectric { index, .. } = &outer.base else { continue };
                within.push(Material::new(inner, index, &stage.sensor, options)?);
            }
            absorption_per_m.push(inner.base.absorption_per_m());
        }
        Ok(Some(Self { ranks, absorption_per_m, within }))
    }

    /// True for the number of a medium.
    pub fn has(&self, material: usize) -> bool {
        self.ranks[material] > 0
    }

    /// The interface of the medium `rank` where it lies in another; both above 0.
    fn interface(&self, rank: u8, around: u8) -> &Material<M> {
        let (row, column) = (usize::from(rank) - 1, usize::from(around) - 1);
        &self.within[row * (row - 1) / 2 + column]
    }

    fn absorption_in(&self, interior: &Interior) -> Vec3 {
        self.absorption_per_m[usize::from(interior.top())]
    }

    /// As [`Scene::meet`].
    #[cold]
    pub fn meet<'s>(
        &'s self,
        scene: &'s Scene<M>,
        ray: &Ray,
        surface: &mut Surface<'s>,
        interior: &Interior,
    ) -> (Option<&'s Material<M>>, Interior) {
        let enters = |surface: &Surface| ray.dir.dot(surface.ng) < 0.0;
        let rank_of = |surface: &Surface| self.ranks[surface.material as usize];
        if rank_of(surface) == 0 {
            let material = scene.material(surface);
            let absorption_per_m = match material.absorption_per_m() {
                Some(inside) if enters(surface) => inside,
                Some(_) => self.absorption_in(interior),
                None => interior.absorption_per_m,
            };
            return (Some(material), Interior { absorption_per_m, ..*interior });
        }

        // Cross everything that lies here at once; who leaves a body was in it, whatever the list says.
        let here = scene.stage.together(ray, *surface, TOGETHER);
        let (mut before, mut beyond) = (*interior, *interior);
        for rank in here.iter().filter(|surface| enters(surface)).map(rank_of).filter(|&rank| rank > 0) {
            beyond.enter(rank);
        }
        for rank in here.iter().filter(|surface| !enters(surface)).map(rank_of).filter(|&rank| rank > 0) {
            if !before.ranks.contains(&rank) {
                before.enter(rank);
            }
            beyond.leave(rank);
        }
        beyond.absorption_per_m = self.absorption_in(&beyond);

        // The higher of the two media has the interface.
        let [low, high] =
            if before.top() < beyond.top() { [before, beyond] } else { [beyond, before] }.map(|i| i.top());
        let Some(counts) = here.iter().find(|surface| rank_of(surface) == high).filter(|_| low < high) else {
            *surface = here[0];
            return (None, beyond);
        };
        *surface = *counts;
        let material = if low == 0 { scene.material(surface) } else { self.interface(high, low) };
        (Some(material), beyond)
    }

    /// The bodies around a point: on the way out, each is left once more often than entered.
    pub fn around(&self, stage: &Stage, point: Vec3) -> Interior {
        // A ray may meet an edge twice: of three, two agree.
        let ways = [Vec3::new(0.36, 0.85, 0.39), Vec3::new(-0.67, 0.23, 0.71), Vec3::new(0.19, -0.41, -0.89)];
        let [one, other, third] = ways.map(|way| {
            let mut counts = vec![0i32; self.absorption_per_m.len()];
            stage.each_surface(&Ray::new(point, way), |surface| {
                let leaves = way.dot(surface.ng) > 0.0;
                counts[usize::from(self.ranks[surface.material as usize])] += if leaves { 1 } else { -1 };
            });
            counts
        });
        let mut interior = Interior::AIR;
        for (rank, ((&one, &other), &third)) in one.iter().zip(&other).zip(&third).enumerate().skip(1) {
            let mut votes = [one, other, third];
            votes.sort_unstable();
            (0..votes[1]).for_each(|_| interior.enter(rank as u8));
        }
        interior.absorption_per_m = self.absorption_in(&interior);
        interior
    }
}

/// Surfaces in the same place.
pub(super) type Together<'s> = ArrayVec<Surface<'s>, DEPTH>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_highest_rank_is_first_and_bodies_count_one_by_one() {
        let mut interior = Interior::AIR;
        for rank in [2, 5, 2, 3] {
            interior.enter(rank);
        }
        assert_eq!(interior.ranks, [5, 3, 2, 2, 0, 0, 0, 0]);
        interior.leave(2);
        interior.leave(7);
        assert_eq!(interior.ranks, [5, 3, 2, 0, 0, 0, 0, 0]);
        (0..9).for_each(|_| interior.enter(4));
        assert_eq!(interior.ranks, [5, 4, 4, 4, 4, 4, 4, 4]);
    }
}
