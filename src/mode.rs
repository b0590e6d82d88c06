//! The colour mode: what travels along a path. The only place where RGB and spectral transport differ.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Mul, MulAssign};

use glam::Vec3;

use crate::color::{Emission, Sensor};
use crate::film::{self, RgbFilm, Rung, Side, Split, Stack, Verdict};

/// One way of carrying colour: three channels, or N wavelengths. Monomorphised, so that RGB pays nothing for spectral.
pub trait Mode: Copy + Debug + Send + Sync + 'static {
    type Light: Lanes;
    /// What each lane of this path stands for.
    type Waves: Copy + Debug + Send + Sync;
    /// A compiled interface: how much light of each lane it reflects and transmits.
    type Film: Send + Sync;
    /// A compiled light spectrum.
    type Spectrum: Send + Sync;

    /// As in `--mode` and the stats.
    const NAME: &'static str;
    /// True when [`Mode::waves`] wants a random number.
    const SAMPLES_WAVES: bool;

    /// The lanes of one path, from a number in [0, 1).
    fn waves(u: f32) -> Self::Waves;
    /// Lane values of a reflectance or tint given as linear sRGB.
    fn reflectance(rgb: Vec3, waves: &Self::Waves) -> Self::Light;
    fn spectrum(emission: &Emission, sensor: &Sensor) -> Self::Spectrum;
    /// Lane radiance of a light of this spectrum, tinted and scaled by linear sRGB.
    fn emitted(spectrum: &Self::Spectrum, rgb: Vec3, waves: &Self::Waves) -> Self::Light;
    fn film(stack: &Stack, plan: &FilmPlan) -> (Self::Film, Verdict);
    fn split(film: &Self::Film, side: Side, cos_i: f32, thickness_nm: f32, waves: &Self::Waves) -> Split<Self::Light>;
    /// Mean reflectance over the cosine-weighted hemisphere: 2 Int R(mu) mu dmu.
    fn average(film: &Self::Film, side: Side, thickness_nm: f32, waves: &Self::Waves) -> Self::Light;
    /// What a pixel adds up: linear sRGB under the sensor's white.
    fn to_rgb(light: Self::Light, waves: &Self::Waves, sensor: &Sensor) -> Vec3;
}

/// How a film is to be compiled.
pub struct FilmPlan<'a> {
    /// Thickness of the varying layer over the scene, nm.
    pub range: film::Range,
    pub sensor: &'a Sensor,
    /// Largest CIEDE2000 that a cheaper rung may cost.
    pub tolerance: f64,
    pub forced: Option<Rung>,
}

/// Three lanes of linear sRGB.
#[derive(Clone, Copy, Debug)]
pub struct Rgb;

impl Mode for Rgb {
    type Light = Wide<3>;
    type Waves = ();
    type Film = RgbFilm;
    type Spectrum = Vec3;
    const NAME: &'static str = "rgb";
    const SAMPLES_WAVES: bool = false;

    #[inline]
    fn waves(_u: f32) {}

    #[inline]
    fn reflectance(rgb: Vec3, _waves: &()) -> Wide<3> {
        Wide(rgb.to_array())
    }

    fn spectrum(emission: &Emission, sensor: &Sensor) -> Vec3 {
        let [r, g, b] = {
            let spectrum = emission.spectrum();
            sensor.rgb_of_light(|nm| spectrum.at(nm))
        };
        Vec3::new(r as f32, g as f32, b as f32)
    }

    #[inline]
    fn emitted(spectrum: &Vec3, rgb: Vec3, _waves: &()) -> Wide<3> {
        Wide((*spectrum * rgb).to_array())
    }

    fn film(stack: &Stack, plan: &FilmPlan) -> (RgbFilm, Verdict) {
        film::choose(stack, plan.range, plan.sensor, plan.tolerance, plan.forced)
    }

    #[inline]
    fn split(film: &RgbFilm, side: Side, cos_i: f32, thickness_nm: f32, _waves: &()) -> Split<Wide<3>> {
        let split = film.split(side, cos_i, thickness_nm);
        Split { reflect: Wide(split.reflect), transmit: Wide(split.transmit) }
    }

    fn average(film: &RgbFilm, side: Side, thickness_nm: f32, _waves: &()) -> Wide<3> {
        Wide(film.average(side, thickness_nm))
    }

    #[inline]
    fn to_rgb(light: Wide<3>, _waves: &(), _sensor: &Sensor) -> Vec3 {
        Vec3::from_array(light.0)
    }
}

/// A fixed number of values that are transported side by side: colour channels or wavelengths.
pub trait Lanes:
    Copy
    + Debug
    + Send
    + Sync
    + PartialEq
    + Add<Output = Self>
    + AddAssign
    + Mul<Output = Self>
    + MulAssign
    + Mul<f32, Output = Self>
    + 'static
{
    const ZERO: Self;
    const ONE: Self;
    fn splat(value: f32) -> Self;
    fn mean(&self) -> f32;
    fn max(&self) -> f32;
    fn is_finite(&self) -> bool;
    fn map(self, f: impl Fn(f32) -> f32) -> Self;
    fn is_black(&self) -> bool {
        *self == Self::ZERO
    }
}

/// `N` lanes in an array that the compiler keeps in vector registers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wide<const N: usize>(pub [f32; N]);

impl<const N: usize> Lanes for Wide<N> {
    const ZERO: Self = Self([0.0; N]);
    const ONE: Self = Self([1.0; N]);

    #[inline]
    fn splat(value: f32) -> Self {
        Self([value; N])
    }

    #[inline]
    fn mean(&self) -> f32 {
        self.0.iter().sum::<f32>() * (1.0 / N as f32)
    }

    #[inline]
    fn max(&self) -> f32 {
        self.0.iter().fold(f32::NEG_INFINITY, |a, &b| a.max(b))
    }

    #[inline]
    fn is_finite(&self) -> bool {
        // 0 * x is NaN exactly when x is not finite; a sum needs no branches.
        self.0.iter().map(|x| x * 0.0).sum::<f32>() == 0.0
    }

    #[inline]
    fn map(self, f: impl Fn(f32) -> f32) -> Self {
        Self(self.0.map(f))
    }
}

impl<const N: usize> Add for Wide<N> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl<const N: usize> Mul for Wide<N> {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] * other.0[i]))
    }
}

impl<const N: usize> Mul<f32> for Wide<N> {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f32) -> Self {
        Self(self.0.map(|x| x * factor))
    }
}

impl<const N: usize> AddAssign for Wide<N> {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const N: usize> MulAssign for Wide<N> {
    #[inline]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}
