//! Which texels a bilinear lookup mixes, and how much of each: a shader that fetches them sees no seam.
//!
//! The rules are those of lookups near an edge, `resample/seam.rs`, for the one texel beyond an edge that two by two texels
//! reach. What lies there is a texel of the image on three kinds of map, and the texel at the edge where the coverage ends. On
//! other maps it is no single texel: at an edge of a cube the library mixes up to twelve.
//!
//! Singular: half a turn around from a texel of a row with an odd number lies between two, of which this takes the first.

use crate::error::Error;
use crate::map::{Grid, Map};
use crate::number::real::Real;
use crate::projections::projection::{Outline, Seam};

/// How many numbers taps are: four columns, four rows, four weights.
pub const NUMBERS: usize = 12;

/// What lies beyond the edges of a map, where it is texels.
///
/// # Errors
/// It is not, or texels do not lie at centers.
pub fn rule(map: &Map) -> Result<Seam, Error> {
    let info = map.info();
    let one = map.uv_width() == 2 && map.layout().is_none() && info.outline == Outline::Square;
    match map.seam() {
        _ if map.grid() != Grid::Centers => Err(Error::Code(
            "taps are printed for maps whose texels lie at centers".to_owned(),
        )),
        seam @ (Seam::Latlong | Seam::Periodic | Seam::Octahedral | Seam::Ends) if one => Ok(seam),
        _ => Err(Error::Code(format!(
            "what lies beyond an edge of {} is no single texel; taps are printed for latlong, octahedral and \
             others whose seams join texel to texel",
            info.name
        ))),
    }
}

/// Four columns, four rows and four weights, of the texels about a place of an image with so many columns and rows.
pub fn taps<R: Real>(seam: Seam, [u, v]: [R; 2], [width, height]: [R; 2]) -> [R; NUMBERS] {
    let (zero, one, half) = (R::ZERO, R::ONE, R::HALF);
    let (x, y) = (u * width - half, v * height - half);
    let (left, top) = (x.floor(), y.floor());
    let (tx, ty) = (x - left, y - top);
    let (right, bottom) = (width - one, height - one);
    let held = |i: R, last: R| {
        let i = R::select(i.less(zero), zero, i);
        R::select(i.more(last), last, i)
    };
    let around = |i: R| {
        let i = R::select(i.less(zero), i + width, i);
        R::select(i.more(right), i - width, i)
    };
    let texel = |i: R, j: R| {
        let beside = i.less(zero) | i.more(right);
        let over = j.less(zero) | j.more(bottom);
        match seam {
            Seam::Latlong => {
                let turned = i + R::select(over, (width * half).floor(), zero);
                [around(turned), held(j, bottom)]
            }
            Seam::Periodic => [around(i), held(j, bottom)],
            Seam::Octahedral => {
                let (column, row) = (held(i, right), held(j, bottom));
                [
                    R::select(over, right - column, column),
                    R::select(beside, bottom - row, row),
                ]
            }
            _ => [held(i, right), held(j, bottom)],
        }
    };
    let corners = [
        texel(left, top),
        texel(left + one, top),
        texel(left, top + one),
        texel(left + one, top + one),
    ];
    let weights = [
        (one - tx) * (one - ty),
        tx * (one - ty),
        (one - tx) * ty,
        tx * ty,
    ];
    let [a, b, c, d] = corners;
    let [e, f, g, h] = weights;
    [a[0], b[0], c[0], d[0], a[1], b[1], c[1], d[1], e, f, g, h]
}
