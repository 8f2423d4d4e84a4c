//! Between which pixels a place lies: two on the ring to the north and two on that to the south, and their weights.
//!
//! Source: HEALPix' interpolation, which healpy's `get_interp_weights` gives: linear in longitude on both rings, and in the polar angle between them. Beyond the
//! first and the last ring the pole has the mean of that ring's four pixels.
//!
//! Domain: angles as in [`Pixels::of_angles`](super::Pixels::of_angles). Where rounding takes a place for one on the other side of a ring, it lies on that ring:
//! the share of what is beyond is 0. So it is never corrected, which would take the angles of two more rings.

use super::index::{Grid, OnRing, double, floor};
use super::place::heights;
use crate::number::math::{max, min};
use crate::number::real::Real;
// An `if` may become a branch, which keeps the loop from being vectorized.
use std::hint::select_unpredictable as choose;

/// Two neighbors on a ring, by how many pixels east of its first they are, and how far a place is from the first of them to the second.
#[derive(Clone, Copy)]
struct Pair {
    ring: i64,
    quadrant: i64,
    /// Half a pixel that centers are off longitude 0: 1, or 0.
    half: i64,
    numbers: [i64; 2],
    east: f64,
}

impl Pair {
    /// Those between which an azimuth lies, in half turns from 0 to 2.
    #[inline(always)]
    fn around(grid: Grid, ring: i64, azimuth: f64) -> Self {
        let quadrant = grid.quadrant(ring);
        let half = choose(quadrant < grid.nside, 1, 1 - ((ring - grid.nside) & 1));
        let count = 4 * quadrant;
        let along = azimuth * double(2 * quadrant) - 0.5 * double(half);
        let before = floor(along);
        let first = before + choose(before < 0, count, 0);
        let first = choose(first < count, first, 0);
        let second = choose(first + 1 < count, first + 1, 0);
        Pair {
            ring,
            quadrant,
            half,
            numbers: [first, second],
            east: along - double(before),
        }
    }

    /// The two on the other side of a pole, around which there are four.
    #[inline(always)]
    fn opposite(self) -> Self {
        let [a, b] = self.numbers;
        Pair {
            numbers: [(a + 2) & 3, (b + 2) & 3],
            ..self
        }
    }

    #[inline(always)]
    fn or(self, other: Self, here: bool) -> Self {
        let [[a, b], [c, d]] = [self.numbers, other.numbers];
        Pair {
            ring: choose(here, other.ring, self.ring),
            quadrant: choose(here, other.quadrant, self.quadrant),
            half: choose(here, other.half, self.half),
            numbers: [choose(here, c, a), choose(here, d, b)],
            east: choose(here, other.east, self.east),
        }
    }

    #[inline(always)]
    fn places(self) -> [OnRing; 2] {
        let place = |number: i64| OnRing {
            ring: self.ring,
            quadrant: self.quadrant,
            halves: 2 * number + self.half,
        };
        [place(self.numbers[0]), place(self.numbers[1])]
    }

    /// The polar angle of the ring, in half turns.
    #[inline(always)]
    fn polar(self, grid: Grid) -> f64 {
        let (z, sine) = heights(grid, self.ring, self.quadrant);
        f64::half_turns(sine, z)
    }
}

/// The four pixels around a place, and their weights: of a polar angle and an azimuth in half turns, from 0 to 1 and to 2.
#[inline(always)]
pub(super) fn between(grid: Grid, polar: f64, azimuth: f64) -> ([OnRing; 4], [f64; 4]) {
    let n = grid.nside;
    let side = double(n);
    let (sine, z) = f64::sin_cos_half_turns(polar);
    // √6 n sin(θ/2) in a cap.
    let cap = 3.0_f64.sqrt() * side * sine / (1.0 + z.abs()).sqrt();
    let belt = 2.0 * side - 1.5 * side * z;
    let in_cap = choose(z > 0.0, cap, 4.0 * side - cap);
    let rings = choose(3.0 * z.abs() > 2.0, in_cap, belt);
    let last = 4 * n - 1;
    let above = floor(min(max(rings, 0.0), double(last)));
    let (at_north, at_south) = (above == 0, above == last);
    let north = Pair::around(grid, choose(at_north, 1, above), azimuth);
    let south = Pair::around(grid, choose(at_south, last, above + 1), azimuth);
    let start = choose(at_north, 0.0, north.polar(grid));
    let end = choose(at_south, 1.0, south.polar(grid));
    let down = min(max((polar - start) / (end - start), 0.0), 1.0);
    let up = 1.0 - down;
    // A pole's value is a quarter of each of the four around it.
    let (quarter_north, quarter_south) = (
        choose(at_north, 0.25 * up, 0.0),
        choose(at_south, 0.25 * down, 0.0),
    );
    let quarter = quarter_north + quarter_south;
    let weight = |own: f64, share: f64, gone: bool| choose(gone, quarter, own * share + quarter);
    let weights = [
        weight(1.0 - north.east, up, at_north),
        weight(north.east, up, at_north),
        weight(1.0 - south.east, down, at_south),
        weight(south.east, down, at_south),
    ];
    let [a, b] = north.or(south.opposite(), at_north).places();
    let [c, d] = south.or(north.opposite(), at_south).places();
    ([a, b, c, d], weights)
}
