//! Drawing samples.

use super::refine::Refine;
use super::search::{BELOW_ONE, WINDOW, bucket, position, search};
use super::{Distribution, Records};
use crate::error::{Error, expect_length};
use crate::kernel::threads;
use crate::kernel::tile::prefetch_item;
use crate::kernel::tile::{TILE, Tile};
use crate::kernel::{Scalar, SimdWork, run_simd, vectorize};
use crate::map::verbs::DrawTile;
use crate::number::math::min;
use crate::number::real::Real;
use crate::projections::projection::Coverage;
use fearless_simd::Simd;

/// Samples that one thread draws before it looks for more work.
const JOB: usize = 16 * TILE;

/// What a tile of samples knows between two passes.
struct Drafts {
    row: [u32; TILE],
    guess: [u32; TILE],
    /// The number that decides on the column.
    x: [f64; TILE],
    /// Where in the row the sample lies, 0 to 1.
    t: [f64; TILE],
    valid: [bool; TILE],
}

impl Drafts {
    fn new() -> Self {
        Drafts {
            row: [0; TILE],
            guess: [0; TILE],
            x: [0.0; TILE],
            t: [0.0; TILE],
            valid: [false; TILE],
        }
    }
}

impl Distribution {
    /// Draws a world direction for each pair of numbers in [0, 1], with its density and, if there is room
    /// for them, its texel's channels over the density. All are NaN for a pair that is not in there.
    ///
    /// # Errors
    /// The slices' lengths do not go together.
    ///
    /// ```
    /// use spheremap::light::distribution::Distribution;
    /// use spheremap::{Map, image::ImageView};
    /// let map = Map::new("latlong")?;
    /// let mut sky = vec![0.0; 4 * 8];
    /// sky[12] = 1.0; // one bright texel
    /// let light = Distribution::new(&ImageView::new(&map, &[4, 8], 1, &sky)?, &sky)?;
    /// let (mut direction, mut pdf, mut weight) = ([0.0_f64; 3], [0.0], [0.0]);
    /// light.sample(&[0.3, 0.7], &mut direction, &mut pdf, &mut weight)?;
    /// let (_, uv) = map.encode_one(direction.into()).expect("a direction");
    /// assert_eq!(((uv.x * 8.0) as usize, (uv.y * 4.0) as usize), (4, 1));
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn sample<R: Scalar>(
        &self,
        xi: &[R],
        directions: &mut [R],
        pdf: &mut [R],
        weights: &mut [R],
    ) -> Result<(), Error> {
        expect_length("xi", xi.len(), 2 * pdf.len())?;
        expect_length("directions", directions.len(), 3 * pdf.len())?;
        if !weights.is_empty() {
            expect_length("weights", weights.len(), self.channels * pdf.len())?;
        }
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
        Ok(())
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
        let (mut drafts, mut next) = (Drafts::new(), Drafts::new());
        let mut coming = xi.chunks(2 * TILE);
        self.draft(coming.next().unwrap_or_default(), &mut next);
        let (mut cells, mut texels) = (Tile::new(), [0; TILE]);
        let tiles = directions.chunks_mut(3 * TILE).zip(pdf.chunks_mut(TILE));
        for (directions, pdf) in tiles {
            std::mem::swap(&mut drafts, &mut next);
            let texels = &mut texels[..pdf.len()];
            self.find_cells(&drafts, &mut cells, texels, each > 0);
            // The next tile's part of the tables is on its way while this one is computed.
            self.draft(coming.next().unwrap_or_default(), &mut next);
            let (here, rest) = std::mem::take(&mut weights).split_at_mut(each * pdf.len());
            weights = rest;
            self.finish(&drafts, &cells, texels, directions, pdf, here);
        }
    }

    /// Rows, and where the search for the column will begin.
    fn draft<R: Scalar>(&self, xi: &[R], drafts: &mut Drafts) {
        struct Draft<'a, R>(&'a Distribution, &'a [R], &'a mut Drafts);
        impl<R: Scalar> SimdWork for Draft<'_, R> {
            #[inline(always)]
            fn run<S: Simd>(self, simd: S) {
                self.0.draft_here(simd, self.1, self.2);
            }
        }
        run_simd(Draft(self, xi, drafts));
    }

    #[inline(always)]
    fn draft_here<S: Simd, R: Scalar>(&self, simd: S, xi: &[R], drafts: &mut Drafts) {
        let (stride, entries) = (self.columns + 1, self.buckets + 1);
        let xi = xi.as_chunks::<2>().0;
        let n = xi.len().min(TILE);
        let (mut y, mut ends) = ([0.0; TILE], [[0.0; TILE]; 2]);
        for (k, xi) in xi[..n].iter().enumerate() {
            let [a, b] = xi.map(Scalar::to_f64);
            let unit = 0.0..=1.0;
            let valid = unit.contains(&a) & unit.contains(&b);
            drafts.valid[k] = valid;
            drafts.x[k] = min(f64::choose(valid, a, 0.5), BELOW_ONE);
            y[k] = min(f64::choose(valid, b, 0.5), BELOW_ONE);
        }
        for k in 0..n {
            let guess = self.marginal_guide[bucket(y[k], self.marginal_guide.len())] as usize;
            let row = search(simd, &self.marginal, &self.marginal_guide, guess, y[k]);
            (ends[0][k], ends[1][k]) = (self.marginal[row], self.marginal[row + 1]);
            drafts.row[k] = row as u32;
            prefetch_item(&self.guide, row * entries + bucket(drafts.x[k], entries));
        }
        for k in 0..n {
            drafts.t[k] = position(y[k], [ends[0][k], ends[1][k]]);
        }
        for k in 0..n {
            let row = drafts.row[k] as usize;
            drafts.guess[k] = self.guide[row * entries + bucket(drafts.x[k], entries)];
            let at = row * stride + drafts.guess[k] as usize;
            prefetch_item(&self.conditional, at);
            prefetch_item(&self.conditional, at + WINDOW);
        }
    }

    /// Rectangles with the two numbers that say where in them a sample lies, and their texels.
    fn find_cells(
        &self,
        drafts: &Drafts,
        cells: &mut Tile<f64, 7>,
        texels: &mut [usize],
        weighted: bool,
    ) {
        struct FindCells<'a>(
            &'a Distribution,
            &'a Drafts,
            &'a mut Tile<f64, 7>,
            &'a mut [usize],
            bool,
        );
        impl SimdWork for FindCells<'_> {
            #[inline(always)]
            fn run<S: Simd>(self, simd: S) {
                self.0.find_cells_here(simd, self.1, self.2, self.3, self.4);
            }
        }
        run_simd(FindCells(self, drafts, cells, texels, weighted));
    }

    #[inline(always)]
    fn find_cells_here<S: Simd>(
        &self,
        simd: S,
        drafts: &Drafts,
        cells: &mut Tile<f64, 7>,
        texels: &mut [usize],
        weighted: bool,
    ) {
        let (stride, entries) = (self.columns + 1, self.buckets + 1);
        let n = texels.len().min(TILE);
        let (mut columns, mut ends) = ([0; TILE], [[0.0; TILE]; 2]);
        let Tile([u0, u1, v0, v1, faces, s, t]) = cells;
        for k in 0..n {
            let (number, x) = (drafts.row[k] as usize, drafts.x[k]);
            let function = &self.conditional[number * stride..][..stride];
            let guide = &self.guide[number * entries..][..entries];
            let column = search(simd, function, guide, drafts.guess[k] as usize, x);
            let row = &self.rows[number];
            let i = if self.split == 1 {
                column
            } else {
                (column as u32 / self.split as u32) as usize
            };
            texels[k] = row.texel + i;
            if weighted {
                self.prefetch_record(texels[k]);
            } else {
                prefetch_item(&self.density, texels[k]);
            }
            (ends[0][k], ends[1][k]) = (function[column], function[column + 1]);
            (u0[k], u1[k]) = (self.edges[column], self.edges[column + 1]);
            (v0[k], v1[k], faces[k]) = (row.v0, row.v1, row.face);
            columns[k] = column;
        }
        for k in 0..n {
            s[k] = position(drafts.x[k], [ends[0][k], ends[1][k]]);
            t[k] = drafts.t[k];
        }
        if !self.nonlinear.is_empty() {
            for (k, column) in columns[..n].iter().enumerate() {
                if self.is_crooked(drafts.row[k] as usize, *column) {
                    cells.set(k, self.straightened(cells.at(k)));
                }
            }
        }
    }

    #[inline(never)]
    fn straightened(&self, cell: [f64; 7]) -> [f64; 7] {
        self.map.visit_canonical(Refine(cell))
    }

    #[inline(always)]
    fn prefetch_record(&self, texel: usize) {
        let at = texel * (self.channels + 1);
        match &self.records {
            Records::Single(records) => prefetch_item(records, at),
            Records::Double(records) => prefetch_item(records, at),
        }
    }

    /// From rectangles to directions, densities and weights.
    #[inline(never)]
    fn finish<R: Scalar>(
        &self,
        drafts: &Drafts,
        cells: &Tile<f64, 7>,
        texels: &[usize],
        directions: &mut [R],
        pdf: &mut [R],
        weights: &mut [R],
    ) {
        let within;
        let rounds = size_of::<R>() == size_of::<f32>();
        let input = if rounds && self.map.coverage() != Coverage::Sphere {
            within = inset(cells);
            &within
        } else {
            cells
        };
        let mut drawn = Tile::new();
        self.map.visit_canonical(DrawTile {
            turn: self.into_world,
            input,
            count: pdf.len(),
            output: &mut drawn,
        });
        vectorize(
            #[inline(always)]
            || self.store(&drawn, texels, directions, pdf, weights),
        );
        let valid = &drafts.valid[..pdf.len()];
        if valid.iter().all(|valid| *valid) {
            return;
        }
        let nan = R::NAN;
        for (k, _) in valid.iter().enumerate().filter(|(_, valid)| !**valid) {
            directions[3 * k..3 * k + 3].fill(nan);
            pdf[k] = nan;
            if !weights.is_empty() {
                weights[k * self.channels..][..self.channels].fill(nan);
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
                (Records::Single(records), 3) => weigh::<R, _, 3>(records, 3, texels, pdf, weights),
                (Records::Single(records), c) => weigh::<R, _, 0>(records, c, texels, pdf, weights),
                (Records::Double(records), c) => weigh::<R, _, 0>(records, c, texels, pdf, weights),
            }
        }
    }

    #[inline(always)]
    fn is_crooked(&self, row: usize, column: usize) -> bool {
        let words = self.columns.div_ceil(64);
        self.nonlinear[row * words + column / 64] >> (column % 64) & 1 != 0
    }
}

/// Rectangles as far inside the image as float32 directions are rounded: drawn on its edge, they would lie beyond it.
fn inset(cells: &Tile<f64, 7>) -> Tile<f64, 7> {
    const EDGE: f64 = 4.0 * f32::EPSILON as f64;
    let mut cells = *cells;
    for x in cells.0[..4].as_flattened_mut() {
        *x = x.clamp(EDGE, 1.0 - EDGE);
    }
    cells
}

/// Densities and weights from the records of texels. CHANNELS is 0 where their number is known at run time only.
#[inline(always)]
fn weigh<R: Scalar, T: Scalar, const CHANNELS: usize>(
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
