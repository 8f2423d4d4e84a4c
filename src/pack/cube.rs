//! `cube`: n × n cells on each face of a cube, n² the largest with 6n² ≤ 2ᵇⁱᵗˢ.
//!
//! Sources: the gnomonic cube; the equi-angular cube (p = tan(πa/4)); S2's quadratic cells (Google's S2
//! geometry library). The code is (face·n + j)·n + i: faces +x -x +y -y +z -z, i and j along the two
//! other axes in the order x, y, z, both upward, at the centers of cells. Ties: x wins over y over z. No
//! direction has two codes. Codes from 6n² on stand for nothing.

use super::chart::{Chart, Charted, Node};
use super::fold::{Rounding, held};
use super::kernel::{Cell, half_turns, sin_cos_half_turns};
use super::{Family, Unit};
use std::sync::Arc;

const LINEAR: u8 = 0;
const EQUIANGULAR: u8 = 1;
const S2: u8 = 2;

#[derive(Clone, Copy)]
struct Cube<const CURVE: u8> {
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
            "equiangular" => Arc::new(Charted(Cube::<EQUIANGULAR> { n })),
            "s2" => Arc::new(Charted(Cube::<S2> { n })),
            _ => Arc::new(Charted(Cube::<LINEAR> { n })),
        }
    },
    ..Family::DEFAULT
};

impl<const CURVE: u8> Cube<CURVE> {
    /// From the plane of a face to even spacing, -1 to 1.
    #[inline(always)]
    fn flat<R: Cell>(p: R) -> R {
        match CURVE {
            EQUIANGULAR => half_turns(p.abs(), R::ONE) * R::new(4.0),
            S2 => (R::ONE + R::new(3.0) * p.abs()).sqrt() - R::ONE,
            _ => p.abs(),
        }
        .negated_if(p < R::ZERO)
    }

    /// Among the centers of cells.
    #[inline(always)]
    fn cell<R: Cell>(self, a: R) -> R {
        (a + R::ONE) * R::new(0.5 * self.n) - R::HALF
    }

    /// Back to the plane.
    #[inline(always)]
    fn curved<R: Cell>(a: R) -> R {
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
    fn place<R: Cell>(self, [x, y, z]: [R; 3]) -> (Node<R>, bool) {
        let zero = R::ZERO;
        let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
        let by_x = (ax >= ay) & (ax >= az);
        let by_y = ay >= az;
        let behind = if by_y { y } else { z };
        let major = if by_x { x } else { behind };
        let p = if by_x { y } else { x };
        let q_side = if by_y { z } else { y };
        let q = if by_x { z } else { q_side };
        let face = if by_y { R::TWO } else { R::new(4.0) };
        let face = if by_x { zero } else { face };
        let face = face + if major < zero { R::ONE } else { zero };
        let inverse = R::ONE / major.abs();
        let i = self.cell(Self::flat(p * inverse));
        let j = self.cell(Self::flat(q * inverse));
        (([i, j], face), true)
    }

    #[inline(always)]
    fn settle<R: Cell>(self, place: [R; 2]) -> [R; 2] {
        let (first, last) = (R::ZERO, R::new(self.n - 1.0));
        [held(place[0], first, last), held(place[1], first, last)]
    }

    #[inline(always)]
    fn direction<R: Cell>(self, ([i, j], face): Node<R>) -> [R; 3] {
        let one = R::ONE;
        let n = R::new(self.n);
        let p = Self::curved((i + i + one) / n - one);
        let q = Self::curved((j + j + one) / n - one);
        let inverse = one / (one + p * p + q * q).sqrt();
        let (p, q) = (p * inverse, q * inverse);
        let axis = (face * R::HALF).floor();
        let m = inverse.negated_if(face > axis + axis);
        let (is_x, is_y) = (axis < R::HALF, axis < R::new(1.5));
        let y_beside = if is_y { m } else { q };
        let z_beside = if is_y { q } else { m };
        [
            if is_x { m } else { p },
            if is_x { p } else { y_beside },
            if is_x { q } else { z_beside },
        ]
    }

    #[inline(always)]
    fn code<R: Cell>(self, ([i, j], face): Node<R>) -> R::Code {
        let n = R::new(self.n);
        ((face * n + j) * n + i).integer()
    }

    #[inline(always)]
    fn node<R: Cell>(self, code: R::Code) -> Node<R> {
        let (n, half) = (R::new(self.n), R::HALF);
        let k = R::from_integer(code);
        let row = ((k + half) / n).floor();
        let face = ((row + half) / n).floor();
        ([k - row * n, row - face * n], face)
    }

    fn step(self) -> f64 {
        1.0 / self.n
    }
}
