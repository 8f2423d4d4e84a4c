//! The texels of an image as cells on the sphere.
//!
//! A [`LatticeCell`] is the part of a texel's rectangle that holds sphere, with its border as a closed loop of
//! smooth parts in the sense of (u, v): sides of the rectangle, and the rim of the valid image
//! where it cuts the texel. Places on the border have a coordinate: the number of the part plus how
//! far along it.
//!
//! Small images are refined, so that no cell spans more than a fraction of the sphere; a cell then is a
//! part of its texel. The valid image is taken as convex, and its rim is found by bisection of
//! [`Projection::contains`], but for disks: whatever the outline is, no formula of it is needed.
//!
//! Where faces show some of the sphere twice, as lenses of more than 180° do, all of it counts once: a cell ends where what another face
//! counts begins, as it would at a rim. Texels of a target that show nothing of their own are whole: they hold a value, and no light.

use crate::error::Error;
use crate::geometry::solid_angle::Rect;
use crate::geometry::vector::{cross, dot, normalized, sub};
use crate::image::raster::Raster;
use crate::image::rim::nearest_valid_texel;
use crate::map::Map;
use crate::number::angle;
use crate::projections::projection::Visitor;
use crate::projections::projection::one;
use crate::projections::projection::{Coverage, Outline, Projection, Uv};
use crate::resample::area::sphere::{Curve, Direction, triangle};
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::OnceLock;

/// Overlaps below this part of the smaller cell are no overlaps: it is what rounding and the hair's breadth
/// between coinciding edges make, and so a conversion to the same texels gives the same texels.
pub(super) const NOTHING: f64 = 3e-8;

/// Cells along a side of a face, at least.
const FEWEST: usize = 16;

/// What a texel shows of its own is none below this, in steradians a unit of its area on the face.
const SLIVER: f64 = 1e-7;

/// The image of a map, in a frame that two images share.
pub(super) struct Lattice<'a> {
    pub map: &'a Map,
    pub raster: Raster,
    /// The map's view frame to the shared one, and back; none where they are the same.
    frame: Option<[[[f64; 3]; 3]; 2]>,
    /// Cells a texel, along each side.
    pub refined: usize,
    pub columns: usize,
    pub rows: usize,
    /// For each face, +1 where (u, v) turn as seen from outside, else -1.
    sense: Vec<f64>,
    /// The radius about the middle of a face within which what it shows counts, and whether texels that lie beyond it hold nothing.
    own: (f64, bool),
    /// The angle from the view axis within which all of the valid image lies.
    reach: OnceLock<f64>,
}

/// A place in an image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    pub face: usize,
    pub uv: [f64; 2],
    /// In cells from the left and from the top.
    pub xy: [f64; 2],
    /// The cell that holds it.
    pub at: [usize; 2],
}

impl Spot {
    pub fn same_cell(&self, other: &Spot) -> bool {
        self.face == other.face && self.at == other.at
    }
}

/// A smooth part of a border, from one place of a face to another: straight in (u, v), or along the rim.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Part {
    pub from: [f64; 2],
    pub to: [f64; 2],
    /// Which side of the rectangle: top, right, bottom, left, or 4 for the rim.
    pub side: u8,
}

pub(super) const RIM: u8 = 4;

impl Part {
    /// The parameter of the part's place nearest to `uv`; on a rim, of that in line with `inside`.
    fn parameter(&self, inside: [f64; 2], uv: [f64; 2]) -> f64 {
        let minus = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
        let along = minus(self.to, self.from);
        let t = if self.side == RIM {
            let (ray, off) = (minus(uv, inside), minus(inside, self.from));
            (off[0] * ray[1] - off[1] * ray[0]) / (along[0] * ray[1] - along[1] * ray[0])
        } else {
            let off = minus(uv, self.from);
            (along[0] * off[0] + along[1] * off[1]) / (along[0] * along[0] + along[1] * along[1])
        };
        // 0/0 becomes 0.
        if t > 0.0 { t.min(1.0) } else { 0.0 }
    }
}

/// What a cell covers.
#[derive(Clone, Copy, Debug)]
pub(super) struct LatticeCell {
    pub face: usize,
    pub at: [usize; 2],
    parts: [Part; 8],
    count: usize,
    /// It ends at this distance from the middle of its face.
    limit: f64,
    /// A place inside, which sees the whole border.
    pub inside: [f64; 2],
}

impl LatticeCell {
    pub fn parts(&self) -> &[Part] {
        &self.parts[..self.count]
    }

    fn push(&mut self, part: Part) {
        if self.count < self.parts.len() {
            self.parts[self.count] = part;
            self.count += 1;
        }
    }
}

struct Decode(Uv<f64>);

impl Visitor for Decode {
    type Output = Direction;
    fn visit<P: Projection>(self, p: P) -> Direction {
        one::decode(p, self.0)
    }
}

struct Encode(Direction);

impl Visitor for Encode {
    type Output = Uv<f64>;
    fn visit<P: Projection>(self, p: P) -> Uv<f64> {
        one::encode(p, self.0)
    }
}

/// Whether a face holds a place, and that within a distance from its middle.
struct Contains(Uv<f64>, f64);

impl Visitor for Contains {
    type Output = bool;
    fn visit<P: Projection>(self, p: P) -> bool {
        let Contains(uv, limit) = self;
        let [x, y] = [uv.u - 0.5, uv.v - 0.5];
        // As far out as `contains` lets rims.
        x * x + y * y <= limit * limit * (1.0 + 8.0 * f64::EPSILON) && one::contains(p, uv)
    }
}

/// The last valid place on the way from a valid place through another one and beyond, within the square.
struct LastValid {
    face: usize,
    from: [f64; 2],
    through: [f64; 2],
    /// How far it goes, in distances between the two.
    farthest: f64,
    /// Nothing is valid beyond this distance from the middle of the face.
    limit: f64,
}

impl LastValid {
    /// How far the circle that ends the disk, or what of it is valid, is about the middle, in distances between the two places: a little
    /// beyond it, where `contains` lets rims out, for beside a rim of infinite density a hair is a square root's.
    fn on_circle(&self) -> Option<f64> {
        let from = self.from.map(|x| x - 0.5);
        let way = [0, 1].map(|k| self.through[k] - self.from[k]);
        let radius = self.limit.min(0.5);
        let product = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let (a, b, c) = (
            product(way, way),
            product(from, way),
            product(from, from) - radius * radius * (1.0 + 6.0 * f64::EPSILON),
        );
        let root = (b * b - a * c).sqrt();
        // Of two forms of the larger root the one that does not cancel.
        let r = if b > 0.0 {
            -c / (b + root)
        } else {
            (root - b) / a
        };
        (r > 0.0 && r < self.farthest).then_some(r)
    }
}

impl Visitor for LastValid {
    type Output = [f64; 2];
    fn visit<P: Projection>(self, p: P) -> [f64; 2] {
        let at = |r: f64| [0, 1].map(|k| self.from[k] + r * (self.through[k] - self.from[k]));
        let valid = |r: f64| {
            let [u, v] = at(r);
            let face = self.face as f64;
            Contains(Uv { u, v, face }, self.limit).visit(p)
        };
        let (mut low, mut high) = (0.0, self.farthest);
        if valid(high) {
            return at(high);
        }
        if P::INFO.outline == Outline::Disk
            && let Some(r) = self.on_circle()
            && valid(r)
        {
            return at(r);
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if valid(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        at(low)
    }
}

/// An angle from the view axis that nothing of the valid image is beyond.
fn reach(map: &Map) -> f64 {
    match map.coverage() {
        Coverage::Sphere => f64::INFINITY,
        Coverage::Hemisphere => FRAC_PI_2,
        Coverage::Cap(angle) => angle,
        Coverage::Part(_) => (0..map.info().faces)
            .map(|face| sampled_reach(map, face))
            .fold(0.0, f64::max),
    }
}

/// The same of a face, from samples and how far they are apart.
fn sampled_reach(map: &Map, face: usize) -> f64 {
    const SAMPLES: usize = 64;
    let at = |k: usize| k as f64 / SAMPLES as f64;
    let direction = |i: usize, j: usize| {
        let uv = Uv {
            u: at(i),
            v: at(j),
            face: face as f64,
        };
        map.visit_canonical(Contains(uv, f64::INFINITY))
            .then(|| map.visit_canonical(Decode(uv)))
    };
    let (mut reach, mut step) = (0.0_f64, 0.0_f64);
    let mut above = [None; SAMPLES + 1];
    for j in 0..=SAMPLES {
        let row: [Option<Direction>; SAMPLES + 1] = std::array::from_fn(|i| direction(i, j));
        for (i, d) in row.iter().enumerate() {
            let Some(d) = *d else { continue };
            reach = reach.max(angle::atan2(angle::length(d[0], d[1]), d[2]));
            let beside = if i > 0 { row[i - 1] } else { None };
            for near in [beside, above[i]].into_iter().flatten() {
                let way = sub(d, near);
                step = step.max(dot(way, way).sqrt());
            }
        }
        above = row;
    }
    // What lies between samples is nearer to one than they are to each other.
    reach + 2.0 * step
}

/// The corners of a rectangle, in the order of the sides that begin there.
fn corners([(u0, u1), (v0, v1)]: [(f64, f64); 2]) -> [[f64; 2]; 4] {
    [[u0, v0], [u1, v0], [u1, v1], [u0, v1]]
}

fn times(m: &[[f64; 3]; 3], d: Direction) -> Direction {
    m.map(|row| row[0] * d[0] + row[1] * d[1] + row[2] * d[2])
}

impl<'a> Lattice<'a> {
    /// An image of this shape; `frame` takes the map's view frame to the shared one.
    pub fn new(map: &'a Map, shape: &[usize], frame: Option<[[f64; 3]; 3]>) -> Result<Self, Error> {
        let raster = Raster::new(map, shape)?;
        let refined = match FEWEST.div_ceil(raster.width.min(raster.height)) {
            1 => 1,
            // Even, so that a kink on an axis lies between cells.
            k => k.next_multiple_of(2),
        };
        let frame = frame.map(|m| {
            let transposed = [0, 1, 2].map(|i| [m[0][i], m[1][i], m[2][i]]);
            [m, transposed]
        });
        let mut lattice = Lattice {
            map,
            raster,
            frame,
            refined,
            columns: raster.width * refined,
            rows: raster.height * refined,
            sense: Vec::new(),
            own: (map.own_radius(), false),
            reach: OnceLock::new(),
        };
        lattice.sense = (0..map.face_layout().faces)
            .map(|face| {
                let at = |u, v| lattice.decode(face, [u, v]);
                triangle(at(0.45, 0.4), at(0.4501, 0.4), at(0.45, 0.4001)).signum()
            })
            .collect();
        Ok(lattice)
    }

    /// The same image, of which nothing is that another face counts: a source.
    pub fn counted_once(mut self) -> Self {
        self.own.1 = true;
        self
    }

    /// The same image, each texel as `refined` × `refined` cells.
    pub fn refine(mut self, refined: usize) -> Self {
        self.refined = refined;
        self.columns = self.raster.width * refined;
        self.rows = self.raster.height * refined;
        self
    }

    /// Whether all of the valid image is farther than an angle from a direction.
    pub fn is_far(&self, d: Direction, angle: f64) -> bool {
        let [x, y, z] = match &self.frame {
            None => d,
            Some([_, m]) => times(m, d),
        };
        let reach = *self.reach.get_or_init(|| reach(self.map));
        angle::atan2(angle::length(x, y), z) > reach + angle
    }

    /// The map's view frame to the shared one.
    pub fn turn(&self) -> Option<[[f64; 3]; 3]> {
        self.frame.map(|[m, _]| m)
    }

    /// Whether all cells are equally long along an axis.
    pub fn uniform(&self, axis: usize) -> bool {
        self.axis(axis).0.1 == -0.5
    }

    fn axis(&self, axis: usize) -> ((f64, f64), usize) {
        if axis == 0 {
            (self.raster.along_u.index(), self.columns)
        } else {
            (self.raster.along_v.index(), self.rows)
        }
    }

    /// The coordinate of half-line `k`: even ones lie between cells, odd ones halfway. Beyond the image it goes on as
    /// far as one step.
    pub fn line(&self, axis: usize, k: isize) -> f64 {
        let (index, cells) = self.axis(axis);
        let last = 2 * cells as isize;
        if k < 0 {
            return 2.0 * self.line(axis, 0) - self.line(axis, -k);
        }
        if k > last {
            return 2.0 * self.line(axis, last) - self.line(axis, (2 * last - k).max(0));
        }
        let cell = (k as usize / 2).min(cells - 1);
        let (from, to) = self.edges(index, cells, cell);
        match k as usize - 2 * cell {
            0 => from,
            1 => 0.5 * (from + to),
            _ => to,
        }
    }

    /// (scale, offset) of the place in cells as a function of the coordinate.
    pub fn scale(&self, axis: usize) -> (f64, f64) {
        let ((scale, offset), _) = self.axis(axis);
        let k = self.refined as f64;
        (scale * k, (offset + 0.5) * k)
    }

    pub fn sense(&self, face: usize) -> f64 {
        self.sense[face]
    }

    pub fn decode(&self, face: usize, [u, v]: [f64; 2]) -> Direction {
        let face = face as f64;
        let d = self.map.visit_canonical(Decode(Uv { u, v, face }));
        match &self.frame {
            None => d,
            Some([m, _]) => times(m, d),
        }
    }

    /// The stored texel that has the value of a cell.
    #[inline(always)]
    pub fn stored(&self, face: usize, cell: [usize; 2]) -> usize {
        let mut texel = cell;
        if self.refined > 1 {
            texel = cell.map(|k| k / self.refined);
        }
        if self.raster.has_rim() {
            let (i, j) = nearest_valid_texel(&self.raster, texel[0], texel[1]);
            texel = [i, j];
        }
        self.raster.view(face).index(texel[0], texel[1])
    }

    /// Where a direction lies, if the image holds it.
    pub fn locate(&self, d: Direction) -> Option<Spot> {
        let d = match &self.frame {
            None => d,
            Some([_, m]) => times(m, d),
        };
        let Uv { u, v, face } = self.map.visit_canonical(Encode(d));
        if u.is_nan() {
            return None;
        }
        let k = self.refined as f64;
        let place = |(scale, offset): (f64, f64), x: f64| (x * scale + (offset + 0.5)) * k;
        let x = place(self.raster.along_u.index(), u);
        let y = place(self.raster.along_v.index(), v);
        Some(Spot {
            face: face as usize,
            uv: [u, v],
            xy: [x, y],
            // `as` takes negative numbers to 0.
            at: [
                (x as usize).min(self.columns - 1),
                (y as usize).min(self.rows - 1),
            ],
        })
    }

    /// The edges of cell `i` along one side, within the image.
    fn edges(&self, (scale, offset): (f64, f64), cells: usize, i: usize) -> (f64, f64) {
        let k = self.refined as f64;
        let edge = |i: usize| {
            if offset == -0.5 {
                // As exact as the grid's own edges.
                i as f64 / cells as f64
            } else {
                (((i as f64 / k) - (offset + 0.5)) / scale).clamp(0.0, 1.0)
            }
        };
        (edge(i), edge(i + 1))
    }

    /// The cell's rectangle: (u0, u1), (v0, v1).
    pub fn rectangle(&self, at: [usize; 2]) -> [(f64, f64); 2] {
        [
            self.edges(self.raster.along_u.index(), self.columns, at[0]),
            self.edges(self.raster.along_v.index(), self.rows, at[1]),
        ]
    }

    fn contains(&self, (face, limit): (usize, f64), [u, v]: [f64; 2]) -> bool {
        let face = face as f64;
        self.map.visit_canonical(Contains(Uv { u, v, face }, limit))
    }

    fn last_valid(
        &self,
        (face, limit): (usize, f64),
        [from, through]: [[f64; 2]; 2],
        farthest: f64,
    ) -> [f64; 2] {
        self.map.visit_canonical(LastValid {
            face,
            from,
            through,
            farthest,
            limit,
        })
    }

    /// How far from the middle of its face a cell ends.
    fn limit(&self, at: [usize; 2]) -> f64 {
        let (own, once) = self.own;
        if own >= 0.5 {
            return f64::INFINITY;
        }
        if once {
            return own;
        }
        let texel = at.map(|k| k / self.refined);
        let [(u0, u1), (v0, v1)] = [
            self.raster.along_u.cell(texel[0]),
            self.raster.along_v.cell(texel[1]),
        ];
        // A sliver is as good as nothing: the rest of its light is lost, and it is found by no rounding.
        let area = (u1 - u0) * (v1 - v0);
        if self.map.solid_angle(Rect { u0, u1, v0, v1 }) > SLIVER * area {
            own
        } else {
            f64::INFINITY
        }
    }

    /// Whether all of a cell's rectangle lies in what it may cover of its face.
    pub fn is_whole(&self, face: usize, at: [usize; 2]) -> bool {
        if self.map.outline() == Outline::Square {
            return true;
        }
        let corners = corners(self.rectangle(at));
        let near = |uv: &[f64; 2]| {
            let [x, y] = uv.map(|x| x - 0.5);
            x * x + y * y < 0.996 * self.own.0 * self.own.0
        };
        // Far inside a disk there is no need to ask.
        if self.map.outline() == Outline::Disk && corners.iter().all(near) {
            return true;
        }
        let within = (face, self.limit(at));
        corners.iter().all(|uv| self.contains(within, *uv))
    }

    /// Whether a direction lies in a cell.
    pub fn holds(&self, cell: &LatticeCell, d: Direction) -> bool {
        if self.own.0 < 0.5 && cell.limit.is_infinite() {
            return self.winds_about(cell, d);
        }
        let spot = self.locate(d);
        spot.is_some_and(|spot| spot.face == cell.face && spot.at == cell.at)
    }

    /// The same of one that [`Lattice::locate`] finds on another face: whether the border goes around the direction.
    fn winds_about(&self, cell: &LatticeCell, d: Direction) -> bool {
        const STEPS: usize = 8;
        let mut border = cell.parts().iter().flat_map(|part| {
            (0..STEPS).map(|k| {
                let t = k as f64 / STEPS as f64;
                self.decode(cell.face, self.place(cell, part, t))
            })
        });
        let Some(first) = border.next() else {
            return false;
        };
        let (mut turned, mut from) = (0.0, first);
        for to in border.chain([first]) {
            let across = dot(d, cross(from, to));
            let along = dot(from, to) - dot(d, from) * dot(d, to);
            turned += angle::atan2(across, along);
            from = to;
        }
        // The border of what lies opposite goes around as well.
        turned.abs() > PI && dot(d, first) > 0.0
    }

    /// A cell; none where it holds no sphere.
    pub fn cell(&self, face: usize, at: [usize; 2]) -> Option<LatticeCell> {
        let [(u0, u1), (v0, v1)] = self.rectangle(at);
        if u1 <= u0 || v1 <= v0 {
            return None;
        }
        let corners = corners([(u0, u1), (v0, v1)]);
        let center = [0.5 * (u0 + u1), 0.5 * (v0 + v1)];
        let mut cell = LatticeCell {
            face,
            at,
            parts: [Part::default(); 8],
            count: 0,
            limit: self.limit(at),
            inside: center,
        };
        let whole = self.map.outline() == Outline::Square
            || corners
                .iter()
                .all(|uv| self.contains((face, cell.limit), *uv));
        let mut sides = [None; 4];
        for (side, slot) in sides.iter_mut().enumerate() {
            let (from, to) = (corners[side], corners[(side + 1) % 4]);
            let ends = if whole {
                Some((from, to))
            } else {
                self.valid_part((face, cell.limit), from, to)
            };
            *slot = ends.map(|(from, to)| Part {
                from,
                to,
                side: side as u8,
            });
        }
        let mut given = sides
            .iter()
            .flatten()
            .copied()
            .collect::<smallparts::Parts>();
        let parts = given.slice();
        if parts.is_empty() {
            return None;
        }
        for (k, part) in parts.iter().enumerate() {
            cell.push(*part);
            let next = parts[(k + 1) % parts.len()].from;
            if next != part.to {
                cell.push(Part {
                    from: part.to,
                    to: next,
                    side: RIM,
                });
            }
        }
        if !whole {
            let n = 2.0 * parts.len() as f64;
            let mean = [0, 1].map(|k| parts.iter().map(|p| p.from[k] + p.to[k]).sum::<f64>() / n);
            // The center might lie between the rim and its chord. Where there is one side only, the mean
            // lies on it: half way from there to the rim.
            let far = self.last_valid((face, cell.limit), [mean, center], 1.0);
            cell.inside = if parts.len() == 1 {
                [0.5 * (mean[0] + far[0]), 0.5 * (mean[1] + far[1])]
            } else {
                mean
            };
        }
        Some(cell)
    }

    /// What of a side lies in the valid image.
    fn valid_part(
        &self,
        within: (usize, f64),
        from: [f64; 2],
        to: [f64; 2],
    ) -> Option<([f64; 2], [f64; 2])> {
        let valid = |uv: [f64; 2]| self.contains(within, uv);
        let cut = |inside: [f64; 2], end: [f64; 2]| {
            if valid(end) {
                end
            } else {
                self.last_valid(within, [inside, end], 1.0)
            }
        };
        // The side's place nearest to the image's center is valid if any is.
        let nearest = [0, 1].map(|k| 0.5_f64.clamp(from[k].min(to[k]), from[k].max(to[k])));
        let inside = [from, to, nearest].into_iter().find(|uv| valid(*uv))?;
        let (from, to) = (cut(inside, from), cut(inside, to));
        (from != to).then_some((from, to))
    }

    /// The coordinate of the place on a cell's border that is nearest to `uv`.
    pub fn along(&self, cell: &LatticeCell, uv: [f64; 2]) -> f64 {
        let mut best = (f64::INFINITY, 0.0);
        for (k, part) in cell.parts().iter().enumerate() {
            let t = part.parameter(cell.inside, uv);
            let [u, v] = self.place(cell, part, t);
            let (x, y) = (u - uv[0], v - uv[1]);
            let distance = x * x + y * y;
            if distance < best.0 {
                best = (distance, k as f64 + t);
            }
        }
        best.1
    }

    /// The place on a part of a cell's border.
    pub fn place(&self, cell: &LatticeCell, part: &Part, t: f64) -> [f64; 2] {
        if t <= 0.0 {
            return part.from;
        }
        if t >= 1.0 {
            return part.to;
        }
        let chord = [0, 1].map(|k| part.from[k] + t * (part.to[k] - part.from[k]));
        if part.side != RIM {
            return chord;
        }
        self.last_valid((cell.face, cell.limit), [cell.inside, chord], 16.0)
    }
}

mod smallparts {
    //! Up to four parts.
    use super::Part;

    #[derive(Default)]
    pub struct Parts([Part; 4], usize);

    impl Parts {
        pub fn slice(&mut self) -> &[Part] {
            &self.0[..self.1]
        }
    }

    impl FromIterator<Part> for Parts {
        fn from_iter<I: IntoIterator<Item = Part>>(parts: I) -> Self {
            let mut all = Parts::default();
            for part in parts.into_iter().take(4) {
                all.0[all.1] = part;
                all.1 += 1;
            }
            all
        }
    }
}

/// A part of a cell's border as a curve.
pub(super) struct Along<'l, 'a> {
    pub lattice: &'l Lattice<'a>,
    pub cell: &'l LatticeCell,
    pub part: Part,
}

impl Curve for Along<'_, '_> {
    fn at(&self, t: f64) -> Direction {
        self.lattice
            .decode(self.cell.face, self.lattice.place(self.cell, &self.part, t))
    }
}

impl Lattice<'_> {
    /// The cell that lies across a place of a cell's border, if any.
    pub fn across(&self, cell: &LatticeCell, part: &Part, t: f64) -> Option<Spot> {
        let (border, inside) = (
            self.decode(cell.face, self.place(cell, part, t)),
            self.decode(cell.face, cell.inside),
        );
        let beyond = [0, 1, 2].map(|k| border[k] + 1e-6 * (border[k] - inside[k]));
        self.locate(normalized(beyond))
    }
}
