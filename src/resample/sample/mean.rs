//! Means of lookups, evenly spread over parallelograms of the source.
//!
//! What a texel of the target sees, where coordinates hardly bend, is a parallelogram of the source. Its mean is that of
//! lookups on a grid within it, one for about every source texel. Put together from single lookups, in tiles
//! like any others, keeping account of which belongs to whom took ten times as long as the lookups. Here all of one
//! texel are made one after the other, from the window that holds them.
//!
//! Only what lies inside of a face is answered for, with all texels that its lookups take part in.
//!
//! Places are found number by number, each for as many parallelograms as there are lanes: most have two to six, and found for one
//! parallelogram after the other they left most lanes empty, which took longer than the lookups. Lanes follow each other in rows of
//! numbers: where some parallelograms are left out, the others close up first. Picked one by one from where they were, their numbers
//! took as long as the lookups.

use super::gather::Bilinear;
use super::look::{Face, Look, Room, Wide, weigh};
use super::lookups::support;
use super::place::Support;
use super::spread::{LANES, MOST, Spread, Spreads, division, spread};
use crate::image::raster::Raster;
use crate::image::texel::Texel;
use crate::kernel::tile::{TILE, Tile, prefetch_item};
use crate::kernel::{Scalar, SimdWork, run_simd, vectorize};
use crate::number::real::{self, Real};
use crate::resample::filters::LookupFilter;
use crate::resample::filters::claims::{Kernel, Visitor};
use crate::resample::sample::Texture;
use fearless_simd::Simd;
use std::marker::PhantomData;

/// Texels that are looked at together: what is known of them stays in the nearest cache.
pub(crate) const TOGETHER: usize = 128;

/// A side whose square is below has one lookup: r √(2 (r² - 1)) / r is a texel and [`SLACK`](super::spread) there.
const SEVERAL: f32 = 1.66;

/// What rounding in f32 may leave out of a reach, in shares of it.
const ROUNDING: f32 = 1e-5;

/// A number of each.
type Row<R> = [R; TOGETHER];

const ZEROS: Row<f32> = [0.0; TOGETHER];

/// Parallelograms of the source, about places of a part of a tile.
pub(crate) struct Parallelograms<F> {
    /// The places, in texels.
    centers: [Row<f64>; 2],
    shapes: Shapes,
    /// Whether all texels that take part are inside of a face.
    inside: Row<bool>,
    asked: Asked<F>,
}

/// Those of them whose means are found.
struct Asked<F> {
    /// Which ones, and how many.
    own: Row<usize>,
    count: usize,
    /// What is known of them, unless they are all.
    centers: [Row<f64>; 2],
    shapes: Shapes,
    /// Where the texels begin that their centers are in, and how far right and down they are from there.
    starts: Row<usize>,
    off: [Row<f32>; 2],
    /// Of those that are looked up, and of the next ones, whose texels are asked for.
    rooms: [Room<F>; 2],
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
    /// How many places there are.
    totals: Row<f32>,
    reach: [Row<f32>; 2],
}

impl Shapes {
    const NONE: Shapes = Shapes {
        sides: [[ZEROS; 2]; 2],
        bends: [[ZEROS; 2]; 3],
        counts: [ZEROS; 2],
        lines: [ZEROS; 2],
        totals: ZEROS,
        reach: [ZEROS; 2],
    };

    /// Takes over those of some numbers.
    #[inline(always)]
    fn pick(&mut self, all: &Shapes, own: &[usize]) {
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

    /// Finds all, from ∂x and ∂y to the right and down in texels, and from their second derivatives.
    ///
    /// Rows of one length behind references of their own, and nothing else: otherwise the compiler makes no lanes of it, which
    /// take a tenth of the time.
    #[inline(always)]
    fn set(&mut self, slopes: &[Row<f32>; 4], second: &[Row<f32>; 6]) {
        for k in 0..TOGETHER {
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
            self.reach[0][k] = reach((ax, bx), (cx, dx, ex));
            self.reach[1][k] = reach((ay, by), (cy, dy, ey));
        }
    }
}

#[inline(always)]
fn pick<R: Copy>(row: &mut Row<R>, from: &Row<R>, own: &[usize]) {
    for (into, &k) in row.iter_mut().zip(own) {
        *into = from[k];
    }
}

/// [`LANES`] numbers of a row.
#[inline(always)]
fn lanes<R: Copy>(row: &Row<R>, chunk: usize) -> [R; LANES] {
    row.as_chunks().0[chunk]
}

/// How far a place, from -½ to ½ along both sides, lies from the center along an axis, by both sides and by how they are bent.
#[inline(always)]
fn off((s, t): (f32, f32), (a, b): (f32, f32), (c, d, e): (f32, f32, f32)) -> f32 {
    t * (b + t * e) + s * (a + t * d + s * c)
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

impl<F: Scalar> Parallelograms<F> {
    pub(crate) fn new() -> Self {
        Parallelograms {
            centers: [[0.0; TOGETHER]; 2],
            shapes: Shapes::NONE,
            inside: [false; TOGETHER],
            asked: Asked {
                own: [0; TOGETHER],
                count: 0,
                centers: [[0.0; TOGETHER]; 2],
                shapes: Shapes::NONE,
                starts: [0; TOGETHER],
                off: [ZEROS; 2],
                rooms: [Room::NEW; 2],
            },
        }
    }

    /// Takes over [`TOGETHER`] of a face, from a number in a tile on: ∂u and ∂v to the right, and ∂u and ∂v down; and their second
    /// derivatives, if they matter.
    pub(crate) fn set<R: Scalar>(
        &mut self,
        (raster, face, filter): (&Raster, usize, LookupFilter),
        (places, first): (&Tile<R, 3>, usize),
        (slopes, bends): (&Tile<R, 4>, &Tile<R, 6>),
    ) {
        let grids = [raster.along_u.index(), raster.along_v.index()];
        let Support { before, after, .. } = support(filter);
        let (before, after) = (before as f64, after as f64);
        let last = [raster.width, raster.height].map(|n| n as f64 - after);
        // Of the texel of a face that is stored last four numbers may not be there; wide filters read up to two more than those of a row.
        let spare = if after > 1.0 { 2.0 } else { 1.0 };
        let scales = grids.map(|(scale, _)| scale);
        let forward = raster.view(face).steps().map(|step| step > 0);
        vectorize(
            #[inline(always)]
            || {
                let (slopes, bends) = (scaled(slopes, first, scales), scaled(bends, first, scales));
                self.shapes.set(&slopes, &bends);
                self.inside = [true; TOGETHER];
                let mut corner = [true; TOGETHER];
                for axis in [0, 1] {
                    let (scale, offset) = grids[axis];
                    let center = &mut self.centers[axis];
                    let places = &places.0[axis][first..][..TOGETHER];
                    for (center, place) in center.iter_mut().zip(places) {
                        *center = place.to_f64() * scale + offset;
                    }
                    let reach = &self.shapes.reach[axis];
                    let held = self.inside.iter_mut().zip(&mut corner);
                    let held = held.zip(&*center).zip(reach);
                    for (((inside, corner), &center), &reach) in held {
                        let reach = f64::from(reach);
                        *inside &= (center >= reach + before) & (center + reach < last[axis]);
                        *corner &= if forward[axis] {
                            center + reach >= last[axis] - spare
                        } else {
                            center - reach < before + spare
                        };
                    }
                }
                for (inside, corner) in self.inside.iter_mut().zip(corner) {
                    *inside &= !corner;
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
            spread: Spread::of(
                shapes.counts.each_ref().map(|count| count[k]),
                shapes.lines.each_ref().map(|reach| reach[k]),
            ),
        }
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
        let off = |axis: usize| off((s, t), (a[axis], b[axis]), (c[axis], d[axis], e[axis]));
        [0, 1].map(|axis| f64::from(off(axis)))
    }

    /// Whether the image is valid wherever it reaches, and so many texels around it, for certain.
    #[inline(always)]
    fn is_held(&self, raster: &Raster, around: usize) -> bool {
        let [x, y] = self.reach().map(|reach| f64::from(reach) + around as f64);
        let [(su, ou), (sv, ov)] = [raster.along_u.index(), raster.along_v.index()];
        let place = [(self.center[0] - ou) / su, (self.center[1] - ov) / sv];
        raster.holds_around(place, [x / su, y / sv])
    }
}

/// Whether any of the first `count` texels of a tile has several lookups, by its slopes.
pub(crate) fn any_several<R: Scalar>(raster: &Raster, slopes: &Tile<R, 4>, count: usize) -> bool {
    let scales = [raster.along_u.index().0, raster.along_v.index().0].map(R::new);
    let Tile([ax, ay, bx, by]) = slopes;
    let several = R::new(f64::from(SEVERAL));
    vectorize(
        #[inline(always)]
        || {
            let mut any = false;
            for k in 0..count.min(TILE) {
                let (ax, ay) = (ax[k] * scales[0], ay[k] * scales[1]);
                let (bx, by) = (bx[k] * scales[0], by[k] * scales[1]);
                any |= real::max(ax * ax + ay * ay, bx * bx + by * by) > several;
            }
            any
        },
    )
}

/// Finds the means about places of a tile, as many as `done` is long, where they can be had: true there, and a texel in `means`, which
/// has room for one more. Returns how many that are.
pub(crate) fn means<T: Texel>(
    (source, filter): (&Texture<'_, T>, LookupFilter),
    (seen, face): (&mut Parallelograms<T::Float>, usize),
    done: &mut [bool],
    means: &mut [T],
) -> usize {
    let find = Find {
        source,
        face,
        seen: &mut *seen,
        done,
        means,
    };
    if filter.visit(find) {
        seen.asked.count
    } else {
        0
    }
}

/// By a filter; false if it has no way for this.
struct Find<'m, 'a, T: Texel> {
    source: &'m Texture<'a, T>,
    face: usize,
    seen: &'m mut Parallelograms<T::Float>,
    done: &'m mut [bool],
    means: &'m mut [T],
}

impl<T: Texel> Visitor for Find<'_, '_, T> {
    type Output = bool;
    fn nearest(self) -> bool {
        false
    }
    fn bilinear(self) -> bool {
        self.by::<Bilinear>(|_| ())
    }
    fn separable<K: Kernel<TAPS>, const TAPS: usize>(self) -> bool {
        self.by::<Wide<TAPS>>(weigh::<T::Float, K, TAPS>)
    }
}

impl<T: Texel> Find<'_, '_, T> {
    /// `weigh` finds the weights of what a room holds.
    fn by<L: Look<T>>(self, weigh: fn(&mut Room<T::Float>)) -> bool {
        let face = Face::new(self.source, self.face, L::SUPPORT);
        let steps = face.narrow_steps().filter(|_| L::serves(&face));
        if let Some(steps) = steps {
            run_simd(Means::<T, L> {
                face,
                steps,
                raster: &self.source.raster,
                seen: self.seen,
                done: self.done,
                means: self.means,
                weigh,
                filter: PhantomData,
            });
        }
        steps.is_some()
    }
}

struct Means<'m, 'a, T: Texel, L> {
    face: Face<'a, T>,
    steps: [i32; 2],
    raster: &'m Raster,
    seen: &'m mut Parallelograms<T::Float>,
    done: &'m mut [bool],
    means: &'m mut [T],
    weigh: fn(&mut Room<T::Float>),
    filter: PhantomData<L>,
}

impl<T: Texel, L: Look<T>> SimdWork for Means<'_, '_, T, L> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let face = self.face;
        self.seen.ask(self.done.len(), self.raster, L::SUPPORT);
        self.seen.start(face.first, self.steps);
        let chunks = self.seen.asked.count.div_ceil(LANES);
        for chunk in 0..=chunks {
            if chunk < chunks {
                self.seen.place(chunk, self.steps);
                let room = &mut self.seen.asked.rooms[chunk % 2];
                (self.weigh)(room);
                for own in [room.number(0), room.number(room.most - 1)] {
                    for &first in own {
                        for row in 0..=L::SUPPORT.before + L::SUPPORT.after {
                            let below = face.steps[1].wrapping_mul(row as isize);
                            prefetch_item(face.texels, first.wrapping_add_signed(below));
                        }
                    }
                }
            }
            let Some(chunk) = chunk.checked_sub(1) else {
                continue;
            };
            let asked = &self.seen.asked;
            let own = &asked.own[chunk * LANES..asked.count.min((chunk + 1) * LANES)];
            let room = &asked.rooms[chunk % 2];
            if face.straight {
                L::look::<S, true>(simd, &face, room, (own, self.means));
            } else {
                L::look::<S, false>(simd, &face, room, (own, self.means));
            }
            for &texel in own {
                self.done[texel] = true;
            }
        }
    }
}

impl<F: Scalar> Parallelograms<F> {
    /// Of the first `count`, asks for those that have several lookups, all inside of a face.
    #[inline(always)]
    fn ask(&mut self, count: usize, raster: &Raster, support: Support) {
        let mut wanted = [false; TOGETHER];
        let totals = self.shapes.totals.iter().zip(&self.inside);
        for (wanted, (&total, &inside)) in wanted.iter_mut().zip(totals) {
            *wanted = inside & (total > 1.0) & (total <= MOST as f32);
        }
        let own = &mut self.asked.own;
        let mut asked = count;
        if wanted[..count].iter().all(|wanted| *wanted) && !raster.has_rim() {
            for (k, own) in own.iter_mut().enumerate() {
                *own = k;
            }
        } else {
            asked = 0;
            for k in (0..count).filter(|&k| wanted[k]) {
                if !raster.has_rim() || self.at(k).is_held(raster, support.after) {
                    self.asked.own[asked] = k;
                    asked += 1;
                }
            }
        }
        self.asked.count = asked;
        if asked < TOGETHER {
            // Lanes that are left over do what the first one does.
            let whole = asked.next_multiple_of(LANES);
            let first = self.asked.own[0];
            self.asked.own[asked..whole].fill(first);
            let own = &self.asked.own[..whole];
            self.asked.shapes.pick(&self.shapes, own);
            for (row, from) in self.asked.centers.iter_mut().zip(&self.centers) {
                pick(row, from, own);
            }
        }
    }

    /// Finds the texels that centers are in. Numbers lie `steps` apart along x and along y, from `start` on.
    #[inline(always)]
    fn start(&mut self, start: usize, steps: [i32; 2]) {
        let asked = &mut self.asked;
        let all = asked.count == TOGETHER;
        let centers = if all { &self.centers } else { &asked.centers };
        let starts = &mut asked.starts;
        starts.fill(start);
        for ((centers, off), step) in centers.iter().zip(&mut asked.off).zip(steps) {
            for ((start, off), &center) in starts.iter_mut().zip(off).zip(centers) {
                // What is left of a center is exact enough in f32, whatever the image's side.
                let texel = Real::floor(center);
                *off = (center - texel) as f32;
                let step = i64::from(texel.whole()) * i64::from(step);
                *start = start.wrapping_add(step as usize);
            }
        }
    }

    /// Finds the windows of [`LANES`] parallelograms.
    #[inline(always)]
    fn place(&mut self, chunk: usize, [right, down]: [i32; 2]) {
        let asked = &mut self.asked;
        let all = asked.count == TOGETHER;
        let shapes = if all { &self.shapes } else { &asked.shapes };
        // Each by its name: what is behind an index of an axis the compiler makes no lanes of.
        let pair = |pair: &[Row<f32>; 2]| pair.each_ref().map(|row| lanes(row, chunk));
        let [[ax, ay], [bx, by]] = shapes.sides.each_ref().map(pair);
        let [[cx, cy], [dx, dy], [ex, ey]] = shapes.bends.each_ref().map(pair);
        let [ox, oy] = pair(&asked.off);
        let starts = lanes(&asked.starts, chunk);
        let spreads = Spreads::new(pair(&shapes.counts), pair(&shapes.lines));
        let room = &mut asked.rooms[chunk % 2];
        room.totals = lanes(&shapes.totals, chunk);
        room.most = most(room.totals) as usize;
        let firsts = room.first.as_chunks_mut::<LANES>().0.iter_mut();
        let txs = room.tx.as_chunks_mut::<LANES>().0.iter_mut();
        let tys = room.ty.as_chunks_mut::<LANES>().0.iter_mut();
        let places = firsts.zip(txs.zip(tys));
        for (number, (first, (tx, ty))) in places.enumerate().take(room.most) {
            let (mut s, mut t) = ([0.0; LANES], [0.0; LANES]);
            spreads.places(number as f32, &mut s, &mut t);
            let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
            for k in 0..LANES {
                let (s, t) = (s[k], t[k]);
                x[k] = ox[k] + off((s, t), (ax[k], bx[k]), (cx[k], dx[k], ex[k]));
                y[k] = oy[k] + off((s, t), (ay[k], by[k]), (cy[k], dy[k], ey[k]));
            }
            for k in 0..LANES {
                let (i, j) = (Real::floor(x[k]), Real::floor(y[k]));
                tx[k] = F::new(f64::from(x[k] - i));
                ty[k] = F::new(f64::from(y[k] - j));
                let step = i.whole().wrapping_mul(right);
                let step = step.wrapping_add(j.whole().wrapping_mul(down));
                first[k] = starts[k].wrapping_add(step as usize);
            }
        }
    }
}

/// The largest of some numbers, half by half: one after the other, each waits for the one before.
#[inline(always)]
fn most(mut numbers: [f32; LANES]) -> f32 {
    let mut half = LANES / 2;
    while half > 0 {
        for k in 0..half {
            numbers[k] = real::max(numbers[k], numbers[k + half]);
        }
        half /= 2;
    }
    numbers[0]
}
