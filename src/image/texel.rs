//! Texel types: what arrays hold, and the floats that filters compute in.

use crate::kernel::Scalar;
use fearless_simd::{
    Bytes, Select, Simd, SimdBase, SimdCombine, SimdCvtFloat, f32x4, f32x8, f64x4, f64x8, i32x4,
    i32x8, u8x16, u16x8, u32x4, u64x2,
};
use half::f16;

/// A texel type. Filters run in `Float` and round once.
pub trait Texel: Copy + std::fmt::Debug + Default + Send + Sync + Filtered<Self> + 'static {
    /// What filters compute in.
    type Float: Scalar + Texel<Float = Self::Float> + Filtered<Self>;
    /// The value.
    fn load(self) -> Self::Float;
    /// Those of four texels.
    #[inline(always)]
    fn load_four<S: Simd>(simd: S, texels: &[Self; 4]) -> Four<Self, S> {
        Four::<Self, S>::load_array(simd, texels.map(Self::load))
    }
    /// Those of eight.
    fn load_eight<S: Simd>(simd: S, texels: &[Self; 8]) -> Eight<Self, S>;
    /// Whether several are converted together in less time than the same number one by one.
    const BY_FOURS: bool = false;
    /// The nearest texel; integers saturate, and NaN is 0 there.
    fn store(x: Self::Float) -> Self;
    /// Those of four numbers.
    #[inline(always)]
    fn store_four<S: Simd>(_: S, numbers: Four<Self, S>) -> [Self; 4] {
        numbers.to_array().map(Self::store)
    }
    /// The texel for a number of the caller's.
    fn from_f64(x: f64) -> Self;
    /// What stands for "nothing": NaN, or 0 where there is none.
    const NOTHING: f64;
    /// Its name, as NumPy has it.
    const NAME: &'static str;
    /// Whether a number of the caller's is within its range.
    fn fits(x: f64) -> bool;
}

/// Four numbers as filters of texels of type T compute them.
pub type Four<T, S> = <<T as Texel>::Float as Scalar>::Four<S>;

/// Eight of them.
pub type Eight<T, S> = <<T as Texel>::Float as Scalar>::Eight<S>;

/// What lookups among texels of type T are stored as: T itself, or the float that they are filtered in where
/// more is to be done with them before they are rounded.
pub trait Filtered<T: Texel>: Copy + Default + Send + Sync {
    /// A texel as it is.
    fn exact(texel: T) -> Self;
    /// A filtered value.
    fn filtered(x: T::Float) -> Self;
    /// Four of them.
    #[inline(always)]
    fn filtered_four<S: Simd>(_: S, numbers: Four<T, S>) -> [Self; 4] {
        numbers.to_array().map(Self::filtered)
    }
}

impl<T: Texel> Filtered<T> for T {
    #[inline(always)]
    fn exact(texel: T) -> T {
        texel
    }
    #[inline(always)]
    fn filtered(x: T::Float) -> T {
        T::store(x)
    }
    #[inline(always)]
    fn filtered_four<S: Simd>(simd: S, numbers: Four<T, S>) -> [T; 4] {
        T::store_four(simd, numbers)
    }
}

macro_rules! filtered_as_f32 {
    ($($t:ty),+) => {
        $(
            impl Filtered<$t> for f32 {
                #[inline(always)]
                fn exact(texel: $t) -> f32 {
                    texel.load()
                }
                #[inline(always)]
                fn filtered(x: f32) -> f32 {
                    x
                }
            }
        )+
    };
}
filtered_as_f32!(u8, u16, f16);

macro_rules! integer_texel {
    ($t:ty, $name:literal, $widen:ident, $widen_eight:ident, $narrow:ident) => {
        impl Texel for $t {
            type Float = f32;
            const NOTHING: f64 = 0.0;
            const NAME: &'static str = $name;
            fn fits(x: f64) -> bool {
                (0.0..=f64::from(<$t>::MAX)).contains(&x)
            }
            #[inline(always)]
            fn load(self) -> f32 {
                self as f32
            }
            #[inline(always)]
            fn load_four<S: Simd>(simd: S, texels: &[$t; 4]) -> f32x4<S> {
                f32x4::float_from($widen(simd, *texels).bitcast::<i32x4<S>>())
            }
            #[inline(always)]
            fn load_eight<S: Simd>(simd: S, texels: &[$t; 8]) -> f32x8<S> {
                let [low, high] = $widen_eight(simd, *texels);
                f32x8::float_from(low.combine(high).bitcast::<i32x8<S>>())
            }
            #[inline(always)]
            fn store(x: f32) -> $t {
                // NaN goes to 0 with the negative ones. The sum leaves the nearest integer in its last
                // bits; `as` would check the range again, number by number.
                const LARGEST: f32 = <$t>::MAX as f32;
                let x = if x > 0.0 { x } else { 0.0 };
                let x = if x < LARGEST { x } else { LARGEST };
                (x + MAGIC).to_bits() as $t
            }
            #[inline(always)]
            fn store_four<S: Simd>(simd: S, x: f32x4<S>) -> [$t; 4] {
                let number = |x| f32x4::splat(simd, x);
                let (zero, largest) = (number(0.0), number(<$t>::MAX as f32));
                let x = x.simd_gt(zero).select(x, zero);
                let x = x.simd_lt(largest).select(x, largest);
                $narrow(simd, (x + number(MAGIC)).bitcast())
            }
            fn from_f64(x: f64) -> $t {
                x.round_ties_even() as $t
            }
        }
    };
}
integer_texel!(u8, "uint8", widen_u8, widen_eight_u8, narrow_u8);
integer_texel!(u16, "uint16", widen_u16, widen_eight_u16, narrow_u16);

/// What leaves the nearest integer of a small number in the last bits of their sum.
const MAGIC: f32 = 8_388_608.0;

/// Four bytes as words. Of four conversions one by one the compiler made no better.
#[inline(always)]
fn widen_u8<S: Simd>(simd: S, bytes: [u8; 4]) -> u32x4<S> {
    let bytes: u8x16<S> = u32x4::splat(simd, u32::from_ne_bytes(bytes)).bitcast();
    let zero = u8x16::splat(simd, 0);
    let halves: u16x8<S> = simd.zip_low_u8x16(bytes, zero).bitcast();
    simd.zip_low_u16x8(halves, zero.bitcast()).bitcast()
}

/// Eight bytes as words.
#[inline(always)]
fn widen_eight_u8<S: Simd>(simd: S, bytes: [u8; 8]) -> [u32x4<S>; 2] {
    let bytes: u8x16<S> = u64x2::splat(simd, u64::from_ne_bytes(bytes)).bitcast();
    let zero = u8x16::splat(simd, 0);
    widened(simd, simd.zip_low_u8x16(bytes, zero).bitcast())
}

/// The lowest bytes of four words.
#[inline(always)]
fn narrow_u8<S: Simd>(simd: S, words: u32x4<S>) -> [u8; 4] {
    let bytes: u8x16<S> = words.bitcast();
    let pairs = simd.unzip_low_u8x16(bytes, bytes);
    let lowest: u32x4<S> = simd.unzip_low_u8x16(pairs, pairs).bitcast();
    lowest.to_array()[0].to_ne_bytes()
}

/// Four halves as words.
#[inline(always)]
pub(super) fn widen_u16<S: Simd>(simd: S, halves: [u16; 4]) -> u32x4<S> {
    // One load: put together from four it took as long as the filter.
    let halves: u16x8<S> = u64x2::splat(simd, joined(halves)).bitcast();
    simd.zip_low_u16x8(halves, u16x8::splat(simd, 0)).bitcast()
}

/// Eight halves as words.
#[inline(always)]
fn widen_eight_u16<S: Simd>(simd: S, halves: [u16; 8]) -> [u32x4<S>; 2] {
    widened(simd, u16x8::load_array(simd, halves))
}

#[inline(always)]
fn widened<S: Simd>(simd: S, halves: u16x8<S>) -> [u32x4<S>; 2] {
    let zero = u16x8::splat(simd, 0);
    [
        simd.zip_low_u16x8(halves, zero).bitcast(),
        simd.zip_high_u16x8(halves, zero).bitcast(),
    ]
}

/// The lower halves of four words.
#[inline(always)]
pub(super) fn narrow_u16<S: Simd>(simd: S, words: u32x4<S>) -> [u16; 4] {
    let halves: u16x8<S> = words.bitcast();
    let lower: u64x2<S> = simd.unzip_low_u16x8(halves, halves).bitcast();
    parted(lower.to_array()[0])
}

/// Four halves as one word, the first one lowest.
#[inline(always)]
pub(super) fn joined(halves: [u16; 4]) -> u64 {
    let [a, b, c, d] = halves.map(u64::from);
    a | b << 16 | c << 32 | d << 48
}

/// The halves that a word was joined of.
#[inline(always)]
pub(super) fn parted(word: u64) -> [u16; 4] {
    [0, 16, 32, 48].map(|shift| (word >> shift) as u16)
}

macro_rules! float_texel {
    ($t:ident, $name:literal, $four:ident, $eight:ident) => {
        impl Texel for $t {
            type Float = $t;
            const NOTHING: f64 = f64::NAN;
            const NAME: &'static str = $name;
            fn fits(_: f64) -> bool {
                true
            }
            #[inline(always)]
            fn load(self) -> $t {
                self
            }
            #[inline(always)]
            fn load_four<S: Simd>(simd: S, texels: &[$t; 4]) -> Four<$t, S> {
                // As they are: through an array the compiler loads them one by one.
                $four::load_array_ref(simd, texels)
            }
            #[inline(always)]
            fn load_eight<S: Simd>(simd: S, texels: &[$t; 8]) -> Eight<$t, S> {
                $eight::load_array_ref(simd, texels)
            }
            #[inline(always)]
            fn store(x: $t) -> $t {
                x
            }
            fn from_f64(x: f64) -> $t {
                x as $t
            }
        }
    };
}
float_texel!(f32, "float32", f32x4, f32x8);
float_texel!(f64, "float64", f64x4, f64x8);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::{SimdWork, run_baseline, run_simd};

    /// Four numbers as texels, and these as numbers, side by side: four, and twice four.
    struct Both<'a, T>([f32; 4], &'a mut [T; 4], &'a mut [[f32; 4]; 3]);

    impl<T: Texel<Float = f32>> SimdWork for Both<'_, T> {
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) {
            let Both(numbers, texels, loaded) = self;
            *texels = T::store_four(simd, Four::<T, S>::load_array(simd, numbers));
            let [a, b, c, d] = *texels;
            let eight = T::load_eight(simd, &[a, b, c, d, d, c, b, a]).to_array();
            let (four, [e, f, g, h, i, j, k, l]) = (T::load_four(simd, texels), eight);
            *loaded = [four.to_array(), [e, f, g, h], [i, j, k, l]];
        }
    }

    fn four_are_four_times_one<T: Texel<Float = f32> + PartialEq + std::fmt::Debug>(most: f32) {
        let hard = [
            f32::NAN,
            -0.0,
            f32::INFINITY,
            f32::NEG_INFINITY,
            -1e-30,
            -1.5,
            1e30,
            most,
        ];
        let some = (0..4 * 512).map(|k| k as f32 * (most + 2.0) / 2040.5);
        let halves = [
            0.5,
            1.5,
            2.5,
            most - 0.5,
            most - 1.5,
            most + 0.25,
            most + 0.5,
            127.5,
        ];
        let all: Vec<f32> = hard.into_iter().chain(halves).chain(some).collect();
        for numbers in all.as_chunks::<4>().0 {
            let (mut texels, mut loaded) = ([T::default(); 4], [[0.0; 4]; 3]);
            for best in [true, false] {
                let both = Both(*numbers, &mut texels, &mut loaded);
                if best {
                    run_simd(both);
                } else {
                    run_baseline(both);
                }
                assert_eq!(texels, numbers.map(T::store), "{numbers:?}");
                let [a, b, c, d] = texels.map(T::load);
                assert_eq!(loaded, [[a, b, c, d], [a, b, c, d], [d, c, b, a]]);
            }
        }
    }

    #[test]
    fn four_integers_are_stored_and_loaded_as_one_is() {
        four_are_four_times_one::<u8>(255.0);
        four_are_four_times_one::<u16>(65535.0);
    }
}
