//! The texels of an image as places on the sphere: their centers, directions and solid angles.

use crate::error::{Error, expect_length};
use crate::geometry::axes::Rotation;
use crate::geometry::solid_angle::Rect;
use crate::image::raster::{Block, Raster};
use crate::kernel::Scalar;
use crate::kernel::threads;
use crate::kernel::tile::{TILE, Tile, TuplesMut};
use crate::map::Map;
use crate::map::grid::GridAxis;
use crate::map::verbs::DecodeTile;
use glam::DMat3;

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
/// The shape is none of the map's, or `out` has not three numbers a texel.
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
    let turn: Rotation = map.view_rotation(rotation).inverse();
    let raster = Raster::new(map, shape)?;
    expect_length("out", out.len(), raster.texels().saturating_mul(3))?;
    let centers = Centers::new(&raster);
    let width = 3 * raster.columns;
    threads::bands(out, width, raster.texels(), 1, |first, band| {
        let mut uv = Tile::new();
        raster.blocks(first, band.len() / width, (TILE, 1), |block| {
            let out = &mut band[3 * block.start..][..3 * block.columns];
            if block.face.is_none() {
                return out.fill(R::NAN);
            }
            centers.of(&block, &mut uv);
            map.visit_canonical(DecodeTile {
                turn,
                input: &uv,
                output: TuplesMut::of(out),
            });
        });
    });
    Ok(())
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
    threads::rows(out, raster.columns, raster.texels() * 16, |row, out| {
        for run in raster.runs(row) {
            let out = &mut out[run.column..][..run.length];
            let Some((_, start, step)) = run.face else {
                out.fill(0.0);
                continue;
            };
            for (k, out) in out.iter_mut().enumerate() {
                let at = |axis: usize| (start[axis] + k as isize * step[axis]) as usize;
                let (u0, u1) = raster.along_u.cell(at(0));
                let (v0, v1) = raster.along_v.cell(at(1));
                *out = map.solid_angle(Rect { u0, u1, v0, v1 });
            }
        }
    });
    Ok(())
}
