//! Vectors of any length brought to length 1.

use super::kernel::Lattice;
use crate::number::real::max;

/// A vector of any length as one of length 1, and whether it has a direction.
#[inline(always)]
pub fn unit<R: Lattice, const NORMAL: bool>([x, y, z]: [R; 3]) -> ([R; 3], R::Mask) {
    let (mut x, mut y, mut z) = (x, y, z);
    if !NORMAL {
        let scale = max(x.abs(), max(y.abs(), z.abs())).binade_scale();
        (x, y, z) = (x * scale, y * scale, z * scale);
    }
    let length = (x * x + y * y + z * z).sqrt();
    let ok = R::truth(NORMAL) | (length.more(R::ZERO) & length.finite());
    let inverse = R::ONE / length;
    ([x * inverse, y * inverse, z * inverse], ok)
}
