//! What a formula costs, counted and not timed: a number type that counts what is done with it.
//!
//! A table that people choose from must say the same on every machine. One step is an addition, a multiplication, a
//! comparison or a change of sign; a division or a root counts as [`SLOW`], about what it takes where sixteen numbers are
//! computed at once. The functions of `math` count as what they are made of.

use crate::number::real::Real;
use crate::projections::projection::{Projection, Uv};
use std::cell::Cell;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Steps of a division or a root.
const SLOW: u32 = 8;
/// Steps of an arctangent: a division, five terms in f32, folding.
const HALF_TURNS: u32 = SLOW + 28;
/// Steps of a sine and a cosine.
const SIN_COS: u32 = 30;
/// Steps of a hyperbolic sine and cosine: a power of two and two series.
const SINH_COSH: u32 = 40;
/// Steps of an inverse hyperbolic sine: a root, a division, a logarithm's series.
const ASINH: u32 = 2 * SLOW + 40;
/// Steps of a cube root: three steps of Halley's.
const CBRT: u32 = 3 * (SLOW + 8) + 6;

thread_local! {
    static STEPS: Cell<u32> = const { Cell::new(0) };
}

/// A number that counts.
#[derive(Clone, Copy)]
struct Counted(f64);

fn step(count: u32, x: f64) -> Counted {
    STEPS.with(|steps| steps.set(steps.get() + count));
    Counted(x)
}

fn comparison(outcome: bool) -> bool {
    step(1, 0.0);
    outcome
}

macro_rules! operation {
    ($trait:ident, $name:ident, $operator:tt, $count:expr) => {
        impl $trait for Counted {
            type Output = Self;
            fn $name(self, other: Self) -> Self {
                step($count, self.0 $operator other.0)
            }
        }
    };
}
operation!(Add, add, +, 1);
operation!(Sub, sub, -, 1);
operation!(Mul, mul, *, 1);
operation!(Div, div, /, SLOW);

impl Neg for Counted {
    type Output = Self;
    fn neg(self) -> Self {
        step(1, -self.0)
    }
}

impl Real for Counted {
    const ZERO: Self = Counted(0.0);
    const HALF: Self = Counted(0.5);
    const ONE: Self = Counted(1.0);
    const TWO: Self = Counted(2.0);
    const NAN: Self = Counted(f64::NAN);

    fn epsilon() -> f64 {
        f64::EPSILON
    }

    type Mask = bool;
    type Value = Self;

    fn value(self) -> Self {
        self
    }

    fn constant(value: Self) -> Self {
        value
    }

    fn new(x: f64) -> Self {
        Counted(x)
    }

    fn truth(value: bool) -> bool {
        value
    }

    fn less(self, other: Self) -> bool {
        comparison(self.0 < other.0)
    }

    fn at_most(self, other: Self) -> bool {
        comparison(self.0 <= other.0)
    }

    fn more(self, other: Self) -> bool {
        comparison(self.0 > other.0)
    }

    fn at_least(self, other: Self) -> bool {
        comparison(self.0 >= other.0)
    }

    // Not counted: what is compared so is nearly always the number of a face.
    fn equals(self, other: Self) -> bool {
        self.0 == other.0
    }

    fn is_nan(self) -> bool {
        self.0.is_nan()
    }

    fn abs(self) -> Self {
        step(1, self.0.abs())
    }

    fn sqrt(self) -> Self {
        step(SLOW, self.0.sqrt())
    }

    // What scales and guards is left out of normal chunks, which nearly all are.
    fn binade_scale(self) -> Self {
        Counted(1.0)
    }

    fn clamped(self, low: f64, high: f64) -> Self {
        step(2, Real::clamped(self.0, low, high))
    }

    fn negated_if(self, condition: bool) -> Self {
        step(1, self.0.negated_if(condition))
    }

    // The comparison was counted.
    fn select(condition: bool, a: Self, b: Self) -> Self {
        if condition { a } else { b }
    }

    // What is not taken is not counted.
    fn either(condition: bool, a: impl FnOnce() -> Self, b: impl FnOnce() -> Self) -> Self {
        if condition { a() } else { b() }
    }

    fn choose(condition: bool, a: Self, b: Self) -> Self {
        Self::select(condition, a, b)
    }

    fn vanishes(self) -> bool {
        false
    }

    fn squarable(self) -> Self {
        self
    }

    fn floor(self) -> Self {
        step(4, Real::floor(self.0))
    }

    fn half_turns(y: Self, x: Self) -> Self {
        step(HALF_TURNS, f64::half_turns(y.0, x.0))
    }

    fn sin_cos_half_turns(r: Self) -> (Self, Self) {
        let (sin, cos) = f64::sin_cos_half_turns(r.0);
        (step(SIN_COS, sin), Counted(cos))
    }

    fn sinc_half_turns(s: Self, r: Self) -> Self {
        step(SIN_COS + SLOW + 2, f64::sinc_half_turns(s.0, r.0))
    }

    fn cos_half_turns(s: Self, r: Self) -> Self {
        step(SIN_COS, f64::cos_half_turns(s.0, r.0))
    }

    fn sinh_cosh(self) -> (Self, Self) {
        let (sinh, cosh) = self.0.sinh_cosh();
        (step(SINH_COSH, sinh), Counted(cosh))
    }

    fn asinh(self) -> Self {
        step(ASINH, Real::asinh(self.0))
    }

    fn cbrt(self) -> Self {
        step(CBRT, Real::cbrt(self.0))
    }
}

/// Steps to encode a direction and to decode a place.
pub fn steps<P: Projection>(projection: P) -> (u32, u32) {
    let count = |work: &dyn Fn()| {
        STEPS.with(|steps| steps.set(0));
        work();
        STEPS.with(Cell::get)
    };
    let encode = count(&|| {
        projection.encode([0.3, -0.2, 0.9].map(Counted));
    });
    let (u, v, face) = (Counted(0.45), Counted(0.4), Counted(0.0));
    let decode = count(&|| {
        projection.decode(Uv { u, v, face });
    });
    (encode, decode)
}
