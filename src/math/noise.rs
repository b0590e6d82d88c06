//! Improved Perlin noise. Perlin 2002, "Improving Noise". Our own, so that pictures do not change with a library.

use glam::Vec3;

/// Gradient noise in about [-1, 1] at `p`, zero at lattice points; `seed` picks another lattice of gradients.
pub fn perlin(p: Vec3, seed: u32) -> f32 {
    // Beyond 2^23 an f32 has no fraction left, and the noise is zero.
    let cell = p.floor();
    let f = p - cell;
    let [x, y, z] = [cell.x as i32, cell.y as i32, cell.z as i32];
    let fade = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let corner = |dx: i32, dy: i32, dz: i32| {
        let hash = lattice_hash(x.wrapping_add(dx), y.wrapping_add(dy), z.wrapping_add(dz), seed);
        gradient(hash, f - Vec3::new(dx as f32, dy as f32, dz as f32))
    };
    let lerp = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let row = |dy: i32, dz: i32| lerp(corner(0, dy, dz), corner(1, dy, dz), fade.x);
    lerp(lerp(row(0, 0), row(1, 0), fade.y), lerp(row(0, 1), row(1, 1), fade.y), fade.z)
}

/// Dot product with one of Perlin's twelve edge directions (four of them doubled to make sixteen).
fn gradient(hash: u32, d: Vec3) -> f32 {
    let h = hash & 15;
    let u = if h < 8 { d.x } else { d.y };
    let v = if h < 4 {
        d.y
    } else if h == 12 || h == 14 {
        d.x
    } else {
        d.z
    };
    (if h & 1 == 0 { u } else { -u }) + (if h & 2 == 0 { v } else { -v })
}

/// An integer hash in place of Perlin's permutation table: no period, any seed.
fn lattice_hash(x: i32, y: i32, z: i32, seed: u32) -> u32 {
    let mut h = (x as u32).wrapping_mul(0x8da6_b343)
        ^ (y as u32).wrapping_mul(0xd816_3841)
        ^ (z as u32).wrapping_mul(0xcb1a_b31f)
        ^ seed.wrapping_mul(0x9e37_79b9);
    h = (h ^ (h >> 16)).wrapping_mul(0x7feb_352d);
    h = (h ^ (h >> 15)).wrapping_mul(0x846c_a68b);
    h ^ (h >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_bounded_continuous_and_zero_on_the_lattice() {
        let mut largest = 0.0f32;
        for i in 0..20_000 {
            let t = i as f32 * 0.0137;
            let p = Vec3::new(t, 3.7 - 0.31 * t, 0.77 * t);
            let here = perlin(p, 7);
            largest = largest.max(here.abs());
            assert!((here - perlin(p + Vec3::splat(1e-4), 7)).abs() < 2e-3);
        }
        assert!((0.6..=1.1).contains(&largest), "largest {largest}");
        assert_eq!(perlin(Vec3::new(3.0, -2.0, 5.0), 1), 0.0);
        assert_ne!(perlin(Vec3::splat(0.4), 1), perlin(Vec3::splat(0.4), 2));
    }
}
