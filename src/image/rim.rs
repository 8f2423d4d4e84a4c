//! Texels across a rim: whose is the part of the sphere that they cover?
//!
//! A texel whose center lies outside the valid image holds no value (photographers print their credits
//! there), yet its corner may cover a little of the sphere. That part belongs to the nearest texel that
//! holds a value, so that nothing outside leaks in and the weights still sum to the coverage.

use crate::error::Error;
use crate::image::raster::Raster;
use crate::image::texels::solid_angles;
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
        for b in y - reach..=y + reach {
            let whole_row = (b - y).abs() == reach;
            let step = if whole_row { 1 } else { 2 * reach as usize };
            for a in (x - reach..=x + reach).step_by(step) {
                let squared = (a - x).pow(2) + (b - y).pow(2);
                if raster.holds(a, b) && nearest.is_none_or(|best| (squared, b, a) < best) {
                    nearest = Some((squared, b, a));
                }
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

/// The solid angle that each stored texel stands for; 0 where it holds no value. They sum to the
/// coverage.
pub fn weights(map: &Map, shape: &[usize], out: &mut [f64]) -> Result<(), Error> {
    let raster = Raster::new(map, shape)?;
    solid_angles(map, shape, out)?;
    if !raster.has_rim() {
        return Ok(());
    }
    for face in 0..map.info().faces {
        let view = raster.view(face);
        let covers = |i, j| out[view.index(i, j)] > 0.0;
        for Across { texel, owner } in across(&raster, covers) {
            let part = std::mem::take(&mut out[view.index(texel[0], texel[1])]);
            out[view.index(owner[0], owner[1])] += part;
        }
    }
    Ok(())
}
