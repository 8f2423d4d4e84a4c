//! Where texels lie between the edges of a face.

use std::ops::Range;

/// Where texel centers lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Grid {
    /// (i + ½)/n: a texel is a small area.
    Centers,
    /// i/(n - 1): the first and last texel lie on the edges.
    Corners,
    /// Centers along u, corners along v: a row on each pole.
    CornersV,
}

impl Grid {
    /// All grids.
    pub const ALL: [Grid; 3] = [Grid::Centers, Grid::Corners, Grid::CornersV];

    /// The name that a grid is asked for by.
    ///
    /// ```
    /// assert_eq!(spheremap::Grid::CornersV.name(), "corners-v");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Grid::Centers => "centers",
            Grid::Corners => "corners",
            Grid::CornersV => "corners-v",
        }
    }

    /// The grids along u and v.
    pub(crate) fn axes(self, width: usize, height: usize) -> (GridAxis, GridAxis) {
        let axis = |corners, n| GridAxis { n, corners };
        match self {
            Grid::Centers => (axis(false, width), axis(false, height)),
            Grid::Corners => (axis(true, width), axis(true, height)),
            Grid::CornersV => (axis(false, width), axis(true, height)),
        }
    }
}

/// The grid along one side of a face.
#[derive(Clone, Copy, Debug)]
pub struct GridAxis {
    n: usize,
    corners: bool,
}

impl GridAxis {
    /// Whether the first and last texels' centers lie on the edges, so that these texels are cut in half.
    pub fn on_edges(self) -> bool {
        self.corners
    }

    /// The coordinate of texel i's center.
    pub fn center(self, i: f64) -> f64 {
        if self.corners {
            i / (self.n - 1) as f64
        } else {
            (i + 0.5) / self.n as f64
        }
    }

    /// The edges of texel i: halfway to its neighbors, within the image.
    pub fn cell(self, i: usize) -> (f64, f64) {
        if self.corners {
            let last = (self.n - 1) as f64;
            (
                ((i as f64 - 0.5) / last).max(0.0),
                ((i as f64 + 0.5) / last).min(1.0),
            )
        } else {
            (i as f64 / self.n as f64, (i + 1) as f64 / self.n as f64)
        }
    }

    /// Where some texels begin and, last, where they end.
    pub(crate) fn edges(self, texels: Range<usize>) -> Vec<f64> {
        let begin = self.cell(texels.start).0;
        let ends = texels.map(|i| self.cell(i).1);
        std::iter::once(begin).chain(ends).collect()
    }

    /// (scale, offset) of the texel index as a function of the coordinate.
    pub fn index(self) -> (f64, f64) {
        if self.corners {
            ((self.n - 1) as f64, 0.0)
        } else {
            (self.n as f64, -0.5)
        }
    }
}
