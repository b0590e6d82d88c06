//! Spectral transport: N wavelengths per path, equally spaced and rotated together.
//!
//! Wilkie et al. 2014, "Hero Wavelength Spectral Sampling", with all wavelengths equal except where an index that differs
//! between them bends the path: there lane 0 decides and stands for all.

use glam::Vec3;

use super::{FilmPlan, Mode, Wide};
use crate::color::{Emission, IndexCurve, MAX_NM, MIN_NM, Sensor, Uplift, UpliftLanes};
use crate::film::{self, Side, SpectralFilm, SpectralProfile, Split, Stack, Verdict};

/// N wavelengths: 4, 8 or 16.
#[derive(Clone, Copy, Debug)]
pub struct Spectral<const N: usize>;

/// The wavelengths of one path.
#[derive(Clone, Copy, Debug)]
pub struct Waves<const N: usize> {
    pub nm: [f32; N],
    uplift: UpliftLanes<N>,
    /// Only lane 0 is left.
    collapsed: bool,
}

const RANGE_NM: f32 = (MAX_NM - MIN_NM) as f32;

/// A light's spectrum at 1 nm.
pub enum SpectrumTable {
    /// The same at all wavelengths.
    Flat(f32),
    Table(Vec<f32>),
}

impl SpectrumTable {
    pub(super) fn new(emission: &Emission) -> Self {
        let spectrum = emission.spectrum();
        if *emission == Emission::E {
            return Self::Flat(spectrum.at(MIN_NM) as f32);
        }
        let steps = (MAX_NM - MIN_NM) as usize;
        Self::Table((0..=steps).map(|step| spectrum.at(MIN_NM + step as f64) as f32).collect())
    }

    #[inline]
    pub(super) fn lanes<const N: usize>(&self, nm: &[f32; N]) -> [f32; N] {
        match self {
            Self::Flat(power) => [*power; N],
            Self::Table(powers) => nm.map(|nm| interpolate(powers, nm)),
        }
    }
}

/// The index of a body over wavelength.
pub enum EtaTable {
    Constant(f32),
    /// At 1 nm.
    Dispersive(Vec<f32>),
}

impl EtaTable {
    pub(super) fn new(index: &IndexCurve) -> Self {
        match index.as_constant() {
            Some(constant) => Self::Constant(constant.re as f32),
            None => {
                let steps = (MAX_NM - MIN_NM) as usize;
                Self::Dispersive((0..=steps).map(|step| index.at(MIN_NM + step as f64).re as f32).collect())
            }
        }
    }

    #[inline]
    pub(super) fn at(&self, nm: f32) -> (f32, bool) {
        match self {
            Self::Constant(eta) => (*eta, false),
            Self::Dispersive(etas) => (interpolate(etas, nm), true),
        }
    }
}

/// Linear interpolation of a table at 1 nm from `MIN_NM`.
#[inline]
fn interpolate(table: &[f32], nm: f32) -> f32 {
    let x = (nm - MIN_NM as f32).clamp(0.0, RANGE_NM);
    let low = (x as usize).min(table.len() - 2);
    table[low] + (table[low + 1] - table[low]) * (x - low as f32)
}

impl<const N: usize> Waves<N> {
    /// Equal steps over the visible range from a random start.
    #[inline]
    pub(super) fn rotated(u: f32) -> Self {
        let nm = std::array::from_fn(|lane| {
            let turn = u + lane as f32 / N as f32;
            MIN_NM as f32 + RANGE_NM * (turn - turn.floor())
        });
        Self { nm, uplift: Uplift::new().lanes(&nm), collapsed: false }
    }

    /// Spectrum of a linear sRGB colour; greys, the commonest colours, need no basis because it sums to 1.
    #[inline]
    pub(super) fn uplifted(&self, rgb: Vec3) -> [f32; N] {
        if rgb.x == rgb.y && rgb.y == rgb.z { [rgb.x; N] } else { self.uplift.apply(rgb.to_array()) }
    }
}

impl<const N: usize> Mode for Spectral<N> {
    type Light = Wide<N>;
    type Waves = Waves<N>;
    type Film = SpectralFilm;
    type Profile = SpectralProfile;
    type Spectrum = SpectrumTable;
    type Eta = EtaTable;
    const NAME: &'static str = match N {
        4 => "spectral4",
        8 => "spectral8",
        _ => "spectral16",
    };
    const SAMPLES_WAVES: bool = true;

    #[inline]
    fn waves(u: f32) -> Waves<N> {
        Waves::rotated(u)
    }

    #[inline]
    fn reflectance(rgb: Vec3, waves: &Waves<N>) -> Wide<N> {
        Wide(waves.uplifted(rgb))
    }

    fn spectrum(emission: &Emission, _sensor: &Sensor) -> SpectrumTable {
        SpectrumTable::new(emission)
    }

    #[inline]
    fn emitted(spectrum: &SpectrumTable, rgb: Vec3, waves: &Waves<N>) -> Wide<N> {
        Wide(spectrum.lanes(&waves.nm)) * Wide(waves.uplifted(rgb))
    }

    fn film(stack: &Stack, plan: &FilmPlan) -> (SpectralFilm, Option<Verdict>) {
        (film::spectral(stack, plan.range), None)
    }

    #[inline]
    fn split(film: &SpectralFilm, side: Side, cos_i: f32, thickness_nm: f32, waves: &Waves<N>) -> Split<Wide<N>> {
        let split = film.split(side, cos_i, thickness_nm, &waves.nm);
        Split { reflect: Wide(split.reflect), transmit: Wide(split.transmit) }
    }

    fn average(film: &SpectralFilm, side: Side, thickness_nm: f32, waves: &Waves<N>) -> Wide<N> {
        Wide(film.average(side, thickness_nm, &waves.nm))
    }

    fn profile(film: &SpectralFilm, stack: &Stack, range: film::Range) -> SpectralProfile {
        SpectralProfile::new(film, stack, range)
    }

    #[inline]
    fn profiled(profile: &SpectralProfile, thickness_nm: f32, waves: &Waves<N>) -> film::Profile<Wide<N>> {
        profile.lanes(thickness_nm, &waves.nm).map(Wide)
    }

    fn eta(index: &IndexCurve) -> EtaTable {
        EtaTable::new(index)
    }

    #[inline]
    fn refraction(eta: &EtaTable, waves: &Waves<N>) -> (f32, bool) {
        eta.at(waves.nm[0])
    }

    #[inline]
    fn survivors(light: Wide<N>, waves: &Waves<N>) -> Wide<N> {
        if waves.collapsed {
            return light;
        }
        let mut alone = [0.0; N];
        alone[0] = light.0[0] * N as f32;
        Wide(alone)
    }

    fn collapse(waves: &mut Waves<N>) {
        waves.collapsed = true;
    }

    #[inline]
    fn to_rgb(light: Wide<N>, waves: &Waves<N>, sensor: &Sensor) -> Vec3 {
        let mut rgb = Vec3::ZERO;
        for (lane, nm) in waves.nm.into_iter().enumerate() {
            rgb += Vec3::from_array(sensor.response(nm)) * light.0[lane];
        }
        rgb * (1.0 / N as f32)
    }
}
