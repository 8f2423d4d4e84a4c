//! What wide filters weigh texels with, found for many places before any texel is read.
//!
//! The weights are all that differs between filters of as many texels. Found apart, into memory, what reads texels is compiled
//! once for a number of texels and not for each filter: that is three megabytes, and the lookups take the same time.

use super::place::Places;
use super::spread::LANES;
use crate::kernel::tile::TILE;
use crate::kernel::{Scalar, vectorize};
use crate::resample::filters::claims::Kernel;

/// The most texels along a side of a window.
pub(super) const WIDEST: usize = 6;

/// Those of N places along an axis: of each texel of a window in a row.
pub(super) type Weights<F, const N: usize> = [[F; N]; WIDEST];

/// Finds those of as many places as there are lanes: of a whole tile in f64, 256 weights of Lanczos, the compiler makes none.
#[inline(always)]
pub(super) fn find_along<F: Scalar, K: Kernel<TAPS>, const TAPS: usize>(
    t: &[F; LANES],
    weights: &mut Weights<F, LANES>,
) {
    const { assert!(TAPS <= WIDEST) };
    for k in 0..LANES {
        for (weights, weight) in weights.iter_mut().zip(K::weights(t[k])) {
            weights[k] = weight;
        }
    }
}

/// Finds those of the first `count` places of a tile, along u and along v.
#[inline(never)]
pub(super) fn find<F: Scalar, K: Kernel<TAPS>, const TAPS: usize>(
    places: &Places<F>,
    count: usize,
    [across, down]: &mut [Weights<F, TILE>; 2],
) {
    vectorize(
        #[inline(always)]
        || {
            for (t, weights) in [(&places.tx, across), (&places.ty, down)] {
                let chunks = t.as_chunks::<LANES>().0.iter().enumerate();
                for (chunk, t) in chunks.take(count.div_ceil(LANES)) {
                    let mut own = [[F::ZERO; LANES]; WIDEST];
                    find_along::<F, K, TAPS>(t, &mut own);
                    for (row, own) in weights.iter_mut().zip(own).take(TAPS) {
                        row.as_chunks_mut().0[chunk] = own;
                    }
                }
            }
        },
    );
}
