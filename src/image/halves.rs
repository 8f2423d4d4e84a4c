//! Halves, the numbers of float16 texels: read and written one by one and by four.
//!
//! Reading is exact, and writing rounds to the nearest half, to the even one of two: IEEE 754-2008. A NaN stays one, quiet, with as much
//! of its payload as fits, as F16C has it. CPUs that have this instruction set (all with AVX2) convert four at once; the others do
//! the same in integers, to the same bits. No number on the way is subnormal but where the result does not
//! depend on it: whatever the process does with those, it changes nothing.
//!
//! `half` branches in its conversions, and where a loop has branches inline LLVM's vectorizer (22.1, `vputils::isSingleScalar`)
//! asks of each number what it asked of those that it is made of, again for each way there: the release build did not end, now with
//! one change of unrelated code, now with another. So what reads one has no branch, and what writes one is called.

use crate::image::texel::{Texel, joined, narrow_u16, parted, widen_u16};
use fearless_simd::{
    Bytes, Select, Simd, SimdBase, SimdCombine, SimdCvtFloat, SimdInto, f32x4, f32x8, i32x4, u32x4,
};
use half::f16;

/// What exponents of f32 are more than those of halves.
const REBIAS: u32 = (127 - 15) << 23;

/// The magnitude of infinity, and of what NaN is beyond.
const INFINITE: u32 = 0x7c00;

/// That of the smallest half that is not subnormal.
const NORMAL: u32 = 0x0400;

/// The bit of f32 that makes a NaN quiet.
const QUIET: u32 = 1 << 22;

impl Texel for f16 {
    type Float = f32;
    const NOTHING: f64 = f64::NAN;
    const NAME: &'static str = "float16";
    const BY_FOURS: bool = true;
    fn fits(_: f64) -> bool {
        true
    }
    #[inline(always)]
    fn load(self) -> f32 {
        to_f32(self)
    }
    #[inline(always)]
    fn load_four<S: Simd>(simd: S, texels: &[f16; 4]) -> f32x4<S> {
        to_four(simd, texels)
    }
    #[inline(always)]
    fn load_eight<S: Simd>(simd: S, texels: &[f16; 8]) -> f32x8<S> {
        let [a, b, c, d, e, f, g, h] = *texels;
        to_four(simd, &[a, b, c, d]).combine(to_four(simd, &[e, f, g, h]))
    }
    #[inline(always)]
    fn store(x: f32) -> f16 {
        from_f32(x)
    }
    #[inline(always)]
    fn store_four<S: Simd>(simd: S, numbers: f32x4<S>) -> [f16; 4] {
        from_four(simd, numbers)
    }
    #[inline(never)]
    fn from_f64(x: f64) -> f16 {
        f16::from_f64(x)
    }
}

/// The value of a half.
#[inline(always)]
fn to_f32(x: f16) -> f32 {
    let bits = u32::from(x.to_bits());
    let (sign, rest) = ((bits & 0x8000) << 16, bits & 0x7fff);
    let normal = (rest << 13) + REBIAS;
    let small = (rest as f32 * SMALLEST).to_bits();
    // The largest exponent is that of infinity and NaN, and is the largest of f32.
    let infinite = normal + REBIAS;
    let quiet = if rest > INFINITE { QUIET } else { 0 };
    let finite = if rest < NORMAL { small } else { normal };
    let found = if rest < INFINITE {
        finite
    } else {
        infinite | quiet
    };
    f32::from_bits(found | sign)
}

/// The smallest half above 0.
const SMALLEST: f32 = f32::from_bits((127 - 24) << 23);

/// The half nearest to a number.
#[inline(never)]
fn from_f32(x: f32) -> f16 {
    f16::from_f32(x)
}

/// The values of four.
#[inline(always)]
fn to_four<S: Simd>(simd: S, halves: &[f16; 4]) -> f32x4<S> {
    let bits = halves.map(f16::to_bits);
    #[cfg(target_arch = "x86_64")]
    if let Some(avx2) = simd.level().as_avx2() {
        return f16c::widen(avx2, joined(bits) as i64).simd_into(simd);
    }
    widen(simd, bits)
}

/// The halves nearest to four numbers.
#[inline(always)]
fn from_four<S: Simd>(simd: S, numbers: f32x4<S>) -> [f16; 4] {
    #[cfg(target_arch = "x86_64")]
    if let Some(avx2) = simd.level().as_avx2() {
        return parted(f16c::narrow(avx2, numbers.into()) as u64).map(f16::from_bits);
    }
    narrow(simd, numbers).map(f16::from_bits)
}

/// As [`to_f32`] does it.
#[inline(always)]
fn widen<S: Simd>(simd: S, halves: [u16; 4]) -> f32x4<S> {
    let word = |x: u32| u32x4::splat(simd, x);
    let signed = |x: u32| i32x4::splat(simd, x as i32);
    let bits = widen_u16(simd, halves);
    let rest = bits & word(0x7fff);
    let magnitude: i32x4<S> = rest.bitcast();
    let small = f32x4::float_from(magnitude) * f32x4::splat(simd, SMALLEST);
    let normal = (rest << 13) + word(REBIAS);
    let quiet = magnitude
        .simd_gt(signed(INFINITE))
        .select(word(QUIET), word(0));
    let infinite = (normal + word(REBIAS)) | quiet;
    let finite = magnitude
        .simd_lt(signed(NORMAL))
        .select(small.bitcast(), normal);
    let found = magnitude.simd_lt(signed(INFINITE)).select(finite, infinite);
    (found | (bits & word(0x8000)) << 16).bitcast()
}

/// Rounds by sums: where the last bit that is kept is odd, half of its unit is added, otherwise less than that.
#[inline(always)]
fn narrow<S: Simd>(simd: S, numbers: f32x4<S>) -> [u16; 4] {
    let word = |x: u32| u32x4::splat(simd, x);
    let signed = |x: u32| i32x4::splat(simd, x as i32);
    let bits: u32x4<S> = numbers.bitcast();
    let rest = bits & word(0x7fff_ffff);
    let magnitude: i32x4<S> = rest.bitcast();
    let odd = (rest >> 13) & word(1);
    let normal = (rest - word(REBIAS) + word(0xfff) + odd) >> 13;
    // The last bit of ½ is the smallest half.
    let half = f32x4::splat(simd, 0.5);
    let moved: f32x4<S> = rest.bitcast();
    let small = (moved + half).bitcast::<u32x4<S>>() - word(0.5_f32.to_bits());
    let payload = word(0x7e00) | ((rest >> 13) & word(0x03ff));
    let infinite = magnitude
        .simd_gt(signed(f32::INFINITY.to_bits()))
        .select(payload, word(INFINITE));
    let finite = magnitude
        .simd_lt(signed(REBIAS + (1 << 23)))
        .select(small, normal);
    // 2¹⁶ and beyond; what rounds to it has become infinite already.
    let found = magnitude
        .simd_lt(signed(REBIAS + (31 << 23)))
        .select(finite, infinite);
    narrow_u16(simd, found | (bits >> 16) & word(0x8000))
}

#[cfg(target_arch = "x86_64")]
mod f16c {
    use fearless_simd::kernel;
    use std::arch::x86_64::{
        __m128, _MM_FROUND_TO_NEAREST_INT, _mm_cvtph_ps, _mm_cvtps_ph, _mm_cvtsi64_si128,
        _mm_cvtsi128_si64,
    };

    kernel!(
        #[inline]
        pub(super) fn widen(avx2: Avx2, halves: i64) -> __m128 {
            _mm_cvtph_ps(_mm_cvtsi64_si128(halves))
        }
    );

    kernel!(
        #[inline]
        pub(super) fn narrow(avx2: Avx2, numbers: __m128) -> i64 {
            _mm_cvtsi128_si64(_mm_cvtps_ph::<_MM_FROUND_TO_NEAREST_INT>(numbers))
        }
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::{SimdWork, run_baseline, run_simd};
    use proptest::prelude::*;

    #[test]
    fn every_half_is_read_as_the_number_it_is() {
        for bits in 0..=u16::MAX {
            let half = f16::from_bits(bits);
            let (got, want) = (to_f32(half), half.to_f32());
            assert!(
                got.to_bits() == want.to_bits() || got.is_nan() && want.is_nan(),
                "{bits:#x}: {got} is not {want}"
            );
        }
    }

    struct Four<'a>([f32; 4], [f16; 4], &'a mut ([u32; 4], [u16; 4]));

    impl SimdWork for Four<'_> {
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) {
            let Four(numbers, halves, made) = self;
            made.0 = to_four(simd, &halves).to_array().map(f32::to_bits);
            made.1 = from_four(simd, f32x4::load_array(simd, numbers)).map(f16::to_bits);
        }
    }

    fn check(numbers: [f32; 4], halves: [f16; 4]) {
        let wanted = (
            halves.map(|x| to_f32(x).to_bits()),
            numbers.map(|x| from_f32(x).to_bits()),
        );
        for best in [true, false] {
            let mut made = ([0; 4], [0; 4]);
            let work = Four(numbers, halves, &mut made);
            if best {
                run_simd(work);
            } else {
                run_baseline(work);
            }
            assert_eq!(made, wanted, "{numbers:?} {halves:?}");
        }
    }

    #[test]
    fn four_are_four_times_one_for_every_half_and_beside_each_tie() {
        for bits in 0..=u16::MAX {
            let half = f16::from_bits(bits);
            let next = f16::from_bits(bits.wrapping_add(1));
            let x = to_f32(half).to_bits();
            // Exact: two halves that follow each other are as far from their middle as a bit of f32 below their last.
            let middle = f32::midpoint(to_f32(half), to_f32(next)).to_bits();
            let numbers = [x, middle, middle.wrapping_sub(1), middle.wrapping_add(1)];
            check(numbers.map(f32::from_bits), [half; 4]);
            let numbers = [x + 1, x.wrapping_sub(1), x ^ 0x1000, !x];
            check(numbers.map(f32::from_bits), [half, next, next, half]);
        }
    }

    proptest! {
        #[test]
        fn four_are_four_times_one(numbers: [u32; 4], halves: [u16; 4]) {
            check(numbers.map(f32::from_bits), halves.map(f16::from_bits));
        }
    }
}
