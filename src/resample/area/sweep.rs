//! The fast path: the cells of a block, eight at a time.
//!
//! The corners of the target's cells are taken into the source by the vectorized kernels. Six neighboring ones of a
//! line tell an edge's cubic and how far it is from the truth (`edges`); cells whose edges are all smooth on one face of the source
//! are done with that, eight side by side (`eight`). Those near seams or poles, with corners too far apart, have borders of their
//! own in two to sixty-four parts, eight cells side by side as well. Those that cross a seam are followed one by one (`seams`), and
//! where that fails, or the sum of a cell's shares is not its solid angle, the general path (`overlay`) has the word.

use crate::geometry::solid_angle::Rect;
use crate::geometry::vector::{dot, sub};
use crate::projections::projection::Outline;
use crate::resample::area::fast::edges::{Edges, FINE, Found, Outlines, Places, on_its_own};
use crate::resample::area::fast::eight::{Cells, Eight, Passed};
use crate::resample::area::fast::lanes::{LANES, Lanes};
use crate::resample::area::fast::plane::Plane;
use crate::resample::area::general::overlay::{BLIND, Overlay};
use crate::resample::area::lattice::Lattice;
use crate::resample::area::traced::density::{Density, mean};
use crate::resample::area::traced::seams::Border;
use crate::resample::area::traced::shares::Shares;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What the sum of a cell's shares may differ from its solid angle by: half of what a sun may lose.
const CLOSE: f64 = 5e-7;

/// The same for cells smaller than those of the source, which see how its density bends: but what one of them lacks
/// its neighbors in the same source cell have.
const CLOSE_INSIDE: f64 = 2e-6;

/// Whether shares with this sum and this least one are those of a cell, `close` to its solid angle.
#[inline(always)]
fn adds_up(total: f64, least: f64, size: f64, close: f64) -> bool {
    (total / size - 1.0).abs() <= close && least >= -CLOSE * size
}

/// Which way cells went.
#[derive(Debug, Default)]
pub(super) struct Tally {
    pub fast: AtomicUsize,
    pub followed: AtomicUsize,
    pub general: AtomicUsize,
}

/// Parts of an edge that is on its own, at most.
const MOST_PARTS: usize = 64;

/// Cells along a side of a block.
pub(super) const BLOCK: usize = 32;

/// Corners beyond a block on each side.
const BEYOND: usize = 2;

/// Source cells beyond its corners that a block may touch, for edges that bulge, and some more in a large one.
const MARGIN: usize = 4;

/// Which list edges are in.
const ACROSS: usize = 0;
const DOWN: usize = 1;
const OWN: usize = 2;

/// A cell that goes on its own.
#[derive(Clone, Copy, Debug)]
struct Alone {
    at: [usize; 2],
    /// The face of the source that holds its corners.
    on: usize,
    /// Its solid angle.
    size: f64,
    /// What it covers in the source's plane.
    area: f64,
    /// Into how many parts each edge is cut.
    parts: usize,
    /// How many it seemed to take before.
    wanted: usize,
}

/// Up to eight cells side by side.
struct Batch {
    /// Which lanes have one: a bit each.
    used: u32,
    ats: [[usize; 2]; LANES],
    /// The face of the source that holds each.
    on: [usize; LANES],
    /// Its solid angle.
    sizes: Lanes,
}

impl Batch {
    fn new() -> Self {
        Batch {
            used: 0,
            ats: [[0; 2]; LANES],
            on: [0; LANES],
            sizes: Lanes([1.0; LANES]),
        }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, at: [usize; 2], on: usize, size: f64) {
        self.used |= 1 << lane;
        (self.ats[lane], self.on[lane], self.sizes.0[lane]) = (at, on, size);
    }
}

/// Told of each cell: which stored source texels it covers, and how much of them. Behind a pointer, for the ways to find that
/// are the same for texels of any type.
pub(super) type Add<'a> = &'a mut dyn FnMut([usize; 2], &[(usize, f64)]);

/// Cells of a target image one block after another.
pub(super) struct Sweep<'l, 'a> {
    from: &'l Lattice<'a>,
    into: &'l Lattice<'a>,
    varies: [[bool; 2]; 2],
    overlay: Overlay<'l, 'a>,
    coarse: &'l Lattice<'a>,
    followed: &'l Lattice<'a>,
    source: Density<'l, 'a>,
    target: Density<'l, 'a>,
    shares: Shares,
    border: Border,
    places: Places,
    across: Edges,
    down: Edges,
    outlines: Outlines,
    eight: Eight,
    /// Edges of cells on their own.
    own: Edges,
    edges: Vec<Passed>,
    source_planes: Vec<Plane>,
    target_plane: Plane,
    /// Cells of the source that a block covers of each face.
    reach: Vec<[[u32; 2]; 2]>,
    alone: Vec<Alone>,
    now: Vec<Alone>,
    shared: Vec<(usize, f64)>,
    counts: [usize; 3],
    /// Whether cells may be anything but general.
    fast: bool,
}

impl<'l, 'a> Sweep<'l, 'a> {
    /// The source comes thrice: in cells for the fast path, for those that are followed and for the general path.
    pub fn new(
        [from, followed, coarse]: [&'l Lattice<'a>; 3],
        into: &'l Lattice<'a>,
        varies: [[bool; 2]; 2],
        fast: bool,
    ) -> Self {
        let faces = from.map.info().faces;
        Sweep {
            from,
            into,
            varies,
            overlay: Overlay::new(coarse, into),
            coarse,
            followed,
            source: Density::new(followed, varies[0]),
            target: Density::new(into, varies[1]),
            shares: Shares::default(),
            border: Border::default(),
            places: Places::default(),
            across: Edges::default(),
            down: Edges::default(),
            outlines: Outlines::default(),
            eight: Eight::default(),
            own: Edges::default(),
            edges: Vec::new(),
            source_planes: (0..faces).map(|_| Plane::default()).collect(),
            target_plane: Plane::default(),
            reach: Vec::new(),
            alone: Vec::new(),
            now: Vec::new(),
            shared: Vec::new(),
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

    /// Calls `add(cell, weights)` for each cell of a rectangle with the stored source texels that it covers and how
    /// much of each; some may be there more than once. Before, `near(face, low, high)` may hear of boxes of source cells that hold
    /// most of them.
    pub fn cells(
        &mut self,
        face: usize,
        low: [usize; 2],
        high: [usize; 2],
        near: &dyn Fn(usize, [usize; 2], [usize; 2]),
        add: Add<'_>,
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
        let columns = high[0] - low[0];
        self.block(face, low, high);
        for (source, [low, high]) in self.reach.iter().enumerate() {
            if low[0] <= high[0] {
                let end = high.map(|k| k as usize + 1);
                near(source, low.map(|k| k as usize), end);
            }
        }
        self.alone.clear();
        for row in 0..high[1] - low[1] {
            for column in (0..columns).step_by(LANES) {
                let count = LANES.min(columns - column);
                self.together(face, low, [column, row], [columns, count], add);
            }
        }
        let mut parts = 1;
        while !self.alone.is_empty() {
            let mut now = std::mem::take(&mut self.now);
            now.clear();
            now.extend(self.alone.iter().filter(|cell| cell.parts <= parts));
            self.alone.retain(|cell| cell.parts > parts);
            for cells in now.chunks(LANES) {
                self.apart(face, cells, parts, add);
            }
            self.now = now;
            parts *= 2;
        }
    }

    /// The corners and edges of a block.
    fn block(&mut self, face: usize, low: [usize; 2], high: [usize; 2]) {
        let lines = |axis: usize| -> Vec<f64> {
            let (first, last) = (low[axis] as isize, high[axis] as isize);
            let beyond = BEYOND as isize;
            (first - beyond..=last + beyond)
                .map(|k| self.into.line(axis, 2 * k))
                .collect()
        };
        let (us, vs) = (lines(0), lines(1));
        self.places.clear();
        for &v in &vs {
            us.iter()
                .for_each(|&u| self.places.push([u, v, face as f64]));
        }
        self.places.take(self.from, self.into);
        let [columns, rows] = [0, 1].map(|k| high[k] - low[k]);
        let width = us.len();
        self.across.clear();
        self.down.clear();
        for row in 0..=rows {
            let first = (row + BEYOND) * width + BEYOND;
            self.across.push(&self.places, first, 1, columns);
            if row < rows {
                self.down.push(&self.places, first, width, columns + 1);
            }
        }
        self.across.pad();
        self.down.pad();
        self.outlines.compute(
            &self.places,
            [BEYOND * width + BEYOND, width],
            [&self.across, &self.down],
            [columns, rows],
        );
        self.reach.clear();
        self.reach
            .resize(self.source_planes.len(), [[u32::MAX; 2], [0; 2]]);
        for row in 0..=rows {
            let k = (row + BEYOND) * width + BEYOND;
            let [xs, ys, faces] = self.places.rows.each_ref().map(|row| &row[k..=k + columns]);
            for ((&x, &y), &face) in xs.iter().zip(ys).zip(faces) {
                let Some([low, high]) = self.reach.get_mut(face as usize) else {
                    continue;
                };
                if !x.is_nan() {
                    let [x, y] = [x, y].map(|place| place as u32);
                    *low = [low[0].min(x), low[1].min(y)];
                    *high = [high[0].max(x), high[1].max(y)];
                }
            }
        }
        self.target_plane
            .hold(self.into, self.varies[1], face, low, high);
    }

    /// Cells side by side in a row.
    #[inline(always)]
    fn together(
        &mut self,
        face: usize,
        low: [usize; 2],
        [column, row]: [usize; 2],
        [columns, count]: [usize; 2],
        add: Add<'_>,
    ) {
        let width = columns + 1 + 2 * BEYOND;
        let first = (row + BEYOND) * width + BEYOND + column;
        let [across, down] = [columns, columns + 1].map(Edges::stride);
        let (above, below) = (row * across + column, (row + 1) * across + column);
        let left = row * down + column;
        self.edges.clear();
        self.edges.extend(
            [
                (ACROSS, above, 1.0),
                (DOWN, left + 1, 1.0),
                (ACROSS, below, -1.0),
                (DOWN, left, -1.0),
            ]
            .map(|(list, first, sense)| Passed { list, first, sense }),
        );
        let mut batch = Batch::new();
        let square = self.into.map.outline() == Outline::Square;
        for lane in 0..count {
            let at = [low[0] + column + lane, low[1] + row];
            let (area, wrong) = (
                self.outlines.areas[above + lane],
                self.outlines.wrong[above + lane],
            );
            if area.is_nan() || !(square || self.into.is_whole(face, at)) {
                self.any(face, at, add);
                continue;
            }
            let on = self.places.face(first + lane) as usize;
            let size = self.size(face, at);
            let fine = FINE * area.abs().min(1.0);
            if wrong <= fine {
                batch.set(lane, at, on, size);
            } else {
                // What could not be told from the corners, or crosses a seam or a crease, may well be smooth.
                let parts = (wrong / fine).sqrt().sqrt();
                self.alone.push(Alone {
                    at,
                    on,
                    size,
                    area: area.abs(),
                    parts: if parts <= 2.0 { 2 } else { 1 },
                    wanted: usize::MAX,
                });
            }
        }
        self.finish(face, batch, add);
    }

    /// Cells whose edges come in so many parts each.
    fn apart(&mut self, face: usize, cells: &[Alone], parts: usize, add: Add<'_>) {
        let around = 16 * parts;
        let limits = [self.from.columns, self.from.rows];
        self.places.clear();
        for cell in cells {
            let [(u0, u1), (v0, v1)] = self.into.rectangle(cell.at);
            let corners = [[u0, v0], [u1, v0], [u1, v1], [u0, v1], [u0, v0]];
            for side in 0..4 {
                let (a, b) = (corners[side], corners[side + 1]);
                for k in 0..4 * parts {
                    let t = k as f64 / (4 * parts) as f64;
                    let [u, v] = [0, 1].map(|axis| a[axis] + t * (b[axis] - a[axis]));
                    self.places.push([u, v, face as f64]);
                }
            }
            // The loop closes.
            self.places.push([u0, v0, face as f64]);
        }
        self.places.take(self.from, self.into);
        self.own.resize(4 * parts * LANES);
        self.edges.clear();
        self.edges.extend((0..4 * parts).map(|k| Passed {
            list: OWN,
            first: k * LANES,
            sense: 1.0,
        }));
        let mut batch = Batch::new();
        for (lane, cell) in cells.iter().enumerate() {
            let mut found = Found::Smooth;
            let fine = FINE * cell.area.min(1.0) / (4 * parts) as f64;
            for k in 0..4 * parts {
                let first = lane * (around + 1) + 4 * k;
                found = on_its_own(
                    &self.places,
                    first,
                    fine,
                    limits,
                    &mut self.own,
                    k * LANES + lane,
                );
                if found != Found::Smooth {
                    break;
                }
            }
            match found {
                Found::Smooth => batch.set(lane, cell.at, cell.on, cell.size),
                // A crease is as rough in parts as it was.
                Found::Rough(more)
                    if parts < MOST_PARTS && (more <= 2 || more <= cell.wanted / 2) =>
                {
                    self.alone.push(Alone {
                        parts: (parts * more.min(4)).next_power_of_two(),
                        wanted: more,
                        ..*cell
                    });
                }
                _ => self.any(face, cell.at, add),
            }
        }
        self.finish(face, batch, add);
    }

    /// Finds the shares of cells side by side; where something is wrong with them a cell goes another way.
    #[inline(always)]
    fn finish(&mut self, face: usize, batch: Batch, add: Add<'_>) {
        let limits = [self.from.columns, self.from.rows];
        let mut rest = batch.used;
        while rest != 0 {
            // Those on another face of the source come next.
            let source = batch.on[rest.trailing_zeros() as usize];
            let here = (0..LANES)
                .filter(|lane| rest >> lane & 1 == 1 && batch.on[*lane] == source)
                .fold(0, |bits, lane| bits | 1 << lane);
            rest &= !here;
            let [low, high] = self.reach[source];
            let margin = [0, 1].map(|k| MARGIN + (high[k] - low[k]) as usize / 16);
            let low = [0, 1].map(|k| (low[k] as usize).saturating_sub(margin[k]));
            let high = [0, 1].map(|k| (high[k] as usize + 1 + margin[k]).min(limits[k]));
            let plane = &mut self.source_planes[source];
            let held = plane.hold(self.from, self.varies[0], source, low, high);
            let cells = Cells {
                edges: &self.edges,
                lists: [&self.across, &self.down, &self.own],
                used: here,
                sense: self.into.sense(face) * self.from.sense(source),
                sizes: &batch.sizes,
                limits,
                plane,
            };
            let done = held && self.eight.run(&cells);
            let mut fit = 0;
            for lane in (0..LANES).filter(|lane| here >> lane & 1 == 1) {
                if done && self.fits(source, lane, batch.sizes.0[lane]) {
                    fit |= 1 << lane;
                } else {
                    self.any(face, batch.ats[lane], add);
                }
            }
            self.share(source, fit, &batch.ats, add);
        }
    }

    /// Whether the shares of a lane are those of a cell.
    #[inline(always)]
    fn fits(&self, source: usize, lane: usize, size: f64) -> bool {
        let eight = &self.eight;
        let close = match self.source_planes[source].get(eight.first(lane)) {
            Some(own) if own > size => CLOSE_INSIDE,
            _ => CLOSE,
        };
        adds_up(eight.total.0[lane], eight.least.0[lane], size, close)
    }

    /// Hands out the shares of the lanes whose bits are set.
    #[inline(always)]
    fn share(&mut self, source: usize, lanes: u32, ats: &[[usize; 2]; LANES], add: Add<'_>) {
        let (eight, from) = (&self.eight, self.from);
        let most = eight.enough.len();
        self.shared
            .resize((LANES * most).max(self.shared.len()), (0, 0.0));
        let view = from.raster.view(source);
        let [along, down] = view.steps();
        let firsts: [[usize; 2]; LANES] = std::array::from_fn(|lane| eight.first(lane));
        // A window is as large as the largest of eight, and a cell may bulge over an edge of the image.
        let ends = [from.columns, from.rows];
        let over = |first: [usize; 2]| (0..2).any(|k| first[k] + eight.window[k] > ends[k]);
        let simple =
            from.refined == 1 && !from.raster.has_rim() && !firsts.iter().any(|first| over(*first));
        let starts = firsts.map(|[x, y]| view.index(x, y) as isize);
        let mut counts = [0; LANES];
        let columns = eight.window[0].max(1);
        for (k, (&enough, weights)) in eight.enough.iter().zip(&eight.weights).enumerate() {
            let here = u32::from(enough) & lanes;
            if here == 0 {
                continue;
            }
            let [column, row] = [k % columns, k / columns];
            let step = column as isize * along + row as isize * down;
            for lane in 0..LANES {
                // Whatever is not meant is written over by the next.
                let index = if simple {
                    (starts[lane] + step) as usize
                } else if here >> lane & 1 == 1 {
                    let [x, y] = firsts[lane];
                    let (x, y) = ((x + column).min(ends[0] - 1), (y + row).min(ends[1] - 1));
                    from.stored(source, [x, y])
                } else {
                    0
                };
                self.shared[lane * most + counts[lane]] = (index, weights.0[lane]);
                counts[lane] += (here >> lane & 1) as usize;
            }
        }
        for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
            self.counts[0] += 1;
            add(ats[lane], &self.shared[lane * most..][..counts[lane]]);
        }
    }

    /// The solid angle of a target cell of the block.
    #[inline(always)]
    fn size(&mut self, face: usize, at: [usize; 2]) -> f64 {
        if self.into.uniform(0) && self.into.uniform(1) {
            self.target_plane.get(at).unwrap_or(f64::NAN)
        } else {
            self.target.cells(face, at).first().map_or(f64::NAN, mean)
        }
    }

    /// A cell that is not smooth.
    #[inline(never)]
    fn any(&mut self, face: usize, at: [usize; 2], add: Add<'_>) {
        self.shares.weights.clear();
        if self.follow(face, at) {
            self.counts[1] += 1;
        } else {
            self.shares.weights.clear();
            self.general(face, at);
        }
        add(at, &self.shares.weights);
    }

    /// A cell whose border crosses seams, or is not smooth; false if that cannot be done.
    fn follow(&mut self, face: usize, at: [usize; 2]) -> bool {
        let from = self.followed;
        if from.map.outline() == Outline::Shape || !self.into.is_whole(face, at) {
            return false;
        }
        let [(u0, u1), (v0, v1)] = self.into.rectangle(at);
        let middle = self.into.decode(face, [0.5 * (u0 + u1), 0.5 * (v0 + v1)]);
        let Some(spot) = from.locate(middle) else {
            return false;
        };
        let mut size = self.target.cells(face, at).first().map_or(f64::NAN, mean);
        if size.is_nan() {
            // A crease runs through it; its border bends there, and is as well followed as any other.
            size = self.into.raster.solid_angle(Rect { u0, u1, v0, v1 });
        }
        let own = self
            .source
            .cells(spot.face, spot.at)
            .first()
            .map_or(f64::NAN, mean);
        let fine = 0.5 * FINE * (size / own).min(1.0);
        if !self.border.trace(from, self.into, face, at, fine) {
            return false;
        }
        self.shares.start();
        let sense = self.into.sense(face);
        let (shares, source) = (&mut self.shares, &mut self.source);
        self.border.faces(from, |on, pieces| {
            shares.add(from, source, on, pieces, sense * from.sense(on), size)
        }) && adds_up(self.shares.total, self.shares.least, size, CLOSE)
    }

    /// Whether a cell lies where the source holds nothing, as far as the general path looks.
    fn misses(&self, face: usize, at: [usize; 2]) -> bool {
        let [(u0, u1), (v0, v1)] = self.into.rectangle(at);
        let (us, vs) = ([u0, 0.5 * (u0 + u1), u1], [v0, 0.5 * (v0 + v1), v1]);
        let center = self.into.decode(face, [us[1], vs[1]]);
        if self.from.locate(center).is_some() {
            return false;
        }
        let around =
            [0, 1, 2, 3, 5, 6, 7, 8].map(|k| self.into.decode(face, [us[k % 3], vs[k / 3]]));
        if around.iter().any(|d| self.from.locate(*d).is_some()) {
            return false;
        }
        let widest = around.iter().fold(0.0_f64, |widest, d| {
            let way = sub(*d, center);
            widest.max(dot(way, way))
        });
        // Twice: a side may bulge between its corners and its middle.
        widest <= BLIND * BLIND || self.from.is_far(center, 2.0 * widest.sqrt())
    }

    /// Any cell. It counts where there is something to share: not outside a rim.
    fn general(&mut self, face: usize, at: [usize; 2]) {
        if self.into.cell(face, at).is_none() || self.misses(face, at) {
            return;
        }
        let (from, weights) = (self.coarse, &mut self.shares.weights);
        let before = weights.len();
        self.overlay.overlaps(face, at, |face, cell, area| {
            weights.push((from.stored(face, cell), area));
        });
        self.counts[2] += usize::from(weights.len() > before);
    }
}
