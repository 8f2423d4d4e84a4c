//! The solid angles of the cells of a part of a face, and how they grow from cell to cell.
//!
//! In a cell the density is quadratic, or linear where the image has [`STRAIGHT`] cells along a side, with the cell's own solid angle
//! as its mean. A line is that of the two neighbors. A parabola is the nearest, in the mean over the cell, to the quartic through five, so
//! that what is left of the third degree moves a border's share least: either moves it by 1e-7 of a cell at most where the formula
//! is smooth, in the row at a pole as well, and what one side of it lacks the other has.
//! One density a cell is computed, at its center. Where the density does
//! not depend on a coordinate, one cell stands for all along it.
//!
//! A cell with a crease through it is not right here, and nothing says so but the sum of the shares of whoever covers it.

use crate::map::verbs::DensityCanonical;
use crate::resample::area::fast::lanes::{LANES, Lanes};
use crate::resample::area::lattice::Lattice;

/// Cells along a side of a face from which on a parabola serves for the density in a cell.
pub(in crate::resample::area) const FEWEST: usize = 256;

/// Cells from which on a line serves.
const STRAIGHT: usize = 1024;

/// Of the quartic through five numbers at -2 to 2, in a cell around one of these: its mean, the slope of the nearest line, and the
/// factor of X² - 1/12 in the nearest parabola, X from the cell's center.
const QUARTIC: [[[f64; 5]; 3]; 5] = {
    const ENDS: [[f64; 5]; 3] = [
        [
            6463.0 / 5760.0,
            -523.0 / 1440.0,
            383.0 / 960.0,
            -283.0 / 1440.0,
            223.0 / 5760.0,
        ],
        [
            -103.0 / 48.0,
            169.0 / 40.0,
            -33.0 / 10.0,
            181.0 / 120.0,
            -23.0 / 80.0,
        ],
        [
            493.0 / 336.0,
            -367.0 / 84.0,
            269.0 / 56.0,
            -199.0 / 84.0,
            157.0 / 336.0,
        ],
    ];
    const NEXT: [[f64; 5]; 3] = [
        [
            223.0 / 5760.0,
            1337.0 / 1440.0,
            23.0 / 960.0,
            17.0 / 1440.0,
            -17.0 / 5760.0,
        ],
        [
            -23.0 / 80.0,
            -17.0 / 24.0,
            27.0 / 20.0,
            -17.0 / 40.0,
            17.0 / 240.0,
        ],
        [
            157.0 / 336.0,
            -73.0 / 84.0,
            17.0 / 56.0,
            11.0 / 84.0,
            -11.0 / 336.0,
        ],
    ];
    const MIDDLE: [[f64; 5]; 3] = [
        [
            -17.0 / 5760.0,
            77.0 / 1440.0,
            863.0 / 960.0,
            77.0 / 1440.0,
            -17.0 / 5760.0,
        ],
        [
            17.0 / 240.0,
            -77.0 / 120.0,
            0.0,
            77.0 / 120.0,
            -17.0 / 240.0,
        ],
        [
            -11.0 / 336.0,
            53.0 / 84.0,
            -67.0 / 56.0,
            53.0 / 84.0,
            -11.0 / 336.0,
        ],
    ];
    [ENDS, NEXT, MIDDLE, mirrored(NEXT), mirrored(ENDS)]
};

/// The same from the other end, where a slope is its opposite.
const fn mirrored([mean, slope, bend]: [[f64; 5]; 3]) -> [[f64; 5]; 3] {
    let [a, b, c, d, e] = mean;
    let [f, g, h, i, j] = slope;
    let [k, l, m, n, o] = bend;
    [[e, d, c, b, a], [-j, -i, -h, -g, -f], [o, n, m, l, k]]
}

/// Cells that are held, at most.
const MOST: usize = 1 << 18;

/// Of the parabola through three numbers at -1 to 1: its mean, its slope in the middle of the cell, and its factor of X² - 1/12.
const PARABOLA: [[[f64; 3]; 3]; 3] = {
    const BEND: [f64; 3] = [1.0, -2.0, 1.0];
    [
        [
            [25.0 / 24.0, -2.0 / 24.0, 1.0 / 24.0],
            [-1.5, 2.0, -0.5],
            BEND,
        ],
        [
            [1.0 / 24.0, 22.0 / 24.0, 1.0 / 24.0],
            [-0.5, 0.0, 0.5],
            BEND,
        ],
        [
            [1.0 / 24.0, -2.0 / 24.0, 25.0 / 24.0],
            [0.5, -2.0, 1.5],
            BEND,
        ],
    ]
};

/// A box of cells of one face.
#[derive(Default)]
pub(in crate::resample::area) struct Plane {
    face: usize,
    low: [usize; 2],
    /// Cells along each axis; 0 before the first use.
    size: [usize; 2],
    /// How far apart neighbors are held along each axis: 0 where the density does not vary.
    steps: [usize; 2],
    /// Factors of 1, X, Y, X² - 1/12, XY and Y² - 1/12 from the cell's center: the first is its solid angle.
    cells: Vec<[f64; 6]>,
    /// Whether the last three count.
    pub bends: bool,
    /// Centers of cells, and the density at each.
    nodes: Vec<[f64; 3]>,
    densities: Vec<f64>,
}

/// Densities around cells.
struct Near<'a> {
    densities: &'a [f64],
    /// How far apart neighbors are along each axis.
    steps: [usize; 2],
    varies: [bool; 2],
    /// What a cell has of a face.
    area: f64,
}

impl Near<'_> {
    /// The numbers of a cell, `off` from the middle of the N nearest along each axis; the last three where it bends. None beside a rim:
    /// whoever covers such a cell sees that something is missing.
    #[inline(always)]
    fn cell<const N: usize>(
        &self,
        nearest: &[[[f64; N]; 3]; N],
        middle: usize,
        off: [isize; 2],
    ) -> [f64; 6] {
        let bends = N > 3;
        let own = self.densities[middle];
        let mut cell = [own, 0.0, 0.0, 0.0, 0.0, 0.0];
        for axis in [0, 1] {
            if !self.varies[axis] {
                continue;
            }
            let (step, at) = (self.steps[axis] as isize, (N / 2) as isize + off[axis]);
            let start = middle as isize - at * step;
            let mut numbers = [0.0; 3];
            for k in 0..N {
                let density = self.densities[(start + k as isize * step) as usize];
                for (number, factors) in numbers.iter_mut().zip(&nearest[at as usize]) {
                    *number += factors[k] * density;
                }
            }
            let [mean, slope, bend] = numbers;
            cell[0] += mean - own;
            cell[1 + axis] = slope;
            if bends {
                cell[3 + 2 * axis] = bend;
            }
        }
        if bends && self.varies == [true; 2] {
            let [along, down] = self.steps.map(|step| step as isize);
            let middle = middle as isize - off[0].signum() * along - off[1].signum() * down;
            let [above, below] =
                [-1, 1].map(|row| [-1, 1].map(|x| (middle + x * along + row * down) as usize));
            let all = self.densities;
            cell[4] = 0.25 * ((all[below[1]] - all[below[0]]) - (all[above[1]] - all[above[0]]));
        }
        let cell = cell.map(|number| self.area * number);
        if cell.iter().all(|x| x.is_finite()) {
            cell
        } else {
            [0.0; 6]
        }
    }
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
        self.bends = limits[0].min(limits[1]) < STRAIGHT;
        self.steps = [usize::from(varies[0]), if varies[1] { size[0] } else { 0 }];
        self.compute(lattice, varies);
        true
    }

    #[inline(never)]
    fn compute(&mut self, lattice: &Lattice<'_>, varies: [bool; 2]) {
        let limits = [lattice.columns, lattice.rows];
        let scales = [0, 1].map(|axis| lattice.scale(axis));
        // Some more on each side where the face has them.
        let reach = if self.bends { 2 } else { 1 };
        let more = varies.map(|varies| if varies { reach } else { 0 });
        let first = [0, 1].map(|k| self.low[k].saturating_sub(more[k]));
        let last = [0, 1].map(|k| (self.low[k] + self.size[k] - 1 + more[k]).min(limits[k] - 1));
        let center = |axis: usize, k: usize| {
            let (scale, offset) = scales[axis];
            (k as f64 + 0.5 - offset) / scale
        };
        let face = self.face as f64;
        self.nodes.clear();
        for j in first[1]..=last[1] {
            let v = center(1, j);
            self.nodes
                .extend((first[0]..=last[0]).map(|i| [center(0, i), v, face]));
        }
        self.densities.resize(self.nodes.len(), 0.0);
        lattice.map.visit_canonical(DensityCanonical {
            input: self.nodes.as_flattened(),
            output: &mut self.densities,
        });
        let across = last[0] - first[0] + 1;
        let near = Near {
            densities: &self.densities,
            steps: [1, across],
            varies,
            area: 1.0 / (scales[0].0 * scales[1].0),
        };
        // How far from the middle of those nearest.
        let off = |axis: usize, k: usize| {
            let far = last[axis].saturating_sub(reach);
            k as isize - k.min(far).max(first[axis] + reach) as isize
        };
        let columns = self.low[0]..self.low[0] + self.size[0];
        self.cells.clear();
        for j in self.low[1]..self.low[1] + self.size[1] {
            let row = (j - first[1]) * across;
            let off_row = off(1, j);
            for i in columns.clone() {
                let (off, middle) = ([off(0, i), off_row], row + i - first[0]);
                // Most by far lie in the middle: for them factors are constants.
                self.cells.push(match (off, self.bends) {
                    ([0, 0], false) => near.cell(&PARABOLA, middle, [0, 0]),
                    ([0, 0], true) => near.cell(&QUARTIC, middle, [0, 0]),
                    (_, false) => near.cell(&PARABOLA, middle, off),
                    (_, true) => near.cell(&QUARTIC, middle, off),
                });
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

    /// The first numbers of the cells so many columns and rows from each lane's own; 0 for those that are not held.
    #[inline(always)]
    pub fn read(
        &self,
        base: &[Lanes; 2],
        by: [usize; 2],
        limits: [usize; 2],
        spread: &mut [Lanes],
    ) {
        for lane in 0..LANES {
            let x = (base[0].0[lane] as i32 as usize + by[0]).min(limits[0] - 1);
            let y = (base[1].0[lane] as i32 as usize + by[1]).min(limits[1] - 1);
            let cell = self.cells.get(self.index([x, y]));
            let cell = cell.copied().unwrap_or([0.0; 6]);
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
            ("latlong", &[256, 512]),
            ("cube", &[6, 1024, 1024]),
            ("cube", &[6, 256, 256]),
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
