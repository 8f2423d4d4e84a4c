//! Conversion to fewer texels: the source is averaged over what each target texel sees.
//!
//! A texel whose sides cross r > 1 source texels is looked up at several places, one for about every source texel that it
//! covers, spread evenly over it; their mean, by solid angle, is the texel. The work is bounded by the source's size, for
//! every source texel is looked up about once, and no smaller copies of the source are made. Each lookup is a
//! lookup: every filter and every seam is as right here as elsewhere.
//!
//! - The choice is each texel's own, and each side's: the poles of a latlong are finer than its equator. Which texels
//!   need more than one lookup follows from the maps' Jacobians (`footprint`); blocks of the target in which no
//!   neighbours lie far apart in the source are not looked at.
//! - Places are spread over min(r, √(2(r² - 1))) source texels: from nothing at r = 1, where one lookup
//!   already is as wide as a texel, to the whole side from r = √2 on. So nothing jumps where the target turns from finer
//!   to coarser.
//! - A texel that covers much is halved, again and again, until one Jacobian describes each part: a part has at
//!   most [`MOST`] places and spans at most [`WIDEST`]. Near a pole halving ends with the rows.
//! - What the source does not hold has no part in a mean. A texel whose own centre sees nothing is `fill`, as without.
//!
//! A lone sun of one texel keeps its energy within 9 % (r near 1.4), 1 % from r = 4 on: places and texels beat against each
//! other. `filter="area"` keeps it exactly.
//!
//! What did not help: a mip chain. It costs a copy, and a lookup in it is as wide as a coarse texel is long: twice
//! the error of these means.

use crate::footprint::{Footprint, Part, measure};
use crate::image::{Block, Centres, Raster, Texel};
use crate::kernel::{Scalar, vectorize};
use crate::real::Real;
use crate::route::Route;
use crate::sample::{Area, Filter, Lookups, Source};
use crate::tile::{TILE, Tile};

/// The most places in a part of a texel.
const MOST: usize = 64;

/// The widest part of a texel of several places, in radians: over it a map's density is taken as constant.
const WIDEST: f64 = 0.035;

/// Places are spread over this share of a side at least: over nothing that could be seen.
const NARROW: f64 = 1e-3;

/// Sides are not halved below this, in u or v.
const SHORTEST: f64 = 1e-6;

/// A side is divided so that places lie at most this much more than a source texel apart: rounding at whole
/// numbers must not double the work.
const SLACK: f64 = 0.15;

/// Neighbours nearer than this, squared and in source texels, belong to texels of one lookup: below the 1.66
/// at which a side gets a second one.
const NEAR: f64 = 1.5;

/// Averages for the texels of a band of the target.
pub struct Antialias<'s, 'a, T: Texel, R> {
    source: &'s Source<'a, T>,
    target: &'s Raster,
    route: Route<'s>,
    channels: usize,
    lookups: Lookups<'s, 'a, T, T::Float, R>,
    parts: Vec<(Part, u16)>,
    /// Of the samples that are being put together.
    next: Owners,
    /// Of those that are being looked up, and of those whose values are there.
    owners: [Owners; 2],
    values: Vec<T::Float>,
    current: usize,
    sums: Sums,
    done: Vec<(usize, T)>,
}

/// Which texel a sample belongs to, and how much it counts.
#[derive(Clone, Copy)]
struct Owners {
    texel: [u16; TILE],
    weight: [f64; TILE],
    count: usize,
}

impl Owners {
    const NONE: Owners = Owners {
        texel: [0; TILE],
        weight: [0.0; TILE],
        count: 0,
    };
}

/// Sums for the texels of a block. Differences from a texel's first value are added, so that a constant stays
/// constant to the bit.
struct Sums {
    weights: [f64; TILE],
    first: Vec<f64>,
    sums: Vec<f64>,
}

impl Sums {
    fn add<F: Real>(&mut self, texel: usize, weight: f64, values: &[F]) {
        let channels = values.len();
        let own = texel * channels..(texel + 1) * channels;
        let (first, sums) = (&mut self.first[own.clone()], &mut self.sums[own]);
        if self.weights[texel] == 0.0 {
            for (first, value) in first.iter_mut().zip(values) {
                *first = value.to_f64();
            }
            sums.fill(0.0);
        }
        self.weights[texel] += weight;
        for ((sum, first), value) in sums.iter_mut().zip(first).zip(values) {
            *sum += weight * (value.to_f64() - *first);
        }
    }
}

impl<'s, 'a, T: Texel, R: Scalar> Antialias<'s, 'a, T, R> {
    /// For a target of a source. `nothing` has a number for each channel.
    pub fn new(
        source: &'s Source<'a, T>,
        target: &'s Raster,
        route: Route<'s>,
        filter: Filter,
        nothing: &'s [T::Float],
    ) -> Self {
        let channels = nothing.len();
        Antialias {
            source,
            target,
            route,
            channels,
            lookups: Lookups::new(source, filter, nothing),
            parts: Vec::new(),
            next: Owners::NONE,
            owners: [Owners::NONE; 2],
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

    /// Averages those texels of a block that need it: `places` are where they lie in the source.
    /// [`Antialias::write`] puts them where they belong.
    pub fn block(&mut self, centres: &Centres<R>, block: &Block, places: &Tile<R, 3>, area: Area) {
        if !coarse(self.source.raster(), places, block) {
            return;
        }
        let n = block.columns * block.rows;
        let mut uv = Tile::new();
        centres.of(block, &mut uv);
        for k in 0..n {
            let part = Part::of_texel(self.target, uv.at(k).map(Real::to_f64));
            self.parts.push((part, k as u16));
        }
        self.sums.weights = [0.0; TILE];
        let mut whole = true;
        while !self.parts.is_empty() {
            self.divide(whole);
            whole = false;
        }
        self.look();
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
            &self.route,
            self.source.raster(),
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
        let place = |k: usize, i: usize| {
            R::new(part.uv[k] + (i as f64 + 0.5 - 0.5 * counts[k] as f64) * step[k])
        };
        for j in 0..counts[1] {
            for i in 0..counts[0] {
                let owners = &mut self.next;
                let n = owners.count;
                let uv = [place(0, i), place(1, j), R::new(part.uv[2])];
                self.lookups.tile().set(n, uv);
                owners.texel[n] = texel;
                owners.weight[n] = weight;
                owners.count = n + 1;
                if n + 1 == TILE {
                    self.look();
                }
            }
        }
    }

    /// Looks the samples up, and adds the values of those before.
    fn look(&mut self) {
        let n = self.next.count;
        if n == 0 {
            return;
        }
        let uv = self.lookups.tile();
        self.route.take(uv, n);
        for (weight, u) in self.next.weight.iter_mut().zip(&uv.0[0][..n]) {
            if u.is_nan() {
                *weight = 0.0;
            }
        }
        let next = 1 - self.current;
        let area = Area {
            start: next * TILE,
            columns: TILE,
            stride: TILE,
        };
        self.lookups.place(n);
        self.lookups.push(&mut self.values, area);
        self.collect();
        self.owners[next] = self.next;
        self.next.count = 0;
        self.current = next;
    }

    /// Adds the values that are there to their texels.
    fn collect(&mut self) {
        let owners = &mut self.owners[self.current];
        let values = &self.values[self.current * TILE * self.channels..];
        let values = values.chunks_exact(self.channels);
        for (k, values) in values.take(owners.count).enumerate() {
            if owners.weight[k] > 0.0 {
                let texel = owners.texel[k] as usize;
                self.sums.add(texel, owners.weight[k], values);
            }
        }
        owners.count = 0;
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

/// Whether any two neighbours of a block lie far apart in the source, or may.
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
