//! The solid angles of the cells of a part of a face, and how they grow from cell to cell.
//!
//! In a cell the density is linear, with the cell's own solid angle as its mean: in an image of [`FEWEST`] cells along a
//! side that moves a border's share by 1e-7 of a cell at most where the formula is smooth, and what one side of
//! it lacks the other has. One density a cell is computed, at its center; the rest are differences. Where the density does
//! not depend on a coordinate, one cell stands for all along it.
//!
//! A cell with a crease through it is not right here, and nothing says so but the sum of the shares of whoever covers it.

use crate::map::verbs::DensityCanonical;
use crate::resample::area::fast::lanes::{LANES, Lanes};
use crate::resample::area::lattice::Lattice;

/// Cells along a side of a face from which on a line serves for the density in a cell.
pub(in crate::resample::area) const FEWEST: usize = 1024;

/// Cells that are held, at most.
const MOST: usize = 1 << 18;

/// A box of cells of one face.
#[derive(Default)]
pub(in crate::resample::area) struct Plane {
    face: usize,
    low: [usize; 2],
    /// Cells along each axis; 0 before the first use.
    size: [usize; 2],
    /// How far apart neighbors are held along each axis: 0 where the density does not vary.
    steps: [usize; 2],
    /// The solid angle, and its growth a cell along u and along v.
    cells: Vec<[f64; 3]>,
}

impl Plane {
    /// Holds at least the cells from `low` to below `high`. False where they are too many.
    pub fn hold(
        &mut self,
        lattice: &Lattice<'_>,
        varies: [bool; 2],
        face: usize,
        low: [usize; 2],
        high: [usize; 2],
    ) -> bool {
        let held = self.face == face
            && [0, 1].iter().all(|&k| {
                self.size[k] > 0
                    && (!varies[k]
                        || self.low[k] <= low[k] && high[k] <= self.low[k] + self.size[k])
            });
        if held {
            return true;
        }
        let limits = [lattice.columns, lattice.rows];
        let (mut first, mut size) = ([0; 2], [1; 2]);
        for k in [0, 1] {
            if varies[k] {
                // A row of densities costs nothing beside what it is asked for.
                let (start, end) = if varies[1 - k] {
                    // Differences take three.
                    let end = high[k].max(3).min(limits[k]);
                    (low[k].min(end.saturating_sub(3)), end)
                } else {
                    (0, limits[k])
                };
                (first[k], size[k]) = (start, end - start);
            }
        }
        if size[0] * size[1] > MOST {
            return false;
        }
        self.face = face;
        self.low = first;
        self.size = size;
        self.steps = [usize::from(varies[0]), if varies[1] { size[0] } else { 0 }];
        self.compute(lattice, varies);
        true
    }

    #[inline(never)]
    fn compute(&mut self, lattice: &Lattice<'_>, varies: [bool; 2]) {
        let limits = [lattice.columns, lattice.rows];
        let scales = [0, 1].map(|axis| lattice.scale(axis));
        // One more on each side where the face has it, for the differences.
        let first = [0, 1].map(|k| self.low[k] - usize::from(varies[k] && self.low[k] > 0));
        let last = [0, 1].map(|k| {
            let end = self.low[k] + self.size[k];
            end - usize::from(!varies[k] || end == limits[k])
        });
        let center = |axis: usize, k: usize| {
            let (scale, offset) = scales[axis];
            (k as f64 + 0.5 - offset) / scale
        };
        let (across, down) = (last[0] - first[0] + 1, last[1] - first[1] + 1);
        let mut nodes: Vec<[f64; 3]> = Vec::with_capacity(across * down);
        for j in first[1]..=last[1] {
            let v = center(1, j);
            let face = self.face as f64;
            nodes.extend((first[0]..=last[0]).map(|i| [center(0, i), v, face]));
        }
        let mut densities = vec![0.0; nodes.len()];
        lattice.map.visit_canonical(DensityCanonical {
            input: nodes.as_flattened(),
            output: &mut densities,
        });
        let area = 1.0 / (scales[0].0 * scales[1].0);
        self.cells.clear();
        let steps = [1, across];
        for j in self.low[1]..self.low[1] + self.size[1] {
            for i in self.low[0]..self.low[0] + self.size[0] {
                let at = [i, j];
                let middle = (j - first[1]) * across + i - first[0];
                let own = area * densities[middle];
                let mut cell = [own, 0.0, 0.0];
                for axis in [0, 1] {
                    if !varies[axis] {
                        continue;
                    }
                    // Beside the end of a face the differences are those of the cell before.
                    let from_end = if at[axis] == first[axis] {
                        1
                    } else if at[axis] == last[axis] {
                        -1
                    } else {
                        0
                    };
                    let by = |k: isize| {
                        let k = (k + from_end) * steps[axis] as isize;
                        area * densities[(middle as isize + k) as usize]
                    };
                    let bend = by(-1) - 2.0 * by(0) + by(1);
                    cell[1 + axis] = 0.5 * (by(1) - by(-1)) - from_end as f64 * bend;
                    cell[0] += bend * (1.0 / 24.0);
                }
                // Beside a rim there is none: whoever covers such a cell sees that something is missing.
                let known = cell.iter().all(|x| x.is_finite());
                self.cells.push(if known { cell } else { [0.0; 3] });
            }
        }
    }

    /// The solid angle of a cell, if it is held.
    #[inline(always)]
    pub fn get(&self, at: [usize; 2]) -> Option<f64> {
        let index = self.index(at);
        self.cells.get(index).map(|cell| cell[0])
    }

    /// Where a cell is held; nowhere if it is not.
    #[inline(always)]
    fn index(&self, at: [usize; 2]) -> usize {
        let along = at[0].wrapping_sub(self.low[0]).wrapping_mul(self.steps[0]);
        let down = at[1].wrapping_sub(self.low[1]).wrapping_mul(self.steps[1]);
        if along < self.size[0] {
            along.wrapping_add(down)
        } else {
            usize::MAX
        }
    }

    /// Whether cells differ along each axis.
    #[inline(always)]
    pub fn varies(&self) -> [bool; 2] {
        self.steps.map(|step| step > 0)
    }

    /// The cells so many columns and rows from each lane's own; 0 for those that are not held.
    #[inline(always)]
    pub fn read(
        &self,
        base: &[Lanes; 2],
        by: [usize; 2],
        limits: [usize; 2],
        spread: &mut [Lanes; 3],
    ) {
        for lane in 0..LANES {
            let x = (base[0].0[lane] as i32 as usize + by[0]).min(limits[0] - 1);
            let y = (base[1].0[lane] as i32 as usize + by[1]).min(limits[1] - 1);
            let cell = self.cells.get(self.index([x, y]));
            let cell = cell.copied().unwrap_or([0.0; 3]);
            for (row, number) in spread.iter_mut().zip(cell) {
                row.0[lane] = number;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Map;

    #[test]
    fn all_cells_are_the_sphere() {
        for (name, shape) in [
            ("latlong", &[1024, 2048][..]),
            ("cube", &[6, 1024, 1024]),
            ("octahedral", &[1024, 1024]),
        ] {
            let map = Map::new(name).unwrap();
            let lattice = Lattice::new(&map, shape, None).unwrap();
            let varies = crate::resample::area::traced::density::Density::varies(&lattice);
            let mut plane = Plane::default();
            let mut sum = 0.0;
            for face in 0..map.info().faces {
                for y in (0..lattice.rows).step_by(128) {
                    for x in (0..lattice.columns).step_by(128) {
                        assert!(plane.hold(&lattice, varies, face, [x, y], [x + 128, y + 128]));
                        for j in y..y + 128 {
                            for i in x..x + 128 {
                                sum += plane.get([i, j]).unwrap();
                            }
                        }
                    }
                }
            }
            let error = sum / (4.0 * std::f64::consts::PI) - 1.0;
            // The octahedron has creases: cells that hold one are not right, and are not used.
            let bound = if name == "octahedral" { 1e-4 } else { 1e-9 };
            assert!(error.abs() < bound, "{name} {error:e}");
        }
    }

    #[test]
    fn what_is_not_held() {
        let map = Map::new("cube").unwrap();
        let lattice = Lattice::new(&map, &[6, 1024, 1024], None).unwrap();
        let mut plane = Plane::default();
        assert_eq!(plane.get([0, 0]), None);
        assert!(plane.hold(&lattice, [true; 2], 2, [10, 20], [14, 24]));
        for (at, held) in [
            ([10, 20], true),
            ([13, 23], true),
            ([14, 20], false),
            ([9, 21], false),
            ([10, 24], false),
            ([10, 19], false),
        ] {
            assert_eq!(plane.get(at).is_some(), held, "{at:?}");
        }
        assert!(!plane.hold(&lattice, [true; 2], 2, [0, 0], [1024, 1024]));
    }
}
