//! Maps whose columns are meridians and whose rows are parallels: where these lie.

use crate::map::Map;
use crate::number::angle;
use crate::projections::projection::one;
use crate::projections::projection::{Projection, Uv, Visitor};

struct Meridians;

impl Visitor for Meridians {
    type Output = Option<f64>;
    fn visit<P: Projection>(self, p: P) -> Option<f64> {
        p.graticule()
    }
}

struct Parallel(f64);

impl Visitor for Parallel {
    type Output = [f64; 2];
    fn visit<P: Projection>(self, p: P) -> [f64; 2] {
        let [x, y, z] = one::decode(p, Uv::flat(0.5, self.0));
        [y, angle::length(x, z)]
    }
}

struct Row([f64; 2]);

impl Visitor for Row {
    type Output = f64;
    fn visit<P: Projection>(self, p: P) -> f64 {
        let [y, flat] = self.0;
        one::encode(p, [0.0, y, flat]).v
    }
}

impl Map {
    /// Where columns are meridians and rows parallels about the view frame's y axis: the longitude of the right edge in half turns.
    pub(crate) fn meridians(&self) -> Option<f64> {
        self.visit_canonical(Meridians)
    }

    /// How far along the axis the parallel of such a map lies, and how far from it.
    pub(crate) fn parallel(&self, v: f64) -> [f64; 2] {
        self.visit_canonical(Parallel(v))
    }

    /// The v of a parallel that is as far along the axis and from it; NaN of one that the map does not hold.
    pub(crate) fn row_of(&self, parallel: [f64; 2]) -> f64 {
        self.visit_canonical(Row(parallel))
    }
}
