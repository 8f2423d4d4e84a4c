//! The three components themselves, each on a grid: `snorm8x3`, `snorm16x3`, `snorm10x3`, `rgb8x3`, `rgb10a2`.
//!
//! Sources: the conversion rules of Direct3D and Vulkan: snorm n = max(k/(2ᵇ⁻¹ - 1), -1), so the field
//! -2ᵇ⁻¹ reads as -1; unorm k/(2ᵇ - 1), which a normal map reads as 2c - 1. Most of the cube lies inside the sphere
//! and its codes are wasted. Decoding normalizes; the code of all zeros has no direction and gives NaN.
//! `precise` takes the best of the eight grid points around the unit vector.
//!
//! Points along one ray from the middle are one direction. Encoding takes a point near the unit sphere and so may
//! write now one of them, now another; the one nearest to the sphere stands for all.

use super::fold::{NEAREST, PRECISE, Rounded, held};
use super::grid::Grid;
use super::printed::{Asked, Formula};
use super::ray;
use super::rounding::Rounding;
use super::unit::unit;
use super::{Family, Scheme, Splits, Unit};
use crate::code::Program;
use crate::code::Words;
use crate::number::real::{max, min};
use crate::pack::kernel;
use crate::pack::kernel::{Cell, Decode, Encode, Lattice};
use std::sync::Arc;

#[derive(Clone, Copy)]
struct Components(Grid);

const ROUNDINGS: &[Rounding] = &[Rounding::Nearest, Rounding::Precise];

/// Three signed numbers.
pub const SNORM: Family = Family {
    name: "snorm",
    title: "Three signed components",
    source: "Direct3D 11.3 functional specification 3.2.3; Vulkan 1.3, 3.9; fields from the lowest bits up",
    summary: "x, y and z as signed normalized integers; what vertex formats read without a shader.",
    bits: &[24, 30, 48],
    roundings: ROUNDINGS,
    splits: Splits::Three {
        components: &[24, 48],
    },
    unit: Unit::Step,
    bounds: &[0.87, 0.71],
    make: |bits, _| Arc::new(Components(Grid::new("snorm", bits / 3))),
    ..Family::DEFAULT
};

/// Three unsigned numbers.
pub const RGB: Family = Family {
    name: "rgb",
    title: "Three color components",
    source: "Direct3D and Vulkan unorm; n = 2c - 1, as in normal maps",
    summary: "x, y and z as the colors of a normal map; no code is exactly on an axis.",
    bits: &[24],
    roundings: ROUNDINGS,
    splits: Splits::Three { components: &[24] },
    unit: Unit::Step,
    bounds: &[0.87, 0.71],
    make: |bits, _| Arc::new(Components(Grid::new("unorm", bits / 3))),
    ..Family::DEFAULT
};

/// Ten bits each and two to spare.
pub const RGB10A2: Family = Family {
    name: "rgb10a2",
    title: "R10G10B10A2",
    source: "DXGI_FORMAT_R10G10B10A2_UNORM, VK_FORMAT_A2B10G10R10_UNORM_PACK32; n = 2c - 1",
    summary: "A G-buffer format: x in the lowest ten bits; the two alpha bits are written as 0 and not read.",
    bits: &[32],
    roundings: ROUNDINGS,
    splits: Splits::Named,
    unit: Unit::Step,
    bounds: &[0.87, 0.71],
    make: |_, _| Arc::new(Components(Grid::new("unorm", 10))),
    ..Family::DEFAULT
};

impl<R: Cell, const ROUNDING: u8> Encode<R> for Rounded<Components, ROUNDING> {
    #[inline(always)]
    fn encode<const NORMAL: bool>(self, d: [R; 3]) -> (R::Code, bool) {
        let grid = self.0.0;
        let ([x, y, z], ok) = self.0.point::<R, NORMAL>(ROUNDING == NEAREST, d);
        let code =
            grid.field(x) | (grid.field(y) << grid.bits) | (grid.field(z) << (2 * grid.bits));
        (R::only_if(ok, code), ok)
    }
}

impl Components {
    /// The grid point of a direction, and whether it is one.
    #[inline(always)]
    fn point<R: Lattice, const NORMAL: bool>(self, nearest: bool, d: [R; 3]) -> ([R; 3], R::Mask) {
        let grid = self.0;
        let (unit, ok) = unit::<R, NORMAL>(d);
        let (n, offset) = (R::new(grid.n), R::new(grid.offset));
        let p = [unit[0].abs() * n, unit[1].abs() * n, unit[2].abs() * n];
        let best = if nearest {
            [
                held((p[0] - offset).nearest() + offset, offset, n),
                held((p[1] - offset).nearest() + offset, offset, n),
                held((p[2] - offset).nearest() + offset, offset, n),
            ]
        } else {
            let [x, y, z] = [
                (p[0] - offset).floor() + offset,
                (p[1] - offset).floor() + offset,
                (p[2] - offset).floor() + offset,
            ];
            let [x0, y0, z0] = [max(x, offset), max(y, offset), max(z, offset)];
            let one = R::ONE;
            let [x1, y1, z1] = [min(x + one, n), min(y + one, n), min(z + one, n)];
            let a = Corner::new(p, [x0, y0, z0]).or_nearer(Corner::new(p, [x1, y0, z0]));
            let b = Corner::new(p, [x0, y1, z0]).or_nearer(Corner::new(p, [x1, y1, z0]));
            let c = Corner::new(p, [x0, y0, z1]).or_nearer(Corner::new(p, [x1, y0, z1]));
            let d = Corner::new(p, [x0, y1, z1]).or_nearer(Corner::new(p, [x1, y1, z1]));
            a.or_nearer(b).or_nearer(c.or_nearer(d)).q
        };
        let zero = R::ZERO;
        let point = [
            best[0].negated_if(d[0].less(zero)),
            best[1].negated_if(d[1].less(zero)),
            best[2].negated_if(d[2].less(zero)),
        ];
        (point, ok)
    }

    /// The code that stands for all of the same direction.
    fn representative(self, code: u64) -> u64 {
        let grid = self.0;
        // A lattice shifted by ½ is that of the odd numbers in half steps.
        let odd = grid.offset > 0.0;
        let parts = if odd { 2.0 } else { 1.0 };
        let shifts = [0, grid.bits, 2 * grid.bits];
        let point = shifts.map(|shift| (grid.place::<f64>(code >> shift) * parts) as i64);
        let chosen = ray::nearest_to_sphere(point, (grid.n * parts) as i64, odd);
        let fields = chosen.map(|x| grid.field::<f64>(x as f64 / parts));
        (0..3).fold(0, |all, k| all | fields[k] << shifts[k])
    }

    /// The direction of a grid point.
    #[inline(always)]
    fn direction<R: Lattice>(self, [x, y, z]: [R; 3]) -> [R; 3] {
        let inverse = R::ONE / (x * x + y * y + z * z).sqrt();
        [x * inverse, y * inverse, z * inverse]
    }
}

impl Formula for Components {
    fn words(self) -> Words {
        Words {
            fields: 3,
            bits: self.0.bits,
        }
    }

    fn pack<R: Lattice>(self, rounding: Rounding, d: [R; 3]) -> Vec<R> {
        let (point, _) = self.point::<R, true>(rounding == Rounding::Nearest, d);
        point.map(|x| self.0.unsigned(x)).to_vec()
    }

    fn unpack<R: Lattice>(self, fields: &[R]) -> [R; 3] {
        self.direction([fields[0], fields[1], fields[2]].map(|x| self.0.of_unsigned(x)))
    }
}

/// A grid point, and the sine squared of the angle to it times |p|².
#[derive(Clone, Copy)]
struct Corner<R> {
    q: [R; 3],
    far: R,
}

impl<R: Lattice> Corner<R> {
    #[inline(always)]
    fn new(p: [R; 3], q: [R; 3]) -> Self {
        let e = [q[0] - p[0], q[1] - p[1], q[2] - p[2]];
        let p2 = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
        let pe = p[0] * e[0] + p[1] * e[1] + p[2] * e[2];
        let e2 = e[0] * e[0] + e[1] * e[1] + e[2] * e[2];
        Corner {
            q,
            far: (p2 * e2 - pe * pe) / (p2 + (pe + pe) + e2),
        }
    }

    /// The nearer one; `self` on ties.
    #[inline(always)]
    fn or_nearer(self, other: Self) -> Self {
        let nearer = other.far.less(self.far);
        Corner {
            q: [
                R::select(nearer, other.q[0], self.q[0]),
                R::select(nearer, other.q[1], self.q[1]),
                R::select(nearer, other.q[2], self.q[2]),
            ],
            far: R::select(nearer, other.far, self.far),
        }
    }
}

impl<R: Cell> Decode<R> for Components {
    #[inline(always)]
    fn decode(self, code: R::Code) -> [R; 3] {
        let b = self.0.bits;
        self.direction([
            self.0.place(code),
            self.0.place(code >> b),
            self.0.place(code >> (2 * b)),
        ])
    }
}

impl Scheme for Components {
    fn encode(&self, rounding: Rounding, d: &[f64], codes: &mut [u64]) -> bool {
        match rounding {
            Rounding::Nearest => kernel::encode(Rounded::<_, NEAREST>(*self), d, codes),
            _ => kernel::encode(Rounded::<_, PRECISE>(*self), d, codes),
        }
    }

    fn decode(&self, codes: &[u64], d: &mut [f64]) {
        kernel::decode(*self, codes, d);
    }

    fn canonical(&self, codes: &mut [u64]) {
        for code in codes {
            *code = self.representative(*code);
        }
    }

    fn step(&self) -> f64 {
        1.0 / self.0.n
    }

    fn program(&self, asked: Asked) -> Option<Program> {
        Some(asked.program(*self))
    }
}
