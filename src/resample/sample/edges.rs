//! Bilinear lookups across the edges and corners of faces.
//!
//! The texels of two faces that meet at an edge are not opposite each other: seen from one face, the
//! neighbor's spacing widens toward the corner, by up to half a texel. So between the last row of
//! centers and the edge the value runs linearly from the row to the edge itself, and the edge has a value
//! that both faces compute alike:
//!
//! - on the edge, the mean of the two rows next to it, each read at the place from which the edge point lies
//!   halfway to its mirror image in the other row;
//! - at the corner, the mean of the three, four or five texels that meet there; between the corner and the last center
//!   along an edge, linear.
//!
//! Where a mirror image lies is the projection's to say ([`Projection::beside`], [`Projection::across`]).
//!
//! That is continuous over every edge, of second order in the texel size, and all its weights are positive, so
//! it never overshoots. What did not help: reading the neighbor's texel of the same number (continuous, as
//! graphics hardware does it, but of first order), and continuing the face's plane into its neighbor
//! (second order, but the two faces disagreed on the edge).

use super::taps::Taps;
use crate::image::raster::Raster;
use crate::map::Map;
use crate::projections::projection::Visitor;
use crate::projections::projection::{Edge, Projection, Uv};

/// An icosahedron's. What crosses sides forever is stopped there.
const MOST_FACES_AT_A_CORNER: usize = 5;

/// The geometry that edges need.
pub(crate) struct FaceEdge<'a> {
    pub(crate) raster: &'a Raster,
    pub(crate) map: &'a Map,
}

/// A side of a face: which axis it is an end of, and which end.
#[derive(Clone, Copy)]
struct Side {
    axis: usize,
    high: bool,
}

impl FaceEdge<'_> {
    /// Adds what stands for a place, in texels, that may lie outside the square of texel centers.
    pub(crate) fn resolve(&self, taps: &mut Taps, face: usize, place: [f64; 2], weight: f64) {
        let last = (self.raster.width - 1) as f64;
        let within = place.map(|x| x.clamp(0.0, last));
        // How far from the last row of centers toward the edge, 1 on the edge itself.
        let depth = [0, 1].map(|k| ((place[k] - within[k]).abs() * 2.0).min(1.0));
        let side = |axis: usize| Side {
            axis,
            high: place[axis] > within[axis],
        };
        let [s, t] = depth;
        match (s > 0.0, t > 0.0) {
            (false, false) => self.inside(taps, face, within, weight),
            (true, false) => {
                self.inside(taps, face, within, weight * (1.0 - s));
                self.on_edge(taps, face, side(0), within[1], weight * s);
            }
            (false, true) => {
                self.inside(taps, face, within, weight * (1.0 - t));
                self.on_edge(taps, face, side(1), within[0], weight * t);
            }
            (true, true) => {
                self.inside(taps, face, within, weight * (1.0 - s) * (1.0 - t));
                self.on_edge(taps, face, side(0), within[1], weight * s * (1.0 - t));
                self.on_edge(taps, face, side(1), within[0], weight * (1.0 - s) * t);
                self.corner(taps, face, [side(0), side(1)], weight * s * t);
            }
        }
    }

    /// Adds the texels around a place within the square of centers.
    fn inside(&self, taps: &mut Taps, face: usize, [x, y]: [f64; 2], weight: f64) {
        let last = self.raster.width - 1;
        let (i, j) = (x.floor() as usize, y.floor() as usize);
        let (tx, ty) = (x - x.floor(), y - y.floor());
        let view = self.raster.view(face);
        let (i1, j1) = ((i + 1).min(last), (j + 1).min(last));
        taps.push(view.index(i, j), weight * (1.0 - tx) * (1.0 - ty));
        taps.push(view.index(i1, j), weight * tx * (1.0 - ty));
        taps.push(view.index(i, j1), weight * (1.0 - tx) * ty);
        taps.push(view.index(i1, j1), weight * tx * ty);
    }

    /// Half a texel, in a face's coordinate from -1 to 1.
    fn half_texel(&self) -> f64 {
        1.0 / self.raster.width as f64
    }

    /// Adds the value of a side at `along`, in texels.
    fn on_edge(&self, taps: &mut Taps, face: usize, side: Side, along: f64, weight: f64) {
        let n = self.raster.width as f64;
        let along = (2.0 * along + 1.0) / n - 1.0;
        let along =
            self.map
                .visit_canonical(Beside(self.edge(face, side), along, self.half_texel()));
        let row = ((along + 1.0) * n - 1.0) * 0.5;
        let mut own = [row; 2];
        own[side.axis] = if side.high { n - 1.0 } else { 0.0 };
        self.inside(taps, face, own.map(|x| x.clamp(0.0, n - 1.0)), 0.5 * weight);
        let (face, place) = self.across(face, side, along);
        self.inside(taps, face, place, 0.5 * weight);
    }

    fn edge(&self, face: usize, side: Side) -> Edge {
        Edge {
            face: face as f64,
            axis: side.axis,
            high: side.high,
        }
    }

    /// The place on the neighbor's first row that mirrors the one at `along` on the last row over a side.
    fn across(&self, face: usize, side: Side, along: f64) -> (usize, [f64; 2]) {
        let n = self.raster.width as f64;
        let across = Across(self.edge(face, side), along, self.half_texel());
        let there = self.map.visit_canonical(across);
        let place = [there.u, there.v].map(|x| (x * n - 0.5).clamp(0.0, n - 1.0));
        (there.face as usize, place)
    }

    /// Adds the mean of the texels at a corner, one of each face that meets there.
    fn corner(&self, taps: &mut Taps, face: usize, sides: [Side; 2], weight: f64) {
        let around = self.around(face, sides);
        for (face, [right, bottom]) in &around {
            let end = |high: bool| {
                if high {
                    (self.raster.width - 1) as f64
                } else {
                    0.0
                }
            };
            let place = [end(*right), end(*bottom)];
            self.inside(taps, *face, place, weight / around.len() as f64);
        }
    }

    /// The corners of faces that meet at one, found by crossing one side after the other until the first face is met
    /// again: three, four or five.
    fn around(&self, face: usize, [entry, exit]: [Side; 2]) -> Vec<(usize, [bool; 2])> {
        let corner = |a: Side, b: Side| {
            if a.axis == 0 {
                [a.high, b.high]
            } else {
                [b.high, a.high]
            }
        };
        let mut around = vec![(face, corner(entry, exit))];
        let (mut here, mut entry, mut exit) = (face, entry, exit);
        while around.len() < MOST_FACES_AT_A_CORNER {
            // Nearer to the side than to the corner's other side: the place across tells which side was crossed.
            let along = if entry.high { 0.9 } else { -0.9 };
            let there = self
                .map
                .visit_canonical(Across(self.edge(here, exit), along, 1e-3));
            here = there.face as usize;
            if here == face {
                break;
            }
            let (p, q) = there.pq();
            let axis = usize::from(q.abs() > p.abs());
            let sides = [p > 0.0, q > 0.0];
            entry = Side {
                axis,
                high: sides[axis],
            };
            exit = Side {
                axis: 1 - axis,
                high: sides[1 - axis],
            };
            around.push((here, sides));
        }
        around
    }
}

struct Beside(Edge, f64, f64);

impl Visitor for Beside {
    type Output = f64;
    fn visit<P: Projection>(self, p: P) -> f64 {
        p.beside(self.0, self.1, self.2)
    }
}

struct Across(Edge, f64, f64);

impl Visitor for Across {
    type Output = Uv<f64>;
    fn visit<P: Projection>(self, p: P) -> Uv<f64> {
        p.across(self.0, self.1, self.2)
    }
}

#[cfg(test)]
mod tests {
    use crate::image::view::ImageView;
    use crate::map::Map;
    use crate::resample::convert::sample;
    use crate::resample::options::Options;

    #[test]
    fn values_are_continuous_over_every_edge_and_corner() {
        let map = Map::new("cube").unwrap();
        for n in [1, 2, 3, 16] {
            let texels: Vec<f64> = (0..6 * n * n)
                .map(|i| (i * 7919 % 1009) as f64 / 1009.0)
                .collect();
            let shape = [6, n, n];
            let image = ImageView::new(&map, &shape, 1, &texels).unwrap();
            let look = |d: [f64; 3]| {
                let mut out = [0.0];
                sample(&image, &d, &Options::new(), &mut out).unwrap();
                out[0]
            };
            for k in 0..=200 {
                let t = k as f64 / 100.0 - 1.0;
                for (a, b) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                    for axes in [[0, 1, 2], [1, 2, 0], [2, 0, 1]] {
                        let at = |e: f64| {
                            let mut d = [0.0; 3];
                            d[axes[0]] = a * (1.0 + e);
                            d[axes[1]] = b * (1.0 - e);
                            d[axes[2]] = t;
                            look(d)
                        };
                        assert!(
                            (at(1e-9) - at(-1e-9)).abs() < 1e-6,
                            "{n} {t} {a} {b} {axes:?}"
                        );
                    }
                }
            }
        }
    }
}
