//! Means of lookups, evenly spread over parallelograms of the source.
//!
//! What a texel of the target sees, where coordinates hardly bend, is a parallelogram of the source. Its mean is that of
//! lookups on a grid within it, one for about every source texel. Put together from single lookups, in tiles
//! like any others, keeping account of which belongs to whom took ten times as long as the lookups. Here all of one
//! texel are made one after the other, from the window that holds them.
//!
//! Places are found number by number, each for as many parallelograms as there are lanes: most have two to six, and found for one
//! parallelogram after the other they left most lanes empty, which took longer than the lookups. Texels that follow each other in a row
//! have nearly one shape (`runs`); where that is not so, each has its own (`parallelograms`).

use super::gather::Bilinear;
use super::look::{Face, Look, Room, Wide, weigh};
use super::pairs::share;
use super::place::Support;
use super::slices::{REACH, Sides, Slices};
use super::spread::{LANES, MOST};
use super::texture::Texture;
use crate::image::raster::Raster;
use crate::image::texel::Texel;
use crate::kernel::tile::prefetch_item;
use crate::kernel::{Scalar, SimdWork, run_simd};
use crate::number::real::Real;
use crate::resample::filters::LookupFilter;
use crate::resample::filters::claims::{Kernel, Visitor};
use fearless_simd::Simd;
use std::marker::PhantomData;

/// Parallelograms of one face whose places are found [`LANES`] at a time.
pub(super) trait Chunks<F> {
    /// Begins with a face: where the window of its first texel begins, and how many numbers lie from a texel to those right and below.
    /// Returns how many chunks there are.
    fn start(&mut self, first: usize, steps: [i32; 2]) -> usize;

    /// Finds the places of one chunk, and whose they are.
    fn place(&self, chunk: usize, room: &mut Room<F>);

    /// Finds the sides of the parallelograms of one chunk, and whose they are.
    fn sides(&self, chunk: usize, into: &mut Sides);
}

/// How means are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// From places that are looked up.
    Places,
    /// From windows, whose texels have their weights.
    Windows,
}

impl Way {
    /// Windows come first, where they serve.
    pub(super) const ALL: [Way; 2] = [Way::Windows, Way::Places];

    /// Whether parallelograms of so many places, for which windows serve or not, are found this way.
    #[inline(always)]
    pub(super) fn takes(self, places: f32, fits: bool) -> bool {
        match self {
            Way::Windows => fits,
            Way::Places => !fits & (places > 1.0) & (places <= MOST as f32),
        }
    }
}

/// Whether means by a filter may be found from windows.
pub(super) fn has_windows(filter: LookupFilter) -> bool {
    filter == LookupFilter::Bilinear
}

/// What is known of chunks that are being looked up.
pub(crate) struct Rooms<F> {
    /// Places of one, and of the next, whose texels are asked for.
    places: [Room<F>; 2],
    sides: Sides,
    slices: Slices<F>,
}

impl<F: Scalar> Rooms<F> {
    pub(crate) fn new() -> Self {
        Rooms {
            places: [Room::NEW; 2],
            sides: Sides::NONE,
            slices: Slices::new(),
        }
    }
}

/// Finds the means of all chunks on a face, and writes them into `means`. False if the filter has no way for this.
pub(super) fn find<T: Texel>(
    (source, filter, way): (&Texture<'_, T>, LookupFilter, Way),
    face: usize,
    (chunks, rooms): (&mut dyn Chunks<T::Float>, &mut Rooms<T::Float>),
    means: &mut [T],
) -> bool {
    let find = Find {
        source,
        face,
        chunks,
        rooms,
        means,
    };
    match way {
        Way::Places => filter.visit(find),
        Way::Windows => find.by_windows(),
    }
}

struct Find<'m, 'a, T: Texel> {
    source: &'m Texture<'a, T>,
    face: usize,
    chunks: &'m mut dyn Chunks<T::Float>,
    rooms: &'m mut Rooms<T::Float>,
    means: &'m mut [T],
}

impl<T: Texel> Visitor for Find<'_, '_, T> {
    type Output = bool;
    fn nearest(self) -> bool {
        false
    }
    fn bilinear(self) -> bool {
        self.by::<Bilinear>(share)
    }
    fn separable<K: Kernel<TAPS>, const TAPS: usize>(self) -> bool {
        self.by::<Wide<TAPS>>(weigh::<T::Float, K, TAPS>)
    }
}

impl<T: Texel> Find<'_, '_, T> {
    /// `weigh` finds the weights of what a room holds.
    fn by<L: Look<T>>(self, weigh: fn(&mut Room<T::Float>)) -> bool {
        let face = Face::new(self.source, self.face, L::SUPPORT);
        let steps = face.narrow_steps(MOST as i32).filter(|_| L::serves(&face));
        if let Some(steps) = steps {
            run_simd(Means::<T, L> {
                face,
                count: self.chunks.start(face.first, steps),
                chunks: self.chunks,
                rooms: &mut self.rooms.places,
                means: self.means,
                weigh,
                filter: PhantomData,
            });
        }
        steps.is_some()
    }

    fn by_windows(self) -> bool {
        let face = Face::new(self.source, self.face, Support::PAIR);
        let steps = face.narrow_steps(REACH);
        if let Some(steps) = steps {
            run_simd(Windowed {
                face,
                steps,
                count: self.chunks.start(face.first, steps),
                chunks: self.chunks,
                rooms: self.rooms,
                means: self.means,
            });
        }
        steps.is_some()
    }
}

struct Windowed<'m, 'a, T: Texel> {
    face: Face<'a, T>,
    steps: [i32; 2],
    count: usize,
    /// Behind a pointer, as in [`Means`].
    chunks: &'m dyn Chunks<T::Float>,
    rooms: &'m mut Rooms<T::Float>,
    means: &'m mut [T],
}

impl<T: Texel> SimdWork for Windowed<'_, '_, T> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let (face, means) = (self.face, self.means);
        let Rooms { sides, slices, .. } = self.rooms;
        for chunk in 0..self.count {
            self.chunks.sides(chunk, sides);
            slices.set(sides, self.steps);
            match (face.channels, face.straight) {
                (3, true) => slices.look::<S, T, 3, true>(simd, &face, means),
                (3, false) => slices.look::<S, T, 3, false>(simd, &face, means),
                (4, true) => slices.look::<S, T, 4, true>(simd, &face, means),
                (4, false) => slices.look::<S, T, 4, false>(simd, &face, means),
                _ => slices.look_any(&face, means),
            }
        }
    }
}

struct Means<'m, 'a, T: Texel, L> {
    face: Face<'a, T>,
    count: usize,
    /// Behind a pointer: how places are found is not compiled for each filter and type.
    chunks: &'m dyn Chunks<T::Float>,
    rooms: &'m mut [Room<T::Float>; 2],
    means: &'m mut [T],
    weigh: fn(&mut Room<T::Float>),
    filter: PhantomData<L>,
}

impl<T: Texel, L: Look<T>> SimdWork for Means<'_, '_, T, L> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let face = self.face;
        for chunk in 0..=self.count {
            if chunk < self.count {
                let room = &mut self.rooms[chunk % 2];
                self.chunks.place(chunk, room);
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
            let room = &self.rooms[chunk % 2];
            if face.straight {
                L::look::<S, true>(simd, &face, room, self.means);
            } else {
                L::look::<S, false>(simd, &face, room, self.means);
            }
        }
    }
}

/// Where places may be, so that all texels of their lookups are inside of a face.
#[derive(Clone, Copy)]
pub(super) struct Margin {
    before: f64,
    last: [f64; 2],
    /// Of the texel of a face that is stored last four numbers may not be there; wide filters read up to two more than those of a row.
    spare: f64,
    forward: [bool; 2],
}

impl Margin {
    pub(super) fn new(raster: &Raster, face: usize, support: Support) -> Margin {
        let (before, after) = (support.before as f64, support.after as f64);
        Margin {
            before,
            last: [raster.width, raster.height].map(|n| n as f64 - after),
            spare: if after > 1.0 { 2.0 } else { 1.0 },
            forward: raster.view(face).steps().map(|step| step > 0),
        }
    }

    /// Whether places so far around a center are between both edges of an axis, and whether any may be at the end of that axis where the
    /// face's last number is stored.
    #[inline(always)]
    pub(super) fn holds(&self, axis: usize, center: f64, reach: f64) -> (bool, bool) {
        let inside = (center >= reach + self.before) & (center + reach < self.last[axis]);
        let end = if self.forward[axis] {
            center + reach >= self.last[axis] - self.spare
        } else {
            center - reach < self.before + self.spare
        };
        (inside, end)
    }
}

/// Finds where the texels begin that centers are in, `steps` apart from `first` on, and how far right and down the centers are from there.
#[inline(always)]
pub(super) fn texels_of<const N: usize>(
    centers: [&[f64; N]; 2],
    (first, steps): (usize, [i32; 2]),
    starts: &mut [usize; N],
    off: &mut [[f32; N]; 2],
) {
    starts.fill(first);
    for ((centers, off), step) in centers.into_iter().zip(off).zip(steps) {
        for ((start, off), &center) in starts.iter_mut().zip(off).zip(centers) {
            // What is left of a center is exact enough in f32, whatever the image's side.
            let texel = Real::floor(center);
            *off = (center - texel) as f32;
            let step = i64::from(texel.whole()) * i64::from(step);
            *start = start.wrapping_add(step as usize);
        }
    }
}

/// Puts the places of one number into a room: so far right and down of texels that begin at `starts`.
#[inline(always)]
pub(super) fn put<F: Scalar>(
    room: &mut Room<F>,
    number: usize,
    [x, y]: [&[f32; LANES]; 2],
    (starts, [right, down]): (&[usize; LANES], [i32; 2]),
) {
    let (mut first, mut tx, mut ty) = (*starts, [F::ZERO; LANES], [F::ZERO; LANES]);
    for k in 0..LANES {
        let (i, j) = (Real::floor(x[k]), Real::floor(y[k]));
        tx[k] = F::new(f64::from(x[k] - i));
        ty[k] = F::new(f64::from(y[k] - j));
        let step = i.whole().wrapping_mul(right);
        let step = step.wrapping_add(j.whole().wrapping_mul(down));
        first[k] = first[k].wrapping_add(step as usize);
    }
    room.first.as_chunks_mut().0[number] = first;
    room.tx.as_chunks_mut().0[number] = tx;
    room.ty.as_chunks_mut().0[number] = ty;
}
