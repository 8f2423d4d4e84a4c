//! Between which levels of a mip chain a lookup lies.
//!
//! Graphics APIs have the level of detail λ = log₂ ρ, for a footprint that is ρ texels of the image long, and mix the levels
//! below and above it linearly in λ (Direct3D 11.3 functional specification, 7.18.11; OpenGL 4.6, 8.14): so do lookups that are
//! told a level or derivatives. Conversions, which nobody compares with a card's, mix linearly in the length, ρ/2ᵏ - 1 between levels k
//! and k + 1, without a logarithm; at whole levels both are the same, and between them no more than 0.086 of a level apart.

use crate::kernel::tile::{TILE, Tile};
use crate::kernel::vectorize;
use crate::number::real::max;
use std::f64::consts::{LN_2, SQRT_2};

/// A level, and how far a lookup is on its way to the next one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Between {
    pub(crate) level: usize,
    pub(crate) share: f64,
}

impl Between {
    /// By a length in texels of level 0: linear in it.
    pub(crate) fn by_length(mut length: f64, levels: usize) -> Between {
        let mut level = 0;
        while length >= 2.0 && level + 1 < levels {
            length *= 0.5;
            level += 1;
        }
        Between {
            level,
            share: (length - 1.0).clamp(0.0, 1.0),
        }
    }

    /// By a level of detail, which is no NaN: linear in it.
    pub(crate) fn by_lod(lod: f64, levels: usize) -> Between {
        let lod = lod.clamp(0.0, (levels - 1) as f64);
        let level = lod as usize;
        Between {
            level,
            share: lod - level as f64,
        }
    }

    /// By a length in texels of level 0: linear in its level of detail.
    pub(crate) fn by_lod_of_length(length: f64, levels: usize) -> Between {
        Between::by_lod(lod(length), levels)
    }
}

/// Writes the levels of detail of footprints with these sides, in texels of level 0, by the longer one: as many as there is room for. At a
/// singular place, where sides are no numbers, it is infinite.
pub(crate) fn lods_of_sides(Tile([ax, ay, bx, by]): &Tile<f64, 4>, out: &mut [f64]) {
    vectorize(
        #[inline(always)]
        || {
            for (k, out) in out.iter_mut().enumerate().take(TILE) {
                let (a, b) = (ax[k] * ax[k] + ay[k] * ay[k], bx[k] * bx[k] + by[k] * by[k]);
                let (a, b) = (a.sqrt(), b.sqrt());
                let is_number = !a.is_nan() & !b.is_nan();
                *out = lod(if is_number { max(a, b) } else { f64::INFINITY });
            }
        },
    );
}

/// log₂ of a length, but 0 below one texel: magnified, all is level 0.
///
/// Written out, because the math libraries of different systems round differently: log₂ m = 2/ln 2 · artanh((m - 1)/(m + 1))
/// for m between √½ and √2, where eleven terms leave 2e-17.
///
/// Without a branch, for lanes.
#[inline(always)]
pub(crate) fn lod(length: f64) -> f64 {
    /// 2⁵², whose last bit is 1.
    const WHOLE: u64 = 0x4330_0000_0000_0000;
    let bits = length.to_bits();
    let biased = f64::from_bits(WHOLE | (bits >> 52)) - f64::from_bits(WHOLE);
    let m = f64::from_bits((bits & ((1 << 52) - 1)) | (1023 << 52));
    let above = m > SQRT_2;
    let exponent = if above {
        biased - 1022.0
    } else {
        biased - 1023.0
    };
    let m = if above { m * 0.5 } else { m };
    let s = (m - 1.0) / (m + 1.0);
    let mut sum = 0.0;
    for k in (0..11).rev() {
        sum = sum * s * s + 1.0 / f64::from(2 * k + 1);
    }
    let lod = exponent + 2.0 / LN_2 * s * sum;
    let lod = if length <= 1.0 { 0.0 } else { lod };
    if length == f64::INFINITY { length } else { lod }
}

#[cfg(test)]
mod tests {
    use super::{Between, lod};

    #[test]
    fn logarithms_are_those_of_the_library() {
        for k in 0..20_000 {
            let x = 1.000_7_f64.powi(k);
            // Both round twice or thrice, at numbers up to 20.
            assert!((lod(x) - x.log2()).abs() < 1e-14, "{x}");
        }
        for k in 0..1024 {
            assert_eq!(lod(2.0_f64.powi(k)), f64::from(k));
        }
        assert_eq!(lod(f64::MAX).to_bits(), 1024.0_f64.to_bits());
        assert_eq!(lod(f64::INFINITY), f64::INFINITY);
        for x in [0.0, 1e-310, 0.3, 1.0] {
            assert_eq!(lod(x), 0.0);
        }
    }

    #[test]
    fn rules_agree_at_whole_levels_and_nearly_between() {
        for k in 0..=64 {
            let exact = f64::from(k) / 16.0;
            let (a, b) = (
                Between::by_length(2.0_f64.powf(exact), 8),
                Between::by_lod(exact, 8),
            );
            let place = |x: Between| x.level as f64 + x.share;
            // The most that t and log2(1 + t) differ.
            assert!((place(a) - place(b)).abs() < 0.0861, "{a:?} {b:?}");
        }
        assert_eq!(
            Between::by_lod(2.0, 3),
            Between {
                level: 2,
                share: 0.0
            }
        );
        assert_eq!(Between::by_lod(f64::INFINITY, 3), Between::by_lod(2.0, 3));
        assert_eq!(
            Between::by_lod(-7.0, 3),
            Between {
                level: 0,
                share: 0.0
            }
        );
        assert_eq!(
            Between::by_lod(1e9, 1),
            Between {
                level: 0,
                share: 0.0
            }
        );
    }
}
