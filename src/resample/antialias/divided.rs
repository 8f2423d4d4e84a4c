//! What becomes of parts of texels that were measured: left alone, halved, or looked up at several places.
//!
//! Part by part, roots and quotients of one waited for each other, and took as long as the lookups: here lanes are parts.

use crate::image::raster::Raster;
use crate::kernel::tile::{TILE, Tile};
use crate::kernel::{Scalar, vectorize};
use crate::number::real;
use crate::resample::footprint::Measuring;
use crate::resample::sample::{LANES, MOST, Spread, Spreads, count, division, spread};
use std::ops::Range;

/// The widest part of a texel of several places, in radians: over it a map's density is taken as constant.
pub(super) const WIDEST: f64 = 0.035;

/// The widest in the source, as a share of it: near a pole, which way along it lies changes within a texel.
const STRAIGHT: f64 = 1.0 / 32.0;

/// Places are spread over this share of a side at least: over nothing that could be seen.
const NARROW: f64 = 1e-3;

/// Sides are not halved below this, in u or v.
const SHORTEST: f64 = 1e-6;

/// A whole texel that one lookup serves.
const LEFT: u8 = 0;
const PLACED: u8 = 1;
/// Along the first and the second side.
const HALVED: [u8; 2] = [2, 3];

/// Of up to a [`TILE`] of parts.
pub(super) struct Divided {
    fates: [u8; TILE],
    /// The sides of what is looked up or halved, in u and v.
    sizes: Tile<f64, 2>,
    /// How places are spread over them: along both sides, or on lines.
    counts: [[f32; TILE]; 2],
    lines: [[f32; TILE]; 2],
    totals: [f32; TILE],
    /// Those that are looked up.
    placed: [usize; TILE],
}

impl Divided {
    pub(super) fn new() -> Box<Self> {
        Box::new(Divided {
            fates: [LEFT; TILE],
            sizes: Tile::new(),
            counts: [[0.0; TILE]; 2],
            lines: [[0.0; TILE]; 2],
            totals: [0.0; TILE],
            placed: [0; TILE],
        })
    }

    /// Takes over so many parts of a source; WHOLE if they are whole texels.
    pub(super) fn set<const WHOLE: bool>(
        &mut self,
        measured: &Measuring,
        n: usize,
        source: &Raster,
    ) {
        let far = [source.width, source.height].map(|side| STRAIGHT * side as f64);
        vectorize(
            #[inline(always)]
            || self.set_all::<WHOLE>(measured, n, far),
        );
    }

    #[inline(always)]
    fn set_all<const WHOLE: bool>(&mut self, measured: &Measuring, n: usize, far: [f64; 2]) {
        let [_, Tile([source, _, _])] = measured.centers();
        let Tile([ax, ay, bx, by]) = &measured.sides;
        let (Tile([angle_a, angle_b]), Tile([texel, _])) = (&measured.angles, &measured.extents);
        let Tile([width, height]) = &measured.sizes;
        let Tile([size_a, size_b]) = &mut self.sizes;
        let ([columns, rows], [reach_a, reach_b]) = (&mut self.counts, &mut self.lines);
        for k in 0..n.min(TILE) {
            let nowhere = source[k].is_nan();
            let length = |x: f64, y: f64| {
                let length = (x * x + y * y).sqrt();
                let length = if length.is_nan() {
                    f64::INFINITY
                } else {
                    length
                };
                if nowhere { 0.0 } else { length }
            };
            let (a, b) = (length(ax[k], ay[k]), length(bx[k], by[k]));
            let (p, m) = if WHOLE { division(a) } else { (1.0, count(a)) };
            let (q, n) = if WHOLE { division(b) } else { (1.0, count(b)) };
            // A part of no width would have no weight beside those above and below it.
            size_a[k] = width[k] * real::max(p, NARROW);
            size_b[k] = height[k] * real::max(q, NARROW);
            let (ax, ay, bx, by) = (ax[k] * p, ay[k] * p, bx[k] * q, by[k] * q);
            let first = (ax as f32, ay as f32);
            let second = (bx as f32, by as f32);
            (columns[k], rows[k], reach_a[k], reach_b[k]) =
                spread(first, second, (m as f32, n as f32));
            let total = columns[k] * rows[k];
            self.totals[k] = total;
            let bent = (ax.abs() + bx.abs() > far[0]) | (ay.abs() + by.abs() > far[1]);
            let wide = (total > 1.0) & ((real::max(angle_a[k], angle_b[k]) > WIDEST) | bent);
            let many = total > MOST as f32;
            // Only what halving makes smaller is halved: at a singular place a side is infinite, however short it is.
            let halves_a = (angle_a[k] > 0.5 * texel[k]) & (size_a[k] > SHORTEST);
            let halves_b = (angle_b[k] > 0.5 * texel[k]) & (size_b[k] > SHORTEST);
            let longer = if many | bent {
                n > m
            } else {
                angle_b[k] > angle_a[k]
            };
            let along_b = halves_b & (longer | !halves_a);
            let halved = (wide | many) & (halves_a | halves_b);
            let fate = if along_b { HALVED[1] } else { HALVED[0] };
            let fate = if halved { fate } else { PLACED };
            let left = WHOLE & (m == 1.0) & (n == 1.0);
            self.fates[k] = if left { LEFT } else { fate };
        }
    }

    /// Calls `each` with the centers and sides of the halves of the first n parts that are halved, and with the number of the part. Returns
    /// how many are looked up.
    pub(super) fn halves(
        &mut self,
        (measured, n): (&Measuring, usize),
        mut each: impl FnMut(usize, [f64; 3], [f64; 2]),
    ) -> usize {
        let mut placed = 0;
        for k in 0..n.min(TILE) {
            match self.fates[k] {
                LEFT => {}
                PLACED => {
                    self.placed[placed] = k;
                    placed += 1;
                }
                fate => {
                    let axis = usize::from(fate == HALVED[1]);
                    let mut size = self.sizes.at(k);
                    size[axis] *= 0.5;
                    for step in [-0.5, 0.5] {
                        let mut uv = measured.centers()[0].at(k);
                        uv[axis] += step * size[axis];
                        each(k, uv, size);
                    }
                }
            }
        }
        placed
    }

    /// Which part is looked up at a number, and at how many places.
    pub(super) fn placed(&self, number: usize) -> (usize, usize) {
        let part = self.placed[number];
        (part, self.totals[part] as usize)
    }

    /// How many places a part has.
    pub(super) fn total(&self, part: usize) -> f64 {
        f64::from(self.totals[part])
    }

    /// How they are spread over it.
    pub(super) fn spread(&self, part: usize) -> Spread {
        let at = |row: &[f32; TILE]| row[part];
        Spread::of(
            self.counts.each_ref().map(at),
            self.lines.each_ref().map(at),
        )
    }

    /// Finds [`LANES`] places of a part, from one's number on: after each other.
    pub(super) fn places_of(
        &self,
        measured: &Measuring,
        (part, spread): (usize, &Spread),
        first: usize,
        room: &mut Room,
    ) {
        let [u, v, _] = measured.centers()[0].at(part);
        let [width, height] = self.sizes.at(part);
        let [us, vs] = &mut room.uv;
        vectorize(
            #[inline(always)]
            || {
                let (mut s, mut t) = ([0.0; LANES], [0.0; LANES]);
                spread.places(first, &mut s, &mut t);
                for k in 0..LANES {
                    us[0][k] = u + f64::from(s[k]) * width;
                    vs[0][k] = v + f64::from(t[k]) * height;
                }
            },
        );
    }

    /// Finds the places, fewer than [`LANES`] each, of up to [`LANES`] parts that are looked up: those of one number after each other.
    pub(super) fn places(&self, measured: &Measuring, own: Range<usize>, room: &mut Room) {
        let mut lanes = [self.placed[own.start]; LANES];
        for (lane, part) in lanes.iter_mut().zip(&self.placed[own]) {
            *lane = *part;
        }
        let pick = |row: &[f32; TILE]| lanes.map(|k| row[k]);
        let counts = self.counts.each_ref().map(pick);
        let lines = self.lines.each_ref().map(pick);
        let most = pick(&self.totals).into_iter().fold(0.0, real::max);
        let pick = |row: &[f64; TILE]| lanes.map(|k| row[k]);
        let [from, _] = measured.centers();
        let (u, v) = (pick(&from.0[0]), pick(&from.0[1]));
        let [width, height] = self.sizes.0.each_ref().map(pick);
        let [us, vs] = &mut room.uv;
        vectorize(
            #[inline(always)]
            || {
                let spreads = Spreads::new(counts, lines);
                let places = us.iter_mut().zip(vs).take(most as usize);
                for (number, (us, vs)) in places.enumerate() {
                    let (mut s, mut t) = ([0.0; LANES], [0.0; LANES]);
                    spreads.places(number as f32, &mut s, &mut t);
                    for k in 0..LANES {
                        us[k] = u[k] + f64::from(s[k]) * width[k];
                        vs[k] = v[k] + f64::from(t[k]) * height[k];
                    }
                }
            },
        );
    }
}

/// Places that were found.
pub(super) struct Room {
    uv: [[[f64; LANES]; LANES]; 2],
}

impl Room {
    pub(super) fn new() -> Box<Self> {
        Box::new(Room {
            uv: [[[0.0; LANES]; LANES]; 2],
        })
    }

    /// Writes the first places of one part.
    pub(super) fn write<R: Scalar>(&self, into: [&mut [R]; 2]) {
        for (row, from) in into.into_iter().zip(&self.uv) {
            for (x, from) in row.iter_mut().zip(&from[0]) {
                *x = R::new(*from);
            }
        }
    }

    /// Writes the first places of a lane.
    pub(super) fn write_lane<R: Scalar>(&self, lane: usize, into: [&mut [R]; 2]) {
        for (row, from) in into.into_iter().zip(&self.uv) {
            for (x, from) in row.iter_mut().zip(from) {
                *x = R::new(from[lane]);
            }
        }
    }
}
