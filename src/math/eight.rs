//! Eight vectors at once, for what is computed alike for all paths of a group.

use std::ops::{Add, Mul, Sub};

use glam::Vec3;
use wide::f32x8;

/// Eight vectors, each coordinate of all side by side. Sums are taken in glam's order, so the bits are those of [`Vec3`].
#[derive(Clone, Copy, Debug)]
pub struct Vec3x8 {
    pub x: f32x8,
    pub y: f32x8,
    pub z: f32x8,
}

impl Vec3x8 {
    #[inline]
    pub fn splat(v: Vec3) -> Self {
        Self { x: f32x8::splat(v.x), y: f32x8::splat(v.y), z: f32x8::splat(v.z) }
    }

    #[inline]
    pub fn lane(&self, lane: usize) -> Vec3 {
        let [x, y, z] = [&self.x, &self.y, &self.z].map(|numbers| numbers.as_array_ref()[lane]);
        Vec3::new(x, y, z)
    }

    #[inline]
    pub fn dot(self, rhs: Self) -> f32x8 {
        self.x * rhs.x + self.y * rhs.y + self.z * rhs.z
    }

    #[inline]
    pub fn length_squared(self) -> f32x8 {
        self.dot(self)
    }
}

impl From<[Vec3; 8]> for Vec3x8 {
    #[inline]
    fn from(vectors: [Vec3; 8]) -> Self {
        let [x, y, z] = [|v: Vec3| v.x, |v: Vec3| v.y, |v: Vec3| v.z].map(|of| f32x8::new(vectors.map(of)));
        Self { x, y, z }
    }
}

impl Add for Vec3x8 {
    type Output = Self;
    #[inline]
    fn add(self, rhs: Self) -> Self {
        Self { x: self.x + rhs.x, y: self.y + rhs.y, z: self.z + rhs.z }
    }
}

impl Sub for Vec3x8 {
    type Output = Self;
    #[inline]
    fn sub(self, rhs: Self) -> Self {
        Self { x: self.x - rhs.x, y: self.y - rhs.y, z: self.z - rhs.z }
    }
}

impl Mul<f32x8> for Vec3x8 {
    type Output = Self;
    #[inline]
    fn mul(self, rhs: f32x8) -> Self {
        Self { x: self.x * rhs, y: self.y * rhs, z: self.z * rhs }
    }
}

/// The numbers of the bits that are set, lowest first.
#[inline]
pub fn set_bits(mut mask: u8) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lowest = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (lowest < 8).then_some(lowest)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_vectors_have_the_bits_of_one() {
        let [a, b] = [0.3, 1.7].map(|k: f32| {
            std::array::from_fn(|i| Vec3::new(i as f32 * k, 0.1 - k * k * i as f32, (i as f32 + k).sqrt()))
        });
        let (eight_a, eight_b) = (Vec3x8::from(a), Vec3x8::from(b));
        let [sum, difference] = [eight_a + eight_b, eight_a - eight_b];
        let scaled = eight_a * eight_b.length_squared();
        for i in 0..8 {
            assert_eq!(eight_a.dot(eight_b).to_array()[i], a[i].dot(b[i]));
            assert_eq!((sum.lane(i), difference.lane(i)), (a[i] + b[i], a[i] - b[i]));
            assert_eq!(scaled.lane(i), a[i] * b[i].length_squared());
            assert_eq!(Vec3x8::splat(a[i]).lane(7 - i), a[i]);
        }
    }

    #[test]
    fn bits_come_in_order() {
        for mask in 0..=u8::MAX {
            assert!(set_bits(mask).eq((0..8).filter(|bit| mask >> bit & 1 == 1)));
        }
    }
}
