//! Light groups: another mode, with the light of each group in lanes of its own.
//!
//! Every group travels on the same paths: surfaces act alike on all, so that choices are those of the mode inside, and only
//! what lights send out differs. One render gives them all, for the price of wider arithmetic; the path loop knows nothing
//! of it.

use std::fmt::Debug;
use std::marker::PhantomData;
use std::ops::{Add, AddAssign, Mul, MulAssign};

use glam::Vec3;

use super::{FilmPlan, Lanes, Mode};
use crate::color::{Emission, IndexCurve, Sensor};
use crate::film::{self, Side, Split, Stack, Verdict};

/// Groups that are told apart: a power of two, so that the mean of equal numbers is exact.
pub const GROUPS: usize = 8;

/// The mode `M` once for each group.
#[derive(Clone, Copy, Debug)]
pub struct Grouped<M>(PhantomData<M>);

/// Lanes of each group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bundle<L>([L; GROUPS]);

impl<L: Lanes> Lanes for Bundle<L> {
    const ZERO: Self = Self([L::ZERO; GROUPS]);
    const ONE: Self = Self([L::ONE; GROUPS]);

    #[inline]
    fn splat(value: f32) -> Self {
        Self([L::splat(value); GROUPS])
    }

    #[inline]
    fn mean(&self) -> f32 {
        // In pairs: doubling and halving round nothing.
        let mut sums = self.0.map(|lanes| lanes.mean());
        let mut count = GROUPS;
        while count > 1 {
            count /= 2;
            for i in 0..count {
                sums[i] += sums[i + count];
            }
        }
        sums[0] * (1.0 / GROUPS as f32)
    }

    #[inline]
    fn max(&self) -> f32 {
        self.0.iter().fold(f32::NEG_INFINITY, |max, lanes| max.max(lanes.max()))
    }

    #[inline]
    fn is_finite(&self) -> bool {
        self.0.iter().all(L::is_finite)
    }

    #[inline]
    fn map(self, f: impl Fn(f32) -> f32) -> Self {
        Self(self.0.map(|lanes| lanes.map(&f)))
    }

    #[inline]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|group| self.0[group].zip(other.0[group], &f)))
    }
}

impl<L: Lanes> Add for Bundle<L> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|group| self.0[group] + other.0[group]))
    }
}

impl<L: Lanes> Mul for Bundle<L> {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        Self(std::array::from_fn(|group| self.0[group] * other.0[group]))
    }
}

impl<L: Lanes> Mul<f32> for Bundle<L> {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f32) -> Self {
        Self(self.0.map(|lanes| lanes * factor))
    }
}

impl<L: Lanes> AddAssign for Bundle<L> {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<L: Lanes> MulAssign for Bundle<L> {
    #[inline]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

/// The same for every group.
#[inline]
fn all<L: Copy>(lanes: L) -> Bundle<L> {
    Bundle([lanes; GROUPS])
}

impl<M: Mode> Mode for Grouped<M> {
    type Light = Bundle<M::Light>;
    type Waves = M::Waves;
    type Film = M::Film;
    type Profile = M::Profile;
    /// With the group that shines in it.
    type Spectrum = (M::Spectrum, usize);
    type Eta = M::Eta;
    const NAME: &'static str = M::NAME;
    const SAMPLES_WAVES: bool = M::SAMPLES_WAVES;
    const GROUPS: usize = GROUPS;

    #[inline]
    fn waves(u: f32) -> M::Waves {
        M::waves(u)
    }

    #[inline]
    fn reflectance(rgb: Vec3, waves: &M::Waves) -> Self::Light {
        all(M::reflectance(rgb, waves))
    }

    fn spectrum(emission: &Emission, sensor: &Sensor) -> Self::Spectrum {
        Self::group_spectrum(emission, 0, sensor)
    }

    fn group_spectrum(emission: &Emission, group: usize, sensor: &Sensor) -> Self::Spectrum {
        (M::spectrum(emission, sensor), group)
    }

    #[inline]
    fn emitted((spectrum, group): &Self::Spectrum, rgb: Vec3, waves: &M::Waves) -> Self::Light {
        let mut light = Self::Light::ZERO;
        light.0[*group] = M::emitted(spectrum, rgb, waves);
        light
    }

    fn film(stack: &Stack, plan: &FilmPlan) -> (M::Film, Option<Verdict>) {
        M::film(stack, plan)
    }

    #[inline]
    fn split(film: &M::Film, side: Side, cos_i: f32, thickness_nm: f32, waves: &M::Waves) -> Split<Self::Light> {
        let split = M::split(film, side, cos_i, thickness_nm, waves);
        Split { reflect: all(split.reflect), transmit: all(split.transmit) }
    }

    fn average(film: &M::Film, side: Side, thickness_nm: f32, waves: &M::Waves) -> Self::Light {
        all(M::average(film, side, thickness_nm, waves))
    }

    fn profile(film: &M::Film, stack: &Stack, range: film::Range) -> M::Profile {
        M::profile(film, stack, range)
    }

    #[inline]
    fn profiled(profile: &M::Profile, thickness_nm: f32, waves: &M::Waves) -> film::Profile<Self::Light> {
        M::profiled(profile, thickness_nm, waves).map(all)
    }

    fn eta(index: &IndexCurve) -> M::Eta {
        M::eta(index)
    }

    #[inline]
    fn refraction(eta: &M::Eta, waves: &M::Waves) -> (f32, bool) {
        M::refraction(eta, waves)
    }

    #[inline]
    fn survivors(light: Self::Light, waves: &M::Waves) -> Self::Light {
        Bundle(light.0.map(|lanes| M::survivors(lanes, waves)))
    }

    fn collapse(waves: &mut M::Waves) {
        M::collapse(waves);
    }

    #[inline]
    fn to_rgb(light: Self::Light, waves: &M::Waves, sensor: &Sensor) -> Vec3 {
        M::to_rgb(light.0.into_iter().fold(M::Light::ZERO, Add::add), waves, sensor)
    }

    #[inline]
    fn group_to_rgb(light: &Self::Light, group: usize, waves: &M::Waves, sensor: &Sensor) -> Vec3 {
        M::to_rgb(light.0[group], waves, sensor)
    }
}
