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
//! Formulas choose with a plain `if` between two values that are both already computed; that is
//! what the vectorizer turns into a select.

use crate::number::math;
use crate::number::math::Polynomials;
use crate::number::math::{max, min};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number a formula can be written in: `f32`, `f64`, or a dual number over one of them.
pub trait Real:
    Copy
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + 'static
{
    /// Distance from 1 to the next larger number.
    const EPSILON: f64;

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

    /// The number without derivatives: what an iteration runs on until its last step.
    type Value: Real;

    /// `self` without derivatives.
    fn value(self) -> Self::Value;

    /// A constant.
    fn constant(value: Self::Value) -> Self;

    /// The constant nearest to `x`.
    fn new(x: f64) -> Self;

    /// The nearest f64, for the few decisions that are taken once a call.
    fn to_f64(self) -> f64;

    /// Whether it is no number.
    fn is_nan(self) -> bool;

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
    fn negated_if(self, condition: bool) -> Self;

    /// `a` where the condition holds, else `b`: both are computed. An `if` says the same, and the compiler may
    /// make a branch of it, which keeps a loop from being vectorized.
    fn choose(condition: bool, a: Self, b: Self) -> Self;

    /// `self`, and where the condition holds the derivatives of `limit`: at a tip, where creases meet and the formula's own
    /// derivatives are those of a quotient 0/0. A number without derivatives stays as it is.
    #[inline(always)]
    fn with_slope_of(self, _condition: bool, _limit: impl FnOnce() -> Self) -> Self {
        self
    }

    /// Whether a number that is not negative is zero.
    fn vanishes(self) -> bool;

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
    if x < R::ZERO { R::new(-1.0) } else { R::ONE }
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
    let small = s < R::new(R::EPSILON);
    let divisor = if small { R::ONE } else { r };
    let (sin, _) = R::sin_cos_half_turns(r);
    if small {
        R::new(PI) - s * R::new(PI * PI * PI / 6.0)
    } else {
        sin / divisor
    }
}

macro_rules! real {
    ($t:ty, $bits:ty, $exponent_mask:expr, $top:expr, $squarable:expr) => {
        impl Real for $t {
            const EPSILON: f64 = <$t>::EPSILON as f64;
            const ZERO: Self = 0.0;
            const HALF: Self = 0.5;
            const ONE: Self = 1.0;
            const TWO: Self = 2.0;
            const NAN: Self = <$t>::NAN;

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
            fn to_f64(self) -> f64 {
                self as f64
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
                let (sinh, cosh) = math::sinh_cosh(f64::from(self));
                (sinh as $t, cosh as $t)
            }

            #[inline(always)]
            fn asinh(self) -> Self {
                math::asinh(f64::from(self)) as $t
            }

            #[inline(always)]
            fn cbrt(self) -> Self {
                math::cbrt(f64::from(self)) as $t
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
#[derive(Clone, Copy, PartialEq)]
pub struct Normal<R>(pub R);

// Each comparison by itself: through `partial_cmp` it would not vectorize.
impl<R: PartialOrd> PartialOrd for Normal<R> {
    #[inline(always)]
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        self.0.partial_cmp(&other.0)
    }

    #[inline(always)]
    fn lt(&self, other: &Self) -> bool {
        self.0 < other.0
    }

    #[inline(always)]
    fn le(&self, other: &Self) -> bool {
        self.0 <= other.0
    }

    #[inline(always)]
    fn gt(&self, other: &Self) -> bool {
        self.0 > other.0
    }

    #[inline(always)]
    fn ge(&self, other: &Self) -> bool {
        self.0 >= other.0
    }
}

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
    const EPSILON: f64 = R::EPSILON;
    const ZERO: Self = Normal(R::ZERO);
    const HALF: Self = Normal(R::HALF);
    const ONE: Self = Normal(R::ONE);
    const TWO: Self = Normal(R::TWO);
    const NAN: Self = Normal(R::NAN);

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
    fn to_f64(self) -> f64 {
        self.0.to_f64()
    }

    #[inline(always)]
    fn is_nan(self) -> bool {
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
    fn negated_if(self, condition: bool) -> Self {
        Normal(self.0.negated_if(condition))
    }

    #[inline(always)]
    fn choose(condition: bool, a: Self, b: Self) -> Self {
        Normal(R::choose(condition, a.0, b.0))
    }

    #[inline(always)]
    fn vanishes(self) -> bool {
        false
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
        let (sinh, cosh) = self.0.sinh_cosh();
        (Normal(sinh), Normal(cosh))
    }

    #[inline(always)]
    fn asinh(self) -> Self {
        Normal(self.0.asinh())
    }

    #[inline(always)]
    fn cbrt(self) -> Self {
        Normal(self.0.cbrt())
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
