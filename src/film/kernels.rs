//! The f32 forms of `exact`, over lanes of wavelengths. Each is one branch-free body in a loop over lanes.
//!
//! Three forms, each exact where it applies:
//! - one lossless layer between lossless media: all real, one sin^2 and one division per lane;
//! - one lossless layer on an absorbing base: the layer's step is real, its fields complex;
//! - everything else: `exact`'s walk, with the real step for the layers that are lossless.
//!
//! The real step is `exact`'s with the common phase taken out: with C = cos(k0 d q) and sigma = sin(k0 d q)/q,
//!
//!   U' = C U - i sigma c V,  V' = C V - i sigma b U
//!
//! and for an evanescent layer C = cosh, sigma = sinh/|q|, both times exp(-k0 d |q|).

use std::f32::consts::TAU;

use super::lanes::{Complex, at_least, exp_negative, fade, phi, sin_cos_turns, sin_square_turns};
use super::stack::Split;

/// n + ik of one medium at N wavelengths.
#[derive(Clone, Copy, Debug)]
pub(super) struct Medium<const N: usize> {
    pub n: [f32; N],
    pub k: [f32; N],
}

/// Light on its way to a surface: the real index around it and the cosine.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beam<const N: usize> {
    n0: [f32; N],
    mu: f32,
}

/// Below this cosine |D|^2 leaves the range of f32.
const MIN_COS: f32 = 1e-6;

impl<const N: usize> Beam<N> {
    #[inline(always)]
    pub(super) fn new(incident: &Medium<N>, cos_i: f32) -> Self {
        Self { n0: incident.n.map(|n| at_least(n, 1e-3)), mu: cos_i.abs().clamp(MIN_COS, 1.0) }
    }

    /// Is a layer of real index evanescent at any of the wavelengths?
    #[inline(always)]
    fn evanescent(&self, layer: &Medium<N>) -> bool {
        // The sign bits together: a reduction that vectorises.
        let mut bits = 0;
        for i in 0..N {
            bits |= wave_real(layer.n[i], self.n0[i], self.n0[i] * self.mu).to_bits();
        }
        bits >> 31 != 0
    }
}

/// q^2 in a medium of real index.
#[inline(always)]
fn wave_real(n: f32, n0: f32, q0: f32) -> f32 {
    (n - n0) * (n + n0) + q0 * q0
}

/// q^2 in a medium and its n^2.
#[inline(always)]
fn wave(n: f32, k: f32, n0: f32, q0: f32) -> (Complex, Complex) {
    let twice = 2.0 * n * k;
    (Complex::new(wave_real(n, n0, q0) - k * k, twice), Complex::new(n * n - k * k, twice))
}

/// N and D of one polarisation from the fields on top.
#[inline(always)]
fn ends(y0: f32, u: Complex, v: Complex) -> (f32, f32) {
    let u = u.scale(y0);
    (u.minus(v).norm_sqr(), u.plus(v).norm_sqr())
}

/// Fresnel reflection of a bare surface.
#[inline(always)]
pub(super) fn interface<const N: usize>(beam: &Beam<N>, base: &Medium<N>) -> Split<[f32; N]> {
    let mut split = Split { reflect: [0.0; N], transmit: [0.0; N] };
    let one = Complex::new(1.0, 0.0);
    for i in 0..N {
        let n0 = beam.n0[i];
        let q0 = n0 * beam.mu;
        let (q2, square) = wave(base.n[i], base.k[i], n0, q0);
        let ys = q2.root();
        let yp = ys.over(square);
        let (back_s, forth_s) = ends(q0, one, ys);
        let (back_p, forth_p) = ends(beam.mu / n0, one, yp);
        split.reflect[i] = 0.5 * (back_s / forth_s + back_p / forth_p);
        split.transmit[i] = 2.0 * (q0 * ys.re / forth_s + beam.mu / n0 * yp.re / forth_p);
    }
    split
}

/// R of one lossless layer between lossless media, `depth` = thickness / wavelength. All real, one division:
///
///   R = N/D,  D = N + 4 a b,  N = (a - b)^2 + K S,  S = (sin(k0 d q1)/q1)^2
///   s: a = q0, b = q2, K = (n1^2 - n0^2)(n1^2 - n2^2)
///   p: a = q0 n2^2, b = q2 n0^2, K times P0 P2 / n1^4, P_j = n_j^2 n1^2 - n0^2 (1 - mu^2)(n_j^2 + n1^2)
#[inline(always)]
pub(super) fn dielectric_film<const N: usize>(
    beam: &Beam<N>,
    layer: &Medium<N>,
    depth: &[f32; N],
    base: &Medium<N>,
) -> [f32; N] {
    if beam.evanescent(layer) {
        dielectric_lanes::<N, true>(beam, layer, depth, base)
    } else {
        dielectric_lanes::<N, false>(beam, layer, depth, base)
    }
}

#[inline(always)]
fn dielectric_lanes<const N: usize, const EVANESCENT: bool>(
    beam: &Beam<N>,
    layer: &Medium<N>,
    depth: &[f32; N],
    base: &Medium<N>,
) -> [f32; N] {
    let mut reflect = [0.0; N];
    let sine_square = (1.0 - beam.mu) * (1.0 + beam.mu);
    for i in 0..N {
        let (n0, n1, n2) = (beam.n0[i], layer.n[i], base.n[i]);
        let (e0, e1, e2) = (n0 * n0, n1 * n1, n2 * n2);
        let q0 = n0 * beam.mu;
        let (w1, w2) = (wave_real(n1, n0, q0), wave_real(n2, n0, q0));
        let q1 = w1.abs().sqrt();
        let (mut s, mut decay) = (sin_square_turns(depth[i] * q1) / at_least(q1 * q1, 1e-12), 1.0);
        // The layer's critical angle: sin(x q)/q -> x.
        let limit = TAU * depth[i];
        s = if q1 < 1e-6 { limit * limit } else { s };
        if EVANESCENT {
            let x = 2.0 * limit * q1;
            let exp = exp_negative(x);
            let sinh = limit * fade(x, exp);
            s = if w1 < 0.0 { sinh * sinh } else { s };
            decay = if w1 < 0.0 { exp } else { 1.0 };
        }
        let q2 = at_least(w2, 0.0).sqrt();
        let ks = (n1 - n0) * (n1 + n0) * (n1 - n2) * (n1 + n2) * s;
        let lateral = e0 * sine_square;
        let kp = ks * (e0 * e1 - lateral * (e0 + e1)) * (e2 * e1 - lateral * (e2 + e1));
        // The p terms are multiplied by n1^4 instead of dividing K.
        let (a, b) = (e1 * e2 * q0, e1 * e0 * q2);
        let (num_s, num_p) = ((q0 - q2) * (q0 - q2) * decay + ks, (a - b) * (a - b) * decay + kp);
        let (den_s, den_p) = (num_s + 4.0 * q0 * q2 * decay, num_p + 4.0 * a * b * decay);
        let r = 0.5 * (num_s * den_p + num_p * den_s) / (den_s * den_p);
        // Total reflection at the exit.
        reflect[i] = if w2 <= 0.0 { 1.0 } else { r };
    }
    reflect
}

/// What a lossless layer does to the fields: C, sigma, and the loss factor of an evanescent one.
#[inline(always)]
fn real_layer<const EVANESCENT: bool>(w: f32, depth: f32) -> (f32, f32, f32) {
    let q = w.abs().sqrt();
    let (sin, cos) = sin_cos_turns(depth * q);
    // sin(x q)/q is good to rounding down to q = 1e-9; below, its limit.
    let (c, sigma) = (cos, if q > 1e-9 { sin / at_least(q, 1e-9) } else { TAU * depth });
    if !EVANESCENT {
        return (c, sigma, 1.0);
    }
    let x = 2.0 * TAU * depth * q;
    let exp = exp_negative(x);
    let beyond = w < 0.0;
    (
        if beyond { 0.5 + 0.5 * exp } else { c },
        if beyond { TAU * depth * fade(x, exp) } else { sigma },
        if beyond { exp } else { 1.0 },
    )
}

/// R of one lossless layer on an absorbing base, `depth` = thickness / wavelength.
#[inline(always)]
pub(super) fn film_on_metal<const N: usize>(
    beam: &Beam<N>,
    layer: &Medium<N>,
    depth: &[f32; N],
    base: &Medium<N>,
) -> [f32; N] {
    if beam.evanescent(layer) {
        metal_lanes::<N, true>(beam, layer, depth, base)
    } else {
        metal_lanes::<N, false>(beam, layer, depth, base)
    }
}

#[inline(always)]
fn metal_lanes<const N: usize, const EVANESCENT: bool>(
    beam: &Beam<N>,
    layer: &Medium<N>,
    depth: &[f32; N],
    base: &Medium<N>,
) -> [f32; N] {
    let mut reflect = [0.0; N];
    for i in 0..N {
        let n0 = beam.n0[i];
        let q0 = n0 * beam.mu;
        let e1 = layer.n[i] * layer.n[i];
        let w1 = wave_real(layer.n[i], n0, q0);
        let (c, sigma, _) = real_layer::<EVANESCENT>(w1, depth[i]);
        let (q2, e2) = wave(base.n[i], base.k[i], n0, q0);
        let ys = q2.root();
        let us = Complex::new(c + sigma * ys.im, -sigma * ys.re);
        let vs = Complex::new(c * ys.re, c * ys.im - sigma * w1);
        // p, times n0 n1^2 |e2|^2, which spares the divisions.
        let size = e2.norm_sqr();
        let yp = ys.times(Complex::new(e2.re, -e2.im)).scale(e1);
        let up = Complex::new(c * size + sigma * yp.im, -sigma * yp.re).scale(e1);
        let vp = Complex::new(c * yp.re, c * yp.im - sigma * w1 * size).scale(n0);
        let (back_s, forth_s) = ends(q0, us, vs);
        let (back_p, forth_p) = ends(beam.mu, up, vp);
        reflect[i] = 0.5 * (back_s / forth_s + back_p / forth_p);
    }
    reflect
}

/// Complex numbers in lanes.
#[derive(Clone, Copy)]
struct Lanes<const N: usize> {
    re: [f32; N],
    im: [f32; N],
}

impl<const N: usize> Lanes<N> {
    #[inline(always)]
    fn real(value: f32) -> Self {
        Self { re: [value; N], im: [0.0; N] }
    }

    #[inline(always)]
    fn get(&self, i: usize) -> Complex {
        Complex::new(self.re[i], self.im[i])
    }

    #[inline(always)]
    fn set(&mut self, i: usize, value: Complex) {
        self.re[i] = value.re;
        self.im[i] = value.im;
    }
}

/// The fields of one polarisation on the way up, and what T has been scaled by.
#[derive(Clone, Copy)]
struct Fields<const N: usize> {
    u: Lanes<N>,
    v: Lanes<N>,
    power: [f32; N],
}

impl<const N: usize> Fields<N> {
    /// Scales to unit size: deep stop bands and opaque layers drive the fields out of the range of f32.
    #[inline(always)]
    fn rescale(&mut self) {
        for i in 0..N {
            let (u, v) = (self.u.get(i), self.v.get(i));
            let scale = 1.0 / (u.re.abs() + u.im.abs() + v.re.abs() + v.im.abs());
            self.u.set(i, u.scale(scale));
            self.v.set(i, v.scale(scale));
            self.power[i] *= scale * scale;
        }
    }
}

/// One layer of a stack at N wavelengths.
pub(super) struct Sheet<const N: usize> {
    pub medium: Medium<N>,
    /// Thickness / wavelength.
    pub depth: [f32; N],
}

impl<const N: usize> Medium<N> {
    /// k = 0 at all of the wavelengths.
    #[inline(always)]
    fn lossless(&self) -> bool {
        // As with `evanescent`: bits are or-ed without a branch.
        self.k.iter().fold(0, |bits, k| bits | k.to_bits()) == 0
    }
}

/// Any number of layers, absorbing or not: `sheet(j)` is the j-th, counted from the side that the light comes from.
#[inline(always)]
pub(super) fn layers<const N: usize>(
    beam: &Beam<N>,
    count: usize,
    sheet: impl Fn(usize) -> Sheet<N>,
    base: &Medium<N>,
) -> Split<[f32; N]> {
    let start = Fields { u: Lanes::real(1.0), v: Lanes::real(0.0), power: [0.0; N] };
    let (mut s, mut p) = (start, start);
    for i in 0..N {
        let n0 = beam.n0[i];
        let (q2, square) = wave(base.n[i], base.k[i], n0, n0 * beam.mu);
        let y = q2.root();
        s.v.set(i, y);
        p.v.set(i, y.over(square));
        s.power[i] = 4.0 * n0 * beam.mu * s.v.re[i];
        p.power[i] = 4.0 * beam.mu / n0 * p.v.re[i];
    }
    for j in (0..count).rev() {
        let sheet = sheet(j);
        match (sheet.medium.lossless(), beam.evanescent(&sheet.medium)) {
            (true, false) => real_step::<N, false>(beam, &sheet, &mut s, &mut p),
            (true, true) => real_step::<N, true>(beam, &sheet, &mut s, &mut p),
            (false, _) => step(beam, &sheet, &mut s, &mut p),
        }
        if j % 8 == 7 {
            s.rescale();
            p.rescale();
        }
    }
    let mut split = Split { reflect: [0.0; N], transmit: [0.0; N] };
    for i in 0..N {
        let (back_s, forth_s) = ends(beam.n0[i] * beam.mu, s.u.get(i), s.v.get(i));
        let (back_p, forth_p) = ends(beam.mu / beam.n0[i], p.u.get(i), p.v.get(i));
        let (scale_s, scale_p) = (0.5 / forth_s, 0.5 / forth_p);
        split.reflect[i] = back_s * scale_s + back_p * scale_p;
        split.transmit[i] = s.power[i] * scale_s + p.power[i] * scale_p;
    }
    split
}

/// A lossless layer.
#[inline(always)]
fn real_step<const N: usize, const EVANESCENT: bool>(
    beam: &Beam<N>,
    sheet: &Sheet<N>,
    s: &mut Fields<N>,
    p: &mut Fields<N>,
) {
    for i in 0..N {
        let w = wave_real(sheet.medium.n[i], beam.n0[i], beam.n0[i] * beam.mu);
        let square = sheet.medium.n[i] * sheet.medium.n[i];
        let (c, sigma, loss) = real_layer::<EVANESCENT>(w, sheet.depth[i]);
        for (fields, up, down) in [(&mut *s, sigma, sigma * w), (&mut *p, sigma * square, sigma * w / square)] {
            let (u, v) = (fields.u.get(i), fields.v.get(i));
            fields.u.set(i, Complex::new(c * u.re + up * v.im, c * u.im - up * v.re));
            fields.v.set(i, Complex::new(c * v.re + down * u.im, c * v.im - down * u.re));
            fields.power[i] *= loss;
        }
    }
}

/// An absorbing layer: `exact`'s step.
#[inline(always)]
fn step<const N: usize>(beam: &Beam<N>, sheet: &Sheet<N>, s: &mut Fields<N>, p: &mut Fields<N>) {
    for i in 0..N {
        let n0 = beam.n0[i];
        let (w, square) = wave(sheet.medium.n[i], sheet.medium.k[i], n0, n0 * beam.mu);
        let q = w.root();
        let depth = sheet.depth[i];
        // z = 2 i k0 d q
        let (phi, exp, size) = phi(2.0 * TAU * depth * q.im, 2.0 * depth * q.re);
        let a = Complex::new(0.5 + 0.5 * exp.re, 0.5 * exp.im);
        // g = -i k0 d phi
        let g = Complex::new(TAU * depth * phi.im, -TAU * depth * phi.re);
        let gw = g.times(w);
        for (fields, up, down) in [(&mut *s, g, gw), (&mut *p, g.times(square), gw.over(square))] {
            let (u, v) = (fields.u.get(i), fields.v.get(i));
            fields.u.set(i, a.times(u).plus(up.times(v)));
            fields.v.set(i, a.times(v).plus(down.times(u)));
            fields.power[i] *= size;
        }
    }
}
