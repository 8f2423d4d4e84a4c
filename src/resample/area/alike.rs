//! Areas between images of one map that is not turned: a smaller or a larger copy.
//!
//! A texel of the target is a rectangle in the plane of one face of the source. It covers whole texels and, along its border, parts
//! of texels, all of them rectangles. Where the density is one of the polynomials of [`crate::image::pieces`], what each sees is its integral. Elsewhere it
//! is the density at two places each way (Gauss and Legendre), which is the solid angle but for
//! h⁴/4320 of the fourth derivative. As on the other paths, where these do not add up to the solid angle of the texel, as on
//! a crease of the density or across a rim, each is asked for exactly.
//!
//! What did not help: exact solid angles of all texels. For most maps they take longer than the path that knows nothing of all this.

use crate::geometry::solid_angle::Rect;
use crate::image::pieces::Pieces;
use crate::map::Map;
use crate::map::verbs::DensityCanonical;
use crate::resample::area::graticule::{edges, met};
use crate::resample::area::lattice::{Lattice, NOTHING};
use crate::resample::area::sweep::Add;
use crate::resample::request::Sight;
use glam::DMat3;
use std::ops::Range;

/// Where the density is asked for, from the middle of an interval, in halves of its length.
const NODE: f64 = 0.577_350_269_189_625_8;

/// How far a sum of sizes may be from a cell's solid angle, relative: those of texels are no farther off, but for what cancels.
const CLOSE: f64 = 1e-8;

/// Cells of the source along the side of a cell of the target, at most; and parts of two more where edges do not lie on each other.
pub(super) const MOST: f64 = 16.0;

/// Whether both images are of one map and none is turned, and solid angles are integrals of the density: in a lens of more than 180° a
/// texel beyond its own half sees something, and has none.
pub(super) fn serves(source: &Map, sight: Sight<'_>) -> bool {
    let unturned = sight.rotation.is_none_or(|r| r == DMat3::IDENTITY);
    unturned && source.same_formula(sight.map) && !sight.map.overlaps()
}

/// What a row or column of the source and one of the target have in common.
#[derive(Clone, Copy)]
struct Interval {
    /// The source's.
    at: usize,
    from: f64,
    to: f64,
}

/// Those of each row or column of a target.
struct Intervals {
    ends: Vec<usize>,
    all: Vec<Interval>,
    /// Where each begins and, last, where they end.
    edges: Vec<f64>,
}

impl Intervals {
    fn new(from: &Lattice<'_>, into: &Lattice<'_>, axis: usize) -> Intervals {
        let theirs: Vec<f64> = edges(from, axis).collect();
        let (mut ends, mut all) = (Vec::new(), Vec::new());
        for cell in 0..[into.columns, into.rows][axis] {
            let (a, b) = into.rectangle([cell; 2])[axis];
            for at in met(&theirs, [a, b]) {
                let (from, to) = (a.max(theirs[at]), b.min(theirs[at + 1]));
                if to - from > NOTHING * (b - a).min(theirs[at + 1] - theirs[at]) {
                    all.push(Interval { at, from, to });
                }
            }
            ends.push(all.len());
        }
        let begins = all.iter().map(|interval| interval.from);
        let edges = begins.chain(all.last().map(|last| last.to)).collect();
        Intervals { ends, all, edges }
    }

    /// Which are those of some of the target's.
    fn of(&self, cells: Range<usize>) -> Range<usize> {
        let start = |cell: usize| cell.checked_sub(1).map_or(0, |before| self.ends[before]);
        start(cells.start)..start(cells.end)
    }
}

/// What two images of a map have in common.
pub(super) struct Alike<'l, 'a> {
    from: &'l Lattice<'a>,
    into: &'l Lattice<'a>,
    columns: Intervals,
    rows: Intervals,
    /// Whether the density is the same all along a row.
    even: bool,
    pieces: Option<Pieces>,
}

impl<'l, 'a> Alike<'l, 'a> {
    pub fn new(from: &'l Lattice<'a>, into: &'l Lattice<'a>) -> Self {
        let [columns, rows] = [0, 1].map(|axis| Intervals::new(from, into, axis));
        Alike {
            from,
            into,
            columns,
            rows,
            even: from.map.has_even_rows(),
            pieces: Pieces::new(from.map, &from.raster),
        }
    }
}

/// Room for what is found of a row of cells.
#[derive(Default)]
pub(super) struct Room {
    places: Places,
    /// Of each row of intervals one after the other.
    sizes: Vec<f64>,
    /// Of which columns of intervals some are not integrals of a polynomial.
    rough: Vec<bool>,
    shares: Vec<(usize, f64)>,
}

/// Canonical (u, v, face) of places, and the densities there.
#[derive(Default)]
struct Places {
    uv: Vec<f64>,
    densities: Vec<f64>,
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
        let across = self.columns.of(low[0]..high[0]);
        for y in low[1]..high[1] {
            let down = &self.rows.all[self.rows.of(y..y + 1)];
            self.sizes(room, face, across.clone(), down);
            for x in low[0]..high[0] {
                let own = self.columns.of(x..x + 1);
                let here = own.start - across.start..own.end - across.start;
                let own = &self.columns.all[own];
                let sizes = || {
                    let rows = room.sizes.chunks_exact(across.len());
                    rows.map(|row| &row[here.clone()])
                };
                room.shares.clear();
                if room.rough[here.clone()].contains(&true) {
                    let [(u0, u1), (v0, v1)] = self.into.rectangle([x, y]);
                    let whole = self.into.raster.solid_angle(Rect { u0, u1, v0, v1 });
                    if whole <= 0.0 {
                        continue;
                    }
                    let total: f64 = sizes().flatten().sum();
                    let adds_up = (total / whole - 1.0).abs() <= CLOSE;
                    if !adds_up {
                        self.exactly(face, own, down, &mut room.shares);
                        add([x, y], &room.shares);
                        continue;
                    }
                }
                let stored = self.stored(face, [x, y]);
                for (row, sizes) in down.iter().zip(sizes()) {
                    let shares = own.iter().zip(sizes);
                    let shares = shares.map(|(column, size)| (stored([column.at, row.at]), *size));
                    room.shares.extend(shares);
                }
                add([x, y], &room.shares);
            }
        }
    }

    /// Where the source's texels that a cell of the target covers are stored, or those that have their values.
    fn stored(&self, face: usize, cell: [usize; 2]) -> impl Fn([usize; 2]) -> usize {
        let raster = &self.from.raster;
        let sides = self.into.rectangle(cell);
        let middle = sides.map(|(from, to)| 0.5 * (from + to));
        // Centers of those in part beyond it are a texel away at most.
        let texel = [raster.along_u, raster.along_v].map(|axis| 1.0 / axis.index().0);
        let reach = [0, 1].map(|axis| 0.5 * (sides[axis].1 - sides[axis].0) + texel[axis]);
        let simple = raster.holds_around(middle, reach);
        let view = raster.view(face);
        move |[i, j]| {
            if simple {
                view.index(i, j)
            } else {
                self.from.stored(face, [i, j])
            }
        }
    }

    /// Finds the sizes of rectangles, row by row.
    fn sizes(&self, room: &mut Room, face: usize, across: Range<usize>, down: &[Interval]) {
        let columns = &self.columns.all[across.clone()];
        let Room {
            places,
            sizes,
            rough,
            ..
        } = room;
        sizes.clear();
        sizes.resize(columns.len() * down.len(), 0.0);
        rough.clear();
        rough.resize(columns.len(), self.pieces.is_none());
        if columns.is_empty() {
            return;
        }
        let edges = &self.columns.edges[across.start..=across.end];
        for (row, out) in down.iter().zip(sizes.chunks_exact_mut(columns.len())) {
            let Some(pieces) = &self.pieces else {
                self.by_places(places, face, columns, row, out);
                continue;
            };
            pieces.parts(
                (self.from.map, &self.from.raster),
                (row.at, (row.from, row.to)),
                (|k| columns[k].at, edges),
                out,
                |parts, out| {
                    rough[parts.clone()].fill(true);
                    self.by_places(places, face, &columns[parts], row, out);
                },
            );
        }
    }

    /// The same of some rectangles of a row by the density at places in each.
    fn by_places(
        &self,
        places: &mut Places,
        face: usize,
        columns: &[Interval],
        row: &Interval,
        out: &mut [f64],
    ) {
        let nodes = |interval: &Interval| {
            let (from, to) = (interval.from, interval.to);
            let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
            [middle - NODE * half, middle + NODE * half]
        };
        let even = &[Interval {
            at: 0,
            from: 0.0,
            to: 1.0,
        }][..];
        let asked = if self.even { even } else { columns };
        let Places { uv, densities } = places;
        uv.clear();
        for v in nodes(row) {
            let us = asked.iter().flat_map(nodes);
            uv.extend(us.flat_map(|u| [u, v, face as f64]));
        }
        densities.resize(uv.len() / 3, 0.0);
        self.from.map.visit_canonical(DensityCanonical {
            input: uv,
            output: densities,
        });
        let (upper, lower) = densities.split_at(2 * asked.len());
        let height = 0.25 * (row.to - row.from);
        let both = |k: usize| upper[2 * k] + upper[2 * k + 1] + lower[2 * k] + lower[2 * k + 1];
        for (k, (column, out)) in columns.iter().zip(out).enumerate() {
            let k = if self.even { 0 } else { k };
            *out = both(k) * height * (column.to - column.from);
        }
    }

    /// The same by exact solid angles.
    fn exactly(
        &self,
        face: usize,
        across: &[Interval],
        down: &[Interval],
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
