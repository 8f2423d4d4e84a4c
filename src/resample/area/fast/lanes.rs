//! Eight cells side by side: how many, and their numbers in memory.

use fearless_simd::{Simd, SimdBase, f64x8};

/// Cells side by side.
pub(in crate::resample::area) const LANES: usize = 8;

/// A number of each cell.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(in crate::resample::area) struct Lanes(pub [f64; LANES]);

impl Lanes {
    #[inline(always)]
    pub(in crate::resample::area) fn load<S: Simd>(&self, simd: S) -> f64x8<S> {
        f64x8::load_array_ref(simd, &self.0)
    }
}

/// Eight numbers of a row.
#[inline(always)]
pub(in crate::resample::area) fn load<S: Simd>(simd: S, row: &[f64], first: usize) -> f64x8<S> {
    f64x8::from_slice(simd, &row[first..][..LANES])
}
