//! What pieces of a border say about the cells of one face: how much of each lies inside.

use super::arc::Piece;
use super::density::{Density, mean};
use super::lattice::Lattice;

/// Cells of a region's bounding box, at most.
const MOST_CELLS: usize = 1 << 20;

/// Overlaps below this part of the smaller cell are no overlaps, as on the general path.
const NOTHING: f64 = super::overlay::NOTHING;

/// Sums for the cells of a bounding box, and the weights that come of them.
#[derive(Default)]
pub(super) struct Shares {
    /// As in [`Piece`], nine a cell.
    sums: Vec<[f64; 9]>,
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
    /// angle inside. False where the region is too large.
    #[inline(always)]
    pub fn add(
        &mut self,
        lattice: &Lattice<'_>,
        density: &mut Density<'_, '_>,
        face: usize,
        parts: &[(&[Piece], f64)],
        size: f64,
    ) -> bool {
        let (mut low, mut high) = ([u32::MAX; 2], [0; 2]);
        for piece in parts.iter().flat_map(|(pieces, _)| *pieces) {
            for k in [0, 1] {
                low[k] = low[k].min(piece.at[k]);
                high[k] = high[k].max(piece.at[k]);
            }
        }
        if low[0] > high[0] {
            return true;
        }
        let columns = (high[0] - low[0]) as usize + 1;
        let rows = (high[1] - low[1]) as usize + 1;
        if columns * rows > MOST_CELLS {
            return false;
        }
        self.sums.clear();
        self.sums.resize(columns * rows, [0.0; 9]);
        for (pieces, sense) in parts {
            for piece in *pieces {
                let x = (piece.at[0] - low[0]) as usize;
                let y = (piece.at[1] - low[1]) as usize;
                let sums = &mut self.sums[y * columns + x];
                for (sum, share) in sums.iter_mut().zip(piece.own.iter().chain(&piece.right)) {
                    *sum += sense * share;
                }
            }
        }
        let first = low.map(|k| k as usize);
        for row in 0..rows {
            let y = first[1] + row;
            let sums = &self.sums[row * columns..][..columns];
            let [mut a, mut b, mut c] = [0.0; 3];
            let mut x = 0;
            while x < columns {
                let cells = density.cells(face, [first[0] + x, y]);
                for (sums, spread) in sums[x..].iter().zip(cells) {
                    let [own, own_x, own_y, own_xx, own_xy, own_yy, ..] = *sums;
                    let weight = spread[0] * (own + a)
                        + spread[1] * own_x
                        + spread[2] * (own_y + b)
                        + spread[3] * (own_xx + a * (1.0 / 12.0))
                        + spread[4] * own_xy
                        + spread[5] * (own_yy + c);
                    a += sums[6];
                    b += sums[7];
                    c += sums[8];
                    self.total += weight;
                    if weight > NOTHING * size.min(mean(spread)) {
                        let at = [first[0] + x, y];
                        self.weights.push((lattice.stored(face, at), weight));
                    } else if weight < self.least {
                        self.least = weight;
                    } else if weight.is_nan() {
                        return false;
                    }
                    x += 1;
                }
            }
        }
        true
    }
}
