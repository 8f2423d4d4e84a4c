//! Texels of the target that are parallelograms of shapes of their own, about places of a part of a tile.
//!
//! Lanes follow each other in rows of numbers: where some parallelograms are left out, the others close up first. Picked one by one from
//! where they were, their numbers took as long as the lookups.
//!
//! Only what lies inside of a face is answered for, with all texels that its lookups take part in.

use super::look::Room;
use super::lookups::support;
use super::mean::{Chunks, Margin, Rooms, Way, find, has_windows, put, texels_of};
use super::shapes::{SEVERAL, Shapes, moved, off, pick};
use super::slices::Sides;
use super::spread::{LANES, Spreads, largest};
use super::texture::Texture;
use crate::image::raster::Raster;
use crate::image::texel::Texel;
use crate::kernel::tile::{TILE, Tile};
use crate::kernel::{Scalar, vectorize};
use crate::number::real;
use crate::resample::filters::LookupFilter;

/// Texels that are looked at together: what is known of them stays in the nearest cache.
pub(crate) const TOGETHER: usize = 128;

/// A number of each.
type Row<R> = [R; TOGETHER];

const ZEROS: Row<f32> = [0.0; TOGETHER];

/// Those of up to so many texels.
pub(crate) struct Parallelograms {
    /// The places, in texels.
    centers: [Row<f64>; 2],
    shapes: Shapes<TOGETHER>,
    /// Whether all texels that take part are inside of a face.
    inside: Row<bool>,
    asked: Asked,
}

/// Those of them whose means are found.
struct Asked {
    /// Which ones, and how many.
    own: Row<usize>,
    count: usize,
    /// What is known of them, unless they are all.
    centers: [Row<f64>; 2],
    shapes: Shapes<TOGETHER>,
    /// Where the texels begin that their centers are in, and how far right and down they are from there.
    starts: Row<usize>,
    off: [Row<f32>; 2],
    /// How many numbers lie from a texel to those right and below.
    steps: [i32; 2],
}

/// [`LANES`] numbers of a row.
#[inline(always)]
fn lanes<R: Copy>(row: &Row<R>, chunk: usize) -> [R; LANES] {
    row.as_chunks().0[chunk]
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
            shapes: Shapes::NONE,
            inside: [false; TOGETHER],
            asked: Asked {
                own: [0; TOGETHER],
                count: 0,
                centers: [[0.0; TOGETHER]; 2],
                shapes: Shapes::NONE,
                starts: [0; TOGETHER],
                off: [ZEROS; 2],
                steps: [0; 2],
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
        let margin = Margin::new(raster, face, support(filter));
        let scales = grids.map(|(scale, _)| scale);
        vectorize(
            #[inline(always)]
            || {
                let (slopes, bends) = (scaled(slopes, first, scales), scaled(bends, first, scales));
                self.shapes.set(&slopes, &bends);
                self.inside = [true; TOGETHER];
                let mut ends = [true; TOGETHER];
                for axis in [0, 1] {
                    let (scale, offset) = grids[axis];
                    let center = &mut self.centers[axis];
                    let places = &places.0[axis][first..][..TOGETHER];
                    for (center, place) in center.iter_mut().zip(places) {
                        *center = place.to_f64() * scale + offset;
                    }
                    let reach = &self.shapes.reach[axis];
                    let held = self.inside.iter_mut().zip(&mut ends);
                    let held = held.zip(&*center).zip(reach);
                    for (((inside, ends), &center), &reach) in held {
                        let (held, end) = margin.holds(axis, center, f64::from(reach));
                        *inside &= held;
                        *ends &= end;
                    }
                }
                for (inside, ends) in self.inside.iter_mut().zip(ends) {
                    *inside &= !ends;
                }
            },
        );
    }

    /// Finds the means about places of a tile, as many as `done` is long, where it is not true and they can be had: true there, and a texel in
    /// `means`. Returns how many that are.
    pub(crate) fn means<T: Texel>(
        &mut self,
        (source, filter): (&Texture<'_, T>, LookupFilter),
        (face, rooms): (usize, &mut Rooms<T::Float>),
        done: &mut [bool],
        means: &mut [T],
    ) -> usize {
        let windows = has_windows(filter);
        let mut all = 0;
        for way in Way::ALL {
            self.ask(done, (way, windows), &source.raster, support(filter).after);
            let Asked { count, .. } = self.asked;
            if count > 0 && find((source, filter, way), face, (self, rooms), means) {
                for &texel in &self.asked.own[..count] {
                    done[texel] = true;
                }
                all += count;
            }
        }
        all
    }

    /// Whether the one about place k has several lookups.
    #[inline(always)]
    pub(crate) fn several(&self, k: usize) -> bool {
        self.shapes.totals[k] > 1.0
    }

    /// Whether the image is valid wherever the one about place k reaches, and so many texels around it, for certain.
    #[inline(always)]
    fn is_held(&self, k: usize, raster: &Raster, around: usize) -> bool {
        let reach = self.shapes.reach.each_ref();
        let [x, y] = reach.map(|reach| f64::from(reach[k]) + around as f64);
        let [(su, ou), (sv, ov)] = [raster.along_u.index(), raster.along_v.index()];
        let [u, v] = self.centers.each_ref().map(|center| center[k]);
        raster.holds_around([(u - ou) / su, (v - ov) / sv], [x / su, y / sv])
    }

    /// Asks for those that are not done and have several lookups, all inside of a face.
    fn ask(&mut self, done: &[bool], (way, windows): (Way, bool), raster: &Raster, around: usize) {
        let count = done.len();
        let mut wanted = [false; TOGETHER];
        let totals = self.shapes.totals.iter().zip(&self.shapes.fits);
        for (wanted, (&total, &fits)) in wanted.iter_mut().zip(totals) {
            *wanted = way.takes(total, windows & fits);
        }
        for (wanted, inside) in wanted.iter_mut().zip(&self.inside) {
            *wanted &= inside;
        }
        for (wanted, done) in wanted.iter_mut().zip(done) {
            *wanted &= !done;
        }
        if !wanted.contains(&true) {
            self.asked.count = 0;
            return;
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
                if !raster.has_rim() || self.is_held(k, raster, around) {
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
}

impl<F: Scalar> Chunks<F> for Parallelograms {
    fn start(&mut self, first: usize, steps: [i32; 2]) -> usize {
        let asked = &mut self.asked;
        asked.steps = steps;
        let all = asked.count == TOGETHER;
        let centers = if all { &self.centers } else { &asked.centers };
        vectorize(
            #[inline(always)]
            || {
                let into = (&mut asked.starts, &mut asked.off);
                texels_of(centers.each_ref(), (first, steps), into.0, into.1);
            },
        );
        asked.count.div_ceil(LANES)
    }

    fn sides(&self, chunk: usize, into: &mut Sides) {
        let asked = &self.asked;
        let all = asked.count == TOGETHER;
        let shapes = if all { &self.shapes } else { &asked.shapes };
        into.own = lanes(&asked.own, chunk);
        into.count = LANES.min(asked.count - chunk * LANES);
        into.starts = lanes(&asked.starts, chunk);
        for axis in [0, 1] {
            let [c, _, e] = shapes
                .bends
                .each_ref()
                .map(|bend| lanes(&bend[axis], chunk));
            let off = lanes(&asked.off[axis], chunk);
            for k in 0..LANES {
                into.off[axis][k] = off[k] + moved((c[k], e[k]));
            }
            for side in [0, 1] {
                into.sides[side][axis] = lanes(&shapes.sides[side][axis], chunk);
            }
        }
    }

    fn place(&self, chunk: usize, room: &mut Room<F>) {
        let asked = &self.asked;
        let all = asked.count == TOGETHER;
        let shapes = if all { &self.shapes } else { &asked.shapes };
        vectorize(
            #[inline(always)]
            || {
                // Each by its name: what is behind an index of an axis the compiler makes no lanes of.
                let pair = |pair: &[Row<f32>; 2]| pair.each_ref().map(|row| lanes(row, chunk));
                let [[ax, ay], [bx, by]] = shapes.sides.each_ref().map(pair);
                let [[cx, cy], [dx, dy], [ex, ey]] = shapes.bends.each_ref().map(pair);
                let [ox, oy] = pair(&asked.off);
                let starts = lanes(&asked.starts, chunk);
                let spreads = Spreads::new(pair(&shapes.counts), pair(&shapes.lines));
                room.own = lanes(&asked.own, chunk);
                room.count = LANES.min(asked.count - chunk * LANES);
                room.totals = lanes(&shapes.totals, chunk);
                room.most = largest(room.totals) as usize;
                for number in 0..room.most {
                    let (mut s, mut t) = ([0.0; LANES], [0.0; LANES]);
                    spreads.places(number as f32, &mut s, &mut t);
                    let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
                    for k in 0..LANES {
                        let (s, t) = (s[k], t[k]);
                        x[k] = ox[k] + off((s, t), (ax[k], bx[k]), (cx[k], dx[k], ex[k]));
                        y[k] = oy[k] + off((s, t), (ay[k], by[k]), (cy[k], dy[k], ey[k]));
                    }
                    put(room, number, [&x, &y], (&starts, asked.steps));
                }
            },
        );
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
