//! Schemes that are a chart of the sphere with a grid on it: round in the chart, compare on the sphere.
//!
//! `precise` takes the best of the four grid points around, each decoded. In float64 throughout: the
//! square of a chord of 10⁻⁹ still has seven digits there.

use super::Scheme;
use super::fold::{NEAREST, PRECISE, Rounded};
use super::printed::{Asked, Formula};
use super::rounding::Rounding;
use super::unit::unit;
use crate::code::Program;
use crate::code::Words;
use crate::pack::kernel;
use crate::pack::kernel::{Cell, Decode, Encode, Lattice};

/// A grid point: two coordinates that are integers, and a face.
pub type Node<R> = ([R; 2], R);

/// A map with a grid.
pub trait Chart: Copy + Send + Sync + 'static {
    /// Where a unit vector lies among the grid points, and whether the map covers it.
    fn place<R: Lattice>(self, d: [R; 3]) -> (Node<R>, R::Mask);

    /// The grid point that coordinates one step beyond an edge mean.
    fn settle<R: Lattice>(self, place: [R; 2]) -> [R; 2];

    /// The grid point that stands for all of the same direction.
    fn representative(self, node: Node<f64>) -> Node<f64> {
        node
    }

    /// The unit vector of a grid point.
    fn direction<R: Lattice>(self, node: Node<R>) -> [R; 3];

    /// The code of a grid point.
    fn code<R: Cell>(self, node: Node<R>) -> R::Code;

    /// The grid point of a code.
    fn node<R: Cell>(self, code: R::Code) -> Node<R>;

    /// How a code is made of numbers.
    fn words(self) -> Words;

    /// The numbers of a grid point's code, none below zero.
    fn numbers<R: Lattice>(self, node: Node<R>) -> Vec<R>;

    /// The grid point of such numbers.
    fn of_numbers<R: Lattice>(self, numbers: &[R]) -> Node<R>;

    /// The step of the grid, of which the bounds are multiples.
    fn step(self) -> f64;
}

/// A chart as a scheme.
#[derive(Clone, Copy, Debug)]
pub struct Charted<C>(pub C);

impl<R: Cell, C: Chart, const ROUNDING: u8> Encode<R> for Rounded<Charted<C>, ROUNDING> {
    #[inline(always)]
    fn encode<const NORMAL: bool>(self, [x, y, z]: [R; 3]) -> (R::Code, bool) {
        let chart = self.0.0;
        let (node, ok, covered) = chosen::<R, C, NORMAL>(chart, ROUNDING == NEAREST, [x, y, z]);
        (R::only_if(ok, chart.code(node)), ok & covered)
    }
}

/// The grid point of a direction, whether it is one, and whether the map covers it.
#[inline(always)]
fn chosen<R: Lattice, C: Chart, const NORMAL: bool>(
    chart: C,
    nearest: bool,
    d: [R; 3],
) -> (Node<R>, R::Mask, R::Mask) {
    let (d, ok) = unit::<R, NORMAL>(d);
    let (([s, t], face), covered) = chart.place(d);
    if nearest {
        let node = (chart.settle([s.nearest(), t.nearest()]), face);
        return (node, ok, covered);
    }
    let (s0, t0) = (s.floor(), t.floor());
    let (s1, t1) = (s0 + R::ONE, t0 + R::ONE);
    let first = Corner::new(chart, d, [s0, t0], face);
    let second = Corner::new(chart, d, [s1, t0], face);
    let third = Corner::new(chart, d, [s0, t1], face);
    let fourth = Corner::new(chart, d, [s1, t1], face);
    let Corner { node, .. } = first.or_nearer(second).or_nearer(third.or_nearer(fourth));
    ((node, face), ok, covered)
}

/// A direction without a zero below zero.
#[inline(always)]
fn direction<R: Lattice, C: Chart>(chart: C, node: Node<R>) -> [R; 3] {
    let zero = R::ZERO;
    let d: [R; 3] = chart.direction(node);
    [d[0] + zero, d[1] + zero, d[2] + zero]
}

impl<C: Chart> Formula for Charted<C> {
    fn words(self) -> Words {
        self.0.words()
    }

    fn pack<R: Lattice>(self, rounding: Rounding, d: [R; 3]) -> Vec<R> {
        let (node, ..) = chosen::<R, C, true>(self.0, rounding == Rounding::Nearest, d);
        self.0.numbers(node)
    }

    fn unpack<R: Lattice>(self, numbers: &[R]) -> [R; 3] {
        direction(self.0, self.0.of_numbers(numbers))
    }
}

/// A grid point, and the square of the chord to it.
#[derive(Clone, Copy)]
struct Corner<R> {
    node: [R; 2],
    far: R,
}

impl<R: Lattice> Corner<R> {
    #[inline(always)]
    fn new<C: Chart>(chart: C, d: [R; 3], place: [R; 2], face: R) -> Self {
        let node = chart.settle(place);
        let q = chart.direction((node, face));
        let e = [q[0] - d[0], q[1] - d[1], q[2] - d[2]];
        Corner {
            node,
            far: e[0] * e[0] + e[1] * e[1] + e[2] * e[2],
        }
    }

    /// The nearer one; `self` on ties.
    #[inline(always)]
    fn or_nearer(self, other: Self) -> Self {
        let nearer = other.far.less(self.far);
        Corner {
            node: [
                R::select(nearer, other.node[0], self.node[0]),
                R::select(nearer, other.node[1], self.node[1]),
            ],
            far: R::select(nearer, other.far, self.far),
        }
    }
}

impl<C: Chart> Scheme for Charted<C> {
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
        let chart = self.0;
        for code in codes {
            *code = chart.code::<f64>(chart.representative(chart.node::<f64>(*code)));
        }
    }

    fn step(&self) -> f64 {
        self.0.step()
    }

    fn program(&self, asked: Asked) -> Option<Program> {
        Some(asked.program(*self))
    }
}

impl<R: Cell, C: Chart> Decode<R> for Charted<C> {
    #[inline(always)]
    fn decode(self, code: R::Code) -> [R; 3] {
        direction(self.0, self.0.node(code))
    }
}
