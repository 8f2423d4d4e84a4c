//! A mirror: r = 2(v·n)n - v for a unit normal n and the direction v from the surface to the eye. Divided by n·n
//! it holds for a normal of any length; |r| = |v|.

use crate::number::real::{Real, max};

/// What a view vector sees in a mirror of this normal.
#[inline(always)]
pub fn mirrored<R: Real>([x, y, z]: [R; 3], [a, b, c]: [R; 3]) -> [R; 3] {
    // The normal's length cancels; a power of two keeps its square in range.
    let scale = max(a.abs(), max(b.abs(), c.abs())).binade_scale();
    let (a, b, c) = (a * scale, b * scale, c * scale);
    let factor = R::TWO * (x * a + y * b + z * c) / (a * a + b * b + c * c);
    [factor * a - x, factor * b - y, factor * c - z]
}
