//! The border of a cell that meets seams, poles or creases of the source: followed from place to place, as finely as it
//! needs.
//!
//! Where the border leaves a face of the source, across a seam or around a pole, the region goes on along the
//! side of that face, in its own sense, to where the border enters next. So each face holds closed
//! regions, and nothing need be known of what lies across. An edge that runs up to a pole goes from one column to any other
//! beside it; what is between there and the pole is nothing, and so it goes by way of the row's end.

use crate::projections::projection::Outline;
use crate::resample::area::lattice::Lattice;
use crate::resample::area::traced::arc::{Arc, Piece, PlanePoint, differences, minus};

/// Parts of an edge at which it is no longer halved: what lies between is a step across a seam.
const SHORTEST: f64 = 1e-11;

/// Parts of an edge below which it may run along a pole, from column to column.
const SHORT: f64 = 1e-6;

/// Rows from a pole within which that has no area.
const POLAR: f64 = 1e-4;

/// Places along a side of a face, a side being 1, that are the same.
const BACK: f64 = 1e-9;

/// A place on a face of the source.
#[derive(Clone, Copy, Debug)]
struct Spot {
    face: usize,
    at: PlanePoint,
}

/// Where the border crosses a side of a face.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    face: usize,
    /// Around the face in the sense of (u, v): the side's number and how far along it.
    place: f64,
    leaves: bool,
}

/// The border of one cell after another.
#[derive(Default)]
pub(in crate::resample::area) struct Border {
    /// Its arcs, and those along sides of faces.
    arcs: Vec<(usize, Arc)>,
    crossings: Vec<Crossing>,
    pieces: Vec<Piece>,
    places: usize,
}

/// Places that are tried for one cell, at most.
const MOST_PLACES: usize = 4000;

/// What is left of a fourth difference of five places on a straight line, at most, in parts of a face's side: each is
/// rounded a few times, and counts up to six times.
const ROUNDED: f64 = 16.0 * f64::EPSILON;

impl Border {
    /// Follows the border of a cell of `into` through `from`. False where it leaves the source or never becomes smooth.
    /// `fine` is the area of which each arc may miss a tiny part.
    pub fn trace(
        &mut self,
        from: &Lattice<'_>,
        into: &Lattice<'_>,
        face: usize,
        at: [usize; 2],
        fine: f64,
    ) -> bool {
        self.arcs.clear();
        self.crossings.clear();
        self.places = 0;
        let [(u0, u1), (v0, v1)] = into.rectangle(at);
        let corners = [[u0, v0], [u1, v0], [u1, v1], [u0, v1]];
        for side in 0..4 {
            let (a, b) = (corners[side], corners[(side + 1) % 4]);
            let locate = |t: f64| {
                let uv = [0, 1].map(|k| a[k] + t * (b[k] - a[k]));
                let spot = from.locate(into.decode(face, uv))?;
                Some(Spot {
                    face: spot.face,
                    at: spot.xy,
                })
            };
            let ends = [locate(0.0), locate(0.5), locate(1.0)];
            let [Some(p), Some(q), Some(r)] = ends else {
                return false;
            };
            if !self.follow(&locate, [(0.0, p), (0.5, q), (1.0, r)], fine, from) {
                return false;
            }
        }
        self.close(from, into.sense(face))
    }

    fn follow(
        &mut self,
        locate: &impl Fn(f64) -> Option<Spot>,
        [a, m, b]: [(f64, Spot); 3],
        fine: f64,
        from: &Lattice<'_>,
    ) -> bool {
        self.places += 2;
        if self.places > MOST_PLACES {
            return false;
        }
        if b.0 - a.0 < SHORT
            && let Some(side) = beside_a_row(&a.1, &b.1, from)
        {
            for (spot, out) in [(&a.1, true), (&b.1, false)] {
                let foot = [spot.at[0], side];
                let (p, q) = if out {
                    (spot.at, foot)
                } else {
                    (foot, spot.at)
                };
                self.arcs.push((spot.face, Arc::line(p, q)));
            }
            return true;
        }
        if b.0 - a.0 < SHORTEST {
            // A rim is no side of a face that a region could go on along.
            if from.map.outline() != Outline::Square {
                return false;
            }
            self.step(&a.1, &b.1, from);
            return true;
        }
        let between = |p: f64, q: f64| {
            let t = 0.5 * (p + q);
            locate(t).map(|spot| (t, spot))
        };
        let (Some(p), Some(q)) = (between(a.0, m.0), between(m.0, b.0)) else {
            return false;
        };
        let all = [a.1, p.1, m.1, q.1, b.1];
        if all.iter().all(|spot| spot.face == a.1.face) {
            let places = all.map(|spot| spot.at);
            let (third, fourth) = differences(places);
            let way = minus(b.1.at, a.1.at);
            let length = (way[0] * way[0] + way[1] * way[1]).sqrt();
            let side = from.columns.max(from.rows) as f64;
            // Differences of half as many steps, twice as long. The parts of a line that is straight but for rounding are no
            // straighter.
            if 0.01 * 16.0 * fourth * length.min(1.0) <= fine || fourth <= ROUNDED * side {
                let arc = Arc::through([places[0], places[2], places[4]], third.map(|d| 8.0 * d));
                self.arcs.push((a.1.face, arc));
                return true;
            }
        }
        if let Some([before, after]) = across_a_seam(locate, [a, p, m, q, b], from) {
            // As often as the search halves.
            self.places += 40;
            return self.smooth(locate, [a, before], fine, from)
                && self.follow(locate, [before, before, after], fine, from)
                && self.smooth(locate, [after, b], fine, from);
        }
        self.follow(locate, [a, p, m], fine, from) && self.follow(locate, [m, q, b], fine, from)
    }

    /// Follows what may well be smooth.
    fn smooth(
        &mut self,
        locate: &impl Fn(f64) -> Option<Spot>,
        [a, b]: [(f64, Spot); 2],
        fine: f64,
        from: &Lattice<'_>,
    ) -> bool {
        if b.0 <= a.0 {
            return true;
        }
        let t = 0.5 * (a.0 + b.0);
        match locate(t) {
            Some(spot) => self.follow(locate, [a, (t, spot), b], fine, from),
            None => false,
        }
    }

    /// Goes from a side of a face to one of another, or to another side of the same.
    fn step(&mut self, a: &Spot, b: &Spot, from: &Lattice<'_>) {
        let ends = [a, b].map(|spot| around(from, spot.at));
        if a.face == b.face && (ends[0] - ends[1]).abs() < BACK {
            // Across and back again, or nearly so.
            self.arcs.push((a.face, Arc::line(a.at, b.at)));
            return;
        }
        for ((spot, leaves), place) in [(a, true), (b, false)].into_iter().zip(ends) {
            let side = side_place(from, place);
            let ends = if leaves {
                (spot.at, side)
            } else {
                (side, spot.at)
            };
            self.arcs.push((spot.face, Arc::line(ends.0, ends.1)));
            self.crossings.push(Crossing {
                face: spot.face,
                place,
                leaves,
            });
        }
    }

    /// Closes what the border bounds along the sides of faces.
    fn close(&mut self, from: &Lattice<'_>, sense: f64) -> bool {
        let crossings = std::mem::take(&mut self.crossings);
        for leave in crossings.iter().filter(|crossing| crossing.leaves) {
            let forward = sense * from.sense(leave.face) > 0.0;
            let way = |enter: &Crossing| {
                let way = if forward {
                    enter.place - leave.place
                } else {
                    leave.place - enter.place
                };
                if way < 0.0 { way + 4.0 } else { way }
            };
            let next = crossings
                .iter()
                .filter(|crossing| crossing.face == leave.face && !crossing.leaves)
                .min_by(|p, q| way(p).total_cmp(&way(q)));
            let Some(next) = next else {
                self.crossings = crossings;
                return false;
            };
            let (mut place, mut rest) = (leave.place, way(next));
            while rest > 0.0 {
                let to_corner = if forward {
                    place.floor() + 1.0 - place
                } else {
                    place - (place.ceil() - 1.0)
                };
                let step = to_corner.min(rest);
                let on = if forward { place + step } else { place - step };
                let ends = (side_place(from, place), side_place(from, on));
                // What runs along a row has no area on either side.
                if ends.0[1] != ends.1[1] {
                    self.arcs.push((leave.face, Arc::line(ends.0, ends.1)));
                }
                rest -= step;
                if rest < 1e-15 {
                    break;
                }
                place = on.rem_euclid(4.0);
                if !forward && place == 0.0 {
                    place = 4.0;
                }
            }
        }
        self.crossings = crossings;
        true
    }

    /// Calls `each(face, pieces)` for each face that the border touches; false if that says so.
    pub fn faces(
        &mut self,
        from: &Lattice<'_>,
        mut each: impl FnMut(usize, &[Piece]) -> bool,
    ) -> bool {
        // A handful of faces at most: no need for more than a pass for each.
        let mut known = 0_u64;
        for k in 0..self.arcs.len() {
            let face = self.arcs[k].0;
            if known >> face & 1 == 1 {
                continue;
            }
            known |= 1 << face;
            self.pieces.clear();
            for (_, arc) in self.arcs[k..].iter().filter(|(on, _)| *on == face) {
                arc.pieces([from.columns, from.rows], &mut self.pieces);
            }
            if !each(face, &self.pieces) {
                return false;
            }
        }
        true
    }
}

/// The first or the last row's end, where both places lie next to it: the end is a pole if they are far apart, and if they
/// are not it does no harm.
fn beside_a_row(a: &Spot, b: &Spot, from: &Lattice<'_>) -> Option<f64> {
    let near = |side: f64| [a, b].iter().all(|spot| (spot.at[1] - side).abs() < POLAR);
    [0.0, from.rows as f64]
        .into_iter()
        .find(|side| a.face == b.face && near(*side))
}

/// Whether two places lie on both sides of a seam, as far as can be told: half a face apart, or on two faces.
fn apart(a: &Spot, b: &Spot, from: &Lattice<'_>) -> bool {
    let [x, y] = minus(a.at, b.at).map(f64::abs);
    a.face != b.face || 2.0 * x > from.columns as f64 || 2.0 * y > from.rows as f64
}

/// Where one seam is crossed, the last place before it and the first behind.
fn across_a_seam(
    locate: &impl Fn(f64) -> Option<Spot>,
    places: [(f64, Spot); 5],
    from: &Lattice<'_>,
) -> Option<[(f64, Spot); 2]> {
    let mut steps = (1..5).filter(|&k| apart(&places[k - 1].1, &places[k].1, from));
    let (Some(k), None) = (steps.next(), steps.next()) else {
        return None;
    };
    let (mut before, mut after) = (places[k - 1], places[k]);
    while after.0 - before.0 >= SHORTEST {
        let t = 0.5 * (before.0 + after.0);
        let spot = locate(t)?;
        match (apart(&before.1, &spot, from), apart(&spot, &after.1, from)) {
            (false, true) => before = (t, spot),
            (true, false) => after = (t, spot),
            // A corner, or a fold.
            _ => return None,
        }
    }
    Some([before, after])
}

/// The nearest place on the sides of a face: from the top left, in the sense of (u, v).
fn around(from: &Lattice<'_>, [x, y]: PlanePoint) -> f64 {
    let (w, h) = (from.columns as f64, from.rows as f64);
    let (s, t) = ((x / w).clamp(0.0, 1.0), (y / h).clamp(0.0, 1.0));
    let far = [t, 1.0 - s, 1.0 - t, s];
    let side = (1..4).fold(0, |best, k| if far[k] < far[best] { k } else { best });
    side as f64 + [s, t, 1.0 - s, 1.0 - t][side]
}

/// The place in cells.
fn side_place(from: &Lattice<'_>, place: f64) -> PlanePoint {
    let (w, h) = (from.columns as f64, from.rows as f64);
    let place = place.rem_euclid(4.0);
    let side = (place as usize).min(3);
    let s = place - side as f64;
    match side {
        0 => [s * w, 0.0],
        1 => [w, s * h],
        2 => [(1.0 - s) * w, h],
        _ => [0.0, (1.0 - s) * h],
    }
}

#[cfg(test)]
mod tests {
    use super::Border;
    use crate::map::{Map, MapOptions};
    use crate::resample::area::fast::edges::FINE;
    use crate::resample::area::frame::frame;
    use crate::resample::area::lattice::Lattice;

    #[test]
    fn what_is_straight_but_for_rounding_is_not_cut() {
        let source = Map::new("latlong").unwrap();
        let from = Lattice::new(&source, &[512, 1024], None).unwrap();
        // In degrees. Of the narrowest, 64 cells are as wide as a million roundings of a place.
        for fov in [1e-7, 1e-6, 1e-5, 1e-4] {
            let parameters = [("fov", fov)];
            let options = MapOptions::new().parameters(&parameters);
            let view = Map::with("perspective", options).unwrap();
            let turn = Some(frame(&source, &view, None));
            let into = Lattice::new(&view, &[64, 64], turn).unwrap();
            // How wide a cell is, in those of the source.
            let width = fov / 180.0 * 512.0 / 64.0;
            let fine = 0.5 * FINE * width * width;
            let mut border = Border::default();
            for at in [[0, 0], [31, 32], [63, 5]] {
                assert!(border.trace(&from, &into, 0, at, fine), "{fov} {at:?}");
                // The quarters of each of the four sides.
                assert_eq!(border.places, 8, "{fov} {at:?}");
            }
        }
    }
}
