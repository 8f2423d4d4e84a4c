//! The grid that samples are drawn on, with the solid angles of its cells, and in which of them the map's
//! density is as good as straight.

use super::row::Row;
use crate::error::Error;
use crate::image::raster::Raster;
use crate::kernel::memory::expect_room;
use crate::kernel::pages;
use crate::kernel::threads;
use crate::map::Map;
use crate::map::row_of_cells::RowOfCells;
use crate::map::verbs::DensityCanonical;
use crate::projections::projection::Outline;

/// The most that the density of a cell may be off when it is taken for straight, relative.
pub const STRAIGHT: f64 = 8e-6;

/// The grid that samples are drawn on: texels, or parts of them.
#[derive(Clone)]
pub(super) struct Cells {
    pub(super) columns: usize,
    pub(super) split: usize,
    pub(super) edges: Vec<f64>,
    pub(super) rows: Vec<Row>,
    /// Row by row, each after one to skip; negative where the density is not straight.
    pub(super) solid_angles: Vec<f64>,
    pub(super) nonlinear: Vec<u64>,
}

impl Cells {
    /// At least `fine` cells along each side of a face, but for maps that need no finer grid.
    pub(super) fn new(map: &Map, raster: &Raster, fine: usize) -> Result<Cells, Error> {
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
        expect_room::<f64>(height * split_v * faces * (columns + 1))?;
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
        let nonlinear = signs(&solid_angles, columns);
        Ok(Cells {
            columns,
            split,
            edges,
            rows,
            solid_angles,
            nonlinear,
        })
    }

    pub(super) fn nonlinear_share(&self) -> f64 {
        let nonlinear: u32 = self.nonlinear.iter().map(|word| word.count_ones()).sum();
        f64::from(nonlinear) / self.solid_angles.len() as f64
    }
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
    let columns = edges.len() - 1;
    let mut out = vec![0.0; rows.len() * (columns + 1)];
    pages::advise(&mut out);
    let points = out.len();
    // One cell costs as much as many points.
    threads::rows(&mut out, columns + 1, points * 16, |number, out| {
        let row = rows[number];
        map.visit_canonical(RowOfCells {
            edges,
            sides: [row.v0, row.v1],
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
pub(super) fn is_straight(corners: [f64; 4], area: f64, solid_angle: f64) -> bool {
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
