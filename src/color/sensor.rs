//! The sensor: from spectra to linear sRGB.

use super::cie::{self, Matrix};
use super::emission::{Emission, Spectrum};

/// Linear sRGB responses at each wavelength, adapted (Bradford) so that a perfect reflector under `white` is exactly
/// (1, 1, 1). For D65 the adaptation is the identity.
///
/// Normalisation: a spectrum L(lambda), in units where `Spectrum` has photopic mean 1, has the colour
///
///   rgb = 1/400 nm * integral over 380..780 nm of L(lambda) response(lambda) dlambda
///
/// so for wavelengths drawn uniformly from [380, 780] the colour is the plain mean of L * response, and for another
/// density p (1/nm) it is the mean of L * response / (400 p). With L = white this is (1, 1, 1).
#[derive(Clone, Debug)]
pub struct Sensor {
    white: Spectrum,
    /// At 1 nm, 380..780 nm; the fourth lane is padding, so that a look-up is two aligned loads.
    response: Vec<[f32; 4]>,
    /// Response times white, each channel summing to 1 over the 401 samples: the weights of a reflectance.
    weights: Vec<[f64; 3]>,
    /// Response in full precision.
    exact: Vec<[f64; 3]>,
}

impl Sensor {
    pub fn new(white: &Emission) -> Self {
        let white = white.spectrum();
        let d65 = Emission::D65.spectrum();
        let d65_xyz = cie::xyz(|nm| d65.at(nm), |nm| d65.at(nm));
        let white_xyz = cie::xyz(|nm| white.at(nm), |nm| white.at(nm));
        let to_rgb: Matrix = cie::multiply(cie::srgb_matrix(d65_xyz), cie::adapt(white_xyz, d65_xyz));
        let nm = |step: usize| cie::MIN_NM + step as f64;
        let raw: Vec<[f64; 3]> = (0..=cie::STEPS).map(|step| cie::apply(to_rgb, cie::observer(nm(step)))).collect();
        // Rounding aside all three sums are equal; dividing by each makes (1, 1, 1) exact. A white without red power (a
        // single laser line) has no meaningful balance: its channels fall back on the sum of green.
        let sums: [f64; 3] = std::array::from_fn(|i| (0..=cie::STEPS).map(|s| raw[s][i] * white.at(nm(s))).sum());
        let sums = sums.map(|sum| if sum.abs() > 1e-12 { sum } else { 1.0 });
        let steps = cie::STEPS as f64;
        let exact: Vec<[f64; 3]> = raw.iter().map(|r| std::array::from_fn(|i| r[i] / sums[i] * steps)).collect();
        let response = exact.iter().map(|r| [r[0] as f32, r[1] as f32, r[2] as f32, 0.0]).collect();
        let weights = (0..=cie::STEPS).map(|s| exact[s].map(|r| r * white.at(nm(s)) / steps)).collect();
        Self { white, response, weights, exact }
    }

    /// The spectrum of the reference white.
    pub fn white(&self) -> &Spectrum {
        &self.white
    }

    /// Linear sRGB of a reflectance seen under the white: the sum over 380..780 nm at 1 nm. Unclamped: saturated spectra
    /// leave sRGB.
    pub fn rgb_of_reflectance(&self, reflectance: impl Fn(f64) -> f64) -> [f64; 3] {
        sum(&self.weights, reflectance, 1.0)
    }

    /// Linear sRGB of a light of this spectrum (photopic mean 1 gives luminance 1, up to the adaptation).
    pub fn rgb_of_light(&self, power: impl Fn(f64) -> f64) -> [f64; 3] {
        sum(&self.exact, power, 1.0 / cie::STEPS as f64)
    }

    /// Linear sRGB response at a wavelength in nm; zero outside 380..780. Normalisation: see the type.
    #[inline]
    pub fn response(&self, nm: f32) -> [f32; 3] {
        let x = nm - cie::MIN_NM as f32;
        // Written so that NaN counts as outside.
        if !(x >= 0.0 && x <= cie::STEPS as f32) {
            return [0.0; 3];
        }
        let low = (x as usize).min(cie::STEPS - 1);
        let t = x - low as f32;
        let (a, b) = (self.response[low], self.response[low + 1]);
        std::array::from_fn(|i| a[i] + t * (b[i] - a[i]))
    }

    /// The weight of each channel at a wavelength in nm when a reflectance is integrated: response times white over 400, so
    /// that the sum at 1 nm steps is (1, 1, 1). Linear between the 1 nm samples.
    pub fn reflectance_weight(&self, nm: f64) -> [f64; 3] {
        let x = (nm - cie::MIN_NM).clamp(0.0, cie::STEPS as f64);
        let low = (x as usize).min(cie::STEPS - 1);
        let t = x - low as f64;
        std::array::from_fn(|i| self.weights[low][i] * (1.0 - t) + self.weights[low + 1][i] * t)
    }
}

fn sum(weights: &[[f64; 3]], spectrum: impl Fn(f64) -> f64, scale: f64) -> [f64; 3] {
    let mut rgb = [0.0; 3];
    for (step, weight) in weights.iter().enumerate() {
        let value = scale * spectrum(cie::MIN_NM + step as f64);
        rgb = std::array::from_fn(|i| rgb[i] + weight[i] * value);
    }
    rgb
}
