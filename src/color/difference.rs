//! CIE L*a*b* and the CIEDE2000 colour difference.

use std::f64::consts::PI;
use std::sync::LazyLock;

use super::cie::{self, Matrix};
use super::emission::Emission;

/// CIE 1976 L*a*b*.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lab {
    pub l: f64,
    pub a: f64,
    pub b: f64,
}

/// Linear sRGB to XYZ, each row divided by the white, so that (1, 1, 1) gives exactly (1, 1, 1).
static TO_RELATIVE_XYZ: LazyLock<Matrix> = LazyLock::new(|| {
    let d65 = Emission::D65.spectrum();
    let white = cie::xyz(|nm| d65.at(nm), |nm| d65.at(nm));
    let to_xyz = cie::invert(cie::srgb_matrix(white));
    std::array::from_fn(|row| to_xyz[row].map(|value| value / white[row]))
});

impl Lab {
    /// From linear sRGB with (1, 1, 1) as the white. Channels may be negative or above 1: the linear part of the curve
    /// carries on below zero.
    pub fn from_linear_srgb(rgb: [f64; 3]) -> Self {
        let [x, y, z] = cie::apply(*TO_RELATIVE_XYZ, rgb).map(curve);
        Self { l: 116.0 * y - 16.0, a: 500.0 * (x - y), b: 200.0 * (y - z) }
    }
}

/// f(t) of CIE 015: a cube root with a linear foot.
fn curve(t: f64) -> f64 {
    const EDGE: f64 = 6.0 / 29.0;
    if t > EDGE * EDGE * EDGE { t.cbrt() } else { t / (3.0 * EDGE * EDGE) + 4.0 / 29.0 }
}

/// CIEDE2000 with unit weights: Sharma, Wu and Dalal, Color Research and Application 30, 21 (2005).
pub fn delta_e_2000(one: Lab, two: Lab) -> f64 {
    let chroma = |lab: Lab| lab.a.hypot(lab.b);
    let seventh = |c: f64| (c.powi(7) / (c.powi(7) + 25f64.powi(7))).sqrt();
    let stretch = 0.5 * (1.0 - seventh(0.5 * (chroma(one) + chroma(two))));
    let polar = |lab: Lab| {
        let a = lab.a * (1.0 + stretch);
        let hue = if a == 0.0 && lab.b == 0.0 { 0.0 } else { lab.b.atan2(a).rem_euclid(2.0 * PI) };
        (a.hypot(lab.b), hue)
    };
    let ((c1, h1), (c2, h2)) = (polar(one), polar(two));
    let grey = c1 * c2 == 0.0;

    let mut turn = if grey { 0.0 } else { h2 - h1 };
    if turn.abs() > PI {
        turn -= 2.0 * PI * turn.signum();
    }
    let hue = if grey {
        h1 + h2
    } else if (h1 - h2).abs() <= PI {
        0.5 * (h1 + h2)
    } else if h1 + h2 < 2.0 * PI {
        0.5 * (h1 + h2) + PI
    } else {
        0.5 * (h1 + h2) - PI
    };

    let (d_l, d_c, d_h) = (two.l - one.l, c2 - c1, 2.0 * (c1 * c2).sqrt() * (0.5 * turn).sin());
    let (l, c) = (0.5 * (one.l + two.l), 0.5 * (c1 + c2));
    let degrees = PI / 180.0;
    let t =
        1.0 - 0.17 * (hue - 30.0 * degrees).cos() + 0.24 * (2.0 * hue).cos() + 0.32 * (3.0 * hue + 6.0 * degrees).cos()
            - 0.20 * (4.0 * hue - 63.0 * degrees).cos();
    let s_l = 1.0 + 0.015 * (l - 50.0).powi(2) / (20.0 + (l - 50.0).powi(2)).sqrt();
    let (s_c, s_h) = (1.0 + 0.045 * c, 1.0 + 0.015 * c * t);
    let rotation = 60.0 * degrees * (-((hue / degrees - 275.0) / 25.0).powi(2)).exp();
    let r_t = -2.0 * seventh(c) * rotation.sin();
    let (l, c, h) = (d_l / s_l, d_c / s_c, d_h / s_h);
    (l * l + c * c + h * h + r_t * c * h).max(0.0).sqrt()
}
