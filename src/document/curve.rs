//! The value of a curve at a time.

use glam::Vec2;

use super::animation::{Channel, Interpolation};

impl Channel {
    /// The row of values at a time in seconds. Before the first key and after the last the curve stays where it is.
    ///
    /// COLLADA 1.4.1 specification, chapter 4, "Curve Interpolation": LINEAR and STEP; BEZIER with control points (time,
    /// value) C0 = `out_tangents` of this key and C1 = `in_tangents` of the next; HERMITE with tangent vectors in their
    /// places.
    pub fn at(&self, time_s: f64) -> Vec<f32> {
        let key = self.times_s.partition_point(|&key_s| f64::from(key_s) <= time_s);
        let row = |key: usize| &self.values[key * self.width..(key + 1) * self.width];
        if key == 0 {
            return row(0).to_vec();
        }
        let (before, after) = (key - 1, key);
        if after == self.times_s.len() {
            return row(before).to_vec();
        }
        let segment = |component: usize| {
            let end = |key: usize| Vec2::new(self.times_s[key], row(key)[component]);
            let tangent = |list: &[Vec2], key: usize| list.get(key * self.width + component).copied();
            let (start, end) = (end(before), end(after));
            let tangents = tangent(&self.out_tangents, before).zip(tangent(&self.in_tangents, after));
            let [p0, p1, p2, p3] = match (self.interpolation[before], tangents) {
                (Interpolation::Step, _) => return start.y,
                (Interpolation::Bezier, Some((c0, c1))) => [start, c0, c1, end],
                // The same cubic: a Hermite tangent is three times the way to the control point.
                (Interpolation::Hermite, Some((t0, t1))) => [start, start + t0 / 3.0, end - t1 / 3.0, end],
                (Interpolation::Linear, _) | (_, None) => {
                    let share = (time_s - f64::from(start.x)) / f64::from(end.x - start.x);
                    return (f64::from(start.y) + share * f64::from(end.y - start.y)) as f32;
                }
            };
            let times = [p0, p1, p2, p3].map(|p| f64::from(p.x.clamp(p0.x, p3.x)));
            let share = share_at(times, time_s);
            bernstein([p0, p1, p2, p3].map(|p| f64::from(p.y)), share) as f32
        };
        (0..self.width).map(segment).collect()
    }
}

/// The parameter at which a cubic that rises from its first to its last value takes `wanted`, by bisection.
///
/// With the inner control values between the outer ones the cubic rises throughout, so there is just one.
fn share_at(values: [f64; 4], wanted: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    // Halved to the last bit of a f32 time.
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if bernstein(values, middle) < wanted { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// The cubic Bezier polynomial with these control values.
fn bernstein([a, b, c, d]: [f64; 4], t: f64) -> f64 {
    let s = 1.0 - t;
    s * s * s * a + 3.0 * s * s * t * b + 3.0 * s * t * t * c + t * t * t * d
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Quantity;

    fn curve(kind: Interpolation, keys: &[(f32, f32)], inward: &[(f32, f32)], outward: &[(f32, f32)]) -> Channel {
        let pairs = |list: &[(f32, f32)]| list.iter().map(|&p| p.into()).collect();
        Channel {
            target: String::new(),
            drives: Quantity::Transform { node: 0, transform: 0 },
            member: Some(0),
            times_s: keys.iter().map(|key| key.0).collect(),
            values: keys.iter().map(|key| key.1).collect(),
            width: 1,
            interpolation: vec![kind; keys.len()],
            in_tangents: pairs(inward),
            out_tangents: pairs(outward),
        }
    }

    fn near(channel: &Channel, form: impl Fn(f64) -> f64) {
        for step in 0..=64 {
            let time_s = 1.0 + f64::from(step) / 32.0;
            let (got, wanted) = (f64::from(channel.at(time_s)[0]), form(time_s));
            assert!((got - wanted).abs() < 2e-6, "{time_s} s: {got} instead of {wanted}");
        }
    }

    #[test]
    fn lines_and_steps() {
        let keys = [(1.0, 10.0), (3.0, 20.0)];
        near(&curve(Interpolation::Linear, &keys, &[], &[]), |t| 10.0 + 5.0 * (t - 1.0));
        near(&curve(Interpolation::Step, &keys, &[], &[]), |t| if t < 3.0 { 10.0 } else { 20.0 });
    }

    #[test]
    fn curves_hold_their_ends_and_hit_their_keys() {
        let keys = [(1.0, 10.0), (1.5, -4.0), (3.0, 20.0)];
        for kind in [Interpolation::Linear, Interpolation::Step] {
            let channel = curve(kind, &keys, &[], &[]);
            for (time_s, value) in [(-5.0, 10.0), (1.0, 10.0), (1.5, -4.0), (3.0, 20.0), (99.0, 20.0)] {
                assert_eq!(channel.at(time_s), [value], "{kind:?} at {time_s} s");
            }
        }
    }

    /// Control points at thirds of the time make time itself the parameter: any cubic can be written down.
    #[test]
    fn a_bezier_with_times_at_thirds_is_a_cubic_of_time() {
        // f(u) = 2 u^3 - 5 u^2 + u + 4 has the control values f(0), f(0) + f'(0)/3, f(1) - f'(1)/3, f(1).
        let f = |u: f64| 2.0 * u.powi(3) - 5.0 * u * u + u + 4.0;
        let third = 2.0 / 3.0;
        let (c0, c1) = ((1.0 + third, 4.0 + 1.0 / 3.0), (3.0 - third, 2.0 + 3.0 / 3.0));
        let bezier = curve(Interpolation::Bezier, &[(1.0, 4.0), (3.0, 2.0)], &[(0.0, 0.0), c1], &[c0, (0.0, 0.0)]);
        near(&bezier, |t| f(0.5 * (t - 1.0)));
        // The same as tangents: 3 (C0 - P0) and 3 (P1 - C1).
        let (t0, t1) = ((2.0, 1.0), (2.0, -3.0));
        let hermite = curve(Interpolation::Hermite, &[(1.0, 4.0), (3.0, 2.0)], &[(0.0, 0.0), t1], &[t0, (0.0, 0.0)]);
        near(&hermite, |t| f(0.5 * (t - 1.0)));
    }

    /// Ease in and out with control times other than thirds: x(s) = s^3 + 3 (1 - s) s^2 = 3 s^2 - 2 s^3 runs the time, the
    /// value runs straight in s. At s = 1/4 the time is 5/32 of the way.
    #[test]
    fn a_bezier_solves_for_its_own_time() {
        let third = 10.0 / 3.0;
        let bezier = curve(
            Interpolation::Bezier,
            &[(1.0, 0.0), (3.0, 10.0)],
            &[(0.0, 0.0), (3.0, 10.0 - third)],
            &[(1.0, third), (0.0, 0.0)],
        );
        for s in [0.25f64, 0.5, 0.75] {
            let time_s = 1.0 + 2.0 * (3.0 * s * s - 2.0 * s.powi(3));
            assert!((f64::from(bezier.at(time_s)[0]) - 10.0 * s).abs() < 1e-5, "at {s}");
        }
    }
}
