//! Rows of the next level whose texels cover two columns each of rows that are stored as rows, where all that they cover holds values.
//!
//! That is nearly every texel, also of images with a rim. The sums are those of any texel, number by number; but where columns follow each other nothing is looked
//! for, and a row is summed in one pass for each that it covers: texel by texel, the searching took four times as long as the sums.

use super::side::Covers;
use crate::image::texel::Texel;
use crate::kernel::{Scalar, vectorize};
use crate::number::real::Real;
use std::array::from_fn;
use std::borrow::Cow;
use std::ops::Range;

/// Texels that are summed together: what is known of them stays in the nearest cache.
const TOGETHER: usize = 64;

/// What the texels of a row cover of one row of the level.
pub(super) struct Covered<'a, T> {
    /// The numbers of the columns, from the first on.
    pub(super) texels: &'a [T],
    /// The solid angles of what is covered of them.
    pub(super) solid_angles: &'a [f64],
}

/// Whether texels of some columns of the next level, of which `across` says what each covers, cover two columns each that follow those of the
/// one before.
pub(super) fn are_pairs(across: &[Vec<Covers>]) -> bool {
    let Some(first) = across.first().and_then(|covered| covered.first()) else {
        return false;
    };
    across
        .iter()
        .enumerate()
        .all(|(k, covered)| match covered[..] {
            [a, b] => a.texel == first.texel + 2 * k && b.texel == a.texel + 1,
            _ => false,
        })
}

/// Fills so many texels with the means of what they cover, all of it of some weight.
pub(super) fn fill<T: Texel>(channels: usize, rows: &[Covered<'_, T>], out: &mut [T::Float]) {
    vectorize(
        #[inline(always)]
        || match channels {
            1 => fill_all::<T, 1>(rows, out),
            3 => fill_all::<T, 3>(rows, out),
            4 => fill_all::<T, 4>(rows, out),
            channels => {
                for channel in 0..channels {
                    fill_one(channel, channels, rows, out);
                }
            }
        },
    );
}

/// What some texels are made of: of each channel a row, so that texels become lanes.
struct Planes<const CHANNELS: usize> {
    weights: [f64; TOGETHER],
    /// The first value that a texel covers.
    first: [[f64; TOGETHER]; CHANNELS],
    /// The sum of what the others differ by.
    sums: [[f64; TOGETHER]; CHANNELS],
}

/// Pairs of texels, or of some numbers of each.
type Together<T, const CHANNELS: usize> = [[[T; CHANNELS]; 2]; TOGETHER];

/// All channels, of a number that is known here.
#[inline(always)]
fn fill_all<T: Texel, const CHANNELS: usize>(rows: &[Covered<'_, T>], out: &mut [T::Float]) {
    fill_planes::<T, CHANNELS>(
        rows,
        #[inline(always)]
        |texels, own| padded(&texels.as_chunks::<CHANNELS>().0.as_chunks::<2>().0[own]),
        out.as_chunks_mut::<CHANNELS>().0.iter_mut(),
    );
}

/// One channel of any number of them.
#[inline(always)]
fn fill_one<T: Texel>(
    channel: usize,
    channels: usize,
    rows: &[Covered<'_, T>],
    out: &mut [T::Float],
) {
    fill_planes::<T, 1>(
        rows,
        #[inline(always)]
        |texels, own| {
            let number = |pair: usize, side| [texels[(2 * pair + side) * channels + channel]];
            Cow::Owned(from_fn(|k| {
                let pair = (own.start + k).min(own.end - 1);
                [number(pair, 0), number(pair, 1)]
            }))
        },
        out[channel..]
            .chunks_mut(channels)
            .filter_map(|texel| texel.first_chunk_mut()),
    );
}

/// Some channels: `pairs` brings those of some texels of a row together, and `out` is where they belong.
#[inline(always)]
fn fill_planes<'t, 'o, T: Texel, const CHANNELS: usize>(
    rows: &[Covered<'t, T>],
    pairs: impl Fn(&'t [T], Range<usize>) -> Cow<'t, Together<T, CHANNELS>>,
    mut out: impl Iterator<Item = &'o mut [T::Float; CHANNELS]>,
) {
    let count = rows
        .first()
        .map_or(0, |row| row.solid_angles.as_chunks::<2>().0.len());
    for first in (0..count).step_by(TOGETHER) {
        let mut planes = Planes {
            weights: [0.0; TOGETHER],
            first: [[0.0; TOGETHER]; CHANNELS],
            sums: [[0.0; TOGETHER]; CHANNELS],
        };
        let own = first..count.min(first + TOGETHER);
        for (number, row) in rows.iter().enumerate() {
            let solid_angles = padded(&row.solid_angles.as_chunks::<2>().0[own.clone()]);
            planes.add(number == 0, &pairs(row.texels, own.clone()), &solid_angles);
        }
        planes.write::<T>(out.by_ref().take(own.len()));
    }
}

/// As many as are summed together, of which the last ones may mean nothing.
#[inline(always)]
fn padded<A: Copy>(items: &[A]) -> Cow<'_, [A; TOGETHER]> {
    if let Some(whole) = items.first_chunk() {
        return Cow::Borrowed(whole);
    }
    let mut room = [items[0]; TOGETHER];
    room[..items.len()].copy_from_slice(items);
    Cow::Owned(room)
}

impl<const CHANNELS: usize> Planes<CHANNELS> {
    /// Adds what the texels cover of a row: pairs of its texels, and the solid angles of what is covered of them.
    #[inline(always)]
    #[expect(clippy::needless_range_loop, reason = "rows in step")]
    fn add<T: Texel>(
        &mut self,
        begin: bool,
        pairs: &Together<T, CHANNELS>,
        solid_angles: &[[f64; 2]; TOGETHER],
    ) {
        if begin {
            for k in 0..TOGETHER {
                for c in 0..CHANNELS {
                    self.first[c][k] = pairs[k][0][c].load().to_f64();
                }
            }
        }
        for k in 0..TOGETHER {
            for side in 0..2 {
                let own = solid_angles[k][side];
                self.weights[k] += own;
                for c in 0..CHANNELS {
                    let more = pairs[k][side][c].load().to_f64() - self.first[c][k];
                    self.sums[c][k] += own * more;
                }
            }
        }
    }

    /// Writes the means.
    #[inline(always)]
    fn write<'o, T: Texel>(&self, out: impl Iterator<Item = &'o mut [T::Float; CHANNELS]>) {
        for (k, out) in out.enumerate().take(TOGETHER) {
            for (c, out) in out.iter_mut().enumerate() {
                let mean = self.first[c][k] + self.sums[c][k] / self.weights[k];
                *out = <T::Float as Real>::new(mean);
            }
        }
    }
}
