//! Importance sampling: directions drawn as often as an image is bright there.
//!
//! The density is **exact for each texel**: p(ω) = L / ∫ L dω, constant per steradian within a texel, L its luminance.
//! So an estimate L/p has no variance within a texel, a texel at a pole or a rim has no infinite density, and a
//! density is looked up without evaluating the map's. (Drawing (u, v) evenly within a texel would be
//! simpler, but then 1/p follows dω/(du dv): infinite at the poles of a latlong, and of infinite variance at the rim of a
//! MatCap.)
//!
//! # How a sample is drawn
//!
//! By inverting distribution functions, v first and then u, so that a low-discrepancy set stays one: no alias table,
//! which is faster in its inner loop but scatters neighbours. Each search starts from a guide table (the cutpoint
//! method, Chen and Asau 1974), which leaves a step or two. A tile of samples goes through each step together:
//! the loads of one step do not wait for each other, and those of the next tile are under way while this one is
//! computed, which is what a table larger than the cache needs.
//!
//! Within a cell the density of the *map* must be inverted as well. Where it is nearly a straight line in v, and
//! then in u, the inverse is a root ([`crate::verbs::DrawCanonical`]). The grid of cells is the image's, cut into
//! whole parts until a face has [`FINE`] or [`FINER`] of them along each side; then a straight line is off by less than
//! [`STRAIGHT`].
//! The cells in which it is not (across a rim, beside a crease or a singular point) are halved, by exact solid angles of
//! the halves, until the part that holds the sample is straight.
//!
//! # What the number of threads and the CPU do to it
//!
//! Nothing: samples do not depend on each other, and sums run in a fixed order. (The solid angles in the tables
//! come from the platform's sine, as everywhere.)
//!
//! # What did not help, and what was left out
//!
//! Searching without fetching ahead (the misses of one sample wait for each other: 20 % slower at 1024×512, 35 % at
//! 4096×2048); a guide as fine as the cells (no faster: it takes the cache from the tables). Left out: tables in f32,
//! in which a dim texel beside a sun loses its digits; a density of its own for each end of a cell, twice
//! the memory for what two evaluations of the formula cost.

use super::rim::holder;
use super::solid_angle::Rect;
use crate::error::Error;
use crate::frame::Turn;
use crate::image::Raster;
use crate::kernel::{Scalar, prefetch_item};
use crate::map::Map;
use crate::projection::{Outline, Projection, Uv};
use crate::projections::Visitor;
use crate::real::Real;
use crate::sample::TILE;
use crate::threads;
use crate::verbs::{DensityCanonical, DrawCanonical, EncodeCanonical};
use glam::DMat3;

/// Cells along a side of a face, at least.
pub const FINE: usize = 512;

/// The same where more than one cell in [`FEW_CROOKED`] would not be straight: bisection is slow.
pub const FINER: usize = 2 * FINE;
const FEW_CROOKED: usize = 10;

/// The most that the density of a cell may be off when it is taken for straight, relative.
pub const STRAIGHT: f64 = 8e-6;

/// Fewer buckets take more steps of a search, and leave more of the cache to what is searched.
const COLUMNS_A_BUCKET: usize = 4;

/// How many edges a search looks at in one go.
const WINDOW: usize = 8;

/// Samples that one thread draws before it looks for more work.
const JOB: usize = 16 * TILE;

/// Samples keep this share of a cell away from its edges, where rounding decides on whose side they are.
const MARGIN: f64 = 1.0 / (1 << 24) as f64;

/// The largest number below 1.
const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// Texels that samples return, each divided by its density.
#[derive(Clone, Debug)]
pub enum Radiance {
    /// Single precision.
    Single(Vec<f32>),
    /// Double precision.
    Double(Vec<f64>),
}

/// A row of cells.
#[derive(Clone, Copy, Debug)]
struct Row {
    v0: f64,
    v1: f64,
    face: f64,
    /// Its first texel.
    texel: usize,
}

/// A density on the sphere, proportional to the luminance of an image.
#[derive(Debug)]
pub struct Distribution {
    map: Map,
    raster: Raster,
    into_view: Turn,
    into_world: Turn,
    /// Cells along u.
    columns: usize,
    /// Cells along u in a texel.
    split: usize,
    edges: Vec<f64>,
    rows: Vec<Row>,
    marginal: Vec<f64>,
    marginal_guide: Vec<u32>,
    /// For each row its distribution function, columns + 1 numbers from 0 to 1.
    conditional: Vec<f64>,
    guide: Vec<u32>,
    buckets: usize,
    /// A bit for each cell in which the map's density is not straight; empty if there is none.
    crooked: Vec<u64>,
    /// For each texel, face by face, the density per steradian.
    density: Vec<f32>,
    /// For each texel its channels, and its density once more: a sample finds both in one place.
    records: Radiance,
    channels: usize,
    integral: f64,
}

/// The grid that samples are drawn on: texels, or parts of them.
struct Cells {
    columns: usize,
    split: usize,
    edges: Vec<f64>,
    rows: Vec<Row>,
    /// Row by row, each after one to skip; negative where the density is not straight.
    solid_angles: Vec<f64>,
    crooked: Vec<u64>,
}

impl Cells {
    /// At least `fine` cells along each side of a face, but for maps that need no finer grid.
    fn new(map: &Map, raster: &Raster, fine: usize) -> Result<Cells, Error> {
        let (width, height, faces) = (raster.width, raster.height, map.info().faces);
        let parts = |n: usize| {
            if map.info().equal_area {
                1
            } else {
                fine.div_ceil(n)
            }
        };
        let (split, split_v) = (parts(width), parts(height));
        let columns = width * split;
        if columns >= u32::MAX as usize || height * split_v * faces >= u32::MAX as usize {
            return Err(Error::Shape(
                "the image has too many columns or rows".to_owned(),
            ));
        }
        let edges = cut((0..width).map(|i| raster.along_u.cell(i)), split);
        let down = cut((0..height).map(|j| raster.along_v.cell(j)), split_v);
        let row = |face: usize, k: usize| Row {
            v0: down[k],
            v1: down[k + 1],
            face: face as f64,
            texel: (face * height + k / split_v) * width,
        };
        let rows: Vec<Row> = (0..faces)
            .flat_map(|face| (0..height * split_v).map(move |k| (face, k)))
            .map(|(face, k)| row(face, k))
            .collect();
        let solid_angles = signed_solid_angles(map, &edges, &rows);
        let crooked = signs(&solid_angles, columns);
        Ok(Cells {
            columns,
            split,
            edges,
            rows,
            solid_angles,
            crooked,
        })
    }

    fn crooked_share(&self) -> f64 {
        let crooked: u32 = self.crooked.iter().map(|word| word.count_ones()).sum();
        f64::from(crooked) / self.solid_angles.len() as f64
    }
}

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
    /// The density of an image of a map: for each stored texel a luminance that is finite and not negative, and
    /// the channels that `sample` divides by the density.
    pub fn new(
        map: &Map,
        shape: &[usize],
        rotation: Option<DMat3>,
        luminance: &[f64],
        radiance: &Radiance,
        channels: usize,
    ) -> Result<Distribution, Error> {
        let raster = Raster::new(map, shape)?;
        let (width, height, faces) = (raster.width, raster.height, map.info().faces);
        let texels = width * height * faces;
        let stored = match radiance {
            Radiance::Single(texels) => texels.len(),
            Radiance::Double(texels) => texels.len(),
        };
        if luminance.len() != raster.texels() || stored != luminance.len() * channels {
            return Err(Error::Shape(format!(
                "Expected {} texels, got {} luminances and {stored} numbers of {channels} channels.",
                raster.texels(),
                luminance.len()
            )));
        }
        let mut cells = Cells::new(map, &raster, FINE)?;
        if cells.crooked_share() > 1.0 / FEW_CROOKED as f64 && width.min(height) < FINER {
            cells = Cells::new(map, &raster, FINER)?;
        }
        let Cells {
            columns,
            split,
            edges,
            rows,
            solid_angles: mut conditional,
            crooked,
        } = cells;
        let sources = sources(&raster, faces);
        let light: Vec<f64> = sources
            .iter()
            .map(|source| source.map_or(0.0, |texel| luminance[texel]))
            .collect();
        accumulate(&mut conditional, columns, split, &rows, &light);
        let mut marginal = Vec::with_capacity(rows.len() + 1);
        let mut integral = 0.0;
        marginal.push(0.0);
        for row in conditional.chunks_exact(columns + 1) {
            integral += row[columns];
            marginal.push(integral);
        }
        if !(integral > 0.0 && integral.is_finite()) {
            let what = if integral == 0.0 {
                "is black: there is nothing"
            } else {
                "is too bright"
            };
            return Err(Error::Contradiction(format!(
                "the image {what} to sample by (its luminance integrates to {integral})"
            )));
        }
        let points = conditional.len();
        threads::rows(&mut conditional, columns + 1, points, |_, row| {
            normalize(row)
        });
        normalize(&mut marginal);
        let buckets = columns.div_ceil(COLUMNS_A_BUCKET);
        let mut guide = vec![0; rows.len() * (buckets + 1)];
        threads::rows(&mut guide, buckets + 1, points, |row, guide| {
            fill_guide(&conditional[row * (columns + 1)..][..=columns], guide);
        });
        let mut marginal_guide = vec![0; 2 * rows.len() + 1];
        fill_guide(&marginal, &mut marginal_guide);

        let density: Vec<f32> = light
            .iter()
            .map(|light| (light / integral) as f32)
            .collect();
        let records = match radiance {
            Radiance::Single(stored) => {
                Radiance::Single(recorded(&sources, stored, channels, &density))
            }
            Radiance::Double(stored) => {
                Radiance::Double(recorded(&sources, stored, channels, &density))
            }
        };
        debug_assert_eq!(texels, sources.len());
        Ok(Distribution {
            map: map.clone(),
            raster,
            into_view: map.turn(rotation),
            into_world: map.turn(rotation).inverse(),
            columns,
            split,
            edges,
            rows,
            marginal,
            marginal_guide,
            conditional,
            guide,
            buckets,
            crooked,
            density,
            records,
            channels,
            integral,
        })
    }

    /// ∫ L dω of the luminance.
    pub fn integral(&self) -> f64 {
        self.integral
    }

    /// Numbers a texel.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// The density per steradian in world directions, three numbers each: 0 outside the coverage, NaN for
    /// what is no direction.
    pub fn pdf<R: Scalar>(&self, directions: &[R], out: &mut [R]) {
        threads::blocks(directions, 3, out, 1, |directions, out| {
            for (directions, out) in directions.chunks(3 * TILE).zip(out.chunks_mut(TILE)) {
                self.pdf_tile(directions, out);
            }
        });
    }

    fn pdf_tile<R: Scalar>(&self, directions: &[R], out: &mut [R]) {
        let mut uv = [R::default(); 3 * TILE];
        let uv = &mut uv[..directions.len()];
        self.map.visit_canonical(EncodeCanonical {
            turn: self.into_view,
            input: directions,
            output: uv,
        });
        let (w, h) = (self.raster.width, self.raster.height);
        let ((su, ou), (sv, ov)) = (self.raster.along_u.index(), self.raster.along_v.index());
        let mut index = [0; TILE];
        for (uv, index) in uv.as_chunks::<3>().0.iter().zip(&mut index) {
            // `as` takes NaN to 0.
            let i = ((uv[0].to_f64() * su + (ou + 0.5)) as usize).min(w - 1);
            let j = ((uv[1].to_f64() * sv + (ov + 0.5)) as usize).min(h - 1);
            *index = (uv[2].to_f64() as usize * h + j) * w + i;
        }
        for (out, index) in out.iter_mut().zip(&index) {
            *out = R::new(f64::from(self.density[*index]));
        }
        for (k, out) in out.iter_mut().enumerate() {
            if uv[3 * k].is_nan() {
                let d = [0, 1, 2].map(|c| directions[3 * k + c].to_f64());
                let direction = d.iter().all(|x| x.is_finite()) && d.iter().any(|x| *x != 0.0);
                *out = R::new(if direction { 0.0 } else { f64::NAN });
            }
        }
    }

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
        let tiles = directions.chunks_mut(3 * TILE).zip(pdf.chunks_mut(TILE));
        for (directions, pdf) in tiles {
            std::mem::swap(&mut drafts, &mut next);
            let drafts = &drafts[..pdf.len()];
            let (mut cells, mut texels) = ([0.0; 7 * TILE], [0; TILE]);
            let (cells, texels) = (&mut cells[..7 * pdf.len()], &mut texels[..pdf.len()]);
            self.find_cells(drafts, cells, texels, each > 0);
            // The next tile's part of the tables is on its way while this one is computed.
            self.draft(coming.next().unwrap_or_default(), &mut next);
            let (here, rest) = std::mem::take(&mut weights).split_at_mut(each * pdf.len());
            weights = rest;
            self.finish(drafts, cells, texels, directions, pdf, here);
        }
    }

    /// Rows, and where the search for the column will begin.
    fn draft<R: Scalar>(&self, xi: &[R], drafts: &mut [Draft]) {
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
    fn find_cells(
        &self,
        drafts: &[Draft],
        cells: &mut [f64],
        texels: &mut [usize],
        weighted: bool,
    ) {
        let (stride, entries) = (self.columns + 1, self.buckets + 1);
        let places = cells
            .as_chunks_mut::<7>()
            .0
            .iter_mut()
            .zip(texels.iter_mut());
        for (draft, (cell, texel)) in drafts.iter().zip(places) {
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
            *cell = [
                self.edges[column],
                self.edges[column + 1],
                row.v0,
                row.v1,
                row.face,
                position(function, column, draft.x),
                draft.t,
            ];
            if !self.crooked.is_empty() && self.is_crooked(number, column) {
                *cell = self.map.visit_canonical(Straighten(*cell));
            }
        }
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
    fn finish<R: Scalar>(
        &self,
        drafts: &[Draft],
        cells: &[f64],
        texels: &[usize],
        directions: &mut [R],
        pdf: &mut [R],
        weights: &mut [R],
    ) {
        let mut drawn = [0.0; 3 * TILE];
        let drawn = &mut drawn[..3 * drafts.len()];
        self.map.visit_canonical(DrawCanonical {
            turn: self.into_world,
            input: cells,
            output: drawn,
        });
        for (out, x) in directions.iter_mut().zip(drawn.iter()) {
            *out = R::new(*x);
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

    fn is_crooked(&self, row: usize, column: usize) -> bool {
        let words = self.columns.div_ceil(64);
        self.crooked[row * words + column / 64] >> (column % 64) & 1 != 0
    }
}

/// Densities and weights from the records of texels. CHANNELS is 0 where their number is known at run time only.
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

/// For each texel, face by face, the stored texel that holds its value; none where it covers nothing.
fn sources(raster: &Raster, faces: usize) -> Vec<Option<usize>> {
    let mut sources = vec![None; raster.width * raster.height * faces];
    threads::rows(
        &mut sources,
        raster.width,
        sources_work(raster, faces),
        |row, sources| {
            let (face, j) = (row / raster.height, row % raster.height);
            let view = raster.view(face);
            for (i, source) in sources.iter_mut().enumerate() {
                if covers_some(raster, i, j) {
                    let (a, b) = holder(raster, i, j);
                    *source = Some(view.index(a, b));
                }
            }
        },
    );
    sources
}

fn sources_work(raster: &Raster, faces: usize) -> usize {
    raster.width * raster.height * faces
}

/// Whether a part of texel (i, j) lies in the valid image.
fn covers_some(raster: &Raster, i: usize, j: usize) -> bool {
    if !raster.has_rim() {
        return true;
    }
    let ((u0, u1), (v0, v1)) = (raster.along_u.cell(i), raster.along_v.cell(j));
    if raster.outline == Outline::Shape {
        return raster.holds(i as isize, j as isize)
            || raster.solid_angle(Rect { u0, u1, v0, v1 }) > 0.0;
    }
    let (p, q) = (0.5_f64.clamp(u0, u1) - 0.5, 0.5_f64.clamp(v0, v1) - 0.5);
    p * p + q * q < 0.25
}

fn recorded<T: Real>(
    sources: &[Option<usize>],
    stored: &[T],
    channels: usize,
    density: &[f32],
) -> Vec<T> {
    let mut out = Vec::with_capacity(sources.len() * (channels + 1));
    for (source, density) in sources.iter().zip(density) {
        match source {
            Some(texel) => out.extend_from_slice(&stored[texel * channels..][..channels]),
            None => out.extend(std::iter::repeat_n(T::new(0.0), channels)),
        }
        out.push(T::new(f64::from(*density)));
    }
    out
}

/// The edges of texels, each cut into parts.
fn cut(texels: impl Iterator<Item = (f64, f64)>, parts: usize) -> Vec<f64> {
    let mut edges = vec![0.0];
    for (from, to) in texels {
        let inner = |k: usize| from + (to - from) * (k as f64 / parts as f64);
        edges.extend((1..parts).map(inner));
        edges.push(to);
    }
    edges
}

/// For each row of cells a zero and their solid angles, negative where the density is not straight.
fn signed_solid_angles(map: &Map, edges: &[f64], rows: &[Row]) -> Vec<f64> {
    struct RowOfCells<'a> {
        edges: &'a [f64],
        row: Row,
        out: &'a mut [f64],
    }
    impl Visitor for RowOfCells<'_> {
        type Output = ();
        fn visit<P: Projection>(self, p: P) {
            for (u, out) in self.edges.windows(2).zip(self.out) {
                *out = p.solid_angle(Rect {
                    u0: u[0],
                    u1: u[1],
                    v0: self.row.v0,
                    v1: self.row.v1,
                });
            }
        }
    }
    let columns = edges.len() - 1;
    let mut out = vec![0.0; rows.len() * (columns + 1)];
    let points = out.len();
    // One cell costs as much as many points.
    threads::rows(&mut out, columns + 1, points * 16, |number, out| {
        let row = rows[number];
        map.visit_canonical(RowOfCells {
            edges,
            row,
            out: &mut out[1..],
        });
        if map.info().equal_area && map.info().outline == Outline::Square {
            return;
        }
        let at_edge = |v: f64| {
            let uv: Vec<f64> = edges.iter().flat_map(|u| [*u, v, row.face]).collect();
            let mut density = vec![0.0; edges.len()];
            map.visit_canonical(DensityCanonical {
                input: &uv,
                output: &mut density,
            });
            density
        };
        let (above, below) = (at_edge(row.v0), at_edge(row.v1));
        for (k, out) in out[1..].iter_mut().enumerate() {
            let corners = [above[k], above[k + 1], below[k], below[k + 1]];
            let area = (edges[k + 1] - edges[k]) * (row.v1 - row.v0);
            if !is_straight(corners, area, *out) {
                *out = -*out;
            }
        }
    });
    out
}

/// Whether a density with these corners is nearly linear, given what it integrates to. The error of the
/// trapezoidal rule is that of a straight line at the ends of the cell.
fn is_straight(corners: [f64; 4], area: f64, solid_angle: f64) -> bool {
    let sum: f64 = corners.iter().sum();
    (0.25 * sum * area - solid_angle).abs() <= STRAIGHT * solid_angle
}

/// A bit for each negative number, `columns` a row after one to skip; nothing if there is none.
fn signs(signed: &[f64], columns: usize) -> Vec<u64> {
    let words = columns.div_ceil(64);
    let mut bits = vec![0; signed.len() / (columns + 1) * words];
    threads::rows(&mut bits, words, signed.len(), |row, bits| {
        for (k, x) in signed[row * (columns + 1)..][1..=columns]
            .iter()
            .enumerate()
        {
            bits[k / 64] |= u64::from(*x < 0.0) << (k % 64);
        }
    });
    if bits.iter().any(|word| *word != 0) {
        bits
    } else {
        Vec::new()
    }
}

/// From solid angles to the sums of luminance times solid angle, row by row.
fn accumulate(cells: &mut [f64], columns: usize, split: usize, rows: &[Row], light: &[f64]) {
    let points = cells.len();
    threads::rows(cells, columns + 1, points, |row, cells| {
        let light = &light[rows[row].texel..][..columns / split];
        let mut sum = 0.0;
        for (cells, light) in cells[1..].chunks_exact_mut(split).zip(light) {
            for cell in cells {
                sum += cell.abs() * light;
                *cell = sum;
            }
        }
    });
}

/// A sum, term by term, becomes a distribution function; without any mass all of it is in the first cell.
fn normalize(function: &mut [f64]) {
    let total = function[function.len() - 1];
    for x in &mut function[1..] {
        *x = if total > 0.0 { *x / total } else { 1.0 };
    }
}

/// The bucket of x < 1 in a guide of so many entries, one more than buckets.
#[inline(always)]
fn bucket(x: f64, entries: usize) -> usize {
    (x * (entries - 1) as f64) as usize
}

/// For each k/K the cell that it falls into.
fn fill_guide(function: &[f64], guide: &mut [u32]) {
    let last = guide.len() - 1;
    let mut cell = 0;
    for (k, guide) in guide.iter_mut().enumerate() {
        let x = (k as f64 / last as f64).min(BELOW_ONE);
        while function[cell + 1] <= x {
            cell += 1;
        }
        *guide = cell as u32;
    }
}

/// The cell with function[cell] <= x < function[cell + 1], for x < 1, from the one that the guide gave.
#[inline(always)]
fn search(function: &[f64], guide: &[u32], guess: usize, x: f64) -> usize {
    let mut cell = guess;
    // A product that rounds up to the next bucket may have led too far.
    while function[cell] > x {
        cell -= 1;
    }
    if let Some(window) = function.get(cell + 1..cell + 1 + WINDOW) {
        // Counted without a branch: where a search ends is what no CPU foresees.
        let passed: u32 = window.iter().map(|edge| u32::from(*edge <= x)).sum();
        cell += passed as usize;
        if passed < WINDOW as u32 {
            return cell;
        }
    }
    let last = guide[bucket(x, guide.len()) + 1] as usize + 1;
    let within = &function[cell + 1..=last.max(cell + 1)];
    cell + within.partition_point(|edge| *edge <= x)
}

/// Where x lies in its cell, 0 to 1, clear of the edges.
#[inline(always)]
fn position(function: &[f64], cell: usize, x: f64) -> f64 {
    let (from, to) = (function[cell], function[cell + 1]);
    ((x - from) / (to - from)).clamp(MARGIN, 1.0 - MARGIN)
}

/// Halves a cell, with the two numbers that say where in it a sample lies, until the map's density in the part
/// that holds the sample is straight.
struct Straighten([f64; 7]);

impl Visitor for Straighten {
    type Output = [f64; 7];

    fn visit<P: Projection>(self, p: P) -> [f64; 7] {
        let [mut u0, mut u1, mut v0, mut v1, face, mut s, mut t] = self.0;
        let solid_angle = |u0, u1, v0, v1| p.solid_angle(Rect { u0, u1, v0, v1 });
        let at = |u, v| Uv { u, v, face };
        let mut here = solid_angle(u0, u1, v0, v1);
        // 48 halvings leave 2⁻²⁴ of each side.
        for _ in 0..48 {
            let corners = [at(u0, v0), at(u1, v0), at(u0, v1), at(u1, v1)];
            let inside = corners.iter().all(|uv| p.contains(*uv));
            let area = (u1 - u0) * (v1 - v0);
            if inside && is_straight(corners.map(|uv| p.density(uv)), area, here) {
                return [u0, u1, v0, v1, face, s, t];
            }
            if u1 - u0 >= v1 - v0 {
                let middle = 0.5 * (u0 + u1);
                let a = solid_angle(u0, middle, v0, v1);
                let b = rest(here, a, || solid_angle(middle, u1, v0, v1));
                let first = choose(a, b, &mut s);
                (u0, u1, here) = if first {
                    (u0, middle, a)
                } else {
                    (middle, u1, b)
                };
            } else {
                let middle = 0.5 * (v0 + v1);
                let a = solid_angle(u0, u1, v0, middle);
                let b = rest(here, a, || solid_angle(u0, u1, middle, v1));
                let first = choose(a, b, &mut t);
                (v0, v1, here) = if first {
                    (v0, middle, a)
                } else {
                    (middle, v1, b)
                };
            }
        }
        let places = [
            (0.5 * (u0 + u1), 0.5 * (v0 + v1)),
            (u0, v0),
            (u1, v0),
            (u0, v1),
            (u1, v1),
        ];
        let held = places.into_iter().find(|(u, v)| p.contains(at(*u, *v)));
        let (u, v) = held.unwrap_or(places[0]);
        [u, u, v, v, face, 0.5, 0.5]
    }
}

/// What is left of a solid angle: the difference, or itself where that would cancel.
fn rest(whole: f64, part: f64, itself: impl Fn() -> f64) -> f64 {
    if part < 0.75 * whole {
        whole - part
    } else {
        itself()
    }
}

/// Whether x lies in the first of two parts of this mass; x becomes its place in its part.
fn choose(a: f64, b: f64, x: &mut f64) -> bool {
    let share = a / (a + b);
    let first = *x < share || b <= 0.0;
    let place = if first {
        *x / share
    } else {
        (*x - share) / (1.0 - share)
    };
    *x = place.clamp(0.0, 1.0);
    first
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Options;

    #[test]
    fn search_finds_the_cell_of_every_number() {
        let mut function = vec![0.0];
        let mut sum = 0.0;
        // Empty cells at both ends and in the middle, tiny ones, and one that holds nearly all.
        for mass in [0.0, 0.0, 1e-9, 1e-12, 0.0, 5.0, 1e-3, 0.0, 2.0, 0.0] {
            sum += mass;
            function.push(sum);
        }
        normalize(&mut function);
        for entries in [2, 5, 11, 64] {
            let mut guide = vec![0; entries];
            fill_guide(&function, &mut guide);
            let edges = function
                .iter()
                .flat_map(|x| [x.next_down(), *x, x.next_up()]);
            let even = (0..1000).map(|k| f64::from(k) / 1000.0);
            for x in edges.chain(even).filter(|x| (0.0..1.0).contains(x)) {
                let cell = search(&function, &guide, guide[bucket(x, entries)] as usize, x);
                assert!(function[cell] <= x && x < function[cell + 1], "{x} {cell}");
            }
        }
    }

    #[test]
    fn halves_keep_the_place_within() {
        let mut x = 0.25;
        assert!(choose(1.0, 1.0, &mut x));
        assert_eq!(x, 0.5);
        let mut x = 1.0;
        assert!(choose(2.0, 0.0, &mut x));
        assert_eq!(x, 1.0);
        let mut x = 0.0;
        assert!(!choose(0.0, 2.0, &mut x));
        assert_eq!(x, 0.0);
    }

    #[test]
    fn cells_of_a_fine_grid_are_straight_but_for_few() {
        for info in crate::projections::REGISTRY {
            let map = Map::new(info.name, Options::default()).unwrap();
            let shape = crate::image::shape_of_size(&map, FINE);
            let texels: usize = shape.iter().product();
            let light = vec![1.0; texels];
            let radiance = Radiance::Single(vec![1.0; texels]);
            let made = Distribution::new(&map, &shape, None, &light, &radiance, 1).unwrap();
            let crooked: u32 = made.crooked.iter().map(|word| word.count_ones()).sum();
            // Most of them, even of the MatCap, whose density rises without bound toward the rim.
            let cells = made.rows.len() * made.columns;
            let share = f64::from(crooked) / cells as f64;
            assert!(share < 0.4, "{} {share}", info.name);
            let total = map.coverage().solid_angle();
            assert!(
                (made.integral() / total - 1.0).abs() < 1e-9,
                "{}",
                info.name
            );
        }
    }
}
