//! Conversion to fewer texels: the source is averaged over what each target texel sees.
//!
//! A texel whose sides cross r > 1 source texels is looked up at several places, one for about every source texel that it
//! covers, spread evenly over it; their mean, by solid angle, is the texel. The work is bounded by the source's size, for
//! every source texel is looked up about once, and no smaller copies of the source are made. Each lookup is a
//! lookup: every filter and every seam is as right here as elsewhere.
//!
//! - The choice is each texel's own, and each side's: the poles of a latlong are finer than its equator. Which texels
//!   need more than one lookup follows from the maps' Jacobians (`footprint`); texels whose neighbors are not far apart in the
//!   source are not looked at.
//! - Slivers, as near poles, take places along a line (`spread`).
//! - Places are spread over min(r, √(2(r² - 1))) source texels, so that nothing jumps where the target turns from finer to
//!   coarser.
//! - Where a polynomial stands for a block's coordinates (`patch`), its derivatives are the Jacobian and the bend of it, and a texel
//!   is a parallelogram in the source, bent a little and of one density, if it is small.
//! - A texel that covers much is halved, again and again, until one Jacobian describes each part: a part has at
//!   most [`MOST`] places and spans at most [`WIDEST`]. Near a pole halving ends with the rows.
//! - What the source does not hold has no part in a mean. A texel whose own center sees nothing is `fill`, as without.
//!
//! A lone sun of one texel keeps its energy within 9 % (r near 1.4), 1 % from r = 4 on: places and texels beat against each
//! other. `filter="area"` keeps it exactly.
//!
//! What did not help: a mip chain. It costs a copy, and a lookup in it is as wide as a coarse texel is long: twice
//! the error of these means.

mod accounts;
mod coarse;

use crate::image::raster::{Block, Raster};
use crate::image::texel::Texel;
use crate::image::texels::Centers;
use crate::kernel::tile::{TILE, Tile};
use crate::kernel::{Scalar, vectorize};
use crate::number::real::Real;
use crate::resample::coordinate_map::CoordinateMap;
use crate::resample::filters::LookupFilter;
use crate::resample::footprint::{Footprint, Measuring, Part, measure};
use crate::resample::polynomial::{CoordinatePolynomial, RUN};
use crate::resample::sample::{
    LANES, Lookups, MOST, Parallelograms, Rectangle, Rooms, Runs, SEVERAL, Sight, Spread, TOGETHER,
    Texture, any_several, count, division,
};
use accounts::{Owners, Sums};
use coarse::coarse;
use std::cell::LazyCell;

/// The widest part of a texel of several places, in radians: over it a map's density is taken as constant.
const WIDEST: f64 = 0.035;

/// The widest in the source, as a share of it: near a pole, which way along it lies changes within a texel.
const STRAIGHT: f64 = 1.0 / 32.0;

/// Places are spread over this share of a side at least: over nothing that could be seen.
const NARROW: f64 = 1e-3;

/// By how many source texels a texel may differ from a bent parallelogram that is taken for it: as little as f32
/// coordinates are off.
const BEND: f64 = 1.0 / 350.0;

/// Terms of third order, of a texel that reaches one source texel from its center, with which those of a run are as good as of one shape.
/// Slopes of 16 texels are k²/2 of a third derivative u‴ from those in the middle, and from a line through the nodes at most 17.5 u‴; places are
/// moved by up to half of that. A texel's own term of third order is u‴/48, so this is a share of 1/32.
const ALIKE: f64 = 1.0 / 32.0 / 8.75 / 48.0;

/// Sides are not halved below this, in u or v.
const SHORTEST: f64 = 1e-6;

/// Averages for the texels of a band of the target.
pub(crate) struct Antialias<'s, 'a, T: Texel, R> {
    source: &'s Texture<'a, T>,
    target: &'s Raster,
    coordinate_map: CoordinateMap<'s>,
    channels: usize,
    filter: LookupFilter,
    lookups: Lookups<'s, 'a, T, T::Float, R>,
    parts: Vec<(Part, u16)>,
    taken: Taken,
    measuring: Box<Measuring>,
    /// Of the samples that are being put together.
    next: Owners,
    /// Of those that are being looked up, and of those whose values are there.
    owners: [Owners; 2],
    /// The present patch.
    patch: Option<Block>,
    /// What its texels are in the source; none where nobody asked yet.
    form: Option<Form>,
    /// Whether those that follow each other in a row have nearly one shape.
    alike: bool,
    /// Second derivatives of its coordinates; zeros where they do not matter.
    bends: Tile<R, 6>,
    /// Its slopes at the nodes of runs, and the second derivatives down; zeros where they do not matter.
    nodes: Box<(Tile<R, 4>, Tile<R, 2>)>,
    values: Vec<T::Float>,
    current: usize,
    sums: Sums,
    done: Done,
    /// The means, texel by texel of the block.
    means: Vec<T>,
    seen: Box<Parallelograms>,
    runs: Box<Runs>,
    rooms: Box<Rooms<T::Float>>,
}

/// Parts that are looked at, what they are by themselves, and what they see.
#[derive(Default)]
struct Taken {
    of: Vec<(Part, u16)>,
    parts: Vec<Part>,
    footprints: Vec<Footprint>,
}

/// Texels of the last block whose means are there.
struct Done {
    texels: [bool; TILE],
    /// How many there are.
    count: usize,
    /// Where the block is in its band, and how many texels it has.
    area: Rectangle,
    length: usize,
}

impl Done {
    const NONE: Done = Done {
        texels: [false; TILE],
        count: 0,
        area: Rectangle {
            start: 0,
            columns: 1,
            stride: 1,
        },
        length: 0,
    };

    /// None of a block.
    fn of(area: Rectangle, block: &Block) -> Done {
        Done {
            area,
            length: block.columns * block.rows,
            ..Done::NONE
        }
    }

    fn put(&mut self, texel: usize) {
        self.texels[texel] = true;
        self.count += 1;
    }
}

/// What the texels of a patch are in the source.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Form {
    /// Too small for several lookups.
    Single,
    Parallelograms,
    /// Whose sides are parabolas.
    Bent,
    Other,
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
            filter,
            lookups: Lookups::new(source, filter, nothing),
            parts: Vec::new(),
            taken: Taken::default(),
            measuring: Measuring::new(),
            next: Owners::NONE,
            owners: [Owners::NONE; 2],
            patch: None,
            form: None,
            alike: false,
            bends: Tile::new(),
            nodes: Box::new((Tile::new(), Tile::new())),
            values: vec![T::Float::default(); 2 * TILE * channels],
            current: 0,
            sums: Sums {
                weights: [0.0; TILE],
                first: vec![0.0; TILE * channels],
                sums: vec![0.0; TILE * channels],
            },
            done: Done::NONE,
            means: vec![T::default(); TILE * channels],
            seen: Box::new(Parallelograms::new()),
            runs: Box::new(Runs::new()),
            rooms: Box::new(Rooms::new()),
        }
    }

    /// What follows are blocks of another patch.
    pub fn next_patch(&mut self, whole: &Block) {
        self.patch = Some(*whole);
        if self.form.take() == Some(Form::Bent) {
            self.bends = Tile::new();
            self.nodes.1 = Tile::new();
        }
    }

    /// Whether means wait to be written.
    pub fn waits(&self) -> bool {
        self.done.length > 0
    }

    /// Averages those runs of a block that see several texels inside of a face: arguments are those of [`Antialias::block`], which does the
    /// rest where these are not all.
    pub fn inside(
        &mut self,
        block: &Block,
        places: &Tile<R, 3>,
        (patch, row): (&CoordinatePolynomial<R>, usize),
        area: Rectangle,
    ) -> Sight {
        let form = self.form(patch);
        if form == Form::Single {
            return Sight::Single;
        }
        if form == Form::Other || !self.alike {
            return Sight::Other;
        }
        let (slopes, down) = &mut *self.nodes;
        patch.slopes_at_nodes(row, block, slopes);
        if form == Form::Bent {
            patch.bends_at_nodes(row, block, down);
        }
        let face = places.0[2][0].whole() as usize;
        let sight = self.runs.set(
            (&self.source.raster, face, self.filter),
            [block.columns, block.rows],
            places,
            (slopes, down),
        );
        if !self.runs.any_inside() {
            return sight;
        }
        let source = (self.source, self.filter);
        let rooms = (face, &mut *self.rooms);
        self.done = Done::of(area, block);
        let done = &mut self.done;
        done.count = (self.runs).means(source, rooms, &mut done.texels, &mut self.means);
        if done.count == 0 {
            done.length = 0;
            return Sight::Other;
        }
        sight
    }

    /// Averages those texels of a block that need it: `places` are where they lie in the source, and `patch` is where
    /// these come from, with the number of the block's first row in it. [`Antialias::write`] puts the means where they belong.
    /// Returns whether these are all of its texels.
    pub fn block(
        &mut self,
        centers: &Centers<R>,
        block: &Block,
        places: &Tile<R, 3>,
        patch: Option<(&CoordinatePolynomial<R>, usize)>,
        area: Rectangle,
    ) -> bool {
        let mut apart = [false; TILE];
        let begun = self.waits();
        if !coarse(&self.source.raster, places, block, &mut apart) && !begun {
            return false;
        }
        let n = block.columns * block.rows;
        let uv = LazyCell::new(|| {
            let mut uv = Tile::new();
            centers.of(block, &mut uv);
            uv
        });
        self.sums.weights = [0.0; TILE];
        let patch = patch.filter(|(patch, _)| self.form(patch) != Form::Other);
        if !begun {
            self.done = Done::of(area, block);
        }
        if let Some((patch, row)) = patch {
            let mut slopes = Tile::new();
            patch.slopes(row, block, &mut slopes);
            if !begun && !any_several(&self.source.raster, &slopes, n) {
                return false;
            }
            if self.form == Some(Form::Bent) {
                patch.bends(row, block, &mut self.bends);
            }
            self.parallelograms(places, &slopes, n, || &uv);
        } else {
            for k in (0..n).filter(|&k| apart[k] && !places.0[0][k].is_nan()) {
                if !self.done.texels[k] {
                    self.part(&uv, k);
                }
            }
        }
        if self.done.count == n {
            return true;
        }
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
                self.done.put(k);
                for c in k * self.channels..(k + 1) * self.channels {
                    let value = self.sums.first[c] + self.sums.sums[c] / weight;
                    self.means[c] = T::store(<T::Float as Real>::new(value));
                }
            }
        }
        self.done.count == n
    }

    /// What texels of the present patch are as good as in the source, if they need no weights by solid angle.
    fn form(&mut self, polynomial: &CoordinatePolynomial<R>) -> Form {
        if let Some(form) = self.form {
            return form;
        }
        let form = self.form_of(polynomial);
        self.form = Some(form);
        form
    }

    fn form_of(&mut self, polynomial: &CoordinatePolynomial<R>) -> Form {
        let raster = &self.source.raster;
        let scale = [raster.along_u.index().0, raster.along_v.index().0];
        let sides = polynomial.longest_sides(scale);
        if sides
            .iter()
            .all(|[x, y]| x * x + y * y <= f64::from(SEVERAL))
        {
            return Form::Single;
        }
        let halves = self.target.along_u.on_edges() || self.target.along_v.on_edges();
        let Some(patch) = self.patch.filter(|_| !halves) else {
            return Form::Other;
        };
        if !self.narrow(&patch) {
            return Form::Other;
        }
        let third = polynomial.beyond(3, scale);
        let [reach_u, reach_v] = [0, 1].map(|axis| 0.5 * (sides[0][axis] + sides[1][axis]));
        self.alike = patch.columns >= RUN && third <= ALIKE * reach_u.max(reach_v).max(1.0);
        if polynomial.beyond(2, scale) <= BEND {
            Form::Parallelograms
        } else if third <= BEND {
            Form::Bent
        } else {
            Form::Other
        }
    }

    /// Whether the texels of a patch are of one density, by those at its corners, at the middles of its sides and in its middle.
    fn narrow(&mut self, patch: &Block) -> bool {
        let Some((face, first, [right, down])) = patch.face else {
            return false;
        };
        let along = [self.target.along_u, self.target.along_v];
        let parts: [Part; 9] = std::array::from_fn(|k| {
            let at = |step: usize, n: usize| (step * (n - 1) / 2) as isize;
            let (column, row) = (at(k % 3, patch.columns), at(k / 3, patch.rows));
            let [u, v] = [0, 1].map(|axis| {
                let texel = first[axis] + column * right[axis] + row * down[axis];
                along[axis].center(texel as f64)
            });
            Part::of_texel(self.target, [u, v, face as f64])
        });
        let mut footprints = [Footprint::default(); 9];
        let way = (&self.coordinate_map, &mut *self.measuring);
        measure(way, &self.source.raster, &parts, &mut footprints);
        let mut angles = footprints.iter().flat_map(|footprint| footprint.angles);
        angles.all(|angle| angle <= WIDEST)
    }

    /// Averages over texels that are parallelograms about places of the source, by their `slopes`; what is in the way of one is left
    /// for later.
    fn parallelograms<'u>(
        &mut self,
        places: &Tile<R, 3>,
        slopes: &Tile<R, 4>,
        n: usize,
        uv: impl Fn() -> &'u Tile<R, 3>,
    ) {
        let face = places.0[2][0].whole() as usize;
        for first in (0..n).step_by(TOGETHER) {
            let count = TOGETHER.min(n - first);
            let raster = &self.source.raster;
            let own = (places, first);
            let of = (raster, face, self.filter);
            self.seen.set(of, own, (slopes, &self.bends));
            let done = &mut self.done.texels[first..first + count];
            let means_of = &mut self.means[first * self.channels..];
            let source = (self.source, self.filter);
            let rooms = (face, &mut *self.rooms);
            let found = self.seen.means(source, rooms, done, means_of);
            self.done.count += found;
            if found == count {
                continue;
            }
            for seen in 0..count {
                let k = first + seen;
                if !self.done.texels[k]
                    && self.seen.several(seen)
                    && !self.near(places.at(k), seen, k as u16)
                {
                    self.part(uv(), k);
                }
            }
        }
    }

    /// Takes a whole texel for later.
    fn part(&mut self, uv: &Tile<R, 3>, k: usize) {
        let part = Part::of_texel(self.target, uv.at(k).map(Scalar::to_f64));
        self.parts.push((part, k as u16));
    }

    /// Looks up places in a texel that is a parallelogram about a place of the source. False where something is in the way.
    fn near(&mut self, [u, v, face]: [R; 3], seen: usize, texel: u16) -> bool {
        let raster = &self.source.raster;
        let seen = self.seen.at(seen);
        let scale = [raster.along_u.index().0, raster.along_v.index().0];
        let [u, v] = [u.to_f64(), v.to_f64()];
        let reach = [0, 1].map(|k| f64::from(seen.reach()[k]) / scale[k]);
        let beyond = |x: f64, reach: f64| x < reach || x > 1.0 - reach;
        let held =
            !beyond(u, reach[0]) && !beyond(v, reach[1]) && raster.holds_around([u, v], reach);
        if !held || seen.spread.count() > MOST {
            return false;
        }
        self.next.begin(texel, 1.0);
        self.look_up(false, (texel, 1.0), &seen.spread, face, |s, t| {
            let [x, y] = seen.at(s, t);
            [u + x / scale[0], v + y / scale[1]]
        });
        true
    }

    /// Looks all places of a spread up for a texel, sooner or later. They lie in the target or in the source.
    #[inline(always)]
    fn look_up(
        &mut self,
        in_target: bool,
        (texel, weight): (u16, f64),
        spread: &Spread,
        face: R,
        place: impl Fn(f32, f32) -> [f64; 2],
    ) {
        let total = spread.count();
        for first in (0..total).step_by(LANES) {
            let (mut s, mut t) = ([0.0; LANES], [0.0; LANES]);
            vectorize(
                #[inline(always)]
                || spread.places(first, &mut s, &mut t),
            );
            let count = LANES.min(total - first);
            if self.next.count + count > TILE {
                self.look(in_target);
                self.next.begin(texel, weight);
            }
            let own = self.next.count..self.next.count + count;
            self.next.count = own.end;
            let Tile([us, vs, faces]) = self.lookups.tile();
            faces[own.clone()].fill(face);
            let places = us[own.clone()].iter_mut().zip(&mut vs[own]);
            for ((at_u, at_v), (s, t)) in places.zip(s.into_iter().zip(t)) {
                let [u, v] = place(s, t);
                (*at_u, *at_v) = (R::new(u), R::new(v));
            }
        }
    }

    /// Writes the texels of the last block into its band.
    pub fn write(&mut self, band: &mut [T]) {
        match self.channels {
            1 => self.write_of::<1>(band),
            3 => self.write_of::<3>(band),
            4 => self.write_of::<4>(band),
            _ => self.write_of::<0>(band),
        }
        self.done.length = 0;
    }

    /// CHANNELS is 0 where their number is known at run time only: a copy of a length that is known here is no call.
    fn write_of<const CHANNELS: usize>(&self, band: &mut [T]) {
        let n = if CHANNELS > 0 {
            CHANNELS
        } else {
            self.channels
        };
        let Done { area, length, .. } = self.done;
        for first in (0..length).step_by(area.columns) {
            let columns = area.columns.min(length - first);
            let done = &self.done.texels[first..first + columns];
            let means = &self.means[first * n..][..columns * n];
            let start = area.start + first / area.columns * area.stride;
            let row = &mut band[start * n..][..columns * n];
            if done.iter().all(|done| *done) {
                vectorize(
                    #[inline(always)]
                    || {
                        // Of a length that is known here: for a few hundred bytes a call is as long as the copy.
                        let whole = if CHANNELS > 0 { RUN * CHANNELS } else { 64 };
                        let into = row.chunks_exact_mut(whole);
                        for (into, means) in into.zip(means.chunks_exact(whole)) {
                            into.copy_from_slice(means);
                        }
                        let rest = row.len() / whole * whole;
                        row[rest..].copy_from_slice(&means[rest..]);
                    },
                );
                continue;
            }
            let texels = row.chunks_exact_mut(n).zip(means.chunks_exact(n));
            for ((into, mean), _) in texels.zip(done).filter(|(_, done)| **done) {
                into.copy_from_slice(mean);
            }
        }
    }

    /// Takes the last parts: halves them, or looks up places in them. Whole texels that need one place are left alone.
    fn divide(&mut self, whole: bool) {
        let first = self.parts.len().saturating_sub(TILE);
        // Taken over, so that what comes of them is added behind the others.
        let mut taken = std::mem::take(&mut self.taken);
        taken.of.clear();
        taken.of.extend(self.parts.drain(first..));
        taken.parts.clear();
        taken.parts.extend(taken.of.iter().map(|(part, _)| *part));
        taken
            .footprints
            .resize(taken.of.len(), Footprint::default());
        let way = (&self.coordinate_map, &mut *self.measuring);
        measure(
            way,
            &self.source.raster,
            &taken.parts,
            &mut taken.footprints,
        );
        for (&(part, texel), footprint) in taken.of.iter().zip(&taken.footprints) {
            self.one(part, texel, footprint, whole);
        }
        self.taken = taken;
    }

    fn one(&mut self, mut part: Part, texel: u16, footprint: &Footprint, whole: bool) {
        let lengths = footprint.lengths();
        let mut sides = footprint.sides;
        let counts = if whole {
            let divisions = lengths.map(division);
            let shares = divisions.map(|(share, _)| share);
            let counts = divisions.map(|(_, count)| count);
            if counts == [1.0, 1.0] {
                return;
            }
            for k in [0, 1] {
                sides[k] = sides[k].map(|x| x * shares[k]);
                // A part of no width would have no weight beside those above and below it.
                part.size[k] *= shares[k].max(NARROW);
            }
            counts
        } else {
            lengths.map(count)
        };
        let single = |side: [f64; 2]| side.map(|x| x as f32);
        let spread = Spread::new(sides.map(single), single(counts));
        let [a, b] = footprint.angles;
        let raster = &self.source.raster;
        let far = |axis: usize, side: usize| {
            sides[0][axis].abs() + sides[1][axis].abs() > STRAIGHT * side as f64
        };
        let bent = far(0, raster.width) || far(1, raster.height);
        let wide = spread.count() > 1 && (a.max(b) > WIDEST || bent);
        let many = spread.count() > MOST;
        // Only what halving makes smaller is halved: at a singular place a side is infinite, however short it is.
        let divides =
            [0, 1].map(|k| footprint.angles[k] > 0.5 * footprint.texel && part.size[k] > SHORTEST);
        if (wide || many) && (divides[0] || divides[1]) {
            let second = if many || bent {
                counts[1] > counts[0]
            } else {
                b > a
            };
            let axis = usize::from(divides[1] && (second || !divides[0]));
            part.size[axis] *= 0.5;
            for step in [-0.5, 0.5] {
                let mut half = part;
                half.uv[axis] += step * part.size[axis];
                self.parts.push((half, texel));
            }
            return;
        }
        let weight = footprint.solid_angle / spread.count() as f64;
        let face = R::new(part.uv[2]);
        self.next.begin(texel, weight);
        let Part { uv, size } = part;
        self.look_up(true, (texel, weight), &spread, face, |s, t| {
            [
                uv[0] + f64::from(s) * size[0],
                uv[1] + f64::from(t) * size[1],
            ]
        });
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
        let list = &owners.list[..owners.length];
        for (k, owner) in list.iter().enumerate() {
            let end = list
                .get(k + 1)
                .map_or(owners.count, |next| usize::from(next.first));
            let own = usize::from(owner.first)..end;
            let seen = &owners.seen[own.clone()];
            let values = &values[own.start * channels..own.end * channels];
            self.sums.add::<_, CHANNELS>(*owner, channels, values, seen);
        }
        (owners.count, owners.length) = (0, 0);
    }
}
