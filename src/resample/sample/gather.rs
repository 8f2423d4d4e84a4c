//! The lookups that need nothing beyond an edge: nearly all of them.
//!
//! Texels of a row lie one after the other, so a filter reads windows of a row and not texels: a pair of RGB
//! texels is six numbers, read as two overlapping groups of four (three-float loads were 2–4× slower), a
//! bicubic row is four groups. The texels of a lookup a tile ahead are asked for from memory while this one
//! is computed; without that, conversions took 1.5 to 2 times as long and random lookups more.
//!
//! The wide filters are written in lanes ([`SimdWork`]): of a plain loop over a row's twelve numbers the compiler made
//! shuffles and a gather of the weights (1.5 to 2 times slower), and weights lie in rows, for the same reason.
//!
//! Of texels of one number four lie in a row: columns of a window are summed by them, and what is left, sums along rows and texels from these, is done for 64
//! lookups at once. One by one, it took as long as the windows.
//!
//! Every filter adds weighted differences from one of its texels to that texel: a constant image stays
//! constant to the bit.
//!
//! What did not help: a copy of the image in 2×2 tiles (a third faster on random lookups only, and the
//! copy costs more); asking for the output's memory as well.

use super::corners::mix;
use super::ones::Ones;
use super::place::Places;
use super::rectangle::{LENGTH, Rectangle, each_part};
use super::weights::Weights;
use super::wide::{Window, along, columns_of, four, four_of, slack, texel_of};
use crate::image::raster::Raster;
use crate::image::texel::{Filtered, Four, Texel};
use crate::kernel::tile::TILE;
use crate::kernel::tile::prefetch_item;
use crate::kernel::{SimdWork, run_simd};
use crate::number::real::Real;
use fearless_simd::{Simd, SimdBase};

/// How a filter makes a texel of the window around a place.
pub(crate) trait Gather<T: Texel>: Copy {
    /// Texels on a side of the window.
    const SIDE: usize;
    /// Numbers that are read after each row of the window.
    const SLACK: usize;
    /// What is known of the places of a tile besides where they are.
    type Weights<'w>: Copy;

    /// Fills an area of `band` with lookups among texels of one number, all of them inside of a face, if it has a way of its own for
    /// these and finds all that it reads.
    fn ones<S: Simd, O: Filtered<T>, const STRAIGHT: bool>(
        simd: S,
        ones: Ones<'_, T, STRAIGHT>,
        tile: ([&Places<T::Float>; 2], Self::Weights<'_>),
        target: (&mut [O], Rectangle, usize),
    ) -> bool;

    /// Lookup k of a tile, in a window whose texels have `channels` numbers. CHANNELS is 0 where their number is known at run time only. LANES numbers are written (0:
    /// as many as there are channels); one more than those of the texel belongs to the next.
    fn texel<S: Simd, O: Filtered<T>, const CHANNELS: usize, const LANES: usize>(
        simd: S,
        channels: usize,
        window: Window<'_, T>,
        tile: (&Places<T::Float>, Self::Weights<'_>),
        k: usize,
        out: &mut [O],
    );
}

/// The texel that holds the place.
#[derive(Clone, Copy)]
pub(crate) struct Nearest;

impl<T: Texel> Gather<T> for Nearest {
    const SIDE: usize = 1;
    const SLACK: usize = 1;
    type Weights<'w> = ();

    #[inline(always)]
    fn ones<S: Simd, O: Filtered<T>, const STRAIGHT: bool>(
        _: S,
        ones: Ones<'_, T, STRAIGHT>,
        (places, ()): ([&Places<T::Float>; 2], ()),
        target: (&mut [O], Rectangle, usize),
    ) -> bool {
        ones.nearest(places, target);
        true
    }

    #[inline(always)]
    fn texel<S: Simd, O: Filtered<T>, const CHANNELS: usize, const LANES: usize>(
        _: S,
        channels: usize,
        window: Window<'_, T>,
        _: (&Places<T::Float>, ()),
        _: usize,
        out: &mut [O],
    ) {
        if LANES == 4 {
            let texel: [O; 4] = group(window.row(0), 0).map(O::exact);
            out[..4].copy_from_slice(&texel);
            return;
        }
        for (out, &texel) in out[..channels].iter_mut().zip(&window.row(0)[..channels]) {
            *out = O::exact(texel);
        }
    }
}

/// The four texels around the place.
#[derive(Clone, Copy)]
pub(crate) struct Bilinear;

impl<T: Texel> Gather<T> for Bilinear {
    const SIDE: usize = 2;
    const SLACK: usize = 1;
    type Weights<'w> = ();

    #[inline(always)]
    fn ones<S: Simd, O: Filtered<T>, const STRAIGHT: bool>(
        simd: S,
        ones: Ones<'_, T, STRAIGHT>,
        (places, ()): ([&Places<T::Float>; 2], ()),
        target: (&mut [O], Rectangle, usize),
    ) -> bool {
        ones.bilinear(simd, places, target);
        true
    }

    #[inline(always)]
    fn texel<S: Simd, O: Filtered<T>, const CHANNELS: usize, const LANES: usize>(
        simd: S,
        channels: usize,
        window: Window<'_, T>,
        (places, ()): (&Places<T::Float>, ()),
        k: usize,
        out: &mut [O],
    ) {
        let (tx, ty) = (places.tx[k], places.ty[k]);
        let (upper, lower) = (window.row(0), window.row(1));
        if LANES > 0 {
            let (a, b) = (
                four::<S, T>(simd, upper, 0),
                four::<S, T>(simd, upper, CHANNELS),
            );
            let (c, d) = (
                four::<S, T>(simd, lower, 0),
                four::<S, T>(simd, lower, CHANNELS),
            );
            let (tx, ty) = (Four::<T, S>::splat(simd, tx), Four::<T, S>::splat(simd, ty));
            let mixed = O::filtered_four(simd, mix([a, b, c, d], tx, ty));
            out[..LANES].copy_from_slice(&mixed[..LANES]);
        } else {
            for k in 0..channels {
                let next = k + channels;
                let corners = [upper[k], upper[next], lower[k], lower[next]];
                out[k] = O::filtered(mix(corners.map(T::load), tx, ty));
            }
        }
    }
}

/// Four numbers from `at` on.
#[inline(always)]
fn group<T: Texel>(row: &[T], at: usize) -> [T; 4] {
    [row[at], row[at + 1], row[at + 2], row[at + 3]]
}

/// A filter of TAPS × TAPS texels whose weights are the products of those along u and along v.
#[derive(Clone, Copy)]
pub(crate) struct Separable<const TAPS: usize>;

impl<T: Texel, const TAPS: usize> Gather<T> for Separable<TAPS> {
    const SIDE: usize = TAPS;
    const SLACK: usize = slack(TAPS);
    type Weights<'w> = &'w [Weights<T::Float, TILE>; 2];

    #[inline(always)]
    fn ones<S: Simd, O: Filtered<T>, const STRAIGHT: bool>(
        simd: S,
        ones: Ones<'_, T, STRAIGHT>,
        ([places, next], weights): ([&Places<T::Float>; 2], Self::Weights<'_>),
        (band, area, length): (&mut [O], Rectangle, usize),
    ) -> bool {
        if !STRAIGHT {
            return false;
        }
        let row = ones.steps[1] as usize;
        let width = TAPS + <Self as Gather<T>>::SLACK;
        let needed = (TAPS - 1) * row + width;
        let Some(last) = ones.texels.len().checked_sub(needed) else {
            return false;
        };
        if places.first[..length].iter().any(|&first| first > last) {
            return false;
        }
        let [across, down] = weights.each_ref().map(first::<T::Float, TAPS>);
        let mut columns = [[[T::Float::ZERO; 4]; LENGTH]; 2];
        each_part(
            band,
            area,
            length,
            #[inline(always)]
            |top: usize, out: &mut [O]| {
                for k in 0..out.len() {
                    let (first, ahead) = (places.first[top + k], next.first[top + k]);
                    for r in 0..TAPS {
                        prefetch_item(ones.texels, ahead.wrapping_add(r * row));
                    }
                    let window = Window {
                        numbers: &ones.texels[first..][..needed],
                        step: row,
                        width,
                    };
                    let down = down.map(|weights| weights[top + k]);
                    let [left, right] = &mut columns;
                    [left[k], right[k]] = columns_of(simd, window, &down);
                }
                let across = across.map(|row| &row[top..][..out.len()]);
                for (k, out) in out.iter_mut().enumerate() {
                    *out = O::filtered(along(across, &columns, k));
                }
            },
        );
        true
    }

    #[inline(always)]
    fn texel<S: Simd, O: Filtered<T>, const CHANNELS: usize, const LANES: usize>(
        simd: S,
        channels: usize,
        window: Window<'_, T>,
        (_, weights): (&Places<T::Float>, Self::Weights<'_>),
        k: usize,
        out: &mut [O],
    ) {
        let [across, down]: [[T::Float; TAPS]; 2] =
            std::array::from_fn(|axis| std::array::from_fn(|t| weights[axis][t][k]));
        if CHANNELS > 0 {
            let mixed: [O; 4] = if CHANNELS == 1 {
                let columns = columns_of(simd, window, &down).map(|columns| [columns]);
                let across = across.each_ref().map(std::slice::from_ref);
                [O::filtered(along(across, &columns, 0)); 4]
            } else {
                O::filtered_four(
                    simd,
                    texel_of::<S, T, TAPS, CHANNELS>(simd, window, &across, &down),
                )
            };
            let stored = if LANES > 0 { LANES } else { CHANNELS };
            out[..stored].copy_from_slice(&mixed[..stored]);
        } else if channels == 2 {
            let texel = texel_of::<S, T, TAPS, 2>(simd, window, &across, &down);
            out[..2].copy_from_slice(&O::filtered_four(simd, texel)[..2]);
        } else {
            // The last four may have been found in part.
            for first in (0..channels).step_by(4) {
                let first = first.min(channels - 4);
                let weights = [&across, &down];
                let four = four_of::<S, T, TAPS>(simd, window, (channels, first), weights);
                out[first..first + 4].copy_from_slice(&O::filtered_four(simd, four));
            }
        }
    }
}

/// The rows of the weights that a filter of TAPS texels along a side has.
#[inline(always)]
fn first<F, const TAPS: usize>(weights: &Weights<F, TILE>) -> [&[F; TILE]; TAPS] {
    std::array::from_fn(|t| &weights[t])
}

/// The stored texels of an image, and how to get at them.
#[derive(Clone, Copy)]
pub(crate) struct Stored<'a, T> {
    pub(crate) raster: &'a Raster,
    pub(crate) texels: &'a [T],
    pub(crate) channels: usize,
}

/// Places of a tile to look up, one texel of an area of `band` each, and those of the next one, whose texels are asked for.
pub(crate) struct Gathering<'a, T: Texel, O> {
    pub(crate) stored: Stored<'a, T>,
    pub(crate) places: &'a Places<T::Float>,
    pub(crate) all_inside: bool,
    pub(crate) next: &'a Places<T::Float>,
    pub(crate) band: &'a mut [O],
    pub(crate) area: Rectangle,
    pub(crate) length: usize,
    /// Answers for the places that are not inside: behind a pointer, for what it knows of them would be a kernel more each.
    pub(crate) edge: &'a mut dyn FnMut(usize, &mut [O]),
}

impl<T: Texel, O: Filtered<T>> Gathering<'_, T, O> {
    /// Does it, by a filter.
    pub(crate) fn run<G: Gather<T>>(self, weights: G::Weights<'_>) {
        match self.stored.channels {
            1 => self.rows::<G, 1>(weights),
            3 => self.rows::<G, 3>(weights),
            4 => self.rows::<G, 4>(weights),
            _ => self.rows::<G, 0>(weights),
        }
    }

    fn rows<G: Gather<T>, const CHANNELS: usize>(self, weights: G::Weights<'_>) {
        // A window of one texel lies as it is, however its face is turned.
        if const { G::SIDE == 1 } || self.is_straight() {
            run_simd(Windows::<T, O, G, CHANNELS, true>(self, weights));
        } else {
            run_simd(Windows::<T, O, G, CHANNELS, false>(self, weights));
        }
    }

    /// Whether the rows of all faces that are looked up are stored as rows.
    fn is_straight(&self) -> bool {
        let raster = self.stored.raster;
        let mut faces = self.places.face[..self.length].iter();
        raster.straight().is_some() || faces.all(|&face| raster.is_straight(face.into()))
    }
}

/// A gathering by a filter.
struct Windows<'a, 'w, T: Texel, O, G: Gather<T>, const CHANNELS: usize, const STRAIGHT: bool>(
    Gathering<'a, T, O>,
    G::Weights<'w>,
);

impl<T, O, G, const CHANNELS: usize, const STRAIGHT: bool> SimdWork
    for Windows<'_, '_, T, O, G, CHANNELS, STRAIGHT>
where
    T: Texel,
    O: Filtered<T>,
    G: Gather<T>,
{
    // Faces that are stored turned are few.
    const EVERY_LEVEL: bool = STRAIGHT;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        if const { STRAIGHT } {
            straight::<S, T, O, G, CHANNELS>(simd, self.0, self.1);
        } else {
            turned::<S, T, O, G, CHANNELS>(simd, self.0, self.1);
        }
    }
}

/// Faces whose rows are stored as rows.
#[inline(always)]
fn straight<S: Simd, T: Texel, O: Filtered<T>, G: Gather<T>, const CHANNELS: usize>(
    simd: S,
    work: Gathering<'_, T, O>,
    weights: G::Weights<'_>,
) {
    let Gathering {
        stored,
        places,
        all_inside,
        next,
        band,
        area,
        length,
        edge,
    } = work;
    let channels = if CHANNELS > 0 {
        CHANNELS
    } else {
        stored.channels
    };
    let (texels, row) = (stored.texels, stored.raster.columns);
    if CHANNELS == 1
        && all_inside
        && let Some(ones) = Ones::<T, true>::new(texels, [1, row as isize])
        && G::ones(
            simd,
            ones,
            ([places, next], weights),
            (&mut *band, area, length),
        )
    {
        return;
    }
    let step = row * channels;
    let width = G::SIDE * channels + G::SLACK;
    let needed = (G::SIDE - 1) * step + width;
    let tile = (places, weights);
    for top in (0..length).step_by(area.columns) {
        let columns = area.columns.min(length - top);
        let start = (area.start + top / area.columns * area.stride) * channels;
        let out = &mut band[start..][..columns * channels];
        let lookups = places.first[top..top + columns].iter();
        let lookups = lookups.zip(&places.inside[top..top + columns]);
        for (k, ((&first, &inside), &ahead)) in lookups.zip(&next.first[top..]).enumerate() {
            // What the next tile has not been told yet is a place of long ago: asking for it does no harm.
            for r in 0..G::SIDE {
                let at = ahead.wrapping_add(r * step);
                prefetch_item(texels, at);
                prefetch_item(texels, at.wrapping_add(G::SIDE * channels - 1));
            }
            let window = match texels.get(first..first.wrapping_add(needed)) {
                Some(numbers) if all_inside | inside => Window {
                    numbers,
                    step,
                    width,
                },
                _ => {
                    edge(top + k, &mut out[k * channels..][..channels]);
                    continue;
                }
            };
            let out = &mut out[k * channels..];
            // Three numbers are written as four where another texel follows, which is then written over.
            if CHANNELS == 3 || CHANNELS == 4 {
                if let Some(out) = out.first_chunk_mut::<4>() {
                    G::texel::<S, O, CHANNELS, 4>(simd, channels, window, tile, top + k, out);
                } else {
                    G::texel::<S, O, CHANNELS, 3>(simd, channels, window, tile, top + k, out);
                }
            } else {
                G::texel::<S, O, CHANNELS, 0>(simd, channels, window, tile, top + k, out);
            }
        }
    }
}

/// Faces that are stored turned or mirrored: windows are put together texel by texel, each of these four numbers long where that is no
/// less, for a texel that is read as it was written does not wait for memory.
#[inline(always)]
fn turned<S: Simd, T: Texel, O: Filtered<T>, G: Gather<T>, const CHANNELS: usize>(
    simd: S,
    work: Gathering<'_, T, O>,
    weights: G::Weights<'_>,
) {
    let Gathering {
        stored,
        places,
        all_inside,
        next,
        band,
        area,
        length,
        edge,
    } = work;
    let (texels, raster) = (stored.texels, stored.raster);
    let channels = if CHANNELS > 0 {
        CHANNELS
    } else {
        stored.channels
    };
    let face = places.face[0];
    if CHANNELS == 1
        && all_inside
        && places.face[..length].iter().all(|other| *other == face)
        && let Some(ones) = Ones::<T, false>::new(texels, raster.view(face.into()).steps())
        && G::ones(
            simd,
            ones,
            ([places, next], weights),
            (&mut *band, area, length),
        )
    {
        return;
    }
    let pitch = if CHANNELS == 3 { 4 } else { channels };
    let width = G::SIDE * pitch + G::SLACK;
    let mut numbers = vec![T::default(); G::SIDE * width];
    let tile = (places, weights);
    for top in (0..length).step_by(area.columns) {
        let columns = area.columns.min(length - top);
        let start = (area.start + top / area.columns * area.stride) * channels;
        let out = &mut band[start..][..columns * channels];
        for (k, out) in out.chunks_exact_mut(channels).enumerate() {
            let k = top + k;
            prefetch_item(texels, next.first[k]);
            if !places.inside[k] {
                edge(k, out);
                continue;
            }
            let steps = raster.view(places.face[k].into()).steps();
            let [right, down] = steps.map(|step| step * channels as isize);
            let mut first = places.first[k];
            for row in numbers.chunks_exact_mut(width) {
                let mut at = first;
                for texel in row.chunks_exact_mut(pitch).take(G::SIDE) {
                    copy::<T, CHANNELS>(&texels[at..], texel);
                    at = at.wrapping_add_signed(right);
                }
                first = first.wrapping_add_signed(down);
            }
            let window = Window {
                numbers: &numbers,
                step: width,
                width,
            };
            match CHANNELS {
                3 => G::texel::<S, O, 4, 3>(simd, pitch, window, tile, k, out),
                4 => G::texel::<S, O, 4, 4>(simd, pitch, window, tile, k, out),
                _ => G::texel::<S, O, CHANNELS, 0>(simd, pitch, window, tile, k, out),
            }
        }
    }
}

/// Copies a texel, and what follows, as far as there is room for it.
#[inline(always)]
fn copy<T: Texel, const CHANNELS: usize>(from: &[T], to: &mut [T]) {
    match (CHANNELS, from.first_chunk(), to.first_chunk_mut::<4>()) {
        (3 | 4, Some(from), Some(to)) => *to = *from,
        _ => {
            let count = to.len().min(from.len());
            to[..count].copy_from_slice(&from[..count]);
        }
    }
}
