//! `cube`: n × n cells on each face of a cube, n² the largest with 6n² ≤ 2ᵇⁱᵗˢ.
//!
//! Sources: the gnomonic cube; the equi-angular cube (p = tan(πa/4)); S2's quadratic cells (Google's S2
//! geometry library). The code is (face·n + j)·n + i: faces +x -x +y -y +z -z, i and j along the two
//! other axes in the order x, y, z, both upward, at the centers of cells. Ties: x wins over y over z. No
//! direction has two codes. Codes from 6n² on stand for nothing.

use super::chart::{Chart, Charted, Node};
use super::fold::held;
use super::kernel::{Cell, Lattice, half_turns, sin_cos_half_turns};
use super::rounding::Rounding;
use super::{Family, Unit};
use crate::code::Words;
use std::sync::Arc;

const LINEAR: u8 = 0;
const EQUIANGULAR: u8 = 1;
const S2: u8 = 2;

#[derive(Clone, Copy)]
struct Cube<const CURVE: u8> {
    bits: u32,
    n: f64,
}

fn side(bits: u32) -> f64 {
    ((bits as f64).exp2() / 6.0).sqrt().floor()
}

/// Cells on a cube.
pub const CUBE: Family = Family {
    name: "cube",
    title: "Cube",
    source: "Gnomonic cube; equiangular: Ronchi et al. 1996; s2: S2 geometry's quadratic transform",
    summary: "Cells of a cube's faces, spaced evenly in the plane, in angle, or as in S2.",
    bits: &[
        8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30, 32, 34, 36, 38, 40, 42, 44, 46, 48,
    ],
    variants: &["linear", "equiangular", "s2"],
    roundings: &[Rounding::Nearest, Rounding::Precise],
    unit: Unit::Step,
    bounds: &[1.4143, 1.4143],
    codes: |bits| 6 * (side(bits) as u64).pow(2),
    make: |bits, curve| {
        let n = side(bits);
        match curve {
            "equiangular" => Arc::new(Charted(Cube::<EQUIANGULAR> { bits, n })),
            "s2" => Arc::new(Charted(Cube::<S2> { bits, n })),
            _ => Arc::new(Charted(Cube::<LINEAR> { bits, n })),
        }
    },
    ..Family::DEFAULT
};

impl<const CURVE: u8> Cube<CURVE> {
    /// From the plane of a face to even spacing, -1 to 1.
    #[inline(always)]
    fn flat<R: Lattice>(p: R) -> R {
        match CURVE {
            EQUIANGULAR => half_turns(p.abs(), R::ONE) * R::new(4.0),
            S2 => (R::ONE + R::new(3.0) * p.abs()).sqrt() - R::ONE,
            _ => p.abs(),
        }
        .negated_if(p.less(R::ZERO))
    }

    /// Among the centers of cells.
    #[inline(always)]
    fn cell<R: Lattice>(self, a: R) -> R {
        (a + R::ONE) * R::new(0.5 * self.n) - R::HALF
    }

    /// The number of a cell, which is its code.
    #[inline(always)]
    fn number<R: Lattice>(self, ([i, j], face): Node<R>) -> R {
        let n = R::new(self.n);
        (face * n + j) * n + i
    }

    /// The cell of a number.
    #[inline(always)]
    fn cell_of<R: Lattice>(self, k: R) -> Node<R> {
        let (n, half) = (R::new(self.n), R::HALF);
        let row = ((k + half) / n).floor();
        let face = ((row + half) / n).floor();
        ([k - row * n, row - face * n], face)
    }

    /// Back to the plane.
    #[inline(always)]
    fn curved<R: Lattice>(a: R) -> R {
        match CURVE {
            EQUIANGULAR => {
                let (sin, cos) = sin_cos_half_turns(a * R::new(0.25));
                sin / cos
            }
            S2 => a * (R::TWO + a.abs()) / R::new(3.0),
            _ => a,
        }
    }
}

impl<const CURVE: u8> Chart for Cube<CURVE> {
    #[inline(always)]
    fn place<R: Lattice>(self, [x, y, z]: [R; 3]) -> (Node<R>, R::Mask) {
        let zero = R::ZERO;
        let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
        let by_x = ax.at_least(ay) & ax.at_least(az);
        let by_y = ay.at_least(az);
        let major = R::select(by_x, x, R::select(by_y, y, z));
        let p = R::select(by_x, y, x);
        let q = R::select(by_x, z, R::select(by_y, z, y));
        let face = R::select(by_x, zero, R::select(by_y, R::TWO, R::new(4.0)));
        let face = face + R::select(major.less(zero), R::ONE, zero);
        let inverse = R::ONE / major.abs();
        let i = self.cell(Self::flat(p * inverse));
        let j = self.cell(Self::flat(q * inverse));
        (([i, j], face), R::truth(true))
    }

    #[inline(always)]
    fn settle<R: Lattice>(self, place: [R; 2]) -> [R; 2] {
        let (first, last) = (R::ZERO, R::new(self.n - 1.0));
        [held(place[0], first, last), held(place[1], first, last)]
    }

    #[inline(always)]
    fn direction<R: Lattice>(self, ([i, j], face): Node<R>) -> [R; 3] {
        let one = R::ONE;
        let n = R::new(self.n);
        let p = Self::curved((i + i + one) / n - one);
        let q = Self::curved((j + j + one) / n - one);
        let inverse = one / (one + p * p + q * q).sqrt();
        let (p, q) = (p * inverse, q * inverse);
        let axis = (face * R::HALF).floor();
        let m = inverse.negated_if(face.more(axis + axis));
        let (is_x, is_y) = (axis.less(R::HALF), axis.less(R::new(1.5)));
        let y_beside = R::select(is_y, m, q);
        let z_beside = R::select(is_y, q, m);
        [
            R::select(is_x, m, p),
            R::select(is_x, p, y_beside),
            R::select(is_x, q, z_beside),
        ]
    }

    #[inline(always)]
    fn code<R: Cell>(self, node: Node<R>) -> R::Code {
        self.number(node).integer()
    }

    #[inline(always)]
    fn node<R: Cell>(self, code: R::Code) -> Node<R> {
        self.cell_of(R::from_integer(code))
    }

    fn words(self) -> Words {
        Words {
            fields: 1,
            bits: self.bits,
        }
    }

    fn numbers<R: Lattice>(self, node: Node<R>) -> Vec<R> {
        vec![self.number(node)]
    }

    fn of_numbers<R: Lattice>(self, numbers: &[R]) -> Node<R> {
        self.cell_of(numbers[0])
    }

    fn step(self) -> f64 {
        1.0 / self.n
    }
}
