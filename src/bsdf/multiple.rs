//! Light that bounces between microfacets several times, which the single-scattering lobes lose.
//!
//! Kulla & Conty 2017, "Revisiting Physically Based Shading at Imageworks": a broad lobe gives back exactly what is
//! missing from every direction. Reciprocal, and white stays white.
//!
//! What is missing from a transparent body depends on the colour of its film, because reflected and refracted light meet
//! different obstacles. The tables here hold geometry alone: what is lost is linear in the film's transmittance over angle,
//! so each lane's own loss is a short sum over the terms of its [`Profile`].

use std::f32::consts::{FRAC_1_PI, TAU};

use glam::Vec3;
use rayon::prelude::*;

use super::dielectric::{is_straight, refract};
use super::microfacet::Microfacets;
use crate::document::Distribution;
use crate::film::{Profile, Side, TERMS, term_means, terms};
use crate::math::GOLDEN;
use crate::mode::{Lanes, Mode};

/// Roughnesses that a table holds where an image varies them: squares of even steps.
const ALPHAS: usize = 13;
/// Cosines per roughness ([`Nodes`]): of what is lost, and of what goes straight through, which follows the terms of a profile.
const COSINES: usize = 36;
const COSINES_OF_TERMS: usize = 96;
/// Facets per entry in one direction and in the other, of which symmetry saves one half.
const FACETS: [usize; 2] = [40, 16];
/// Losses below this share of the light are left alone.
const NEGLIGIBLE: f32 = 5e-4;
/// Where they have to be: 5 degrees above the horizon.
const LOW: f32 = 0.087;

/// K numbers over roughness and cosine.
struct Table<const K: usize> {
    /// Row by row, each as long as its nodes; one row where the roughness is constant.
    entries: Vec<[f32; K]>,
    /// 2 Int x mu dmu of each row, exactly as `at` interpolates it.
    means: Vec<[f32; K]>,
    /// Of each row.
    nodes: Vec<Nodes>,
}

impl<const K: usize> Table<K> {
    /// S tables of means over visible facets, for a constant `alpha`, or for all where `None`, over the cosines that `nodes`
    /// gives for a roughness; `facet(microfacets, wo, h)` gives what one facet adds to each.
    fn several<const S: usize>(
        distribution: Distribution,
        alpha: Option<f32>,
        nodes: fn(f32) -> Nodes,
        facet: impl Fn(&Microfacets, Vec3, Vec3) -> [[f32; K]; S] + Sync,
    ) -> [Self; S] {
        let alphas: Vec<f32> = match alpha {
            Some(alpha) => vec![alpha],
            None => (0..ALPHAS).map(|i| (i as f32 / (ALPHAS - 1) as f32).powi(2)).collect(),
        };
        let nodes: Vec<Nodes> = alphas.iter().map(|&alpha| nodes(alpha)).collect();
        let columns = nodes[0].columns;
        let entry = |index: usize| {
            let microfacets = Microfacets { distribution, alpha: alphas[index / columns] };
            // Looking exactly along the surface has no visible facets.
            let mu = nodes[index / columns].cosine(index % columns).max(1e-5);
            let wo = Vec3::new((1.0 - mu * mu).sqrt(), 0.0, mu);
            mean_over_facets(&microfacets, wo, |h| facet(&microfacets, wo, h))
        };
        let count = alphas.len() * columns;
        let entries: Vec<[[f32; K]; S]> = (0..count).into_par_iter().with_min_len(4).map(entry).collect();
        std::array::from_fn(|table| {
            let entries: Vec<[f32; K]> = entries.iter().map(|entry| entry[table]).collect();
            let mean = |(row, nodes): (&[[f32; K]], &Nodes)| {
                let mut sum = [0.0; K];
                for (entry, weight) in row.iter().zip(nodes.weights()) {
                    add(&mut sum, entry, weight);
                }
                sum
            };
            let means = entries.chunks(columns).zip(&nodes).map(mean).collect();
            Self { entries, means, nodes: nodes.clone() }
        })
    }

    /// The entry at a (positive) cosine.
    #[inline]
    fn at(&self, alpha: f32, cos: f32) -> [f32; K] {
        self.between(alpha, |row| {
            let nodes = self.nodes[row];
            let x = nodes.place(cos.clamp(0.0, 1.0));
            let column = (x as usize).min(nodes.columns - 2);
            let start = row * nodes.columns + column;
            mix(&self.entries[start], &self.entries[start + 1], x - column as f32)
        })
    }

    /// Cosine-weighted mean over the hemisphere.
    #[inline]
    fn mean(&self, alpha: f32) -> [f32; K] {
        self.between(alpha, |row| self.means[row])
    }

    #[inline]
    fn between(&self, alpha: f32, row: impl Fn(usize) -> [f32; K]) -> [f32; K] {
        if self.means.len() == 1 {
            return row(0);
        }
        let x = alpha.clamp(0.0, 1.0).sqrt() * (ALPHAS - 1) as f32;
        let low = (x as usize).min(ALPHAS - 2);
        mix(&row(low), &row(low + 1), x - low as f32)
    }
}

#[inline]
fn mix<const K: usize>(a: &[f32; K], b: &[f32; K], t: f32) -> [f32; K] {
    std::array::from_fn(|i| a[i] + t * (b[i] - a[i]))
}

#[inline]
fn add<const K: usize>(sum: &mut [f32; K], entry: &[f32; K], weight: f32) {
    for (sum, value) in sum.iter_mut().zip(entry) {
        *sum += weight * value;
    }
}

/// Where a row has its cosines: even steps of t = sqrt((1 + c) mu / (mu + c)).
#[derive(Clone, Copy)]
struct Nodes {
    c: f32,
    columns: usize,
}

impl Nodes {
    /// For what is lost: c in proportion to the roughness, because losses set in at slopes like those of the facets.
    #[inline]
    fn new(alpha: f32) -> Self {
        Self { c: 4.0 * alpha.max(1e-4), columns: COSINES }
    }

    /// For what follows the terms of a profile: practically t = sqrt(mu).
    fn of_terms(_alpha: f32) -> Self {
        Self { c: 1e4, columns: COSINES_OF_TERMS }
    }

    /// Column of a cosine, with a fraction.
    #[inline]
    fn place(self, mu: f32) -> f32 {
        ((1.0 + self.c) * mu / (mu + self.c)).sqrt() * (self.columns - 1) as f32
    }

    fn cosine(self, column: usize) -> f32 {
        self.cosine_at(column as f32 / (self.columns - 1) as f32)
    }

    #[inline]
    fn cosine_at(self, t: f32) -> f32 {
        (self.c * t * t / (1.0 + self.c - t * t)).min(1.0)
    }

    /// 2 * integral of each node's hat times mu dmu = d(mu^2).
    fn weights(self) -> Vec<f32> {
        const STEPS: usize = 32;
        let mut weights = vec![0.0f64; self.columns];
        for column in 0..self.columns - 1 {
            for step in 0..STEPS {
                let t = |step: f32| self.cosine_at((column as f32 + step / STEPS as f32) / (self.columns - 1) as f32);
                let area = f64::from(t(step as f32 + 1.0)).powi(2) - f64::from(t(step as f32)).powi(2);
                let share = (step as f64 + 0.5) / STEPS as f64;
                weights[column] += (1.0 - share) * area;
                weights[column + 1] += share * area;
            }
        }
        weights.into_iter().map(|weight| weight as f32).collect()
    }
}

/// Mean over the facets visible from `wo` (in the xz plane), by a product rule over one half of the symmetric whole.
fn mean_over_facets<const K: usize, const S: usize>(
    microfacets: &Microfacets,
    wo: Vec3,
    value: impl Fn(Vec3) -> [[f32; K]; S],
) -> [[f32; K]; S] {
    let mut sums = [[0.0; K]; S];
    if microfacets.is_smooth() {
        return value(Vec3::Z);
    }
    for j in 0..FACETS[1] {
        let s = (j as f32 + 0.5) / FACETS[1] as f32;
        let (half, half_weight) = match microfacets.distribution {
            Distribution::Ggx => (0.5 * s, 1.0),
            // Again to the end where facets are tilted.
            Distribution::Beckmann => (0.5 * s * s, 2.0 * s),
        };
        // Rows are shifted against each other (a lattice), so that total reflection does not set in between two columns of
        // all of them.
        let shift = (0.5 + GOLDEN as f32 * j as f32).fract();
        for i in 0..FACETS[0] {
            // Rare facets, those that are tilted most, lose most: they lie at the ends.
            let t = (i as f32 + shift) / FACETS[0] as f32;
            let whole = t * t * (3.0 - 2.0 * t);
            let weight = half_weight * 6.0 * t * (1.0 - t) / (FACETS[0] * FACETS[1]) as f32;
            let u = match microfacets.distribution {
                Distribution::Ggx => [half, whole],
                Distribution::Beckmann => [whole, half],
            };
            for (sum, value) in sums.iter_mut().zip(value(microfacets.sample_visible(wo, u))) {
                add(sum, &value, weight);
            }
        }
    }
    sums
}

/// A direction of the broad lobe, upper hemisphere: t of [`Nodes`] with density 4 t^3, which follows the lobe from barely
/// rough surfaces, that lose light to the horizon only, to rough ones, where it is nearly a cosine.
#[inline]
pub(super) fn square_to_broad(alpha: f32, u: [f32; 2]) -> Vec3 {
    let z = Nodes::new(alpha).cosine_at(u[0].sqrt().sqrt());
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (TAU * u[1]).sin_cos();
    Vec3::new(radius * cos, radius * sin, z)
}

/// Density of [`square_to_broad`], 1/sr.
#[inline]
pub(super) fn broad_pdf(alpha: f32, cos: f32) -> f32 {
    let Nodes { c, .. } = Nodes::new(alpha);
    let share = (1.0 + c) / (cos + c);
    share * share * c / (cos + c) * cos * FRAC_1_PI
}

/// Share of the light reflected by facet `h` that no other facet stops.
fn reflected(microfacets: &Microfacets, wo: Vec3, h: Vec3) -> f32 {
    let up = h * (2.0 * wo.dot(h)) - wo;
    if up.z > 0.0 { microfacets.g2_reflect(wo, up) / microfacets.g1(wo) } else { 0.0 }
}

/// Share of the light that single scattering by metal facets would lose if they reflected everything.
pub struct Missing(Table<1>);

impl Missing {
    /// For a constant `alpha`, or for all where `None`; `None` where nothing worth mentioning is lost.
    pub fn new(distribution: Distribution, alpha: Option<f32>) -> Option<Self> {
        let [table] =
            Table::several(distribution, alpha, Nodes::new, |facets, wo, h| [[1.0 - reflected(facets, wo, h)]]);
        (table.at(alpha.unwrap_or(1.0), LOW)[0] > NEGLIGIBLE).then_some(Self(table))
    }

    /// Share lost from a direction at this (positive) cosine.
    #[inline]
    pub fn share(&self, alpha: f32, cos: f32) -> f32 {
        self.0.at(alpha, cos)[0].max(0.0)
    }

    /// Share lost from diffuse light.
    #[inline]
    pub fn mean(&self, alpha: f32) -> f32 {
        self.0.mean(alpha)[0].max(TINY)
    }

    /// Share of the broad lobe's light per steradian towards `cos_i`, cosine included: in proportion to what is missing
    /// there, which makes the lobe reciprocal.
    #[inline]
    pub fn lobe(&self, alpha: f32, cos_i: f32) -> f32 {
        self.share(alpha, cos_i) * cos_i * FRAC_1_PI / self.mean(alpha)
    }
}

/// Means below this are mostly rounding: what they stand for is left lost.
const TINY: f32 = 1e-5;

/// One number that needs no film, and one for each term of a profile.
type Sums = Table<{ 1 + TERMS }>;

/// What facets between two transparent media do to light, whatever their film.
pub struct Interface(Geometry);

enum Geometry {
    /// Losses from outside and from inside: if everything were reflected, and what each term of the transmittance
    /// changes.
    Bends { losses: [Sums; 2] },
    /// Between equal media. What goes straight through: the share that the spread of visible facets leaves of fringes too
    /// narrow for a profile, and what the facets' mean of each of its terms is beyond that.
    Straight { losses: Sums, through: Sums },
}

impl Interface {
    /// For a constant `alpha`, or for all where `None`. `eta` is the index inside over outside.
    pub fn new(distribution: Distribution, alpha: Option<f32>, eta: f32) -> Self {
        if is_straight(eta) {
            let [losses] = Table::several(distribution, alpha, Nodes::new, |facets, wo, h| {
                // What is not bent meets no obstacle.
                [loss(reflected(facets, wo, h), Some((wo.dot(h).max(0.0), 1.0)))]
            });
            let [through] =
                Table::several(distribution, alpha, Nodes::of_terms, |_, wo, h| [straight(wo.z, wo.dot(h).max(0.0))]);
            return Self(Geometry::Straight { losses, through });
        }
        let losses = Table::several(distribution, alpha, Nodes::new, |facets, wo, h| {
            let reflected = reflected(facets, wo, h);
            [eta, 1.0 / eta].map(|across| loss(reflected, passed(facets, wo, h, across)))
        });
        Self(Geometry::Bends { losses })
    }

    #[inline]
    fn losses(&self, side: Side) -> &Sums {
        match &self.0 {
            Geometry::Bends { losses } => &losses[at(side)],
            Geometry::Straight { losses, .. } => losses,
        }
    }
}

/// For light refracted by facet `h`: the cosine in the rarer medium, and the share that no other facet stops. `None` beyond
/// the critical angle.
fn passed(microfacets: &Microfacets, wo: Vec3, h: Vec3, across: f32) -> Option<(f32, f32)> {
    let cos_h = wo.dot(h).max(0.0);
    let down = refract(wo, h, cos_h, across)?;
    let passed = if down.z < 0.0 { microfacets.g2_transmit(wo, down) / microfacets.g1(wo) } else { 0.0 };
    Some((if across >= 1.0 { cos_h } else { down.dot(h).abs() }, passed))
}

fn loss(reflected: f32, passed: Option<(f32, f32)>) -> [f32; 1 + TERMS] {
    let mut entry = [0.0; 1 + TERMS];
    entry[0] = 1.0 - reflected;
    if let Some((rare_cos, passed)) = passed {
        for (slot, value) in entry[1..].iter_mut().zip(terms(rare_cos)) {
            *slot = value * (reflected - passed);
        }
    }
    entry
}

/// Periods over sqrt(mu) of a fringe that a profile does not resolve, per term.
const NARROW: f32 = 0.6;

fn straight(cos: f32, cos_h: f32) -> [f32; 1 + TERMS] {
    let narrow = ((cos_h.sqrt() - cos.sqrt()) * (NARROW * TAU * TERMS as f32)).cos();
    let mut entry = [narrow; 1 + TERMS];
    for (slot, (facet, view)) in entry[1..].iter_mut().zip(terms(cos_h).into_iter().zip(terms(cos))) {
        *slot = facet - narrow * view;
    }
    entry
}

/// [`Interface`] under a film, at one point.
pub struct Multiple<'s, M: Mode> {
    interface: &'s Interface,
    alpha: f32,
    profile: Profile<M::Light>,
    /// Lost from diffuse light, from outside and from inside.
    means: [M::Light; 2],
    /// Shares of what is lost that cross to the other side, from outside and from inside.
    crossing: [M::Light; 2],
}

impl<'s, M: Mode> Multiple<'s, M> {
    /// `eta` is the index inside over outside.
    pub fn new(interface: &'s Interface, alpha: f32, eta: f32, profile: Profile<M::Light>) -> Self {
        let zero = M::Light::ZERO;
        let mut multiple = Self { interface, alpha, profile, means: [zero; 2], crossing: [zero; 2] };
        multiple.means = [Side::Outside, Side::Inside]
            .map(|side| multiple.lost(side, &interface.losses(side).mean(alpha)).map(|mean| mean.max(TINY)));
        // Crossing must be reciprocal, which ties the two sides together: y m n^2 has to be the same from both, and n^2 T
        // is; the smaller loss sets the scale.
        let mut transmit = M::Light::ZERO;
        for (factor, mean) in multiple.profile.transmit.iter().zip(term_means()) {
            transmit += *factor * *mean;
        }
        let [outside, inside] = multiple.means;
        multiple.crossing = [
            transmit * outside.zip(inside, |here, beyond| (beyond / here).min(1.0) * (eta * eta).min(1.0)),
            transmit * inside.zip(outside, |here, beyond| (beyond / here).min(1.0) * (eta * eta).recip().min(1.0)),
        ];
        multiple
    }

    /// Lost from the light whose facets have these sums.
    #[inline]
    fn lost(&self, side: Side, sums: &[f32; 1 + TERMS]) -> M::Light {
        let mut lost = self.profile.absorbed[at(side)].map(|absorbed| (1.0 - absorbed) * sums[0]);
        for (factor, sum) in self.profile.transmit.iter().zip(&sums[1..]) {
            lost += *factor * *sum;
        }
        lost
    }

    /// Share of light that single scattering loses from a direction on `side` at this (positive) cosine.
    #[inline]
    pub(super) fn missing(&self, side: Side, cos: f32) -> M::Light {
        let lost = self.lost(side, &self.interface.losses(side).at(self.alpha, cos));
        lost.zip(self.means[at(side)], |lost, mean| if mean > TINY { lost.max(0.0) } else { 0.0 })
    }

    /// The broad lobe's light per steradian towards a direction on `side` at this (positive) cosine, cosine included, for
    /// light 1: in proportion to what is missing there.
    #[inline]
    pub(super) fn lobe(&self, side: Side, cos: f32) -> M::Light {
        self.missing(side, cos) * self.means[at(side)].map(|mean| cos * FRAC_1_PI / mean)
    }

    /// Shares of the missing light of `side` that stay on this side and that cross.
    #[inline]
    pub(super) fn shares(&self, side: Side) -> [M::Light; 2] {
        let crossing = self.crossing[at(side)];
        // What facets absorb stays absorbed; everything else that does not cross comes back.
        let kept = self.profile.absorbed[at(side)].map(|absorbed| 1.0 - absorbed);
        [kept + crossing * -1.0, crossing]
    }

    /// What goes straight through a body that does not bend light, seen at this (positive) cosine: the facets' mean, where
    /// `facet` is transmitted by one at this very cosine.
    #[inline]
    pub(super) fn straight(&self, cos: f32, facet: M::Light) -> M::Light {
        let Geometry::Straight { through, .. } = &self.interface.0 else { return M::Light::ZERO };
        let [narrow, weights @ ..] = through.at(self.alpha, cos);
        let mut transmit = facet * narrow;
        for (factor, weight) in self.profile.transmit.iter().zip(weights) {
            transmit += *factor * weight;
        }
        transmit
    }
}

#[inline]
fn at(side: Side) -> usize {
    usize::from(side == Side::Inside)
}
