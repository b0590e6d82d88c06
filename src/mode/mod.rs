//! The colour mode: what travels along a path. The only place where RGB and spectral transport differ.

mod grouped;
mod lanes;
mod paired;
mod rgb;
mod spectral;

use std::fmt::Debug;

use glam::Vec3;

use crate::color::{Emission, IndexCurve, Sensor};
use crate::film::{self, Rung, Side, Split, Stack, Verdict};

pub use grouped::{GROUPS, Grouped};
pub use lanes::{Lanes, Wide};
pub use paired::Paired;
pub use rgb::Rgb;
pub use spectral::{Spectral, Waves};

/// One way of carrying colour: three channels, or N wavelengths. Monomorphised, so that RGB pays nothing for spectral.
pub trait Mode: Copy + Debug + Send + Sync + 'static {
    type Light: Lanes;
    /// What each lane of this path stands for.
    type Waves: Copy + Debug + Send + Sync;
    /// A compiled interface: how much light of each lane it reflects and transmits.
    type Film: Send + Sync;
    /// How an interface transmits over angle, for what microfacets lose.
    type Profile: Send + Sync;
    /// A compiled light spectrum.
    type Spectrum: Send + Sync;
    /// A compiled refractive index of a body that bends light.
    type Eta: Send + Sync;

    /// As in `--mode` and the stats.
    const NAME: &'static str;
    /// True when [`Mode::waves`] wants a random number.
    const SAMPLES_WAVES: bool;
    /// Light groups that are told apart; 0: none.
    const GROUPS: usize = 0;

    /// The lanes of one path, from a number in [0, 1).
    fn waves(u: f32) -> Self::Waves;
    /// Lane values of a reflectance or tint given as linear sRGB.
    fn reflectance(rgb: Vec3, waves: &Self::Waves) -> Self::Light;
    fn spectrum(emission: &Emission, sensor: &Sensor) -> Self::Spectrum;
    /// The same where light groups are told apart.
    fn group_spectrum(emission: &Emission, _group: usize, sensor: &Sensor) -> Self::Spectrum {
        Self::spectrum(emission, sensor)
    }
    /// Lane radiance of a light of this spectrum, tinted and scaled by linear sRGB.
    fn emitted(spectrum: &Self::Spectrum, rgb: Vec3, waves: &Self::Waves) -> Self::Light;
    /// The verdict tells what was chosen; `None` where the mode is exact and there was no choice.
    fn film(stack: &Stack, plan: &FilmPlan) -> (Self::Film, Option<Verdict>);
    fn split(film: &Self::Film, side: Side, cos_i: f32, thickness_nm: f32, waves: &Self::Waves) -> Split<Self::Light>;
    /// Mean reflectance over the cosine-weighted hemisphere: 2 Int R(mu) mu dmu.
    fn average(film: &Self::Film, side: Side, thickness_nm: f32, waves: &Self::Waves) -> Self::Light;
    fn profile(film: &Self::Film, stack: &Stack, range: film::Range) -> Self::Profile;
    fn profiled(profile: &Self::Profile, thickness_nm: f32, waves: &Self::Waves) -> film::Profile<Self::Light>;
    fn eta(index: &IndexCurve) -> Self::Eta;
    /// The index that decides this path's direction, and whether other lanes would have gone elsewhere.
    fn refraction(eta: &Self::Eta, waves: &Self::Waves) -> (f32, bool);
    /// What is left of light that was bent by an index that differs between lanes: the lane that decided, weighted to stand
    /// for all.
    fn survivors(light: Self::Light, waves: &Self::Waves) -> Self::Light;
    /// Notes that only the survivors travel on.
    fn collapse(waves: &mut Self::Waves);
    /// What a pixel adds up: linear sRGB under the sensor's white.
    fn to_rgb(light: Self::Light, waves: &Self::Waves, sensor: &Sensor) -> Vec3;
    /// The part of it that one of the [`GROUPS`](Self::GROUPS) has.
    fn group_to_rgb(light: &Self::Light, _group: usize, waves: &Self::Waves, sensor: &Sensor) -> Vec3 {
        Self::to_rgb(*light, waves, sensor)
    }
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
