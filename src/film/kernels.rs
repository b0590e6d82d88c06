//! The f32 forms of `exact`, over lanes of wavelengths. Each is one branch-free body in a loop over lanes.
//!
//! A lossless layer needs real arithmetic only: with sigma = sin(k0 d q)/q the fields on top of it are
//!
//!   U = C - i sigma c y_base,  V = C y_base - i sigma b     (C = cos(k0 d q); evanescent: cosh and sinh/|q|, times exp(-x))
//!
//! which is `exact`'s step with the common phase taken out. It covers lossless and metallic bases alike, and R is computed
//! directly, so that it keeps its relative accuracy where it is small. Anything else walks the general step.

use std::f32::consts::TAU;

use super::lanes::{Complex, exp_negative, fade, phi, sin_cos_turns};
use super::stack::Split;

/// n + ik of one medium at N wavelengths.
#[derive(Clone, Copy, Debug)]
pub(super) struct Medium<const N: usize> {
    pub n: [f32; N],
    pub k: [f32; N],
}

/// Light on its way to a surface: the real index around it, the cosine, and 1/wavelength in 1/nm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beam<const N: usize> {
    pub n0: [f32; N],
    pub mu: f32,
    pub per_nm: [f32; N],
}

/// Below this cosine |D|^2 leaves the range of f32.
const MIN_COS: f32 = 1e-6;

impl<const N: usize> Beam<N> {
    #[inline(always)]
    pub(super) fn new(incident: &Medium<N>, cos_i: f32, per_nm: [f32; N]) -> Self {
        Self { n0: incident.n.map(|n| n.max(1e-3)), mu: cos_i.abs().clamp(MIN_COS, 1.0), per_nm }
    }
}

/// q^2 of a medium and its n^2.
#[inline(always)]
fn wave(n: f32, k: f32, n0: f32, q0: f32) -> (Complex, Complex) {
    let twice = 2.0 * n * k;
    (Complex::new((n - n0) * (n + n0) - k * k + q0 * q0, twice), Complex::new(n * n - k * k, twice))
}

/// The mean of R and T over both polarisations, from their (D, N, 4 y0 Re y_base) and the loss on the way.
#[inline(always)]
fn close(s: (Complex, Complex, f32), p: (Complex, Complex, f32), loss: f32) -> (f32, f32) {
    let (power_s, power_p) = (0.5 / s.0.norm_sqr(), 0.5 / p.0.norm_sqr());
    let reflect = s.1.norm_sqr() * power_s + p.1.norm_sqr() * power_p;
    (reflect, loss * (s.2 * power_s + p.2 * power_p))
}

/// Fresnel reflection of a bare surface.
#[inline(always)]
pub(super) fn interface<const N: usize>(beam: &Beam<N>, base: &Medium<N>) -> Split<[f32; N]> {
    let mut split = Split { reflect: [0.0; N], transmit: [0.0; N] };
    for i in 0..N {
        let n0 = beam.n0[i];
        let q0 = n0 * beam.mu;
        let (q2, square) = wave(base.n[i], base.k[i], n0, q0);
        let (y0s, y0p) = (q0, beam.mu / n0);
        let ys = q2.root();
        let yp = ys.over(square);
        let s = (Complex::new(y0s + ys.re, ys.im), Complex::new(y0s - ys.re, -ys.im), 4.0 * y0s * ys.re);
        let p = (Complex::new(y0p + yp.re, yp.im), Complex::new(y0p - yp.re, -yp.im), 4.0 * y0p * yp.re);
        (split.reflect[i], split.transmit[i]) = close(s, p, 1.0);
    }
    split
}

/// One lossless layer on any base.
#[inline(always)]
pub(super) fn lossless_film<const N: usize>(
    beam: &Beam<N>,
    layer: &Medium<N>,
    thickness_nm: f32,
    base: &Medium<N>,
    metal: bool,
) -> Split<[f32; N]> {
    let evanescent =
        (0..N).any(|i| (layer.n[i] - beam.n0[i]) * (layer.n[i] + beam.n0[i]) + (beam.n0[i] * beam.mu).powi(2) < 0.0);
    match (evanescent, metal) {
        (false, false) => film_lanes::<N, false, false>(beam, layer, thickness_nm, base),
        (false, true) => film_lanes::<N, false, true>(beam, layer, thickness_nm, base),
        (true, false) => film_lanes::<N, true, false>(beam, layer, thickness_nm, base),
        (true, true) => film_lanes::<N, true, true>(beam, layer, thickness_nm, base),
    }
}

#[inline(always)]
fn film_lanes<const N: usize, const EVANESCENT: bool, const METAL: bool>(
    beam: &Beam<N>,
    layer: &Medium<N>,
    thickness_nm: f32,
    base: &Medium<N>,
) -> Split<[f32; N]> {
    let mut split = Split { reflect: [0.0; N], transmit: [0.0; N] };
    for i in 0..N {
        let n0 = beam.n0[i];
        let q0 = n0 * beam.mu;
        let n1 = layer.n[i];
        let b_s = (n1 - n0) * (n1 + n0) + q0 * q0;
        let c_p = n1 * n1;
        let b_p = b_s / c_p;

        // The layer: C, sigma and what it lets through.
        let q1 = b_s.abs().sqrt();
        let depth = thickness_nm * beam.per_nm[i];
        let (sin, cos) = sin_cos_turns(depth * q1);
        // sin(2 pi x q)/q is exact to rounding down to q = 1e-9; below, q is taken as 1e-9.
        let (mut c, mut sigma, mut loss) = (cos, if q1 > 1e-9 { sin / q1.max(1e-9) } else { TAU * depth }, 1.0);
        if EVANESCENT {
            let x = 2.0 * TAU * depth * q1;
            let decay = exp_negative(x);
            let beyond = b_s < 0.0;
            c = if beyond { 0.5 + 0.5 * decay } else { c };
            sigma = if beyond { TAU * depth * fade(x, decay) } else { sigma };
            loss = if beyond { decay } else { 1.0 };
        }

        // The base's admittances; a lossless base has q real or imaginary.
        let (ys, yp) = if METAL {
            let (q2, square) = wave(base.n[i], base.k[i], n0, q0);
            let q = q2.root();
            (q, q.over(square))
        } else {
            let n2 = base.n[i];
            let q2 = (n2 - n0) * (n2 + n0) + q0 * q0;
            let q = Complex::new(q2.max(0.0).sqrt(), (-q2).max(0.0).sqrt());
            (q, q.scale(1.0 / (n2 * n2)))
        };
        let s = fields(q0, ys, c, sigma, sigma * b_s);
        let p = fields(beam.mu / n0, yp, c, sigma * c_p, sigma * b_p);
        (split.reflect[i], split.transmit[i]) = close(s, p, loss);
    }
    split
}

/// (D, N, 4 y0 Re y_base) of one polarisation over a lossless layer; `sigma_c` and `sigma_b` are sigma times c and b.
#[inline(always)]
fn fields(y0: f32, y: Complex, c: f32, sigma_c: f32, sigma_b: f32) -> (Complex, Complex, f32) {
    let u = Complex::new(y0 * (c + sigma_c * y.im), -y0 * sigma_c * y.re);
    let v = Complex::new(c * y.re, c * y.im - sigma_b);
    (u.plus(v), Complex::new(u.re - v.re, u.im - v.im), 4.0 * y0 * y.re)
}

/// Any number of layers, absorbing or not: `layer(j)` is the medium and thickness (nm) of the j-th, counted from the side
/// that the light comes from.
#[inline(always)]
pub(super) fn layers<const N: usize>(
    beam: &Beam<N>,
    count: usize,
    layer: impl Fn(usize) -> (Medium<N>, f32),
    base: &Medium<N>,
) -> Split<[f32; N]> {
    let zero = [Complex::new(0.0, 0.0); N];
    let one = [Complex::new(1.0, 0.0); N];
    let (mut us, mut vs, mut up, mut vp) = (one, zero, one, zero);
    let (mut loss_s, mut loss_p) = ([1.0f32; N], [1.0f32; N]);
    for i in 0..N {
        let n0 = beam.n0[i];
        let (q2, square) = wave(base.n[i], base.k[i], n0, n0 * beam.mu);
        vs[i] = q2.root();
        vp[i] = vs[i].over(square);
        loss_s[i] = 4.0 * n0 * beam.mu * vs[i].re;
        loss_p[i] = 4.0 * beam.mu / n0 * vp[i].re;
    }
    for step in (0..count).rev() {
        let (medium, thickness_nm) = layer(step);
        for i in 0..N {
            let n0 = beam.n0[i];
            let (q2, square) = wave(medium.n[i], medium.k[i], n0, n0 * beam.mu);
            let q = q2.root();
            let depth = thickness_nm * beam.per_nm[i];
            // z = 2 i k0 d q
            let (phi, exp) = phi(2.0 * TAU * depth * q.im, 2.0 * depth * q.re);
            let a = Complex::new(0.5 + 0.5 * exp.re, 0.5 * exp.im);
            // g = -i k0 d phi
            let g = Complex::new(TAU * depth * phi.im, -TAU * depth * phi.re);
            let (u, v) = (us[i], vs[i]);
            us[i] = a.times(u).plus(g.times(v));
            vs[i] = g.times(q2).times(u).plus(a.times(v));
            let (u, v) = (up[i], vp[i]);
            up[i] = a.times(u).plus(g.times(square).times(v));
            vp[i] = g.times(q2.over(square)).times(u).plus(a.times(v));
            let decay = exp.norm_sqr().sqrt();
            loss_s[i] *= decay;
            loss_p[i] *= decay;
        }
        // Deep stop bands and opaque layers drive the fields out of the range of f32.
        if step % 8 == 7 {
            rescale(&mut us, &mut vs, &mut loss_s);
            rescale(&mut up, &mut vp, &mut loss_p);
        }
    }
    let mut split = Split { reflect: [0.0; N], transmit: [0.0; N] };
    for i in 0..N {
        let n0 = beam.n0[i];
        let ends = |y0: f32, u: Complex, v: Complex, power: f32| {
            let u = u.scale(y0);
            (u.plus(v), Complex::new(u.re - v.re, u.im - v.im), power)
        };
        let s = ends(n0 * beam.mu, us[i], vs[i], loss_s[i]);
        let p = ends(beam.mu / n0, up[i], vp[i], loss_p[i]);
        (split.reflect[i], split.transmit[i]) = close(s, p, 1.0);
    }
    split
}

#[inline(always)]
fn rescale<const N: usize>(u: &mut [Complex; N], v: &mut [Complex; N], loss: &mut [f32; N]) {
    for i in 0..N {
        let scale = 1.0 / (u[i].re.abs() + u[i].im.abs() + v[i].re.abs() + v[i].im.abs());
        u[i] = u[i].scale(scale);
        v[i] = v[i].scale(scale);
        loss[i] *= scale * scale;
    }
}
