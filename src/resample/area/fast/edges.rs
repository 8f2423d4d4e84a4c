//! The borders of a target's cells as cubics in the source's plane.
//!
//! In a block of cells an edge follows from six corners in a line, of which it joins the third and the fourth: one corner a cell is
//! taken into the source, and neighbors share what is between them. Its bend is chosen so that the area beside the
//! chord is right to the fifth difference; the fifth itself says how far off it may be. Near a seam or where the
//! corners are too far apart for that, a cell's border is halved and quartered on its own.

use crate::geometry::axes::Rotation;
use crate::kernel;
use crate::kernel::SimdWork;
use crate::kernel::tile::{TILE, Tile, Tuples};
use crate::map::verbs::{ContinuedCanonical, EncodeTile};
use crate::resample::area::fast::lanes::{LANES, load};
use crate::resample::area::lattice::Lattice;
use crate::resample::area::traced::arc::PlanePoint;
use fearless_simd::{Select, Simd, SimdBase, f64x8};

/// The area by which a border may be wrong, in source cells or in target cells, whichever are smaller.
pub(in crate::resample::area) const FINE: f64 = 5e-8;

/// How much of what lies between an edge and its cubic, here on one side and there on the other, counts as area: it moves
/// the shares of source cells whose sides lie along the edge, and there only.
const SLIVER: f64 = 0.5;

/// The largest distance of a quartic from the cubic with the same area, beside its fourth difference.
const QUARTIC: f64 = 6e-4;

/// The next term of the area, beside the fifth difference.
const QUINTIC: f64 = 0.0032;

/// Places in the source: columns, rows and faces.
#[derive(Default)]
pub(in crate::resample::area) struct Places {
    pub rows: [Vec<f64>; 3],
    input: Vec<[f64; 3]>,
    directions: Vec<[f64; 3]>,
}

impl Places {
    pub fn clear(&mut self) {
        self.input.clear();
    }

    pub fn push(&mut self, uv: [f64; 3]) {
        self.input.push(uv);
    }

    /// Takes all (u, v, face) of one image into the other.
    pub fn take(&mut self, from: &Lattice<'_>, into: &Lattice<'_>) {
        let turn = Rotation::Matrix(into.turn().unwrap_or([
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
        ]));
        self.directions.resize(self.input.len(), [0.0; 3]);
        into.map.visit_canonical(ContinuedCanonical {
            input: self.input.as_flattened(),
            output: self.directions.as_flattened_mut(),
        });
        let scales = [from.scale(0), from.scale(1)];
        for row in &mut self.rows {
            // Eight may be read from the last row's end on.
            row.resize((self.input.len() + 8 * LANES).next_multiple_of(TILE), 0.0);
        }
        let mut uv = Tile::new();
        for (k, directions) in self.directions.chunks(TILE).enumerate() {
            from.map.visit_canonical(EncodeTile {
                turn,
                input: Tuples::Interleaved(directions),
                output: &mut uv,
            });
            for (axis, row) in self.rows.iter_mut().enumerate() {
                let row = &mut row[k * TILE..][..TILE];
                let (scale, offset) = *scales.get(axis).unwrap_or(&(1.0, 0.0));
                for (to, from) in row.iter_mut().zip(&uv.0[axis]) {
                    *to = from * scale + offset;
                }
            }
        }
    }

    pub fn face(&self, k: usize) -> f64 {
        self.rows[2][k]
    }

    pub fn at(&self, k: usize) -> PlanePoint {
        [self.rows[0][k], self.rows[1][k]]
    }
}

/// Edges side by side, as [`super::arc::Arc`]s.
#[derive(Default)]
pub(in crate::resample::area) struct Edges {
    rows: [Vec<f64>; 8],
    /// The area by which each may be wrong; NaN where it is none.
    pub wrong: Vec<f64>,
}

impl Edges {
    pub fn clear(&mut self) {
        self.rows.iter_mut().for_each(Vec::clear);
        self.wrong.clear();
    }

    /// Adds the edges from places `first`, `first` + 1 and so on to those `step` further, a row of them; some more to fill up
    /// mean nothing.
    pub fn push(&mut self, places: &Places, first: usize, step: usize, count: usize) {
        let count = Self::stride(count);
        let start = self.wrong.len();
        self.rows
            .iter_mut()
            .for_each(|row| row.resize(start + count, 0.0));
        self.wrong.resize(start + count, 0.0);
        kernel::run_simd(ThroughSix {
            places: [0, 1, 2].map(|axis| &places.rows[axis][..]),
            first,
            step,
            rows: self.rows.each_mut().map(|row| &mut row[start..]),
            wrong: &mut self.wrong[start..],
        });
    }

    /// How many are in a row of so many.
    pub fn stride(count: usize) -> usize {
        count.next_multiple_of(LANES)
    }

    /// Room for reading a few beyond the last.
    pub fn pad(&mut self) {
        let count = self.wrong.len() + LANES;
        self.rows.iter_mut().for_each(|row| row.resize(count, 0.0));
        self.wrong.resize(count, f64::NAN);
    }

    /// A row for each number of the cubics: from, along, bend and twist, columns before rows.
    #[inline(always)]
    pub fn rows(&self) -> &[Vec<f64>; 8] {
        &self.rows
    }

    /// Sets one of them.
    pub fn set(&mut self, k: usize, numbers: [f64; 8]) {
        for (row, number) in self.rows.iter_mut().zip(numbers) {
            row[k] = number;
        }
    }

    /// As many as this, which mean nothing yet.
    pub fn resize(&mut self, count: usize) {
        self.rows.iter_mut().for_each(|row| row.resize(count, 0.0));
    }
}

/// What a block's cells are, from its places and edges, row by row like [`Edges`] of as many columns.
#[derive(Default)]
pub(in crate::resample::area) struct Outlines {
    /// What each covers in the source's plane, by its corners; NaN where they lie on several faces, or on none.
    pub areas: Vec<f64>,
    /// The area by which it may be wrong, NaN where that is not known.
    pub wrong: Vec<f64>,
}

impl Outlines {
    /// The cells of a block of `columns` × `rows`, the first corner at place `first`, rows of places `width` apart.
    pub fn compute(
        &mut self,
        places: &Places,
        [first, width]: [usize; 2],
        [across, down]: [&Edges; 2],
        [columns, rows]: [usize; 2],
    ) {
        let count = rows * Edges::stride(columns);
        self.areas.resize(count, 0.0);
        self.wrong.resize(count, 0.0);
        kernel::run_simd(Outline {
            outlines: self,
            places,
            first,
            width,
            across: &across.wrong,
            down: &down.wrong,
            columns,
            rows,
        });
    }
}

struct Outline<'a> {
    outlines: &'a mut Outlines,
    places: &'a Places,
    first: usize,
    width: usize,
    across: &'a [f64],
    down: &'a [f64],
    columns: usize,
    rows: usize,
}

impl SimdWork for Outline<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let [stride, down_stride] = [self.columns, self.columns + 1].map(Edges::stride);
        let (zero, half) = (f64x8::splat(simd, 0.0), f64x8::splat(simd, 0.5));
        let [xs, ys, faces] = [0, 1, 2].map(|axis| &self.places.rows[axis][..]);
        for row in 0..self.rows {
            for column in (0..self.columns).step_by(LANES) {
                let k = self.first + row * self.width + column;
                let [a, b, c, d] = [k, k + 1, k + self.width + 1, k + self.width];
                let across = load(simd, xs, c) - load(simd, xs, a);
                let along = load(simd, xs, d) - load(simd, xs, b);
                let down = load(simd, ys, c) - load(simd, ys, a);
                let up = load(simd, ys, d) - load(simd, ys, b);
                let area = half * (across * up - down * along);
                let face = load(simd, faces, a);
                let strange = (load(simd, faces, b) - face).abs()
                    + (load(simd, faces, c) - face).abs()
                    + (load(simd, faces, d) - face).abs();
                let to = row * stride + column;
                let left = row * down_stride + column;
                let wrong = load(simd, self.across, to)
                    + load(simd, self.across, to + stride)
                    + load(simd, self.down, left)
                    + load(simd, self.down, left + 1);
                let area = strange
                    .simd_eq(zero)
                    .select(area, f64x8::splat(simd, f64::NAN));
                area.store_slice(&mut self.outlines.areas[to..][..LANES]);
                wrong.store_slice(&mut self.outlines.wrong[to..][..LANES]);
            }
        }
    }
}

/// Edges through six places each.
struct ThroughSix<'a> {
    places: [&'a [f64]; 3],
    first: usize,
    step: usize,
    rows: [&'a mut [f64]; 8],
    wrong: &'a mut [f64],
}

impl SimdWork for ThroughSix<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let ThroughSix {
            places,
            first,
            step,
            rows,
            wrong,
        } = self;
        let zero = f64x8::splat(simd, 0.0);
        let [
            from_x,
            from_y,
            along_x,
            along_y,
            bend_x,
            bend_y,
            twist_x,
            twist_y,
        ] = rows.map(|row| row.as_chunks_mut::<LANES>().0);
        for (k, wrong) in wrong.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
            let start = first - 2 * step + k * LANES;
            let q = six(simd, places[0], start, step);
            let r = six(simd, places[1], start, step);
            let f = six(simd, places[2], start, step);
            let (x, y) = (Line::through(simd, &q), Line::through(simd, &r));
            let mut strange = zero;
            for other in &f[1..] {
                strange += (*other - f[0]).abs();
            }
            q[2].store_array(&mut from_x[k]);
            r[2].store_array(&mut from_y[k]);
            x.along.store_array(&mut along_x[k]);
            y.along.store_array(&mut along_y[k]);
            x.bend.store_array(&mut bend_x[k]);
            y.bend.store_array(&mut bend_y[k]);
            x.twist.store_array(&mut twist_x[k]);
            y.twist.store_array(&mut twist_y[k]);
            let area = x.fifth.abs() * y.along.abs() + y.fifth.abs() * x.along.abs();
            let far = (x.fourth.abs() + y.fourth.abs()) * (x.along.abs() + y.along.abs());
            let by =
                f64x8::splat(simd, QUINTIC) * area + f64x8::splat(simd, SLIVER * QUARTIC) * far;
            strange
                .simd_eq(zero)
                .select(by, f64x8::splat(simd, f64::NAN))
                .store_array(wrong);
        }
    }
}

/// Eight numbers of a row from each of six places on, a step apart.
#[inline(always)]
fn six<S: Simd>(simd: S, row: &[f64], first: usize, step: usize) -> [f64x8<S>; 6] {
    [
        load(simd, row, first),
        load(simd, row, first + step),
        load(simd, row, first + 2 * step),
        load(simd, row, first + 3 * step),
        load(simd, row, first + 4 * step),
        load(simd, row, first + 5 * step),
    ]
}

/// One coordinate of eight edges.
struct Line<S: Simd> {
    along: f64x8<S>,
    bend: f64x8<S>,
    twist: f64x8<S>,
    fourth: f64x8<S>,
    fifth: f64x8<S>,
}

impl<S: Simd> Line<S> {
    /// The third to the fourth of six places (Bessel's interpolation).
    #[inline(always)]
    fn through(simd: S, q: &[f64x8<S>; 6]) -> Self {
        let number = |x| f64x8::splat(simd, x);
        let second = |k: usize| (q[k - 1] - q[k]) + (q[k + 1] - q[k]);
        let (a, b, c, d) = (second(1), second(2), second(3), second(4));
        let (before, after) = ((a - b) + (c - b), (b - c) + (d - c));
        let fourth = number(0.5) * (before + after);
        Line {
            along: q[3] - q[2],
            // Six times the area, which is -1/12 of the second difference and 11/720 of the fourth.
            bend: fourth * number(11.0 / 120.0) - number(0.25) * (b + c),
            twist: (c - b) * number(1.0 / 12.0),
            fourth,
            fifth: after - before,
        }
    }
}

/// One coordinate of an edge on its own.
struct Single {
    along: f64,
    bend: f64,
    twist: f64,
    fourth: f64,
}

impl Single {
    /// The first to the last of five places a quarter apart (Boole's rule for the area).
    #[inline(always)]
    fn through(q: [f64; 5]) -> Single {
        let along = q[4] - q[0];
        let off = [1, 2, 3].map(|k| q[k] - q[0] - 0.25 * k as f64 * along);
        Single {
            along,
            bend: (32.0 * (off[0] + off[2]) + 12.0 * off[1]) * (1.0 / 15.0),
            twist: (off[0] - off[2]) * (16.0 / 3.0),
            // 4⁴: as of places a whole edge apart.
            fourth: 256.0 * (q[0] - 4.0 * q[1] + 6.0 * q[2] - 4.0 * q[3] + q[4]),
        }
    }
}

/// What became of an edge on its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::resample::area) enum Found {
    Smooth,
    /// Not yet, but it may be in so many parts.
    Rough(usize),
    /// It crosses a seam.
    Torn,
}

/// Sets an edge from five places in a row, a quarter of it apart, from `first` on. `fine` is the area that it may
/// be wrong by, in a plane of so many columns and rows.
pub(in crate::resample::area) fn on_its_own(
    places: &Places,
    first: usize,
    fine: f64,
    limits: [usize; 2],
    edges: &mut Edges,
    number: usize,
) -> Found {
    let five = |axis: usize| -> [f64; 5] { std::array::from_fn(|k| places.rows[axis][first + k]) };
    let [x, y] = [five(0), five(1)].map(Single::through);
    let length = x.along.abs() + y.along.abs();
    let wrong = SLIVER * QUARTIC * (x.fourth.abs() + y.fourth.abs()) * length;
    // NaN is where the source holds nothing; half a face is from one side of it to the other.
    let torn = wrong.is_nan()
        || 2.0 * x.along.abs() > limits[0] as f64
        || 2.0 * y.along.abs() > limits[1] as f64
        || five(2).iter().any(|face| *face != places.face(first));
    if torn {
        return Found::Torn;
    }
    if wrong > fine {
        // It falls with the fifth power of the length, and there are as many more of them.
        return Found::Rough((wrong / fine).sqrt().sqrt().ceil() as usize);
    }
    let [from_x, from_y] = places.at(first);
    let cubic = [
        from_x, from_y, x.along, y.along, x.bend, y.bend, x.twist, y.twist,
    ];
    edges.set(number, cubic);
    Found::Smooth
}
