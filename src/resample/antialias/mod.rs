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
//!   is a parallelogram in the source, bent a little and of one density, if it is small. Of one that covers many texels these are summed up, by how much
//!   of each it covers (`slices`).
//! - A texel that covers much is halved, again and again, until one Jacobian describes each part: a part has at
//!   most [`MOST`](crate::resample::sample::MOST) places and spans at most [`WIDEST`]. Near a pole halving ends with the rows.
//! - Rows of a panorama's texels have densities of their own: beside its poles each place counts as much as it has there. With one weight for a
//!   part, a sun in the first of r rows had r times its light.
//! - What the source does not hold has no part in a mean. A texel whose own center sees nothing is `fill`, as without.
//!
//! A lone sun of one texel keeps its energy within 9 % (r near 1.4), 1 % from r = 4 on, where texels are parallelograms in the source; within
//! 40 % where they are halved, and within a factor of two beside poles of the source: places and texels beat against each other. `filter="area"`
//! keeps it exactly, as images do that become smaller along straight rows, which take that way ([`area`](crate::resample::area)).
//!
//! What did not help: a mip chain. It costs a copy, and a lookup in it is as wide as a coarse texel is long: twice
//! the error of these means.

mod accounts;
mod coarse;
mod divided;

use crate::image::raster::{Block, Raster};
use crate::image::texel::Texel;
use crate::image::texels::Centers;
use crate::kernel::tile::{TILE, Tile};
use crate::kernel::{Scalar, vectorize};
use crate::number::real::Real;
use crate::resample::coordinate_map::CoordinateMap;
use crate::resample::filters::LookupFilter;
use crate::resample::footprint::{Measuring, Part};
use crate::resample::polynomial::{CoordinatePolynomial, RUN};
use crate::resample::sample::{
    LANES, Lookups, Parallelograms, Rectangle, Rooms, Runs, SEVERAL, Sight, TOGETHER, Texture,
    any_several,
};
use accounts::{Owners, Sums};
use coarse::coarse;
use divided::{Divided, Room, WIDEST};
use std::cell::LazyCell;
use std::ops::Range;

/// By how many source texels a texel may differ from a bent parallelogram that is taken for it, as little as f32 coordinates are off; and
/// as a share of how narrow it is, where that is more.
const BEND: f64 = 1.0 / 350.0;

/// By how much densities at both ends of a part, or of a texel that is taken for a parallelogram, may differ, as a share of that in its middle.
const UNEVEN: f64 = 1.0 / 8.0;

/// Terms of third order, of a texel that reaches one source texel from its center, with which those of a run are as good as of one shape.
/// Slopes of 16 texels are k²/2 of a third derivative u‴ from those in the middle, and from a line through the nodes at most 17.5 u‴; places are
/// moved by up to half of that. A texel's own term of third order is u‴/48, so this is a share of 1/32.
const ALIKE: f64 = 1.0 / 32.0 / 8.75 / 48.0;

/// Averages for the texels of a band of the target.
pub(crate) struct Antialias<'s, 'a, T: Texel, R> {
    source: &'s Texture<'a, T>,
    target: &'s Raster,
    coordinate_map: CoordinateMap<'s>,
    /// Of a target whose rows are parallels: what a width of 1 is at the equator, in radians.
    around: Option<f64>,
    channels: usize,
    filter: LookupFilter,
    lookups: Lookups<'s, 'a, T, T::Float, R>,
    parts: Vec<(Part, u16)>,
    measuring: Box<Measuring>,
    divided: Box<Divided>,
    room: Box<Room>,
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
            around: coordinate_map.around(),
            channels,
            filter,
            lookups: Lookups::new(source, filter, nothing),
            parts: Vec::new(),
            measuring: Measuring::new(),
            divided: Divided::new(),
            room: Room::new(),
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

    /// Whether the texels of the present patch are too bent for parallelograms, which those of a part of it need not be.
    pub fn is_bent(&mut self, patch: &CoordinatePolynomial<R>) -> bool {
        !self.halves() && self.form(patch) == Form::Other
    }

    /// Whether texels at the border of the target are halves.
    fn halves(&self) -> bool {
        self.target.along_u.on_edges() || self.target.along_v.on_edges()
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
        let Some(patch) = self.patch.filter(|_| !self.halves()) else {
            return Form::Other;
        };
        if !self.narrow(&patch) {
            return Form::Other;
        }
        let third = polynomial.beyond(3, scale);
        let bend = BEND * polynomial.narrowest(scale).max(1.0);
        let [reach_u, reach_v] = [0, 1].map(|axis| 0.5 * (sides[0][axis] + sides[1][axis]));
        self.alike = patch.columns >= RUN && third <= ALIKE * reach_u.max(reach_v).max(1.0);
        if polynomial.beyond(2, scale) <= bend {
            Form::Parallelograms
        } else if third <= bend {
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
        let parts = (0..9).map(|k| {
            let at = |step: usize, n: usize| (step * (n - 1) / 2) as isize;
            let (column, row) = (at(k % 3, patch.columns), at(k / 3, patch.rows));
            let [u, v] = [0, 1].map(|axis| {
                let texel = first[axis] + column * right[axis] + row * down[axis];
                along[axis].center(texel as f64)
            });
            Part::of_texel(self.target, [u, v, face as f64])
        });
        let n = (self.measuring).measure(&self.coordinate_map, &self.source.raster, parts);
        let [a, b] = self.measuring.angles.0.each_ref().map(|row| &row[..n]);
        let narrow = a.iter().chain(b).all(|angle| *angle <= WIDEST);
        narrow && (self.around.is_none() || self.is_even(patch))
    }

    /// Whether no texel of a patch of parallels has rows of different densities, by what was measured of three rows of it.
    fn is_even(&self, patch: &Block) -> bool {
        let Tile([_, solid_angles]) = &self.measuring.extents;
        let middles = [1, 4, 7].map(|k| solid_angles[k]);
        let least = middles.into_iter().fold(f64::INFINITY, f64::min);
        let change = (middles[2] - middles[0]).abs();
        change <= UNEVEN * least * (patch.rows.max(2) - 1) as f64
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
                if !self.done.texels[k] && self.seen.several(seen) {
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
        let mut texels = [0; TILE];
        for (texel, (_, own)) in texels.iter_mut().zip(&self.parts[first..]) {
            *texel = *own;
        }
        let raster = &self.source.raster;
        let parts = self.parts.drain(first..).map(|(part, _)| part);
        let n = (self.measuring).measure(&self.coordinate_map, raster, parts);
        let measured = &*self.measuring;
        if whole {
            self.divided.set::<true>(measured, n, raster);
        } else {
            self.divided.set::<false>(measured, n, raster);
        }
        let parts = &mut self.parts;
        let placed = (self.divided).halves((measured, n), |k, uv, size| {
            parts.push((Part { uv, size }, texels[k]));
        });
        self.place(&texels, placed);
    }

    /// Puts all places of so many parts where they are looked up, sooner or later.
    fn place(&mut self, texels: &[u16; TILE], placed: usize) {
        let mut first = 0;
        while first < placed {
            let (part, places) = self.divided.placed(first);
            if places >= LANES {
                self.place_many((texels[part], part), places);
                first += 1;
            } else {
                first = self.place_few(texels, first..placed);
            }
        }
    }

    /// Those of a part of a texel: so many that one part fills the lanes.
    fn place_many(&mut self, (texel, part): (u16, usize), places: usize) {
        let weight = self.weight(part);
        let spread = self.divided.spread(part);
        self.next.begin(texel, weight);
        for first in (0..places).step_by(LANES) {
            let count = LANES.min(places - first);
            if self.next.count + count > TILE {
                self.look();
                self.next.begin(texel, weight);
            }
            let measured = &*self.measuring;
            (self.divided).places_of(measured, (part, &spread), first, &mut self.room);
            let (room, into) = self.take(part, count);
            room.write(into);
        }
    }

    /// Those of the next parts: of as many as there are lanes, until one has many. Returns the number after these.
    fn place_few(&mut self, texels: &[u16; TILE], numbers: Range<usize>) -> usize {
        let most = numbers.len().min(LANES);
        let few = |number: &usize| self.divided.placed(*number).1 < LANES;
        let end = numbers.start + numbers.clone().take(most).take_while(few).count();
        let own = numbers.start..end;
        (self.divided).places(&self.measuring, own.clone(), &mut self.room);
        for (lane, number) in own.enumerate() {
            let (part, places) = self.divided.placed(number);
            if self.next.count + places > TILE {
                self.look();
            }
            let weight = self.weight(part);
            self.next.begin(texels[part], weight);
            let (room, into) = self.take(part, places);
            room.write_lane(lane, into);
        }
        end
    }

    /// Takes the next places for so many of a part. Returns what was found, and where u and v are to be written.
    fn take(&mut self, part: usize, count: usize) -> (&Room, [&mut [R]; 2]) {
        let own = self.next.count..self.next.count + count;
        self.next.count = own.end;
        let [from, _] = self.measuring.centers();
        let Tile([us, vs, faces]) = self.lookups.tile();
        faces[own.clone()].fill(R::new(from.0[2][part]));
        (&self.room, [&mut us[own.clone()], &mut vs[own]])
    }

    /// How much each place of a part counts, and whether that is times the density there.
    fn weight(&self, part: usize) -> (f64, bool) {
        let Measuring {
            angles, extents, ..
        } = &*self.measuring;
        let [width, height] = self.measuring.sizes.at(part);
        // Next to the axis densities of rows are as different as they are far from it.
        let uneven = self.around.is_some_and(|around| {
            let [along, down] = angles.at(part);
            down * around * width > UNEVEN * along
        });
        let whole = if uneven {
            width * height
        } else {
            extents.0[1][part]
        };
        (whole / self.divided.total(part), uneven)
    }

    /// Looks the samples up, whose places are in the target, and adds the values of those before.
    fn look(&mut self) {
        let n = self.next.count;
        if n == 0 {
            self.next.length = 0;
            return;
        }
        let uv = self.lookups.tile();
        self.next.share(&self.coordinate_map, uv);
        self.coordinate_map.take(uv, n);
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
        for (number, owner) in owners.list[..owners.length].iter().enumerate() {
            let own = owners.samples(number);
            let values = &values[own.start * channels..own.end * channels];
            let counted = (&owners.seen[own.clone()], &owners.shares[own]);
            (self.sums).add::<_, CHANNELS>(*owner, channels, values, counted);
        }
        (owners.count, owners.length) = (0, 0);
    }
}
