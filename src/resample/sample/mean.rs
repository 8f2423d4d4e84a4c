//! Means of lookups, evenly spread over parallelograms of the source.
//!
//! What a texel of the target sees, where coordinates hardly bend, is a parallelogram of the source. Its mean is that of
//! bilinear lookups on a grid within it, one for about every source texel. Put together from single lookups, in tiles
//! like any others, keeping account of which belongs to whom took ten times as long as the lookups. Here all of one
//! texel are made one after the other, from the window that holds them.
//!
//! Only what lies inside of a face is answered for, with all texels that its lookups take part in.

use super::gather::{four, mix};
use crate::image::raster::Raster;
use crate::image::texel::{Four, Texel};
use crate::kernel::tile::{TILE, Tile};
use crate::kernel::{Scalar, SimdWork, run_simd, vectorize};
use crate::number::real::{self, Real};
use crate::resample::sample::Texture;
use fearless_simd::{Simd, SimdBase};

/// The most lookups in one mean.
pub(crate) const MOST: usize = 64;

/// A side is divided so that places lie at most this much more than a source texel apart: rounding at whole
/// numbers must not double the work.
const SLACK: f64 = 0.15;

/// Which part of a side of r source texels places are spread over, and how many of them divide it.
///
/// That is min(r, √(2(r² - 1))) texels: from nothing at r = 1, where one lookup already is as wide as a texel, to the whole side
/// from r = √2 on.
#[inline(always)]
pub(crate) fn division<R: Real>(r: R) -> [R; 2] {
    let one = R::ONE;
    let spread = real::max(R::TWO * (r * r - one), R::ZERO).sqrt() / r;
    let share = R::select(r.more(one), real::min(spread, one), R::ZERO);
    [share, count(real::min(r, R::new(1e9)) * share)]
}

/// How many places divide a length in source texels.
#[inline(always)]
pub(crate) fn count<R: Real>(length: R) -> R {
    let least = real::min(length - R::new(SLACK), R::new(MOST as f64));
    real::max(-(-least).floor(), R::ONE)
}

/// Parallelograms of the source, about places of a tile. They are few, and f64 whatever the places are.
pub(crate) struct Parallelograms {
    /// The places, in texels.
    centers: [[f64; TILE]; 2],
    /// The part of each side that places are spread over, along x and y: right and down in the target.
    sides: [[[f64; TILE]; 2]; 2],
    /// By how much they are bent: factors of squares to the right, of products, and of squares down.
    bends: [[[f64; TILE]; 2]; 3],
    /// How many places divide it.
    counts: [[f64; TILE]; 2],
}

impl Parallelograms {
    pub(crate) fn new() -> Self {
        let zeros = [0.0; TILE];
        Parallelograms {
            centers: [zeros; 2],
            sides: [[zeros; 2]; 2],
            bends: [[zeros; 2]; 3],
            counts: [zeros; 2],
        }
    }

    /// Takes over the first `count` of a tile: ∂u and ∂v to the right, and ∂u and ∂v down; and their second derivatives. Those
    /// without a side whose square is above `near` texels have one lookup.
    pub(crate) fn set<R: Scalar>(
        &mut self,
        raster: &Raster,
        places: &Tile<R, 3>,
        (slopes, bends): (&Tile<R, 4>, &Tile<R, 6>),
        near: f64,
        count: usize,
    ) {
        let [(su, ou), (sv, ov)] = [raster.along_u.index(), raster.along_v.index()];
        vectorize(
            #[inline(always)]
            || {
                for k in 0..count.min(TILE) {
                    let [au, av, bu, bv] = slopes.at(k).map(Scalar::to_f64);
                    let ([ax, ay], [bx, by]) = ([au * su, av * sv], [bu * su, bv * sv]);
                    let (a, b) = (ax * ax + ay * ay, bx * bx + by * by);
                    let [[p, m], [q, n]] = [division(a.sqrt()), division(b.sqrt())];
                    let [u, v, _] = places.at(k).map(Scalar::to_f64);
                    (self.centers[0][k], self.centers[1][k]) = (u * su + ou, v * sv + ov);
                    (self.sides[0][0][k], self.sides[0][1][k]) = (ax * p, ay * p);
                    (self.sides[1][0][k], self.sides[1][1][k]) = (bx * q, by * q);
                    let [cu, cv, du, dv, eu, ev] = bends.at(k).map(Scalar::to_f64);
                    let factors = [
                        (0.5 * p * p, cu, cv),
                        (p * q, du, dv),
                        (0.5 * q * q, eu, ev),
                    ];
                    for (bend, (factor, along_u, along_v)) in self.bends.iter_mut().zip(factors) {
                        (bend[0][k], bend[1][k]) = (factor * along_u * su, factor * along_v * sv);
                    }
                    let one = real::max(a, b) <= near;
                    self.counts[0][k] = if one { 1.0 } else { m };
                    self.counts[1][k] = if one { 1.0 } else { n };
                }
            },
        );
    }

    /// Whether the one about place k has several lookups.
    #[inline(always)]
    pub(crate) fn several(&self, k: usize) -> bool {
        self.counts[0][k] * self.counts[1][k] > 1.0
    }

    /// That about place k.
    #[inline(always)]
    pub(crate) fn at(&self, k: usize) -> Parallelogram {
        Parallelogram {
            center: self.centers.each_ref().map(|x| x[k]),
            sides: self.sides.each_ref().map(|[x, y]| [x[k], y[k]]),
            bends: self.bends.each_ref().map(|[x, y]| [x[k], y[k]]),
            counts: self.counts.each_ref().map(|count| count[k] as usize),
        }
    }
}

/// A place in texels, and sides that places are spread over, bent a little.
#[derive(Clone, Copy)]
pub(crate) struct Parallelogram {
    pub(crate) center: [f64; 2],
    sides: [[f64; 2]; 2],
    bends: [[f64; 2]; 3],
    /// How many places divide each.
    pub(crate) counts: [usize; 2],
}

impl Parallelogram {
    /// How far it reaches from its center along x and y.
    #[inline(always)]
    pub(crate) fn reach(&self) -> [f64; 2] {
        let ([a, b], [c, d, e]) = (self.sides, self.bends);
        [0, 1].map(|axis| {
            let straight = a[axis].abs() + b[axis].abs();
            0.5 * straight + 0.25 * (c[axis].abs() + d[axis].abs() + e[axis].abs())
        })
    }

    /// Places of one row, from its center.
    #[inline(always)]
    pub(crate) fn row(&self, row: usize) -> impl Fn(usize) -> [f64; 2] + use<> {
        let ([a, b], [c, d, e]) = (self.sides, self.bends);
        let [step, t] = [1.0 / self.counts[0] as f64, 1.0 / self.counts[1] as f64];
        let t = (row as f64 + 0.5) * t - 0.5;
        let middle = [0, 1].map(|axis| t * (b[axis] + t * e[axis]));
        let slope = [0, 1].map(|axis| a[axis] + t * d[axis]);
        #[inline(always)]
        move |column| {
            let s = (column as f64 + 0.5) * step - 0.5;
            [0, 1].map(|axis| middle[axis] + s * (slope[axis] + s * c[axis]))
        }
    }

    /// Whether all texels that its lookups weight are inside of a face and valid, where that is easily told.
    #[inline(always)]
    fn inside(&self, raster: &Raster) -> bool {
        let [x, y] = self.reach();
        let [(su, ou), (sv, ov)] = [raster.along_u.index(), raster.along_v.index()];
        let last = [raster.width, raster.height].map(|n| n as f64 - 1.0);
        let within = |axis: usize, reach: f64| {
            (self.center[axis] >= reach) & (self.center[axis] + reach < last[axis])
        };
        let place = [(self.center[0] - ou) / su, (self.center[1] - ov) / sv];
        // With a texel around it.
        let reach = [(x + 1.0) / su, (y + 1.0) / sv];
        within(0, x) && within(1, y) && raster.holds_around(place, reach)
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
            first: [0; MOST],
            tx: [T::Float::ZERO; MOST],
            ty: [T::Float::ZERO; MOST],
        },
        raster,
        seen,
        done,
        means,
    });
}

struct Means<'m, 'a, T: Texel> {
    lookups: Lookups<'a, T>,
    raster: &'m Raster,
    seen: &'m Parallelograms,
    done: &'m mut [bool],
    means: &'m mut [T],
}

impl<T: Texel> SimdWork for Means<'_, '_, T> {
    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let channels = self.lookups.channels;
        for (k, done) in self.done.iter_mut().enumerate() {
            if !self.seen.several(k) {
                continue;
            }
            let seen = self.seen.at(k);
            let [m, n] = seen.counts;
            if m * n > MOST || !seen.inside(self.raster) || !self.lookups.place(&seen) {
                continue;
            }
            // Of three numbers, four are written: the next texel's come after.
            let mean = &mut self.means[k * channels..];
            if let (3 | 4, Some(mean)) = (channels, mean.first_chunk_mut()) {
                *mean = self.lookups.mean_of_four(simd);
            } else {
                self.lookups.mean(&mut mean[..channels]);
            }
            *done = true;
        }
    }
}

/// A whole number from 0 to 2⁵² as an integer. `as` looks for what is none, and integers would be multiplied in lanes that have no
/// instruction for it.
#[inline(always)]
fn whole(x: f64) -> usize {
    const MAGIC: f64 = (1_u64 << 52) as f64;
    (x + MAGIC).to_bits().wrapping_sub(MAGIC.to_bits()) as usize
}

/// Those of one mean: where their windows begin, and how far the places lie right of and below the first texel.
struct Lookups<'a, T: Texel> {
    texels: &'a [T],
    channels: usize,
    row: usize,
    /// The face's first texel.
    start: usize,
    count: usize,
    first: [usize; MOST],
    tx: [T::Float; MOST],
    ty: [T::Float; MOST],
}

impl<T: Texel> Lookups<'_, T> {
    /// False where the image ends before a window does.
    #[inline(always)]
    fn place(&mut self, seen: &Parallelogram) -> bool {
        let [m, n] = seen.counts;
        // Four numbers are read at a time.
        let window = (self.row + 1) * self.channels + 4;
        let last = self.texels.len().checked_sub(window);
        let steps = [self.channels, self.row * self.channels].map(|step| step as f64);
        let first = (self.start * self.channels) as f64;
        let mut farthest = 0;
        self.count = 0;
        for row in 0..n {
            let row = seen.row(row);
            for column in 0..m {
                let [x, y] = row(column);
                let (x, y) = (seen.center[0] + x, seen.center[1] + y);
                let (i, j) = (Real::floor(x), Real::floor(y));
                let at = whole(first + (j * steps[1] + i * steps[0]));
                farthest = at.max(farthest);
                self.first[self.count] = at;
                self.tx[self.count] = Real::new(x - i);
                self.ty[self.count] = Real::new(y - j);
                self.count += 1;
            }
        }
        last.is_some_and(|last| farthest <= last)
    }

    #[inline(always)]
    fn share(&self) -> T::Float {
        Real::new(1.0 / self.count as f64)
    }

    #[inline(always)]
    fn list(&self) -> impl Iterator<Item = (usize, T::Float, T::Float)> {
        let steps = self.tx.iter().zip(&self.ty);
        let lookups = self.first[..self.count].iter().zip(steps);
        lookups.map(|(&first, (&tx, &ty))| (first, tx, ty))
    }

    /// The mean of four numbers a lookup, difference by difference from the first one: a constant stays constant to the bit.
    #[inline(always)]
    fn mean_of_four<S: Simd>(&self, simd: S) -> [T; 4] {
        let splat = |x| Four::<T, S>::splat(simd, x);
        let share = splat(self.share());
        let (mut base, mut sum) = (splat(T::Float::ZERO), splat(T::Float::ZERO));
        let step = self.row * self.channels;
        for (k, (first, tx, ty)) in self.list().enumerate() {
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
    fn mean(&self, mean: &mut [T]) {
        let share = self.share();
        let below = self.row * self.channels;
        for (c, mean) in mean.iter_mut().enumerate() {
            let (mut base, mut sum) = (T::Float::ZERO, T::Float::ZERO);
            for (k, (first, tx, ty)) in self.list().enumerate() {
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
