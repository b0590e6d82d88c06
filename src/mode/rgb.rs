//! RGB transport: three lanes of linear sRGB.

use glam::Vec3;

use super::{FilmPlan, Mode, Wide};
use crate::color::{Emission, IndexCurve, NOMINAL_NM, Sensor};
use crate::film::{self, RgbFilm, RgbProfile, Side, Split, Stack, Verdict};

/// Three lanes of linear sRGB.
#[derive(Clone, Copy, Debug)]
pub struct Rgb;

impl Mode for Rgb {
    type Light = Wide<3>;
    type Waves = ();
    type Film = RgbFilm;
    type Profile = RgbProfile;
    type Spectrum = Vec3;
    type Eta = f32;
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

    fn film(stack: &Stack, plan: &FilmPlan) -> (RgbFilm, Option<Verdict>) {
        let (film, verdict) = film::choose(stack, plan.range, plan.sensor, plan.tolerance, plan.forced);
        (film, Some(verdict))
    }

    #[inline]
    fn split(film: &RgbFilm, side: Side, cos_i: f32, thickness_nm: f32, _waves: &()) -> Split<Wide<3>> {
        let split = film.split(side, cos_i, thickness_nm);
        Split { reflect: Wide(split.reflect), transmit: Wide(split.transmit) }
    }

    fn average(film: &RgbFilm, side: Side, thickness_nm: f32, _waves: &()) -> Wide<3> {
        Wide(film.average(side, thickness_nm))
    }

    fn profile(film: &RgbFilm, stack: &Stack, range: film::Range) -> RgbProfile {
        RgbProfile::new(film, stack, range)
    }

    #[inline]
    fn profiled(profile: &RgbProfile, thickness_nm: f32, _waves: &()) -> film::Profile<Wide<3>> {
        profile.at(thickness_nm).map(Wide)
    }

    fn eta(index: &IndexCurve) -> f32 {
        index.at(NOMINAL_NM).re as f32
    }

    #[inline]
    fn refraction(eta: &f32, _waves: &()) -> (f32, bool) {
        (*eta, false)
    }

    #[inline]
    fn survivors(light: Wide<3>, _waves: &()) -> Wide<3> {
        light
    }

    #[inline]
    fn collapse(_waves: &mut ()) {}

    #[inline]
    fn to_rgb(light: Wide<3>, _waves: &(), _sensor: &Sensor) -> Vec3 {
        Vec3::from_array(light.0)
    }
}
