//! `hemioct`: the upper half of the octahedron, turned by 45° to fill the square.
//!
//! Source: Cigolle et al. 2014. (s, t) = (x + y, x - y)/|d|₁. Domain: z ≥ 0; below lies nothing, and
//! what `invalid="ignore"` lets pass goes to the horizon. The grid is rectangular on a face (√3:1), so
//! the best of four gains less than on the whole octahedron and hexagonal rounding nothing.

use super::chart::{Chart, Charted, Node};
use super::fold::held;
use super::grid::{GRIDS, Grid};
use super::kernel::{Cell, Lattice};
use super::oct::EVEN;
use super::rounding::Rounding;
use super::{Family, Splits, Unit};
use crate::code::Words;
use crate::number::real::max;
use std::sync::Arc;

#[derive(Clone, Copy)]
struct Hemioct {
    grid: Grid,
    /// The outermost lattice point.
    last: f64,
}

impl Hemioct {
    fn new(grid: Grid) -> Self {
        let last = if grid.reaches_the_end() {
            grid.n
        } else {
            grid.n - grid.offset
        };
        Hemioct { grid, last }
    }
}

/// The upper half of the octahedron.
pub const HEMIOCT: Family = Family {
    name: "hemioct",
    title: "Hemi-octahedral",
    source: "Cigolle et al. 2014, A Survey of Efficient Representations for Independent Unit Vectors",
    summary: "Directions with z ≥ 0, such as tangent-space normals, with half a bit more each way.",
    bits: EVEN,
    variants: &GRIDS,
    roundings: &[Rounding::Nearest, Rounding::Precise],
    splits: Splits::Two,
    hemisphere: true,
    unit: Unit::Step,
    bounds: &[1.23, 1.23],
    make: |bits, grid| Arc::new(Charted(Hemioct::new(Grid::new(grid, bits / 2)))),
    ..Family::DEFAULT
};

impl Chart for Hemioct {
    #[inline(always)]
    fn place<R: Lattice>(self, [x, y, z]: [R; 3]) -> (Node<R>, R::Mask) {
        let zero = R::ZERO;
        let scale = R::new(self.grid.n) / (x.abs() + y.abs() + max(z, zero));
        let offset = R::new(self.grid.offset);
        // A lattice of integers: `settle` brings the offset back.
        let place = [(x + y) * scale - offset, (x - y) * scale - offset];
        ((place, zero), z.at_least(zero))
    }

    #[inline(always)]
    fn settle<R: Lattice>(self, place: [R; 2]) -> [R; 2] {
        let (offset, last) = (R::new(self.grid.offset), R::new(self.last));
        [
            held(place[0] + offset, -last, last),
            held(place[1] + offset, -last, last),
        ]
    }

    #[inline(always)]
    fn direction<R: Lattice>(self, ([s, t], _): Node<R>) -> [R; 3] {
        let half = R::HALF;
        let (x, y) = ((s + t) * half, (s - t) * half);
        let z = max(R::new(self.grid.n) - x.abs() - y.abs(), R::ZERO);
        let inverse = R::ONE / (x * x + y * y + z * z).sqrt();
        [x * inverse, y * inverse, z * inverse]
    }

    #[inline(always)]
    fn code<R: Cell>(self, ([s, t], _): Node<R>) -> R::Code {
        self.grid.field(s) | (self.grid.field(t) << self.grid.bits)
    }

    #[inline(always)]
    fn node<R: Cell>(self, code: R::Code) -> Node<R> {
        let place = [
            self.grid.place(code),
            self.grid.place(code >> self.grid.bits),
        ];
        (place, R::ZERO)
    }

    fn words(self) -> Words {
        Words {
            fields: 2,
            bits: self.grid.bits,
        }
    }

    fn numbers<R: Lattice>(self, ([s, t], _): Node<R>) -> Vec<R> {
        [s, t].map(|x| self.grid.unsigned(x)).to_vec()
    }

    fn of_numbers<R: Lattice>(self, numbers: &[R]) -> Node<R> {
        let place = [numbers[0], numbers[1]].map(|x| self.grid.of_unsigned(x));
        (place, R::ZERO)
    }

    fn step(self) -> f64 {
        1.0 / self.grid.n
    }
}
