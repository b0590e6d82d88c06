//! Values that travel side by side.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Mul, MulAssign};

/// A fixed number of values that are transported side by side: colour channels or wavelengths.
pub trait Lanes:
    Copy
    + Debug
    + Send
    + Sync
    + PartialEq
    + Add<Output = Self>
    + AddAssign
    + Mul<Output = Self>
    + MulAssign
    + Mul<f32, Output = Self>
    + 'static
{
    const ZERO: Self;
    const ONE: Self;
    fn splat(value: f32) -> Self;
    fn mean(&self) -> f32;
    fn max(&self) -> f32;
    fn is_finite(&self) -> bool;
    fn map(self, f: impl Fn(f32) -> f32) -> Self;
    /// Lane by lane.
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self;
    fn is_black(&self) -> bool {
        *self == Self::ZERO
    }
}

/// `N` lanes in an array that the compiler keeps in vector registers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wide<const N: usize>(pub [f32; N]);

impl<const N: usize> Lanes for Wide<N> {
    const ZERO: Self = Self([0.0; N]);
    const ONE: Self = Self([1.0; N]);

    #[inline]
    fn splat(value: f32) -> Self {
        Self([value; N])
    }

    #[inline]
    fn mean(&self) -> f32 {
        self.0.iter().sum::<f32>() * (1.0 / N as f32)
    }

    #[inline]
    fn max(&self) -> f32 {
        self.0.iter().fold(f32::NEG_INFINITY, |a, &b| a.max(b))
    }

    #[inline]
    fn is_finite(&self) -> bool {
        // 0 * x is NaN exactly when x is not finite; a sum needs no branches.
        self.0.iter().map(|x| x * 0.0).sum::<f32>() == 0.0
    }

    #[inline]
    fn map(self, f: impl Fn(f32) -> f32) -> Self {
        Self(self.0.map(f))
    }

    #[inline]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }
}

impl<const N: usize> Add for Wide<N> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl<const N: usize> Mul for Wide<N> {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] * other.0[i]))
    }
}

impl<const N: usize> Mul<f32> for Wide<N> {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f32) -> Self {
        Self(self.0.map(|x| x * factor))
    }
}

impl<const N: usize> AddAssign for Wide<N> {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const N: usize> MulAssign for Wide<N> {
    #[inline]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}
