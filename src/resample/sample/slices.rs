//! Bilinear means over parallelograms of many texels: every texel of the source that is seen is read once, by how much of it is seen.
//!
//! One lookup for about every texel, the other way to a mean, reads each of them four times: where a parallelogram sees [`FROM`] texels or more that takes
//! longer, up to three times as long. Of fewer, weights take longer than they save. What both come to is nearly the same: lookups a texel apart, each a
//! tent, weigh the texels along an axis as a segment does that is as long as they are many, over texels that are boxes.
//!
//! # What a row sees
//!
//! Of each row of texels, from half a texel above its centers to half a texel below, [`LINES`] lines stand for the part that the parallelogram reaches, in the
//! middles of as many parts of it. At height h a line crosses it from l to r, both the nearer of two straight edges; a texel weighs as much of all lines as is within
//! half a texel of its center: the step of x clamped to l and r, from its left to its right. All is divided by the sum of r - l, which is the area but for
//! what edges do between lines: at most an eighth of a texel, in texels at the border.
//!
//! A parallelogram less than [`NARROWEST`] high over its longer side could lie between two lines, and is looked up place by place. How it is bent moves
//! its middle, by the mean of squares; where that is no small part of it ([`fits`]), it is looked up so as well.
//!
//! What did not help: a parallelogram with two sides along the rows and the same second moments, which needs no lines (it sees as much, but not the
//! same: means differed from areas by four times as much), and one segment or trapezoid for all lines of a row (by two to four times as much: where an
//! edge is nearly along the row, a corner lies in it).
//!
//! # In lanes
//!
//! Weights of a row are found for [`LANES`] parallelograms together, and then three or four numbers of a texel are summed up side by side, as differences from
//! the texel next to the center: a constant stays constant to the bit. Of one number, two, or five and more each is summed by itself, in the same order.
//! Windows of all lanes are as large as the largest of them; what is beyond a lane's own counts zero times, and where that makes a NaN the mean is found
//! again, from those that count.

use super::look::{Face, write};
use super::spread::{LANES, by_halves, largest};
use super::wide::four;
use crate::image::texel::{Four, Texel};
use crate::kernel::tile::prefetch_item;
use crate::kernel::{Scalar, vectorize};
use crate::number::real::{self, Real};
use fearless_simd::{Simd, SimdBase};
use std::ops::Add;

/// Windows serve from so many places on.
const FROM: f32 = 12.0;

/// The least height over the longer side.
const NARROWEST: f32 = 1.5;

/// An edge is moved up or down by so much over its length, at least: along a row it would cross no line.
const STEEPEST: f32 = 1.0 / 64.0;

/// The longest, in texels: sums in f32 of more of them would show.
const LONGEST: f32 = 64.0;

/// How far bends may move places, as a share of the sum of width and height and two texels, which is what a window is large.
const BENT: f32 = 1.0 / 16.0;

/// Numbers of several parallelograms.
type Row<X> = [X; LANES];

/// Bytes that memory gives at a time.
const LINE: usize = 64;

/// Lines of a row.
const LINES: usize = 4;

/// The most texels that an offset is, with those beyond a window's rows.
pub(super) const REACH: i32 = 2 * LONGEST as i32;

/// Whether windows serve for a parallelogram of so many places, with sides a and b, moved by its bends by so much along x and y.
#[inline(always)]
pub(super) fn fits(places: f32, [(ax, ay), (bx, by)]: [(f32, f32); 2], (x, y): (f32, f32)) -> bool {
    let area = ax * by - ay * bx;
    let longer = real::max(ax * ax + ay * ay, bx * bx + by * by);
    let (width, height) = (ax.abs() + bx.abs(), ay.abs() + by.abs());
    let short = (width <= LONGEST) & (height <= LONGEST);
    let wide = area * area >= NARROWEST * NARROWEST * longer;
    (places >= FROM) & short & wide & (x + y <= BENT * (width + height + 2.0))
}

/// Parallelograms that are looked at together.
pub(super) struct Sides {
    /// The texels that they are of, and how many these are: lanes that are left over do what the first one does.
    pub(super) own: Row<usize>,
    pub(super) count: usize,
    /// Where texels begin, and how far right and down of them the middles are.
    pub(super) starts: Row<usize>,
    pub(super) off: [Row<f32>; 2],
    /// Along x and y, the first and the second.
    pub(super) sides: [[Row<f32>; 2]; 2],
}

impl Sides {
    pub(super) const NONE: Sides = Sides {
        own: [0; LANES],
        count: 0,
        starts: [0; LANES],
        off: [[0.0; LANES]; 2],
        sides: [[[0.0; LANES]; 2]; 2],
    };
}

/// Their windows.
pub(super) struct Slices<F> {
    own: Row<usize>,
    count: usize,
    starts: Row<usize>,
    off: [Row<f32>; 2],
    /// How many numbers lie from a texel to those right and below.
    steps: [i32; 2],
    /// Of both pairs of edges: how far their middle moves along x by height, and how far they are from it.
    slopes: [Row<f32>; 2],
    halves: [Row<f32>; 2],
    /// How far they reach from the middle along x and y.
    reach: [Row<f32>; 2],
    /// Times which shares count: 1 over the area, so that sums are no larger than means.
    over_area: Row<f32>,
    /// The first row, from where the texel begins, and how many there are.
    top: Row<f32>,
    rows: usize,
    /// The texel next to the center.
    base: Row<usize>,
    /// Shares of all rows so far.
    total: Row<f32>,
    /// Of a row, where the first texel begins, and what each weighs.
    first: Row<usize>,
    weights: Vec<Row<F>>,
    columns: usize,
    /// Of all lanes, number by number.
    sums: Vec<F>,
}

impl<F: Scalar> Slices<F> {
    pub(super) const fn new() -> Self {
        Slices {
            own: [0; LANES],
            count: 0,
            starts: [0; LANES],
            off: [[0.0; LANES]; 2],
            steps: [0; 2],
            slopes: [[0.0; LANES]; 2],
            halves: [[0.0; LANES]; 2],
            reach: [[0.0; LANES]; 2],
            over_area: [0.0; LANES],
            top: [0.0; LANES],
            rows: 0,
            base: [0; LANES],
            total: [0.0; LANES],
            first: [0; LANES],
            weights: Vec::new(),
            columns: 0,
            sums: Vec::new(),
        }
    }

    /// Takes over some parallelograms of a face that has so many numbers from a texel to its neighbors.
    #[inline(never)]
    pub(super) fn set(&mut self, sides: &Sides, steps: [i32; 2]) {
        (self.own, self.count) = (sides.own, sides.count);
        (self.starts, self.off, self.steps) = (sides.starts, sides.off, steps);
        vectorize(
            #[inline(always)]
            || self.shape(sides),
        );
    }

    #[inline(always)]
    fn shape(&mut self, sides: &Sides) {
        let [[ax, ay], [bx, by]] = &sides.sides;
        let [x, y] = sides.off;
        let [right, down] = self.steps;
        let (mut slopes, mut halves) = ([[0.0; LANES]; 2], [[0.0; LANES]; 2]);
        let (mut top, mut rows, mut base) = ([0.0; LANES], [0.0; LANES], [0; LANES]);
        let mut reach = [[0.0; LANES]; 2];
        for k in 0..LANES {
            let area = (ax[k] * by[k] - ay[k] * bx[k]).abs();
            let (a, b) = (steep(ay[k]), steep(by[k]));
            (slopes[0][k], slopes[1][k]) = (ax[k] / a, bx[k] / b);
            (halves[0][k], halves[1][k]) = (0.5 * area / a.abs(), 0.5 * area / b.abs());
            self.over_area[k] = 1.0 / real::max(area, f32::MIN_POSITIVE);
            let half = 0.5 * (ay[k].abs() + by[k].abs());
            top[k] = Real::floor(y[k] - half + 0.5);
            rows[k] = -Real::floor(-(y[k] + half + 0.5)) - top[k];
            (reach[0][k], reach[1][k]) = (0.5 * (ax[k].abs() + bx[k].abs()), half);
            let nearest = [x[k], y[k]].map(|x| Real::floor(x + 0.5).whole());
            let across = nearest[0].wrapping_mul(right);
            base[k] = across.wrapping_add(nearest[1].wrapping_mul(down));
        }
        (self.slopes, self.halves, self.top) = (slopes, halves, top);
        self.reach = reach;
        self.rows = largest(rows).whole() as usize;
        self.base = beyond(&self.starts, &base);
        self.total = [0.0; LANES];
    }

    /// Finds what texels of a row weigh; rows follow each other from the first on.
    #[inline(never)]
    fn row(&mut self, row: usize) {
        vectorize(
            #[inline(always)]
            || self.weigh(row as f32),
        );
    }

    #[inline(always)]
    fn weigh(&mut self, row: f32) {
        let ([a, b], [p, q]) = (&self.slopes, &self.halves);
        let (top, [far, high], [x, y]) = (&self.top, &self.reach, &self.off);
        let [right, down] = self.steps;
        let mut lines = [[[0.0; LANES]; 2]; LINES];
        let (mut off, mut apart) = ([0.0; LANES], [0.0; LANES]);
        let (mut columns, mut begin) = ([0.0; LANES], [0; LANES]);
        for k in 0..LANES {
            let texel = top[k] + row;
            let away = texel - y[k];
            let upper = real::min(real::max(away - 0.5, -high[k]), high[k]);
            let lower = real::min(real::max(away + 0.5, upper), high[k]);
            let between = (lower - upper) * (1.0 / LINES as f32);
            apart[k] = between * self.over_area[k];
            let (mut least, mut most, mut sum) = (far[k], -far[k], 0.0);
            for (number, line) in lines.iter_mut().enumerate() {
                let height = upper + between * (number as f32 + 0.5);
                let (ca, cb) = (height * a[k], height * b[k]);
                let l = real::max(real::max(ca - p[k], cb - q[k]), -far[k]);
                let r = real::max(real::min(real::min(ca + p[k], cb + q[k]), far[k]), l);
                (line[0][k], line[1][k]) = (l, r);
                (least, most) = (real::min(least, l), real::max(most, r));
                sum += r - l;
            }
            self.total[k] += apart[k] * sum;
            let left = Real::floor(x[k] + least + 0.5);
            columns[k] = real::max(-Real::floor(-(x[k] + most + 0.5)) - left, 1.0);
            off[k] = left - 0.5 - x[k];
            let across = left.whole().wrapping_mul(right);
            begin[k] = across.wrapping_add(texel.whole().wrapping_mul(down));
        }
        self.first = beyond(&self.starts, &begin);
        self.columns = largest(columns).whole() as usize;
        if self.weights.len() < self.columns {
            self.weights.resize(self.columns, [F::ZERO; LANES]);
        }
        let mut before = [0.0; LANES];
        for [l, _] in &lines {
            for k in 0..LANES {
                before[k] += l[k];
            }
        }
        let mut number = 0.0;
        for weights in &mut self.weights[..self.columns] {
            number += 1.0;
            let mut into = [F::ZERO; LANES];
            let mut passed = [0.0; LANES];
            for [l, r] in &lines {
                for k in 0..LANES {
                    passed[k] += real::min(real::max(off[k] + number, l[k]), r[k]);
                }
            }
            for k in 0..LANES {
                into[k] = F::new(f64::from(apart[k] * (passed[k] - before[k])));
            }
            before = passed;
            *weights = into;
        }
    }

    /// What a sum of the lane by weights is to be multiplied by.
    #[inline(always)]
    fn over(&self, lane: usize) -> F {
        F::new(f64::from(
            1.0 / real::max(self.total[lane], f32::MIN_POSITIVE),
        ))
    }

    /// Writes the means of texels of CHANNELS numbers, three or four, where they belong.
    #[inline(always)]
    pub(super) fn look<
        S: Simd,
        T: Texel<Float = F>,
        const CHANNELS: usize,
        const STRAIGHT: bool,
    >(
        &mut self,
        simd: S,
        face: &Face<'_, T>,
        means: &mut [T],
    ) {
        let mut sums = [[F::ZERO; 4]; LANES];
        for row in 0..self.rows {
            self.row(row);
            self.ask(face, CHANNELS);
            let weights = &self.weights[..self.columns];
            let lanes = self.first.iter().zip(&self.base).zip(&mut sums);
            for (lane, ((&first, &base), sum)) in lanes.enumerate().take(self.count) {
                let base = four(simd, face.texels, base);
                let mut own = Sum::<T, S> {
                    base,
                    sum: Four::<T, S>::load_array(simd, *sum),
                };
                let own_row = (face.texels, first, lane);
                if STRAIGHT {
                    own.add_row::<CHANNELS>(simd, own_row, weights);
                } else {
                    own.add_turned(simd, own_row, weights, face.steps[0]);
                }
                *sum = own.sum.to_array();
            }
        }
        let (mut unknown, mut any) = ([false; LANES], false);
        for (lane, sum) in sums.iter().enumerate().take(self.count) {
            let base = four(simd, face.texels, self.base[lane]);
            let over = Four::<T, S>::splat(simd, self.over(lane));
            let mean = base + Four::<T, S>::load_array(simd, *sum) * over;
            unknown[lane] = mean.to_array()[..CHANNELS].iter().any(|x| x.is_nan());
            any |= unknown[lane];
            let mean = T::filtered_four(simd, mean);
            write::<T, CHANNELS>(means, self.own[lane], mean);
        }
        if any {
            self.careful(face, &unknown, means);
        }
    }

    /// Writes the means of texels of one number, of two, or of more than four.
    #[inline(always)]
    pub(super) fn look_any<T: Texel<Float = F>>(&mut self, face: &Face<'_, T>, means: &mut [T]) {
        let unknown = self.one_by_one::<T, false>(face, &[true; LANES], means);
        if unknown.contains(&true) {
            self.careful(face, &unknown, means);
        }
    }

    /// Finds some means again, of the texels that count and of no others.
    #[inline(never)]
    fn careful<T: Texel<Float = F>>(
        &mut self,
        face: &Face<'_, T>,
        wanted: &Row<bool>,
        means: &mut [T],
    ) {
        self.one_by_one::<T, true>(face, wanted, means);
    }

    /// Writes some means number by number, by the same sums as those of [`look`](Self::look), and returns which are no numbers. CAREFUL leaves out what
    /// counts zero times.
    #[inline(always)]
    fn one_by_one<T: Texel<Float = F>, const CAREFUL: bool>(
        &mut self,
        face: &Face<'_, T>,
        wanted: &Row<bool>,
        means: &mut [T],
    ) -> Row<bool> {
        let (channels, right) = (face.channels, face.steps[0]);
        let number = |at: usize| face.texels.get(at).map_or(F::ZERO, |x| x.load());
        let base_of = |at: usize| {
            let base = number(at);
            // Zero times a number is no NaN if it is finite.
            let out = CAREFUL && (F::ZERO * base).is_nan();
            if out { F::ZERO } else { base }
        };
        self.sums.clear();
        self.sums.resize(LANES * channels, F::ZERO);
        self.total = [0.0; LANES];
        for row in 0..self.rows {
            self.row(row);
            self.ask(face, channels);
            let weights = &self.weights[..self.columns];
            for lane in (0..self.count).filter(|&lane| wanted[lane]) {
                for channel in 0..channels {
                    let base = base_of(self.base[lane].wrapping_add(channel));
                    let mut at = self.first[lane].wrapping_add(channel);
                    let mut next = |weights: &Row<F>| {
                        let weight = weights[lane];
                        let counts = !CAREFUL || weight > F::ZERO;
                        let off = if counts { number(at) - base } else { F::ZERO };
                        at = at.wrapping_add_signed(right);
                        weight * off
                    };
                    let sum = &mut self.sums[lane * channels + channel];
                    if face.straight {
                        let (fours, rest) = weights.as_chunks::<4>();
                        let mut along = F::ZERO;
                        for four in fours {
                            along = along + sum_of(four.each_ref().map(&mut next));
                        }
                        *sum = *sum
                            + match rest {
                                [a, b, c] => along + sum_of([a, b, c].map(&mut next)),
                                [a, b] => along + sum_of([a, b].map(&mut next)),
                                [a] => along + next(a),
                                _ => along,
                            };
                    } else {
                        for weights in weights {
                            *sum = *sum + next(weights);
                        }
                    }
                }
            }
        }
        let mut unknown = [false; LANES];
        for lane in (0..self.count).filter(|&lane| wanted[lane]) {
            for channel in 0..channels {
                let sum = self.sums[lane * channels + channel] * self.over(lane);
                let mean = base_of(self.base[lane].wrapping_add(channel)) + sum;
                unknown[lane] |= mean.is_nan();
                if let Some(own) = means.get_mut(self.own[lane] * channels + channel) {
                    *own = T::store(mean);
                }
            }
        }
        unknown
    }

    /// Asks for the texels of the next row.
    #[inline(always)]
    fn ask<T: Texel>(&self, face: &Face<'_, T>, channels: usize) {
        let last = (self.columns - 1) * channels;
        for first in &self.first {
            let below = first.wrapping_add_signed(face.steps[1]);
            for number in (0..last).step_by(LINE / size_of::<T>()) {
                prefetch_item(face.texels, below.wrapping_add(number));
            }
            prefetch_item(face.texels, below.wrapping_add(last));
        }
    }
}

/// What texels of one window differ from one of them, by their weights.
struct Sum<T: Texel, S: Simd> {
    base: Four<T, S>,
    sum: Four<T, S>,
}

impl<T: Texel, S: Simd> Sum<T, S> {
    /// Adds a row that is stored as a row; NaN where it is not all there.
    #[inline(always)]
    fn add_row<const CHANNELS: usize>(
        &mut self,
        simd: S,
        (texels, first, lane): (&[T], usize, usize),
        weights: &[Row<T::Float>],
    ) {
        let before = std::mem::replace(&mut self.sum, Four::<T, S>::splat(simd, T::Float::ZERO));
        // Bounds are checked once for four texels.
        let (fours, rest) = weights.as_chunks::<4>();
        let mut at = first;
        for weights in fours {
            self.add::<CHANNELS, 4>(simd, (texels, at, lane), weights);
            at = at.wrapping_add(4 * CHANNELS);
        }
        let own = (texels, at, lane);
        match rest {
            [a, b, c] => self.add::<CHANNELS, 3>(simd, own, &[*a, *b, *c]),
            [a, b] => self.add::<CHANNELS, 2>(simd, own, &[*a, *b]),
            [a] => self.add::<CHANNELS, 1>(simd, own, &[*a]),
            _ => {}
        }
        self.sum = before + self.sum;
    }

    /// Adds texels that follow each other.
    #[inline(always)]
    fn add<const CHANNELS: usize, const N: usize>(
        &mut self,
        simd: S,
        (texels, first, lane): (&[T], usize, usize),
        weights: &[Row<T::Float>; N],
    ) {
        let width = (N - 1) * CHANNELS + 4;
        let Some(row) = texels.get(first..first.wrapping_add(width)) else {
            self.sum = Four::<T, S>::splat(simd, T::Float::NAN);
            return;
        };
        let zero = Four::<T, S>::splat(simd, T::Float::ZERO);
        let mut terms = [zero; N];
        for (k, (term, weights)) in terms.iter_mut().zip(weights).enumerate() {
            let weight = Four::<T, S>::splat(simd, weights[lane % LANES]);
            *term = weight * (four(simd, row, k * CHANNELS) - self.base);
        }
        self.sum += sum_of(terms);
    }

    /// Adds a row that is stored some other way.
    #[inline(always)]
    fn add_turned(
        &mut self,
        simd: S,
        (texels, first, lane): (&[T], usize, usize),
        weights: &[Row<T::Float>],
        right: isize,
    ) {
        let mut at = first;
        for weights in weights {
            let weight = Four::<T, S>::splat(simd, weights[lane % LANES]);
            self.sum += weight * (four(simd, texels, at) - self.base);
            at = at.wrapping_add_signed(right);
        }
    }
}

/// The sum of some terms.
#[inline(always)]
fn sum_of<X: Copy + Add<Output = X>, const N: usize>(terms: [X; N]) -> X {
    by_halves(terms, X::add)
}

/// Where numbers lie, so many from some others.
#[inline(always)]
fn beyond(starts: &Row<usize>, steps: &Row<i32>) -> Row<usize> {
    let mut found = *starts;
    for (found, step) in found.iter_mut().zip(steps) {
        *found = found.wrapping_add_signed(*step as isize);
    }
    found
}

/// How far an edge goes down, if it is not along a row.
#[inline(always)]
fn steep(down: f32) -> f32 {
    real::max(down.abs(), STEEPEST).copysign(down)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Texels of the first window, from the center on, and what each weighs.
    fn window(sides: &Sides) -> Vec<([f64; 2], f64)> {
        // Rows of a thousand texels, with the center in the middle of an image.
        let (row, middle) = (1000, 500_000);
        let mut slices = Slices::<f64>::new();
        slices.set(sides, [1, row as i32]);
        let center = sides.off.each_ref().map(|x| f64::from(x[0]));
        let mut found = Vec::new();
        for r in 0..slices.rows {
            slices.row(r);
            for (c, weights) in slices.weights[..slices.columns].iter().enumerate() {
                let at = (slices.first[0] + c) as isize - middle + row / 2;
                let (x, y) = (at.rem_euclid(row) - row / 2, at.div_euclid(row));
                found.push(([x as f64 - center[0], y as f64 - center[1]], weights[0]));
            }
        }
        for (_, weight) in &mut found {
            *weight *= slices.over(0);
        }
        found
    }

    /// The area of a convex polygon left of x, or right of it, along an axis.
    fn cut(polygon: &[[f64; 2]], axis: usize, at: f64, sign: f64) -> Vec<[f64; 2]> {
        let inside = |p: &[f64; 2]| sign * (p[axis] - at);
        let mut left = Vec::new();
        for (k, p) in polygon.iter().enumerate() {
            let q = &polygon[(k + 1) % polygon.len()];
            let (a, b) = (inside(p), inside(q));
            if a >= 0.0 {
                left.push(*p);
            }
            if a * b < 0.0 {
                let t = a / (a - b);
                left.push([0, 1].map(|i| p[i] + t * (q[i] - p[i])));
            }
        }
        left
    }

    fn area(polygon: &[[f64; 2]]) -> f64 {
        let ends = polygon.iter().cycle().skip(1);
        let crosses = polygon
            .iter()
            .zip(ends)
            .map(|(p, q)| p[0] * q[1] - p[1] * q[0]);
        0.5 * crosses.sum::<f64>().abs()
    }

    proptest! {
        /// Texels weigh what the parallelogram covers of them, and all of them 1.
        #[test]
        fn texels_weigh_what_is_covered_of_them(
            a in prop::array::uniform2(-9.0_f32..9.0),
            b in prop::array::uniform2(-9.0_f32..9.0),
            off in prop::array::uniform2(-3.0_f32..3.0),
        ) {
            prop_assume!(fits(FROM, [(a[0], a[1]), (b[0], b[1])], (0.0, 0.0)));
            let mut sides = Sides::NONE;
            (sides.count, sides.starts) = (1, [500_000; LANES]);
            for axis in [0, 1] {
                sides.off[axis] = [off[axis]; LANES];
                sides.sides[0][axis] = [a[axis]; LANES];
                sides.sides[1][axis] = [b[axis]; LANES];
            }
            let [a, b] = [a, b].map(|side| side.map(f64::from));
            let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)];
            let corners = corners.map(|(s, t)| [0, 1].map(|i| s * a[i] + t * b[i]));
            let (mut sum, mut covered, all) = (0.0, 0.0, area(&corners));
            for (at, weight) in window(&sides) {
                let mut part = corners.to_vec();
                for axis in [0, 1] {
                    part = cut(&part, axis, at[axis] - 0.5, 1.0);
                    part = cut(&part, axis, at[axis] + 0.5, -1.0);
                }
                let exact = area(&part);
                prop_assert!(weight >= 0.0);
                // Half of what lines are apart, along a side of a texel; and edges along rows are moved by 1/64.
                prop_assert!((weight * all - exact).abs() < 0.15, "{at:?} {} {exact}", weight * all);
                sum += weight;
                covered += exact;
            }
            // Sums of a hundred numbers in f32.
            prop_assert!((sum - 1.0).abs() < 1e-5, "{sum}");
            // What no line reaches of two corners may be left out, each as much as a texel may be off.
            prop_assert!((covered - all).abs() < 0.3, "{covered} {all}");
        }
    }
}
