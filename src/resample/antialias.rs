//! Conversion to fewer texels: the source is averaged over what each target texel sees.
//!
//! A texel whose sides cross r > 1 source texels is looked up at several places, one for about every source texel that it
//! covers, spread evenly over it; their mean, by solid angle, is the texel. The work is bounded by the source's size, for
//! every source texel is looked up about once, and no smaller copies of the source are made. Each lookup is a
//! lookup: every filter and every seam is as right here as elsewhere.
//!
//! - The choice is each texel's own, and each side's: the poles of a latlong are finer than its equator. Which texels
//!   need more than one lookup follows from the maps' Jacobians (`footprint`); blocks of the target in which no
//!   neighbors lie far apart in the source are not looked at.
//! - Places are spread over min(r, √(2(r² - 1))) source texels: from nothing at r = 1, where one lookup
//!   already is as wide as a texel, to the whole side from r = √2 on. So nothing jumps where the target turns from finer
//!   to coarser.
//! - Where a polynomial stands for a block's coordinates (`patch`), its slopes are the Jacobian, and a texel is a parallelogram
//!   in the source, of one density, if it is small.
//! - A texel that covers much is halved, again and again, until one Jacobian describes each part: a part has at
//!   most [`MOST`] places and spans at most [`WIDEST`]. Near a pole halving ends with the rows.
//! - What the source does not hold has no part in a mean. A texel whose own center sees nothing is `fill`, as without.
//!
//! A lone sun of one texel keeps its energy within 9 % (r near 1.4), 1 % from r = 4 on: places and texels beat against each
//! other. `filter="area"` keeps it exactly.
//!
//! What did not help: a mip chain. It costs a copy, and a lookup in it is as wide as a coarse texel is long: twice
//! the error of these means.

use crate::image::raster::{Block, Raster};
use crate::image::texel::Texel;
use crate::image::texels::Centers;
use crate::kernel::tile::{TILE, Tile};
use crate::kernel::{Scalar, vectorize};
use crate::number::real::Real;
use crate::projections::projection::Outline;
use crate::resample::coordinate_map::CoordinateMap;
use crate::resample::filters::LookupFilter;
use crate::resample::footprint::{Footprint, Part, measure};
use crate::resample::polynomial::CoordinatePolynomial;
use crate::resample::sample::{Lookups, Rectangle, Texture};

/// The most places in a part of a texel.
const MOST: usize = 64;

/// The widest part of a texel of several places, in radians: over it a map's density is taken as constant.
const WIDEST: f64 = 0.035;

/// Places are spread over this share of a side at least: over nothing that could be seen.
const NARROW: f64 = 1e-3;

/// By how many source texels a texel may differ from a parallelogram that is taken for it: as little as f32
/// coordinates are off.
const BEND: f64 = 1.0 / 350.0;

/// Sides are not halved below this, in u or v.
const SHORTEST: f64 = 1e-6;

/// A side is divided so that places lie at most this much more than a source texel apart: rounding at whole
/// numbers must not double the work.
const SLACK: f64 = 0.15;

/// Neighbors nearer than this, squared and in source texels, belong to texels of one lookup: below the 1.66
/// at which a side gets a second one.
const NEAR: f64 = 1.5;

/// Averages for the texels of a band of the target.
pub(crate) struct Antialias<'s, 'a, T: Texel, R> {
    source: &'s Texture<'a, T>,
    target: &'s Raster,
    coordinate_map: CoordinateMap<'s>,
    channels: usize,
    lookups: Lookups<'s, 'a, T, T::Float, R>,
    parts: Vec<(Part, u16)>,
    /// Of the samples that are being put together.
    next: Owners,
    /// Of those that are being looked up, and of those whose values are there.
    owners: [Owners; 2],
    /// Whether the texels of the present patch are parallelograms in the source; none where nobody asked yet.
    flat: Option<bool>,
    values: Vec<T::Float>,
    current: usize,
    sums: Sums,
    done: Vec<(usize, T)>,
}

/// Which texels the samples of a tile belong to, and how much they count: those of one follow each other.
#[derive(Clone, Copy)]
struct Owners {
    /// One more than samples: those of the last may not fit any more.
    runs: [Run; TILE + 1],
    length: usize,
    /// How many samples there are.
    count: usize,
    /// Whether the source holds anything there.
    seen: [bool; TILE],
}

#[derive(Clone, Copy)]
struct Run {
    texel: u16,
    /// The first sample; the last is the one before the next run's.
    first: u16,
    /// Of each sample.
    weight: f64,
}

impl Owners {
    const NONE: Owners = Owners {
        runs: [Run {
            texel: 0,
            first: 0,
            weight: 0.0,
        }; TILE + 1],
        length: 0,
        count: 0,
        seen: [false; TILE],
    };

    /// What comes next belongs to this texel.
    fn begin(&mut self, texel: u16, weight: f64) {
        self.runs[self.length] = Run {
            texel,
            first: self.count as u16,
            weight,
        };
        self.length += 1;
    }
}

/// Sums for the texels of a block. Differences from a texel's first value are added, so that a constant stays
/// constant to the bit.
struct Sums {
    weights: [f64; TILE],
    first: Vec<f64>,
    sums: Vec<f64>,
}

impl Sums {
    /// Adds the samples of a run that were seen. CHANNELS is 0 where their number is known at run time only.
    #[inline(always)]
    fn add<F: Scalar, const CHANNELS: usize>(
        &mut self,
        run: Run,
        channels: usize,
        values: &[F],
        seen: &[bool],
    ) {
        let texel = usize::from(run.texel);
        let own = texel * channels..(texel + 1) * channels;
        let (first, sums) = (&mut self.first[own.clone()], &mut self.sums[own]);
        let samples = values.chunks_exact(channels).zip(seen);
        let mut samples = samples.filter(|(_, seen)| **seen).peekable();
        if self.weights[texel] == 0.0
            && let Some((values, _)) = samples.peek()
        {
            for (first, value) in first.iter_mut().zip(*values) {
                *first = value.to_f64();
            }
            sums.fill(0.0);
        }
        if CHANNELS > 0 {
            let (mut sum, mut base, mut count) = ([0.0; CHANNELS], [0.0; CHANNELS], 0.0);
            base.copy_from_slice(first);
            for (values, _) in samples {
                for k in 0..CHANNELS {
                    sum[k] += values[k].to_f64() - base[k];
                }
                count += 1.0;
            }
            for (total, sum) in sums.iter_mut().zip(sum) {
                *total += run.weight * sum;
            }
            self.weights[texel] += run.weight * count;
        } else {
            for (values, _) in samples {
                for ((sum, first), value) in sums.iter_mut().zip(&*first).zip(values) {
                    *sum += run.weight * (value.to_f64() - *first);
                }
                self.weights[texel] += run.weight;
            }
        }
    }
}

impl<'s, 'a, T: Texel, R: Scalar> Antialias<'s, 'a, T, R> {
    /// For a target of a source. `nothing` has a number for each channel.
    pub fn new(
        source: &'s Texture<'a, T>,
        target: &'s Raster,
        coordinate_map: CoordinateMap<'s>,
        filter: LookupFilter,
        nothing: &'s [T::Float],
    ) -> Self {
        let channels = nothing.len();
        Antialias {
            source,
            target,
            coordinate_map,
            channels,
            lookups: Lookups::new(source, filter, nothing),
            parts: Vec::new(),
            next: Owners::NONE,
            owners: [Owners::NONE; 2],
            flat: None,
            values: vec![T::Float::default(); 2 * TILE * channels],
            current: 0,
            sums: Sums {
                weights: [0.0; TILE],
                first: vec![0.0; TILE * channels],
                sums: vec![0.0; TILE * channels],
            },
            done: Vec::new(),
        }
    }

    /// What follows are blocks of another patch.
    pub fn next_patch(&mut self) {
        self.flat = None;
    }

    /// Averages those texels of a block that need it: `places` are where they lie in the source, and `patch` is where
    /// these come from, with the number of the block's first row in it. [`Antialias::write`] puts the means where they belong.
    pub fn block(
        &mut self,
        centers: &Centers<R>,
        block: &Block,
        places: &Tile<R, 3>,
        patch: Option<(&CoordinatePolynomial<R>, usize)>,
        area: Rectangle,
    ) {
        if !coarse(&self.source.raster, places, block) {
            return;
        }
        let n = block.columns * block.rows;
        let mut uv = Tile::new();
        centers.of(block, &mut uv);
        self.sums.weights = [0.0; TILE];
        let patch = patch.filter(|(patch, _)| self.flat(patch, block, &uv));
        let mut slopes = Tile::new();
        if let Some((patch, row)) = patch {
            patch.slopes(row, block, &mut slopes);
        }
        vectorize(
            #[inline(always)]
            || {
                for k in 0..n {
                    if patch.is_none() || !self.near(places.at(k), slopes.at(k), k as u16) {
                        let part = Part::of_texel(self.target, uv.at(k).map(Scalar::to_f64));
                        self.parts.push((part, k as u16));
                    }
                }
            },
        );
        self.look(false);
        let mut whole = true;
        while !self.parts.is_empty() {
            self.divide(whole);
            whole = false;
        }
        self.look(true);
        self.lookups.finish(&mut self.values);
        self.collect();
        for (k, weight) in self.sums.weights[..n].iter().enumerate() {
            if *weight > 0.0 {
                let at = area.start + k / area.columns * area.stride + k % area.columns;
                for c in k * self.channels..(k + 1) * self.channels {
                    let value = self.sums.first[c] + self.sums.sums[c] / weight;
                    let value = T::store(<T::Float as Real>::new(value));
                    self.done
                        .push((at * self.channels + c % self.channels, value));
                }
            }
        }
    }

    /// Whether texels of a patch are as good as parallelograms in the source, and need no weights by solid angle. `uv` are the
    /// centers of one of its blocks.
    fn flat(&mut self, patch: &CoordinatePolynomial<R>, block: &Block, uv: &Tile<R, 3>) -> bool {
        if let Some(flat) = self.flat {
            return flat;
        }
        let raster = &self.source.raster;
        let scale = [raster.along_u.index().0, raster.along_v.index().0];
        let mut footprints = [Footprint::default(); 2];
        let parts = [0, block.columns * block.rows - 1]
            .map(|k| Part::of_texel(self.target, uv.at(k).map(Scalar::to_f64)));
        measure(&self.coordinate_map, raster, &parts, &mut footprints);
        let small = footprints.iter().all(|footprint| {
            let [a, b] = footprint.angles;
            a.max(b) < 0.5 * WIDEST
        });
        let halves = self.target.along_u.on_edges() || self.target.along_v.on_edges();
        let flat = small && !halves && patch.bend(scale) <= BEND;
        self.flat = Some(flat);
        flat
    }

    /// Looks up places in a texel that is a parallelogram about a place of the source, with the sides `slopes`, if it needs
    /// several. False where something is in the way.
    #[inline(always)]
    fn near(&mut self, [u, v, face]: [R; 3], slopes: [R; 4], texel: u16) -> bool {
        let raster = &self.source.raster;
        let scale = [raster.along_u.index().0, raster.along_v.index().0];
        let [a, b] = [[slopes[0], slopes[1]], [slopes[2], slopes[3]]]
            .map(|side| [side[0].to_f64(), side[1].to_f64()]);
        let squares = [a, b].map(|[x, y]| {
            let (x, y) = (x * scale[0], y * scale[1]);
            x * x + y * y
        });
        if squares[0].max(squares[1]) <= NEAR {
            return true;
        }
        let lengths = squares.map(f64::sqrt);
        let shares = lengths.map(share);
        let counts = [0, 1].map(|k| count(lengths[k] * shares[k]));
        if counts == [1, 1] {
            return true;
        }
        let [u, v] = [u.to_f64(), v.to_f64()];
        let reach = [0, 1].map(|k| 0.5 * (shares[0] * a[k].abs() + shares[1] * b[k].abs()));
        let held = match raster.outline {
            Outline::Square => {
                let beyond = |x: f64, reach: f64| x < reach || x > 1.0 - reach;
                !beyond(u, reach[0]) && !beyond(v, reach[1])
            }
            _ => {
                let (p, q) = ((2.0 * u - 1.0).abs(), (2.0 * v - 1.0).abs());
                let (p, q) = (p + 2.0 * reach[0], q + 2.0 * reach[1]);
                p * p + q * q < 1.0
            }
        };
        if !held || counts[0] * counts[1] > MOST {
            return false;
        }
        let step = [0, 1].map(|k| shares[k] / counts[k] as f64);
        let across = a.map(|x| x * step[0]);
        self.next.begin(texel, 1.0);
        let mut t = 0.5 * (step[1] - shares[1]);
        for _ in 0..counts[1] {
            let s = 0.5 * (step[0] - shares[0]);
            let first = [0, 1].map(|k| [u, v][k] + t * b[k] + s * a[k]);
            self.row(false, (texel, 1.0), counts[0], (first, across, face));
            t += step[1];
        }
        true
    }

    /// Looks a row of at most [`MOST`] places up for a texel, sooner or later. They lie in the target or in the source.
    #[inline(always)]
    fn row(
        &mut self,
        in_target: bool,
        (texel, weight): (u16, f64),
        count: usize,
        ([mut u, mut v], [du, dv], face): ([f64; 2], [f64; 2], R),
    ) {
        if self.next.count + count > TILE {
            self.look(in_target);
            self.next.begin(texel, weight);
        }
        let own = self.next.count..self.next.count + count;
        self.next.count = own.end;
        let Tile([us, vs, faces]) = self.lookups.tile();
        faces[own.clone()].fill(face);
        for (at_u, at_v) in us[own.clone()].iter_mut().zip(&mut vs[own]) {
            (*at_u, *at_v) = (R::new(u), R::new(v));
            u += du;
            v += dv;
        }
    }

    /// Writes the texels of the last block into its band.
    pub fn write(&mut self, band: &mut [T]) {
        for (at, value) in self.done.drain(..) {
            band[at] = value;
        }
    }

    /// Takes the last parts: halves them, or looks up places in them. Whole texels that need one place are left alone.
    fn divide(&mut self, whole: bool) {
        let first = self.parts.len().saturating_sub(TILE);
        let mut taken = [(Part::default(), 0); TILE];
        let n = self.parts.len() - first;
        taken[..n].copy_from_slice(&self.parts[first..]);
        self.parts.truncate(first);
        let mut parts = [Part::default(); TILE];
        for (part, (taken, _)) in parts.iter_mut().zip(&taken[..n]) {
            *part = *taken;
        }
        let mut footprints = [Footprint::default(); TILE];
        measure(
            &self.coordinate_map,
            &self.source.raster,
            &parts[..n],
            &mut footprints,
        );
        for (&(part, texel), footprint) in taken[..n].iter().zip(&footprints) {
            self.one(part, texel, footprint, whole);
        }
    }

    fn one(&mut self, mut part: Part, texel: u16, footprint: &Footprint, whole: bool) {
        let lengths = footprint.lengths();
        let counts = if whole {
            let shares = lengths.map(share);
            let counts = [0, 1].map(|k| count(lengths[k].min(1e9) * shares[k]));
            if counts == [1, 1] {
                return;
            }
            // A part of no width would have no weight beside those above and below it.
            part.size = [0, 1].map(|k| part.size[k] * shares[k].max(NARROW));
            counts
        } else {
            lengths.map(count)
        };
        let [a, b] = footprint.angles;
        let several = counts[0] * counts[1] > 1;
        let wide = several && a.max(b) > WIDEST;
        let many = counts[0] * counts[1] > MOST;
        // Only what halving makes smaller is halved: at a singular place a side is infinite, however short it is.
        let divides =
            [0, 1].map(|k| footprint.angles[k] > 0.5 * footprint.texel && part.size[k] > SHORTEST);
        if (wide || many) && (divides[0] || divides[1]) {
            let second = if many { counts[1] > counts[0] } else { b > a };
            let axis = usize::from(divides[1] && (second || !divides[0]));
            part.size[axis] *= 0.5;
            for step in [-0.5, 0.5] {
                let mut half = part;
                half.uv[axis] += step * part.size[axis];
                self.parts.push((half, texel));
            }
            return;
        }
        let weight = footprint.solid_angle / (counts[0] * counts[1]) as f64;
        let step = [0, 1].map(|k| part.size[k] / counts[k] as f64);
        let face = R::new(part.uv[2]);
        self.next.begin(texel, weight);
        let [u, mut v] = [0, 1].map(|k| part.uv[k] + 0.5 * (step[k] - part.size[k]));
        for _ in 0..counts[1] {
            let places = ([u, v], [step[0], 0.0], face);
            self.row(true, (texel, weight), counts[0], places);
            v += step[1];
        }
    }

    /// Looks the samples up, whose places are in the target or in the source, and adds the values of those before.
    fn look(&mut self, in_target: bool) {
        let n = self.next.count;
        if n == 0 {
            self.next.length = 0;
            return;
        }
        let uv = self.lookups.tile();
        if in_target {
            self.coordinate_map.take(uv, n);
        }
        for (seen, u) in self.next.seen.iter_mut().zip(&uv.0[0][..n]) {
            *seen = !u.is_nan();
        }
        let next = 1 - self.current;
        let area = Rectangle {
            start: next * TILE,
            columns: TILE,
            stride: TILE,
        };
        self.lookups.place(n);
        self.lookups.push(&mut self.values, area);
        self.collect();
        std::mem::swap(&mut self.owners[next], &mut self.next);
        (self.next.count, self.next.length) = (0, 0);
        self.current = next;
    }

    /// Adds the values that are there to their texels.
    fn collect(&mut self) {
        vectorize(
            #[inline(always)]
            || match self.channels {
                1 => self.add::<1>(),
                3 => self.add::<3>(),
                4 => self.add::<4>(),
                _ => self.add::<0>(),
            },
        );
    }

    #[inline(always)]
    fn add<const CHANNELS: usize>(&mut self) {
        let channels = if CHANNELS > 0 {
            CHANNELS
        } else {
            self.channels
        };
        let owners = &mut self.owners[self.current];
        let values = &self.values[self.current * TILE * channels..][..TILE * channels];
        let runs = &owners.runs[..owners.length];
        for (k, run) in runs.iter().enumerate() {
            let end = runs
                .get(k + 1)
                .map_or(owners.count, |run| usize::from(run.first));
            let own = usize::from(run.first)..end;
            let seen = &owners.seen[own.clone()];
            let values = &values[own.start * channels..own.end * channels];
            self.sums.add::<_, CHANNELS>(*run, channels, values, seen);
        }
        (owners.count, owners.length) = (0, 0);
    }
}

/// Which part of a side of r source texels places are spread over.
fn share(r: f64) -> f64 {
    if r > 1.0 {
        let spread = (2.0 * (r * r - 1.0)).sqrt() / r;
        if spread < 1.0 { spread } else { 1.0 }
    } else {
        0.0
    }
}

/// How many places divide a length in source texels.
fn count(length: f64) -> usize {
    // `as` takes negative numbers to 0.
    ((length - SLACK).min(MOST as f64).ceil() as usize).max(1)
}

/// Whether any two neighbors of a block lie far apart in the source, or may.
fn coarse<R: Scalar>(source: &Raster, Tile([u, v, face]): &Tile<R, 3>, block: &Block) -> bool {
    let (columns, rows) = (block.columns, block.rows);
    if columns < 2 || rows < 2 {
        return true;
    }
    let scale = [source.along_u.index().0, source.along_v.index().0].map(R::new);
    let near = R::new(NEAR);
    let apart = |a: usize, b: usize| {
        let (x, y) = ((u[a] - u[b]) * scale[0], (v[a] - v[b]) * scale[1]);
        let together = (x * x + y * y <= near) & (face[a] == face[b]);
        !(together | (u[a].is_nan() & u[b].is_nan()))
    };
    let count = (columns * rows).min(TILE);
    vectorize(
        #[inline(always)]
        || {
            let mut any = false;
            for k in columns..count {
                any |= apart(k - columns, k);
            }
            for row in 0..rows {
                for k in row * columns + 1..((row + 1) * columns).min(count) {
                    any |= apart(k - 1, k);
                }
            }
            any
        },
    )
}
