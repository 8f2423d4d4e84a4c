//! The texels of an image as places on the sphere: their centers, directions and solid angles.

use crate::error::{Error, expect_length};
use crate::geometry::axes::{Rotation, expect_rotation};
use crate::geometry::solid_angle::Rect;
use crate::image::pieces::Pieces;
use crate::image::raster::{Block, Raster};
use crate::kernel::Scalar;
use crate::kernel::threads;
use crate::kernel::tile::{TILE, Tile, TuplesMut};
use crate::map::Map;
use crate::map::grid::GridAxis;
use crate::map::row_of_cells::RowOfCells;
use crate::map::verbs::DecodeTile;
use glam::DMat3;
use std::ops::Range;

/// The coordinates of all texel centers of a face: computed once a call, for they cost a division each.
pub struct Centers<R> {
    u: Vec<R>,
    v: Vec<R>,
}

impl<R: Scalar> Centers<R> {
    /// Those of a raster.
    pub fn new(raster: &Raster) -> Self {
        let along = |axis: GridAxis, n: usize| {
            let center = |i: usize| R::new(axis.center(i as f64));
            (0..n).map(center).collect()
        };
        Centers {
            u: along(raster.along_u, raster.width),
            v: along(raster.along_v, raster.height),
        }
    }

    /// Writes the canonical (u, v, face) of the texels of a block, row by row, at most [`TILE`] in all. The block must
    /// lie on a face.
    #[inline(always)]
    pub fn of(&self, block: &Block, uv: &mut Tile<R, 3>) {
        let Some((face, texel, [along, down])) = block.face else {
            return;
        };
        let [us, vs, faces] = &mut uv.0;
        faces[..block.columns * block.rows].fill(R::new(face as f64));
        for row in 0..block.rows {
            let here = row * block.columns..(row + 1) * block.columns;
            let (us, vs) = (&mut us[here.clone()], &mut vs[here]);
            let row = row as isize;
            let first = [texel[0] + row * down[0], texel[1] + row * down[1]];
            if along == [1, 0] {
                vs.fill(self.v[first[1] as usize]);
                us.copy_from_slice(&self.u[first[0] as usize..][..block.columns]);
            } else {
                for (k, (u, v)) in us.iter_mut().zip(vs).enumerate() {
                    let at = |axis: usize| (first[axis] + k as isize * along[axis]) as usize;
                    (*u, *v) = (self.u[at(0)], self.v[at(1)]);
                }
            }
        }
    }
}

/// The direction of every texel center, three numbers each; NaN outside the valid image. `rotation` turns the content.
///
/// # Errors
/// The shape is none of the map's, `out` has not three numbers a texel, or `rotation` is none.
///
/// ```
/// use spheremap::{Map, image::directions};
/// let mut toward = [0.0; 3 * 6];
/// directions(&Map::new("cube")?, &[6, 1, 1], None, &mut toward)?;
/// assert_eq!(toward[..3], [1.0, 0.0, 0.0]);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn directions<R: Scalar>(
    map: &Map,
    shape: &[usize],
    rotation: Option<DMat3>,
    out: &mut [R],
) -> Result<(), Error> {
    let raster = Raster::new(map, shape)?;
    expect_length("out", out.len(), raster.texels().saturating_mul(3))?;
    expect_rotation(rotation)?;
    let directions = Directions::new(map, &raster, rotation);
    threads::bands(
        out,
        3 * raster.columns,
        raster.texels(),
        1,
        |first, band| directions.rows(first, band),
    );
    Ok(())
}

/// Where the texels of an image look.
pub(crate) struct Directions<'a, R> {
    map: &'a Map,
    raster: &'a Raster,
    centers: Centers<R>,
    turn: Rotation,
}

impl<'a, R: Scalar> Directions<'a, R> {
    /// Of a raster of this map; `rotation` turns the content.
    pub(crate) fn new(map: &'a Map, raster: &'a Raster, rotation: Option<DMat3>) -> Self {
        Directions {
            map,
            raster,
            centers: Centers::new(raster),
            turn: map.view_rotation(rotation).inverse(),
        }
    }

    /// Writes those of stored rows from `first` on, as many as `out` has room for.
    pub(crate) fn rows(&self, first: usize, out: &mut [R]) {
        let mut uv = Tile::new();
        let rows = out.len() / (3 * self.raster.columns);
        self.raster.blocks(first, rows, (TILE, 1), |block| {
            let out = &mut out[3 * block.start..][..3 * block.columns];
            if block.face.is_none() {
                return out.fill(R::NAN);
            }
            self.centers.of(&block, &mut uv);
            self.map.visit_canonical(DecodeTile {
                turn: self.turn,
                input: &uv,
                output: TuplesMut::of(out),
            });
        });
    }
}

/// The exact solid angle of every texel, rims included; 0 where no face is.
///
/// # Errors
/// The shape is none of the map's, or `out` has not one number a texel.
///
/// ```
/// use spheremap::{Map, image::solid_angles};
/// let mut face = [0.0; 6];
/// solid_angles(&Map::new("cube")?, &[6, 1, 1], &mut face)?;
/// assert!((face[0] - 4.0 * std::f64::consts::PI / 6.0).abs() < 1e-15);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn solid_angles(map: &Map, shape: &[usize], out: &mut [f64]) -> Result<(), Error> {
    let raster = Raster::new(map, shape)?;
    expect_length("out", out.len(), raster.texels())?;
    let cells = SolidAngles::new(map, &raster);
    // Faces are alike. Where one is stored after the other, the first is found and the others are copies of it.
    let stacked = raster.texels() == raster.faces() * raster.width * raster.height
        && raster.columns == raster.width
        && raster.straight().is_some();
    let rows = if stacked { raster.height } else { raster.rows };
    let (own, copies) = out.split_at_mut(rows * raster.columns);
    let points = own.len() * 16;
    threads::rows(own, raster.columns, points, |row, out| {
        // The last row of a face that was found: its first texel, its length and its column.
        let mut known = None;
        for run in raster.runs(row) {
            let here = run.column..run.column + run.length;
            let Some((_, start, step)) = run.face else {
                out[here].fill(0.0);
                continue;
            };
            if step == [1, 0] {
                if let Some((texel, length, column)) = known
                    && (texel, length) == (start, run.length)
                {
                    out.copy_within(column..column + length, run.column);
                } else {
                    let [first, j] = start.map(|k| k as usize);
                    cells.row(map, &raster, j, first, &mut out[here]);
                    known = Some((start, run.length, run.column));
                }
                continue;
            }
            for (k, out) in out[here].iter_mut().enumerate() {
                let at = |axis: usize| (start[axis] + k as isize * step[axis]) as usize;
                *out = solid_angle_of(map, &raster, at(0), at(1));
            }
        }
    });
    let points = copies.len();
    threads::rows(copies, raster.columns, points, |row, out| {
        out.copy_from_slice(&own[row % rows * raster.columns..][..raster.columns]);
    });
    Ok(())
}

/// The solid angles of the texels of a face, row by row. Where the density is that of the row, those of a row differ by the rounding
/// of their widths, and each width is looked at once; elsewhere most are those of a few polynomials.
pub(crate) struct SolidAngles {
    /// Which width each column has, and a column of each width.
    alike: Option<(Vec<u32>, Vec<usize>)>,
    pieces: Option<Pieces>,
}

impl SolidAngles {
    /// Of a raster of this map.
    pub(crate) fn new(map: &Map, raster: &Raster) -> Self {
        let alike = map.has_even_rows().then(|| {
            let (mut widths, mut columns) = (Vec::new(), Vec::new());
            let which = (0..raster.width).map(|i| {
                let (u0, u1) = raster.along_u.cell(i);
                let width = u1 - u0;
                // Neighbors are often as wide.
                let known = widths.iter().rposition(|w| *w == width);
                known.unwrap_or_else(|| {
                    widths.push(width);
                    columns.push(i);
                    widths.len() - 1
                }) as u32
            });
            (which.collect(), columns)
        });
        let pieces = Pieces::new(map, raster);
        SolidAngles { alike, pieces }
    }

    /// That of texel (i, j).
    pub(crate) fn of(&self, map: &Map, raster: &Raster, i: usize, j: usize) -> f64 {
        let mut one = [0.0];
        self.row(map, raster, j, i, &mut one);
        one[0]
    }

    /// Those of parts of row j, from one side to another and between edges: of each the column that it is of is told.
    pub(crate) fn parts(
        &self,
        (map, raster): (&Map, &Raster),
        row: (usize, (f64, f64)),
        (columns, edges): (&[usize], &[f64]),
        out: &mut [f64],
    ) {
        let (_, (v0, v1)) = row;
        if self.alike.is_some() {
            let (u0, u1) = (0.0, 1.0);
            let whole = map.solid_angle(Rect { u0, u1, v0, v1 });
            for ((u0, u1), out) in edges.iter().zip(&edges[1..]).zip(out) {
                *out = whole * (u1 - u0);
            }
            return;
        }
        let by_themselves = |parts: Range<usize>, out: &mut [f64]| {
            map.visit_canonical(RowOfCells {
                edges: &edges[parts.start..=parts.end],
                sides: row.1.into(),
                out,
            });
        };
        match &self.pieces {
            Some(pieces) => {
                let own = (|k: usize| columns[k], edges);
                pieces.parts((map, raster), row, own, out, by_themselves);
            }
            None => by_themselves(0..out.len(), out),
        }
    }

    /// Those of the texels of row j from a column on.
    pub(crate) fn row(&self, map: &Map, raster: &Raster, j: usize, first: usize, out: &mut [f64]) {
        let one = |i| solid_angle_of(map, raster, i, j);
        match &self.alike {
            None => {
                let by_themselves = |columns: Range<usize>, out: &mut [f64]| {
                    map.visit_canonical(RowOfCells {
                        edges: &raster.along_u.edges(columns),
                        sides: raster.along_v.cell(j).into(),
                        out,
                    });
                };
                match &self.pieces {
                    Some(pieces) => pieces.row((map, raster), j, first, out, by_themselves),
                    None => by_themselves(first..first + out.len(), out),
                }
            }
            Some((_, columns)) if columns.len() == 1 => out.fill(one(columns[0])),
            Some((which, columns)) => {
                let known: Vec<f64> = columns.iter().map(|&i| one(i)).collect();
                for (out, which) in out.iter_mut().zip(&which[first..]) {
                    *out = known[*which as usize];
                }
            }
        }
    }
}

/// That of texel (i, j).
pub(crate) fn solid_angle_of(map: &Map, raster: &Raster, i: usize, j: usize) -> f64 {
    let (u0, u1) = raster.along_u.cell(i);
    let (v0, v1) = raster.along_v.cell(j);
    map.solid_angle(Rect { u0, u1, v0, v1 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::raster::shape_of_size;
    use crate::projections::REGISTRY;

    #[test]
    fn solid_angles_that_are_remembered_are_those_of_their_texels() {
        for info in REGISTRY {
            let map = Map::new(info.name).unwrap();
            if !map.has_even_rows() {
                continue;
            }
            // Widths that round in several ways.
            let shape = shape_of_size(&map, 2 * 35);
            let raster = Raster::new(&map, &shape).unwrap();
            let cells = SolidAngles::new(&map, &raster);
            let mut row = vec![0.0; raster.width];
            for j in [0, 17, raster.height - 1] {
                cells.row(&map, &raster, j, 0, &mut row);
                for (i, remembered) in row.iter().enumerate() {
                    let itself = solid_angle_of(&map, &raster, i, j);
                    assert_eq!(*remembered, itself, "{} {i} {j}", info.name);
                }
            }
        }
    }
}
