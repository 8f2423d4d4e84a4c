//! The shares of eight cells at once, one in each lane.
//!
//! A cell's border is a loop of cubics in the source's plane, as in [`super::arc`], and the sums are the same: by Green's
//! theorem each part of an edge in a source cell adds ∫ x dy there and its height to the cells on its left. But nothing
//! is followed from crossing to crossing. A window of source cells that holds all eight borders is fixed; where each edge
//! meets the lines of the window is computed for all lines, and then each cell of the window takes what lies
//! between its lines, which for most is nothing. So there is the same work in all lanes and hardly a branch.
//!
//! Where an edge meets a line between columns need not be exact: on the line the sums on both sides agree, so that an error ε moves
//! ε²/2 of a cell. Between rows it moves ε of a cell from one to the other, which no sum of all shows. The chord's crossing corrected
//! once leaves 1e-5 there, twice 1e-7, but for edges that bend as much as they go on.
//!
//! What did not help: cutting chords instead of cubics, with what lies between added in the middle. It is as
//! conservative among themselves, but beside a cell that is followed exactly a ten-thousandth is lost or there twice.

use crate::kernel;
use crate::kernel::SimdWork;
use crate::resample::area::fast::edges::Edges;
use crate::resample::area::fast::lanes::{Lanes, load};
use crate::resample::area::fast::plane::Plane;
use crate::resample::area::lattice::NOTHING;
use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f64x8, mask64x8};

/// An edge of each cell: eight neighbors from `first` on among those of a list, and +1 or -1 for the way that they are
/// passed.
#[derive(Clone, Copy, Debug)]
pub(in crate::resample::area) struct Passed {
    pub list: usize,
    pub first: usize,
    pub sense: f64,
}

/// Source cells along a side of a window, at most.
const WIDEST: usize = 160;

/// Bends beside the way along from which on crossings are solved for.
const BENT: f64 = 0.05;

/// What a cell of the window has N of: ∫ of 1 over what lies in it and across each cell on its left, of Y over both, of Y² - 1/12
/// over both where that counts, and over what lies in it of X, then of XY and X² - 1/12. X and Y are from its center.
type Sums<const N: usize> = [Lanes; N];

/// A part of the way along an edge: from and to.
type Part = [Lanes; 2];

/// What comes out, and room for the way there.
pub(in crate::resample::area) struct Eight {
    sums: Vec<Lanes>,
    /// Between which places an edge is in each column and in each row of the window.
    parts: [[Part; WIDEST]; 2],
    /// Cells of the window that an edge comes to: columns and rows.
    met: Vec<[u32; 2]>,
    /// Columns and rows of the window.
    pub window: [usize; 2],
    /// Each lane's first column and row.
    pub base: [Lanes; 2],
    /// For each cell of the window, row by row, how much of it the lanes hold.
    pub weights: Vec<Lanes>,
    /// And in which lanes that is more than next to nothing: a bit each.
    pub enough: Vec<u8>,
    /// The sum of all weights, of those that were left out as well.
    pub total: Lanes,
    /// The most negative one.
    pub least: Lanes,
}

impl Default for Eight {
    fn default() -> Self {
        Eight {
            sums: Vec::new(),
            parts: [[Part::default(); WIDEST]; 2],
            met: Vec::new(),
            window: [0; 2],
            base: Default::default(),
            weights: Vec::new(),
            enough: Vec::new(),
            total: Lanes::default(),
            least: Lanes::default(),
        }
    }
}

/// Eight cells of a target and the plane of the source that they lie in.
pub(in crate::resample::area) struct Cells<'a> {
    /// Their borders.
    pub edges: &'a [Passed],
    pub lists: [&'a Edges; 3],
    /// Which lanes have a cell: a bit each.
    pub used: u32,
    /// +1 or -1 for the sense in which the edges go around.
    pub sense: f64,
    /// Their solid angles.
    pub sizes: &'a Lanes,
    /// Columns and rows of the plane.
    pub limits: [usize; 2],
    pub plane: &'a Plane,
}

impl Eight {
    /// Finds the shares of eight cells. False where the window would be too large.
    pub fn run(&mut self, cells: &Cells<'_>) -> bool {
        self.window = [0; 2];
        kernel::run_simd(Work { eight: self, cells });
        self.window[0] > 0
    }

    /// The first column and row of a lane's window.
    #[inline(always)]
    pub fn first(&self, lane: usize) -> [usize; 2] {
        [0, 1].map(|k| self.base[k].0[lane] as i32 as usize)
    }
}

struct Work<'w, 'a> {
    eight: &'w mut Eight,
    cells: &'w Cells<'a>,
}

/// One coordinate of an edge.
#[derive(Clone, Copy)]
struct Cubic<S: Simd> {
    from: f64x8<S>,
    along: f64x8<S>,
    bend: f64x8<S>,
    twist: f64x8<S>,
    /// Factors of t, t², t³.
    powers: [f64x8<S>; 3],
    /// Whether in some lane it turns back or nearly so.
    bent: bool,
}

impl<S: Simd> Cubic<S> {
    #[inline(always)]
    fn new(simd: S, cells: &Cells<'_>, edge: &Passed, axis: usize, base: f64x8<S>) -> Self {
        let number = |x| f64x8::splat(simd, x);
        let [from, along, bend, twist] = numbers(simd, cells, edge, axis);
        let bends = bend.abs() + twist.abs();
        Cubic {
            from: from - base,
            along,
            bend,
            twist,
            powers: [
                along + bend + twist,
                number(0.0) - bend - number(3.0) * twist,
                twist + twist,
            ],
            bent: bends.simd_gt(number(BENT) * along.abs()).any_true(),
        }
    }

    #[inline(always)]
    fn at(&self, t: f64x8<S>) -> f64x8<S> {
        let [a, b, c] = self.powers;
        self.from + t * (a + t * (b + t * c))
    }

    #[inline(always)]
    fn slope(&self, simd: S, t: f64x8<S>) -> f64x8<S> {
        let [a, b, c] = self.powers;
        a + t * (b + b + t * (f64x8::splat(simd, 3.0) * c))
    }

    /// Where it turns back, else 1.
    #[inline(always)]
    fn turn(&self, simd: S) -> f64x8<S> {
        let number = |x| f64x8::splat(simd, x);
        let (half, one) = (number(0.5), number(1.0));
        let mut turn = half + half * self.along / self.bend;
        // For the twist.
        let [_, b, c] = self.powers;
        for _ in 0..2 {
            let step = self.slope(simd, turn) / (b + b + number(6.0) * c * turn);
            turn = step.abs().simd_lt(number(0.1)).select(turn - step, turn);
        }
        let turn = turn.max(number(0.0)).min(one);
        (self.bend.abs().simd_gt(self.along.abs())).select(turn, one)
    }

    /// Which parts of the way from `start` to `end`, where it does not turn back, are between one line and the next.
    #[inline(always)]
    fn between(&self, simd: S, [start, end]: [f64x8<S>; 2], parts: &mut [Part]) {
        let number = |x| f64x8::splat(simd, x);
        let (zero, one) = (number(0.0), number(1.0));
        let (a, b) = if self.bent {
            (self.at(start), self.at(end))
        } else {
            (self.from, self.from + self.along)
        };
        let up = b.simd_ge(a);
        let (first, last) = (up.select(start, end), up.select(end, start));
        let (low, high) = (a.min(b), a.max(b));
        // Where nothing moves along this axis, any place is as good.
        let inverse = one / self.along.simd_eq(zero).select(one, self.along);
        let mut before = first;
        let count = parts.len();
        for (k, part) in parts.iter_mut().enumerate() {
            let mut t = last;
            if k + 1 < count {
                let line = number((k + 1) as f64);
                let met = if self.bent {
                    self.solve(simd, line, up)
                } else {
                    let t = ((line - self.from) * inverse).max(zero).min(one);
                    let (s, skew) = (one - t, one - t - t);
                    let off = t * s * (self.bend + skew * self.twist);
                    let more = skew * self.bend + (one - number(6.0) * t * s) * self.twist;
                    let step = inverse * (one - more * inverse);
                    let t = t - off * step;
                    t - (self.at(t) - line) * step
                };
                let far = line.simd_ge(high).select(last, met.max(start).min(end));
                t = line.simd_le(low).select(first, far);
            }
            before.min(t).store_array(&mut part[0].0);
            before.max(t).store_array(&mut part[1].0);
            before = t;
        }
    }

    /// Where a part that does not turn back meets a line; anything where it does not.
    #[inline(always)]
    fn solve(&self, simd: S, line: f64x8<S>, up: mask64x8<S>) -> f64x8<S> {
        let number = |x| f64x8::splat(simd, x);
        let (zero, one) = (number(0.0), number(1.0));
        let sign = up.select(one, number(-1.0));
        let [_, b, c] = self.powers;
        // Parabolas that touch it: beside a turning point a step along the tangent goes astray, and a parabola through
        // the ends with the bend that the twist leaves there comes closer by a factor of five a step only.
        let start = sign * (self.from - line);
        let mut t = passes(
            simd,
            start,
            sign * (self.along + self.bend),
            zero - sign * self.bend,
        );
        for _ in 0..2 {
            t = t.max(zero).min(one);
            t += passes(
                simd,
                sign * (self.at(t) - line),
                sign * self.slope(simd, t),
                sign * (b + number(3.0) * c * t),
            );
        }
        t.max(zero).min(one)
    }
}

/// Where a + b t + c t² passes zero on its way up. No closure: that would be a call, and so would each of its operations.
#[inline(always)]
fn passes<S: Simd>(simd: S, a: f64x8<S>, b: f64x8<S>, c: f64x8<S>) -> f64x8<S> {
    let number = |x| f64x8::splat(simd, x);
    let root = (b * b - number(4.0) * a * c).max(number(0.0)).sqrt();
    let near = number(0.0) - (a + a) / (b + root);
    let far = number(0.5) * (root - b) / c;
    b.simd_ge(number(0.0)).select(near, far)
}

/// From, along, bend and twist of an edge; 0 in lanes without a cell.
#[inline(always)]
fn numbers<S: Simd>(simd: S, cells: &Cells<'_>, edge: &Passed, axis: usize) -> [f64x8<S>; 4] {
    let used = mask64x8::from_bitmask(simd, u64::from(cells.used));
    let rows = cells.lists[edge.list].rows();
    // `map` would be a call.
    [
        number(simd, used, &rows[axis], edge.first),
        number(simd, used, &rows[2 + axis], edge.first),
        number(simd, used, &rows[4 + axis], edge.first),
        number(simd, used, &rows[6 + axis], edge.first),
    ]
}

#[inline(always)]
fn number<S: Simd>(simd: S, used: mask64x8<S>, row: &[f64], first: usize) -> f64x8<S> {
    used.select(load(simd, row, first), f64x8::splat(simd, 0.0))
}

impl SimdWork for Work<'_, '_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Work { eight, cells } = self;
        match (cells.plane.varies(), cells.plane.bends) {
            ([false, false], _) => shares::<S, 2>(simd, eight, cells),
            ([false, true], false) => shares::<S, 4>(simd, eight, cells),
            ([false, true], true) => shares::<S, 6>(simd, eight, cells),
            (_, false) => shares::<S, 5>(simd, eight, cells),
            (_, true) => shares::<S, 9>(simd, eight, cells),
        }
    }
}

/// Whether N sums hold those of a density that varies along v, along u and along v, and that bends.
const fn counted(sums: usize) -> [bool; 3] {
    [sums > 2, sums == 5 || sums == 9, sums == 6 || sums == 9]
}

/// The shares, by N sums: 2 where the density is constant, 4 where it varies along v, 5 where along u as well, and 6 and 9 where it
/// bends too. So no moment is computed that counts for nothing.
#[inline(always)]
fn shares<S: Simd, const N: usize>(simd: S, eight: &mut Eight, cells: &Cells<'_>) {
    let number = |x| f64x8::splat(simd, x);
    let zero = number(0.0);
    let mut base = [zero; 2];
    let mut window = [0; 2];
    for axis in [0, 1] {
        let (mut low, mut high) = (number(f64::INFINITY), number(f64::NEG_INFINITY));
        for edge in cells.edges {
            let [from, along, bend, twist] = numbers(simd, cells, edge, axis);
            let to = from + along;
            // How far beyond its ends an edge that turns back may come.
            let more = (bend.abs() + twist.abs() - along.abs()).max(zero) * number(0.25);
            low = low.min(from.min(to) - more);
            high = high.max(from.max(to) + more);
        }
        let last = number((cells.limits[axis] - 1) as f64);
        base[axis] = low.floor().max(zero).min(last);
        let top = high.floor().max(zero).min(last);
        window[axis] = (top - base[axis]).reduce_max() as usize + 1;
        base[axis].store_array(&mut eight.base[axis].0);
    }
    if window[0].max(window[1]) > WIDEST {
        return;
    }
    eight.window = window;
    let [columns, rows] = window;
    eight.sums.clear();
    eight.sums.resize(columns * rows * N, Lanes::default());
    eight.met.resize(columns * rows, [0; 2]);
    for edge in cells.edges {
        let x = Cubic::new(simd, cells, edge, 0, base[0]);
        let y = Cubic::new(simd, cells, edge, 1, base[1]);
        let (one, sense) = (number(1.0), number(edge.sense));
        let mut cuts = [zero, one, one, one];
        if x.bent | y.bent {
            let (p, q) = (x.turn(simd), y.turn(simd));
            cuts[1] = p.min(q);
            cuts[2] = p.max(q);
        }
        for k in 0..3 {
            let span = [cuts[k], cuts[k + 1]];
            if !span[1].simd_gt(span[0]).any_true() {
                continue;
            }
            let [across, down] = &mut eight.parts;
            x.between(simd, span, &mut across[..columns]);
            y.between(simd, span, &mut down[..rows]);
            // Which cells any edge comes to is settled first: a loop without branches, and then one without doubts.
            let mut count = 0;
            for (row, part) in down[..rows].iter().enumerate() {
                let in_row = [part[0].load(simd), part[1].load(simd)];
                if !in_row[1].simd_gt(in_row[0]).any_true() {
                    continue;
                }
                for (column, part) in across[..columns].iter().enumerate() {
                    let start = in_row[0].max(part[0].load(simd));
                    let end = in_row[1].min(part[1].load(simd));
                    eight.met[count] = [column as u32, row as u32];
                    count += usize::from(end.simd_gt(start).any_true());
                }
            }
            for &[column, row] in &eight.met[..count] {
                let middles = [f64::from(column), f64::from(row) + 0.5];
                let (column, row) = (column as usize, row as usize);
                let (p, q) = (&across[column], &down[row]);
                let start = p[0].load(simd).max(q[0].load(simd));
                let length = (p[1].load(simd).min(q[1].load(simd)) - start).max(zero);
                let sums = &mut eight.sums.as_chunks_mut::<N>().0[row * columns + column];
                piece(simd, [&x, &y], middles, sense, [start, length], sums);
            }
        }
    }
    weigh::<S, N>(simd, eight, cells);
}

/// Adds what the part of an edge from `start` on, so long, does to a cell whose left side and middle row are there.
#[inline(always)]
fn piece<S: Simd, const N: usize>(
    simd: S,
    [x, y]: [&Cubic<S>; 2],
    [left, middle]: [f64; 2],
    sense: f64x8<S>,
    [start, length]: [f64x8<S>; 2],
    sums: &mut Sums<N>,
) {
    // Two places of Gauss, which are exact for the area of a parabola.
    const FIRST: f64 = 0.211_324_865_405_187_1;
    let number = |x| f64x8::splat(simd, x);
    let (left, middle, one, half) = (number(left), number(middle), number(1.0), number(0.5));
    let weight = half * length * sense;
    let zero = number(0.0);
    let [down_counts, along_counts, bends] = const { counted(N) };
    let twelfth = number(1.0 / 12.0);
    let [mut area, mut height, mut down, mut higher, mut along] = [zero; 5];
    let [mut bend_down, mut bend_higher, mut both, mut bend_along] = [zero; 4];
    for place in [FIRST, 1.0 - FIRST] {
        let t = start + number(place) * length;
        let p = x.at(t) - left;
        let w = weight * y.slope(simd, t);
        let a = w * p;
        area += a;
        height += w;
        let q = y.at(t) - middle;
        if down_counts {
            down += a * q;
            higher += w * q;
        }
        if down_counts && bends {
            let bend = q * q - twelfth;
            bend_down += a * bend;
            bend_higher += w * bend;
        }
        if along_counts {
            let a = a * (p - one);
            along += a;
            if bends {
                both += a * q;
                bend_along += a * (p + p - one);
            }
        }
    }
    let along = half * along;
    let all = if bends {
        let bend_along = number(1.0 / 6.0) * bend_along;
        [
            area,
            height,
            down,
            higher,
            bend_down,
            bend_higher,
            along,
            half * both,
            bend_along,
        ]
    } else {
        [area, height, down, higher, along, zero, zero, zero, zero]
    };
    for (sum, more) in sums.iter_mut().zip(all) {
        (sum.load(simd) + more).store_array(&mut sum.0);
    }
}

/// The weights that come of the sums.
#[inline(always)]
fn weigh<S: Simd, const N: usize>(simd: S, eight: &mut Eight, cells: &Cells<'_>) {
    let [down_counts, along_counts, bends] = const { counted(N) };
    let zero = f64x8::splat(simd, 0.0);
    let [columns, rows] = eight.window;
    let (sense, sizes) = (f64x8::splat(simd, cells.sense), cells.sizes.load(simd));
    let nothing = f64x8::splat(simd, NOTHING);
    let (mut total, mut least) = (zero, zero);
    eight.weights.clear();
    eight.weights.resize(columns * rows, Lanes::default());
    eight.enough.clear();
    eight.enough.resize(columns * rows, 0);
    let mut spread = [Lanes::default(); 6];
    let known = if bends { 6 } else { 3 };
    for row in 0..rows {
        let [mut height, mut higher, mut bend_higher] = [zero; 3];
        for column in (0..columns).rev() {
            if column + 1 == columns || along_counts {
                cells.plane.read(
                    &eight.base,
                    [column, row],
                    cells.limits,
                    &mut spread[..known],
                );
            }
            let whole = spread[0].load(simd);
            let (along, down) = (spread[1].load(simd), spread[2].load(simd));
            let mut sums = [zero; N];
            let stored = &eight.sums.as_chunks::<N>().0[row * columns + column];
            for (sum, stored) in sums.iter_mut().zip(stored) {
                *sum = stored.load(simd);
            }
            let mut weight = whole * (sums[0] + height);
            if down_counts {
                weight += down * (sums[2] + higher);
                higher += sums[3];
            }
            if down_counts && bends {
                weight += spread[5].load(simd) * (sums[4] + bend_higher);
                bend_higher += sums[5];
            }
            if along_counts {
                weight += along * sums[if bends { 6 } else { 4 }];
            }
            if along_counts && bends {
                weight += spread[4].load(simd) * sums[7];
                weight += spread[3].load(simd) * sums[8];
            }
            weight = sense * weight;
            height += sums[1];
            total += weight;
            least = least.min(weight);
            let k = row * columns + column;
            weight.store_array(&mut eight.weights[k].0);
            eight.enough[k] = weight.simd_gt(nothing * sizes.min(whole)).to_bitmask() as u8;
        }
    }
    total.store_array(&mut eight.total.0);
    least.store_array(&mut eight.least.0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::raster::shape_of_size;
    use crate::map::Map;
    use crate::resample::area::fast::lanes::LANES;
    use crate::resample::area::lattice::Lattice;
    use crate::resample::area::traced::arc::{Arc, PlanePoint, differences};
    use crate::resample::area::traced::density::Density;
    use crate::resample::area::traced::shares::Shares;
    use proptest::prelude::*;

    /// A wobbly loop: the corners of a quad and how far its sides bend and twist.
    fn places(seed: [f64; 24], middle: PlanePoint, size: f64) -> [[PlanePoint; 5]; 4] {
        let corner = |k: usize| -> PlanePoint {
            let (x, y) = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)][k % 4];
            let off = [seed[2 * (k % 4)], seed[2 * (k % 4) + 1]];
            [
                middle[0] + size * (x + 0.2 * off[0]),
                middle[1] + size * (y + 0.2 * off[1]),
            ]
        };
        [0, 1, 2, 3].map(|side| {
            let (a, b) = (corner(side), corner(side + 1));
            // From half a side before it to half a side behind.
            [-0.5, 0.0, 0.5, 1.0, 1.5].map(|t: f64| {
                [0, 1].map(|k| {
                    let bend = 0.2 * size * seed[8 + 4 * side + k];
                    // As much beside the bend as edges have that pass for smooth.
                    let twist = 0.001 * size * seed[10 + 4 * side + k];
                    a[k] + t * (b[k] - a[k]) + t * (1.0 - t) * (bend + (1.0 - 2.0 * t) * twist)
                })
            })
        })
    }

    fn are_as_one_by_one(
        seeds: [[f64; 24]; LANES],
        center: [f64; 2],
        size: f64,
        (name, n): (&str, usize),
    ) -> Result<(), TestCaseError> {
        let map = Map::new(name).unwrap();
        let lattice = Lattice::new(&map, &shape_of_size(&map, n), None).unwrap();
        let varies = Density::varies(&lattice);
        let mut plane = Plane::default();
        let low = center.map(|x| x as usize - 40);
        prop_assert!(plane.hold(&lattice, varies, 0, low, low.map(|k| k + 80)));
        let mut edges = Edges::default();
        edges.resize(4 * LANES);
        let mut density = Density::new(&lattice, varies);
        let mut want = Vec::new();
        for (lane, seed) in seeds.into_iter().enumerate() {
            let middle = center.map(|x| x + 0.3 * lane as f64);
            let mut pieces = Vec::new();
            for (side, q) in places(seed, middle, size).into_iter().enumerate() {
                let third = differences(q).0;
                let arc = Arc::through([q[1], q[2], q[3]], third);
                arc.pieces([lattice.columns, lattice.rows], &mut pieces);
                edges.set(side * LANES + lane, arc.numbers());
            }
            let mut shares = Shares::default();
            shares.start();
            prop_assert!(shares.add(&lattice, &mut density, 0, &pieces, 1.0, 1.0));
            want.push(shares);
        }
        let passed = [0, 1, 2, 3].map(|side| Passed {
            list: 0,
            first: side * LANES,
            sense: 1.0,
        });
        let mut eight = Eight::default();
        let ones = Lanes([1.0; LANES]);
        let cells = Cells {
            edges: &passed,
            lists: [&edges; 3],
            used: 0xff,
            sense: 1.0,
            sizes: &ones,
            limits: [lattice.columns, lattice.rows],
            plane: &plane,
        };
        prop_assert!(eight.run(&cells));
        let own = plane.get(low.map(|k| k + 40)).unwrap();
        for (lane, want) in want.iter().enumerate() {
            // A line for the density instead of a quadratic, or of 256 cells the nearest quadratic instead of one through the middles of
            // sides: beside a cube's corner 1e-7 for each of X², XY and Y², and twice
            // that where two sides cut the same cell. Where a long side turns back beside a line, parts in 1e7 of its length.
            let bound = 6e-7 * own * (1.0 + size);
            let cut = 4.0;
            prop_assert!(
                (eight.total.0[lane] - want.total).abs() < cut * bound,
                "total {} {} {:e}",
                lane,
                want.total / own,
                (eight.total.0[lane] - want.total) / own
            );
            for &(index, weight) in &want.weights {
                let (row, column) = (index / lattice.columns, index % lattice.columns);
                let [x, y] = eight.first(lane);
                let got = eight.weights[(row - y) * eight.window[0] + column - x].0[lane];
                prop_assert!(
                    (got - weight).abs() < bound,
                    "{} {} {}",
                    lane,
                    got / own,
                    weight / own
                );
            }
        }
        Ok(())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(1000))]
        #[test]
        fn eight_at_once_are_as_one_by_one(
            seeds in prop::array::uniform8(prop::array::uniform24(-1.0..1.0)),
            center in prop::array::uniform2(60.0..960.0),
            size in prop::sample::select(vec![0.01, 0.3, 1.0, 1.7, 9.0]),
            name in prop::sample::select(vec!["cube", "latlong", "equal_area"]),
        ) {
            are_as_one_by_one(seeds, center, size, (name, 1024))?;
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(1000))]
        /// Where densities bend.
        #[test]
        fn eight_of_a_small_image_are_as_one_by_one(
            seeds in prop::array::uniform8(prop::array::uniform24(-1.0..1.0)),
            center in prop::array::uniform2(60.0..190.0),
            size in prop::sample::select(vec![0.01, 0.3, 1.0, 1.7, 9.0]),
            name in prop::sample::select(vec!["cube", "latlong", "equal_area"]),
        ) {
            are_as_one_by_one(seeds, center, size, (name, 256))?;
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]
        /// Where an edge is bent in any lane, crossings of all are solved for.
        #[test]
        fn eight_that_are_hardly_bent_are_as_one_by_one(
            seeds in prop::array::uniform8(prop::array::uniform24(-1.0..1.0)),
            center in prop::array::uniform2(60.0..960.0),
            size in prop::sample::select(vec![0.3, 1.0, 1.7, 9.0]),
            name in prop::sample::select(vec!["cube", "latlong", "equal_area"]),
        ) {
            let seeds = seeds.map(|seed| {
                std::array::from_fn(|k| if k < 8 { 0.1 * seed[k] } else { 0.2 * seed[k] })
            });
            are_as_one_by_one(seeds, center, size, (name, 1024))?;
        }
    }

    /// Twisted in the middle, where the slope of the twist is the other way around than at the ends.
    #[test]
    fn a_twisted_side_is_cut_at_the_line_between_rows() {
        let mut seeds = [[0.0; 24]; LANES];
        seeds[6][21] = -0.086_058_208_009_411_12;
        seeds[6][23] = 0.721_948_176_089_433;
        are_as_one_by_one(seeds, [60.0, 60.0], 1.7, ("cube", 1024)).unwrap();
    }

    /// A ten-thousandth of a texel behind the line that it crosses, a long side turns back.
    #[test]
    fn a_side_that_turns_back_on_a_line_is_cut_there() {
        let mut seeds = [[0.0; 24]; LANES];
        seeds[6][1] = -0.248_886_502_139_099_4;
        seeds[6][3] = -0.369_688_088_773_104_7;
        seeds[6][9] = 0.250_653_469_531_782;
        seeds[6][11] = -0.821_351_877_592_941_4;
        are_as_one_by_one(seeds, [60.0, 210.118_521_057_787_92], 9.0, ("cube", 1024)).unwrap();
    }

    #[test]
    fn a_window_may_be_too_large() {
        let map = Map::new("latlong").unwrap();
        let lattice = Lattice::new(&map, &[1024, 2048], None).unwrap();
        let mut plane = Plane::default();
        plane.hold(&lattice, [false, true], 0, [0, 0], [1, 1]);
        let mut edges = Edges::default();
        edges.resize(LANES);
        let line = Arc::line([10.0, 10.0], [10.0 + WIDEST as f64, 20.0]);
        edges.set(3, line.numbers());
        let ones = Lanes([1.0; LANES]);
        let cells = Cells {
            edges: &[Passed {
                list: 0,
                first: 0,
                sense: 1.0,
            }],
            lists: [&edges; 3],
            used: 1 << 3,
            sense: 1.0,
            sizes: &ones,
            limits: [2048, 1024],
            plane: &plane,
        };
        assert!(!Eight::default().run(&cells));
    }
}
