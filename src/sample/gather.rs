//! The lookups that need nothing beyond an edge: nearly all of them.
//!
//! Texels of a row lie one after the other, so a filter reads windows of a row and not texels: a pair of RGB
//! texels is six numbers, read as two overlapping groups of four (three-float loads were 2–4× slower), a
//! bicubic row is twelve. The texels of a lookup some way ahead are asked for from memory while this one
//! is computed; without that, random lookups waited for memory one after the other.
//!
//! Every filter adds weighted differences from one of its texels to that texel: a constant image stays
//! constant to the bit.
//!
//! What did not help: a copy of the image in 2×2 tiles (a third faster on random lookups only, and the
//! copy costs more).

use super::Area;
use super::place::Places;
use super::weights::Kernel;
use crate::image::{Filtered, Raster, Texel};
use crate::kernel::{prefetch_item, vectorize};
use std::marker::PhantomData;

/// The most numbers in a window's row for which loops are unrolled.
const ROW: usize = 24;

/// Rows of SIDE texels and SLACK numbers.
#[derive(Clone, Copy)]
pub(crate) struct Window<'a, T> {
    numbers: &'a [T],
    step: usize,
    width: usize,
}

impl<'a, T> Window<'a, T> {
    #[inline(always)]
    fn row(self, r: usize) -> &'a [T] {
        &self.numbers[r * self.step..][..self.width]
    }
}

/// How a filter makes a texel of the window around a place.
pub(crate) trait Gather<T: Texel>: Copy {
    /// Texels on a side of the window.
    const SIDE: usize;
    /// Numbers that are read after each row of the window.
    const SLACK: usize;

    /// One lookup in a window whose texels have `channels` numbers. CHANNELS is 0 where their number is known at run time only. LANES numbers are written (0:
    /// as many as there are channels); one more than those of the texel belongs to the next.
    fn texel<O: Filtered<T>, const CHANNELS: usize, const LANES: usize>(
        channels: usize,
        window: Window<'_, T>,
        t: [T::Float; 2],
        out: &mut [O],
    );
}

/// The texel that holds the place.
#[derive(Clone, Copy)]
pub(crate) struct Nearest;

impl<T: Texel> Gather<T> for Nearest {
    const SIDE: usize = 1;
    const SLACK: usize = 0;

    #[inline(always)]
    fn texel<O: Filtered<T>, const CHANNELS: usize, const LANES: usize>(
        channels: usize,
        window: Window<'_, T>,
        _: [T::Float; 2],
        out: &mut [O],
    ) {
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

    #[inline(always)]
    fn texel<O: Filtered<T>, const CHANNELS: usize, const LANES: usize>(
        channels: usize,
        window: Window<'_, T>,
        [tx, ty]: [T::Float; 2],
        out: &mut [O],
    ) {
        let (upper, lower) = (window.row(0), window.row(1));
        if LANES > 0 {
            let (a, b) = (group(upper, 0), group(upper, CHANNELS));
            let (c, d) = (group(lower, 0), group(lower, CHANNELS));
            let mixed: [O; 4] =
                std::array::from_fn(|k| O::filtered(mix::<T>([a[k], b[k], c[k], d[k]], tx, ty)));
            out[..LANES].copy_from_slice(&mixed[..LANES]);
        } else {
            for k in 0..channels {
                let next = k + channels;
                let corners = [upper[k], upper[next], lower[k], lower[next]];
                out[k] = O::filtered(mix(corners, tx, ty));
            }
        }
    }
}

/// Four numbers from `at` on.
#[inline(always)]
fn group<T: Texel>(row: &[T], at: usize) -> [T; 4] {
    [row[at], row[at + 1], row[at + 2], row[at + 3]]
}

#[inline(always)]
fn mix<T: Texel>(corners: [T; 4], tx: T::Float, ty: T::Float) -> T::Float {
    let [a, b, c, d] = corners.map(T::load);
    let above = a + tx * (b - a);
    let below = c + tx * (d - c);
    above + ty * (below - above)
}

/// A separable kernel over TAPS × TAPS texels.
#[derive(Clone, Copy)]
pub(crate) struct Separable<K, const TAPS: usize>(PhantomData<K>);

impl<T: Texel, K: Kernel<TAPS>, const TAPS: usize> Gather<T> for Separable<K, TAPS> {
    const SIDE: usize = TAPS;
    const SLACK: usize = 0;

    #[inline(always)]
    fn texel<O: Filtered<T>, const CHANNELS: usize, const LANES: usize>(
        channels: usize,
        window: Window<'_, T>,
        [tx, ty]: [T::Float; 2],
        out: &mut [O],
    ) {
        let (across, down) = (K::weights(tx), K::weights(ty));
        let middle = TAPS / 2 - 1;
        if CHANNELS > 0 {
            let width = TAPS * CHANNELS;
            let base: [T::Float; CHANNELS] =
                std::array::from_fn(|k| window.row(middle)[middle * CHANNELS + k].load());
            let mut bases = [T::Float::default(); ROW];
            for k in 0..width {
                bases[k] = base[k % CHANNELS];
            }
            let mut sums = [T::Float::default(); ROW];
            for (r, &weight) in down.iter().enumerate() {
                let row = &window.row(r)[..width];
                for k in 0..width {
                    sums[k] = sums[k] + weight * (row[k].load() - bases[k]);
                }
            }
            let lanes = if LANES > 0 { 4 } else { CHANNELS };
            let mut mixed = [O::default(); 4];
            for k in 0..lanes {
                let mut sum = across[0] * sums[k];
                for t in 1..TAPS {
                    sum = sum + across[t] * sums[t * CHANNELS + k];
                }
                mixed[k] = O::filtered(bases[k] + sum);
            }
            let stored = if LANES > 0 { LANES } else { CHANNELS };
            out[..stored].copy_from_slice(&mixed[..stored]);
        } else {
            for (k, out) in out.iter_mut().enumerate().take(channels) {
                let base = window.row(middle)[middle * channels + k].load();
                let mut sum = T::Float::default();
                for (t, &across) in across.iter().enumerate() {
                    let mut column = T::Float::default();
                    for (r, &weight) in down.iter().enumerate() {
                        let texel = window.row(r)[t * channels + k].load();
                        column = column + weight * (texel - base);
                    }
                    sum = sum + across * column;
                }
                *out = O::filtered(base + sum);
            }
        }
    }
}

/// The stored texels of an image, and how to get at them.
#[derive(Clone, Copy)]
pub(crate) struct Stored<'a, T> {
    pub(crate) raster: &'a Raster,
    pub(crate) texels: &'a [T],
    pub(crate) channels: usize,
}

/// Looks places up, one texel of `out` each, and asks for the texels of the first ones of another tile.
/// `edge` answers for those that are not inside.
pub(crate) fn gather<T: Texel, O: Filtered<T>, G: Gather<T>>(
    stored: Stored<'_, T>,
    places: (&Places<T::Float>, bool),
    ahead: (&Places<T::Float>, usize),
    band: &mut [O],
    area: (Area, usize),
    edge: impl FnMut(usize, &mut [O]),
) {
    match stored.channels {
        1 => rows::<T, O, G, 1>(stored, places, ahead, band, area, edge),
        3 => rows::<T, O, G, 3>(stored, places, ahead, band, area, edge),
        4 => rows::<T, O, G, 4>(stored, places, ahead, band, area, edge),
        _ => rows::<T, O, G, 0>(stored, places, ahead, band, area, edge),
    }
}

fn rows<T: Texel, O: Filtered<T>, G: Gather<T>, const CHANNELS: usize>(
    stored: Stored<'_, T>,
    places: (&Places<T::Float>, bool),
    ahead: (&Places<T::Float>, usize),
    band: &mut [O],
    area: (Area, usize),
    mut edge: impl FnMut(usize, &mut [O]),
) {
    match stored.raster.straight() {
        Some(row) => vectorize(
            #[inline(always)]
            || straight::<T, O, G, CHANNELS>(stored, row, places, ahead, band, area, &mut edge),
        ),
        None => turned::<T, O, G, CHANNELS>(stored, places.0, band, area, &mut edge),
    }
}

/// Faces whose rows are stored as rows, `row` texels apart.
#[inline(always)]
fn straight<T: Texel, O: Filtered<T>, G: Gather<T>, const CHANNELS: usize>(
    stored: Stored<'_, T>,
    row: usize,
    (places, all_inside): (&Places<T::Float>, bool),
    (next, ahead): (&Places<T::Float>, usize),
    band: &mut [O],
    (area, length): (Area, usize),
    edge: &mut impl FnMut(usize, &mut [O]),
) {
    let channels = if CHANNELS > 0 {
        CHANNELS
    } else {
        stored.channels
    };
    let step = row * channels;
    let needed = (G::SIDE - 1) * step + G::SIDE * channels + G::SLACK;
    let Some(last) = stored.texels.len().checked_sub(needed) else {
        return each(band, area, length, channels, edge);
    };
    let width = G::SIDE * channels + G::SLACK;
    for top in (0..length).step_by(area.columns) {
        let columns = area.columns.min(length - top);
        let start = (area.start + top / area.columns * area.stride) * channels;
        let out = &mut band[start..][..columns * channels];
        for k in 0..columns {
            let n = top + k;
            if n < ahead {
                let at = next.first[n].wrapping_mul(channels);
                for r in 0..G::SIDE {
                    let at = at.wrapping_add(r * step);
                    prefetch_item(stored.texels, at);
                    if G::SIDE > 1 {
                        prefetch_item(stored.texels, at.wrapping_add(G::SIDE * channels - 1));
                    }
                }
            }
            let at = places.first[n].wrapping_mul(channels);
            let out = &mut out[k * channels..];
            if !(all_inside || places.inside[n]) || at > last {
                edge(n, &mut out[..channels]);
                continue;
            }
            let window = &stored.texels[at..at + needed];
            let t = [places.tx[n], places.ty[n]];
            let window = Window {
                numbers: window,
                step,
                width,
            };
            // Three numbers are written as four where another texel follows, which is then written over.
            if CHANNELS == 4 || CHANNELS == 3 && k + 1 < columns {
                G::texel::<O, CHANNELS, 4>(channels, window, t, out);
            } else if CHANNELS == 3 {
                G::texel::<O, CHANNELS, 3>(channels, window, t, out);
            } else {
                G::texel::<O, CHANNELS, 0>(channels, window, t, out);
            }
        }
    }
}

/// Calls `work` with the number and the place of each of `length` texels of an area.
fn each<T>(
    band: &mut [T],
    area: Area,
    length: usize,
    channels: usize,
    mut work: impl FnMut(usize, &mut [T]),
) {
    for first in (0..length).step_by(area.columns) {
        let columns = area.columns.min(length - first);
        let start = (area.start + first / area.columns * area.stride) * channels;
        let row = &mut band[start..][..columns * channels];
        for (k, out) in row.chunks_exact_mut(channels).enumerate() {
            work(first + k, out);
        }
    }
}

/// Faces that are stored turned or mirrored: windows are put together texel by texel.
fn turned<T: Texel, O: Filtered<T>, G: Gather<T>, const CHANNELS: usize>(
    stored: Stored<'_, T>,
    places: &Places<T::Float>,
    band: &mut [O],
    (area, length): (Area, usize),
    edge: &mut impl FnMut(usize, &mut [O]),
) {
    let channels = stored.channels;
    let width = G::SIDE * channels + G::SLACK;
    let mut window = vec![T::default(); G::SIDE * width];
    each(band, area, length, channels, |k, out| {
        if !places.inside[k] {
            return edge(k, out);
        }
        let first = places.first[k] as isize;
        let [right, down] = stored.raster.view(places.face[k] as usize).steps();
        for (r, row) in window.chunks_exact_mut(width).enumerate() {
            for (t, texel) in row.chunks_exact_mut(channels).take(G::SIDE).enumerate() {
                let at = (first + t as isize * right + r as isize * down) as usize * channels;
                texel.copy_from_slice(&stored.texels[at..at + channels]);
            }
        }
        G::texel::<O, CHANNELS, 0>(
            channels,
            Window {
                numbers: &window,
                step: width,
                width,
            },
            [places.tx[k], places.ty[k]],
            out,
        );
    });
}
