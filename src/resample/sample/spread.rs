//! Where in a parallelogram of the source lookups lie whose mean is to be its mean: about one for every source texel.
//!
//! Seen from the source a texel of the target is a parallelogram. Where it is about as wide as it is long, places are a grid along
//! its sides. Near the pole of a latlong it is a sliver: both sides run along the parallel, and a grid would look up
//! the square of what there is to see. So a sliver is cut into as many slivers as it is source texels wide, and places of each lie
//! on one line. They are where its light is: a parallelogram's width along a line is that of the sum of two uniform numbers, a
//! trapezoid, which is divided into parts of equal area; the mean place of each part is looked up.
//!
//! A parallelogram counts as long and wide as the rectangle with its second moments, the square roots of the eigenvalues of
//! a aᵀ + b bᵀ; lines lie along the longer axis. That is the Jacobian's singular value decomposition, as anisotropic
//! filters of graphics hardware have it.
//!
//! Numbers of source texels are f32: how many places there are is their matter, and that to 1e-5 of a texel. In f64 their roots took as
//! long as the lookups. Places are found [`LANES`] at a time, by their number alone: row by row, of two or three each, they were
//! single numbers, and took longer than the lookups as well.

use crate::number::real::{self, Real};

/// The most places in one mean, and on one line.
pub(crate) const MOST: usize = 64;

/// Places that are found together.
pub(crate) const LANES: usize = 16;

/// Their numbers.
pub(super) const NUMBERS: [f32; LANES] = {
    let mut numbers = [0.0; LANES];
    let mut k = 0;
    while k < LANES {
        numbers[k] = k as f32;
        k += 1;
    }
    numbers
};

/// A side is divided so that places lie at most this much more than a source texel apart: rounding at whole
/// numbers must not double the work.
const SLACK: f64 = 0.15;

/// From how many times as long as wide on a parallelogram is a sliver.
const SLIVER: f32 = 1.5;

/// Which part of a side of r source texels places are spread over, and how many of them divide it.
///
/// That is min(r, √(2(r² - 1))) texels: from nothing at r = 1, where one lookup already is as wide as a texel, to the whole side
/// from r = √2 on.
#[inline(always)]
pub(crate) fn division<R: Real>(r: R) -> (R, R) {
    let one = R::ONE;
    let spread = real::max(R::TWO * (r * r - one), R::ZERO).sqrt() / r;
    let share = R::select(r.more(one), real::min(spread, one), R::ZERO);
    (share, count(real::min(r, R::new(1e9)) * share))
}

/// How many places divide a length in source texels.
#[inline(always)]
pub(crate) fn count<R: Real>(length: R) -> R {
    let least = real::min(length - R::new(SLACK), R::new(MOST as f64));
    real::max(-(-least).floor(), R::ONE)
}

/// How places are spread over a parallelogram.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spread {
    /// Along the first and the second side; or on a line, and how many lines.
    counts: [f32; 2],
    /// How far both sides reach along the lines; zeros where there are none.
    reach: [f32; 2],
    parts: Parts,
}

impl Spread {
    /// So many places along both sides, or on a line and lines, along which both sides reach so far.
    #[inline(always)]
    pub(crate) fn of(counts: [f32; 2], reach: [f32; 2]) -> Spread {
        Spread {
            counts,
            reach,
            parts: Parts::new(counts.into(), reach.into()),
        }
    }

    /// Writes [`LANES`] places from one's number on, from -½ to ½ along the first and the second side. Those after the last one are of
    /// no meaning.
    #[inline(always)]
    pub(crate) fn places(&self, first: usize, s: &mut [f32; LANES], t: &mut [f32; LANES]) {
        let (first, columns, parts) = (first as f32, self.counts[0], &self.parts);
        let [p, q] = self.reach;
        if p == 0.0 && q == 0.0 {
            for k in 0..LANES {
                (s[k], t[k]) = parts.in_grid(columns, first + NUMBERS[k]);
            }
        } else if p.abs() >= q.abs() {
            for k in 0..LANES {
                (s[k], t[k]) = parts.on_line(columns, first + NUMBERS[k]);
            }
        } else {
            for k in 0..LANES {
                (t[k], s[k]) = parts.on_line(columns, first + NUMBERS[k]);
            }
        }
    }
}

/// What places of a spread have in common: quotients.
#[derive(Clone, Copy, Debug)]
struct Parts {
    /// One over the number of columns, and of rows; or of places on a line, and of lines.
    one_over: (f32, f32),
    trapezoid: Trapezoid,
    /// How many places there are on a line, with the sign of the reach; of the side that is divided among the lines, to their number.
    scales: (f32, f32),
}

impl Parts {
    #[inline(always)]
    fn new((columns, rows): (f32, f32), (p, q): (f32, f32)) -> Parts {
        // The side that reaches less far is the one that is divided among the lines.
        let first = p.abs() >= q.abs();
        let (far, near) = (if first { p } else { q }, if first { q } else { p });
        let one_over = (1.0 / columns, 1.0 / rows);
        Parts {
            one_over,
            trapezoid: Trapezoid::new(far.abs(), near.abs() * one_over.1),
            scales: (columns.copysign(far), columns.copysign(near) * one_over.1),
        }
    }

    /// The column and the row of a place. Half of a place is farther from a whole number than rounding is.
    #[inline(always)]
    fn cell(&self, columns: f32, number: f32) -> (f32, f32) {
        let row = Real::floor((number + 0.5) * self.one_over.0);
        (number - row * columns, row)
    }

    /// Where a place of a grid is along both sides.
    #[inline(always)]
    fn in_grid(&self, columns: f32, number: f32) -> (f32, f32) {
        let (column, row) = self.cell(columns, number);
        let (a, b) = self.one_over;
        ((column + 0.5) * a - 0.5, (row + 0.5) * b - 0.5)
    }

    /// Where one on a line is along the side that reaches farther, and along the other.
    #[inline(always)]
    fn on_line(&self, columns: f32, number: f32) -> (f32, f32) {
        let (column, row) = self.cell(columns, number);
        let (step, down) = self.one_over;
        let (ax, ay) = self.trapezoid.sums((column * step - 0.5).abs());
        let (bx, by) = self.trapezoid.sums(((column + 1.0) * step - 0.5).abs());
        (
            self.scales.0 * (bx - ax),
            self.scales.1 * (by - ay) + ((row + 0.5) * down - 0.5),
        )
    }
}

/// [`LANES`] spreads, whose places of one number are found together.
pub(crate) struct Spreads {
    /// What each [`Spread`] has: two numbers.
    counts: [[f32; LANES]; 2],
    reach: [[f32; LANES]; 2],
    /// Whether any has lines. The quotients of lines are found for these alone.
    lines: bool,
    /// Its [`Parts`].
    one_over: [[f32; LANES]; 2],
    trapezoids: [[f32; LANES]; 2],
    scales: [[f32; LANES]; 2],
}

impl Spreads {
    #[inline(always)]
    pub(crate) fn new(counts: [[f32; LANES]; 2], reach: [[f32; LANES]; 2]) -> Spreads {
        let mut spreads = Spreads {
            counts,
            reach,
            lines: false,
            one_over: [[0.0; LANES]; 2],
            trapezoids: [[0.0; LANES]; 2],
            scales: [[0.0; LANES]; 2],
        };
        let [first, second] = &mut spreads.one_over;
        for k in 0..LANES {
            (first[k], second[k]) = (1.0 / counts[0][k], 1.0 / counts[1][k]);
            spreads.lines |= (reach[0][k] != 0.0) | (reach[1][k] != 0.0);
        }
        if spreads.lines {
            for k in 0..LANES {
                let counts = (counts[0][k], counts[1][k]);
                let parts = Parts::new(counts, (reach[0][k], reach[1][k]));
                spreads.trapezoids[0][k] = parts.trapezoid.slope;
                spreads.trapezoids[1][k] = parts.trapezoid.one_over;
                (spreads.scales[0][k], spreads.scales[1][k]) = parts.scales;
            }
        }
        spreads
    }

    /// Writes the places of one number, the last one where a spread has fewer.
    #[inline(always)]
    pub(crate) fn places(&self, number: f32, s: &mut [f32; LANES], t: &mut [f32; LANES]) {
        for k in 0..LANES {
            let number = real::min(number, self.counts[0][k] * self.counts[1][k] - 1.0);
            (s[k], t[k]) = self.parts(k).in_grid(self.counts[0][k], number);
        }
        if self.lines {
            for k in 0..LANES {
                let number = real::min(number, self.counts[0][k] * self.counts[1][k] - 1.0);
                let (far, near) = self.parts(k).on_line(self.counts[0][k], number);
                let (p, q) = (self.reach[0][k].abs(), self.reach[1][k].abs());
                let line = (p > 0.0) | (q > 0.0);
                let (a, b) = if p >= q { (far, near) } else { (near, far) };
                s[k] = if line { a } else { s[k] };
                t[k] = if line { b } else { t[k] };
            }
        }
    }

    #[inline(always)]
    fn parts(&self, k: usize) -> Parts {
        Parts {
            one_over: (self.one_over[0][k], self.one_over[1][k]),
            trapezoid: Trapezoid {
                slope: self.trapezoids[0][k],
                one_over: self.trapezoids[1][k],
            },
            scales: (self.scales[0][k], self.scales[1][k]),
        }
    }
}

/// How many places on a line and how many lines, or how many along both sides, and how far both sides reach along the lines.
///
/// Numbers alone, and no array: this is computed in lanes, of which arrays of two would make pairs.
#[inline(always)]
pub(crate) fn spread(
    (ax, ay): (f32, f32),
    (bx, by): (f32, f32),
    (m, n): (f32, f32),
) -> (f32, f32, f32, f32) {
    let (xx, yy, xy) = (ax * ax + bx * bx, ay * ay + by * by, ax * ay + bx * by);
    let (middle, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let root = (half * half + xy * xy).sqrt();
    let longer = (middle + root).sqrt();
    // The product of both is the area: no difference of nearly equal numbers.
    let shorter = (ax * by - ay * bx).abs() / longer;
    let across = half < 0.0;
    let x = if across { xy } else { root + half };
    let y = if across { root - half } else { xy };
    let scale = 1.0 / (x * x + y * y).sqrt();
    let (p, q) = ((ax * x + ay * y) * scale, (bx * x + by * y) * scale);
    let lines = count(shorter);
    let most = real::max(p.abs(), q.abs());
    let least = real::min(p.abs(), q.abs()) / lines;
    let places = count((most * most + least * least).sqrt());
    // Neither at a singular place nor where rounding would say which axis is the longer one.
    let sliver = (longer > SLIVER * shorter) & (most <= 1e9);
    let fewer = sliver & (places * lines < m * n);
    (
        if fewer { places } else { m },
        if fewer { lines } else { n },
        if fewer { p } else { 0.0 },
        if fewer { q } else { 0.0 },
    )
}

/// The density of p s + q t, for s and t that are uniform from -½ to ½, and p ≥ q ≥ 0.
///
/// Its middle part is level, and each end slopes down over a share g = q / 2p of the whole.
#[derive(Clone, Copy, Debug)]
struct Trapezoid {
    slope: f32,
    one_over: f32,
}

impl Trapezoid {
    #[inline(always)]
    fn new(p: f32, q: f32) -> Trapezoid {
        Trapezoid {
            slope: 0.5 * q / p,
            one_over: 2.0 * p / q,
        }
    }

    /// Of the mean s and t at a place, the integrals over a share f of the whole, from the middle on.
    ///
    /// Up to the slope s is f and t is 0. Within it, w from the end, which is √(2 p q (½ - f)), they are ½ - w/2p and ½ - w/2q.
    #[inline(always)]
    fn sums(&self, f: f32) -> (f32, f32) {
        const THIRD: f32 = 1.0 / 3.0;
        let (rest, g) = (real::max(0.5 - f, 0.0), self.slope);
        let level = 0.5 - g;
        let linear = 0.5 * (g - rest);
        // Neither counts on the level part, where there may be no slope at all.
        let root = rest * (rest * self.one_over).sqrt();
        let s = 0.5 * level * level + linear - 2.0 * THIRD * g * (g - root);
        let t = linear - THIRD * (g - root);
        let flat = rest >= g;
        (
            if flat { 0.5 * f * f } else { s },
            if flat { 0.0 } else { t },
        )
    }
}

/// What some terms come to, half by half: one after the other, each waits for the one before.
#[inline(always)]
pub(super) fn by_halves<X: Copy, const N: usize>(mut terms: [X; N], of: impl Fn(X, X) -> X) -> X {
    let mut half = N.next_power_of_two() / 2;
    while half > 0 {
        for k in half..N.min(2 * half) {
            terms[k - half] = of(terms[k - half], terms[k]);
        }
        half /= 2;
    }
    terms[0]
}

/// The largest of some numbers.
#[inline(always)]
pub(super) fn largest(numbers: [f32; LANES]) -> f32 {
    by_halves(numbers, real::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Over sides given in source texels, which so many places would divide in a grid.
    fn over([[ax, ay], [bx, by]]: [[f32; 2]; 2], [m, n]: [f32; 2]) -> Spread {
        let (places, lines, p, q) = spread((ax, ay), (bx, by), (m, n));
        Spread::of([places, lines], [p, q])
    }

    fn total(spread: &Spread) -> usize {
        spread.counts[0] as usize * spread.counts[1] as usize
    }

    fn places(spread: &Spread) -> Vec<[f64; 2]> {
        let mut all = Vec::new();
        for first in (0..total(spread)).step_by(LANES) {
            let (mut s, mut t) = ([0.0; LANES], [0.0; LANES]);
            spread.places(first, &mut s, &mut t);
            all.extend(s.into_iter().zip(t).map(|(s, t)| [s, t].map(f64::from)));
        }
        all.truncate(total(spread));
        all
    }

    proptest! {
        /// Places lie inside, their mean is the middle, and their second moments along the longer axis are nearly those of
        /// the parallelogram.
        #[test]
        fn places_are_spread_as_the_parallelogram_is(
            a in prop::array::uniform2(-30.0_f32..30.0),
            b in prop::array::uniform2(-30.0_f32..30.0),
        ) {
            let grid = [a, b].map(|side: [f32; 2]| count(side[0].hypot(side[1])));
            let spread = over([a, b], grid);
            prop_assert!(total(&spread) <= (grid[0] * grid[1]) as usize);
            let all = places(&spread);
            let [a, b] = [a, b].map(|side| side.map(f64::from));
            let n = all.len() as f64;
            // A place is a difference of numbers up to 1/8, rounded to 2⁻²⁷, times up to 64.
            let rounding = 1e-6;
            for axis in [0, 1] {
                prop_assert!(all.iter().all(|at| at[axis].abs() <= 0.5));
                let mean: f64 = all.iter().map(|at| at[axis]).sum::<f64>() / n;
                prop_assert!(mean.abs() < rounding, "{mean}");
            }
            let shown = |[s, t]: [f64; 2]| [0, 1].map(|k| s * a[k] + t * b[k]);
            let [xx, yy] = [0, 1].map(|i| (a[i] * a[i] + b[i] * b[i]) / 12.0);
            let moment = |i: usize| all.iter().map(|at| shown(*at)[i].powi(2)).sum::<f64>() / n;
            let (longer, got) = (xx + yy, moment(0) + moment(1));
            // Parts of a texel and SLACK in length, each shown by its mean place, lack at most their own width's moment, and those
            // of a slope, where they are wider, as much again.
            let width = 2.0 * (1.0 + SLACK) * (1.0 + SLACK) / 12.0;
            prop_assert!(got <= longer + rounding * longer, "{got} {longer}");
            prop_assert!(got >= longer - 2.0 * width - 0.02 * longer, "{got} {longer} {spread:?}");
        }
    }

    /// The same numbers, whether found for one or for many.
    #[test]
    fn spreads_in_lanes_are_those_one_by_one() {
        let one = |k: usize| {
            let x = k as f32;
            let sides = [[3.0 - 0.4 * x, 0.3 * x], [0.2 * x, 2.0 - 0.5 * x]];
            let grid = sides.map(|side: [f32; 2]| count(side[0].hypot(side[1])));
            over(sides, grid)
        };
        let of = |row: fn(&Spread) -> [f32; 2]| {
            [0, 1].map(|axis| std::array::from_fn(|lane| row(&one(lane))[axis]))
        };
        let spreads = Spreads::new(of(|spread| spread.counts), of(|spread| spread.reach));
        for number in 0..MOST {
            let (mut s, mut t) = ([0.0; LANES], [0.0; LANES]);
            spreads.places(number as f32, &mut s, &mut t);
            for lane in 0..LANES {
                let all = places(&one(lane));
                let at = all[number.min(all.len() - 1)];
                assert_eq!([s[lane], t[lane]].map(f64::from), at, "{lane} {number}");
            }
        }
    }

    #[test]
    fn a_sliver_takes_a_line_and_a_square_a_grid() {
        let sliver = over([[20.0, 0.5], [-20.0, 0.5]], [21.0, 21.0]);
        assert_eq!(sliver.counts, [29.0, 1.0]);
        let square = over([[3.0, 0.0], [0.0, 3.0]], [3.0, 3.0]);
        assert_eq!(square.counts, [3.0, 3.0]);
        let nowhere = over([[f32::INFINITY, 0.0], [0.0, f32::INFINITY]], [64.0, 64.0]);
        assert_eq!(total(&nowhere), 64 * 64);
    }

    #[test]
    fn parts_of_a_trapezoid_end_where_it_ends() {
        // The mean of s over the upper half is 1/4 for a rectangle, and 1/6 for the triangle of p = q; both times two for the half.
        // A few operations in f32 on numbers up to ½.
        let close = |got: f32, exact: f32| (got - exact).abs() < 1e-7;
        let rectangle = Trapezoid::new(1.0, 0.0).sums(0.5);
        assert!(close(rectangle.0, 0.125) && rectangle.1 == 0.0);
        let triangle = Trapezoid::new(1.0, 1.0).sums(0.5);
        assert!(close(triangle.0, 1.0 / 12.0) && close(triangle.1, 1.0 / 12.0));
    }
}
