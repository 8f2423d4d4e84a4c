//! Texels across a rim: whose is the part of the sphere that they cover?
//!
//! A texel whose center lies outside the valid image holds no value (photographers print their credits
//! there), yet its corner may cover a little of the sphere. That part belongs to the nearest texel that
//! holds a value, so that nothing outside leaks in and the weights still sum to the coverage.

use crate::error::{Error, expect_length};
use crate::image::raster::Raster;
use crate::image::texels::SolidAngles;
use crate::kernel::memory::expect_room;
use crate::kernel::threads;
use crate::map::Map;

/// The texel that holds the value of texel (i, j) of a face: itself, or the nearest whose center lies in
/// the valid image. Of several at one distance it is the first by row and column.
pub fn nearest_valid_texel(raster: &Raster, i: usize, j: usize) -> (usize, usize) {
    let (x, y) = (i as isize, j as isize);
    if raster.holds(x, y) {
        return (i, j);
    }
    let longest = raster.width.max(raster.height) as isize;
    let mut nearest: Option<(isize, isize, isize)> = None;
    for reach in 1..=longest {
        // Whatever lies on a ring is at least its half side away.
        if nearest.is_some_and(|(squared, _, _)| squared < reach * reach) {
            break;
        }
        let mut look = |a: isize, b: isize| {
            let squared = (a - x).pow(2) + (b - y).pow(2);
            if raster.holds(a, b) && nearest.is_none_or(|best| (squared, b, a) < best) {
                nearest = Some((squared, b, a));
            }
        };
        // Nothing beyond the image is looked at: one may be much longer than wide.
        for b in (y - reach).max(0)..=(y + reach).min(raster.height as isize - 1) {
            if (b - y).abs() == reach {
                let ends = (x - reach).max(0)..=(x + reach).min(raster.width as isize - 1);
                ends.for_each(|a| look(a, b));
            } else {
                look(x - reach, b);
                look(x + reach, b);
            }
        }
    }
    nearest.map_or((i, j), |(_, b, a)| (a as usize, b as usize))
}

/// A texel of a face that lies across the rim: it covers some of the sphere and holds no value.
#[derive(Clone, Copy, Debug)]
pub struct Across {
    /// Where it is.
    pub texel: [usize; 2],
    /// The texel that its part counts with.
    pub owner: [usize; 2],
}

/// All texels across the rim of a face, by rows, for which `covers(i, j)`. Where no texel of the image holds a value, each
/// is its own owner and none is listed.
pub fn across(raster: &Raster, covers: impl Fn(usize, usize) -> bool + Sync) -> Vec<Across> {
    if !raster.has_rim() {
        return Vec::new();
    }
    let mut rows = vec![Vec::new(); raster.height];
    threads::rows(&mut rows, 1, raster.width * raster.height * 4, |j, row| {
        for i in 0..raster.width {
            if !raster.holds(i as isize, j as isize) && covers(i, j) {
                let (a, b) = nearest_valid_texel(raster, i, j);
                if (a, b) != (i, j) {
                    row[0].push(Across {
                        texel: [i, j],
                        owner: [a, b],
                    });
                }
            }
        }
    });
    rows.concat()
}

/// Which stored texels hold a value, 1 or 0 each: none outside the valid image, and none where no face is. Of an image of which no texel
/// does, each stands for itself.
///
/// # Errors
/// The shape is none of the map's, or `out` has not one number a texel.
pub(crate) fn held(map: &Map, shape: &[usize], out: &mut [u8]) -> Result<(), Error> {
    let raster = Raster::new(map, shape)?;
    expect_length("out", out.len(), raster.texels())?;
    let has_rim = raster.has_rim() && raster.holds_any();
    threads::rows(out, raster.columns, raster.texels() * 4, |row, out| {
        out.fill(0);
        for run in raster.runs(row) {
            let Some((_, start, step)) = run.face else {
                continue;
            };
            let here = &mut out[run.column..run.column + run.length];
            if !has_rim {
                here.fill(1);
                continue;
            }
            for (k, held) in here.iter_mut().enumerate() {
                let [i, j] = [0, 1].map(|axis| start[axis] + k as isize * step[axis]);
                *held = u8::from(raster.holds(i, j));
            }
        }
    });
    Ok(())
}

/// The solid angle of each texel of a face, row by row.
pub(crate) fn face_solid_angles(map: &Map, raster: &Raster) -> Vec<f64> {
    let (w, h) = (raster.width, raster.height);
    let mut solid_angles = vec![0.0; w * h];
    let cells = SolidAngles::new(map, raster);
    threads::rows(&mut solid_angles, w, w * h * 16, |j, row| {
        cells.row(map, raster, j, 0, row);
    });
    solid_angles
}

/// The solid angle that each texel of a face stands for, row by row; 0 where it holds no value. Those of all faces sum to the
/// coverage.
pub fn face_weights(map: &Map, raster: &Raster) -> Vec<f64> {
    let w = raster.width;
    let mut weights = face_solid_angles(map, raster);
    for Across { texel, owner } in across(raster, |i, j| weights[j * w + i] > 0.0) {
        let part = std::mem::take(&mut weights[texel[1] * w + texel[0]]);
        weights[owner[1] * w + owner[0]] += part;
    }
    weights
}

/// The solid angle that each stored texel counts with in a sum: its own and, inside a rim, that of texels across it; 0 where
/// it holds no value. They sum to the coverage.
///
/// # Errors
/// The shape is none of the map's, or `out` has not one number a texel.
///
/// ```
/// use spheremap::{Map, image::weights};
/// let ball = Map::new("sphere")?;
/// let mut weight = [0.0; 8 * 8];
/// weights(&ball, &[8, 8], &mut weight)?;
/// assert_eq!(weight[0], 0.0);
/// assert!((weight.iter().sum::<f64>() - 4.0 * std::f64::consts::PI).abs() < 1e-12);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn weights(map: &Map, shape: &[usize], out: &mut [f64]) -> Result<(), Error> {
    let raster = Raster::new(map, shape)?;
    expect_length("out", out.len(), raster.texels())?;
    expect_room::<f64>(raster.width * raster.height)?;
    let weights = face_weights(map, &raster);
    out.fill(0.0);
    for face in 0..raster.faces() {
        let view = raster.view(face);
        for (j, row) in weights.chunks_exact(raster.width).enumerate() {
            for (i, weight) in row.iter().enumerate() {
                out[view.index(i, j)] = *weight;
            }
        }
    }
    Ok(())
}
