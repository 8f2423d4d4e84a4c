//! `spherical`: longitude and latitude, half of the bits each.
//!
//! Source: common; in the tables of Cigolle et al. 2014. Longitude atan2(y, x) = 2πi/2ᵇ counts from +x, periodic;
//! the angle from +z is πj/(2ᵇ - 1), both poles exact. At a pole every longitude is the same
//! direction, and the code has i = 0. Codes crowd at the poles: the worst of the common schemes of its
//! size, kept to read what others wrote.

use super::chart::{Chart, Charted, Node};
use super::kernel::{Cell, Lattice, half_turns, sin_cos_half_turns};
use super::oct::EVEN;
use super::rounding::Rounding;
use super::{Family, Splits, Unit};
use crate::code::Words;
use crate::number::real::{max, min};
use std::sync::Arc;

#[derive(Clone, Copy)]
struct Spherical {
    bits: u32,
    /// 2ᵇ, here because the library's power is a call.
    columns: f64,
}

/// Longitude and latitude.
pub const SPHERICAL: Family = Family {
    name: "spherical",
    title: "Longitude and latitude",
    source: "Cigolle et al. 2014; longitude 2πi/2ᵇ, colatitude πj/(2ᵇ - 1)",
    summary: "Two angles; needs sines to decode and wastes codes at the poles.",
    bits: EVEN,
    roundings: &[Rounding::Nearest, Rounding::Precise],
    splits: Splits::Two,
    unit: Unit::Step,
    bounds: &[3.56, 3.56],
    make: |bits, _| Arc::new(Charted(Spherical::new(bits / 2))),
    ..Family::DEFAULT
};

/// The grid point that an azimuth one step around and a row beyond a pole mean. At a pole, azimuth 0.
#[inline(always)]
pub(super) fn around_and_down<R: Lattice>([i, j]: [R; 2], columns: f64) -> [R; 2] {
    let (zero, all) = (R::ZERO, R::new(columns));
    let last = R::new(columns - 1.0);
    let j = min(max(j, zero), last);
    let i = R::select(i.less(zero), i + all, i);
    let i = R::select(i.less(all), i, i - all);
    let pole = j.at_most(zero) | j.at_least(last);
    [R::select(pole, zero, i), j]
}

/// Two unsigned fields.
#[inline(always)]
pub(super) fn split<R: Cell>(code: R::Code, bits: u32) -> Node<R> {
    let mask = R::code((1 << bits) - 1);
    let place = [
        R::from_integer(code & mask),
        R::from_integer((code >> bits) & mask),
    ];
    (place, R::ZERO)
}

impl Spherical {
    fn new(bits: u32) -> Self {
        let columns = f64::from(bits).exp2();
        Spherical { bits, columns }
    }
}

impl Chart for Spherical {
    #[inline(always)]
    fn place<R: Lattice>(self, [x, y, z]: [R; 3]) -> (Node<R>, R::Mask) {
        let zero = R::ZERO;
        let around = half_turns(y.abs(), x).negated_if(y.less(zero));
        let down = half_turns((x * x + y * y).sqrt(), z);
        let columns = self.columns;
        let place = [around * R::new(0.5 * columns), down * R::new(columns - 1.0)];
        ((place, zero), R::truth(true))
    }

    #[inline(always)]
    fn settle<R: Lattice>(self, place: [R; 2]) -> [R; 2] {
        around_and_down(place, self.columns)
    }

    fn representative(self, (place, face): Node<f64>) -> Node<f64> {
        (around_and_down(place, self.columns), face)
    }

    #[inline(always)]
    fn direction<R: Lattice>(self, ([i, j], _): Node<R>) -> [R; 3] {
        let columns = self.columns;
        let (sin, cos) = sin_cos_half_turns(i * R::new(2.0 / columns));
        let (h, z) = sin_cos_half_turns(j / R::new(columns - 1.0));
        [cos * h, sin * h, z]
    }

    #[inline(always)]
    fn code<R: Cell>(self, ([i, j], _): Node<R>) -> R::Code {
        i.integer() | (j.integer() << self.bits)
    }

    #[inline(always)]
    fn node<R: Cell>(self, code: R::Code) -> Node<R> {
        split(code, self.bits)
    }

    fn words(self) -> Words {
        Words {
            fields: 2,
            bits: self.bits,
        }
    }

    fn numbers<R: Lattice>(self, ([i, j], _): Node<R>) -> Vec<R> {
        vec![i, j]
    }

    fn of_numbers<R: Lattice>(self, numbers: &[R]) -> Node<R> {
        ([numbers[0], numbers[1]], R::ZERO)
    }

    fn step(self) -> f64 {
        1.0 / self.columns
    }
}
