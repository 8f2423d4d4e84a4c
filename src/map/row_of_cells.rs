//! The solid angles of cells that lie side by side in a row of a face.
//!
//! Most maps have closed forms, which are found cell by cell. Lenses have none, and nearly all of their cells take a rule of four to
//! sixteen points ([`solid_angle::smooth`]). These are taken in lanes, all points of many cells at once: the same points, by the same
//! formulas and summed in the same order, so that a cell has the bits that it has alone.

use super::verbs::DensityOwn;
use crate::geometry::solid_angle::{self, Rect};
use crate::projections::projection::{Projection, Visitor};
use std::cell::OnceCell;

/// Cells whose points are found at once: what fits the cache.
const CELLS: usize = 256;

/// The solid angles of cells in a row.
pub(crate) struct RowOfCells<'a> {
    /// Where in u the cells begin and end, one more than there are cells.
    pub(crate) edges: &'a [f64],
    /// The same in v.
    pub(crate) sides: [f64; 2],
    /// A solid angle for each cell.
    pub(crate) out: &'a mut [f64],
}

impl Visitor for RowOfCells<'_> {
    type Output = ();

    fn visit<P: Projection>(self, p: P) {
        let RowOfCells {
            edges,
            sides: [v0, v1],
            out,
        } = self;
        let cell = |k: usize| Rect {
            u0: edges[k],
            u1: edges[k + 1],
            v0,
            v1,
        };
        if const { P::INFO.faces > 1 } {
            for (k, out) in out.iter_mut().enumerate() {
                *out = p.solid_angle(cell(k));
            }
            return;
        }
        let density = |places: &[f64]| {
            let mut output = vec![0.0; places.len() / 2];
            DensityOwn {
                input: places,
                output: &mut output,
            }
            .visit(p);
            output
        };
        let borders = OnceCell::new();
        let corners = |k: usize| {
            let [above, below]: &[Vec<f64>; 2] = borders.get_or_init(|| {
                [v0, v1].map(|v| {
                    let places: Vec<f64> = edges.iter().flat_map(|u| [*u, v]).collect();
                    density(&places)
                })
            });
            [above[k], above[k + 1], below[k], below[k + 1]]
        };
        let mut smooth = Vec::new();
        for (k, out) in out.iter_mut().enumerate() {
            if p.is_smooth(cell(k), || corners(k)) {
                smooth.push(k);
            } else {
                *out = p.solid_angle(cell(k));
            }
        }
        for cells in smooth.chunks(CELLS) {
            let mut places = Vec::new();
            for &k in cells {
                solid_angle::smooth(cell(k), |u, v| {
                    places.extend([u, v]);
                    0.0
                });
            }
            let mut densities = density(&places).into_iter();
            for &k in cells {
                let sum = solid_angle::smooth(cell(k), |_, _| densities.next().unwrap_or(f64::NAN));
                // A point beyond a rim that all corners are within.
                out[k] = if sum.is_nan() {
                    p.solid_angle(cell(k))
                } else {
                    sum
                };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Map, MapOptions};

    #[test]
    fn cells_in_a_row_have_the_bits_that_they_have_alone() {
        for (name, parameters) in [
            ("unified", vec![]),
            ("kannala_brandt", vec![("k2", 0.1)]),
            ("camera_pinhole", vec![]),
            ("camera_brown_conrady", vec![("k1", 0.1), ("p1", 0.01)]),
            ("camera_brown_conrady", vec![("k4", 5.0)]),
            ("camera_unified", vec![("xi", 1.5)]),
            ("cube_equiangular", vec![]),
        ] {
            let options = MapOptions::new().parameters(&parameters);
            let map = Map::with(name, options).unwrap();
            // Cells of three rules, and of none.
            for n in [40, 100, 300, 1700] {
                let edges: Vec<f64> = (0..=n).map(|k| k as f64 / n as f64).collect();
                for j in [0, n / 8, n / 2] {
                    let sides = [edges[j], edges[j + 1]];
                    let mut row = vec![0.0; n];
                    map.visit_canonical(RowOfCells {
                        edges: &edges,
                        sides,
                        out: &mut row,
                    });
                    for k in (0..n).step_by(3) {
                        let alone = map.solid_angle(Rect {
                            u0: edges[k],
                            u1: edges[k + 1],
                            v0: sides[0],
                            v1: sides[1],
                        });
                        assert_eq!(row[k].to_bits(), alone.to_bits(), "{name} {n} {j} {k}");
                    }
                }
            }
        }
    }
}
