//! Bilinear: what lies between the four texels around a place.

use std::ops::{Add, Mul, Sub};

/// Between four corners, by one number or several at once.
#[inline(always)]
pub(super) fn mix<X>([a, b, c, d]: [X; 4], tx: X, ty: X) -> X
where
    X: Copy + Add<Output = X> + Sub<Output = X> + Mul<Output = X>,
{
    let above = a + tx * (b - a);
    let below = c + tx * (d - c);
    above + ty * (below - above)
}
