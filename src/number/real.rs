//! The scalars a formula may be written in.
//!
//! Every projection is one generic formula over [`Real`], and the compiler makes of it the f32 and
//! f64 kernels, at every instruction-set level, and (through [`crate::number::dual::Dual`]) its Jacobian.
//! For that to give the same bits everywhere, a `Real` offers only operations that IEEE 754 rounds
//! correctly (`+ - * / sqrt`, comparison, sign and exponent surgery) and functions built from them
//! in [`crate::number::math`]. There is no `mul_add` and no call into the platform's math library: the first
//! is a library call where the CPU lacks it, the second differs between platforms, and neither
//! vectorizes.
//!
//! A formula has no `if` on its numbers: a comparison gives a [`Real::Mask`], and [`Real::select`] takes one of two values that
//! are both already computed. For floats that is a `bool` and a plain `if`, which the vectorizer turns into a select; a number
//! that records what is done with it keeps both values and the condition. [`Real::either`] says the same of values that are
//! computed for it alone, and [`Real::choose`] where the compiler would make a branch of the `if`. What is decided by
//! parameters alone, which are `f64` in any formula, is an `if`.

use crate::number::math::Polynomials;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

/// [`Real::epsilon`] of f32. A formula may be shorter for numbers whose own is no smaller.
pub const SINGLE: f64 = f32::EPSILON as f64;

/// A number a formula can be written in: `f32`, `f64`, or a dual number over one of them.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + 'static
{
    /// 0.
    const ZERO: Self;

    /// ½.
    const HALF: Self;

    /// 1.
    const ONE: Self;

    /// 2.
    const TWO: Self;

    /// What is no number.
    const NAN: Self;

    /// Distance from 1 to the next larger number.
    fn epsilon() -> f64;

    /// The outcome of a comparison: `bool` for numbers, a node for numbers that record.
    type Mask: Copy
        + BitAnd<Output = Self::Mask>
        + BitOr<Output = Self::Mask>
        + BitXor<Output = Self::Mask>
        + Not<Output = Self::Mask>;

    /// The number without derivatives: what an iteration runs on until its last step.
    type Value: Real;

    /// `self` without derivatives.
    fn value(self) -> Self::Value;

    /// A constant.
    fn constant(value: Self::Value) -> Self;

    /// The constant nearest to `x`.
    fn new(x: f64) -> Self;

    /// A mask that is known beforehand.
    fn truth(value: bool) -> Self::Mask;

    /// self < other. Every comparison looks at the values only, not at derivatives, and is false where one is NaN.
    fn less(self, other: Self) -> Self::Mask;

    /// self ≤ other.
    fn at_most(self, other: Self) -> Self::Mask;

    /// self > other.
    fn more(self, other: Self) -> Self::Mask;

    /// self ≥ other.
    fn at_least(self, other: Self) -> Self::Mask;

    /// self = other.
    fn equals(self, other: Self) -> Self::Mask;

    /// Whether it is no number.
    fn is_nan(self) -> Self::Mask;

    /// |self|.
    fn abs(self) -> Self;

    /// The correctly rounded square root.
    fn sqrt(self) -> Self;

    /// The power of two that brings a positive `self` into [1, 2), or a subnormal one as near as a
    /// power of two can. Zero and infinity give a finite power as well. Of a power of two it is the
    /// inverse, but for the largest, where it is the smallest normal number. A constant to
    /// derivatives.
    fn binade_scale(self) -> Self;

    /// `self` held between two numbers. NaN stays, and so do derivatives.
    fn clamped(self, low: f64, high: f64) -> Self;

    /// -self where the condition holds.
    fn negated_if(self, condition: Self::Mask) -> Self;

    /// `a` where the condition holds, else `b`.
    fn select(condition: Self::Mask, a: Self, b: Self) -> Self;

    /// The same of values that are computed for it alone: both are, but by a number that counts steps.
    #[inline(always)]
    fn either(condition: Self::Mask, a: impl FnOnce() -> Self, b: impl FnOnce() -> Self) -> Self {
        Self::select(condition, a(), b())
    }

    /// A part of a formula that stands in it often: inlined, for it becomes lanes, but by numbers that are no hardware's, which make it
    /// a call.
    #[inline(always)]
    fn part<O>(formula: impl FnOnce() -> O) -> O {
        formula()
    }

    /// The same as [`Real::select`], of which the compiler may make a branch, which keeps a loop from being vectorized.
    fn choose(condition: Self::Mask, a: Self, b: Self) -> Self;

    /// `self`, and where the condition holds the derivatives of `limit`: at a tip, where creases meet and the formula's own
    /// derivatives are those of a quotient 0/0. A number without derivatives stays as it is.
    #[inline(always)]
    fn with_slope_of(self, _condition: Self::Mask, _limit: impl FnOnce() -> Self) -> Self {
        self
    }

    /// Whether a number that is not negative is zero.
    fn vanishes(self) -> Self::Mask;

    /// `self`, or zero where its square would be subnormal.
    fn squarable(self) -> Self;

    /// The largest integer not above `self`, for |self| below a quarter of 1/ε. A constant to
    /// derivatives.
    fn floor(self) -> Self;

    /// The angle of the point (x, y), y ≥ 0, in half turns: atan2(y, x)/π in [0, 1]. (0, 0) gives 0
    /// and the sign of a zero does not count.
    fn half_turns(y: Self, x: Self) -> Self;

    /// (sin πr, cos πr) for |r| ≤ 2²⁰.
    fn sin_cos_half_turns(r: Self) -> (Self, Self);

    /// sin(πr)/r as a smooth even function of r, given s = r² and r = √s ≤ 1.
    fn sinc_half_turns(s: Self, r: Self) -> Self;

    /// cos πr as a smooth even function of r, given s = r² and r = √s ≤ 1.
    fn cos_half_turns(s: Self, r: Self) -> Self;

    /// (sinh self, cosh self) for |self| ≤ 300 (88 for f32).
    fn sinh_cosh(self) -> (Self, Self);

    /// asinh self; what is larger than 2⁶⁰ counts as 2⁶⁰.
    fn asinh(self) -> Self;

    /// The cube root of a positive number.
    fn cbrt(self) -> Self;
}

/// +1 for x ≥ 0 and for both zeros, else -1. A fold that used sign(0) = 0 would send -z to +z.
#[inline(always)]
pub fn sign<R: Real>(x: R) -> R {
    R::select(x.less(R::ZERO), R::new(-1.0), R::ONE)
}

/// The smaller of two numbers; `b` where either is NaN.
#[inline(always)]
pub fn min<R: Real>(a: R, b: R) -> R {
    R::select(a.less(b), a, b)
}

/// The larger of two numbers; `b` where either is NaN.
#[inline(always)]
pub fn max<R: Real>(a: R, b: R) -> R {
    R::select(a.more(b), a, b)
}

/// x², or 1e-9 where it is less, for a long polynomial: f32 sees neither beside 1, and the fourth power is no subnormal number.
#[inline(always)]
pub fn floored_square<R: Real>(x: R) -> R {
    max(x * x, R::new(1e-9))
}

/// (x, y) times the power of two that brings the larger one near 1, and the inverse of that power. It
/// keeps squares from under- and overflowing and azimuths right down to the smallest subnormal.
#[inline(always)]
pub fn scaled<R: Real>(x: R, y: R) -> (R, R, R) {
    let scale = max(x.abs(), y.abs()).binade_scale();
    (x * scale, y * scale, scale.binade_scale())
}

/// sin(πr)/r for s = r², r = √s in [0, 1], right through r = 0 where it is π.
#[inline(always)]
pub fn sinc_half_turns<R: Real>(s: R, r: R) -> R {
    use std::f64::consts::PI;
    // Below the first value the series π - π³s/6 is exact to rounding, derivatives included.
    let small = s.less(R::new(R::epsilon()));
    let divisor = R::select(small, R::ONE, r);
    let (sin, _) = R::sin_cos_half_turns(r);
    let series = R::new(PI) - s * R::new(PI * PI * PI / 6.0);
    R::select(small, series, sin / divisor)
}

macro_rules! real {
    ($t:ty, $bits:ty, $exponent_mask:expr, $top:expr, $squarable:expr) => {
        impl Real for $t {
            const ZERO: Self = 0.0;
            const HALF: Self = 0.5;
            const ONE: Self = 1.0;
            const TWO: Self = 2.0;
            const NAN: Self = <$t>::NAN;

            #[inline(always)]
            fn epsilon() -> f64 {
                <$t>::EPSILON as f64
            }

            type Mask = bool;
            type Value = Self;

            #[inline(always)]
            fn value(self) -> Self {
                self
            }

            #[inline(always)]
            fn constant(value: Self) -> Self {
                value
            }

            #[inline(always)]
            fn new(x: f64) -> Self {
                x as $t
            }

            #[inline(always)]
            fn truth(value: bool) -> bool {
                value
            }

            #[inline(always)]
            fn less(self, other: Self) -> bool {
                self < other
            }

            #[inline(always)]
            fn at_most(self, other: Self) -> bool {
                self <= other
            }

            #[inline(always)]
            fn more(self, other: Self) -> bool {
                self > other
            }

            #[inline(always)]
            fn at_least(self, other: Self) -> bool {
                self >= other
            }

            #[inline(always)]
            fn equals(self, other: Self) -> bool {
                self == other
            }

            #[inline(always)]
            fn is_nan(self) -> bool {
                self.is_nan()
            }

            #[inline(always)]
            fn abs(self) -> Self {
                self.abs()
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                self.sqrt()
            }

            #[inline(always)]
            fn binade_scale(self) -> Self {
                let exponent = self.to_bits() & $exponent_mask;
                let scale = <$t>::from_bits(<$bits>::wrapping_sub($top, exponent));
                // The largest binade would give 0 and infinity a negative number.
                if scale > <$t>::MIN_POSITIVE {
                    scale
                } else {
                    <$t>::MIN_POSITIVE
                }
            }

            #[inline(always)]
            fn clamped(self, low: f64, high: f64) -> Self {
                // The operand that a comparison with NaN chooses is the second.
                max(low as $t, min(high as $t, self))
            }

            #[inline(always)]
            fn negated_if(self, condition: bool) -> Self {
                self.flipped_if(condition)
            }

            #[inline(always)]
            fn select(condition: bool, a: Self, b: Self) -> Self {
                if condition { a } else { b }
            }

            #[inline(always)]
            fn choose(condition: bool, a: Self, b: Self) -> Self {
                std::hint::select_unpredictable(condition, a, b)
            }

            #[inline(always)]
            fn vanishes(self) -> bool {
                self <= 0.0
            }

            #[inline(always)]
            fn squarable(self) -> Self {
                if self.abs() > $squarable { self } else { 0.0 }
            }

            #[inline(always)]
            fn floor(self) -> Self {
                // The library's floor is a call below SSE4.1; adding 1.5·2^(digits-1) rounds too.
                const ROUND: $t = 1.5 / <$t>::EPSILON;
                let nearest = (self + ROUND) - ROUND;
                if nearest > self {
                    nearest - 1.0
                } else {
                    nearest
                }
            }

            #[inline(always)]
            fn half_turns(y: Self, x: Self) -> Self {
                <$t as Polynomials>::half_turns::<false>(y, x)
            }

            #[inline(always)]
            fn sin_cos_half_turns(r: Self) -> (Self, Self) {
                <$t as Polynomials>::sin_cos_half_turns(r)
            }

            #[inline(always)]
            fn sinc_half_turns(s: Self, r: Self) -> Self {
                sinc_half_turns(s, r)
            }

            #[inline(always)]
            fn cos_half_turns(_s: Self, r: Self) -> Self {
                <$t as Polynomials>::sin_cos_half_turns(r).1
            }

            #[inline(always)]
            fn sinh_cosh(self) -> (Self, Self) {
                <$t as Polynomials>::sinh_cosh(self)
            }

            #[inline(always)]
            fn asinh(self) -> Self {
                <$t as Polynomials>::asinh(self)
            }

            #[inline(always)]
            fn cbrt(self) -> Self {
                <$t as Polynomials>::cbrt(self)
            }
        }
    };
}

real!(f32, u32, 0x7f80_0000, 0x7f00_0000, 1e-18);
real!(
    f64,
    u64,
    0x7ff0_0000_0000_0000,
    0x7fe0_0000_0000_0000,
    1e-150
);

/// A number in a formula all of whose inputs are normal (see [`crate::kernel::Scalar::outside_normal_range`]): guards
/// against zeros, and scaling that only matters far from 1, are left out. The results have the
/// same bits.
#[derive(Clone, Copy)]
pub struct Normal<R>(pub R);

impl<R: Add<Output = R>> Add for Normal<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Normal(self.0 + other.0)
    }
}

impl<R: Sub<Output = R>> Sub for Normal<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Normal(self.0 - other.0)
    }
}

impl<R: Mul<Output = R>> Mul for Normal<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Normal(self.0 * other.0)
    }
}

impl<R: Div<Output = R>> Div for Normal<R> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Normal(self.0 / other.0)
    }
}

impl<R: Neg<Output = R>> Neg for Normal<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Normal(-self.0)
    }
}

impl<R: Real + Polynomials> Real for Normal<R> {
    const ZERO: Self = Normal(R::ZERO);
    const HALF: Self = Normal(R::HALF);
    const ONE: Self = Normal(R::ONE);
    const TWO: Self = Normal(R::TWO);
    const NAN: Self = Normal(R::NAN);

    #[inline(always)]
    fn epsilon() -> f64 {
        R::epsilon()
    }

    type Mask = R::Mask;
    type Value = Self;

    #[inline(always)]
    fn value(self) -> Self {
        self
    }

    #[inline(always)]
    fn constant(value: Self) -> Self {
        value
    }

    #[inline(always)]
    fn new(x: f64) -> Self {
        Normal(R::new(x))
    }

    #[inline(always)]
    fn truth(value: bool) -> R::Mask {
        R::truth(value)
    }

    #[inline(always)]
    fn less(self, other: Self) -> R::Mask {
        self.0.less(other.0)
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> R::Mask {
        self.0.at_most(other.0)
    }

    #[inline(always)]
    fn more(self, other: Self) -> R::Mask {
        self.0.more(other.0)
    }

    #[inline(always)]
    fn at_least(self, other: Self) -> R::Mask {
        self.0.at_least(other.0)
    }

    #[inline(always)]
    fn equals(self, other: Self) -> R::Mask {
        self.0.equals(other.0)
    }

    #[inline(always)]
    fn is_nan(self) -> R::Mask {
        self.0.is_nan()
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Normal(self.0.abs())
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Normal(self.0.sqrt())
    }

    #[inline(always)]
    fn binade_scale(self) -> Self {
        Normal(R::ONE)
    }

    #[inline(always)]
    fn clamped(self, low: f64, high: f64) -> Self {
        Normal(self.0.clamped(low, high))
    }

    #[inline(always)]
    fn negated_if(self, condition: R::Mask) -> Self {
        Normal(self.0.negated_if(condition))
    }

    #[inline(always)]
    fn select(condition: R::Mask, a: Self, b: Self) -> Self {
        Normal(R::select(condition, a.0, b.0))
    }

    #[inline(always)]
    fn choose(condition: R::Mask, a: Self, b: Self) -> Self {
        Normal(R::choose(condition, a.0, b.0))
    }

    #[inline(always)]
    fn vanishes(self) -> R::Mask {
        R::truth(false)
    }

    #[inline(always)]
    fn squarable(self) -> Self {
        self
    }

    #[inline(always)]
    fn floor(self) -> Self {
        Normal(self.0.floor())
    }

    #[inline(always)]
    fn half_turns(y: Self, x: Self) -> Self {
        Normal(<R as Polynomials>::half_turns::<true>(y.0, x.0))
    }

    #[inline(always)]
    fn sin_cos_half_turns(r: Self) -> (Self, Self) {
        let (sin, cos) = <R as Real>::sin_cos_half_turns(r.0);
        (Normal(sin), Normal(cos))
    }

    #[inline(always)]
    fn sinc_half_turns(s: Self, r: Self) -> Self {
        Normal(R::sinc_half_turns(s.0, r.0))
    }

    #[inline(always)]
    fn cos_half_turns(s: Self, r: Self) -> Self {
        Normal(R::cos_half_turns(s.0, r.0))
    }

    #[inline(always)]
    fn sinh_cosh(self) -> (Self, Self) {
        let (sinh, cosh) = Real::sinh_cosh(self.0);
        (Normal(sinh), Normal(cosh))
    }

    #[inline(always)]
    fn asinh(self) -> Self {
        Normal(Real::asinh(self.0))
    }

    #[inline(always)]
    fn cbrt(self) -> Self {
        Normal(Real::cbrt(self.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn binade_scale_brings_every_positive_number_near_one() {
        for exponent in -149..=127 {
            let m = (exponent as f64).exp2() as f32
                * 1.5_f32.min(if exponent < -148 { 1.0 } else { 1.5 });
            let scaled = m * m.binade_scale();
            assert!(
                (2f32.powi(-22)..4.0).contains(&scaled),
                "2^{exponent}: {scaled}"
            );
            if exponent >= -126 {
                assert!(scaled >= 1.0, "2^{exponent}: {scaled}");
            }
        }
        for m in [0.0, f64::INFINITY, f64::MAX] {
            let scale = m.binade_scale();
            assert!(scale.is_finite() && scale > 0.0);
        }
    }

    #[test]
    fn floor_agrees_with_the_library() {
        for i in -4000..4000 {
            let x = i as f64 / 8.0;
            assert_eq!(Real::floor(x), x.floor());
            assert_eq!(Real::floor(x as f32), (x as f32).floor());
        }
    }
}
