//! RGB and spectral side by side on the same paths, to measure how wrong RGB is for a scene.
//!
//! Lanes 0..3 are RGB, the others 16 wavelengths. Both share every direction and every choice, so the difference of the two
//! pictures has almost no noise of its own. A pilot for choosing the mode, not a way to render.

use glam::Vec3;

use super::spectral::{EtaTable, SpectrumTable};
use super::{FilmPlan, Mode, Rgb, Spectral, Waves, Wide};
use crate::color::{Emission, IndexCurve, Sensor};
use crate::film::{self, RgbFilm, RgbProfile, Side, SpectralFilm, SpectralProfile, Split, Stack, Verdict};

/// Number of wavelengths; with 16, colour noise vanishes.
const N: usize = 16;
const LANES: usize = 3 + N;

/// `SPECTRAL` tells which of the two pictures a pixel adds up.
#[derive(Clone, Copy, Debug)]
pub struct Paired<const SPECTRAL: bool>;

fn join(rgb: [f32; 3], waves: [f32; N]) -> Wide<LANES> {
    Wide(std::array::from_fn(|lane| if lane < 3 { rgb[lane] } else { waves[lane - 3] }))
}

/// RGB colours have no known spectrum: only their strength counts.
fn grey(rgb: Vec3) -> f32 {
    rgb.element_sum() / 3.0
}

fn spectral_part(light: &Wide<LANES>) -> Wide<N> {
    Wide(std::array::from_fn(|lane| light.0[lane + 3]))
}

impl<const SPECTRAL: bool> Mode for Paired<SPECTRAL> {
    type Light = Wide<LANES>;
    type Waves = Waves<N>;
    type Film = (RgbFilm, SpectralFilm);
    type Profile = (RgbProfile, SpectralProfile);
    type Spectrum = (Vec3, SpectrumTable);
    type Eta = EtaTable;
    const NAME: &'static str = "paired";
    const SAMPLES_WAVES: bool = true;

    fn waves(u: f32) -> Waves<N> {
        Waves::rotated(u)
    }

    fn reflectance(rgb: Vec3, _waves: &Waves<N>) -> Wide<LANES> {
        Wide([grey(rgb); LANES])
    }

    fn spectrum(emission: &Emission, sensor: &Sensor) -> Self::Spectrum {
        (Rgb::spectrum(emission, sensor), SpectrumTable::new(emission))
    }

    fn emitted((tint, table): &Self::Spectrum, rgb: Vec3, waves: &Waves<N>) -> Wide<LANES> {
        join(tint.to_array(), table.lanes(&waves.nm)) * grey(rgb)
    }

    fn film(stack: &Stack, plan: &FilmPlan) -> (Self::Film, Option<Verdict>) {
        let (rgb, verdict) = Rgb::film(stack, plan);
        ((rgb, Spectral::<N>::film(stack, plan).0), verdict)
    }

    fn split(film: &Self::Film, side: Side, cos_i: f32, nm: f32, waves: &Waves<N>) -> Split<Wide<LANES>> {
        let (rgb, spectral) = (film.0.split(side, cos_i, nm), film.1.split(side, cos_i, nm, &waves.nm));
        Split { reflect: join(rgb.reflect, spectral.reflect), transmit: join(rgb.transmit, spectral.transmit) }
    }

    fn average(film: &Self::Film, side: Side, nm: f32, waves: &Waves<N>) -> Wide<LANES> {
        join(film.0.average(side, nm), film.1.average(side, nm, &waves.nm))
    }

    fn profile(film: &Self::Film, stack: &Stack, range: film::Range) -> Self::Profile {
        (Rgb::profile(&film.0, stack, range), Spectral::<N>::profile(&film.1, stack, range))
    }

    fn profiled((rgb, spectral): &Self::Profile, nm: f32, waves: &Waves<N>) -> film::Profile<Wide<LANES>> {
        rgb.at(nm).zip(spectral.lanes(nm, &waves.nm), join)
    }

    fn eta(index: &IndexCurve) -> EtaTable {
        EtaTable::new(index)
    }

    fn refraction(eta: &EtaTable, waves: &Waves<N>) -> (f32, bool) {
        eta.at(waves.nm[0])
    }

    fn survivors(light: Wide<LANES>, waves: &Waves<N>) -> Wide<LANES> {
        let alone = Spectral::<N>::survivors(spectral_part(&light), waves);
        join([light.0[0], light.0[1], light.0[2]], alone.0)
    }

    fn collapse(waves: &mut Waves<N>) {
        Spectral::<N>::collapse(waves);
    }

    fn to_rgb(light: Wide<LANES>, waves: &Waves<N>, sensor: &Sensor) -> Vec3 {
        if SPECTRAL {
            Spectral::<N>::to_rgb(spectral_part(&light), waves, sensor)
        } else {
            Vec3::new(light.0[0], light.0[1], light.0[2])
        }
    }
}
