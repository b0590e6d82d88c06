//! Where to look for light that mirrors and lenses throw onto what is seen in mirrors and through lenses, where light paths
//! (`throw.rs`) cannot bring it: a scattered ray finds the way to it by luck alone. What it lights is as hard to find again. So
//! matte surfaces send some of their rays to where photons came from.
//!
//! A tree over the places where photons landed; each leaf keeps the points that threw them, with a cone around each. What it
//! says is only a density to sample with, known exactly for every direction: pictures keep their means, whatever the photons
//! did. After Jensen 1995, "Importance Driven Path Tracing using the Photon Map".

use std::f32::consts::FRAC_1_PI;

use glam::{Mat3, Vec3};
use rayon::prelude::*;

use super::photons::{self, Photon};
use crate::math::warp::{cauchy_pdf, square_to_cauchy};
use crate::math::{Frame, extent};
use crate::mode::Mode;
use crate::scene::{Aim, Scene};

/// Cones of a leaf.
const CONES: usize = 64;
/// Narrowest cone, as 1 - cos of its half angle: 0.8 degrees.
const NARROW: f32 = 1e-4;
/// Below so many photons there is nothing worth looking for.
const FEW: usize = 64;
/// Photons that a leaf is made of, at most.
const ENOUGH: usize = 3 * CONES;
/// The chance to follow photons where nothing but thrown light arrives.
const MOST: f32 = 0.8;
/// Thrown light counts as much as these shares of the light that comes straight from lamps, and of that from other surfaces
/// that they light: it is harder to find.
const DIRECT_SHARE: f32 = 0.1;
const INDIRECT_SHARE: f32 = 0.3;
/// Below this chance a leaf is not worth asking.
const WORTHWHILE: f32 = 0.05;
/// The cone of a point reaches to so many neighbours.
const NEIGHBOUR: usize = 3;

/// The photons of a scene, sorted by where they landed.
pub(super) struct Guide {
    nodes: Vec<Node>,
    /// `None` where asking is not worth it.
    leaves: Vec<Option<Leaf>>,
}

#[derive(Clone, Copy)]
enum Node {
    /// Splits space at a coordinate of an axis: what lies below goes to the next node, the rest to `above`.
    Split {
        axis: u8,
        at: f32,
        above: u32,
    },
    Leaf(u32),
}

/// Directions to sample, the same for a small region of space.
pub(super) struct Leaf {
    /// Box that the photons landed in, a little wider.
    low: Vec3,
    high: Vec3,
    /// The chance to sample these instead of the surface.
    pub chance: f32,
    /// How the points that throw light move with the point that they throw it to.
    drift: Mat3,
    /// Points that threw light, by coordinate, moved to where they would be for the origin; and the squared radius of what
    /// each stands for.
    points: [[f32; CONES]; 3],
    radius2: [f32; CONES],
}

impl Guide {
    /// Sends `count` photons into the scene; `None` where mirrors and lenses throw next to no light.
    pub fn new<M: Mode>(scene: &Scene<M>, aim: &Aim, count: u32) -> Option<Self> {
        let photons = photons::trace(scene, aim, count);
        (photons.len() >= FEW).then(|| Self::of(photons))
    }

    fn of(photons: Vec<Photon>) -> Self {
        let (mut nodes, mut crowds) = (Vec::new(), Vec::new());
        split(photons, &mut nodes, &mut crowds);
        let leaf = |photons: Vec<Photon>| Some(Leaf::new(&photons)).filter(|leaf| leaf.chance >= WORTHWHILE);
        Self { nodes, leaves: crowds.into_par_iter().map(leaf).collect() }
    }

    /// What is known about light that is thrown to a point.
    #[inline(never)]
    pub(super) fn at(&self, position: Vec3) -> Option<&Leaf> {
        let mut node = 0;
        loop {
            match *self.nodes.get(node)? {
                Node::Split { axis, at, above } => {
                    node = if position[axis as usize] < at { node + 1 } else { above as usize };
                }
                Node::Leaf(leaf) => {
                    let leaf = self.leaves.get(leaf as usize)?.as_ref()?;
                    let inside = position.cmpge(leaf.low).all() && position.cmple(leaf.high).all();
                    return inside.then_some(leaf);
                }
            }
        }
    }
}

/// Adds the nodes over some photons, and to `crowds` what each of their leaves is made of.
fn split(photons: Vec<Photon>, nodes: &mut Vec<Node>, crowds: &mut Vec<Vec<Photon>>) {
    let (low, high) = extent(photons.iter().map(|photon| photon.position));
    // Photons that a rounding error separates cannot be split.
    if photons.len() <= ENOUGH || (high - low).max_element() <= 1e-5 * high.abs().max(low.abs()).max_element() {
        nodes.push(Node::Leaf(crowds.len() as u32));
        crowds.push(photons);
        return;
    }
    let axis = (high - low).max_position();
    let at = 0.5 * (low[axis] + high[axis]);
    let (below, above): (Vec<Photon>, Vec<Photon>) = photons.into_iter().partition(|photon| photon.position[axis] < at);
    let node = nodes.len();
    nodes.push(Node::Leaf(0));
    split(below, nodes, crowds);
    nodes[node] = Node::Split { axis: axis as u8, at, above: nodes.len() as u32 };
    split(above, nodes, crowds);
}

impl Leaf {
    fn new(photons: &[Photon]) -> Self {
        let (low, high) = extent(photons.iter().map(|photon| photon.position));
        let count = photons.len() as f32;
        let power: f32 = photons.iter().map(|photon| photon.power).sum();
        let easy = photons.iter().map(|p| DIRECT_SHARE * p.direct + INDIRECT_SHARE * p.indirect).sum::<f32>() / count;

        // Draw as many points as there are cones, by their power.
        let drift = drift(photons);
        let mut points = [Vec3::ZERO; CONES];
        let (mut next, mut sum) = (0, photons[0].power);
        for (i, point) in points.iter_mut().enumerate() {
            let wanted = power * (i as f32 + 0.5) / CONES as f32;
            while sum < wanted && next + 1 < photons.len() {
                next += 1;
                sum += photons[next].power;
            }
            *point = photons[next].thrower - drift * photons[next].position;
        }

        // Widen each to its neighbours.
        let radius2 = points.map(|point| {
            let mut distances2 = points.map(|other| point.distance_squared(other));
            *distances2.select_nth_unstable_by(NEIGHBOUR, f32::total_cmp).1
        });

        let size = high - low;
        let area_m2 = (size.x * size.y).max(size.y * size.z).max(size.z * size.x).max(f32::MIN_POSITIVE);
        let thrown = power / area_m2;
        let chance = (thrown / (thrown + easy)).min(MOST);
        let margin = 0.25 * size + size.max_element() * 0.05;
        let points = [points.map(|p| p.x), points.map(|p| p.y), points.map(|p| p.z)];
        let mut leaf = Self { low: low - margin, high: high + margin, chance, drift, points, radius2 };
        leaf.chance *= leaf.narrowness(photons);
        leaf
    }

    /// How much there is to gain: 0 where a matte surface finds the way to the throwing points as well by itself, near 1
    /// where they are close together.
    fn narrowness(&self, photons: &[Photon]) -> f32 {
        let toward = |photon: &Photon| (photon.thrower - photon.position).try_normalize();
        let pdfs = photons.iter().filter_map(|photon| Some(self.pdf(photon.position, toward(photon)?)));
        let mean_pdf = pdfs.sum::<f32>() / photons.len() as f32;
        (1.0 - FRAC_1_PI / mean_pdf).max(0.0)
    }

    /// A direction from `from`.
    #[inline]
    pub fn sample(&self, from: Vec3, u: [f32; 3]) -> Option<Vec3> {
        let scaled = u[0] * CONES as f32;
        let cone = (scaled as usize).min(CONES - 1);
        let [x, y, z] = &self.points;
        let offset = Vec3::new(x[cone], y[cone], z[cone]) + self.drift * from - from;
        let axis = offset.try_normalize()?;
        let width = width(self.radius2[cone], offset.length_squared());
        Some(Frame::new(axis).to_world(square_to_cauchy([u[1], u[2]], width)))
    }

    /// Density of a direction that is drawn here with the leaf's chance and from the surface otherwise.
    #[inline]
    pub fn mixed(&self, surface_pdf: f32, guided_pdf: f32) -> f32 {
        surface_pdf + self.chance * (guided_pdf - surface_pdf)
    }

    /// Density of [`Leaf::sample`], 1/sr.
    #[inline(never)]
    pub fn pdf(&self, from: Vec3, wi: Vec3) -> f32 {
        let [x, y, z] = &self.points;
        let shift = self.drift * from - from;
        let mut densities = [0.0; CONES];
        for i in 0..CONES {
            let (x, y, z) = (x[i] + shift.x, y[i] + shift.y, z[i] + shift.z);
            let distance2 = x * x + y * y + z * z;
            let along = x * wi.x + y * wi.y + z * wi.z;
            let off_axis = (1.0 - along / distance2.sqrt()).max(0.0);
            densities[i] = cauchy_pdf(off_axis, width(self.radius2[i], distance2));
        }
        densities.iter().sum::<f32>() * (1.0 / CONES as f32)
    }
}

/// Rounds of fitting; each leaves out what lies far from the fit of the round before.
const ROUNDS: u32 = 3;

/// The linear map from where photons landed to where they were thrown that fits them best; zero where none does.
fn drift(photons: &[Photon]) -> Mat3 {
    let mut fit: Option<(Mat3, Vec3, f32)> = None;
    for _ in 0..ROUNDS {
        let near = |photon: &&Photon| match fit {
            Some((drift, offset, limit2)) => {
                (photon.thrower - drift * photon.position - offset).length_squared() <= limit2
            }
            None => true,
        };
        let used: Vec<&Photon> = photons.iter().filter(near).collect();
        let scale = 1.0 / used.len().max(1) as f32;
        let landed = used.iter().map(|p| p.position).sum::<Vec3>() * scale;
        let thrown = used.iter().map(|p| p.thrower).sum::<Vec3>() * scale;
        let (mut spread, mut crossed) = (Mat3::ZERO, Mat3::ZERO);
        for photon in &used {
            let (position, thrower) = (photon.position - landed, photon.thrower - thrown);
            spread += outer(position, position);
            crossed += outer(thrower, position);
        }
        // Across the surface photons do not spread at all: keep what cannot be known at zero.
        let trace = spread.x_axis.x + spread.y_axis.y + spread.z_axis.z;
        if trace <= 0.0 {
            return Mat3::ZERO;
        }
        let drift = crossed * (spread + Mat3::from_diagonal(Vec3::splat(1e-3 * trace))).inverse();
        let offset = thrown - drift * landed;
        let mut misses: Vec<f32> =
            photons.iter().map(|p| (p.thrower - drift * p.position - offset).length_squared()).collect();
        let middle = misses.len() / 2;
        let (_, median, _) = misses.select_nth_unstable_by(middle, f32::total_cmp);
        fit = Some((drift, offset, 4.0 * *median));
    }
    fit.map(|(drift, ..)| drift).filter(Mat3::is_finite).unwrap_or(Mat3::ZERO)
}

/// a b^T.
fn outer(a: Vec3, b: Vec3) -> Mat3 {
    Mat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// 1 - cos of the angle under which a radius is seen.
#[inline]
fn width(radius2: f32, distance2: f32) -> f32 {
    (0.5 * radius2 / distance2).clamp(NARROW, 1.0)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::math::Sampler;
    use crate::math::warp::{UNIFORM_SPHERE_PDF, square_to_sphere};

    /// Photons that a mirror in the plane z = 1 throws onto the plane z = 0, about half as far from the axis as they land.
    fn photons() -> Vec<Photon> {
        let photon = |i| {
            let [x, y, blur_x, blur_y] = Sampler::new(0, i, 0).next_4d();
            let thrower = 0.5 * Vec3::new(x + blur_x - 0.5, y + blur_y - 0.5, 2.0);
            Photon { position: Vec3::new(x, y, 0.0), thrower, power: 1.0, direct: 1.0, indirect: 0.0 }
        };
        (0..256).map(photon).collect()
    }

    fn guide() -> Guide {
        Guide::of(photons())
    }

    #[test]
    fn every_photon_finds_its_leaf_and_none_is_found_elsewhere() {
        let guide = guide();
        assert!(photons().iter().all(|photon| guide.at(photon.position).is_some()));
        assert!(guide.at(Vec3::new(0.5, 0.5, 3.0)).is_none());
    }

    #[test]
    fn leaves_point_to_where_light_comes_from() {
        let (guide, from) = (guide(), Vec3::new(0.3, 0.6, 0.0));
        let leaf = guide.at(from).unwrap();
        let toward = (Vec3::new(0.15, 0.3, 1.0) - from).normalize();
        assert!(leaf.pdf(from, toward) > 10.0 * UNIFORM_SPHERE_PDF, "{}", leaf.pdf(from, toward));
        assert!(leaf.pdf(from, -toward) < UNIFORM_SPHERE_PDF);
    }

    /// Where light comes from everywhere a surface finds it by itself: the guide stays out of its way.
    #[test]
    fn only_narrow_light_is_followed() {
        let from_all_around = |photon: Photon, i| {
            let [x, y, ..] = Sampler::new(0, i, 1).next_4d();
            let toward = square_to_sphere([x, y]);
            let thrower = photon.position + Vec3::new(toward.x, toward.y, toward.z.abs());
            Photon { thrower, direct: 0.0, ..photon }
        };
        let wide: Vec<Photon> = photons().into_iter().zip(0..).map(|(photon, i)| from_all_around(photon, i)).collect();
        let chance = |photons: &[Photon]| Leaf::new(photons).chance;
        assert!(chance(&photons()) > 0.5, "{}", chance(&photons()));
        assert!(chance(&wide) < 0.5 * chance(&photons()), "{}", chance(&wide));
    }

    /// The density integrates to 1, and what it says of a cone is how often samples fall into it.
    #[test]
    fn samples_follow_the_density() {
        let (guide, from) = (guide(), Vec3::new(0.3, 0.6, 0.0));
        let leaf = guide.at(from).unwrap();
        let (mut whole, mut near, mut drawn) = (0.0, 0.0, 0.0);
        let axis = Vec3::new(0.1, -0.2, 1.0).normalize();
        let within = |wi: Vec3| f64::from(u8::from(wi.dot(axis) > 0.9));
        let count = 1 << 16;
        for i in 0..count {
            let [x, y, lobe, _] = Sampler::new(1, i, 7).next_4d();
            let wi = square_to_sphere([x, y]);
            let share = f64::from(leaf.pdf(from, wi) / UNIFORM_SPHERE_PDF) / f64::from(count);
            whole += share;
            near += share * within(wi);
            drawn += within(leaf.sample(from, [lobe, x, y]).unwrap()) / f64::from(count);
        }
        assert!((whole - 1.0).abs() < 0.01, "{whole}");
        assert!((near - drawn).abs() < 0.01, "{near} {drawn}");
    }
}
