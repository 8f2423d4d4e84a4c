//! Windows of the wide filters: texels are weighted down the rows first, and what comes of that along them.
//!
//! The numbers of a row follow each other, whichever texels they are of, and are added up eight at a time; only what is left of all rows is
//! parted into texels. Texel by texel, four numbers of which one is none of a color's three, it was two thirds more operations.
//!
//! Rows are added up as differences from one of them, and columns as differences from one of these: a constant stays constant to the bit.
//! What is summed is the same, number by number, however many numbers a texel has.

use crate::image::texel::{Eight, Four, Texel};
use crate::kernel::Scalar;
use crate::number::real::Real;
use fearless_simd::{Simd, SimdBase, SimdCombine, SimdSplit};
use std::ops::{Add, Mul, Sub};

/// Rows of SIDE texels and SLACK numbers.
#[derive(Clone, Copy)]
pub(crate) struct Window<'a, T> {
    pub(super) numbers: &'a [T],
    pub(super) step: usize,
    pub(super) width: usize,
}

impl<'a, T> Window<'a, T> {
    #[inline(always)]
    pub(super) fn row(self, r: usize) -> &'a [T] {
        &self.numbers[r * self.step..][..self.width]
    }
}

/// Numbers that are read after each row of a window so wide: four or eight at a time of texels of one number, and of three.
pub(super) const fn slack(taps: usize) -> usize {
    if taps.is_multiple_of(4) { 1 } else { 2 }
}

/// The sum of so many items by their weights: difference by difference from the one left of the middle.
#[inline(always)]
pub(super) fn weighted<X, const TAPS: usize>(
    item: impl Fn(usize) -> X,
    zero: X,
    weights: &[X; TAPS],
) -> X
where
    X: Copy + Add<Output = X> + Sub<Output = X> + Mul<Output = X>,
{
    let middle = TAPS / 2 - 1;
    let base = item(middle);
    let mut sum = zero;
    for (t, &weight) in weights.iter().enumerate() {
        if t != middle {
            sum = sum + weight * (item(t) - base);
        }
    }
    base + sum
}

/// The texel that a wide filter makes of a window whose texels have CHANNELS numbers, two to four.
#[inline(always)]
pub(super) fn texel_of<S: Simd, T: Texel, const TAPS: usize, const CHANNELS: usize>(
    simd: S,
    window: Window<'_, T>,
    across: &[T::Float; TAPS],
    down: &[T::Float; TAPS],
) -> Four<T, S> {
    const { assert!(TAPS <= 6 && CHANNELS <= 4) };
    let columns = columns::<S, T, TAPS, CHANNELS>(simd, window, down);
    let texels = if CHANNELS == 2 {
        [
            tap::<S, T, 0, 0>(&columns),
            tap::<S, T, 0, 2>(&columns),
            tap::<S, T, 0, 4>(&columns),
            tap::<S, T, 0, 6>(&columns),
            tap::<S, T, 1, 0>(&columns),
            tap::<S, T, 1, 2>(&columns),
        ]
    } else if CHANNELS == 3 {
        [
            tap::<S, T, 0, 0>(&columns),
            tap::<S, T, 0, 3>(&columns),
            tap::<S, T, 0, 6>(&columns),
            tap::<S, T, 1, 1>(&columns),
            tap::<S, T, 1, 4>(&columns),
            tap::<S, T, 1, 7>(&columns),
        ]
    } else {
        [
            tap::<S, T, 0, 0>(&columns),
            tap::<S, T, 0, 4>(&columns),
            tap::<S, T, 1, 0>(&columns),
            tap::<S, T, 1, 4>(&columns),
            tap::<S, T, 2, 0>(&columns),
            tap::<S, T, 2, 4>(&columns),
        ]
    };
    weighted(
        #[inline(always)]
        |t| texels[t],
        Four::<T, S>::splat(simd, T::Float::ZERO),
        &fours::<S, T, TAPS>(simd, across),
    )
}

/// Four numbers, from one on, of the texel that it makes of a window whose texels have more.
#[inline(always)]
pub(super) fn four_of<S: Simd, T: Texel, const TAPS: usize>(
    simd: S,
    window: Window<'_, T>,
    (channels, first): (usize, usize),
    [across, down]: [&[T::Float; TAPS]; 2],
) -> Four<T, S> {
    let zero = Four::<T, S>::splat(simd, T::Float::ZERO);
    let down = fours::<S, T, TAPS>(simd, down);
    weighted(
        #[inline(always)]
        |t| {
            weighted(
                #[inline(always)]
                |r| four::<S, T>(simd, window.row(r), t * channels + first),
                zero,
                &down,
            )
        },
        zero,
        &fours::<S, T, TAPS>(simd, across),
    )
}

/// Weights, each four times.
#[inline(always)]
fn fours<S: Simd, T: Texel, const TAPS: usize>(
    simd: S,
    weights: &[T::Float; TAPS],
) -> [Four<T, S>; TAPS] {
    let mut fours = [Four::<T, S>::splat(simd, T::Float::ZERO); TAPS];
    for (four, weight) in fours.iter_mut().zip(weights) {
        *four = Four::<T, S>::splat(simd, *weight);
    }
    fours
}

/// Four numbers from number FIRST of an eight on.
#[inline(always)]
fn tap<S: Simd, T: Texel, const EIGHT: usize, const FIRST: usize>(
    columns: &[Eight<T, S>; 3],
) -> Four<T, S> {
    let (here, next) = (columns[EIGHT], columns[(EIGHT + 1) % 3]);
    match FIRST {
        0 => here.split().0,
        4 => here.split().1,
        _ => here.slide::<FIRST>(next).split().0,
    }
}

/// The columns of a window of texels of one number: four at a time, of eight at most.
#[inline(always)]
pub(super) fn columns_of<S: Simd, T: Texel, const TAPS: usize>(
    simd: S,
    window: Window<'_, T>,
    down: &[T::Float; TAPS],
) -> [[T::Float; 4]; 2] {
    let [columns, _, _] = columns::<S, T, TAPS, 1>(simd, window, down);
    let (left, right) = columns.split();
    [left.to_array(), right.to_array()]
}

/// The sums of the numbers of a window down its rows. What comes behind the last one means nothing.
#[inline(always)]
fn columns<S: Simd, T: Texel, const TAPS: usize, const CHANNELS: usize>(
    simd: S,
    window: Window<'_, T>,
    down: &[T::Float; TAPS],
) -> [Eight<T, S>; 3] {
    let zero = Eight::<T, S>::splat(simd, T::Float::ZERO);
    let nothing = Four::<T, S>::splat(simd, T::Float::ZERO);
    let (mut weights, fours) = ([zero; TAPS], fours::<S, T, TAPS>(simd, down));
    for (weight, down) in weights.iter_mut().zip(down) {
        *weight = Eight::<T, S>::splat(simd, *down);
    }
    let mut columns = [zero; 3];
    for (group, columns) in columns.iter_mut().enumerate() {
        let first = 8 * group;
        let left = (TAPS * CHANNELS).saturating_sub(first);
        if left > 4 {
            *columns = weighted(
                #[inline(always)]
                |r| eight::<S, T>(simd, window.row(r), first),
                zero,
                &weights,
            );
        } else if left > 0 {
            let sums = weighted(
                #[inline(always)]
                |r| four::<S, T>(simd, window.row(r), first),
                nothing,
                &fours,
            );
            *columns = sums.combine(sums);
        }
    }
    columns
}

/// Four numbers of a row, or none where there are fewer.
#[inline(always)]
pub(super) fn four<S: Simd, T: Texel>(simd: S, row: &[T], first: usize) -> Four<T, S> {
    match row.get(first..).and_then(<[T]>::first_chunk) {
        Some(texels) => T::load_four(simd, texels),
        None => Four::<T, S>::splat(simd, T::Float::ZERO),
    }
}

/// Eight numbers of a row, or none where there are fewer.
#[inline(always)]
pub(super) fn eight<S: Simd, T: Texel>(simd: S, row: &[T], first: usize) -> Eight<T, S> {
    match row.get(first..).and_then(<[T]>::first_chunk) {
        Some(texels) => T::load_eight(simd, texels),
        None => Eight::<T, S>::splat(simd, T::Float::ZERO),
    }
}

/// What a wide filter makes of the columns of a window, those of one lane of many.
#[inline(always)]
pub(super) fn along<F: Scalar, const TAPS: usize, const N: usize>(
    across: [&[F]; TAPS],
    columns: &[[[F; 4]; N]; 2],
    k: usize,
) -> F {
    let mut weights = [F::ZERO; TAPS];
    for (weight, across) in weights.iter_mut().zip(across) {
        *weight = across[k];
    }
    weighted(
        #[inline(always)]
        |t| columns[t / 4][k][t % 4],
        F::ZERO,
        &weights,
    )
}
