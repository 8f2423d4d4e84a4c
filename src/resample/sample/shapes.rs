//! What texels of the target are in the source, wherever they lie: parallelograms, bent a little, and how places are spread over them.
//!
//! Numbers of many, in rows: found one by one they took as long as the lookups.

use super::slices;
use super::spread::{Spread, division, spread};
use crate::number::real;

/// A side whose square is below has one lookup: r √(2 (r² - 1)) / r is a texel and [`SLACK`](super::spread) there.
pub(crate) const SEVERAL: f32 = 1.66;

/// What rounding in f32 may leave out of a reach, in shares of it.
const ROUNDING: f32 = 1e-5;

/// N of them: two numbers of each are those along x and along y, or of the first and the second side.
pub(super) struct Shapes<const N: usize> {
    /// The part of each side that places are spread over: right and down in the target.
    pub(super) sides: [[[f32; N]; 2]; 2],
    /// By how much they are bent: factors of squares to the right, of products, and of squares down.
    pub(super) bends: [[[f32; N]; 2]; 3],
    /// How places are spread over them: what a [`Spread`] holds.
    pub(super) counts: [[f32; N]; 2],
    pub(super) lines: [[f32; N]; 2],
    /// How many places there are.
    pub(super) totals: [f32; N],
    pub(super) reach: [[f32; N]; 2],
    /// Whether [windows](super::slices) serve for them.
    pub(super) fits: [bool; N],
}

impl<const N: usize> Shapes<N> {
    pub(super) const NONE: Shapes<N> = Shapes {
        sides: [[[0.0; N]; 2]; 2],
        bends: [[[0.0; N]; 2]; 3],
        counts: [[0.0; N]; 2],
        lines: [[0.0; N]; 2],
        totals: [0.0; N],
        reach: [[0.0; N]; 2],
        fits: [false; N],
    };

    /// Takes over those of some numbers.
    #[inline(always)]
    pub(super) fn pick(&mut self, all: &Shapes<N>, own: &[usize]) {
        let (sides, bends) = (self.sides.as_flattened_mut(), self.bends.as_flattened_mut());
        let rows = sides.iter_mut().chain(bends).chain(&mut self.counts);
        let rows = rows.chain(&mut self.lines).chain([&mut self.totals]);
        let (sides, bends) = (all.sides.as_flattened(), all.bends.as_flattened());
        let from = sides.iter().chain(bends).chain(&all.counts);
        let from = from.chain(&all.lines).chain([&all.totals]);
        for (row, from) in rows.zip(from) {
            pick(row, from, own);
        }
    }

    /// How places are spread over that of a number.
    #[inline(always)]
    pub(super) fn spread(&self, k: usize) -> Spread {
        Spread::of(
            self.counts.each_ref().map(|count| count[k]),
            self.lines.each_ref().map(|reach| reach[k]),
        )
    }

    /// Finds all, from ∂x and ∂y to the right and down in texels, and from their second derivatives.
    ///
    /// Rows of one length behind references of their own, and nothing else: otherwise the compiler makes no lanes of it, which
    /// take a tenth of the time.
    #[inline(always)]
    pub(super) fn set(&mut self, slopes: &[[f32; N]; 4], second: &[[f32; N]; 6]) {
        for k in 0..N {
            let (ax, ay) = (slopes[0][k], slopes[1][k]);
            let (bx, by) = (slopes[2][k], slopes[3][k]);
            let (a, b) = (ax * ax + ay * ay, bx * bx + by * by);
            let one = real::max(a, b) <= SEVERAL;
            let (p, m) = division(a.sqrt());
            let (q, n) = division(b.sqrt());
            let (ax, ay, bx, by) = (ax * p, ay * p, bx * q, by * q);
            let (pp, pq, qq) = (0.5 * p * p, p * q, 0.5 * q * q);
            let (cx, cy) = (pp * second[0][k], pp * second[1][k]);
            let (dx, dy) = (pq * second[2][k], pq * second[3][k]);
            let (ex, ey) = (qq * second[4][k], qq * second[5][k]);
            let grid = (if one { 1.0 } else { m }, if one { 1.0 } else { n });
            let (columns, rows, far, near) = spread((ax, ay), (bx, by), grid);
            (self.sides[0][0][k], self.sides[0][1][k]) = (ax, ay);
            (self.sides[1][0][k], self.sides[1][1][k]) = (bx, by);
            (self.bends[0][0][k], self.bends[0][1][k]) = (cx, cy);
            (self.bends[1][0][k], self.bends[1][1][k]) = (dx, dy);
            (self.bends[2][0][k], self.bends[2][1][k]) = (ex, ey);
            (self.counts[0][k], self.counts[1][k]) = (columns, rows);
            (self.lines[0][k], self.lines[1][k]) = (far, near);
            self.totals[k] = columns * rows;
            let (bent_x, bent_y) = (bent((cx, dx, ex)), bent((cy, dy, ey)));
            self.reach[0][k] = reach((ax, bx), (cx, dx, ex));
            self.reach[1][k] = reach((ay, by), (cy, dy, ey));
            let sides = [(ax, ay), (bx, by)];
            self.fits[k] = slices::fits(columns * rows, sides, (bent_x, bent_y));
        }
    }
}

/// Takes over those of some numbers, one after the other.
#[inline(always)]
pub(super) fn pick<R: Copy, const N: usize>(row: &mut [R; N], from: &[R; N], own: &[usize]) {
    for (into, &k) in row.iter_mut().zip(own) {
        *into = from[k];
    }
}

/// How far a place, from -½ to ½ along both sides, lies from the center along an axis, by both sides and by how they are bent.
#[inline(always)]
pub(super) fn off((s, t): (f32, f32), (a, b): (f32, f32), (c, d, e): (f32, f32, f32)) -> f32 {
    t * (b + t * e) + s * (a + t * d + s * c)
}

/// How far a parallelogram reaches from its center along an axis, at most.
#[inline(always)]
pub(super) fn reach((a, b): (f32, f32), (c, d, e): (f32, f32, f32)) -> f32 {
    let straight = a.abs() + b.abs();
    let reach = 0.5 * straight + bent((c, d, e));
    reach * (1.0 + ROUNDING)
}

/// By how much bends move a place along an axis, at most.
#[inline(always)]
fn bent((c, d, e): (f32, f32, f32)) -> f32 {
    0.25 * (c.abs() + d.abs() + e.abs())
}

/// By how much bends move the mean of all places: 1/12 is that of the squares of numbers that are uniform from -½ to ½.
#[inline(always)]
pub(super) fn moved((c, e): (f32, f32)) -> f32 {
    (c + e) * (1.0 / 12.0)
}
