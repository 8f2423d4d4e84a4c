//! Octahedral schemes: a lattice on the unfolded octahedron, and how to round on it.
//!
//! Sources: Meyer et al. 2010, On Floating-Point Normal Vectors; Cigolle et al. 2014, A Survey of Efficient
//! Representations for Independent Unit Vectors (the best of four). Rounding in barycentrics is the
//! hexagonal rounding of cube coordinates, and on the octahedron ours.
//!
//! # One octant is enough
//!
//! |d| as barycentrics (A, B, C) of its octant, in steps, A + B + C = n. The upper half of the square holds
//! (A, B), the lower one (n - B, n - A), with the signs of x and y. So both halves round the
//! same lattice in (A, B), shifted by `upper` or `lower`; the four corners of a cell are the same four
//! candidates; and a candidate with C < 0 lies beyond the crease, at (A + C, B + C, C). A candidate across
//! the plane x = 0 or y = 0 is the mirror image of one on our side, and never nearer: those are
//! left out.
//!
//! # Rounding
//!
//! - nearest: A and B each by itself. Error at most (3/√2)δ, δ = 1/n.
//! - precise: the candidate nearest on the sphere. At most √2·δ. The lattice on a face is triangular, so
//!   its cells become hexagons, and three of the four need a look. Distances come from differences:
//!   with e the way from p to the candidate q, sin² = (|p|²|e|² - (p·e)²)/(|p|²|q|²). A dot product of unit
//!   vectors is 1 minus 10⁻⁹ here, and float32 could not tell two of them apart.
//! - hex: round A, B and C, and correct the one that moved furthest. It is the nearest in the plane of the
//!   face; no candidate is decoded.
//!
//! # What a code is
//!
//! Fields of x and y, x in the low bits. Where the square's edge meets itself the signs are +, so that each
//! direction has one code; -z is the corner (1, 1).
//!
//! # Warps
//!
//! A [`Warp`] says which point of an octant has these barycentrics: the plain octahedron; `woct`, where
//! they go through t(1 + k(1 - t)) to even out the density; or Clarberg's equal-area map.

use super::grid::Grid;
use super::kernel::{Cell, Decode, Encode, Lattice, half_turns, sin_cos_half_turns};
use super::printed::Formula;
use super::rounding::Rounding;
use crate::code::Words;
use crate::number::real::{max, min};

/// From barycentrics of an octant to directions in it, and back.
pub trait Warp: Copy + Send + Sync + 'static {
    /// Whether the nearest corner of a cell belongs to the lattice's triangle around the place. Brute
    /// force found no exception on the plain and on the warped octahedron.
    const TRIANGLES: bool;

    /// Whether a point is its barycentrics.
    const PLAIN: bool = false;

    /// Barycentrics, in steps, of a direction without signs. `sum` is the sum of its components.
    fn barycentrics<R: Lattice>(self, a: [R; 3], sum: R, n: R) -> [R; 3];

    /// A vector along the direction of barycentrics that sum to n, of which the third may be negative, and
    /// gives the vector its sign.
    fn point<R: Lattice>(self, b: [R; 3], n: R) -> [R; 3];

    /// point(to) - point(from), without cancellation where that can be had.
    #[inline(always)]
    fn step<R: Lattice>(self, from: [R; 3], to: [R; 3], n: R) -> [R; 3] {
        let (p, q) = (self.point(from, n), self.point(to, n));
        [q[0] - p[0], q[1] - p[1], q[2] - p[2]]
    }
}

/// The plain octahedron.
#[derive(Clone, Copy, Debug)]
pub struct Plain;

impl Warp for Plain {
    const TRIANGLES: bool = true;
    const PLAIN: bool = true;

    #[inline(always)]
    fn barycentrics<R: Lattice>(self, [x, y, z]: [R; 3], sum: R, n: R) -> [R; 3] {
        let scale = n / sum;
        [x * scale, y * scale, z * scale]
    }

    #[inline(always)]
    fn point<R: Lattice>(self, b: [R; 3], _: R) -> [R; 3] {
        b
    }
}

/// The octahedron with evened-out density: direction ∝ f(b), f(t) = t(1 + k(1 - t)).
#[derive(Clone, Copy, Debug)]
pub struct Warped;

/// Makes the density vary by 1.396:1 instead of 5.196:1.
const K: f64 = 11.0 / 16.0;

impl Warp for Warped {
    const TRIANGLES: bool = true;

    #[inline(always)]
    fn barycentrics<R: Lattice>(self, a: [R; 3], sum: R, n: R) -> [R; 3] {
        let scale = R::ONE / sum;
        let a = [a[0] * scale, a[1] * scale, a[2] * scale];
        let b = newton(a, newton(a, newton(a, newton(a, a))));
        // Below 0 by a rounding only.
        let zero = R::ZERO;
        [
            max(b[0], zero) * n,
            max(b[1], zero) * n,
            max(b[2], zero) * n,
        ]
    }

    #[inline(always)]
    fn point<R: Lattice>(self, [a, b, c]: [R; 3], n: R) -> [R; 3] {
        let k = R::new(K) / n;
        let slope = R::new(1.0 + K);
        [
            a * (slope - k * a),
            b * (slope - k * b),
            c * (slope - k * c.abs()),
        ]
    }

    #[inline(always)]
    fn step<R: Lattice>(self, from: [R; 3], to: [R; 3], n: R) -> [R; 3] {
        let k = R::new(K) / n;
        let slope = R::new(1.0 + K);
        let (p, q) = (from[2], to[2]);
        // q|q| - p|p| is -(q² + p²) across the crease.
        let squares = R::select(q.less(R::ZERO), -(q * q + p * p), (q - p) * (q + p));
        [
            (to[0] - from[0]) * (slope - k * (from[0] + to[0])),
            (to[1] - from[1]) * (slope - k * (from[1] + to[1])),
            (q - p) * slope - k * squares,
        ]
    }
}

/// One step of Newton's method on f(bᵢ) = λaᵢ, Σbᵢ = 1: with gᵢ = 1/f'(bᵢ),
/// λ = (1 + kΣgᵢbᵢ²)/Σgᵢaᵢ and bᵢ ← gᵢ(λaᵢ - kbᵢ²).
#[inline(always)]
fn newton<R: Lattice>(a: [R; 3], b: [R; 3]) -> [R; 3] {
    let (k, slope) = (R::new(K), R::new(1.0 + K));
    let twice = k + k;
    let (s0, s1, s2) = (
        slope - twice * b[0],
        slope - twice * b[1],
        slope - twice * b[2],
    );
    // All three with the product of the slopes as a common factor.
    let (g0, g1, g2) = (s1 * s2, s2 * s0, s0 * s1);
    let (q0, q1, q2) = (k * (b[0] * b[0]), k * (b[1] * b[1]), k * (b[2] * b[2]));
    let all = s0 * g0;
    let lambda = (all + (g0 * q0 + g1 * q1 + g2 * q2)) / (g0 * a[0] + g1 * a[1] + g2 * a[2]);
    let inverse = R::ONE / all;
    [
        g0 * inverse * (lambda * a[0] - q0),
        g1 * inverse * (lambda * a[1] - q1),
        g2 * inverse * (lambda * a[2] - q2),
    ]
}

/// Clarberg's equal-area map: 1 - |z| = r², azimuth ∝ the place between the two sides.
#[derive(Clone, Copy, Debug)]
pub struct EqualArea;

impl Warp for EqualArea {
    const TRIANGLES: bool = false;

    #[inline(always)]
    fn barycentrics<R: Lattice>(self, [x, y, z]: [R; 3], _: R, n: R) -> [R; 3] {
        let h2 = x * x + y * y;
        let length = (h2 + z * z).sqrt();
        let radius = (h2 / (length * (length + z))).sqrt();
        let turn = half_turns(y, x) * R::TWO;
        let r = min(radius, R::ONE) * n;
        let b = r * turn;
        [r - b, b, n - r]
    }

    #[inline(always)]
    fn point<R: Lattice>(self, [a, b, c]: [R; 3], n: R) -> [R; 3] {
        let sum = max(a + b, R::new(1e-30));
        let radius = (a + b) / n;
        let (sin, cos) = sin_cos_half_turns(b / sum * R::HALF);
        let square = radius * radius;
        let h = radius * max(R::TWO - square, R::ZERO).sqrt();
        let z = R::ONE - square;
        [cos * h, sin * h, z.negated_if(c.less(R::ZERO))]
    }
}

pub(super) const NEAREST: u8 = 0;
pub(super) const PRECISE: u8 = 1;
pub(super) const HEX: u8 = 2;

/// A number held between two others.
#[inline(always)]
pub(super) fn held<R: Lattice>(x: R, low: R, high: R) -> R {
    min(max(x, low), high)
}

/// One octahedral scheme.
#[derive(Clone, Copy, Debug)]
pub struct Fold<F> {
    /// What lies at these barycentrics.
    pub warp: F,
    /// Of both coordinates.
    pub grid: Grid,
    /// The lattice's offset in the lower half: the distance of ±n from it.
    pub lower: f64,
    /// The offset of the third barycentric.
    third: f64,
}

impl<F: Warp> Fold<F> {
    /// On this grid.
    pub fn new(warp: F, grid: Grid) -> Self {
        let lower = if grid.reaches_the_end() { 0.0 } else { 0.5 };
        let third = (grid.n - 2.0 * grid.offset).fract();
        Fold {
            warp,
            grid,
            lower,
            third,
        }
    }
}

/// A scheme with its rounding.
#[derive(Clone, Copy)]
pub(super) struct Rounded<S, const ROUNDING: u8>(pub S);

/// A direction on a fold: where it is in its octant, and which octant.
struct OctantPlace<R: Lattice> {
    b: [R; 3],
    lower: R::Mask,
    negative: [R::Mask; 2],
    ok: R::Mask,
}

/// A lattice point, and the sine squared of the angle to it, times |p|², as a quotient.
#[derive(Clone, Copy)]
struct Candidate<R> {
    a: R,
    b: R,
    far: R,
    square: R,
}

impl<R: Lattice> Candidate<R> {
    /// The nearer one; `self` on ties.
    #[inline(always)]
    fn or_nearer(self, other: Self) -> Self {
        let nearer = (other.far * self.square).less(self.far * other.square);
        Candidate {
            a: R::select(nearer, other.a, self.a),
            b: R::select(nearer, other.b, self.b),
            far: R::select(nearer, other.far, self.far),
            square: R::select(nearer, other.square, self.square),
        }
    }
}

impl<F: Warp> Fold<F> {
    #[inline(always)]
    fn place<R: Lattice, const NORMAL: bool>(self, [x, y, z]: [R; 3]) -> OctantPlace<R> {
        let zero = R::ZERO;
        let mut a = [x.abs(), y.abs(), z.abs()];
        if !NORMAL {
            let scale = max(a[0], max(a[1], a[2])).binade_scale();
            a = [a[0] * scale, a[1] * scale, a[2] * scale];
        }
        let sum = a[0] + a[1] + a[2];
        let ok = R::truth(NORMAL) | (sum.more(zero) & sum.finite());
        OctantPlace {
            b: self.warp.barycentrics(a, sum, R::new(self.grid.n)),
            lower: z.less(zero),
            negative: [x.less(zero), y.less(zero)],
            ok,
        }
    }

    /// Corners of the cell that a place lies in: two values of A, two of B.
    #[inline(always)]
    fn cell<R: Lattice>(self, place: &OctantPlace<R>) -> [[R; 2]; 2] {
        let (offset, last) = self.range(place);
        let a = (place.b[0] - offset).floor() + offset;
        let b = (place.b[1] - offset).floor() + offset;
        let one = R::ONE;
        [
            [max(a, offset), min(a + one, last)],
            [max(b, offset), min(b + one, last)],
        ]
    }

    /// The lattice's first and last place along a side of the octant.
    #[inline(always)]
    fn range<R: Lattice>(self, place: &OctantPlace<R>) -> (R, R) {
        let (up, low) = (self.grid.offset, self.lower);
        let (n_up, n_low) = (self.grid.n - low, self.grid.n - up);
        let choose = |low, up| R::select(place.lower, R::new(low), R::new(up));
        (choose(low, up), choose(n_low, n_up))
    }

    /// A lattice point on the square.
    #[inline(always)]
    fn unfolded<R: Lattice>(self, place: &OctantPlace<R>, a: R, b: R) -> [R; 2] {
        let n = R::new(self.grid.n);
        let s = R::select(place.lower, n - b, a);
        let t = R::select(place.lower, n - a, b);
        // On an edge of the square the other coordinate's sign says nothing.
        [
            s.negated_if(place.negative[0] & t.less(n)),
            t.negated_if(place.negative[1] & s.less(n)),
        ]
    }

    #[inline(always)]
    fn nearest<R: Lattice>(self, place: &OctantPlace<R>) -> [R; 2] {
        let (first, last) = self.range(place);
        let a = (place.b[0] - first).nearest() + first;
        let b = (place.b[1] - first).nearest() + first;
        self.unfolded(place, held(a, first, last), held(b, first, last))
    }

    #[inline(always)]
    fn hex<R: Lattice>(self, place: &OctantPlace<R>) -> [R; 2] {
        let (first, last) = self.range(place);
        let n = R::new(self.grid.n);
        let third = R::new(self.third);
        let [a, b, c] = place.b;
        let ra = (a - first).nearest() + first;
        let rb = (b - first).nearest() + first;
        let rc = (c - third).nearest() + third;
        let (da, db, dc) = ((ra - a).abs(), (rb - b).abs(), (rc - c).abs());
        let mend_a = da.more(db) & da.more(dc);
        let mend_b = !mend_a & db.more(dc);
        let ra_mended = n - rb - rc;
        let rb_mended = n - ra - rc;
        let ra = R::select(mend_a, ra_mended, ra);
        let rb = R::select(mend_b, rb_mended, rb);
        if self.grid.offset > 0.0 || self.lower > 0.0 {
            // Beyond the side of the octant lies no lattice point of this face: along its first row,
            // the other coordinate by itself.
            let half = R::HALF;
            let beside_a = (b - (first - a) * half - first).nearest() + first;
            let beside_b = (a - (first - b) * half - first).nearest() + first;
            let (out_a, out_b) = (ra.less(first), rb.less(first));
            let rb = R::select(out_a, beside_a, rb);
            let ra = R::select(out_b, beside_b, ra);
            return self.unfolded(place, held(ra, first, last), held(rb, first, last));
        }
        self.unfolded(place, ra, rb)
    }

    #[inline(always)]
    fn precise<R: Lattice>(self, place: &OctantPlace<R>) -> [R; 2] {
        let [[a0, a1], [b0, b1]] = self.cell(place);
        let n = R::new(self.grid.n);
        let p = self.warp.point(place.b, n);
        let second = self.candidate(place, p, a1, b0);
        let third = self.candidate(place, p, a0, b1);
        let best = if F::TRIANGLES {
            // The cell is two triangles of the lattice, and the nearest corner belongs to the one that
            // the place lies in.
            let beyond = (place.b[0] + place.b[1]).more(a0 + b0 + R::ONE);
            let corner = [R::select(beyond, a1, a0), R::select(beyond, b1, b0)];
            let corner = self.candidate(place, p, corner[0], corner[1]);
            second.or_nearer(third).or_nearer(corner)
        } else {
            let first = self.candidate(place, p, a0, b0);
            let fourth = self.candidate(place, p, a1, b1);
            first.or_nearer(second).or_nearer(third.or_nearer(fourth))
        };
        self.unfolded(place, best.a, best.b)
    }

    /// The lattice point of a place.
    #[inline(always)]
    fn rounded<R: Lattice, const ROUNDING: u8>(self, place: &OctantPlace<R>) -> [R; 2] {
        match ROUNDING {
            NEAREST => self.nearest(place),
            HEX => self.hex(place),
            _ => self.precise(place),
        }
    }

    /// How far a lattice point is from p, the point of a place.
    #[inline(always)]
    fn candidate<R: Lattice>(self, place: &OctantPlace<R>, p: [R; 3], a: R, b: R) -> Candidate<R> {
        let n = R::new(self.grid.n);
        if F::PLAIN && self.grid.offset == 0.0 && self.lower == 0.0 {
            // A lattice of whole numbers has no corner of a triangle beyond the crease, and all steps on a
            // face keep the sum: the third component is -(e₀ + e₁).
            let (e0, e1) = (a - place.b[0], b - place.b[1]);
            let p2 = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
            let pe = (p[0] - p[2]) * e0 + (p[1] - p[2]) * e1;
            let half = e0 * (e0 + e1) + e1 * e1;
            let e2 = half + half;
            return Candidate {
                a,
                b,
                far: p2 * e2 - pe * pe,
                square: p2 + (pe + pe) + e2,
            };
        }
        let c = n - a - b;
        let over = min(c, R::ZERO);
        let e = self.warp.step(place.b, [a + over, b + over, c], n);
        let p2 = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
        let pe = p[0] * e[0] + p[1] * e[1] + p[2] * e[2];
        let e2 = e[0] * e[0] + e[1] * e[1] + e[2] * e[2];
        Candidate {
            a,
            b,
            far: p2 * e2 - pe * pe,
            square: p2 + (pe + pe) + e2,
        }
    }

    /// The code that stands for all of the same direction: on an edge of the square, that with the sign +.
    pub fn representative(self, code: u64) -> u64 {
        let grid = self.grid;
        let (s, t): (f64, f64) = (grid.place(code), grid.place(code >> grid.bits));
        let settled = |x: f64, beside: f64| if beside.abs() == grid.n { x.abs() } else { x };
        grid.field(settled(s, t)) | grid.field(settled(t, s)) << grid.bits
    }

    /// The direction of a lattice point on the square.
    #[inline(always)]
    fn direction<R: Lattice>(self, [s, t]: [R; 2]) -> [R; 3] {
        let (zero, n) = (R::ZERO, R::new(self.grid.n));
        let (a, b) = (s.abs(), t.abs());
        let c = n - a - b;
        let over = min(c, zero);
        let [x, y, z] = self.warp.point([a + over, b + over, c], n);
        let inverse = R::ONE / (x * x + y * y + z * z).sqrt();
        // + 0: no -0 where an edge of the square meets itself.
        [
            (x * inverse).negated_if(s.less(zero)) + zero,
            (y * inverse).negated_if(t.less(zero)) + zero,
            z * inverse,
        ]
    }
}

impl<R: Cell, F: Warp, const ROUNDING: u8> Encode<R> for Rounded<Fold<F>, ROUNDING> {
    #[inline(always)]
    fn encode<const NORMAL: bool>(self, d: [R; 3]) -> (R::Code, bool) {
        let fold = self.0;
        let place = fold.place::<R, NORMAL>(d);
        let [s, t] = fold.rounded::<R, ROUNDING>(&place);
        let code = fold.grid.field(s) | (fold.grid.field(t) << fold.grid.bits);
        (R::only_if(place.ok, code), place.ok)
    }
}

impl<R: Cell, F: Warp> Decode<R> for Fold<F> {
    #[inline(always)]
    fn decode(self, code: R::Code) -> [R; 3] {
        let grid = self.grid;
        self.direction([grid.place(code), grid.place(code >> grid.bits)])
    }
}

impl<F: Warp> Formula for Fold<F> {
    fn words(self) -> Words {
        Words {
            fields: 2,
            bits: self.grid.bits,
        }
    }

    fn pack<R: Lattice>(self, rounding: Rounding, d: [R; 3]) -> Vec<R> {
        let place = self.place::<R, true>(d);
        let point = match rounding {
            Rounding::Nearest => self.nearest(&place),
            Rounding::Hex => self.hex(&place),
            Rounding::Precise => self.precise(&place),
        };
        point.map(|x| self.grid.unsigned(x)).to_vec()
    }

    fn unpack<R: Lattice>(self, fields: &[R]) -> [R; 3] {
        self.direction([fields[0], fields[1]].map(|x| self.grid.of_unsigned(x)))
    }
}
