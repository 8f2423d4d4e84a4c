//! Areas between images of one map that is not turned: a smaller or a larger copy.
//!
//! A texel of the target is a rectangle in the plane of one face of the source. It covers whole texels and, along its border, parts
//! of texels, all of them rectangles. What each sees is the density at two places each way (Gauss and Legendre), which is the solid angle but for
//! h⁴/4320 of the fourth derivative. As on the other paths, where these do not add up to the solid angle of the texel, as on
//! a crease of the density or across a rim, each is asked for exactly.
//!
//! What did not help: exact solid angles of all texels. For most maps they take longer than the path that knows nothing of all this.

use crate::geometry::solid_angle::Rect;
use crate::image::texel::Texel;
use crate::map::verbs::DensityCanonical;
use crate::resample::area::graticule::{edges, met};
use crate::resample::area::lattice::{Lattice, NOTHING};
use crate::resample::area::sweep::Add;
use crate::resample::request::Request;
use glam::DMat3;

/// Where the density is asked for, from the middle of an interval, in halves of its length.
const NODE: f64 = 0.577_350_269_189_625_8;

/// How far a sum of sizes may be from a cell's solid angle, relative: those of texels are no farther off, but for what cancels.
const CLOSE: f64 = 1e-8;

/// Cells of the source along the side of a cell of the target, at most; and parts of two more where edges do not lie on each other.
pub(super) const MOST: f64 = 16.0;

/// Whether both images are of one map and none is turned.
pub(super) fn serves<T: Texel>(request: Request<'_, T>) -> bool {
    let unturned = request.rotation.is_none_or(|r| r == DMat3::IDENTITY);
    unturned && request.image.map().same_formula(request.map)
}

/// An interval that a row or column of the source and one of the target have in common.
#[derive(Clone, Copy)]
struct Piece {
    /// The source's.
    at: usize,
    from: f64,
    to: f64,
}

/// Those of each row or column of a target.
struct Pieces {
    ends: Vec<usize>,
    all: Vec<Piece>,
}

impl Pieces {
    fn new(from: &Lattice<'_>, into: &Lattice<'_>, axis: usize) -> Pieces {
        let theirs: Vec<f64> = edges(from, axis).collect();
        let (mut ends, mut all) = (Vec::new(), Vec::new());
        for cell in 0..[into.columns, into.rows][axis] {
            let (a, b) = into.rectangle([cell; 2])[axis];
            for at in met(&theirs, [a, b]) {
                let (from, to) = (a.max(theirs[at]), b.min(theirs[at + 1]));
                if to - from > NOTHING * (b - a).min(theirs[at + 1] - theirs[at]) {
                    all.push(Piece { at, from, to });
                }
            }
            ends.push(all.len());
        }
        Pieces { ends, all }
    }

    fn start(&self, cell: usize) -> usize {
        cell.checked_sub(1).map_or(0, |before| self.ends[before])
    }

    /// Those of some of the target's.
    fn of(&self, from: usize, to: usize) -> &[Piece] {
        &self.all[self.start(from)..self.start(to)]
    }
}

/// What two images of a map have in common.
pub(super) struct Alike<'l, 'a> {
    from: &'l Lattice<'a>,
    into: &'l Lattice<'a>,
    columns: Pieces,
    rows: Pieces,
    /// Whether the density is the same all along a row.
    even: bool,
}

impl<'l, 'a> Alike<'l, 'a> {
    pub fn new(from: &'l Lattice<'a>, into: &'l Lattice<'a>) -> Self {
        let [columns, rows] = [0, 1].map(|axis| Pieces::new(from, into, axis));
        Alike {
            from,
            into,
            columns,
            rows,
            even: from.map.has_even_rows(),
        }
    }
}

/// Room for what is found of a row of cells.
#[derive(Default)]
pub(super) struct Room {
    /// Canonical (u, v, face) of places, and the densities there.
    places: Vec<f64>,
    densities: Vec<f64>,
    /// Of each row of pieces one after the other.
    sizes: Vec<f64>,
    shares: Vec<(usize, f64)>,
}

impl Alike<'_, '_> {
    /// Calls `add` with each of the target's cells from `low` to before `high` on a face, and what it covers of the source's texels.
    pub fn cells(
        &self,
        room: &mut Room,
        face: usize,
        low: [usize; 2],
        high: [usize; 2],
        add: Add<'_>,
    ) {
        let first = self.columns.start(low[0]);
        let across = self.columns.of(low[0], high[0]);
        for y in low[1]..high[1] {
            let down = self.rows.of(y, y + 1);
            self.sizes(room, face, across, down);
            for x in low[0]..high[0] {
                let [(u0, u1), (v0, v1)] = self.into.rectangle([x, y]);
                let whole = self.into.raster.solid_angle(Rect { u0, u1, v0, v1 });
                if whole <= 0.0 {
                    continue;
                }
                let own = self.columns.of(x, x + 1);
                let begin = self.columns.start(x) - first;
                let sizes = || {
                    let rows = room.sizes.chunks_exact(across.len());
                    rows.map(|row| &row[begin..][..own.len()])
                };
                let total: f64 = sizes().flatten().sum();
                room.shares.clear();
                if (total / whole - 1.0).abs() <= CLOSE {
                    for (row, sizes) in down.iter().zip(sizes()) {
                        let texel = |piece: &Piece| self.from.stored(face, [piece.at, row.at]);
                        let shares = own.iter().zip(sizes);
                        (room.shares).extend(shares.map(|(piece, size)| (texel(piece), *size)));
                    }
                } else {
                    self.exactly(face, own, down, &mut room.shares);
                }
                add([x, y], &room.shares);
            }
        }
    }

    /// Finds the sizes of rectangles, row by row.
    fn sizes(&self, room: &mut Room, face: usize, across: &[Piece], down: &[Piece]) {
        let nodes = |piece: &Piece| {
            let (middle, half) = (0.5 * (piece.from + piece.to), 0.5 * (piece.to - piece.from));
            [middle - NODE * half, middle + NODE * half]
        };
        let Room {
            places,
            densities,
            sizes,
            ..
        } = room;
        places.clear();
        sizes.clear();
        let even = &[Piece {
            at: 0,
            from: 0.0,
            to: 1.0,
        }][..];
        let asked = if self.even { even } else { across };
        // Twice, for two rows.
        for _ in 0..2 {
            let us = asked.iter().flat_map(nodes);
            places.extend(us.flat_map(|u| [u, 0.0, face as f64]));
        }
        densities.resize(places.len() / 3, 0.0);
        let row = 2 * asked.len();
        for piece in down {
            for (v, places) in nodes(piece)
                .into_iter()
                .zip(places.chunks_exact_mut(3 * row))
            {
                places.chunks_exact_mut(3).for_each(|place| place[1] = v);
            }
            self.from.map.visit_canonical(DensityCanonical {
                input: places,
                output: densities,
            });
            let (upper, lower) = densities.split_at(row);
            let height = 0.25 * (piece.to - piece.from);
            let both = |k: usize| upper[2 * k] + upper[2 * k + 1] + lower[2 * k] + lower[2 * k + 1];
            let of = across.iter().enumerate();
            sizes.extend(of.map(|(k, column)| {
                let k = if self.even { 0 } else { k };
                both(k) * height * (column.to - column.from)
            }));
        }
    }

    /// The same by exact solid angles.
    fn exactly(
        &self,
        face: usize,
        across: &[Piece],
        down: &[Piece],
        shares: &mut Vec<(usize, f64)>,
    ) {
        shares.clear();
        for row in down {
            for column in across {
                let size = self.from.raster.solid_angle(Rect {
                    u0: column.from,
                    u1: column.to,
                    v0: row.from,
                    v1: row.to,
                });
                if size > 0.0 {
                    shares.push((self.from.stored(face, [column.at, row.at]), size));
                }
            }
        }
    }
}
