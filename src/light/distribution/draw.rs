//! Drawing samples.

use super::search::{BELOW_ONE, WINDOW, bucket, position, search};
use super::straighten::Straighten;
use super::{Distribution, Radiance};
use crate::kernel::{Scalar, prefetch_item, vectorize};
use crate::real::Real;
use crate::threads;
use crate::tile::{TILE, Tile};
use crate::verbs::DrawTile;

/// Samples that one thread draws before it looks for more work.
const JOB: usize = 16 * TILE;

/// What a tile of samples knows between two passes.
#[derive(Clone, Copy, Default)]
struct Draft {
    row: u32,
    guess: u32,
    /// The number that decides on the column.
    x: f64,
    /// Where in the row the sample lies, 0 to 1.
    t: f64,
    valid: bool,
}

impl Distribution {
    /// Draws a world direction for each pair of numbers in [0, 1], with its density and, if there is room
    /// for them, its texel's channels over the density. All are NaN for a pair that is not in there.
    pub fn sample<R: Scalar>(
        &self,
        xi: &[R],
        directions: &mut [R],
        pdf: &mut [R],
        weights: &mut [R],
    ) {
        struct Job<'a, R> {
            xi: &'a [R],
            directions: &'a mut [R],
            pdf: &'a mut [R],
            weights: &'a mut [R],
        }
        let points = pdf.len();
        let each = if weights.is_empty() { 0 } else { self.channels };
        let mut weights = weights;
        let mut jobs: Vec<Job<'_, R>> = xi
            .chunks(2 * JOB)
            .zip(directions.chunks_mut(3 * JOB))
            .zip(pdf.chunks_mut(JOB))
            .map(|((xi, directions), pdf)| {
                let (here, rest) = std::mem::take(&mut weights).split_at_mut(each * pdf.len());
                weights = rest;
                Job {
                    xi,
                    directions,
                    pdf,
                    weights: here,
                }
            })
            .collect();
        threads::rows(&mut jobs, 1, points, |_, jobs| {
            for job in jobs {
                self.sample_tiles(job.xi, job.directions, job.pdf, job.weights);
            }
        });
    }

    fn sample_tiles<R: Scalar>(
        &self,
        xi: &[R],
        directions: &mut [R],
        pdf: &mut [R],
        weights: &mut [R],
    ) {
        let each = if weights.is_empty() { 0 } else { self.channels };
        let mut weights = weights;
        let (mut drafts, mut next) = ([Draft::default(); TILE], [Draft::default(); TILE]);
        let mut coming = xi.chunks(2 * TILE);
        self.draft(coming.next().unwrap_or_default(), &mut next);
        let (mut cells, mut texels) = (Tile::new(), [0; TILE]);
        let tiles = directions.chunks_mut(3 * TILE).zip(pdf.chunks_mut(TILE));
        for (directions, pdf) in tiles {
            std::mem::swap(&mut drafts, &mut next);
            let drafts = &drafts[..pdf.len()];
            let texels = &mut texels[..pdf.len()];
            self.find_cells(drafts, &mut cells, texels, each > 0);
            // The next tile's part of the tables is on its way while this one is computed.
            self.draft(coming.next().unwrap_or_default(), &mut next);
            let (here, rest) = std::mem::take(&mut weights).split_at_mut(each * pdf.len());
            weights = rest;
            self.finish(drafts, &cells, texels, directions, pdf, here);
        }
    }

    /// Rows, and where the search for the column will begin.
    #[inline(never)]
    fn draft<R: Scalar>(&self, xi: &[R], drafts: &mut [Draft]) {
        vectorize(
            #[inline(always)]
            || self.draft_here(xi, drafts),
        );
    }

    #[inline(always)]
    fn draft_here<R: Scalar>(&self, xi: &[R], drafts: &mut [Draft]) {
        let (stride, entries) = (self.columns + 1, self.buckets + 1);
        let drafts = &mut drafts[..xi.len() / 2];
        for (draft, xi) in drafts.iter_mut().zip(xi.as_chunks::<2>().0) {
            let (x, y) = (xi[0].to_f64(), xi[1].to_f64());
            let unit = 0.0..=1.0;
            draft.valid = unit.contains(&x) && unit.contains(&y);
            let (x, y) = if draft.valid {
                (x, y.min(BELOW_ONE))
            } else {
                (0.5, 0.5)
            };
            let guess = self.marginal_guide[bucket(y, self.marginal_guide.len())] as usize;
            let row = search(&self.marginal, &self.marginal_guide, guess, y);
            draft.row = row as u32;
            draft.t = position(&self.marginal, row, y);
            draft.x = x.min(BELOW_ONE);
            prefetch_item(&self.guide, row * entries + bucket(draft.x, entries));
        }
        for draft in drafts {
            let row = draft.row as usize;
            draft.guess = self.guide[row * entries + bucket(draft.x, entries)];
            let at = row * stride + draft.guess as usize;
            prefetch_item(&self.conditional, at);
            prefetch_item(&self.conditional, at + WINDOW);
        }
    }

    /// Rectangles with the two numbers that say where in them a sample lies, and their texels.
    #[inline(never)]
    fn find_cells(
        &self,
        drafts: &[Draft],
        cells: &mut Tile<f64, 7>,
        texels: &mut [usize],
        weighted: bool,
    ) {
        vectorize(
            #[inline(always)]
            || self.find_cells_here(drafts, cells, texels, weighted),
        );
    }

    #[inline(always)]
    fn find_cells_here(
        &self,
        drafts: &[Draft],
        cells: &mut Tile<f64, 7>,
        texels: &mut [usize],
        weighted: bool,
    ) {
        let (stride, entries) = (self.columns + 1, self.buckets + 1);
        for (k, (draft, texel)) in drafts.iter().zip(texels).enumerate() {
            let number = draft.row as usize;
            let function = &self.conditional[number * stride..][..stride];
            let guide = &self.guide[number * entries..][..entries];
            let column = search(function, guide, draft.guess as usize, draft.x);
            let row = &self.rows[number];
            let i = if self.split == 1 {
                column
            } else {
                (column as u32 / self.split as u32) as usize
            };
            *texel = row.texel + i;
            if weighted {
                self.prefetch_record(*texel);
            } else {
                prefetch_item(&self.density, *texel);
            }
            let mut cell = [
                self.edges[column],
                self.edges[column + 1],
                row.v0,
                row.v1,
                row.face,
                position(function, column, draft.x),
                draft.t,
            ];
            if !self.crooked.is_empty() && self.is_crooked(number, column) {
                cell = self.straightened(cell);
            }
            cells.set(k, cell);
        }
    }

    #[inline(never)]
    fn straightened(&self, cell: [f64; 7]) -> [f64; 7] {
        self.map.visit_canonical(Straighten(cell))
    }

    #[inline(always)]
    fn prefetch_record(&self, texel: usize) {
        let at = texel * (self.channels + 1);
        match &self.records {
            Radiance::Single(records) => prefetch_item(records, at),
            Radiance::Double(records) => prefetch_item(records, at),
        }
    }

    /// From rectangles to directions, densities and weights.
    #[inline(never)]
    fn finish<R: Scalar>(
        &self,
        drafts: &[Draft],
        cells: &Tile<f64, 7>,
        texels: &[usize],
        directions: &mut [R],
        pdf: &mut [R],
        weights: &mut [R],
    ) {
        let mut drawn = Tile::new();
        self.map.visit_canonical(DrawTile {
            turn: self.into_world,
            input: cells,
            count: drafts.len(),
            output: &mut drawn,
        });
        vectorize(
            #[inline(always)]
            || self.store(&drawn, texels, directions, pdf, weights),
        );
        if drafts.iter().all(|draft| draft.valid) {
            return;
        }
        for (k, draft) in drafts.iter().enumerate() {
            if !draft.valid {
                let nan = R::new(f64::NAN);
                directions[3 * k..3 * k + 3].fill(nan);
                pdf[k] = nan;
                if !weights.is_empty() {
                    weights[k * self.channels..][..self.channels].fill(nan);
                }
            }
        }
    }

    /// Directions as they are stored, densities and weights.
    #[inline(always)]
    fn store<R: Scalar>(
        &self,
        Tile([x, y, z]): &Tile<f64, 3>,
        texels: &[usize],
        directions: &mut [R],
        pdf: &mut [R],
        weights: &mut [R],
    ) {
        for (k, out) in directions.as_chunks_mut::<3>().0.iter_mut().enumerate() {
            *out = [x[k], y[k], z[k]].map(R::new);
        }
        if weights.is_empty() {
            for (pdf, texel) in pdf.iter_mut().zip(texels.iter()) {
                *pdf = R::new(f64::from(self.density[*texel]));
            }
        } else {
            match (&self.records, self.channels) {
                (Radiance::Single(records), 3) => {
                    weigh::<R, _, 3>(records, 3, texels, pdf, weights)
                }
                (Radiance::Single(records), c) => {
                    weigh::<R, _, 0>(records, c, texels, pdf, weights)
                }
                (Radiance::Double(records), c) => {
                    weigh::<R, _, 0>(records, c, texels, pdf, weights)
                }
            }
        }
    }

    #[inline(always)]
    fn is_crooked(&self, row: usize, column: usize) -> bool {
        let words = self.columns.div_ceil(64);
        self.crooked[row * words + column / 64] >> (column % 64) & 1 != 0
    }
}

/// Densities and weights from the records of texels. CHANNELS is 0 where their number is known at run time only.
#[inline(always)]
fn weigh<R: Scalar, T: Real, const CHANNELS: usize>(
    records: &[T],
    channels: usize,
    texels: &[usize],
    pdf: &mut [R],
    weights: &mut [R],
) {
    let c = if CHANNELS == 0 { channels } else { CHANNELS };
    let places = pdf.iter_mut().zip(weights.chunks_exact_mut(c));
    for ((pdf, weights), texel) in places.zip(texels) {
        let record = &records[texel * (c + 1)..][..=c];
        let density = record[c].to_f64();
        *pdf = R::new(density);
        let inverse = 1.0 / density;
        for (weight, x) in weights.iter_mut().zip(record) {
            *weight = R::new(x.to_f64() * inverse);
        }
    }
}
