//! What pieces of a border say about the cells of one face: how much of each lies inside.

use crate::resample::area::lattice::{Lattice, NOTHING};
use crate::resample::area::traced::arc::Piece;
use crate::resample::area::traced::density::{Density, mean};

/// Of a row's height, what is left by rounding where a border has closed.
const EMPTY: f64 = 1e-11;

/// The weights that come of a border's pieces.
#[derive(Default)]
pub(in crate::resample::area) struct Shares {
    /// The pieces by row and column.
    pieces: Vec<Piece>,
    /// Stored texels and how much of each.
    pub weights: Vec<(usize, f64)>,
    /// The sum of all weights, of those that were left out as well.
    pub total: f64,
    /// The most negative one.
    pub least: f64,
}

impl Shares {
    /// Goes on to the next cell.
    #[inline(always)]
    pub fn start(&mut self) {
        self.total = 0.0;
        self.least = 0.0;
    }

    /// Adds the cells of a face inside a closed border: its pieces and +1 or -1 for their sense. `size` is the solid
    /// angle inside. False where a density is not known.
    pub fn add(
        &mut self,
        lattice: &Lattice<'_>,
        density: &mut Density<'_, '_>,
        face: usize,
        pieces: &[Piece],
        sense: f64,
        size: f64,
    ) -> bool {
        let mut pieces_in_order = std::mem::take(&mut self.pieces);
        pieces_in_order.clear();
        pieces_in_order.extend_from_slice(pieces);
        pieces_in_order.sort_by_key(|piece| (piece.at[1], piece.at[0]));
        let known = pieces_in_order
            .chunk_by(|p, q| p.at[1] == q.at[1])
            .all(|row| self.add_row(lattice, density, face, row, sense, size));
        self.pieces = pieces_in_order;
        known
    }

    /// The same for the pieces of one row, from left to right.
    fn add_row(
        &mut self,
        lattice: &Lattice<'_>,
        density: &mut Density<'_, '_>,
        face: usize,
        row: &[Piece],
        sense: f64,
        size: f64,
    ) -> bool {
        let y = row[0].at[1] as usize;
        let mut across = [0.0_f64; 3];
        let mut next = row[0].at[0] as usize;
        for cell in row.chunk_by(|p, q| p.at[0] == q.at[0]) {
            let x = cell[0].at[0] as usize;
            // A border that touches two ends of a row closes on each of them: between, there is nothing.
            if across[0].abs() > EMPTY {
                for x in next..x {
                    if !self.weigh(lattice, density, (face, [x, y]), [0.0; 6], across, size) {
                        return false;
                    }
                }
            }
            let (mut own, mut right) = ([0.0; 6], [0.0; 3]);
            for piece in cell {
                for (sum, share) in own.iter_mut().zip(piece.own) {
                    *sum += sense * share;
                }
                for (sum, share) in right.iter_mut().zip(piece.right) {
                    *sum += sense * share;
                }
            }
            if !self.weigh(lattice, density, (face, [x, y]), own, across, size) {
                return false;
            }
            for (sum, share) in across.iter_mut().zip(right) {
                *sum += share;
            }
            next = x + 1;
        }
        true
    }

    /// Adds one cell: what its own pieces and those on its left say.
    #[inline(always)]
    fn weigh(
        &mut self,
        lattice: &Lattice<'_>,
        density: &mut Density<'_, '_>,
        (face, at): (usize, [usize; 2]),
        own: [f64; 6],
        [a, b, c]: [f64; 3],
        size: f64,
    ) -> bool {
        let Some(spread) = density.cells(face, at).first() else {
            return false;
        };
        let weight = spread[0] * (own[0] + a)
            + spread[1] * own[1]
            + spread[2] * (own[2] + b)
            + spread[3] * (own[3] + a * (1.0 / 12.0))
            + spread[4] * own[4]
            + spread[5] * (own[5] + c);
        self.total += weight;
        if weight > NOTHING * size.min(mean(spread)) {
            self.weights.push((lattice.stored(face, at), weight));
        } else if weight < self.least {
            self.least = weight;
        }
        !weight.is_nan()
    }
}
