//! Belcour and Barla, "A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence", SIGGRAPH 2017:
//! Airy's series integrated over wavelength in Fourier space, with n and k held constant inside each channel.
//!
//! With r01 real and r12 complex, one polarisation of one channel reflects
//!
//!   R = 1 - K (1 + 2 sum_m Re[P^m S(m OPD)]),  P = -r01 r12,  K = (1 - r01^2)(1 - |r12|^2)/(1 - |P|^2)
//!   S(x) = sum over lambda of w(lambda) exp(2 pi i x / lambda),  OPD = 2 d q1 (inside the film)
//!
//! Three errors that copies of the published code carry are avoided. The paper's Gaussians are normalised for illuminant E
//! and pass through a matrix that is not sRGB's; here S is the transform of the sensor's own sRGB response times its white,
//! so a flat reflectance stays white. n and k per RGB channel are used in RGB, not mixed with XYZ kernels. Phases are those
//! of signed and complex amplitudes alone, with no further pi.

use num_complex::Complex64;

use crate::color::{CHANNEL_NM, IndexCurve, MAX_NM, MIN_NM, NOMINAL_NM, Sensor};

use super::grid::Axis;
use super::lanes::{Complex, cell, sin_cos_turns};
use super::quadrature::gauss_legendre;
use super::stack::{Range, Side, Split, Stack};
use super::table::thickness_axis;

#[derive(Clone, Debug)]
pub(super) struct Gaussian {
    channels: [Channel; 3],
    /// The side that all media are seen from: the rarer one.
    rare: Side,
    /// (n_dense / n_rare)^2.
    ratio: f32,
    opaque: bool,
    /// None where the thickness varies.
    constant_nm: Option<f32>,
    axis: Axis,
    /// Per thickness row: outside, inside.
    averages: Vec<[[f32; 3]; 2]>,
}

/// One colour channel: the media at its wavelength, seen from the rarer side, and its transform.
#[derive(Clone, Debug)]
struct Channel {
    n0: f32,
    n1: f32,
    base: Complex,
    per_nm: f32,
    /// S(x) exp(-2 pi i x / lambda) every `STEP_NM`: without its carrier the transform is smooth. Ends at zero.
    envelope: Vec<[f32; 2]>,
}

const STEP_NM: f32 = 50.0;
/// The transform has faded at this path difference.
const LAST: usize = 600;
/// Terms of the series, and the size at which it ends.
const TERMS: usize = 16;
const SMALLEST: f32 = 5e-4;

impl Gaussian {
    /// # Errors
    /// The reason why the model does not apply.
    pub(super) fn new(stack: &Stack, range: Range, sensor: &Sensor) -> Result<Self, &'static str> {
        let [layer] = stack.layers.as_slice() else { return Err("Belcour and Barla's model is for one layer") };
        if !stack.lossless_layers() || stack.outside.max_k() > 0.0 {
            return Err("Belcour and Barla's model is for a layer that does not absorb");
        }
        if stack.weight < 1.0 {
            return Err("Belcour and Barla's model is for full coverage");
        }
        let opaque = stack.opaque_base();
        let nominal = |side: Side| if side == Side::Outside { &stack.outside } else { &stack.base }.at(NOMINAL_NM).re;
        let rare = if opaque || nominal(Side::Outside) <= nominal(Side::Inside) { Side::Outside } else { Side::Inside };
        let (first, last) =
            if rare == Side::Outside { (&stack.outside, &stack.base) } else { (&stack.base, &stack.outside) };
        if layer.index.range_of_n().0 < first.range_of_n().1 {
            return Err("the layer is rarer than the medium around it, so its waves may be evanescent");
        }
        let ratio = if opaque { 1.0 } else { (last.at(NOMINAL_NM).re / first.at(NOMINAL_NM).re).powi(2) as f32 };
        let channels = [0, 1, 2].map(|c| {
            let base = mean_index(last, sensor, c);
            Channel {
                n0: mean_index(first, sensor, c).re,
                n1: mean_index(&layer.index, sensor, c).re,
                base,
                per_nm: (1.0 / CHANNEL_NM[c]) as f32,
                envelope: envelope(sensor, c),
            }
        });
        let constant_nm = stack.varying.is_none().then_some(layer.thickness_nm as f32);
        let axis = thickness_axis(stack, range);
        let mut film = Self { channels, rare, ratio, opaque, constant_nm, axis, averages: Vec::new() };
        film.averages = (0..film.axis.rows()).map(|row| film.row_averages(row, range)).collect();
        Ok(film)
    }

    /// Never inlined: its many registers would be saved for every look-up in a table, too.
    #[inline(never)]
    pub(super) fn split(&self, side: Side, cos_i: f32, thickness_nm: f32) -> Split<[f32; 3]> {
        let mut mu = cos_i.abs();
        if side != self.rare {
            let square = 1.0 - self.ratio * (1.0 - mu * mu);
            if self.opaque || square <= 0.0 {
                return Split { reflect: [1.0; 3], transmit: [0.0; 3] };
            }
            mu = square.sqrt();
        }
        let thickness_nm = self.constant_nm.unwrap_or(thickness_nm).max(0.0);
        let reflect = [0, 1, 2].map(|c| self.channels[c].reflect(mu.clamp(1e-5, 1.0), thickness_nm));
        Split { reflect, transmit: reflect.map(|r| 1.0 - r) }
    }

    #[inline]
    pub(super) fn average(&self, side: Side, thickness_nm: f32) -> [f32; 3] {
        let value = |row: usize| self.averages.get(row).map_or([0.0; 3], |pair| pair[(side == Side::Inside) as usize]);
        self.axis.place(thickness_nm).between(value)
    }

    fn row_averages(&self, row: usize, range: Range) -> [[f32; 3]; 2] {
        let thickness_nm = self.axis.thickness_nm(row, range.min_nm) as f32;
        let mut rare = [0.0f32; 3];
        for &(mu, weight) in gauss_legendre() {
            let reflect = self.split(self.rare, mu as f32, thickness_nm).reflect;
            rare = std::array::from_fn(|c| rare[c] + (2.0 * weight * mu) as f32 * reflect[c]);
        }
        let dense = rare.map(|rare| if self.opaque { 1.0 } else { 1.0 - (1.0 - rare) / self.ratio });
        if self.rare == Side::Outside { [rare, dense] } else { [dense, rare] }
    }
}

impl Channel {
    #[inline(always)]
    fn reflect(&self, mu: f32, thickness_nm: f32) -> f32 {
        let q0 = self.n0 * mu;
        let w =
            |n: Complex| Complex::new((n.re - self.n0) * (n.re + self.n0) - n.im * n.im + q0 * q0, 2.0 * n.re * n.im);
        let (e1, e2) = (self.n1 * self.n1, self.base.times(self.base));
        let q1 = w(Complex::new(self.n1, 0.0)).re.max(0.0).sqrt();
        let q2 = w(self.base).root();
        let path_nm = 2.0 * thickness_nm * q1;
        let (sin, cos) = sin_cos_turns(path_nm * self.per_nm);
        let carrier = Complex::new(cos, sin);
        let s = self.polarised(q0, q1, q2, carrier, path_nm);
        let p = self.polarised(mu / self.n0, q1 / e1, q2.over(e2), carrier, path_nm);
        0.5 * (s + p)
    }

    #[inline(always)]
    fn polarised(&self, y0: f32, y1: f32, y2: Complex, carrier: Complex, path_nm: f32) -> f32 {
        let r01 = (y0 - y1) / (y0 + y1);
        let r12 = Complex::new(y1 - y2.re, -y2.im).over(Complex::new(y1 + y2.re, y2.im));
        let (a, b) = (r01 * r01, r12.norm_sqr());
        let k = (1.0 - a) * (1.0 - b) / (1.0 - a * b).max(1e-9);
        let turn = r12.times(carrier).scale(-r01);
        let mut power = turn;
        let mut sum = 0.0;
        for m in 1..=TERMS {
            let (low, t) = cell(m as f32 * path_nm / STEP_NM, LAST as f32);
            let Some([below, above]) = self.envelope.get(low as usize..low as usize + 2) else { break };
            let at = |i: usize| below[i] + t * (above[i] - below[i]);
            sum += power.re * at(0) - power.im * at(1);
            power = power.times(turn);
            if power.norm_sqr() < SMALLEST * SMALLEST {
                break;
            }
        }
        1.0 - k * (1.0 + 2.0 * sum)
    }
}

/// The index as a channel sees it: the mean under its response times the white.
fn mean_index(curve: &IndexCurve, sensor: &Sensor, channel: usize) -> Complex {
    let part = |pick: fn(Complex64) -> f64| sensor.rgb_of_reflectance(|nm| pick(curve.at(nm)))[channel];
    Complex::new(part(|index| index.re).max(0.0) as f32, part(|index| index.im).max(0.0) as f32)
}

/// The transform of a channel's response times the white, without its carrier.
fn envelope(sensor: &Sensor, channel: usize) -> Vec<[f32; 2]> {
    let per_carrier = 1.0 / CHANNEL_NM[channel];
    let mut rows = vec![[0.0f32; 2]; LAST + 1];
    let mut nm = MIN_NM;
    while nm <= MAX_NM {
        let weight = sensor.reflectance_weight(nm)[channel] as f32;
        // Steps along the path turn the phase by a constant angle.
        let turn = STEP_NM * (1.0 / nm - per_carrier) as f32;
        for (step, row) in rows.iter_mut().enumerate().take(LAST) {
            let (sin, cos) = sin_cos_turns(turn * step as f32);
            row[0] += weight * cos;
            row[1] += weight * sin;
        }
        nm += 1.0;
    }
    rows
}
