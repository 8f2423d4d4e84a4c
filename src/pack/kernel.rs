//! Directions in, codes out, and back: the loops that every vectorized scheme shares.
//!
//! The organization is that of [`crate::kernel`]: chunks of 64 in rows of an aligned buffer, one plain loop, compiled for
//! each level, and a second copy without guards for chunks of normal numbers. What differs is the end
//! of it: a code is one unsigned word, u32 where a scheme computes in f32 and u64 in f64.
//!
//! Floats become integers by their bits: x + 1.5·2²³ holds x, rounded, in its low bits. `as i32`
//! saturates, which no instruction does, and kept the loop scalar.

use crate::kernel::tile::{Rows, SOURCE_AHEAD, TARGET_AHEAD, W, in_chunks, prefetch};
use crate::kernel::{Job, Scalar, all_normal, dispatch};
use crate::number::real::Real;
use crate::number::trace::Trace;
use std::ops::{BitAnd, BitOr, Shl, Shr, Sub};

/// A number that formulas of schemes are written in: a float, or one that records.
pub trait Lattice: Real {
    /// The integer nearest to `self`; even on ties.
    fn nearest(self) -> Self;

    /// Whether it is neither infinite nor NaN.
    fn finite(self) -> Self::Mask;
}

impl Lattice for Trace {
    fn nearest(self) -> Self {
        self.round()
    }

    // What is printed is for unit vectors.
    fn finite(self) -> Self::Mask {
        Self::truth(true)
    }
}

/// A float type that schemes compute in, and the word that holds their codes.
pub trait Cell: Scalar + Lattice {
    /// The unsigned word of its size.
    type Code: Copy
        + Default
        + PartialEq
        + Send
        + Sync
        + BitAnd<Output = Self::Code>
        + BitOr<Output = Self::Code>
        + Sub<Output = Self::Code>
        + Shl<u32, Output = Self::Code>
        + Shr<u32, Output = Self::Code>;

    /// The constant, or as much of it as the word holds.
    fn code(bits: u64) -> Self::Code;

    /// An integer with |self| ≤ 2²¹ (2⁵⁰) as a word, in two's complement.
    fn integer(self) -> Self::Code;

    /// The number that a word of two's complement holds, within ±2²¹ (2⁵⁰).
    fn from_integer(code: Self::Code) -> Self;

    /// The lowest `bits` bits as a number in two's complement.
    fn from_signed(code: Self::Code, bits: u32) -> Self;

    /// The word if the condition holds, else 0.
    fn only_if(ok: bool, code: Self::Code) -> Self::Code;
}

macro_rules! cell {
    ($t:ty, $code:ty, $signed:ty) => {
        impl Lattice for $t {
            #[inline(always)]
            fn nearest(self) -> $t {
                const MAGIC: $t = 1.5 / <$t>::EPSILON;
                (self + MAGIC) - MAGIC
            }

            #[inline(always)]
            fn finite(self) -> bool {
                self.abs() <= <$t>::MAX
            }
        }

        impl Cell for $t {
            type Code = $code;

            #[inline(always)]
            fn code(bits: u64) -> $code {
                bits as $code
            }

            #[inline(always)]
            fn integer(self) -> $code {
                const MAGIC: $t = 1.5 / <$t>::EPSILON;
                (self + MAGIC).to_bits().wrapping_sub(MAGIC.to_bits())
            }

            #[inline(always)]
            fn from_integer(code: $code) -> $t {
                const MAGIC: $t = 1.5 / <$t>::EPSILON;
                <$t>::from_bits(code.wrapping_add(MAGIC.to_bits())) - MAGIC
            }

            #[inline(always)]
            fn from_signed(code: $code, bits: u32) -> $t {
                // The sign bit, counted negative: an arithmetic shift of 64 bits is scalar below AVX-512.
                let sign = 1 << (bits - 1);
                let mask: $code = (sign << 1) - 1;
                Self::from_integer(((code & mask) ^ sign).wrapping_sub(sign))
            }

            #[inline(always)]
            fn only_if(ok: bool, code: $code) -> $code {
                if ok { code } else { 0 }
            }
        }
    };
}
cell!(f32, u32, i32);
cell!(f64, u64, i64);

/// See [`Real::half_turns`], where `Polynomials` is in scope too.
#[inline(always)]
pub fn half_turns<R: Real>(y: R, x: R) -> R {
    R::half_turns(y, x)
}

/// See [`Real::sin_cos_half_turns`].
#[inline(always)]
pub fn sin_cos_half_turns<R: Real>(r: R) -> (R, R) {
    R::sin_cos_half_turns(r)
}

/// The code of a direction.
pub trait Encode<R: Cell>: Copy + Send + Sync {
    /// The code, and whether the direction has one. NORMAL promises that every component is a number far
    /// from 0 and infinity.
    fn encode<const NORMAL: bool>(self, d: [R; 3]) -> (R::Code, bool);
}

/// The direction of a code.
pub trait Decode<R: Cell>: Copy + Send + Sync {
    /// A unit vector.
    fn decode(self, code: R::Code) -> [R; 3];
}

struct EncodeJob<'a, R: Cell, F> {
    scheme: F,
    directions: &'a [[[R; 3]; W]],
    codes: &'a mut [[R::Code; W]],
    scratch: &'a mut Rows<R, 3>,
}

impl<R: Cell, F: Encode<R>> Job for EncodeJob<'_, R, F> {
    type Output = bool;

    #[inline(always)]
    fn work(self) -> bool {
        let Self {
            scheme,
            directions,
            codes,
            scratch,
        } = self;
        let mut good = true;
        for (source, target) in directions.iter().zip(codes) {
            prefetch(source, SOURCE_AHEAD);
            prefetch(target, TARGET_AHEAD);
            good &= encode_chunk(scheme, source, target, scratch);
        }
        good
    }
}

#[inline(always)]
fn encode_chunk<R: Cell, F: Encode<R>>(
    scheme: F,
    source: &[[R; 3]; W],
    target: &mut [R::Code; W],
    scratch: &mut Rows<R, 3>,
) -> bool {
    let Rows(rows) = scratch;
    for i in 0..W {
        for k in 0..3 {
            rows[k][i] = source[i][k];
        }
    }
    if all_normal(rows) {
        let mut bad = R::Code::default();
        for i in 0..W {
            let (code, ok) = scheme.encode::<true>([rows[0][i], rows[1][i], rows[2][i]]);
            target[i] = code;
            bad = bad | R::only_if(!ok, R::code(1));
        }
        bad == R::Code::default()
    } else {
        let mut bad = R::Code::default();
        for i in 0..W {
            let (code, ok) = scheme.encode::<false>([rows[0][i], rows[1][i], rows[2][i]]);
            target[i] = code;
            bad = bad | R::only_if(!ok, R::code(1));
        }
        bad == R::Code::default()
    }
}

struct DecodeJob<'a, R: Cell, F> {
    scheme: F,
    codes: &'a [[R::Code; W]],
    directions: &'a mut [[[R; 3]; W]],
    scratch: &'a mut Rows<R, 3>,
}

impl<R: Cell, F: Decode<R>> Job for DecodeJob<'_, R, F> {
    type Output = ();

    #[inline(always)]
    fn work(self) {
        let Self {
            scheme,
            codes,
            directions,
            scratch,
        } = self;
        for (source, target) in codes.iter().zip(directions) {
            prefetch(source, SOURCE_AHEAD);
            prefetch(target, TARGET_AHEAD);
            decode_chunk(scheme, source, target, scratch);
        }
    }
}

#[inline(always)]
fn decode_chunk<R: Cell, F: Decode<R>>(
    scheme: F,
    source: &[R::Code; W],
    target: &mut [[R; 3]; W],
    scratch: &mut Rows<R, 3>,
) {
    let Rows(rows) = scratch;
    for i in 0..W {
        let d = scheme.decode(source[i]);
        for k in 0..3 {
            rows[k][i] = d[k];
        }
    }
    for i in 0..W {
        for k in 0..3 {
            target[i][k] = rows[k][i];
        }
    }
}

/// Codes of directions, three numbers each. False if one of them has none; its code is then 0.
pub fn encode<R: Cell, F: Encode<R>>(scheme: F, directions: &[R], codes: &mut [R::Code]) -> bool {
    let mut scratch = Rows([[R::default(); W]; 3]);
    let mut good = true;
    // Three ones are a direction of every scheme.
    let others = ([R::ONE; 3], R::Code::default());
    let directions = directions.as_chunks().0;
    in_chunks(directions, codes, others, |directions, codes| {
        good &= dispatch(EncodeJob {
            scheme,
            directions,
            codes,
            scratch: &mut scratch,
        });
    });
    good
}

/// Directions of codes.
pub fn decode<R: Cell, F: Decode<R>>(scheme: F, codes: &[R::Code], directions: &mut [R]) {
    let mut scratch = Rows([[R::default(); W]; 3]);
    let others = (R::Code::default(), [R::default(); 3]);
    let directions = directions.as_chunks_mut().0;
    in_chunks(codes, directions, others, |codes, directions| {
        dispatch(DecodeJob {
            scheme,
            codes,
            directions,
            scratch: &mut scratch,
        });
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_go_through_the_bits_and_back() {
        for k in [-32768_i64, -127, -1, 0, 1, 5, 65535, 1 << 20] {
            assert_eq!((k as f32).integer() as i32, k as i32);
            assert_eq!((k as f64).integer() as i64, k);
            assert_eq!(f32::from_integer(k as i32 as u32), k as f32);
            assert_eq!(f64::from_integer(k as u64), k as f64);
        }
        for k in -128..128_i64 {
            assert_eq!(f32::from_signed(k as u32 & 255, 8), k as f32);
            assert_eq!(f64::from_signed((k as u64 & 255) | 0xff00, 8), k as f64);
        }
        assert_eq!(f64::from_signed(1 << 31, 32), -(2f64.powi(31)));
    }
}
