//! A number that records instead of computing: a formula run on it is written down as a graph.
//!
//! [`Trace`] stands for an f32 or an f64 of a [`Graph`] of the thread, which [`record`] begins and ends. The formulas of the
//! projections run on it as they are, and with [`Dual`](crate::number::dual::Dual) numbers over it their derivatives do.
//!
//! What is recorded is the arithmetic that kernels do with numbers of the normal range (`Normal`): scaling by powers of two
//! is left out, and components below 2⁻⁶⁰ of the largest count as zero. What guards against zero is kept. The bits are those
//! of the kernels. Polynomials are recorded by their own coefficients; where the kernels work on the bits of floats, what
//! is recorded says the same in arithmetic that every language has: a quarter turn's parity is `k - 2·floor(k/2)`, powers of
//! two and exponents are operations of their own.
//!
//! Only the cube root of f32 is another here than in kernels, which begin it with the bits of an integer's third: it is as good.

use crate::number::graph::{Binary, Comparison, Graph, Helper, Id, Logic, Node, Style, Unary};
use crate::number::math::{Coefficients, Polynomials};
use crate::number::real::{self, Real, max, min};
use std::cell::RefCell;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

/// What is being recorded: the graph, and constants that have no node before they take part.
struct Recording {
    graph: Graph,
    constants: Vec<f64>,
}

/// Constants that formulas have by name: the first ones of every recording.
const NAMED: [f64; 5] = [0.0, 0.5, 1.0, 2.0, f64::NAN];

thread_local! {
    static RECORDING: RefCell<Option<Recording>> = const { RefCell::new(None) };
}

/// Runs a formula on numbers that record, and returns the graph and what the formula made of them.
pub fn record<O>(style: Style, formula: impl FnOnce() -> O) -> (Graph, O) {
    let recording = Recording {
        graph: Graph::new(style),
        constants: NAMED.into(),
    };
    RECORDING.set(Some(recording));
    let output = formula();
    let recording = RECORDING.take();
    let graph = recording.map(|recording| recording.graph);
    (graph.unwrap_or_else(|| Graph::new(style)), output)
}

fn recording<O>(work: impl FnOnce(&mut Recording) -> O) -> O {
    RECORDING.with_borrow_mut(|recording| match recording {
        Some(recording) => work(recording),
        None => unreachable!("numbers that record exist within `record` only"),
    })
}

fn with<O>(work: impl FnOnce(&mut Graph) -> O) -> O {
    recording(|recording| work(&mut recording.graph))
}

// Every operation of every formula is a call of one of these: inlined, they would be a fifth of the library. What
// they take and give is in registers: as enums of constants and nodes, which lie in memory, it made the calls a seventh of the library.

/// A node, or, from [`CONSTANT`] on, a constant.
#[derive(Clone, Copy, Debug)]
struct Value(u32);

/// The number of the first constant; of nodes there are fewer.
const CONSTANT: u32 = 1 << 31;

#[inline(never)]
fn constant(x: f64) -> Value {
    recording(|recording| {
        recording.constants.push(x);
        Value(CONSTANT + (recording.constants.len() - 1) as u32)
    })
}

#[inline(never)]
fn id_of(value: Value) -> Id {
    match value.0.checked_sub(CONSTANT) {
        Some(number) => recording(|recording| {
            let x = recording.constants[number as usize];
            recording.graph.constant(x)
        }),
        None => value.0,
    }
}

#[inline(never)]
fn unary(operation: Unary, a: Value) -> Value {
    let a = id_of(a);
    Value(with(|graph| graph.unary(operation, a)))
}

#[inline(never)]
fn binary(operation: Binary, a: Value, b: Value) -> Value {
    let (a, b) = (id_of(a), id_of(b));
    Value(with(|graph| graph.binary(operation, a, b)))
}

#[inline(never)]
fn compare(comparison: Comparison, a: Value, b: Value) -> Condition {
    let (a, b) = (id_of(a), id_of(b));
    Condition(with(|graph| graph.compare(comparison, a, b)))
}

#[inline(never)]
fn select(condition: Condition, a: Value, b: Value) -> Value {
    let (condition, a, b) = (condition.id(), id_of(a), id_of(b));
    Value(with(|graph| graph.select(condition, a, b)))
}

#[inline(never)]
fn call(helper: Helper, a: Value, b: Value) -> Id {
    let (a, b) = (id_of(a), id_of(b));
    with(|graph| graph.node(Node::Call(helper, a, b)))
}

/// A number of a graph: how wide, its style says.
#[derive(Clone, Copy, Debug)]
pub struct Trace(Value);

/// A condition of a graph: a node, or, from [`CONSTANT`] on, what is known beforehand.
#[derive(Clone, Copy, Debug)]
pub struct Condition(u32);

impl Condition {
    /// Its node.
    #[inline(never)]
    pub fn id(self) -> Id {
        match self.0.checked_sub(CONSTANT) {
            Some(value) => with(|graph| graph.node(Node::Truth(value != 0))),
            None => self.0,
        }
    }

    #[inline(never)]
    fn join(self, logic: Logic, other: Self) -> Self {
        let (a, b) = (self.id(), other.id());
        Condition(with(|graph| graph.logic(logic, a, b)))
    }
}

impl BitAnd for Condition {
    type Output = Self;
    fn bitand(self, other: Self) -> Self {
        self.join(Logic::And, other)
    }
}

impl BitOr for Condition {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        self.join(Logic::Or, other)
    }
}

impl BitXor for Condition {
    type Output = Self;
    fn bitxor(self, other: Self) -> Self {
        (self & !other) | (!self & other)
    }
}

impl Not for Condition {
    type Output = Self;
    #[inline(never)]
    fn not(self) -> Self {
        let id = self.id();
        Condition(with(|graph| graph.not(id)))
    }
}

impl Trace {
    /// One of [`NAMED`].
    const fn named(number: u32) -> Self {
        Trace(Value(CONSTANT + number))
    }

    fn made(id: Id) -> Self {
        Trace(Value(id))
    }

    /// An argument of the function.
    pub fn input(number: u8) -> Self {
        Trace::made(with(|graph| graph.node(Node::Input(number))))
    }

    /// The nearest whole number, the even one of two.
    pub fn round(self) -> Self {
        self.unary(Unary::Round)
    }

    /// Its node.
    pub fn id(self) -> Id {
        id_of(self.0)
    }

    fn unary(self, operation: Unary) -> Self {
        Trace(unary(operation, self.0))
    }

    fn binary(self, operation: Binary, other: Self) -> Self {
        Trace(binary(operation, self.0, other.0))
    }

    fn compare(self, comparison: Comparison, other: Self) -> Condition {
        compare(comparison, self.0, other.0)
    }

    fn style() -> Style {
        with(|graph| graph.style())
    }

    fn width() -> &'static Width {
        if Self::style().double {
            &DOUBLE
        } else {
            &SINGLE
        }
    }

    fn call(helper: Helper, a: Self, b: Self) -> Self {
        Trace::made(call(helper, a.0, b.0))
    }

    /// Both numbers that a shared function gives.
    fn call_pair(helper: Helper, a: Self) -> (Self, Self) {
        let call = call(helper, a.0, a.0);
        let part = |number| Trace::made(with(|graph| graph.node(Node::Part(call, number))));
        (part(0), part(1))
    }
}

macro_rules! operation {
    ($trait:ident, $name:ident, $operation:ident) => {
        impl $trait for Trace {
            type Output = Self;
            fn $name(self, other: Self) -> Self {
                self.binary(Binary::$operation, other)
            }
        }
    };
}
operation!(Add, add, Add);
operation!(Sub, sub, Subtract);
operation!(Mul, mul, Multiply);
operation!(Div, div, Divide);

impl Neg for Trace {
    type Output = Self;
    fn neg(self) -> Self {
        self.unary(Unary::Negate)
    }
}

/// The body of a shared function: its graph, and what it gives.
pub fn body(helper: Helper, style: Style) -> (Graph, Vec<Id>) {
    record(
        Style {
            inside: true,
            ..style
        },
        || {
            let (a, b) = (Trace::input(0), Trace::input(1));
            let one = |x: Trace| vec![x.id()];
            let two = |(x, y): (Trace, Trace)| vec![x.id(), y.id()];
            match helper {
                Helper::HalfTurns => one(Trace::half_turns(a, b)),
                Helper::SinCosPi => two(Trace::sin_cos_half_turns(a)),
                Helper::SinhCosh => two(a.sinh_cosh()),
                Helper::Asinh => one(a.asinh()),
                Helper::CubeRoot => one(a.cbrt()),
            }
        },
    )
}

/// What formulas are recorded with: of f32 or of f64.
struct Width {
    epsilon: f64,
    /// The smallest normal number.
    smallest: f64,
    polynomials: Coefficients,
    /// ln 2 in two parts, of which the first times a small whole number is exact.
    ln_2: [f64; 2],
    /// How many terms the series of hyperbolic functions and of artanh take.
    terms: [usize; 2],
}

static SINGLE: Width = Width {
    epsilon: real::SINGLE,
    smallest: f32::MIN_POSITIVE as f64,
    polynomials: f32::COEFFICIENTS,
    ln_2: [0.693_145_751_953_125, 1.428_606_820_309_417_3e-6],
    terms: [4, 5],
};

static DOUBLE: Width = Width {
    epsilon: f64::EPSILON,
    smallest: f64::MIN_POSITIVE,
    polynomials: f64::COEFFICIENTS,
    ln_2: [0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10],
    terms: [7, 10],
};

/// c₀ + s (c₁ + s (c₂ + …)), in the order in which [`polynomial!`](crate::number::math::polynomial) sums it.
fn polynomial(s: Trace, coefficients: &[f64]) -> Trace {
    if coefficients.len() > 5 {
        let s2 = s * s;
        return fours(s, s2, s2 * s2, coefficients);
    }
    let mut terms = coefficients.iter().rev().map(|&c| Trace::new(c));
    let last = terms.next().unwrap_or(Trace::ZERO);
    terms.fold(last, |sum, c| c + s * sum)
}

/// The same, four terms at a time.
fn fours(s: Trace, s2: Trace, s4: Trace, coefficients: &[f64]) -> Trace {
    let (four, rest) = coefficients.split_at(coefficients.len().min(4));
    let pair = |pair: &[f64]| match *pair {
        [c0, c1] => Trace::new(c0) + s * Trace::new(c1),
        _ => Trace::new(pair[0]),
    };
    let mut sum = pair(&four[..four.len().min(2)]);
    if four.len() > 2 {
        sum = sum + s2 * pair(&four[2..]);
    }
    if rest.is_empty() {
        sum
    } else {
        sum + s4 * fours(s, s2, s4, rest)
    }
}

impl Real for Trace {
    const ZERO: Self = Trace::named(0);
    const HALF: Self = Trace::named(1);
    const ONE: Self = Trace::named(2);
    const TWO: Self = Trace::named(3);
    const NAN: Self = Trace::named(4);

    fn epsilon() -> f64 {
        Self::width().epsilon
    }

    type Mask = Condition;
    type Value = Self;

    fn value(self) -> Self {
        self
    }

    fn constant(value: Self) -> Self {
        value
    }

    #[inline(never)]
    fn part<O>(formula: impl FnOnce() -> O) -> O {
        formula()
    }

    fn new(x: f64) -> Self {
        Trace(constant(x))
    }

    fn truth(value: bool) -> Condition {
        Condition(CONSTANT + u32::from(value))
    }

    fn less(self, other: Self) -> Condition {
        self.compare(Comparison::Less, other)
    }

    fn at_most(self, other: Self) -> Condition {
        self.compare(Comparison::AtMost, other)
    }

    fn more(self, other: Self) -> Condition {
        other.compare(Comparison::Less, self)
    }

    fn at_least(self, other: Self) -> Condition {
        other.compare(Comparison::AtMost, self)
    }

    fn equals(self, other: Self) -> Condition {
        self.compare(Comparison::Equal, other)
    }

    fn is_nan(self) -> Condition {
        !self.equals(self)
    }

    fn abs(self) -> Self {
        self.unary(Unary::Absolute)
    }

    fn sqrt(self) -> Self {
        self.unary(Unary::Root)
    }

    // Scaling only matters far from 1.
    fn binade_scale(self) -> Self {
        Self::ONE
    }

    fn clamped(self, low: f64, high: f64) -> Self {
        max(Self::new(low), min(Self::new(high), self))
    }

    fn negated_if(self, condition: Condition) -> Self {
        Self::select(condition, -self, self)
    }

    fn choose(condition: Condition, a: Self, b: Self) -> Self {
        Self::select(condition, a, b)
    }

    fn select(condition: Condition, a: Self, b: Self) -> Self {
        Trace(select(condition, a.0, b.0))
    }

    fn vanishes(self) -> Condition {
        self.at_most(Self::ZERO)
    }

    fn squarable(self) -> Self {
        self
    }

    fn floor(self) -> Self {
        self.unary(Unary::Floor)
    }

    fn half_turns(y: Self, x: Self) -> Self {
        if !Self::style().inside {
            return Self::call(Helper::HalfTurns, y, x);
        }
        if Self::style().native {
            return y.binary(Binary::Arctangent, x) * Self::new(std::f64::consts::FRAC_1_PI);
        }
        let width = Self::width();
        let ax = x.abs();
        let steep = y.more(ax);
        let behind = x.less(Self::ZERO);
        let (hi, lo) = (max(y, ax), min(y, ax));
        let fold = lo.more(Self::new(std::f64::consts::SQRT_2 - 1.0) * hi);
        let numerator = lo - Self::select(fold, hi, Self::ZERO);
        let denominator = hi + Self::select(fold, lo, Self::ZERO);
        let t = numerator / max(denominator, Self::new(width.smallest));
        let s = t * t;
        let [high, low] = width.polynomials.atan_1.map(Self::new);
        let angle = t * high + t * (low + s * polynomial(s, width.polynomials.atan));
        let beside = Self::select(behind, Self::new(0.75), Self::new(0.25));
        let along = Self::select(behind, Self::ONE, Self::ZERO);
        let along = Self::select(steep, Self::HALF, along);
        let middle = Self::select(fold, beside, along);
        middle + angle.negated_if(steep ^ behind)
    }

    fn sin_cos_half_turns(r: Self) -> (Self, Self) {
        if !Self::style().inside {
            return Self::call_pair(Helper::SinCosPi, r);
        }
        if Self::style().native {
            let angle = r * Self::new(std::f64::consts::PI);
            return (angle.unary(Unary::Sine), angle.unary(Unary::Cosine));
        }
        let polynomials = &Self::width().polynomials;
        let quarters = (r + r).unary(Unary::Round);
        let r = r - quarters * Self::HALF;
        let s = r * r;
        let [high, low] = polynomials.pi.map(Self::new);
        let sin = r * high + r * (low + s * polynomial(s, polynomials.sin));
        let cos = Self::ONE + s * polynomial(s, polynomials.cos);
        // Of the quarter turn that was rounded off, the lowest bits: whether it exchanges, and which it turns over.
        let halves = (quarters * Self::HALF).floor();
        let odd = (quarters - halves * Self::TWO).more(Self::HALF);
        let turned = (halves - (halves * Self::HALF).floor() * Self::TWO).more(Self::HALF);
        let (a, b) = (Self::select(odd, cos, sin), Self::select(odd, sin, cos));
        (a.negated_if(turned), b.negated_if(turned ^ odd))
    }

    fn sinc_half_turns(s: Self, r: Self) -> Self {
        real::sinc_half_turns(s, r)
    }

    fn cos_half_turns(_: Self, r: Self) -> Self {
        Self::sin_cos_half_turns(r).1
    }

    fn sinh_cosh(self) -> (Self, Self) {
        if !Self::style().inside {
            return Self::call_pair(Helper::SinhCosh, self);
        }
        if Self::style().native {
            return (self.unary(Unary::Sinh), self.unary(Unary::Cosh));
        }
        let width = Self::width();
        let k = (self * Self::new(std::f64::consts::LOG2_E)).unary(Unary::Round);
        let [high, low] = width.ln_2.map(Self::new);
        let r = (self - k * high) - k * low;
        let power = k.unary(Unary::PowerOfTwo);
        let inverse = (-k).unary(Unary::PowerOfTwo);
        let (a, b) = (
            Self::HALF * (power - inverse),
            Self::HALF * (power + inverse),
        );
        let s = r * r;
        let inverse_factorials = |first: u32| -> Vec<f64> {
            let factorial = |n: u32| (1..=n).map(f64::from).product::<f64>();
            (0..width.terms[0] as u32)
                .map(|k| 1.0 / factorial(first + 2 * k))
                .collect()
        };
        let sinh = r + r * (s * polynomial(s, &inverse_factorials(3)[..width.terms[0] - 1]));
        let cosh = Self::ONE + s * polynomial(s, &inverse_factorials(2));
        (a * cosh + b * sinh, b * cosh + a * sinh)
    }

    fn asinh(self) -> Self {
        if !Self::style().inside {
            return Self::call(Helper::Asinh, self, self);
        }
        let beyond = Self::new((1_u64 << 60) as f64);
        let size = min(self.abs(), beyond);
        let root = (Self::ONE + size * size).sqrt();
        let w = size + root;
        let scaled = w * Self::new(std::f64::consts::FRAC_1_SQRT_2);
        let exponent = scaled.unary(Unary::Exponent) + Self::ONE;
        let m = w * (-exponent).unary(Unary::PowerOfTwo);
        let small = exponent.less(Self::HALF);
        let numerator = Self::select(small, size, m - Self::ONE);
        let f = numerator / (Self::select(small, root, m) + Self::ONE);
        let s = f * f;
        let odds: Vec<f64> = (1..=Self::width().terms[1])
            .map(|k| 1.0 / (2 * k + 1) as f64)
            .collect();
        let artanh = f + f * (s * polynomial(s, &odds));
        let value = exponent * Self::new(std::f64::consts::LN_2) + Self::TWO * artanh;
        value.negated_if(self.less(Self::ZERO))
    }

    fn cbrt(self) -> Self {
        if !Self::style().inside {
            return Self::call(Helper::CubeRoot, self, self);
        }
        let single = !Self::style().double;
        let x = max(self, Self::new(if single { 1e-30 } else { 1e-300 }));
        // What the bits of x above 2^20 of its mantissa say as one number: a third of it is near that of the root.
        let exponent = x.unary(Unary::Exponent);
        let mantissa = x * (-exponent).unary(Unary::PowerOfTwo);
        let grain = Self::new(1_048_576.0);
        let steps = ((mantissa - Self::ONE) * grain).floor();
        let third = if single {
            // f32 has no room for both: exponents are whole numbers of thirds of the grain.
            let scaled = exponent * Self::new(1.0 / 3.0) + steps * Self::new(1.0 / 3_145_728.0);
            scaled - Self::new(0.057)
        } else {
            let high = (exponent + Self::new(1023.0)) * grain + steps;
            let third = high * Self::new(1.0 / 3.0) + Self::new(715_094_163.0);
            third.unary(Unary::Round) / grain - Self::new(1023.0)
        };
        let whole = third.floor();
        let mut t = whole.unary(Unary::PowerOfTwo) * (Self::ONE + (third - whole));
        for _ in 0..3 {
            let cube = t * t * t;
            t = t * ((cube + (x + x)) / ((cube + cube) + x));
        }
        t
    }
}
