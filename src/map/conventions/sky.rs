//! Maps of the sky as healpy has them: longitude grows to the left, as seen from inside, with 0 in the middle and north up.

use super::{Convention, Known, programs};
use crate::map::grid::Grid;

const HEALPY: Convention = Convention {
    name: "healpy",
    version: "healpy 1.20.1",
    known: Known::Run,
    ..programs::HEALPY
};

/// What healpy computes with, and what it draws.
pub const TABLE: &[Convention] = &[
    Convention {
        kind: "healpix",
        axes: "+x +y +z",
        note: "Texel (y, x) of face f is nested pixel f nside² plus the bits of x and y in turn; `healpix.to_image` makes it of a map.",
        source: "healpy, pixelfunc",
        ..HEALPY
    },
    Convention {
        kind: "mollweide",
        axes: "-y -z +x",
        grid: Grid::Corners,
        note: "`mollview`; its arrays have the south in row 0.",
        source: "healpy, projector.MollweideProj",
        ..HEALPY
    },
    Convention {
        kind: "latlong",
        axes: "-y -z +x",
        grid: Grid::Corners,
        note: "`cartview`; its arrays have the south in row 0.",
        source: "healpy, projector.CartesianProj",
        ..HEALPY
    },
];
