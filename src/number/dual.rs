//! Dual numbers: a formula gives its own Jacobian.
//!
//! `Dual { re, du, dv }` carries a value and its derivatives by the two image coordinates. Running a
//! projection's `decode` on the dual numbers (u, 1, 0) and (v, 0, 1) yields the direction and both
//! columns of ∂d/∂(u, v), from the one formula there is, so a Jacobian can never disagree with its
//! map. Comparisons look at the value only: the derivative is that of the branch taken.
//!
//! The derivatives are two named fields and not an array: a loop over a local array of two stopped
//! the vectorizer and cost a factor of ten.

use crate::number::real::Real;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A value with its derivatives by u and v.
#[derive(Clone, Copy, Debug)]
pub struct Dual<R> {
    /// The value.
    pub re: R,
    /// ∂/∂u.
    pub du: R,
    /// ∂/∂v.
    pub dv: R,
}

impl<R: Real> Dual<R> {
    /// The image coordinate u itself.
    #[inline(always)]
    pub fn u(re: R) -> Self {
        Self {
            re,
            du: R::ONE,
            dv: R::ZERO,
        }
    }

    /// The image coordinate v itself.
    #[inline(always)]
    pub fn v(re: R) -> Self {
        Self {
            re,
            du: R::ZERO,
            dv: R::ONE,
        }
    }

    /// A number that depends on neither.
    #[inline(always)]
    pub fn constant(re: R) -> Self {
        Self {
            re,
            du: R::ZERO,
            dv: R::ZERO,
        }
    }

    /// f(self), given its value and f′.
    #[inline(always)]
    fn chain(self, re: R, derivative: R) -> Self {
        Self {
            re,
            du: self.du * derivative,
            dv: self.dv * derivative,
        }
    }
}

impl<R: Real> Add for Dual<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self {
            re: self.re + o.re,
            du: self.du + o.du,
            dv: self.dv + o.dv,
        }
    }
}

impl<R: Real> Sub for Dual<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self {
            re: self.re - o.re,
            du: self.du - o.du,
            dv: self.dv - o.dv,
        }
    }
}

impl<R: Real> Mul for Dual<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self {
            re: self.re * o.re,
            du: self.du * o.re + self.re * o.du,
            dv: self.dv * o.re + self.re * o.dv,
        }
    }
}

impl<R: Real> Div for Dual<R> {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        let re = self.re / o.re;
        Self {
            re,
            du: (self.du - re * o.du) / o.re,
            dv: (self.dv - re * o.dv) / o.re,
        }
    }
}

impl<R: Real> Neg for Dual<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self {
            re: -self.re,
            du: -self.du,
            dv: -self.dv,
        }
    }
}

impl<R: Real> Real for Dual<R> {
    const ZERO: Self = Dual {
        re: R::ZERO,
        du: R::ZERO,
        dv: R::ZERO,
    };
    const HALF: Self = Dual {
        re: R::HALF,
        du: R::ZERO,
        dv: R::ZERO,
    };
    const ONE: Self = Dual {
        re: R::ONE,
        du: R::ZERO,
        dv: R::ZERO,
    };
    const TWO: Self = Dual {
        re: R::TWO,
        du: R::ZERO,
        dv: R::ZERO,
    };
    const NAN: Self = Dual {
        re: R::NAN,
        du: R::ZERO,
        dv: R::ZERO,
    };

    #[inline(always)]
    fn epsilon() -> f64 {
        R::epsilon()
    }

    type Mask = R::Mask;
    type Value = R;

    #[inline(always)]
    fn value(self) -> R {
        self.re
    }

    #[inline(always)]
    fn constant(value: R) -> Self {
        Dual::constant(value)
    }

    #[inline(always)]
    fn part<O>(formula: impl FnOnce() -> O) -> O {
        R::part(formula)
    }

    #[inline(always)]
    fn new(x: f64) -> Self {
        Self::constant(R::new(x))
    }

    #[inline(always)]
    fn truth(value: bool) -> R::Mask {
        R::truth(value)
    }

    #[inline(always)]
    fn less(self, other: Self) -> R::Mask {
        self.re.less(other.re)
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> R::Mask {
        self.re.at_most(other.re)
    }

    #[inline(always)]
    fn more(self, other: Self) -> R::Mask {
        self.re.more(other.re)
    }

    #[inline(always)]
    fn at_least(self, other: Self) -> R::Mask {
        self.re.at_least(other.re)
    }

    #[inline(always)]
    fn equals(self, other: Self) -> R::Mask {
        self.re.equals(other.re)
    }

    #[inline(always)]
    fn is_nan(self) -> R::Mask {
        self.re.is_nan()
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self::select(self.re.less(R::ZERO), -self, self)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.re.sqrt();
        self.chain(root, R::HALF / root)
    }

    #[inline(always)]
    fn binade_scale(self) -> Self {
        Self::constant(self.re.binade_scale())
    }

    #[inline(always)]
    fn clamped(self, low: f64, high: f64) -> Self {
        Self {
            re: self.re.clamped(low, high),
            ..self
        }
    }

    #[inline(always)]
    fn negated_if(self, condition: R::Mask) -> Self {
        Self {
            re: self.re.negated_if(condition),
            du: self.du.negated_if(condition),
            dv: self.dv.negated_if(condition),
        }
    }

    #[inline(always)]
    fn select(condition: R::Mask, a: Self, b: Self) -> Self {
        Self {
            re: R::select(condition, a.re, b.re),
            du: R::select(condition, a.du, b.du),
            dv: R::select(condition, a.dv, b.dv),
        }
    }

    #[inline(always)]
    fn choose(condition: R::Mask, a: Self, b: Self) -> Self {
        Self {
            re: R::choose(condition, a.re, b.re),
            du: R::choose(condition, a.du, b.du),
            dv: R::choose(condition, a.dv, b.dv),
        }
    }

    #[inline(always)]
    fn with_slope_of(self, condition: R::Mask, limit: impl FnOnce() -> Self) -> Self {
        let limit = limit();
        Self {
            re: self.re,
            du: R::choose(condition, limit.du, self.du),
            dv: R::choose(condition, limit.dv, self.dv),
        }
    }

    #[inline(always)]
    fn vanishes(self) -> R::Mask {
        self.re.vanishes()
    }

    #[inline(always)]
    fn squarable(self) -> Self {
        self
    }

    #[inline(always)]
    fn floor(self) -> Self {
        Self::constant(self.re.floor())
    }

    #[inline(always)]
    fn half_turns(y: Self, x: Self) -> Self {
        let square = (x.re * x.re + y.re * y.re) * R::new(std::f64::consts::PI);
        let (dy, dx) = (x.re / square, -y.re / square);
        Self {
            re: R::half_turns(y.re, x.re),
            du: y.du * dy + x.du * dx,
            dv: y.dv * dy + x.dv * dx,
        }
    }

    #[inline(always)]
    fn sin_cos_half_turns(r: Self) -> (Self, Self) {
        let (sin, cos) = R::sin_cos_half_turns(r.re);
        let pi = R::new(std::f64::consts::PI);
        (r.chain(sin, pi * cos), r.chain(cos, -pi * sin))
    }

    #[inline(always)]
    fn sinc_half_turns(s: Self, r: Self) -> Self {
        use std::f64::consts::PI;
        // d/ds sin(πr)/r = (πr cos πr - sin πr)/(2r³) cancels for small r, where its series serves.
        let value = R::sinc_half_turns(s.re, r.re);
        let (sin, cos) = R::sin_cos_half_turns(r.re);
        let x = s.re * R::new(PI * PI);
        let series = R::new(-PI * PI * PI / 6.0)
            * (R::ONE
                - x * (R::new(1.0 / 10.0)
                    - x * (R::new(1.0 / 280.0)
                        - x * (R::new(1.0 / 15120.0)
                            - x * (R::new(1.0 / 1330560.0) - x * R::new(1.0 / 172972800.0))))));
        let divisor = R::TWO * s.re * r.re;
        let direct = (R::new(PI) * r.re * cos - sin) / divisor;
        let derivative = R::choose(s.re.less(R::new(0.02)), series, direct);
        s.chain(value, derivative)
    }

    #[inline(always)]
    fn cos_half_turns(s: Self, r: Self) -> Self {
        // d/ds cos πr = -π/2 · sin(πr)/r: no division by the derivative of a root at 0.
        let slope = R::new(-0.5 * std::f64::consts::PI) * R::sinc_half_turns(s.re, r.re);
        s.chain(R::cos_half_turns(s.re, r.re), slope)
    }

    #[inline(always)]
    fn sinh_cosh(self) -> (Self, Self) {
        let (sinh, cosh) = self.re.sinh_cosh();
        (self.chain(sinh, cosh), self.chain(cosh, sinh))
    }

    #[inline(always)]
    fn asinh(self) -> Self {
        let slope = R::ONE / (R::ONE + self.re * self.re).sqrt();
        self.chain(self.re.asinh(), slope)
    }

    #[inline(always)]
    fn cbrt(self) -> Self {
        let root = self.re.cbrt();
        self.chain(root, R::new(1.0 / 3.0) / (root * root))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Central differences of f at x against the dual derivative.
    fn check(f: impl Fn(Dual<f64>) -> Dual<f64>, x: f64) {
        let h = 1e-6;
        let numeric = (f(Dual::constant(x + h)).re - f(Dual::constant(x - h)).re) / (2.0 * h);
        let exact = f(Dual::u(x)).du;
        assert!(
            (numeric - exact).abs() < 1e-8 * exact.abs().max(1.0),
            "{x}: {numeric} {exact}"
        );
    }

    #[test]
    fn derivatives_agree_with_differences() {
        for i in 1..100 {
            let x = i as f64 / 100.0;
            check(|x| x.sqrt() * x / (x + Dual::new(2.0)), x);
            check(|x| Dual::half_turns(x, Dual::new(0.3) - x), x);
            check(|x| Dual::sin_cos_half_turns(x).0, x);
            check(|x| Dual::sin_cos_half_turns(x).1, x);
            check(|s| Dual::sinc_half_turns(s, s.sqrt()), x);
            check(|s| Dual::cos_half_turns(s, s.sqrt()), x);
            check(|x| x.sinh_cosh().0, x);
            check(|x| x.sinh_cosh().1, x);
            check(Dual::asinh, x);
            check(Dual::cbrt, x);
        }
    }

    #[test]
    fn even_functions_have_finite_derivatives_at_zero() {
        let s = Dual::<f64>::u(0.0);
        assert!(Dual::sinc_half_turns(s, s.sqrt()).du.is_finite());
        assert!(Dual::cos_half_turns(s, s.sqrt()).du.is_finite());
    }
}
