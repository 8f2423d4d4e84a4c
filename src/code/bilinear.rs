//! Two by two texels about a place: which, and how much of each.
//!
//! The bilinear lookup of every sampler (OpenGL 4.6, section 8.14.2), with texels at centers, (i + ½)/n, or with the outer ones on
//! the edges, i/(n - 1). Takes a coordinate from 0 to 1; the texel before may have the number -1, and the next that behind the last. Singular: none.

use crate::map::Grid;
use crate::number::real::Real;

/// One coordinate of a lookup: the texel before it, and how far it is toward the next.
#[derive(Clone, Copy)]
pub struct Along<R> {
    /// The number of the texel.
    pub before: R,
    /// The part of the way to the next.
    pub part: R,
    /// The number of the last texel.
    pub last: R,
}

impl<R: Real> Along<R> {
    /// That of a coordinate from 0 to 1 among `count` texels; the outer ones may lie on the edges.
    pub fn new(x: R, count: R, on_edges: bool) -> Along<R> {
        let last = count - R::ONE;
        let place = if on_edges {
            x * last
        } else {
            x * count - R::HALF
        };
        let before = place.floor();
        Along {
            before,
            part: place - before,
            last,
        }
    }

    /// Both texels.
    pub fn both(self) -> [R; 2] {
        [self.before, self.before + R::ONE]
    }

    /// A number held to those of texels.
    pub fn held(self, i: R) -> R {
        let i = R::select(i.less(R::ZERO), R::ZERO, i);
        R::select(i.more(self.last), self.last, i)
    }
}

/// The weights of two by two texels, row by row.
pub fn weights<R: Real>(across: R, down: R) -> [R; 4] {
    let (before, above) = (R::ONE - across, R::ONE - down);
    [before * above, across * above, before * down, across * down]
}

/// Whether the outer texels lie on the edges along u and v.
pub fn on_edges(grid: Grid) -> [bool; 2] {
    [grid == Grid::Corners, grid != Grid::Centers]
}
