//! The yardstick: reflectance and transmittance of any stack, in f64.
//!
//! Abeles' characteristic form, walked from the base up, written so that no exponential ever grows and no wave component
//! divides. With exp(-iwt), n + ik, k0 = 2 pi / lambda, and the normal wave component in units of k0
//!
//!   q_j^2 = (n_j - n_0)(n_j + n_0) + (n_0 mu)^2,  Im q_j >= 0      (no cancellation at grazing or at index match)
//!
//! the tangential fields (U, V) at the top of a layer of thickness d follow from those at its bottom by
//!
//!   U' = A U + c g V,   V' = b g U + A V
//!   E = exp(2 i k0 d q),  A = (1 + E)/2,  g = -i k0 d phi(2 i k0 d q),  phi(z) = (exp(z) - 1)/z
//!   s: c = 1, b = q^2;   p: c = n^2, b = q^2 / n^2
//!
//! which is the usual matrix times exp(i k0 d q). |E| <= 1 always; phi is entire, so the layer's own critical angle q = 0 is
//! an ordinary point; the wave that grows on the way up is the wanted one, so rounding errors die out. From (1, y_base),
//! with y = q (s) or q / n^2 (p),
//!
//!   N = y_0 U - V,  D = y_0 U + V,  R = |N/D|^2,  T = 4 y_0 Re(y_base) prod |E_j| / |D|^2.
//!
//! One form for dielectric, absorbing and metallic media, total and frustrated total reflection, and zero thickness.
//! Sources: Born and Wolf, Principles of Optics, 1.6 and 14.4; Byrnes, arXiv:1603.02720.

use std::f64::consts::TAU;

use num_complex::Complex64;

use super::stack::{Polarised, Side, Split, Stack};

const ONE: Complex64 = Complex64::new(1.0, 0.0);

/// Below this cosine everything is grazing: keeps 0/0 away where nothing refracts at all.
const MIN_COS: f64 = 1e-12;
/// A medium that light arrives from has a real index; a metal's n may be 0.
const MIN_INCIDENT: f64 = 1e-3;

/// R and T of a stack for light from `side` at the cosine `cos_i` (0..1, in the medium that it comes from; the sign and
/// rounding above 1 are ignored) and wavelength `nm`. `thickness_nm` is that of the varying layer, ignored when none varies;
/// negative counts as 0. T is the power that enters the last medium. Where the medium that light comes from absorbs, its
/// real part is used.
pub fn exact(stack: &Stack, side: Side, cos_i: f64, thickness_nm: f64, nm: f64) -> Polarised {
    let coated = walk(stack, stack.layers.len(), side, cos_i, thickness_nm, nm);
    if stack.weight >= 1.0 || stack.layers.is_empty() {
        return coated;
    }
    let bare = walk(stack, 0, side, cos_i, thickness_nm, nm);
    let weight = stack.weight.max(0.0);
    let mix = |a: f64, b: f64| weight * a + (1.0 - weight) * b;
    let mix = |a: Split<f64>, b: Split<f64>| Split {
        reflect: mix(a.reflect, b.reflect),
        transmit: mix(a.transmit, b.transmit),
    };
    Polarised { s: mix(coated.s, bare.s), p: mix(coated.p, bare.p) }
}

/// The fields (U, V) of one polarisation.
#[derive(Clone, Copy)]
struct Fields {
    u: Complex64,
    v: Complex64,
}

/// The first `count` layers on the base (all or none).
fn walk(stack: &Stack, count: usize, side: Side, cos_i: f64, thickness_nm: f64, nm: f64) -> Polarised {
    let (incident, last) = match side {
        Side::Outside => (&stack.outside, &stack.base),
        Side::Inside => (&stack.base, &stack.outside),
    };
    let n0 = incident.at(nm).re.max(MIN_INCIDENT);
    let q0 = n0 * cos_i.abs().clamp(MIN_COS, 1.0);
    let k0 = TAU / nm;

    let (q2, square) = wave(last.at(nm), n0, q0);
    let q = root(q2);
    let (base_s, base_p) = (q, q / square);
    let mut s = Fields { u: ONE, v: base_s };
    let mut p = Fields { u: ONE, v: base_p };
    // T shrinks by the losses on the way and by the scale that is taken out of the fields.
    let (mut loss_s, mut loss_p) = (1.0, 1.0);
    for step in 0..count {
        // From the far side of the stack towards the light.
        let layer = if side == Side::Outside { count - 1 - step } else { step };
        let (q2, square) = wave(stack.layers[layer].index.at(nm), n0, q0);
        let depth = k0 * stack.thickness(layer, thickness_nm);
        let z = 2.0 * depth * Complex64::i() * root(q2);
        let decay = z.exp();
        let a = 0.5 * (ONE + decay);
        let g = -Complex64::i() * depth * phi(z, decay);
        s = Fields { u: a * s.u + g * s.v, v: g * q2 * s.u + a * s.v };
        p = Fields { u: a * p.u + g * square * p.v, v: g * (q2 / square) * p.u + a * p.v };
        loss_s *= decay.norm() * rescale(&mut s);
        loss_p *= decay.norm() * rescale(&mut p);
    }
    Polarised { s: close(s, q0, base_s.re, loss_s), p: close(p, q0 / (n0 * n0), base_p.re, loss_p) }
}

/// q^2 of a medium, with Im >= 0, and its n^2.
fn wave(index: Complex64, n0: f64, q0: f64) -> (Complex64, Complex64) {
    let (n, k) = (index.re, index.im);
    let twice = 2.0 * n * k;
    (Complex64::new((n - n0) * (n + n0) - k * k + q0 * q0, twice), Complex64::new(n * n - k * k, twice))
}

/// The square root in the first quadrant, for Im >= 0, without cancellation.
fn root(w: Complex64) -> Complex64 {
    let norm = w.norm();
    if norm == 0.0 {
        return Complex64::new(0.0, 0.0);
    }
    let large = (0.5 * (norm + w.re.abs())).sqrt();
    let small = 0.5 * w.im / large;
    if w.re >= 0.0 { Complex64::new(large, small) } else { Complex64::new(small, large) }
}

/// (exp(z) - 1)/z, entire; `exp_z` is exp(z).
fn phi(z: Complex64, exp_z: Complex64) -> Complex64 {
    if z.norm_sqr() > 0.04 {
        return (exp_z - ONE) / z;
    }
    // Eleven terms reach 1e-17 at |z| = 0.2.
    (1..=11).rev().fold(ONE, |sum, order| ONE + sum * z / f64::from(order + 1))
}

/// Deep stop bands grow the fields; R and T only need ratios. Scales the fields to unit size where they leave the middle of
/// the range of f64, and returns the square of the scale, by which T has to be multiplied.
fn rescale(fields: &mut Fields) -> f64 {
    let size = fields.u.norm_sqr() + fields.v.norm_sqr();
    if size < 1e100 && size > 1e-100 {
        return 1.0;
    }
    let scale = size.sqrt().recip();
    fields.u *= scale;
    fields.v *= scale;
    scale * scale
}

fn close(fields: Fields, y0: f64, y_base: f64, loss: f64) -> Split<f64> {
    let (forth, back) = (y0 * fields.u + fields.v, y0 * fields.u - fields.v);
    let power = forth.norm_sqr();
    Split { reflect: back.norm_sqr() / power, transmit: 4.0 * y0 * y_base * loss / power }
}
