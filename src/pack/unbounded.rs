//! Schemes to read old data with, and not to choose: `sphere`, `matcap`, `z_phi`.
//!
//! Sources: the sphere map (p, q) = (x, y)/√(2(1 + z)), alias Lambert's azimuthal equal-area map; the two
//! components x and y of a normal that faces the viewer; z and the azimuth. Somewhere in each of them, the
//! rim, the horizon or the poles, the error falls with the root of the step and not with the step: no
//! multiple of the step bounds it, and the Python layer warns.
//!
//! Domain: `sphere` all directions, -z is the whole rim and is written where the formula's limit along +x lies;
//! `matcap` z ≥ 0. Codes outside the disk decode as on its rim and are not written; of those of `matcap` along one ray
//! the first stands for all.

use super::chart::{Chart, Charted, Node};
use super::fold::held;
use super::grid::Grid;
use super::kernel::{Cell, Lattice, half_turns, sin_cos_half_turns};
use super::oct::EVEN;
use super::ray;
use super::rounding::Rounding;
use super::{Family, Splits, Unit};
use crate::code::Words;
use crate::number::real::max;
use std::sync::Arc;

const ROUNDINGS: &[Rounding] = &[Rounding::Nearest, Rounding::Precise];
const NONE: &[f64] = &[f64::INFINITY, f64::INFINITY];

/// The sphere map.
pub const SPHERE: Family = Family {
    name: "sphere",
    title: "Sphere map",
    source: "OpenGL GL_SPHERE_MAP; Lambert azimuthal equal-area; once common in G-buffers",
    summary: "Not recommended: errors of fourteen degrees at -z in 16 bits.",
    bits: EVEN,
    roundings: ROUNDINGS,
    splits: Splits::Two,
    unit: Unit::Step,
    bounds: NONE,
    make: |bits, _| Arc::new(Charted(Disk::<true>(Grid::new("snorm", bits / 2)))),
    ..Family::DEFAULT
};

/// Two components of a normal.
pub const MATCAP: Family = Family {
    name: "matcap",
    title: "x and y",
    source: "Two-channel normal maps (BC5, 3Dc); z = √(1 - x² - y²)",
    summary: "Not recommended but at z near 1: errors of seven degrees at the horizon in 16 bits.",
    bits: EVEN,
    roundings: ROUNDINGS,
    splits: Splits::Two,
    hemisphere: true,
    unit: Unit::Step,
    bounds: NONE,
    make: |bits, _| Arc::new(Charted(Disk::<false>(Grid::new("snorm", bits / 2)))),
    ..Family::DEFAULT
};

/// Height and azimuth.
pub const Z_PHI: Family = Family {
    name: "z_phi",
    title: "z and azimuth",
    source: "Archimedes' equal-area cylinder: azimuth 2πi/2ᵇ, z = 1 - 2j/(2ᵇ - 1)",
    summary: "Not recommended: errors of five degrees at the poles in 16 bits.",
    bits: EVEN,
    roundings: ROUNDINGS,
    splits: Splits::Two,
    unit: Unit::Step,
    bounds: NONE,
    make: |bits, _| Arc::new(Charted(Cylinder::new(bits / 2))),
    ..Family::DEFAULT
};

/// The sphere map, or for a hemisphere the two components.
#[derive(Clone, Copy)]
struct Disk<const WHOLE: bool>(Grid);

impl<const WHOLE: bool> Disk<WHOLE> {
    /// One step nearer to the middle, for a point outside the disk: only codes inside are written.
    #[inline(always)]
    fn inward<R: Lattice>(self, [p, q]: [R; 2]) -> [R; 2] {
        let (zero, one, n) = (R::ZERO, R::ONE, R::new(self.0.n));
        let outside = (p * p + q * q).more(n * n);
        let along_p = p.abs().at_least(q.abs());
        let step_p = R::select(outside & along_p, one.negated_if(p.less(zero)), zero);
        let step_q = R::select(outside & !along_p, one.negated_if(q.less(zero)), zero);
        [p - step_p, q - step_q]
    }

    /// The point that is written for one on the rim of the sphere map, all of which is -z.
    #[inline(always)]
    fn one_rim<R: Lattice>(self, [p, q]: [R; 2]) -> [R; 2] {
        let n = R::new(self.0.n);
        let on_rim = (p * p + q * q).at_least(n * n);
        [R::select(on_rim, n, p), R::select(on_rim, R::ZERO, q)]
    }

    /// The point that stands for one outside the disk of the two components, where a ray is one direction.
    fn one_ray(self, place: [f64; 2]) -> [f64; 2] {
        let (point, n) = (place.map(|x| x as i64), self.0.n as i64);
        let outside = point[0].pow(2) + point[1].pow(2) > n.pow(2);
        if outside {
            ray::first_beyond_circle(point, n).map(|x| x as f64)
        } else {
            place
        }
    }
}

impl<const WHOLE: bool> Chart for Disk<WHOLE> {
    #[inline(always)]
    fn place<R: Lattice>(self, [x, y, z]: [R; 3]) -> (Node<R>, R::Mask) {
        let (zero, one, n) = (R::ZERO, R::ONE, R::new(self.0.n));
        let h2 = x * x + y * y;
        if !WHOLE {
            // What lies below the horizon goes to it.
            let h = max(h2.sqrt(), R::new(1e-30));
            let scale = R::select(z.less(zero), n / h, n);
            return (([x * scale, y * scale], zero), z.at_least(zero));
        }
        // w = 1 + z without cancellation; 0 at -z alone.
        let w = R::select(z.less(zero), h2 / (one - z), one + z);
        let blind = w.at_most(R::new(1e-300));
        let scale = n / (w + w).sqrt();
        let p = R::select(blind, n, x * scale);
        let q = R::select(blind, zero, y * scale);
        (([p, q], zero), R::truth(true))
    }

    #[inline(always)]
    fn settle<R: Lattice>(self, place: [R; 2]) -> [R; 2] {
        let n = R::new(self.0.n);
        let place = [held(place[0], -n, n), held(place[1], -n, n)];
        // A corner beyond the rim is off by less than a step along its longer side, or two.
        let inside = self.inward(self.inward(place));
        if WHOLE { self.one_rim(inside) } else { inside }
    }

    fn representative(self, (place, face): Node<f64>) -> Node<f64> {
        if WHOLE {
            (self.one_rim(place), face)
        } else {
            (self.one_ray(place), face)
        }
    }

    #[inline(always)]
    fn direction<R: Lattice>(self, ([p, q], _): Node<R>) -> [R; 3] {
        let (zero, one) = (R::ZERO, R::ONE);
        let (p, q) = (p / R::new(self.0.n), q / R::new(self.0.n));
        let r2 = p * p + q * q;
        let inside = r2.at_most(one);
        let to_rim = one / max(r2, one).sqrt();
        let (p, q) = (p * to_rim, q * to_rim);
        let rest = R::select(inside, one - r2, zero);
        if WHOLE {
            let h = rest.sqrt();
            let h = h + h;
            let z = R::select(inside, rest + rest - one, -one);
            [p * h, q * h, z]
        } else {
            [p, q, rest.sqrt()]
        }
    }

    #[inline(always)]
    fn code<R: Cell>(self, ([p, q], _): Node<R>) -> R::Code {
        self.0.field(p) | (self.0.field(q) << self.0.bits)
    }

    #[inline(always)]
    fn node<R: Cell>(self, code: R::Code) -> Node<R> {
        let place = [self.0.place(code), self.0.place(code >> self.0.bits)];
        (place, R::ZERO)
    }

    fn words(self) -> Words {
        Words {
            fields: 2,
            bits: self.0.bits,
        }
    }

    fn numbers<R: Lattice>(self, ([s, t], _): Node<R>) -> Vec<R> {
        [s, t].map(|x| self.0.unsigned(x)).to_vec()
    }

    fn of_numbers<R: Lattice>(self, numbers: &[R]) -> Node<R> {
        let place = [numbers[0], numbers[1]].map(|x| self.0.of_unsigned(x));
        (place, R::ZERO)
    }

    fn step(self) -> f64 {
        1.0 / self.0.n
    }
}

#[derive(Clone, Copy)]
struct Cylinder {
    bits: u32,
    /// 2ᵇ.
    columns: f64,
}

impl Cylinder {
    fn new(bits: u32) -> Self {
        let columns = f64::from(bits).exp2();
        Cylinder { bits, columns }
    }
}

impl Chart for Cylinder {
    #[inline(always)]
    fn place<R: Lattice>(self, [x, y, z]: [R; 3]) -> (Node<R>, R::Mask) {
        let (zero, columns) = (R::ZERO, self.columns);
        let around = half_turns(y.abs(), x).negated_if(y.less(zero));
        let down = (R::ONE - z) * R::new(0.5 * (columns - 1.0));
        (
            ([around * R::new(0.5 * columns), down], zero),
            R::truth(true),
        )
    }

    #[inline(always)]
    fn settle<R: Lattice>(self, place: [R; 2]) -> [R; 2] {
        super::spherical::around_and_down(place, self.columns)
    }

    fn representative(self, (place, face): Node<f64>) -> Node<f64> {
        (super::spherical::around_and_down(place, self.columns), face)
    }

    #[inline(always)]
    fn direction<R: Lattice>(self, ([i, j], _): Node<R>) -> [R; 3] {
        let columns = self.columns;
        let (sin, cos) = sin_cos_half_turns(i * R::new(2.0 / columns));
        let t = (j + j) / R::new(columns - 1.0);
        let h = (t * (R::TWO - t)).sqrt();
        [cos * h, sin * h, R::ONE - t]
    }

    #[inline(always)]
    fn code<R: Cell>(self, ([i, j], _): Node<R>) -> R::Code {
        i.integer() | (j.integer() << self.bits)
    }

    #[inline(always)]
    fn node<R: Cell>(self, code: R::Code) -> Node<R> {
        super::spherical::split(code, self.bits)
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
        (-(self.bits as f64)).exp2()
    }
}
