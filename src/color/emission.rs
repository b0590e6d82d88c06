//! Spectral shapes of light sources.

use std::sync::{Arc, LazyLock};

use super::cie;
use super::table::{self, Row};

/// The relative spectral power of a light, as a scene names it. The RGB colour beside it gives tint and strength.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Emission {
    /// Equal energy.
    #[default]
    E,
    D65,
    A,
    /// Planckian radiator at this temperature in kelvin.
    Blackbody(f32),
    /// (wavelength in nm, relative power), increasing wavelengths.
    Table(Vec<(f32, f32)>),
}

/// CIE D65 at 5 nm, 360..830 nm.
static D65: LazyLock<Vec<Row<1>>> = LazyLock::new(|| table::parse(include_str!("../../data/illuminant_d65.csv")));

/// Temperature of illuminant A with its own value of c2, K; and the c2 of the present temperature scale, nm K.
const A_KELVIN: f64 = 2848.0;
const A_C2_NM_K: f64 = 1.435e7;
const C2_NM_K: f64 = 1.438_776_877e7;

/// Relative spectral power over wavelength, scaled so that its mean under the photopic curve is 1: radiance (1, 1, 1) has
/// the same luminance whatever its spectrum.
#[derive(Clone, Debug)]
pub struct Spectrum {
    /// At 1 nm, 380..780 nm.
    power: Arc<[f64]>,
}

impl Emission {
    /// The spectrum; all zero where a table holds no power inside 380..780 nm.
    pub fn spectrum(&self) -> Spectrum {
        match self {
            Self::E => Spectrum::new(|_| 1.0),
            Self::D65 => Spectrum::new(|nm| table::interpolate(&D65, nm)[0]),
            // CIE 015: the definition keeps the c2 of 1931.
            Self::A => Spectrum::new(|nm| planck(nm, A_C2_NM_K / A_KELVIN)),
            Self::Blackbody(kelvin) => {
                // Below 20 K the visible tail leaves the range of f64; nothing shines there.
                let reach_nm = C2_NM_K / f64::from(kelvin.max(20.0));
                Spectrum::new(|nm| planck(nm, reach_nm))
            }
            Self::Table(rows) => {
                let rows: Vec<Row<1>> = rows.iter().map(|&(nm, power)| (f64::from(nm), [f64::from(power)])).collect();
                let (first, last) = (rows.first().map_or(0.0, |r| r.0), rows.last().map_or(0.0, |r| r.0));
                // A table says nothing about the light outside its own range: dark, as lamps and lasers are there.
                Spectrum::new(|nm| if nm < first || nm > last { 0.0 } else { table::interpolate(&rows, nm)[0] })
            }
        }
    }
}

/// Planck's law relative to 560 nm; `reach_nm` = c2 / T. Written by differences of exponents, so that 100 K does not
/// overflow.
fn planck(nm: f64, reach_nm: f64) -> f64 {
    let (x, x0) = (reach_nm / nm, reach_nm / 560.0);
    (560.0 / nm).powi(5) * (x0 - x).exp() * (-x0).exp_m1() / (-x).exp_m1()
}

impl Spectrum {
    fn new(power: impl Fn(f64) -> f64) -> Self {
        let nm = |step: usize| cie::MIN_NM + step as f64;
        let (mut sum, mut weight) = (0.0, 0.0);
        for step in 0..=cie::STEPS {
            let photopic = cie::observer(nm(step))[1];
            sum += photopic * power(nm(step));
            weight += photopic;
        }
        let scale = if sum > 0.0 { weight / sum } else { 0.0 };
        Self { power: (0..=cie::STEPS).map(|step| scale * power(nm(step)).max(0.0)).collect() }
    }

    /// Relative power at a wavelength in nm; linear between 1 nm samples, zero outside 380..780 nm.
    pub fn at(&self, nm: f64) -> f64 {
        let x = nm - cie::MIN_NM;
        if !(0.0..=cie::STEPS as f64).contains(&x) {
            return 0.0;
        }
        let low = (x as usize).min(cie::STEPS - 1);
        let t = x - low as f64;
        self.power[low] * (1.0 - t) + self.power[low + 1] * t
    }

    /// Relative power at each of a path's wavelengths in nm.
    pub fn lanes<const N: usize>(&self, nm: &[f32; N]) -> [f32; N] {
        nm.map(|nm| self.at(f64::from(nm)) as f32)
    }
}
