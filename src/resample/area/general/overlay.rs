//! Which source cells a target cell covers, and how much of each.
//!
//! The target cell's border is traced through the source image and cut into pieces, each inside one
//! source cell. With the parts of that cell's own border that lie in the target cell, the pieces bound the
//! overlap, and the area is what the loop sweeps about a place inside the source cell. Which parts of the
//! source cell's border lie in the target cell follows from where pieces leave the cell and enter it, and from
//! nothing else: overlaps are closed loops whatever rounding does, and two target cells that share an edge
//! share its pieces, so that what one loses the other gains.
//!
//! Nothing is asked about seams, poles or the order of faces. Where two neighboring places of the traced
//! border lie in different cells, the border is bisected until they are as near as numbers can be; then
//! the piece ends on the border of the one cell and the next begins on the border of the other.

use crate::geometry::vector::{dot, sub};
use crate::resample::area::lattice::{Along, Lattice, LatticeCell, NOTHING, Part, RIM, Spot};
use crate::resample::area::sphere::{Curve, Direction, swept, triangle};
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// Error of an area, relative to the smaller of the two cells.
const TOLERANCE: f64 = 1e-9;

/// Cells between two such places, at most: where more are passed, as beside a pole, they are skipped.
const MOST_STEPS: usize = 64;

/// The longest way, in radians, along which an image that holds neither end is not looked for.
pub(in crate::resample::area) const BLIND: f64 = 1e-3;

/// Of two places nearer than this, relative to the smaller cell's side, it is known that the border
/// goes straight from the one's cell to the other's.
const NEAR: f64 = 1e-4;

/// Up to this part of a cell's border a target cell may touch its corner alone, or all of it but a corner.
const CORNER: f64 = 1e-4;

/// A place of the traced border.
#[derive(Clone, Copy)]
struct Sample {
    t: f64,
    d: Direction,
    spot: Option<Spot>,
}

impl Sample {
    fn same_cell(&self, other: &Sample) -> bool {
        match (&self.spot, &other.spot) {
            (Some(p), Some(q)) => p.same_cell(q),
            (p, q) => p.is_none() && q.is_none(),
        }
    }
}

/// A change of the border's state: whether the source cell's border lies in the target cell from
/// here on (+1) or up to here (-1).
type Step = (f64, f64);

struct Touched {
    cell: LatticeCell,
    anchor: Direction,
    tolerance: f64,
    swept: f64,
    steps: Vec<Step>,
    /// Reached from a neighbor: no piece of the border lies in it.
    whole: bool,
}

#[derive(Default)]
struct Mix(u64);

impl Hasher for Mix {
    fn finish(&self) -> u64 {
        self.0
    }
    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u64(u64::from(byte));
        }
    }
    fn write_u64(&mut self, x: u64) {
        self.0 = (self.0 ^ x)
            .wrapping_mul(0x9e37_79b9_7f4a_7c15)
            .rotate_left(29);
    }
}

/// The overlaps of one target cell after another with the cells of a source image.
pub(in crate::resample::area) struct Overlay<'l, 'a> {
    source: &'l Lattice<'a>,
    target: &'l Lattice<'a>,
    touched: Vec<Touched>,
    numbers: HashMap<u64, u32, BuildHasherDefault<Mix>>,
    /// The source cell in which the trace is, and where it entered.
    open: Option<usize>,
    /// Cells of which `touched` keeps the memory.
    used: usize,
}

/// What is traced: a part of a target cell's border, in the direction that its neighbor shares.
struct Edge<'l, 'a> {
    along: Along<'l, 'a>,
    /// +1 where the trace runs as the border does, else -1.
    sense: f64,
}

impl Edge<'_, '_> {
    fn sample(&self, source: &Lattice<'_>, t: f64) -> Sample {
        let d = self.along.at(t);
        Sample {
            t,
            d,
            spot: source.locate(d),
        }
    }
}

impl<'l, 'a> Overlay<'l, 'a> {
    pub fn new(source: &'l Lattice<'a>, target: &'l Lattice<'a>) -> Self {
        Overlay {
            source,
            target,
            touched: Vec::new(),
            numbers: HashMap::default(),
            open: None,
            used: 0,
        }
    }

    /// Calls `add(face, cell, area)` for each source cell that a target cell overlaps.
    pub fn overlaps(
        &mut self,
        face: usize,
        at: [usize; 2],
        mut add: impl FnMut(usize, [usize; 2], f64),
    ) {
        let (source, target) = (self.source, self.target);
        let Some(cell) = target.cell(face, at) else {
            return;
        };
        self.touched.clear();
        self.numbers.clear();
        let size = extent(target, &cell);
        for part in cell.parts() {
            // Right and down, which is what the neighbor across it does; a rim has none.
            let reversed = part.side == 2 || part.side == 3;
            let (part, sense) = if reversed {
                let (from, to) = (part.to, part.from);
                (Part { from, to, ..*part }, -1.0)
            } else {
                (*part, 1.0)
            };
            let edge = Edge {
                along: Along {
                    lattice: target,
                    cell: &cell,
                    part,
                },
                sense: sense * target.sense(face),
            };
            self.trace(&edge, size);
        }
        self.used = 0;
        while self.used < self.touched.len() {
            let k = self.used;
            self.used += 1;
            let area = if self.touched[k].tolerance.is_nan() {
                0.0
            } else if self.touched[k].whole {
                self.spread(k, &cell, |_, _| true);
                let t = &self.touched[k];
                whole(source, &t.cell, t.anchor, t.tolerance)
            } else {
                self.bounded(k, &cell)
            };
            let touched = &self.touched[k];
            if area > NOTHING / TOLERANCE * touched.tolerance {
                let cell = &self.touched[k].cell;
                add(cell.face, cell.at, area);
            }
        }
    }

    fn number(&mut self, spot: &Spot, size: f64) -> Option<usize> {
        self.cell_number(spot.face, spot.at, size, false)
    }

    fn cell_number(
        &mut self,
        face: usize,
        at: [usize; 2],
        size: f64,
        whole: bool,
    ) -> Option<usize> {
        let source = self.source;
        let key = ((face * source.rows + at[1]) * source.columns + at[0]) as u64;
        if let Some(&number) = self.numbers.get(&key) {
            return Some(number as usize);
        }
        let cell = source.cell(face, at)?;
        let own = extent(source, &cell);
        self.numbers.insert(key, self.touched.len() as u32);
        self.touched.push(Touched {
            cell,
            anchor: source.decode(face, cell.inside),
            tolerance: TOLERANCE * own.min(size),
            swept: 0.0,
            steps: Vec::new(),
            whole,
        });
        Some(self.touched.len() - 1)
    }

    fn trace(&mut self, edge: &Edge<'_, '_>, size: f64) {
        let (first, last) = (edge.sample(self.source, 0.0), edge.sample(self.source, 1.0));
        self.open = first.spot.and_then(|spot| self.number(&spot, size));
        let way = sub(last.d, first.d);
        if dot(way, way) > 1e-4 * size {
            return self.walk(edge, &first, &last, size);
        }
        // An edge on a pole, or one that folds back on itself.
        let mut from = first;
        for t in [0.25, 0.5, 0.75] {
            let to = edge.sample(self.source, t);
            self.walk(edge, &from, &to, size);
            from = to;
        }
        self.walk(edge, &from, &last, size);
    }

    /// Follows the border from `a` to `b`.
    fn walk(&mut self, edge: &Edge<'_, '_>, a: &Sample, b: &Sample, size: f64) {
        let way = sub(b.d, a.d);
        let length = dot(way, way);
        let near = match self.open {
            Some(open) => {
                self.touched[open].tolerance.min(size * TOLERANCE) * (NEAR * NEAR / TOLERANCE)
            }
            None => size * NEAR * NEAR,
        };
        if let (Some(p), Some(q)) = (a.spot, b.spot)
            && p.same_cell(&q)
        {
            return self.within(edge, a, b, size, length <= near);
        }
        if a.spot.is_none() && b.spot.is_none() {
            if length <= BLIND * BLIND {
                return;
            }
        } else if length <= near {
            return self.step_by_step(edge, a, b, size);
        } else if let (Some(p), Some(q)) = (a.spot, b.spot)
            && let Some((axis, at)) = single_crossing(&p, &q)
            && let Some([before, after]) = self.solve(edge, a, b, axis, at)
        {
            self.walk(edge, a, &before, size);
            self.cross(edge, &before, &after, size);
            return self.walk(edge, &after, b, size);
        }
        let t = 0.5 * (a.t + b.t);
        if t <= a.t || t >= b.t {
            return self.cross(edge, a, b, size);
        }
        let middle = edge.sample(self.source, t);
        self.walk(edge, a, &middle, size);
        self.walk(edge, &middle, b, size);
    }

    /// Goes from cell to cell between two near places, to the last digit.
    fn step_by_step(&mut self, edge: &Edge<'_, '_>, a: &Sample, b: &Sample, size: f64) {
        let mut from = *a;
        for step in 0..=MOST_STEPS {
            if from.same_cell(b) {
                return self.sweep(edge, &from, b);
            }
            let (before, mut after) = self.part(edge, &from, b, |middle| middle.same_cell(&from));
            if step == MOST_STEPS {
                after = self.part(edge, &from, b, |middle| !middle.same_cell(b)).1;
            }
            self.sweep(edge, &from, &before);
            self.cross(edge, &before, &after, size);
            from = after;
        }
        self.sweep(edge, &from, b);
    }

    /// The last place of the near part of the border, and the first of the far one.
    fn part(
        &self,
        edge: &Edge<'_, '_>,
        a: &Sample,
        b: &Sample,
        is_near: impl Fn(&Sample) -> bool,
    ) -> (Sample, Sample) {
        let (mut before, mut after) = (*a, *b);
        loop {
            let t = 0.5 * (before.t + after.t);
            if t <= before.t || t >= after.t {
                return (before, after);
            }
            let middle = edge.sample(self.source, t);
            if is_near(&middle) {
                before = middle;
            } else {
                after = middle;
            }
        }
    }

    /// Follows the border between two places of one cell.
    fn within(&mut self, edge: &Edge<'_, '_>, a: &Sample, b: &Sample, size: f64, near: bool) {
        let t = 0.5 * (a.t + b.t);
        if t <= a.t || t >= b.t || near {
            return self.sweep(edge, a, b);
        }
        let middle = edge.sample(self.source, t);
        let mut split = Some(middle);
        if let (Some(p), Some(m), Some(q)) = (a.spot, middle.spot, b.spot)
            && p.same_cell(&m)
        {
            split = match excursion(&p, &m, &q) {
                Bend::Inside => None,
                Bend::Unclear => Some(middle),
                Bend::Outside(s) => {
                    let there = edge.sample(self.source, a.t + s * (b.t - a.t));
                    there
                        .spot
                        .is_none_or(|spot| !spot.same_cell(&p))
                        .then_some(there)
                }
            };
        }
        match split {
            Some(there) => {
                self.walk(edge, a, &there, size);
                self.walk(edge, &there, b, size);
            }
            None => self.sweep(edge, a, b),
        }
    }

    /// Adds what the border sweeps on its way through the open cell.
    fn sweep(&mut self, edge: &Edge<'_, '_>, a: &Sample, b: &Sample) {
        if let Some(open) = self.open
            && a.t < b.t
        {
            let t = 0.5 * (a.t + b.t);
            let touched = &mut self.touched[open];
            let places = [(a.t, a.d), (t, edge.along.at(t)), (b.t, b.d)];
            touched.swept +=
                edge.sense * swept(&edge.along, touched.anchor, places, touched.tolerance);
        }
    }

    /// Where a coordinate meets the line between two cells, as the last place of one and the first of
    /// the other; none if the border is not smooth on the way.
    fn solve(
        &self,
        edge: &Edge<'_, '_>,
        a: &Sample,
        b: &Sample,
        axis: usize,
        line: f64,
    ) -> Option<[Sample; 2]> {
        let (p, q) = (a.spot?, b.spot?);
        let (mut low, mut high) = ((a.t, p.xy[axis] - line), (b.t, q.xy[axis] - line));
        let tolerance = 1e-11 + 8.0 * f64::EPSILON * line;
        let (mut found, mut moved) = (None, None);
        // Regula falsi; a side that stays twice is halved (the Illinois method).
        for _ in 0..24 {
            let t = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
            let t = t.clamp(a.t, b.t);
            let sample = edge.sample(self.source, t);
            let spot = sample.spot?;
            if spot.face != p.face {
                return None;
            }
            let x = spot.xy[axis] - line;
            if x.abs() <= tolerance {
                found = Some((sample, spot));
                break;
            }
            if high.0 - low.0 <= 4.0 * f64::EPSILON {
                // Across a seam two neighboring cells may be far apart: the coordinate leaps.
                return None;
            }
            let is_high = (x < 0.0) == (high.1 < 0.0);
            let (near, far) = if is_high {
                (&mut high, &mut low)
            } else {
                (&mut low, &mut high)
            };
            *near = (t, x);
            if moved.replace(is_high) == Some(is_high) {
                far.1 *= 0.5;
            }
        }
        let (sample, spot) = found?;
        // It must not have moved along the line in one step: there it leaps.
        let other = 1 - axis;
        if (spot.xy[other] - line_between(&p, &q, other)).abs() > 1.0 {
            return None;
        }
        let side = |of: &Spot| {
            let mut spot = spot;
            spot.at = of.at;
            Sample {
                spot: Some(spot),
                ..sample
            }
        };
        (spot.at[other] == p.at[other] && spot.at[other] == q.at[other])
            .then(|| [side(&p), side(&q)])
    }

    /// Leaves the cell of `a` and enters that of `b`.
    fn cross(&mut self, edge: &Edge<'_, '_>, a: &Sample, b: &Sample, size: f64) {
        if let (Some(open), Some(spot)) = (self.open, a.spot) {
            self.step(edge, open, spot.uv, 1.0);
        }
        self.open = None;
        if let Some(spot) = b.spot
            && let Some(number) = self.number(&spot, size)
        {
            self.step(edge, number, spot.uv, -1.0);
            self.open = Some(number);
        }
    }

    fn step(&mut self, edge: &Edge<'_, '_>, number: usize, uv: [f64; 2], leaving: f64) {
        let source = self.source;
        let touched = &mut self.touched[number];
        let place = source.along(&touched.cell, uv);
        // The loop goes on from where a piece leaves, in its own sense.
        let sense = edge.sense * source.sense(touched.cell.face);
        touched.steps.push((place, leaving * sense));
    }

    /// The area of the overlap with a cell that the border touches.
    fn bounded(&mut self, k: usize, target: &LatticeCell) -> f64 {
        let source = self.source;
        let mut steps = std::mem::take(&mut self.touched[k].steps);
        steps.sort_by(|a, b| a.0.total_cmp(&b.0));
        let end = self.touched[k].cell.parts().len() as f64;
        let (start, share) = self.start(&steps, end, k, target);
        let touched = &self.touched[k];
        // A border that winds about a corner, as about a pole, and then runs through the cell bounds a part of it.
        let beside = touched.swept.abs() <= 4.0 * CORNER * touched.tolerance / TOLERANCE;
        if beside && share.min(1.0 - share) < CORNER && self.holds(target, k) != (share > 0.5) {
            // At a corner, as where many meridians meet, rounding may exchange the places where the target's border enters
            // and leaves: then what seems in is out.
            if share > 0.5 {
                return 0.0;
            }
            self.spread(k, target, |_, _| true);
            let t = &self.touched[k];
            return whole(source, &t.cell, t.anchor, t.tolerance);
        }
        let held = |from: f64, to: f64, inside: f64, this: &mut Self| {
            if inside < 0.5 || to <= from {
                return 0.0;
            }
            let touched = &this.touched[k];
            let area = stretch(
                source,
                &touched.cell,
                touched.anchor,
                touched.tolerance,
                from,
                to,
            );
            this.spread(k, target, |part, t| {
                let place = part as f64 + t;
                place > from && place < to
            });
            area
        };
        let (mut area, mut from, mut inside) = (self.touched[k].swept, 0.0, start);
        for &(place, change) in &steps {
            area += held(from, place, inside, self);
            from = place;
            inside += change;
        }
        area += held(from, end, inside, self);
        self.touched[k].steps = steps;
        area
    }

    /// Whether the border's first place lies in the target cell (1) or not (0), and how much of the border does; NaN
    /// where nothing but a place on it tells.
    fn start(&self, steps: &[Step], end: f64, k: usize, target: &LatticeCell) -> (f64, f64) {
        // Where a place is along the border, by length: a side on a pole has none.
        let cell = &self.touched[k].cell;
        let ends = |part: &Part| {
            let ends = [part.from, part.to].map(|uv| self.source.decode(cell.face, uv));
            let way = sub(ends[1], ends[0]);
            dot(way, way).sqrt()
        };
        let mut lengths = [0.0; 9];
        for (k, part) in cell.parts().iter().enumerate() {
            lengths[k + 1] = lengths[k] + ends(part);
        }
        let perimeter = lengths[cell.parts().len()];
        let length = |place: f64| {
            let k = (place as usize).min(cell.parts().len() - 1);
            lengths[k] + (place - k as f64) * (lengths[k + 1] - lengths[k])
        };
        // How much of the border would be neither in nor out, and how much in.
        let parts_of = |start: f64| {
            let (mut wrong, mut held, mut from, mut inside) = (0.0, 0.0, 0.0, start);
            for &(place, change) in steps.iter().chain(&[(end, 0.0)]) {
                if !(-0.5..=1.5).contains(&inside) {
                    wrong += length(place) - length(from);
                } else if inside > 0.5 {
                    held += length(place) - length(from);
                }
                from = place;
                inside += change;
            }
            (wrong, held)
        };
        if steps.is_empty() {
            // The target cell lies inside this one.
            return (0.0, f64::NAN);
        }
        let (out, inside) = (parts_of(0.0), parts_of(1.0));
        if (out.0 - inside.0).abs() > 1e-2 * perimeter {
            let (start, (_, held)) = if inside.0 < out.0 {
                (1.0, inside)
            } else {
                (0.0, out)
            };
            return (start, held / perimeter);
        }
        // The border's steps undo each other within rounding: the middle of the rest of it tells.
        let mut longest = (-1.0, 0.0);
        let mut from = 0.0;
        for place in steps.iter().map(|step| step.0).chain([end]) {
            let gap = length(place) - length(from);
            if gap > longest.0 {
                longest = (gap, 0.5 * (length(from) + length(place)));
            }
            from = place;
        }
        let parts = cell.parts();
        let k = (0..parts.len())
            .find(|k| lengths[k + 1] >= longest.1)
            .unwrap_or(parts.len() - 1);
        let t = (longest.1 - lengths[k]) / (lengths[k + 1] - lengths[k]);
        let uv = self.source.place(cell, &parts[k], t);
        let holds = self.target.holds(target, self.source.decode(cell.face, uv));
        (f64::from(u8::from(holds)), f64::NAN)
    }

    /// Takes in a cell that the border does not touch.
    fn take_in(&mut self, face: usize, at: [usize; 2], target: &LatticeCell) {
        let before = self.touched.len();
        if let Some(number) = self.cell_number(face, at, f64::INFINITY, true)
            && number == before
            && !self.holds(target, number)
        {
            // Reached through a gap that rounding made: the cell stays, known and empty.
            self.touched[number].tolerance = f64::NAN;
        }
    }

    fn holds(&self, target: &LatticeCell, number: usize) -> bool {
        self.target.holds(target, self.touched[number].anchor)
    }

    /// Takes in the neighbors across those places of a cell's border that lie in the target cell.
    fn spread(&mut self, k: usize, target: &LatticeCell, lies_in: impl Fn(usize, f64) -> bool) {
        let source = self.source;
        let cell = self.touched[k].cell;
        for (number, part) in cell.parts().iter().enumerate() {
            for t in [0.5, 0.02, 0.27, 0.73, 0.98] {
                if !lies_in(number, t) {
                    continue;
                }
                if let Some(at) = beside(source, cell.at, part) {
                    self.take_in(cell.face, at, target);
                    break;
                }
                if let Some(spot) = source.across(&cell, part, t) {
                    self.take_in(spot.face, spot.at, target);
                }
            }
        }
    }
}

/// The neighbor on the same face.
fn beside(source: &Lattice<'_>, [x, y]: [usize; 2], part: &Part) -> Option<[usize; 2]> {
    match part.side {
        0 if y > 0 => Some([x, y - 1]),
        1 if x + 1 < source.columns => Some([x + 1, y]),
        2 if y + 1 < source.rows => Some([x, y + 1]),
        3 if x > 0 => Some([x - 1, y]),
        RIM => None,
        _ => None,
    }
}

/// The axis and place of the one line between two cells that lie side by side.
fn single_crossing(p: &Spot, q: &Spot) -> Option<(usize, f64)> {
    if p.face != q.face {
        return None;
    }
    for axis in [0, 1] {
        if p.at[1 - axis] == q.at[1 - axis] && p.at[axis].abs_diff(q.at[axis]) == 1 {
            return Some((axis, p.at[axis].max(q.at[axis]) as f64));
        }
    }
    None
}

/// The nearest place to `p` and `q` along an axis.
fn line_between(p: &Spot, q: &Spot, axis: usize) -> f64 {
    0.5 * (p.xy[axis] + q.xy[axis])
}

enum Bend {
    /// It stays in the cell.
    Inside,
    /// It leaves the cell, furthest at this share of the way.
    Outside(f64),
    /// It bends too much to say.
    Unclear,
}

/// Bends that are nothing but rounding, in cells: two images' lines lie as near as that where they coincide.
const STRAIGHT: f64 = 1e-9;

/// Whether the border leaves the cell between two places of it, by a third in the middle.
///
/// Between these it is a curve, or a crease of the target's map turns it somewhere. By as much as it bends, it may come further than its
/// places do. Where that is beyond the cell, it must go on along the axis for certain.
fn excursion(p: &Spot, m: &Spot, q: &Spot) -> Bend {
    let mut bend = Bend::Inside;
    for axis in [0, 1] {
        let (a, b, c) = (p.xy[axis], m.xy[axis], q.xy[axis]);
        let second = a - 2.0 * b + c;
        let (slope, beyond) = (c - a, second.abs());
        if beyond > 0.1 {
            return Bend::Unclear;
        }
        let low = p.at[axis] as f64;
        let outside = |from: f64, to: f64| from < low || to > low + 1.0;
        // The parabola a + (slope - 2·second)·s + 2·second·s² has its extremum here.
        let s = 0.5 - 0.25 * slope / second;
        if s > 0.0 && s < 1.0 {
            let extremum = a + s * (slope - 2.0 * second) + 2.0 * second * s * s;
            if outside(extremum, extremum) {
                return Bend::Outside(s);
            }
        }
        let near = outside(a.min(b).min(c) - beyond, a.max(b).max(c) + beyond);
        if near && beyond > STRAIGHT && slope.abs() < 4.0 * beyond {
            bend = Bend::Unclear;
        }
    }
    bend
}

/// Roughly a cell's area; of a needle, that of one less thin.
fn extent(lattice: &Lattice<'_>, cell: &LatticeCell) -> f64 {
    let center = lattice.decode(cell.face, cell.inside);
    let (mut area, mut square) = (0.0, 0.0_f64);
    for part in cell.parts() {
        let (a, b) = (
            lattice.decode(cell.face, part.from),
            lattice.decode(cell.face, part.to),
        );
        area += triangle(center, a, b).abs();
        let arm = sub(a, center);
        square = square.max(dot(arm, arm));
    }
    area.max(1e-4 * square).max(1e-24)
}

/// What a stretch of a cell's border sweeps about its anchor.
fn stretch(
    lattice: &Lattice<'_>,
    cell: &LatticeCell,
    anchor: Direction,
    tolerance: f64,
    from: f64,
    to: f64,
) -> f64 {
    let mut sum = 0.0;
    for (k, part) in cell.parts().iter().enumerate() {
        let (t0, t1) = ((from - k as f64).max(0.0), (to - k as f64).min(1.0));
        if t0 < t1 {
            let curve = Along {
                lattice,
                cell,
                part: *part,
            };
            let places = [t0, 0.5 * (t0 + t1), t1].map(|t| (t, curve.at(t)));
            sum += swept(&curve, anchor, places, tolerance);
        }
    }
    sum * lattice.sense(cell.face)
}

/// The area of a whole cell.
pub(in crate::resample::area) fn whole(
    lattice: &Lattice<'_>,
    cell: &LatticeCell,
    anchor: Direction,
    tolerance: f64,
) -> f64 {
    stretch(
        lattice,
        cell,
        anchor,
        tolerance,
        0.0,
        cell.parts().len() as f64,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::solid_angle::Rect;
    use crate::image::raster::shape_of_size;
    use crate::map::{Map, MapOptions};
    use crate::projections::REGISTRY;
    use crate::projections::projection::Coverage;

    fn exact(lattice: &Lattice<'_>, at: [usize; 2]) -> f64 {
        let [(u0, u1), (v0, v1)] = lattice.rectangle(at);
        lattice.map.solid_angle(Rect { u0, u1, v0, v1 })
    }

    fn each_cell(lattice: &Lattice<'_>, mut f: impl FnMut(usize, [usize; 2])) {
        for face in 0..lattice.map.info().faces {
            for y in 0..lattice.rows {
                for x in 0..lattice.columns {
                    f(face, [x, y]);
                }
            }
        }
    }

    #[test]
    fn cells_have_the_exact_solid_angle() {
        for info in REGISTRY {
            let map = Map::new(info.name).unwrap();
            let shape = shape_of_size(&map, 21);
            let lattice = Lattice::new(&map, &shape, None).unwrap();
            let mut worst = 0.0_f64;
            each_cell(&lattice, |face, at| {
                let want = exact(&lattice, at);
                let got = lattice.cell(face, at).map_or(0.0, |cell| {
                    let size = extent(&lattice, &cell);
                    let anchor = lattice.decode(face, cell.inside);
                    whole(&lattice, &cell, anchor, TOLERANCE * size)
                });
                worst = worst.max((got - want).abs() / want.max(1e-5));
            });
            assert!(worst < 1e-7, "{} {worst:e}", info.name);
        }
    }

    /// How far a source's cells and a target's are from sharing their areas out.
    fn worst(source: &Lattice<'_>, target: &Lattice<'_>) -> (f64, f64) {
        let mut overlay = Overlay::new(source, target);
        let mut given = HashMap::new();
        let (mut rows, mut columns) = (0.0_f64, 0.0_f64);
        each_cell(target, |face, at| {
            let mut sum = 0.0;
            overlay.overlaps(face, at, |face, at, area| {
                sum += area;
                *given.entry((face, at)).or_insert(0.0) += area;
            });
            let want = exact(target, at);
            rows = rows.max((sum - want).abs() / want.max(1e-5));
        });
        each_cell(source, |face, at| {
            let got = given.get(&(face, at)).copied().unwrap_or(0.0);
            let want = exact(source, at);
            columns = columns.max((got - want).abs() / want.max(1e-5));
        });
        (rows, columns)
    }

    #[test]
    fn a_corner_between_two_places_is_looked_for() {
        // Beside a line between columns the border turns: at 18.01, between the first and the second of these places.
        let spot = |x: f64, y: f64| Spot {
            face: 0,
            uv: [x, y],
            xy: [x, y],
            at: [x as usize, y as usize],
        };
        let [p, m, q] = [[17.987, 3.0], [17.9777, 3.32], [17.9262, 3.655]].map(|[x, y]| spot(x, y));
        assert!(!matches!(excursion(&p, &m, &q), Bend::Inside));
        // As bent, but far from lines; and beside one, but on its way.
        let [p, m, q] = [[17.487, 3.1], [17.4777, 3.32], [17.4262, 3.555]].map(|[x, y]| spot(x, y));
        assert!(matches!(excursion(&p, &m, &q), Bend::Inside));
        let [p, m, q] = [[17.99, 3.1], [17.7, 3.32], [17.4, 3.555]].map(|[x, y]| spot(x, y));
        assert!(matches!(excursion(&p, &m, &q), Bend::Inside));
    }

    #[test]
    fn both_sums_are_the_cells() {
        // Each projection against partners with a seam, with faces, with a rim.
        let partners = ["latlong", "cube", "angular"];
        let sphere = |name: &str| Map::new(name).unwrap();
        for info in REGISTRY {
            if sphere(info.name).coverage() != Coverage::Sphere {
                continue;
            }
            for partner in partners {
                for (a, b) in [(info.name, partner), (partner, info.name)] {
                    for turned in [false, true] {
                        let (source, target) = (sphere(a), sphere(b));
                        let rotation =
                            turned.then(|| crate::geometry::axes::from_angles(33.0, -20.0, 71.0));
                        let frame = crate::resample::area::frame::frame(&source, &target, rotation);
                        let shape = shape_of_size(&source, 20);
                        let from = Lattice::new(&source, &shape, None).unwrap();
                        let shape = shape_of_size(&target, 17);
                        let into = Lattice::new(&target, &shape, Some(frame)).unwrap();
                        let (rows, columns) = worst(&from, &into);
                        assert!(
                            rows < 1e-6 && columns < 1e-6,
                            "{a} {b} {turned} {rows:e} {columns:e}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn texels_on_the_edges() {
        // Meridians of both images coincide there, and parallels of one end on them.
        let grids = ["centers", "corners", "corners-v"];
        let map = |grid| Map::with("latlong", MapOptions::new().grid(grid)).unwrap();
        for (a, b) in grids.iter().flat_map(|a| grids.map(|b| (*a, b))) {
            let (source, target) = (map(a), map(b));
            for (n, m) in (3..12).flat_map(|n| (3..12).map(move |m| (n, m))) {
                let from = Lattice::new(&source, &[n, 2 * n], None).unwrap();
                let frame = crate::resample::area::frame::frame(&source, &target, None);
                let into = Lattice::new(&target, &[m, 2 * m], Some(frame)).unwrap();
                let (rows, columns) = worst(&from, &into);
                assert!(
                    rows < 1e-6 && columns < 1e-6,
                    "{a} {n} {b} {m} {rows:e} {columns:e}"
                );
            }
        }
    }
}
