//! How much of the sphere each cell of a lattice holds, and how that is spread over the cell, for cells that are followed one by
//! one (for the others see `plane`).
//!
//! In a cell the density is the quadratic through its values at the corners, the sides' middles and the center;
//! with [`FEWEST`] cells along a face it is right to 2e-7 where the formula is smooth, in the row at a pole as well
//! (where the density's third derivative is largest beside it), and a whole cell to 1e-9.
//! A cell with a crease through it has none, and is left to the general path: NaN.
//! Cells are computed in tiles, which are kept while they are near. Where the density does not depend on a
//! coordinate, one tile serves all along it.

use crate::map::verbs::DensityCanonical;
use crate::resample::area::lattice::Lattice;

/// Cells along a side of a face from which on a quadratic through these places serves for the density in a cell.
pub(in crate::resample::area) const FEWEST: usize = 512;

/// Cells along a side of a tile.
const TILE: usize = 16;
const NODES: usize = 2 * TILE + 1;

/// How much the bend across a cell may change along it where the density is smooth, relative to the density and times the
/// square of the number of cells: 3 beside a pole; where a crease runs through it grows with that number, from 50 at 64 on.
const CREASED: f64 = 8.0;

/// Tiles that are kept.
const KEPT: usize = 128;

/// Factors of 1, X, Y, X², XY, Y² from the cell's center, in steradians a cell.
pub(in crate::resample::area) type Spread = [f64; 6];

/// The solid angle of a cell.
#[inline(always)]
pub(in crate::resample::area) fn mean(spread: &Spread) -> f64 {
    spread[0] + (spread[3] + spread[5]) * (1.0 / 12.0)
}

struct Tile {
    key: [usize; 3],
    cells: Vec<Spread>,
}

/// The cells of a lattice.
pub(in crate::resample::area) struct Density<'l, 'a> {
    lattice: &'l Lattice<'a>,
    /// Whether the density varies along u and along v.
    varies: [bool; 2],
    tiles: Vec<Option<Tile>>,
    nodes: Vec<[f64; 3]>,
    densities: Vec<f64>,
}

impl<'l, 'a> Density<'l, 'a> {
    pub fn new(lattice: &'l Lattice<'a>, varies: [bool; 2]) -> Self {
        Density {
            lattice,
            varies,
            tiles: (0..KEPT).map(|_| None).collect(),
            nodes: Vec::new(),
            densities: Vec::new(),
        }
    }

    /// Whether the density varies along u and along v anywhere.
    pub fn varies(lattice: &Lattice<'_>) -> [bool; 2] {
        const PLACES: usize = 24;
        let place = |k: usize| (0.618_033_988_749_894_9 * k as f64 + 0.01).fract();
        let mut varies = [false; 2];
        for face in 0..lattice.map.info().faces {
            for (axis, varies) in varies.iter_mut().enumerate() {
                for i in 0..PLACES {
                    let nodes: Vec<[f64; 3]> = (0..PLACES)
                        .map(|k| {
                            let (fixed, free) = (place(i), place(k + PLACES));
                            let [u, v] = if axis == 0 {
                                [free, fixed]
                            } else {
                                [fixed, free]
                            };
                            [u, v, face as f64]
                        })
                        .collect();
                    let mut densities = [0.0; PLACES];
                    lattice.map.visit_canonical(DensityCanonical {
                        input: nodes.as_flattened(),
                        output: &mut densities,
                    });
                    *varies |= densities.iter().any(|d| *d != densities[0]);
                }
                // Cells must be alike as well.
                *varies |= !lattice.uniform(axis);
            }
        }
        varies
    }

    /// The cells of row `y` from column `x` on, as far as a tile goes.
    #[inline(always)]
    pub fn cells(&mut self, face: usize, [x, y]: [usize; 2]) -> &[Spread] {
        let tile = [
            if self.varies[0] { x / TILE } else { 0 },
            if self.varies[1] { y / TILE } else { 0 },
        ];
        let key = [face, tile[0], tile[1]];
        let slot = (tile[0] + 11 * tile[1] + 37 * face) % KEPT;
        if self.tiles[slot].as_ref().is_none_or(|held| held.key != key) {
            self.compute(slot, key);
        }
        let held = self.tiles[slot]
            .as_ref()
            .map_or(&[][..], |held| &held.cells);
        &held[(y % TILE) * TILE..][x % TILE..TILE]
    }

    #[inline(never)]
    fn compute(&mut self, slot: usize, key: [usize; 3]) {
        let [face, i, j] = key;
        let lattice = self.lattice;
        let lines = |axis: usize, tile: usize| -> [f64; NODES] {
            std::array::from_fn(|k| lattice.line(axis, (2 * tile * TILE + k) as isize))
        };
        let (us, vs) = (lines(0, i), lines(1, j));
        self.nodes.clear();
        let crease = CREASED / (lattice.columns.min(lattice.rows) as f64).powi(2);
        let face = face as f64;
        self.nodes.extend(
            vs.iter()
                .flat_map(|&v| us.iter().map(move |&u| [u, v, face])),
        );
        self.densities.resize(NODES * NODES, 0.0);
        lattice.map.visit_canonical(DensityCanonical {
            input: self.nodes.as_flattened(),
            output: &mut self.densities,
        });
        let mut tile = self.tiles[slot].take().unwrap_or(Tile {
            key,
            cells: Vec::new(),
        });
        tile.key = key;
        tile.cells.clear();
        for y in 0..TILE {
            let row = |k: usize| &self.densities[(2 * y + k) * NODES..][..NODES];
            let rows = [row(0), row(1), row(2)];
            for x in 0..TILE {
                let area = (us[2 * x + 2] - us[2 * x]) * (vs[2 * y + 2] - vs[2 * y]);
                let at = |i: usize, j: usize| area * rows[j][2 * x + i];
                let bend = |k: usize, along_u: bool| {
                    let at = |i: usize| if along_u { at(i, k) } else { at(k, i) };
                    at(0) - 2.0 * at(1) + at(2)
                };
                let center = at(1, 1);
                let smooth = [true, false].iter().all(|&along_u| {
                    let change = bend(0, along_u) - 2.0 * bend(1, along_u) + bend(2, along_u);
                    let tilt = bend(0, along_u) - bend(2, along_u);
                    change.abs().max(tilt.abs()) <= crease * center
                });
                tile.cells.push([
                    if smooth { center } else { f64::NAN },
                    at(2, 1) - at(0, 1),
                    at(1, 2) - at(1, 0),
                    2.0 * (at(2, 1) - 2.0 * center + at(0, 1)),
                    at(2, 2) - at(2, 0) - at(0, 2) + at(0, 0),
                    2.0 * (at(1, 2) - 2.0 * center + at(1, 0)),
                ]);
            }
        }
        self.tiles[slot] = Some(tile);
    }
}
