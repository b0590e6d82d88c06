//! Sine, cosine and arc tangent of single precision, without calls, branches, or a range to reduce.
//!
//! The polynomials are those of the Cephes library (Moshier, sinf.c and atanf.c).

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Sine and cosine of an angle of at most pi/4 either way, to 1e-7.
#[inline]
pub fn sin_cos_eighth(angle: f32) -> (f32, f32) {
    let z = angle * angle;
    let sin = ((-1.951_529_6e-4 * z + 8.332_161e-3) * z - 0.166_666_55) * z * angle + angle;
    let cos = ((2.443_315_7e-5 * z - 1.388_731_6e-3) * z + 4.166_664_6e-2) * z * z - 0.5 * z + 1.0;
    (sin, cos)
}

/// Sine and cosine of an angle in turns, within 0..1, to 1e-7.
#[inline]
pub fn sin_cos_turn(turns: f32) -> (f32, f32) {
    // To the nearest quarter turn, exactly.
    let quarters = (4.0 * turns + 0.5) as i32;
    let (sin, cos) = sin_cos_eighth((4.0 * turns - quarters as f32) * FRAC_PI_2);
    let (sin, cos) = if quarters & 1 == 0 { (sin, cos) } else { (cos, -sin) };
    if quarters & 2 == 0 { (sin, cos) } else { (-sin, -cos) }
}

/// Angle of the point (x, y), at a distance of about 1, from the x axis, in -pi..pi to 3e-7; 0 at the origin.
#[inline]
pub fn atan2(y: f32, x: f32) -> f32 {
    let (low, high) = (y.abs().min(x.abs()), y.abs().max(x.abs()));
    // Beyond tan(pi/8) the angle to the diagonal is the smaller one.
    let beyond = low > 0.414_213_57 * high;
    let (over, under, offset) = if beyond { (low - high, low + high, FRAC_PI_4) } else { (low, high, 0.0) };
    let t = over / under.max(f32::MIN_POSITIVE);
    let z = t * t;
    let series = ((8.053_744_5e-2 * z - 0.138_776_86) * z + 0.199_777_11) * z - 0.333_329_5;
    let angle = offset + (series * z * t + t);
    let angle = if y.abs() > x.abs() { FRAC_PI_2 - angle } else { angle };
    (if x < 0.0 { PI - angle } else { angle }).copysign(y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_are_exact_enough() {
        let near = |(sin, cos): (f32, f32), angle: f64| {
            assert!(
                (f64::from(sin) - angle.sin()).abs() < 1e-7 && (f64::from(cos) - angle.cos()).abs() < 1e-7,
                "{angle}"
            );
        };
        for i in -1000..=1000 {
            let angle = FRAC_PI_4 * i as f32 / 1000.0;
            near(sin_cos_eighth(angle), f64::from(angle));
        }
        for i in 0..=100_000 {
            let turns = i as f32 / 100_000.0;
            near(sin_cos_turn(turns), f64::from(turns) * std::f64::consts::TAU);
        }
        assert!(sin_cos_turn(0.5 - f32::EPSILON / 4.0).0 > 0.0);
    }

    #[test]
    fn arc_tangents_are_exact_enough() {
        for i in 0..100_000 {
            let angle = (f64::from(i) / 50_000.0 - 1.0) * std::f64::consts::PI;
            let (y, x) = (angle.sin() as f32, angle.cos() as f32);
            assert!((f64::from(atan2(y, x)) - f64::from(y).atan2(f64::from(x))).abs() < 3e-7, "{angle}");
        }
        assert_eq!((atan2(0.0, 0.0), atan2(0.0, 1.0), atan2(1.0, 0.0)), (0.0, 0.0, FRAC_PI_2));
        assert!((f64::from(atan2(1e-20, 1.0)) - 1e-20).abs() < 1e-27);
    }
}
