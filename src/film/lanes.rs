//! Branch-free f32 functions that the compiler vectorises inside loops over lanes: no calls into the mathematical library,
//! no table look-ups, every choice a select.

/// Adding and subtracting it rounds |x| < 2^22 to the nearest integer, and leaves that integer in the low bits.
const ROUNDER: f32 = 12_582_912.0;

/// max and min as the processor has them: one instruction; NaN becomes the limit.
#[inline(always)]
pub(super) fn at_least(x: f32, limit: f32) -> f32 {
    if x > limit { x } else { limit }
}

#[inline(always)]
pub(super) fn at_most(x: f32, limit: f32) -> f32 {
    if x < limit { x } else { limit }
}

/// The cell and the place in it of `x`, clamped to 0..`span` (whole, below 2^19): a rounding by addition is several times as
/// fast as a checked conversion. On the border of two cells either may be given; the last one ends a millionth early.
#[inline(always)]
pub(super) fn cell(x: f32, span: f32) -> (u32, f32) {
    let x = at_most(at_least(x, 0.0), span * (1.0 - 1e-6));
    let shifted = (x - 0.5) + ROUNDER;
    (shifted.to_bits() & 0x3f_ffff, x - (shifted - ROUNDER))
}

/// (sin, cos) of 2 pi `turns`, for |turns| < 2^21. Maximum absolute error 2e-7 over the range reduction, which is exact: the
/// argument's own rounding is what remains for many turns.
#[inline(always)]
pub(super) fn sin_cos_turns(turns: f32) -> (f32, f32) {
    // Half turns change the sign only.
    let shifted = 2.0 * turns + ROUNDER;
    let sign = (shifted.to_bits() & 1) << 31;
    let x = turns - 0.5 * (shifted - ROUNDER);
    let u = x * x;
    // Minimax on |x| <= 1/4: errors 3e-9 and 2e-10.
    let sin = x * (std::f32::consts::TAU + u * (-41.341_656 + u * (81.601_005 + u * (-76.549_78 + u * 39.536_7))));
    let cos = 1.0 + u * (-19.739_208 + u * (64.939_35 + u * (-85.453_57 + u * (60.144_016 + u * -24.982_238))));
    (f32::from_bits(sin.to_bits() ^ sign), f32::from_bits(cos.to_bits() ^ sign))
}

/// sin^2 of 2 pi `turns`, for |turns| < 2^21. Maximum error 2e-7, relative for small arguments.
#[inline(always)]
pub(super) fn sin_square_turns(turns: f32) -> f32 {
    let x = turns - 0.5 * ((2.0 * turns + ROUNDER) - ROUNDER);
    let u = x * x;
    let sin = std::f32::consts::TAU + u * (-41.341_656 + u * (81.601_005 + u * (-76.549_78 + u * 39.536_7)));
    u * sin * sin
}

/// exp(-x) for x >= 0. Maximum relative error 3e-7 for x < 80; smaller than 1e-34 beyond.
#[inline(always)]
pub(super) fn exp_negative(x: f32) -> f32 {
    // exp(-x) = 2^whole * 2^part. The product below is split in two, so that large x keeps its fraction.
    let power = at_least(x * -std::f32::consts::LOG2_E, -126.0);
    let shifted = power + ROUNDER;
    let whole = shifted - ROUNDER;
    let part = power - whole;
    // Minimax on |part| <= 1/2: relative error 2e-9.
    let fraction = 1.0
        + part
            * (std::f32::consts::LN_2
                + part
                    * (0.240_226_47
                        + part
                            * (0.055_503_29 + part * (0.009_618_489 + part * (0.001_339_993 + part * 0.000_153_458)))));
    let scale = f32::from_bits((shifted.to_bits().wrapping_sub(ROUNDER.to_bits()).wrapping_add(127)) << 23);
    fraction * scale
}

/// (1 - exp(-x))/x for x >= 0, without cancellation near 0; `exp` is exp(-x).
#[inline(always)]
pub(super) fn fade(x: f32, exp: f32) -> f32 {
    let series = 1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x * (1.0 / 120.0 - x / 720.0))));
    let quotient = (1.0 - exp) / at_least(x, 0.1);
    if x < 0.3 { series } else { quotient }
}

/// A complex number in one lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Complex {
    pub re: f32,
    pub im: f32,
}

impl Complex {
    #[inline(always)]
    pub(super) fn new(re: f32, im: f32) -> Self {
        Self { re, im }
    }

    #[inline(always)]
    pub(super) fn plus(self, other: Self) -> Self {
        Self::new(self.re + other.re, self.im + other.im)
    }

    #[inline(always)]
    pub(super) fn minus(self, other: Self) -> Self {
        Self::new(self.re - other.re, self.im - other.im)
    }

    #[inline(always)]
    pub(super) fn times(self, other: Self) -> Self {
        Self::new(self.re * other.re - self.im * other.im, self.re * other.im + self.im * other.re)
    }

    #[inline(always)]
    pub(super) fn scale(self, factor: f32) -> Self {
        Self::new(self.re * factor, self.im * factor)
    }

    #[inline(always)]
    pub(super) fn norm_sqr(self) -> f32 {
        self.re * self.re + self.im * self.im
    }

    #[inline(always)]
    pub(super) fn over(self, other: Self) -> Self {
        let scale = 1.0 / other.norm_sqr();
        Self::new((self.re * other.re + self.im * other.im) * scale, (self.im * other.re - self.re * other.im) * scale)
    }

    /// The square root in the first quadrant, for an imaginary part >= 0.
    #[inline(always)]
    pub(super) fn root(self) -> Self {
        let large = (0.5 * (self.norm_sqr().sqrt() + self.re.abs())).sqrt();
        let small = 0.5 * self.im / at_least(large, 1e-18);
        if self.re >= 0.0 { Self::new(large, small) } else { Self::new(small, large) }
    }
}

/// (exp(z) - 1)/z for Re z <= 0, z = -decay + 2 pi i turns; exp(z); and |exp(z)|.
#[inline(always)]
pub(super) fn phi(decay: f32, turns: f32) -> (Complex, Complex, f32) {
    let (sin, cos) = sin_cos_turns(turns);
    let size = exp_negative(decay);
    let exp = Complex::new(size * cos, size * sin);
    let z = Complex::new(-decay, std::f32::consts::TAU * turns);
    let near = z.norm_sqr() < 0.04;
    // The quotient is not used near 0; keep its denominator away from it.
    let safe = Complex::new(if near { 1.0 } else { z.re }, z.im);
    let quotient = Complex::new(exp.re - 1.0, exp.im).over(safe);
    let mut series = Complex::new(1.0, 0.0);
    for order in [6.0f32, 5.0, 4.0, 3.0, 2.0] {
        series = series.times(z.scale(1.0 / order)).plus(Complex::new(1.0, 0.0));
    }
    let phi = Complex::new(if near { series.re } else { quotient.re }, if near { series.im } else { quotient.im });
    (phi, exp, size)
}
