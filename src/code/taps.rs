//! Which texels a bilinear lookup mixes, and how much of each: a shader that fetches them sees no seam.
//!
//! On maps of one rectangle the rules are those of lookups near an edge, `resample/seam.rs`, for the one texel beyond an
//! edge that two by two texels reach. What lies there is a texel of the image on three kinds of map, and the texel at the
//! edge where the coverage ends. Cubes have a rule of their own ([`crate::code::cube_taps`]). On other maps it is no single
//! texel. Along a side whose outer texels lie on the edges nothing is beyond.
//!
//! Singular: half a turn around from a texel of a row with an odd number lies between two, of which this takes the first.

use crate::code::bilinear::{Along, on_edges, weights};
use crate::code::cube_taps::{self, Cube};
use crate::error::Error;
use crate::map::{Grid, Map};
use crate::number::real::Real;
use crate::projections::projection::{Outline, Seam};

/// What lies beyond the edges of a map, where it is texels.
pub enum Rule {
    /// Texels of the one rectangle.
    Rectangle(Seam),
    /// Texels of other faces.
    Cube(Box<Cube>),
}

/// What lies beyond the edges of a map, where it is texels.
///
/// # Errors
/// It is not.
pub fn rule(map: &Map) -> Result<Rule, Error> {
    let info = map.info();
    let one = map.uv_width() == 2 && map.layout().is_none() && info.outline == Outline::Square;
    match map.seam() {
        seam @ (Seam::Latlong | Seam::Periodic | Seam::Octahedral | Seam::Ends) if one => {
            Ok(Rule::Rectangle(seam))
        }
        Seam::Faces if info.faces == cube_taps::FACES => Ok(Rule::Cube(Box::new(Cube::of(map)))),
        _ => Err(Error::Code(format!(
            "what lies beyond an edge of {} is no single texel; taps are printed for cubes, latlong, octahedral and \
             others whose seams join texel to texel",
            info.name
        ))),
    }
}

/// Four columns, four rows and four weights, of the texels about a place of an image with so many columns and rows.
pub fn rectangle<R: Real>(
    seam: Seam,
    grid: Grid,
    [u, v]: [R; 2],
    [width, height]: [R; 2],
) -> Vec<R> {
    let none = R::truth(false);
    let [edges_u, edges_v] = on_edges(grid);
    let (x, y) = (
        Along::new(u, width, edges_u),
        Along::new(v, height, edges_v),
    );
    let around = |i: R| {
        if edges_u {
            return x.held(i);
        }
        let i = R::select(i.less(R::ZERO), i + width, i);
        R::select(i.more(x.last), i - width, i)
    };
    let beyond = |axis: Along<R>, edges: bool, i: R| {
        if edges {
            none
        } else {
            i.less(R::ZERO) | i.more(axis.last)
        }
    };
    let texel = |i: R, j: R| {
        let (column, row) = (x.held(i), y.held(j));
        let over = beyond(y, edges_v, j);
        match seam {
            Seam::Latlong => {
                let turned = i + R::select(over, (width * R::HALF).floor(), R::ZERO);
                [around(turned), row]
            }
            Seam::Periodic => [around(i), row],
            Seam::Octahedral => [
                R::select(over, x.last - column, column),
                R::select(beyond(x, edges_u, i), y.last - row, row),
            ],
            _ => [column, row],
        }
    };
    let ([left, right], [top, bottom]) = (x.both(), y.both());
    let texels = [
        texel(left, top),
        texel(right, top),
        texel(left, bottom),
        texel(right, bottom),
    ];
    let places = [0, 1]
        .into_iter()
        .flat_map(|k| texels.map(|texel| texel[k]));
    places.chain(weights(x.part, y.part)).collect()
}
