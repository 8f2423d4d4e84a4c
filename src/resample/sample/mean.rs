//! Means of lookups, evenly spread over parallelograms of the source.
//!
//! What a texel of the target sees, where coordinates hardly bend, is a parallelogram of the source. Its mean is that of
//! bilinear lookups on a grid within it, one for about every source texel. Put together from single lookups, in tiles
//! like any others, keeping account of which belongs to whom took ten times as long as the lookups. Here all of one
//! texel are made one after the other, from the window that holds them.
//!
//! Only what lies inside of a face is answered for, with all texels that its lookups take part in.

use super::gather::{four, mix};
use super::spread::{LANES, MOST, Parts, Spread, Trapezoid, division, second_of_two, spread};
use crate::image::raster::Raster;
use crate::image::texel::{Four, Texel};
use crate::kernel::tile::Tile;
use crate::kernel::{Scalar, SimdWork, run_simd, vectorize};
use crate::number::real::{self, Real};
use crate::resample::sample::Texture;
use fearless_simd::{Simd, SimdBase};
use std::ops::Range;

/// Places that are turned into texels together, at most.
const ROOM: usize = 256;
const _: () = assert!(ROOM >= MOST);

/// Texels that are looked at together: what is known of them stays in the nearest cache.
pub(crate) const TOGETHER: usize = 128;

/// What rounding in f32 may leave out of a reach, in shares of it.
const ROUNDING: f32 = 1e-5;

/// A number of each.
type Row<R> = [R; TOGETHER];

const ZEROS: Row<f32> = [0.0; TOGETHER];

/// Parallelograms of the source, about places of a part of a tile.
pub(crate) struct Parallelograms {
    /// The places, in texels.
    centers: [Row<f64>; 2],
    shapes: Shapes,
    /// Whether all texels that take part are inside of a face.
    inside: Row<bool>,
}

/// What does not depend on where they lie: two numbers of each are those along x and along y, or of the first and the second side.
struct Shapes {
    /// The part of each side that places are spread over: right and down in the target.
    sides: [[Row<f32>; 2]; 2],
    /// By how much they are bent: factors of squares to the right, of products, and of squares down.
    bends: [[Row<f32>; 2]; 3],
    /// How places are spread over them: what a [`Spread`] holds.
    counts: [Row<f32>; 2],
    lines: [Row<f32>; 2],
    one_over: [Row<f32>; 2],
    trapezoids: [Row<f32>; 2],
    scales: [Row<f32>; 2],
    /// How many places there are.
    totals: Row<f32>,
    /// Where two places lie from the center: between them, and from there to the second.
    pairs: [[Row<f32>; 2]; 2],
    reach: [Row<f32>; 2],
}

impl Shapes {
    /// Finds all, from ∂x and ∂y to the right and down in texels, and from their second derivatives. Those without a side whose square
    /// is above `near` have one lookup.
    ///
    /// Rows of one length behind references of their own, and nothing else: otherwise the compiler makes no lanes of it, which
    /// take a tenth of the time.
    #[inline(always)]
    fn set(&mut self, slopes: &[Row<f32>; 4], second: &[Row<f32>; 6], near: f32) {
        for k in 0..TOGETHER {
            let (ax, ay) = (slopes[0][k], slopes[1][k]);
            let (bx, by) = (slopes[2][k], slopes[3][k]);
            let (a, b) = (ax * ax + ay * ay, bx * bx + by * by);
            let one = real::max(a, b) <= near;
            let (p, m) = division(a.sqrt());
            let (q, n) = division(b.sqrt());
            let (ax, ay, bx, by) = (ax * p, ay * p, bx * q, by * q);
            let (pp, pq, qq) = (0.5 * p * p, p * q, 0.5 * q * q);
            let (cx, cy) = (pp * second[0][k], pp * second[1][k]);
            let (dx, dy) = (pq * second[2][k], pq * second[3][k]);
            let (ex, ey) = (qq * second[4][k], qq * second[5][k]);
            let grid = (if one { 1.0 } else { m }, if one { 1.0 } else { n });
            let (columns, rows, far, near) = spread((ax, ay), (bx, by), grid);
            let (s, t) = second_of_two(columns, far, near);
            let (ss, st, tt) = (s * s, s * t, t * t);
            (self.sides[0][0][k], self.sides[0][1][k]) = (ax, ay);
            (self.sides[1][0][k], self.sides[1][1][k]) = (bx, by);
            (self.bends[0][0][k], self.bends[0][1][k]) = (cx, cy);
            (self.bends[1][0][k], self.bends[1][1][k]) = (dx, dy);
            (self.bends[2][0][k], self.bends[2][1][k]) = (ex, ey);
            (self.counts[0][k], self.counts[1][k]) = (columns, rows);
            (self.lines[0][k], self.lines[1][k]) = (far, near);
            let parts = Parts::new((columns, rows), (far, near));
            (self.one_over[0][k], self.one_over[1][k]) = parts.one_over;
            self.trapezoids[0][k] = parts.trapezoid.slope;
            self.trapezoids[1][k] = parts.trapezoid.one_over;
            (self.scales[0][k], self.scales[1][k]) = parts.scales;
            self.totals[k] = columns * rows;
            self.pairs[0][0][k] = ss * cx + st * dx + tt * ex;
            self.pairs[0][1][k] = ss * cy + st * dy + tt * ey;
            self.pairs[1][0][k] = s * ax + t * bx;
            self.pairs[1][1][k] = s * ay + t * by;
            self.reach[0][k] = reach((ax, bx), (cx, dx, ex));
            self.reach[1][k] = reach((ay, by), (cy, dy, ey));
        }
    }
}

/// How far a parallelogram reaches from its center along an axis, at most.
#[inline(always)]
fn reach((a, b): (f32, f32), (c, d, e): (f32, f32, f32)) -> f32 {
    let straight = a.abs() + b.abs();
    let reach = 0.5 * straight + 0.25 * (c.abs() + d.abs() + e.abs());
    reach * (1.0 + ROUNDING)
}

/// Rows of a tile, from a number on, times `scales`.
#[inline(always)]
fn scaled<R: Scalar, const N: usize>(
    rows: &Tile<R, N>,
    first: usize,
    scales: [f64; 2],
) -> [Row<f32>; N] {
    let mut scaled = [ZEROS; N];
    for (axis, (row, scaled)) in rows.0.iter().zip(&mut scaled).enumerate() {
        let scale = R::new(scales[axis % 2]);
        for (x, scaled) in row[first..][..TOGETHER].iter().zip(scaled) {
            *scaled = (*x * scale).to_f64() as f32;
        }
    }
    scaled
}

impl Parallelograms {
    pub(crate) fn new() -> Self {
        Parallelograms {
            centers: [[0.0; TOGETHER]; 2],
            shapes: Shapes {
                sides: [[ZEROS; 2]; 2],
                bends: [[ZEROS; 2]; 3],
                counts: [ZEROS; 2],
                lines: [ZEROS; 2],
                one_over: [ZEROS; 2],
                trapezoids: [ZEROS; 2],
                scales: [ZEROS; 2],
                totals: ZEROS,
                pairs: [[ZEROS; 2]; 2],
                reach: [ZEROS; 2],
            },
            inside: [false; TOGETHER],
        }
    }

    /// Takes over [`TOGETHER`] from a number in a tile on: ∂u and ∂v to the right, and ∂u and ∂v down; and their second derivatives,
    /// if they matter. Those without a side whose square is above `near` texels have one lookup.
    pub(crate) fn set<R: Scalar>(
        &mut self,
        raster: &Raster,
        (places, first): (&Tile<R, 3>, usize),
        (slopes, bends): (&Tile<R, 4>, &Tile<R, 6>),
        near: f32,
    ) {
        let grids = [raster.along_u.index(), raster.along_v.index()];
        let last = [raster.width, raster.height].map(|n| n as f64 - 1.0);
        let scales = grids.map(|(scale, _)| scale);
        vectorize(
            #[inline(always)]
            || {
                let (slopes, bends) = (scaled(slopes, first, scales), scaled(bends, first, scales));
                self.shapes.set(&slopes, &bends, near);
                self.inside = [true; TOGETHER];
                for axis in [0, 1] {
                    let (scale, offset) = grids[axis];
                    let center = &mut self.centers[axis];
                    let places = &places.0[axis][first..][..TOGETHER];
                    for (center, place) in center.iter_mut().zip(places) {
                        *center = place.to_f64() * scale + offset;
                    }
                    let reach = &self.shapes.reach[axis];
                    let held = self.inside.iter_mut().zip(&*center).zip(reach);
                    for ((inside, &center), &reach) in held {
                        let reach = f64::from(reach);
                        *inside &= (center >= reach) & (center + reach < last[axis]);
                    }
                }
            },
        );
    }

    /// Whether the one about place k has several lookups.
    #[inline(always)]
    pub(crate) fn several(&self, k: usize) -> bool {
        self.shapes.totals[k] > 1.0
    }

    /// That about place k.
    #[inline(always)]
    pub(crate) fn at(&self, k: usize) -> Parallelogram {
        let shapes = &self.shapes;
        Parallelogram {
            center: self.centers.each_ref().map(|x| x[k]),
            sides: shapes.sides.each_ref().map(|[x, y]| [x[k], y[k]]),
            bends: shapes.bends.each_ref().map(|[x, y]| [x[k], y[k]]),
            spread: Spread {
                counts: shapes.counts.each_ref().map(|count| count[k]),
                reach: shapes.lines.each_ref().map(|reach| reach[k]),
                parts: Parts {
                    one_over: (shapes.one_over[0][k], shapes.one_over[1][k]),
                    trapezoid: Trapezoid {
                        slope: shapes.trapezoids[0][k],
                        one_over: shapes.trapezoids[1][k],
                    },
                    scales: (shapes.scales[0][k], shapes.scales[1][k]),
                },
            },
        }
    }

    /// Whether all texels that lookups about place k weight are inside of a face and valid, where that is easily told.
    #[inline(always)]
    fn inside(&self, k: usize, raster: &Raster) -> bool {
        self.inside[k] && (!raster.has_rim() || self.at(k).is_held(raster))
    }
}

/// A place in texels, and sides that places are spread over, bent a little.
#[derive(Clone, Copy)]
pub(crate) struct Parallelogram {
    pub(crate) center: [f64; 2],
    sides: [[f32; 2]; 2],
    bends: [[f32; 2]; 3],
    pub(crate) spread: Spread,
}

impl Parallelogram {
    /// How far it reaches from its center along x and y, at most.
    #[inline(always)]
    pub(crate) fn reach(&self) -> [f32; 2] {
        let ([a, b], [c, d, e]) = (self.sides, self.bends);
        [0, 1].map(|axis| reach((a[axis], b[axis]), (c[axis], d[axis], e[axis])))
    }

    /// How far a place, from -½ to ½ along both sides, lies from its center.
    #[inline(always)]
    pub(crate) fn at(&self, s: f32, t: f32) -> [f64; 2] {
        let ([a, b], [c, d, e]) = (self.sides, self.bends);
        [0, 1].map(|axis| {
            let middle = t * (b[axis] + t * e[axis]);
            f64::from(middle + s * (a[axis] + t * d[axis] + s * c[axis]))
        })
    }

    /// Whether the image is valid wherever it reaches, and a texel around it, for certain.
    #[inline(always)]
    fn is_held(&self, raster: &Raster) -> bool {
        let [x, y] = self.reach().map(f64::from);
        let [(su, ou), (sv, ov)] = [raster.along_u.index(), raster.along_v.index()];
        let place = [(self.center[0] - ou) / su, (self.center[1] - ov) / sv];
        raster.holds_around(place, [(x + 1.0) / su, (y + 1.0) / sv])
    }
}

/// Finds the means about places of a tile, as many as `done` is long, where they can be had: true there, and a texel in `means`, which
/// has room for one more.
pub(crate) fn means<T: Texel>(
    source: &Texture<'_, T>,
    (seen, face): (&Parallelograms, usize),
    done: &mut [bool],
    means: &mut [T],
) {
    let raster = &source.raster;
    let Some(row) = raster.straight() else {
        return;
    };
    run_simd(Means {
        lookups: Lookups {
            texels: source.texels,
            channels: source.channels,
            row,
            start: raster.view(face).index(0, 0),
            count: 0,
            x: [0.0; ROOM + LANES],
            y: [0.0; ROOM + LANES],
            first: [0; ROOM],
            tx: [T::Float::ZERO; ROOM],
            ty: [T::Float::ZERO; ROOM],
        },
        owners: [(0, 0); TOGETHER],
        owned: 0,
        raster,
        seen,
        done,
        means,
    });
}

struct Means<'m, 'a, T: Texel> {
    lookups: Lookups<'a, T>,
    /// Which texels the lookups belong to, with the first of each.
    owners: [(u16, u16); TOGETHER],
    owned: usize,
    raster: &'m Raster,
    seen: &'m Parallelograms,
    done: &'m mut [bool],
    means: &'m mut [T],
}

impl<T: Texel> SimdWork for Means<'_, '_, T> {
    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let seen = self.seen;
        for k in 0..self.done.len() {
            let total = seen.shapes.totals[k];
            if total <= 1.0 || total > MOST as f32 || !seen.inside(k, self.raster) {
                continue;
            }
            let count = total as usize;
            if self.lookups.count + count > ROOM {
                self.look(simd);
            }
            self.owners[self.owned] = (k as u16, self.lookups.count as u16);
            self.owned += 1;
            if count == 2 {
                let pairs = seen.shapes.pairs.each_ref();
                let [between, second] = pairs.map(|xy| xy.each_ref().map(|x| f64::from(x[k])));
                let [x, y] = [0, 1].map(|axis| seen.centers[axis][k] + between[axis]);
                self.lookups.push([x - second[0], y - second[1]]);
                self.lookups.push([x + second[0], y + second[1]]);
            } else {
                self.lookups.push_all(&seen.at(k));
            }
        }
        self.look(simd);
    }
}

impl<T: Texel> Means<'_, '_, T> {
    /// Finds the means of what was pushed.
    #[inline(always)]
    fn look<S: Simd>(&mut self, simd: S) {
        let channels = self.lookups.channels;
        let far = self.lookups.place();
        let last = self.lookups.last();
        for owner in 0..self.owned {
            let (texel, first) = self.owners[owner];
            let next = self.owners[..self.owned].get(owner + 1);
            let end = next.map_or(self.lookups.count, |(_, first)| usize::from(*first));
            let (texel, own) = (usize::from(texel), usize::from(first)..end);
            if last.is_none_or(|last| {
                far > last && self.lookups.first[own.clone()].iter().any(|at| *at > last)
            }) {
                continue;
            }
            // Of three numbers, four are written: the next texel's come after.
            let mean = &mut self.means[texel * channels..];
            if let (3 | 4, Some(mean)) = (channels, mean.first_chunk_mut()) {
                *mean = self.lookups.mean_of_four(simd, own);
            } else {
                self.lookups.mean(own, &mut mean[..channels]);
            }
            self.done[texel] = true;
        }
        (self.owned, self.lookups.count) = (0, 0);
    }
}

/// A whole number from 0 to 2⁵² as an integer. `as` looks for what is none, and integers would be multiplied in lanes that have no
/// instruction for it.
#[inline(always)]
fn whole(x: f64) -> usize {
    const MAGIC: f64 = (1_u64 << 52) as f64;
    (x + MAGIC).to_bits().wrapping_sub(MAGIC.to_bits()) as usize
}

/// Those of some means: their places in texels, where their windows begin, and how far they lie right of and below the first texel.
struct Lookups<'a, T: Texel> {
    texels: &'a [T],
    channels: usize,
    row: usize,
    /// The face's first texel.
    start: usize,
    count: usize,
    x: [f64; ROOM + LANES],
    y: [f64; ROOM + LANES],
    first: [usize; ROOM],
    tx: [T::Float; ROOM],
    ty: [T::Float; ROOM],
}

impl<T: Texel> Lookups<'_, T> {
    #[inline(always)]
    fn push(&mut self, [x, y]: [f64; 2]) {
        (self.x[self.count], self.y[self.count]) = (x, y);
        self.count += 1;
    }

    #[inline(always)]
    fn push_all(&mut self, seen: &Parallelogram) {
        let total = seen.spread.count();
        for first in (0..total).step_by(LANES) {
            let (mut s, mut t) = ([0.0; LANES], [0.0; LANES]);
            seen.spread.places(first, &mut s, &mut t);
            let own = self.count + first..self.count + first + LANES;
            let places = self.x[own.clone()].iter_mut().zip(&mut self.y[own]);
            for ((x, y), (s, t)) in places.zip(s.into_iter().zip(t)) {
                let [right, down] = seen.at(s, t);
                (*x, *y) = (seen.center[0] + right, seen.center[1] + down);
            }
        }
        self.count += total;
    }

    /// The last number at which a window may begin: four numbers are read at a time.
    fn last(&self) -> Option<usize> {
        let window = (self.row + 1) * self.channels + 4;
        self.texels.len().checked_sub(window)
    }

    /// Finds the windows, and where the last one begins.
    #[inline(always)]
    fn place(&mut self) -> usize {
        let steps = [self.channels, self.row * self.channels].map(|step| step as f64);
        let start = (self.start * self.channels) as f64;
        let count = self.count.min(ROOM);
        let places = self.x[..count].iter().zip(&self.y[..count]);
        let windows = self.first[..count].iter_mut();
        let shares = self.tx[..count].iter_mut().zip(&mut self.ty[..count]);
        let mut farthest = 0;
        for (((&x, &y), first), (tx, ty)) in places.zip(windows).zip(shares) {
            let (i, j) = (Real::floor(x), Real::floor(y));
            *first = whole(start + (j * steps[1] + i * steps[0]));
            farthest = farthest.max(*first);
            *tx = Real::new(x - i);
            *ty = Real::new(y - j);
        }
        farthest
    }

    #[inline(always)]
    fn list(&self, own: Range<usize>) -> impl Iterator<Item = (usize, T::Float, T::Float)> {
        let steps = self.tx[own.clone()].iter().zip(&self.ty[own.clone()]);
        let lookups = self.first[own].iter().zip(steps);
        lookups.map(|(&first, (&tx, &ty))| (first, tx, ty))
    }

    /// The mean of four numbers a lookup, difference by difference from the first one: a constant stays constant to the bit.
    #[inline(always)]
    fn mean_of_four<S: Simd>(&self, simd: S, own: Range<usize>) -> [T; 4] {
        let splat = |x| Four::<T, S>::splat(simd, x);
        let share = splat(Real::new(1.0 / own.len() as f64));
        let (mut base, mut sum) = (splat(T::Float::ZERO), splat(T::Float::ZERO));
        let step = self.row * self.channels;
        for (k, (first, tx, ty)) in self.list(own).enumerate() {
            let upper = &self.texels[first..][..self.channels + 4];
            let lower = &self.texels[first + step..][..self.channels + 4];
            let corners = [
                four::<S, T>(simd, upper, 0),
                four::<S, T>(simd, upper, self.channels),
                four::<S, T>(simd, lower, 0),
                four::<S, T>(simd, lower, self.channels),
            ];
            let value = mix(corners, splat(tx), splat(ty));
            if k == 0 {
                base = value;
            }
            sum += share * (value - base);
        }
        T::filtered_four(simd, base + sum)
    }

    /// That of any number of channels.
    #[inline(always)]
    fn mean(&self, own: Range<usize>, mean: &mut [T]) {
        let share: T::Float = Real::new(1.0 / own.len() as f64);
        let below = self.row * self.channels;
        for (c, mean) in mean.iter_mut().enumerate() {
            let (mut base, mut sum) = (T::Float::ZERO, T::Float::ZERO);
            for (k, (first, tx, ty)) in self.list(own.clone()).enumerate() {
                let right = first + c + self.channels;
                let corners = [first + c, right, first + c + below, right + below];
                let value = mix(corners.map(|at| self.texels[at].load()), tx, ty);
                if k == 0 {
                    base = value;
                }
                sum = sum + share * (value - base);
            }
            *mean = T::store(base + sum);
        }
    }
}
