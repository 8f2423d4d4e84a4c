//! The fast path: the cells of a block, from a lattice of points that they share.
//!
//! The corners of the target's cells and the middles of their sides are taken into the source by the vectorised
//! kernels. Five neighbouring points of a line tell an edge's cubic and how far it is from the truth; two cells share
//! the pieces of the edge between them. A cell whose edges are all smooth on one face is done with that. Others are
//! followed on their own (`seams`), and where that fails, or the sum of a cell's shares is not its solid angle,
//! the general path (`overlay`) has the word.

use super::arc::{Arc, Piece, Place, differences, minus};
use super::density::{Density, mean};
use super::lattice::Lattice;
use super::overlay::{BLIND, Overlay};
use super::seams::Border;
use super::shares::Shares;
use super::sphere::{dot, sub};
use crate::frame::Turn;
use crate::kernel::{self, Job};
use crate::projection::Outline;
use crate::tile::{TILE, Tile, Tuples};
use crate::verbs::{ContinuedCanonical, EncodeTile};
use std::sync::atomic::{AtomicUsize, Ordering};

/// What an edge may err by, in source cells or in target cells, whichever are smaller.
const FINE: f64 = 5e-8;

/// What the sum of a cell's shares may differ from its solid angle by.
const CLOSE: f64 = 2e-7;

/// Which way cells went.
#[derive(Debug, Default)]
pub(super) struct Tally {
    pub fast: AtomicUsize,
    pub followed: AtomicUsize,
    pub general: AtomicUsize,
}

/// An edge between two cells: its pieces, and the area by which it may be wrong; NaN where it is not smooth.
#[derive(Clone, Copy)]
struct Edge {
    start: usize,
    end: usize,
    wrong: f64,
}

#[derive(Default)]
struct Edges {
    pieces: Vec<Piece>,
    edges: Vec<Edge>,
}

impl Edges {
    fn clear(&mut self) {
        self.pieces.clear();
        self.edges.clear();
    }

    /// The edge between the second and the fourth of five points (x, y, face).
    #[inline(always)]
    fn push(&mut self, q: [[f64; 3]; 5], limits: [usize; 2]) {
        let start = self.pieces.len();
        let places = q.map(|[x, y, _]| [x, y]);
        // `differences` takes them around the middle one.
        let (third, fourth) = differences(places);
        let way = minus(places[3], places[1]);
        let length = (way[0] * way[0] + way[1] * way[1]).sqrt();
        let one_face = q.iter().all(|point| point[2] == q[2][2]);
        // 0.01: the largest distance of the cubic from the quartic.
        let smooth = one_face && 0.01 * fourth * length.min(1.0) <= FINE;
        if smooth {
            Arc::through([places[1], places[2], places[3]], third).pieces(limits, &mut self.pieces);
        }
        self.edges.push(Edge {
            start,
            end: self.pieces.len(),
            wrong: if smooth {
                0.006 * fourth * length
            } else {
                f64::NAN
            },
        });
    }

    fn pieces(&self, edge: &Edge) -> &[Piece] {
        &self.pieces[edge.start..edge.end]
    }
}

/// Cells of a target image one block after another.
pub(super) struct Sweep<'l, 'a> {
    from: &'l Lattice<'a>,
    into: &'l Lattice<'a>,
    overlay: Overlay<'l, 'a>,
    source: Density<'l, 'a>,
    target: Density<'l, 'a>,
    shares: Shares,
    border: Border,
    points: Vec<[f64; 3]>,
    directions: Vec<[f64; 3]>,
    turn: Turn,
    /// Where each cell of a row has its last weight.
    ends: Vec<usize>,
    /// Edges above a row of cells, below it, and between its cells.
    above: Edges,
    below: Edges,
    between: Edges,
    counts: [usize; 3],
    /// Whether cells may be anything but general.
    fast: bool,
}

/// Five points of a line from point `first` on.
#[inline(always)]
fn five(points: &[[f64; 3]], first: usize, step: usize) -> [[f64; 3]; 5] {
    [0, 1, 2, 3, 4].map(|n| points[first + n * step])
}

/// The edges above row `.1` of a block's cells; `.2` points in a row.
struct Below<'s, 'l, 'a>(&'s mut Sweep<'l, 'a>, usize, usize);

impl Job for Below<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn work(self) {
        let Below(sweep, row, width) = self;
        let limits = [sweep.from.columns, sweep.from.rows];
        let first = (2 * row + 1) * width;
        for i in 0..(width - 3) / 2 {
            sweep
                .below
                .push(five(&sweep.points, first + 2 * i, 1), limits);
        }
    }
}

/// The edges between the cells of row `.1`.
struct Between<'s, 'l, 'a>(&'s mut Sweep<'l, 'a>, usize, usize);

impl Job for Between<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn work(self) {
        let Between(sweep, row, width) = self;
        let limits = [sweep.from.columns, sweep.from.rows];
        let first = 2 * row * width + 1;
        for i in 0..=(width - 3) / 2 {
            sweep
                .between
                .push(five(&sweep.points, first + 2 * i, width), limits);
        }
    }
}

/// The weights of a row of cells.
struct Row<'s, 'l, 'a> {
    sweep: &'s mut Sweep<'l, 'a>,
    face: usize,
    first: [usize; 2],
    columns: usize,
    /// The middle of the first cell.
    middle: usize,
    width: usize,
}

impl Job for Row<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn work(self) {
        let Row {
            sweep, face, width, ..
        } = self;
        for i in 0..self.columns {
            let at = [self.first[0] + i, self.first[1]];
            let middle = self.middle + 2 * i;
            let start = sweep.shares.weights.len();
            if sweep.smooth(face, at, i, middle, width) {
                sweep.counts[0] += 1;
            } else {
                sweep.shares.weights.truncate(start);
                sweep.any(face, at, middle, width);
            }
            let end = sweep.shares.weights.len();
            sweep.ends.push(end);
        }
    }
}

/// Cells along a side of a block.
pub(super) const BLOCK: usize = 32;

impl<'l, 'a> Sweep<'l, 'a> {
    pub fn new(
        from: &'l Lattice<'a>,
        into: &'l Lattice<'a>,
        varies: [[bool; 2]; 2],
        fast: bool,
    ) -> Self {
        let turn = Turn::Matrix(into.turn().unwrap_or([
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
        ]));
        Sweep {
            from,
            into,
            overlay: Overlay::new(from, into),
            source: Density::new(from, varies[0]),
            target: Density::new(into, varies[1]),
            shares: Shares::default(),
            border: Border::default(),
            points: Vec::new(),
            directions: Vec::new(),
            turn,
            ends: Vec::new(),
            above: Edges::default(),
            below: Edges::default(),
            between: Edges::default(),
            counts: [0; 3],
            fast,
        }
    }

    pub fn count(&self, tally: &Tally) {
        for (count, sum) in self
            .counts
            .iter()
            .zip([&tally.fast, &tally.followed, &tally.general])
        {
            sum.fetch_add(*count, Ordering::Relaxed);
        }
    }

    /// Calls `add(cell, weights)` for each cell of a rectangle, row by row, with the stored source texels that it
    /// covers and how much of each; some may be there more than once.
    pub fn cells(
        &mut self,
        face: usize,
        low: [usize; 2],
        high: [usize; 2],
        mut add: impl FnMut([usize; 2], &[(usize, f64)]),
    ) {
        if !self.fast {
            for y in low[1]..high[1] {
                for x in low[0]..high[0] {
                    self.shares.weights.clear();
                    self.general(face, [x, y]);
                    add([x, y], &self.shares.weights);
                }
            }
            return;
        }
        let width = self.points_of(face, low, high);
        self.below.clear();
        kernel::vectorize(
            #[inline(always)]
            || Below(self, 0, width).work(),
        );
        for j in 0..high[1] - low[1] {
            std::mem::swap(&mut self.above, &mut self.below);
            self.below.clear();
            self.between.clear();
            self.ends.clear();
            self.shares.weights.clear();
            kernel::vectorize(
                #[inline(always)]
                || Below(self, j + 1, width).work(),
            );
            kernel::vectorize(
                #[inline(always)]
                || Between(self, j, width).work(),
            );
            kernel::vectorize(
                #[inline(always)]
                || {
                    Row {
                        sweep: self,
                        face,
                        first: [low[0], low[1] + j],
                        columns: high[0] - low[0],
                        middle: (2 * j + 2) * width + 2,
                        width,
                    }
                    .work()
                },
            );
            let mut start = 0;
            for (i, &end) in self.ends.iter().enumerate() {
                add([low[0] + i, low[1] + j], &self.shares.weights[start..end]);
                start = end;
            }
        }
    }

    /// The points of a rectangle's half-lines and of one more on each side; how many there are in a row.
    fn points_of(&mut self, face: usize, low: [usize; 2], high: [usize; 2]) -> usize {
        let lines = |axis: usize| -> Vec<f64> {
            (2 * low[axis] as isize - 1..=2 * high[axis] as isize + 1)
                .map(|k| self.into.line(axis, k))
                .collect()
        };
        let (us, vs) = (lines(0), lines(1));
        let face = face as f64;
        self.points.clear();
        self.points.extend(
            vs.iter()
                .flat_map(|&v| us.iter().map(move |&u| [u, v, face])),
        );
        self.directions.resize(self.points.len(), [0.0; 3]);
        self.into.map.visit_canonical(ContinuedCanonical {
            input: self.points.as_flattened(),
            output: self.directions.as_flattened_mut(),
        });
        let (along_u, along_v) = (self.from.scale(0), self.from.scale(1));
        let mut uv = Tile::new();
        for (directions, points) in self
            .directions
            .chunks(TILE)
            .zip(self.points.chunks_mut(TILE))
        {
            self.from.map.visit_canonical(EncodeTile {
                turn: self.turn,
                input: Tuples::Interleaved(directions),
                output: &mut uv,
            });
            for (k, point) in points.iter_mut().enumerate() {
                let [u, v, face] = uv.at(k);
                *point = [u * along_u.0 + along_u.1, v * along_v.0 + along_v.1, face];
            }
        }
        us.len()
    }

    /// The solid angle of a target cell.
    #[inline(always)]
    fn size(&mut self, face: usize, at: [usize; 2]) -> f64 {
        self.target.cells(face, at).first().map_or(f64::NAN, mean)
    }

    /// Whether the shares are those of a cell.
    #[inline(always)]
    fn fits(&self, size: f64) -> bool {
        (self.shares.total / size - 1.0).abs() <= CLOSE && self.shares.least >= -CLOSE * size
    }

    fn whole(&self, face: usize, at: [usize; 2]) -> bool {
        let into = self.into;
        into.map.info().outline == Outline::Square || {
            let [(u0, u1), (v0, v1)] = into.rectangle(at);
            [[u0, v0], [u1, v0], [u1, v1], [u0, v1]]
                .iter()
                .all(|uv| into.contains(face, *uv))
        }
    }

    /// A cell with smooth edges on one face; false if it has none.
    #[inline(always)]
    fn smooth(
        &mut self,
        face: usize,
        at: [usize; 2],
        i: usize,
        middle: usize,
        width: usize,
    ) -> bool {
        let edges = [
            &self.above.edges[i],
            &self.between.edges[i + 1],
            &self.below.edges[i],
            &self.between.edges[i],
        ];
        let corner = |k: usize| -> Place { [self.points[k][0], self.points[k][1]] };
        let (a, b) = (corner(middle - width - 1), corner(middle + width + 1));
        let (c, d) = (corner(middle - width + 1), corner(middle + width - 1));
        let (p, q) = (minus(b, a), minus(d, c));
        let area = 0.5 * (p[0] * q[1] - p[1] * q[0]);
        let wrong: f64 = edges.iter().map(|edge| edge.wrong).sum();
        // NaN where an edge is not smooth.
        let near = wrong <= FINE * area.abs();
        if !near || !self.whole(face, at) {
            return false;
        }
        let sense = area.signum();
        let on = self.points[middle][2] as usize;
        let size = self.size(face, at);
        let parts = [
            (self.above.pieces(&self.above.edges[i]), sense),
            (self.between.pieces(&self.between.edges[i + 1]), sense),
            (self.below.pieces(&self.below.edges[i]), -sense),
            (self.between.pieces(&self.between.edges[i]), -sense),
        ];
        self.shares.start();
        self.shares
            .add(self.from, &mut self.source, on, &parts, size)
            && self.fits(size)
    }

    /// A cell that is not smooth.
    #[inline(never)]
    fn any(&mut self, face: usize, at: [usize; 2], middle: usize, width: usize) {
        let start = self.shares.weights.len();
        if self.follow(face, at, middle) {
            self.counts[1] += 1;
            return;
        }
        self.shares.weights.truncate(start);
        if !self.misses(face, at, middle, width) {
            self.general(face, at);
        }
    }

    /// A cell whose border crosses seams, or is not smooth; false if that cannot be done.
    fn follow(&mut self, face: usize, at: [usize; 2], middle: usize) -> bool {
        let [x, y, on] = self.points[middle];
        if on.is_nan() || self.from.map.info().outline == Outline::Shape || !self.whole(face, at) {
            return false;
        }
        let size = self.size(face, at);
        let cell = [
            (x as usize).min(self.from.columns - 1),
            (y as usize).min(self.from.rows - 1),
        ];
        let own = self
            .source
            .cells(on as usize, cell)
            .first()
            .map_or(f64::NAN, mean);
        let fine = 0.5 * FINE * (size / own).min(1.0);
        if !self.border.trace(self.from, self.into, face, at, fine) {
            return false;
        }
        self.shares.start();
        let sense = self.into.sense(face);
        let (shares, from, source) = (&mut self.shares, self.from, &mut self.source);
        self.border.faces(from, |on, pieces| {
            shares.add(from, source, on, &[(pieces, sense * from.sense(on))], size)
        }) && self.fits(size)
    }

    /// Whether a cell lies where the source holds nothing, as far as the general path looks.
    fn misses(&self, face: usize, at: [usize; 2], middle: usize, width: usize) -> bool {
        let around = || {
            [middle - width, middle, middle + width]
                .into_iter()
                .flat_map(|k| [k - 1, k, k + 1])
        };
        if around().any(|k| !self.points[k][2].is_nan()) {
            return false;
        }
        let centre = self.directions[middle];
        let widest = around().fold(0.0_f64, |widest, k| {
            let way = sub(self.directions[k], centre);
            widest.max(dot(way, way))
        });
        let [(u0, u1), (v0, v1)] = self.into.rectangle(at);
        let middle = self.into.decode(face, [0.5 * (u0 + u1), 0.5 * (v0 + v1)]);
        // Twice: a side may bulge between its corners and its middle.
        widest <= BLIND * BLIND || self.from.is_far(middle, 2.0 * widest.sqrt())
    }

    /// Any cell. It counts where there is something to share: not outside a rim.
    fn general(&mut self, face: usize, at: [usize; 2]) {
        let (from, weights) = (self.from, &mut self.shares.weights);
        let before = weights.len();
        self.overlay.overlaps(face, at, |face, cell, area| {
            weights.push((from.stored(face, cell), area));
        });
        self.counts[2] += usize::from(weights.len() > before);
    }
}
