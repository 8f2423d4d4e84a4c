//! Where a target may be coarser than its source, told without slopes: by how far neighbors lie apart.

use crate::image::raster::{Block, Raster};
use crate::kernel::tile::{TILE, Tile};
use crate::kernel::{Scalar, vectorize};

/// Neighbors nearer than this, squared and in source texels, belong to texels of one lookup: well below the 1.66
/// at which a side gets a second one.
const NEAR: f64 = 1.5;

/// Whether any two neighbors of a block lie far apart in the source, or may; and which ones.
pub(super) fn coarse<R: Scalar>(
    source: &Raster,
    places: &Tile<R, 3>,
    block: &Block,
    far: &mut [bool; TILE],
) -> bool {
    let (columns, rows) = (block.columns, block.rows);
    if columns < 2 || rows < 2 {
        far.fill(true);
        return true;
    }
    let scale = [source.along_u.index().0, source.along_v.index().0].map(R::new);
    let count = (columns * rows).min(TILE);
    vectorize(
        #[inline(always)]
        || {
            let mut any = apart(places, [0, columns], count - columns, scale, far);
            for first in (0..count).step_by(columns) {
                let pairs = columns.min(count - first) - 1;
                any |= apart(places, [first, first + 1], pairs, scale, far);
            }
            any
        },
    )
}

/// Whether any of so many places lie far from others, which begin elsewhere in the tile. Both are marked.
#[inline(always)]
fn apart<R: Scalar>(
    Tile(places): &Tile<R, 3>,
    first: [usize; 2],
    count: usize,
    scale: [R; 2],
    far: &mut [bool; TILE],
) -> bool {
    let [[u, v, face], [p, q, other]] =
        first.map(|first| places.each_ref().map(|row| &row[first..first + count]));
    let near = R::new(NEAR);
    let (mut any, mut pairs) = (false, [false; TILE]);
    for (k, pair) in pairs[..count].iter_mut().enumerate() {
        let (x, y) = ((u[k] - p[k]) * scale[0], (v[k] - q[k]) * scale[1]);
        let together = (x * x + y * y <= near) & (face[k] == other[k]);
        *pair = !(together | (u[k].is_nan() & p[k].is_nan()));
        any |= *pair;
    }
    if any {
        for first in first {
            for (far, pair) in far[first..].iter_mut().zip(&pairs[..count]) {
                *far |= *pair;
            }
        }
    }
    any
}
