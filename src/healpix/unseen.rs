//! Values that healpy marks as missing.

/// What healpy writes where a map has no value.
const UNSEEN: f64 = -1.6375e30;

/// Whether a value is healpy's mark, which went through float32 or not: healpy's own test.
#[inline(always)]
fn is_unseen(x: f64) -> bool {
    (x - UNSEEN).abs() <= -1e-5 * UNSEEN
}

macro_rules! unseen_to_nan {
    ($name:ident, $float:ty) => {
        /// Makes NaN of what healpy marks as unseen.
        pub fn $name(bytes: &mut [u8]) {
            for place in bytes.as_chunks_mut().0 {
                let x = <$float>::from_ne_bytes(*place);
                let x = if is_unseen(x.into()) {
                    <$float>::NAN
                } else {
                    x
                };
                *place = x.to_ne_bytes();
            }
        }
    };
}
unseen_to_nan!(unseen_to_nan_f32, f32);
unseen_to_nan!(unseen_to_nan_f64, f64);
