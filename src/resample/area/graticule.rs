//! Areas between images whose columns are meridians and whose rows are parallels about one axis: panoramas and cylinders,
//! as they are, turned about that axis, upside down or mirrored.
//!
//! A row of the target and one of the source have a zone of the sphere in common, a column of each a sector of longitude, and what
//! a texel of each shares is the product. So each row of the target is a weighted sum of whole rows of the source, and each of
//! its texels one of a few neighbors in that sum. Zones are the source's own solid angles, in whose rows the target's edges are found
//! by the two formulas; what rounding leaves between edges that coincide is no overlap, as on the other paths.
//!
//! What did not help: running sums along a row, from which any sector is a difference. A sun of 1e9 leaves 1e-7 of rounding in
//! all that follow it.

use crate::error::Error;
use crate::geometry::solid_angle::Rect;
use crate::image::texel::Texel;
use crate::kernel::{Scalar, SimdWork, interrupt, run_simd, threads};
use crate::map::Map;
use crate::number::angle;
use crate::number::real::Real;
use crate::resample::area::frame::turn;
use crate::resample::area::lattice::{Lattice, NOTHING};
use crate::resample::area::statistic::{Of, Sum, Tallies, is_plain};
use crate::resample::filters::AreaFilter;
use crate::resample::request::{Request, Sight};
use fearless_simd::{Simd, SimdBase};
use std::ops::Range;

/// How far from its own axis a turned one may lie, in radians: as far as other paths turn the target to keep edges apart.
const HAIR: f64 = 1e-11;

/// For each row or column of a target those of the source that it meets, and how much of it lies in each.
pub(super) struct Shares {
    ends: Vec<usize>,
    all: Vec<(usize, f64)>,
    /// How many of the source's one covers, of the one that covers fewest.
    fewest: f64,
}

impl Shares {
    /// Those of as many intervals of the target as are given, among the source's; `add` calls back with all that one meets, how
    /// much they share, and how much of the source's own that is along the image.
    pub(super) fn new(
        count: usize,
        mut add: impl FnMut(usize, &mut dyn FnMut(usize, f64, f64)),
    ) -> Self {
        let mut shares = Shares {
            ends: Vec::with_capacity(count),
            all: Vec::with_capacity(2 * count),
            fewest: f64::INFINITY,
        };
        for number in 0..count {
            let start = shares.all.len();
            let (mut whole, mut covered) = (0.0, 0.0);
            add(number, &mut |at, part, of_it| {
                whole += part;
                covered += of_it;
                shares.all.push((at, part));
            });
            shares.fewest = shares.fewest.min(covered);
            for (_, part) in &mut shares.all[start..] {
                *part /= whole;
            }
            shares.ends.push(shares.all.len());
        }
        shares
    }

    /// Those of one of the target's.
    #[inline(always)]
    fn of(&self, number: usize) -> &[(usize, f64)] {
        let start = number.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.all[start..self.ends[number]]
    }
}

/// What two images have in common.
pub(super) struct Graticule {
    pub(super) rows: Shares,
    pub(super) columns: Shares,
}

/// The edges of an image's columns (axis 0) or rows, first to last.
pub(super) fn edges(lattice: &Lattice<'_>, axis: usize) -> impl Iterator<Item = f64> {
    let count = [lattice.columns, lattice.rows][axis];
    (0..=count).map(move |k| lattice.line(axis, 2 * k as isize))
}

/// The cells between edges that an interval meets: all that may share more than an end with it.
pub(super) fn met(edges: &[f64], [from, to]: [f64; 2]) -> Range<usize> {
    let first = edges.partition_point(|edge| *edge <= from);
    let last = edges.partition_point(|edge| *edge < to);
    first.saturating_sub(1)..last.min(edges.len() - 1)
}

impl Graticule {
    /// None unless columns of both images are meridians and rows parallels, about the same axis.
    pub fn between(
        (source, shape): (&Map, &[usize]),
        sight: Sight<'_>,
    ) -> Result<Option<Self>, Error> {
        let target = sight.map;
        let (Some(from_edge), Some(into_edge)) = (source.meridians(), target.meridians()) else {
            return Ok(None);
        };
        const AS_IT_IS: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let turn = turn(source, target, sight.rotation, AS_IT_IS);
        let upright = angle::length(turn[1][0], turn[1][2]) <= HAIR;
        if !upright {
            return Ok(None);
        }
        let from = Lattice::new(source, shape, None)?.refine(1);
        let into = Lattice::new(target, sight.shape, None)?.refine(1);
        let rows = rows([&from, &into], turn[1][1].signum());
        let mirrored = turn[0][0] * turn[2][2] < turn[0][2] * turn[2][0];
        // Where the target's middle meridian lies.
        let ahead = f64::half_turns(turn[0][2].abs(), turn[2][2]).copysign(turn[0][2]);
        let way = if mirrored { -1.0 } else { 1.0 };
        let columns = columns([&from, &into], [from_edge, into_edge], [ahead, way]);
        Ok(Some(Graticule { rows, columns }))
    }

    /// How many columns and rows of the source a texel of the target covers, of those that cover fewest.
    pub fn fewest(&self) -> [f64; 2] {
        [&self.columns, &self.rows].map(|shares| shares.fewest)
    }

    /// Fills the image that a request asks for.
    #[inline(never)]
    pub fn convert<T: Texel>(&self, request: Request<'_, T>, of: Of, out: &mut [T]) {
        let (image, window) = (request.image, request.window);
        let channels = image.channels();
        let wide = image.shape().last().map_or(0, |columns| columns * channels);
        let width = window.columns.len() * channels;
        let points = self.rows.all.len() * wide + window.texels();
        // A window that goes over the source's seam takes all between its two ends: the whole row.
        let met = window.columns.clone();
        let met = met.flat_map(|column| self.columns.of(column).iter().map(|share| share.0));
        let (first, last) = (met.clone().min(), met.max());
        let needed = first
            .zip(last)
            .map_or(0..0, |(first, last)| first..last + 1);
        let way = match of.filter {
            AreaFilter::Mode => Way::Lists,
            AreaFilter::Area if is_plain::<T>(of.skipna) => Way::Plain,
            AreaFilter::Area => Way::Sums,
        };
        interrupt::part(0.0, 1.0, || {
            threads::bands(out, width, points, 1, |first, band| {
                let mut tallies = Tallies::new(image, of, 1);
                let mut line = Line::default();
                for (row, out) in band.chunks_exact_mut(width).enumerate() {
                    let rows = self.rows.of(window.rows.start + first + row);
                    let texels = rows.iter().map(|&(row, share)| {
                        let texels = &image.texels()[row * wide..][..wide];
                        let met = &texels[needed.start * channels..needed.end * channels];
                        (met, share)
                    });
                    match way {
                        Way::Plain => line.add_plain(texels),
                        Way::Sums => line.add(texels, of.skipna),
                        Way::Lists => {}
                    }
                    let texels = window.columns.clone().zip(out.chunks_exact_mut(channels));
                    for (column, out) in texels {
                        let columns = self.columns.of(column);
                        if rows.is_empty() || columns.is_empty() {
                            out.copy_from_slice(request.fill);
                            continue;
                        }
                        match way {
                            Way::Plain => line.store_plain(columns, needed.start, out),
                            Way::Sums => line.store(columns, needed.start, out),
                            Way::Lists => {
                                tallies.clear();
                                tallies.add(0, line.list(rows, columns, wide / channels));
                                tallies.store(0, 0.0, request.fill, out);
                            }
                        }
                    }
                }
            });
        });
    }
}

/// How what texels share is put together.
#[derive(Clone, Copy)]
enum Way {
    /// As sums alone.
    Plain,
    /// With what has weight, the least and the most.
    Sums,
    /// One by one.
    Lists,
}

/// The rows of the source that each row of the target meets; `way` is -1 where the target stands on its head.
fn rows([from, into]: [&Lattice<'_>; 2], way: f64) -> Shares {
    let theirs: Vec<f64> = edges(from, 1).collect();
    let zone = |v0: f64, v1: f64| {
        from.raster.solid_angle(Rect {
            v0,
            v1,
            ..Rect::WHOLE
        })
    };
    let zones: Vec<f64> = theirs.windows(2).map(|row| zone(row[0], row[1])).collect();
    let ours: Vec<f64> = edges(into, 1)
        .map(|v| {
            let [y, flat] = into.map.parallel(v);
            let v = from.map.row_of([way * y, flat]);
            // What the source does not reach lies above it or below.
            if v.is_nan() {
                f64::from(u8::from(way * y > 0.0))
            } else {
                v
            }
        })
        .collect();
    Shares::new(into.raster.height, |row, add| {
        let (a, b) = (ours[row], ours[row + 1]);
        let (from, to) = (a.min(b), a.max(b));
        let whole = zone(from, to);
        for k in met(&theirs, [from, to]) {
            let (first, last) = (from.max(theirs[k]), to.min(theirs[k + 1]));
            let part = zone(first, last);
            if part > NOTHING * zones[k].min(whole) {
                add(k, part, (last - first) / (theirs[k + 1] - theirs[k]));
            }
        }
    })
}

/// The columns of the source that each column of the target meets, the middle of the target lying `ahead` of the source's, and its
/// longitudes going the same way or the other.
fn columns(
    [from, into]: [&Lattice<'_>; 2],
    [from_edge, into_edge]: [f64; 2],
    [ahead, way]: [f64; 2],
) -> Shares {
    let longitudes = |lattice: &Lattice<'_>, edge: f64| -> Vec<f64> {
        edges(lattice, 0).map(|u| (2.0 * u - 1.0) * edge).collect()
    };
    let theirs = longitudes(from, from_edge);
    let ours = longitudes(into, into_edge);
    Shares::new(into.raster.width, |column, add| {
        let [a, b] = [column, column + 1].map(|k| ahead + way * ours[k]);
        let (left, right) = (a.min(b), a.max(b));
        // The same place, once or more around.
        let first = ((-from_edge - right) * 0.5).floor() as i64;
        let last = ((from_edge - left) * 0.5).ceil() as i64;
        for around in first..=last {
            let [from, to] = [left, right].map(|place| place + 2.0 * around as f64);
            for k in met(&theirs, [from, to]) {
                let part = to.min(theirs[k + 1]) - from.max(theirs[k]);
                let own = theirs[k + 1] - theirs[k];
                if part > NOTHING * own.min(to - from) {
                    add(k, part, part / own);
                }
            }
        }
    })
}

/// Rows of a source, added for a row of the target.
#[derive(Default)]
struct Line {
    plain: Vec<f64>,
    sums: Vec<Sum>,
    pairs: Vec<(usize, f64)>,
}

impl Line {
    /// Σ of rows, weighed.
    fn add_plain<'a, T: Texel>(&mut self, rows: impl Iterator<Item = (&'a [T], f64)>) {
        let rows: Vec<(&[T], f64)> = rows.collect();
        self.plain.clear();
        self.plain
            .resize(rows.first().map_or(0, |(row, _)| row.len()), 0.0);
        run_simd(AddRows {
            sums: &mut self.plain,
            rows: &rows,
        });
    }

    /// The same where values that are not finite may count for nothing, and a mean has to lie within the values.
    fn add<'a, T: Texel>(&mut self, rows: impl Iterator<Item = (&'a [T], f64)>, skipna: bool) {
        self.sums.clear();
        for (row, share) in rows {
            self.sums.resize(row.len(), Sum::NONE);
            for (sum, value) in self.sums.iter_mut().zip(row) {
                let value = value.load().to_f64();
                if !skipna || value.is_finite() {
                    sum.add(value, share);
                }
            }
        }
    }

    /// The stored texels in these rows and columns of an image so wide, and how much of each.
    fn list(
        &mut self,
        rows: &[(usize, f64)],
        columns: &[(usize, f64)],
        wide: usize,
    ) -> &[(usize, f64)] {
        self.pairs.clear();
        for &(row, part) in rows {
            let pair = |&(column, share): &(usize, f64)| (row * wide + column, part * share);
            self.pairs.extend(columns.iter().map(pair));
        }
        &self.pairs
    }

    /// Writes the texel that meets these columns, which are counted from the image's first; the line has those from `first` on.
    #[inline(always)]
    fn store_plain<T: Texel>(&self, columns: &[(usize, f64)], first: usize, out: &mut [T]) {
        match out.len() {
            1 => self.store_plain_of::<T, 1>(columns, first, out),
            2 => self.store_plain_of::<T, 2>(columns, first, out),
            3 => self.store_plain_of::<T, 3>(columns, first, out),
            4 => self.store_plain_of::<T, 4>(columns, first, out),
            channels => {
                for (channel, out) in out.iter_mut().enumerate() {
                    let value = |column: usize| self.plain[(column - first) * channels + channel];
                    let all = columns.iter();
                    let mean = all.map(|&(column, share)| share * value(column)).sum();
                    *out = T::store(<T::Float as Real>::new(mean));
                }
            }
        }
    }

    #[inline(always)]
    fn store_plain_of<T: Texel, const N: usize>(
        &self,
        columns: &[(usize, f64)],
        first: usize,
        out: &mut [T],
    ) {
        let (sums, _) = self.plain.as_chunks::<N>();
        let mut mean = [0.0; N];
        for &(column, share) in columns {
            for (mean, sum) in mean.iter_mut().zip(&sums[column - first]) {
                *mean += share * sum;
            }
        }
        for (out, mean) in out.iter_mut().zip(mean) {
            *out = T::store(<T::Float as Real>::new(mean));
        }
    }

    fn store<T: Texel>(&self, columns: &[(usize, f64)], first: usize, out: &mut [T]) {
        let channels = out.len();
        for (channel, out) in out.iter_mut().enumerate() {
            let mut sum = Sum::NONE;
            for &(column, share) in columns {
                sum.merge(&self.sums[(column - first) * channels + channel], share);
            }
            *out = T::store(<T::Float as Real>::new(sum.mean()));
        }
    }
}

/// Numbers of a row that are added at a time: their sums stay in the CPU's first cache.
const PART: usize = 1024;

/// Adds rows of numbers to sums, weighed.
struct AddRows<'a, T> {
    sums: &'a mut [f64],
    rows: &'a [(&'a [T], f64)],
}

impl<T: Texel> SimdWork for AddRows<'_, T> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        for (number, sums) in self.sums.chunks_mut(PART).enumerate() {
            for (row, share) in self.rows {
                add(simd, sums, &row[number * PART..][..sums.len()], *share);
            }
        }
    }
}

#[inline(always)]
fn add<T: Texel, S: Simd>(simd: S, sums: &mut [f64], row: &[T], share: f64) {
    let (eights, last) = row.as_chunks::<8>();
    // Of conversions one by one the compiler makes lanes by itself, and better ones.
    let together = if T::BY_FOURS { eights.len() } else { 0 };
    let (sums, rest) = sums.split_at_mut(8 * together);
    for (sums, eight) in sums.as_chunks_mut::<8>().0.iter_mut().zip(eights) {
        let mut numbers = [<T::Float as Real>::ZERO; 8];
        T::load_eight(simd, eight).store_array(&mut numbers);
        for (sum, number) in sums.iter_mut().zip(numbers) {
            *sum += share * number.to_f64();
        }
    }
    let last = if T::BY_FOURS { last } else { row };
    for (sum, value) in rest.iter_mut().zip(last) {
        *sum += share * value.load().to_f64();
    }
}
