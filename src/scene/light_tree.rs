//! A tree over the lights that have a place: from any point one is drawn about as often as it matters there.
//!
//! Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting", with the bounds of
//! pbrt-v4 (Pharr et al. 2023, section 12.6.3); a lamp made of many triangles is one light for those who are far from it.

use std::ops::Range;

use glam::Vec3;

use super::beam::Beam;

/// Places where a node may be cut, along each axis.
const BINS: usize = 12;
/// A flat lamp is not taken apart from further away than this many of its radii.
const FAR_RADII: f32 = 4.0;
/// Lights count as one flat lamp if their normals differ by less than this cosine.
const FLAT_COS: f32 = 0.9999;
/// Keeps the irradiance from a light that one stands on finite.
const SMALLEST_M2: f32 = 1e-20;
/// Of the cosine by which light falls off beside a normal: spots do not follow it.
const SMALLEST_COS: f32 = 0.01;
/// Rounding that must not make a light dark that shines just so.
const COS_SLACK: f32 = 1e-4;

/// What a light takes in the tree, with two nodes, and while that is made.
pub const BYTES_PER_LIGHT: usize = 2 * size_of::<Node>()
    + size_of::<(u32, f64)>()
    + size_of::<u32>()
    + size_of::<(u32, Beam)>()
    + size_of::<Option<Beam>>();

/// Lights with a place, and how one of them is chosen.
pub struct LightTree {
    /// The root first; the first half of a node follows it.
    nodes: Vec<Node>,
    /// Emitters in the tree's order, each with the intensity of all before it; a last entry ends the sum.
    order: Vec<(u32, f64)>,
    /// For each emitter its place in the order; `u32::MAX` for what is not in the tree.
    place: Vec<u32>,
}

struct Node {
    center: Vec3,
    /// Of the sphere around its box, squared.
    radius2: f32,
    axis: Vec3,
    cos_half_angle: f32,
    sin_half_angle: f32,
    /// No light further than this from the nearest normal.
    cos_spread: f32,
    intensity: f32,
    two_sided: bool,
    /// All lights in one plane that they fill.
    flat: bool,
    /// Part of the order; where its second half begins.
    first: u32,
    middle: u32,
    end: u32,
    /// The node of the second half; 0 in a node that has none.
    second: u32,
}

impl LightTree {
    /// `beams`: one for each emitter that belongs into the tree. Those without intensity are left out.
    pub fn new(beams: &[Option<Beam>]) -> Self {
        let mut lights: Vec<(u32, Beam)> = (0u32..)
            .zip(beams)
            .filter_map(|(index, beam)| {
                beam.filter(|b| b.intensity > 0.0 && b.intensity.is_finite()).map(|b| (index, b))
            })
            .collect();
        let (nodes, order) = (Vec::with_capacity(2 * lights.len()), Vec::with_capacity(lights.len() + 1));
        let mut tree = Self { nodes, order, place: vec![u32::MAX; beams.len()] };
        if !lights.is_empty() {
            let count = lights.len();
            tree.grow(&mut lights, 0..count);
        }
        let mut before = 0.0;
        for (place, (index, beam)) in (0u32..).zip(&lights) {
            tree.place[*index as usize] = place;
            tree.order.push((*index, before));
            before += f64::from(beam.intensity);
        }
        tree.order.push((u32::MAX, before));
        tree
    }

    /// Adds the node of a part of the lights, and all below it. Puts the lights in order.
    fn grow(&mut self, lights: &mut [(u32, Beam)], part: Range<usize>) -> u32 {
        let number = self.nodes.len();
        let own = &mut lights[part.clone()];
        let whole = join(own);
        let filled = own.iter().map(|(_, beam)| beam.diagonal2()).sum::<f32>() > 0.5 * whole.diagonal2();
        self.nodes.push(Node {
            center: whole.center(),
            radius2: 0.25 * whole.diagonal2(),
            axis: whole.axis,
            cos_half_angle: whole.half_angle.cos(),
            sin_half_angle: whole.half_angle.sin(),
            cos_spread: whole.spread.cos(),
            // In f64: the shares of a million lamps must add up.
            intensity: own.iter().map(|(_, beam)| f64::from(beam.intensity)).sum::<f64>() as f32,
            two_sided: whole.two_sided,
            flat: filled && whole.half_angle.cos() > FLAT_COS,
            first: part.start as u32,
            middle: part.end as u32,
            end: part.end as u32,
            second: 0,
        });
        if own.len() > 1 {
            let middle = part.start + split(own, &whole);
            self.grow(lights, part.start..middle);
            let second = self.grow(lights, middle..part.end);
            (self.nodes[number].middle, self.nodes[number].second) = (middle as u32, second);
        }
        number as u32
    }

    /// The greatest irradiance that the lights could cause at a point if they were at the middle of their box, about.
    pub fn irradiance(&self, from: Vec3) -> f32 {
        self.nodes.first().map_or(0.0, |root| root.importance(from))
    }

    /// An emitter and the chance of it, from one number in [0, 1). `None` where several lights are told apart and none shines.
    pub fn sample(&self, from: Vec3, mut u: f32) -> Option<(usize, f32)> {
        let (node, chance) = self.descend(from, |_, first| {
            let is_first = u < first;
            u = if is_first { u / first } else { (u - first) / (1.0 - first) };
            is_first
        })?;
        let own = &self.order[node.first as usize..node.end as usize];
        let target = own[0].1 + f64::from(u) * f64::from(node.intensity);
        let place = own.partition_point(|(_, before)| *before <= target).max(1) - 1;
        let at = node.first as usize + place;
        Some((own[place].0 as usize, chance * self.share(at, node)))
    }

    /// The chance of [`LightTree::sample`] to choose this emitter.
    pub fn probability(&self, from: Vec3, emitter: usize) -> f32 {
        let place = self.place[emitter];
        if place == u32::MAX {
            return 0.0;
        }
        let found = self.descend(from, |node, _| place < node.middle);
        found.map_or(0.0, |(node, chance)| chance * self.share(place as usize, node))
    }

    /// Of a node's intensity what one of its lights has.
    fn share(&self, place: usize, node: &Node) -> f32 {
        if node.end - node.first == 1 {
            return 1.0;
        }
        ((self.order[place + 1].1 - self.order[place].1) / f64::from(node.intensity)) as f32
    }

    /// Goes down from the root to where lights are no longer told apart; `first` gets the node and the chance of its first
    /// half, and tells whether to go there.
    fn descend(&self, from: Vec3, mut first: impl FnMut(&Node, f32) -> bool) -> Option<(&Node, f32)> {
        let mut index = 0;
        let mut node = self.nodes.first()?;
        let mut chance = 1.0;
        while node.second != 0 && !node.is_one(from) {
            let halves = [index + 1, node.second as usize].map(|half| self.nodes[half].importance(from));
            let sum = halves[0] + halves[1];
            if sum == 0.0 {
                return None;
            }
            let share = halves[0] / sum;
            let goes_first = first(node, share);
            (index, chance) = if goes_first {
                (index + 1, chance * share)
            } else {
                (node.second as usize, chance * (halves[1] / sum))
            };
            node = &self.nodes[index];
        }
        Some((node, chance))
    }
}

impl Node {
    /// True where its lights look like one.
    #[inline]
    fn is_one(&self, from: Vec3) -> bool {
        self.flat && from.distance_squared(self.center) > FAR_RADII * FAR_RADII * self.radius2
    }

    /// Bounds the irradiance at a point, as far as the sphere around the box and the cone around the normals tell. Zero only
    /// where none of the lights shines.
    #[inline]
    fn importance(&self, from: Vec3) -> f32 {
        let offset = from - self.center;
        let distance2 = offset.length_squared();
        if distance2 <= self.radius2 {
            return self.intensity / self.radius2.max(SMALLEST_M2);
        }
        let across = offset.dot(self.axis) / distance2.sqrt();
        let cos_axis = if self.two_sided { across.abs() } else { across }.clamp(-1.0, 1.0);

        // Take the cone of normals off the angle, and then the angle under which the sphere is seen.
        let cone = (self.cos_half_angle, self.sin_half_angle);
        let angle = less((cos_axis, (1.0 - cos_axis * cos_axis).sqrt()), cone);
        let sin2 = self.radius2 / distance2;
        let (cos, _) = less(angle, ((1.0 - sin2).sqrt(), sin2.sqrt()));
        if cos <= self.cos_spread - COS_SLACK {
            return 0.0;
        }
        self.intensity * cos.max(SMALLEST_COS) / distance2.max(SMALLEST_M2)
    }
}

/// Cosine and sine of an angle less another; zero is the least.
#[inline]
fn less((cos_a, sin_a): (f32, f32), (cos_b, sin_b): (f32, f32)) -> (f32, f32) {
    if cos_a >= cos_b { (1.0, 0.0) } else { (cos_a * cos_b + sin_a * sin_b, sin_a * cos_b - cos_a * sin_b) }
}

fn join(lights: &[(u32, Beam)]) -> Beam {
    let (_, first) = lights[0];
    lights[1..].iter().fold(first, |whole, (_, beam)| whole.with(beam))
}

/// What all that there are send.
fn joined(a: Option<Beam>, b: Option<Beam>) -> Option<Beam> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.with(&b)),
        _ => a.or(b),
    }
}

/// Puts lights in an order in which a cut makes two cheap halves, and returns how many the first has: of all cuts between
/// bins along an axis the one whose halves cost least, or the middle where the lights are all in one place.
fn split(lights: &mut [(u32, Beam)], whole: &Beam) -> usize {
    let (low, high) = lights.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), (_, beam)| {
        (low.min(beam.center()), high.max(beam.center()))
    });
    let extent = high - low;
    let size = whole.high - whole.low;
    let bin = |beam: &Beam, axis: usize| {
        let at = (beam.center()[axis] - low[axis]) / extent[axis];
        ((at * BINS as f32) as usize).min(BINS - 1)
    };
    let mut best = (f32::INFINITY, 0, 0);
    for axis in (0..3).filter(|&axis| extent[axis] > 0.0) {
        let mut bins = [None::<Beam>; BINS];
        for (_, beam) in lights.iter() {
            let bin = &mut bins[bin(beam, axis)];
            *bin = joined(*bin, Some(*beam));
        }
        // Thin slices of a long box are better than long ones.
        let regular = size.max_element() / size[axis];
        let costs = |order: &mut dyn Iterator<Item = usize>| {
            let mut sum = None::<Beam>;
            let mut costs = [0.0; BINS];
            for i in order {
                sum = joined(sum, bins[i]);
                costs[i] = sum.map_or(0.0, |sum| sum.cost());
            }
            costs
        };
        let (up_to, from) = (costs(&mut (0..BINS)), costs(&mut (0..BINS).rev()));
        for cut in 1..BINS {
            let cost = regular * (up_to[cut - 1] + from[cut]);
            if cost < best.0 {
                best = (cost, axis, cut);
            }
        }
    }
    let (_, axis, cut) = best;
    if cut == 0 {
        return lights.len() / 2;
    }
    lights.sort_unstable_by_key(|(index, beam)| (bin(beam, axis), *index));
    let middle = lights.partition_point(|(_, beam)| bin(beam, axis) < cut);
    if middle == 0 || middle == lights.len() { lights.len() / 2 } else { middle }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Sampler;

    /// Small lamps in a room: matte triangles, spots and bulbs, and some that are dark.
    fn lamps(count: u32) -> Vec<Option<Beam>> {
        let lamp = |k: u32| {
            let mut sampler = Sampler::new(1, k, 0);
            let [x, y, z, size] = sampler.next_4d();
            let [a, b, bright, kind] = sampler.next_4d();
            let low = Vec3::new(x, y, z) * 10.0;
            let axis = crate::math::warp::square_to_sphere([a, b]);
            let around = Beam::all_around(low, low + 0.3 * size, bright);
            match (kind * 4.0) as u32 {
                0 => around,
                1 => Beam { axis, half_angle: 0.0, spread: 0.4, high: low, ..around },
                2 => Beam { axis, half_angle: 0.0, intensity: 0.0, ..around },
                _ => Beam { axis, half_angle: 0.0, ..around },
            }
        };
        (0..count).map(|k| (k % 7 != 3).then(|| lamp(k))).collect()
    }

    fn points() -> impl Iterator<Item = Vec3> {
        (0..40).map(|k| {
            let [x, y, z, _] = Sampler::new(2, k, 0).next_4d();
            Vec3::new(x, y, z) * 14.0 - 2.0
        })
    }

    #[test]
    fn draws_as_often_as_it_says() {
        let beams = lamps(60);
        let tree = LightTree::new(&beams);
        for from in points() {
            let chances: Vec<f32> = (0..60).map(|k| tree.probability(from, k)).collect();
            const DRAWS: usize = 40_000;
            let mut counts = vec![0; 60];
            for i in 0..DRAWS {
                let u = (i as f32 + 0.5) / DRAWS as f32;
                if let Some((index, chance)) = tree.sample(from, u) {
                    counts[index] += 1;
                    assert!((chance - chances[index]).abs() <= 1e-5 * chance, "{index}: {chance} {}", chances[index]);
                }
            }
            for (index, (count, chance)) in counts.iter().zip(&chances).enumerate() {
                let share = *count as f32 / DRAWS as f32;
                assert!((share - chance).abs() < 1e-3, "lamp {index} from {from}: {share} instead of {chance}");
            }
        }
    }

    /// Where a lamp shines its chance is not zero.
    #[test]
    fn no_lamp_is_forgotten() {
        let beams = lamps(300);
        let tree = LightTree::new(&beams);
        let mut chosen = 0;
        for from in points() {
            for (index, beam) in beams.iter().enumerate() {
                let Some(beam) = beam.filter(|beam| beam.intensity > 0.0) else {
                    assert_eq!(tree.probability(from, index), 0.0);
                    continue;
                };
                let cos = (from - beam.center()).normalize().dot(beam.axis);
                let shines = (cos.acos() - beam.half_angle).max(0.0) < beam.spread - 1e-3;
                assert!(!shines || tree.probability(from, index) > 0.0, "lamp {index} from {from}");
                chosen += usize::from(shines);
            }
        }
        assert!(chosen > 1000);
    }

    #[test]
    fn near_lamps_come_first_and_far_panels_are_one_light() {
        let square = |x: f32| {
            let low = Vec3::new(x, 0.0, 0.0);
            Some(Beam { axis: Vec3::Y, half_angle: 0.0, ..Beam::all_around(low, low + Vec3::new(1.0, 0.0, 1.0), 1.0) })
        };
        let row: Vec<_> = (0..4).map(|k| square(k as f32 * 100.0)).collect();
        let tree = LightTree::new(&row);
        assert!(tree.probability(Vec3::new(100.5, 1.0, 0.5), 1) > 0.9);
        assert_eq!(tree.probability(Vec3::new(100.5, -1.0, 0.5), 1), 0.0);

        let panel = LightTree::new(&[square(0.0), square(1.0)]);
        assert_eq!(panel.probability(Vec3::new(0.5, 30.0, 0.5), 0), 0.5);
        assert!(panel.probability(Vec3::new(0.5, 0.1, 0.5), 0) > 0.6);
    }
}
