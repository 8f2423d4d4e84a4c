//! What the slices hold that verbs take: numbers, arrays of numbers, or glam's vectors.
//!
//! Verbs compute on interleaved numbers. A slice of arrays is one of numbers already; glam promises no layout that safe code
//! could rely on, so its vectors pass through a tile of numbers, which stays in the first-level cache.

use crate::error::{Error, expect_length, expect_multiple};
use crate::kernel::Scalar;
use crate::kernel::threads;
use crate::kernel::tile::TILE;
use glam::{DVec2, DVec3, Vec2, Vec3};

/// The most numbers that a point has: those of a Jacobian.
const MOST: usize = 6;

mod sealed {
    pub trait Sealed {}
}

/// An element of the slices that the verbs of a [`Map`](crate::Map) take: a number, an array of numbers, or a vector of glam.
///
/// A slice of numbers holds points one after the other. All others hold a point an element.
pub trait Element: Copy + Send + Sync + sealed::Sealed {
    /// The float type.
    type Number: Scalar;

    /// How many numbers an element holds.
    const WIDTH: usize;

    /// Whether a slice of elements is one of numbers.
    #[doc(hidden)]
    const FLAT: bool = true;

    /// The numbers of a slice whose elements are [`Element::FLAT`].
    #[doc(hidden)]
    fn numbers(_: &[Self]) -> &[Self::Number] {
        &[]
    }

    /// The numbers of a slice whose elements are [`Element::FLAT`].
    #[doc(hidden)]
    fn numbers_mut(_: &mut [Self]) -> &mut [Self::Number] {
        &mut []
    }

    /// Writes the numbers of elements that are not [`Element::FLAT`].
    #[doc(hidden)]
    fn read(_: &[Self], _: &mut [Self::Number]) {}

    /// Makes elements that are not [`Element::FLAT`] of numbers.
    #[doc(hidden)]
    fn write(_: &mut [Self], _: &[Self::Number]) {}
}

macro_rules! flat {
    ($($t:ty, $number:ty, $width:literal: |$s:ident| $numbers:expr, $numbers_mut:expr;)+) => {$(
        impl sealed::Sealed for $t {}
        impl Element for $t {
            type Number = $number;
            const WIDTH: usize = $width;
            fn numbers($s: &[$t]) -> &[$number] {
                $numbers
            }
            fn numbers_mut($s: &mut [$t]) -> &mut [$number] {
                $numbers_mut
            }
        }
    )+};
}
flat! {
    f32, f32, 1: |s| s, s;
    f64, f64, 1: |s| s, s;
    [f32; 2], f32, 2: |s| s.as_flattened(), s.as_flattened_mut();
    [f64; 2], f64, 2: |s| s.as_flattened(), s.as_flattened_mut();
    [f32; 3], f32, 3: |s| s.as_flattened(), s.as_flattened_mut();
    [f64; 3], f64, 3: |s| s.as_flattened(), s.as_flattened_mut();
    [f32; 6], f32, 6: |s| s.as_flattened(), s.as_flattened_mut();
    [f64; 6], f64, 6: |s| s.as_flattened(), s.as_flattened_mut();
    [[f32; 2]; 3], f32, 6: |s| s.as_flattened().as_flattened(), s.as_flattened_mut().as_flattened_mut();
    [[f64; 2]; 3], f64, 6: |s| s.as_flattened().as_flattened(), s.as_flattened_mut().as_flattened_mut();
}

macro_rules! vectors {
    ($($t:ident, $number:ty, $width:literal;)+) => {$(
        impl sealed::Sealed for $t {}
        impl Element for $t {
            type Number = $number;
            const WIDTH: usize = $width;
            const FLAT: bool = false;
            fn read(vectors: &[$t], numbers: &mut [$number]) {
                for (vector, numbers) in vectors.iter().zip(numbers.as_chunks_mut().0) {
                    *numbers = vector.to_array();
                }
            }
            fn write(vectors: &mut [$t], numbers: &[$number]) {
                for (vector, numbers) in vectors.iter_mut().zip(numbers.as_chunks().0) {
                    *vector = $t::from_array(*numbers);
                }
            }
        }
    )+};
}
vectors! {
    Vec2, f32, 2;
    DVec2, f64, 2;
    Vec3, f32, 3;
    DVec3, f64, 3;
}

/// How many points of `width` numbers a slice holds.
pub(crate) fn points<E: Element>(
    name: &'static str,
    slice: &[E],
    width: usize,
) -> Result<usize, Error> {
    if E::WIDTH != 1 && E::WIDTH != width {
        return Err(Error::Width {
            name,
            expected: width,
            got: E::WIDTH,
        });
    }
    let numbers = slice.len() * E::WIDTH;
    expect_multiple(name, numbers, width)?;
    Ok(numbers / width)
}

/// An error if a slice does not hold so many points of `width` numbers.
pub(crate) fn expect_points<E: Element>(
    name: &'static str,
    slice: &[E],
    count: usize,
    width: usize,
) -> Result<(), Error> {
    points(name, slice, width)?;
    expect_length(name, slice.len() * E::WIDTH, count * width)
}

/// Calls `work` with the numbers of the points of `input` and what belongs to them in `output`: `each` items a point. The
/// lengths have been checked.
pub(crate) fn reading<E: Element, T: Send>(
    input: &[E],
    width: usize,
    output: &mut [T],
    each: usize,
    work: impl Fn(&[E::Number], &mut [T]) + Sync,
) {
    if E::FLAT {
        return work(E::numbers(input), output);
    }
    threads::blocks(input, 1, output, each, |input, output| {
        let mut numbers = [E::Number::default(); MOST * TILE];
        for (input, output) in input.chunks(TILE).zip(output.chunks_mut(each * TILE)) {
            let numbers = &mut numbers[..width * input.len()];
            E::read(input, numbers);
            work(numbers, output);
        }
    });
}

/// Calls `work` with the numbers of points and room for as many of `width` numbers, and puts these into `output`. The lengths
/// have been checked.
pub(crate) fn writing<A: Sync, E: Element>(
    input: &[A],
    each: usize,
    output: &mut [E],
    width: usize,
    work: impl Fn(&[A], &mut [E::Number]) + Sync,
) {
    if E::FLAT {
        return work(input, E::numbers_mut(output));
    }
    threads::blocks(input, each, output, 1, |input, output| {
        let mut numbers = [E::Number::default(); MOST * TILE];
        for (input, output) in input.chunks(each * TILE).zip(output.chunks_mut(TILE)) {
            let numbers = &mut numbers[..width * output.len()];
            work(input, numbers);
            E::write(output, numbers);
        }
    });
}
