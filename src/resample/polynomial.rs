//! Where the texels of a block lie in another image, from where a few places of the block lie.
//!
//! Between two images whose formulas are smooth ([`Info::smooth`](crate::projections::projection::Info::smooth)) source coordinates
//! hardly bend within a block of texels. So they are computed at [`PLACES`] places only, in f64: at Chebyshev's points,
//! [`ALONG`] × [`DOWN`] of them, whose values a polynomial takes on, and at a few others, at which the polynomial is
//! compared with the formula. Texels take their coordinates from the polynomial, within 2⁻²³ of an image if they are f32
//! ([`TOLERANCE`], and the rounding of the result): nearer to the truth than a formula in f32, for a quarter of its time.
//!
//! What a polynomial cannot follow shows. A pole or a rim of the source spoils all of its block. The edge of a face, or a
//! seam, is no singular point of the formula of the face on one side: continued across it, coordinates leave the face.
//! So a block is refused where its places lie on different faces, and rows of it where the polynomial leaves
//! the face; these texels take the long way. Creases inside a face (an octahedron's edges) could hide between
//! the places, and formulas with such are not smooth. Where these are lines of an image that are known
//! ([`Info::creases`](crate::projections::projection::Info::creases)) a block serves whose texels lie on one side of each: in the
//! target by its corners, in the source by how far its places are from the line, for a block is no straight figure there.
//!
//! What did not help: a polynomial a row (eight times as many places for the same error), and polynomials in f32 (their
//! places are no better than the texels' own coordinates were).

use crate::image::raster::{Block, Raster};
use crate::kernel::tile::{TILE, Tile};
use crate::kernel::{Scalar, SimdWork, run_simd};
use crate::map::grid::GridAxis;
use crate::number::angle;
use crate::number::real::Real;
use crate::projections::projection::{Outline, Uv};
use crate::resample::coordinate_map::CoordinateMap;
use fearless_simd::{Simd, SimdBase, f64x8};

/// Columns and rows of a block, at most.
pub const BLOCK: (usize, usize) = (64, 32);

/// Texels in a row of a target that are looked at together.
pub const RUN: usize = 16;

/// Nodes of a row: two in each of its runs.
const NODES: usize = 2 * BLOCK.0 / RUN;

/// How far they lie from the middle of a run: a mean of both is that of a cubic polynomial over all of it (Gauss's quadrature, 8/√3).
pub const NODE: f64 = 4.618_802_153_517_006;

/// The first texels of the runs of a row of so many, [`RUN`] or more: the last ones may have texels in common.
pub fn runs(columns: usize) -> impl Iterator<Item = usize> {
    (0..columns)
        .step_by(RUN)
        .map(move |first| first.min(columns - RUN))
}

/// Which number of what is written at nodes is the left one of a run; the right one comes next.
pub fn node_of(row: usize, run: usize) -> usize {
    row * NODES + 2 * run
}

/// Points of the polynomial along a row.
const ALONG: usize = 8;

/// Its points down the rows.
const DOWN: usize = 7;

/// Places at which it is compared with the formula, each in the gap behind a point along and a point down: near the corners
/// and the middles of the sides, where a singular point outside of the block shows first.
const BETWEEN: [(usize, usize); 8] = [
    (0, 0),
    (6, 0),
    (0, 5),
    (6, 5),
    (3, 0),
    (2, 5),
    (0, 3),
    (6, 2),
];

/// All places at which the formula is computed: as many as a kernel takes at once.
const PLACES: usize = ALONG * DOWN + BETWEEN.len();
const _: () = assert!(PLACES.is_multiple_of(crate::kernel::tile::W));

/// How far the polynomial may be from the formula where they are compared, in images: 1/16000 of a texel of 8192. Between
/// the places it is farther, up to eight times in 170,000 maps turned at random, beside a pole.
const TOLERANCE: f64 = 1.0 / (1 << 27) as f64;

/// How far it may be as a share of how narrow texels of the target are in the source, where they are [`MANY`] texels of it or more: then
/// all are means, of which between the places a share of 1/500 is of texels beside what they see.
const SHARE: f64 = 1.0 / 4096.0;
const MANY: f64 = 2.0;

/// Cosines of multiples of π/7, and of π/6: where a polynomial errs least if its values are given there.
const POINTS_ALONG: [f64; ALONG] = {
    let [a, b, c] = [
        0.900_968_867_902_419_1,
        0.623_489_801_858_733_5,
        0.222_520_933_956_314_4,
    ];
    [-1.0, -a, -b, -c, c, b, a, 1.0]
};
const POINTS_DOWN: [f64; DOWN] = {
    let (a, b) = (0.866_025_403_784_438_6, 0.5);
    [-1.0, -a, -b, 0.0, b, a, 1.0]
};

/// By how much of p and q a block may reach over a crease: texels that end at one do so but for rounding, and a polynomial is off by
/// less than the tolerance there.
const BESIDE: f64 = 1e-12;

/// Of the polynomials that are 1 at one of N points and 0 at the others, the coefficients: a row for each point.
fn powers<const N: usize>(points: [f64; N]) -> [[f64; N]; N] {
    let mut powers = [[0.0; N]; N];
    for (i, (powers, own)) in powers.iter_mut().zip(points).enumerate() {
        powers[0] = 1.0;
        for (_, other) in points.into_iter().enumerate().filter(|&(j, _)| j != i) {
            for k in (0..N).rev() {
                let lower = if k > 0 { powers[k - 1] } else { 0.0 };
                powers[k] = (lower - other * powers[k]) / (own - other);
            }
        }
    }
    powers
}

/// Why no polynomial stands for a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// It has too few texels.
    Small,
    /// The source holds none of its places, as far as was seen.
    Nowhere,
    /// Something in it is no polynomial: parts of it may be.
    Bent,
}

/// Finds polynomials for the blocks of a target.
pub struct CoordinatePolynomials<'a> {
    coordinate_map: CoordinateMap<'a>,
    along: [GridAxis; 2],
    fewest: usize,
    outline: Outline,
    /// How many texels an image of the source is, if texels that see several of them are means.
    means: Option<[f64; 2]>,
    /// x and y, first of the points and then of the places at which the polynomial is compared.
    places: [[f64; PLACES]; 2],
    powers_along: [[f64; ALONG]; ALONG],
    powers_down: [[f64; DOWN]; DOWN],
}

impl<'a> CoordinatePolynomials<'a> {
    /// For a coordinate_map between images, and blocks of so many texels at least; none where a formula is not smooth.
    pub fn new(
        coordinate_map: CoordinateMap<'a>,
        source: &Raster,
        target: &Raster,
        fewest: usize,
    ) -> Option<Self> {
        let mut places = [[0.0; PLACES]; 2];
        for k in 0..PLACES {
            let [x, y] = if k < ALONG * DOWN {
                [POINTS_ALONG[k % ALONG], POINTS_DOWN[k / ALONG]]
            } else {
                let (i, j) = BETWEEN[k - ALONG * DOWN];
                let middle = |points: &[f64], k: usize| 0.5 * (points[k] + points[k + 1]);
                [middle(&POINTS_ALONG, i), middle(&POINTS_DOWN, j)]
            };
            (places[0][k], places[1][k]) = (x, y);
        }
        coordinate_map.smooth().then(|| CoordinatePolynomials {
            coordinate_map,
            along: [target.along_u, target.along_v],
            fewest,
            outline: source.outline,
            means: None,
            places,
            powers_along: powers(POINTS_ALONG),
            powers_down: powers(POINTS_DOWN),
        })
    }

    /// For images whose texels are means of what they see of a source.
    pub fn for_means(mut self, source: &Raster) -> Self {
        self.means = Some([source.along_u.index().0, source.along_v.index().0]);
        self
    }

    /// How far polynomials may be from the formula along u and v.
    fn tolerances<R: Scalar>(&self, polynomial: &CoordinatePolynomial<R>) -> [f64; 2] {
        let Some(scale) = self.means else {
            return [TOLERANCE; 2];
        };
        let narrowest = polynomial.narrowest(scale);
        let share = if narrowest >= MANY {
            narrowest * SHARE
        } else {
            0.0
        };
        scale.map(|scale| TOLERANCE.max(share / scale))
    }

    /// Whether blocks of so many columns and rows are worth it.
    pub fn serve(&self, (columns, rows): (usize, usize)) -> bool {
        columns * rows >= self.fewest && columns.min(rows) > 1
    }

    /// Whether a block, by its corners in u and v, lies on one side of each crease of the target.
    fn between_creases(&self, [us, vs]: [[f64; 4]; 2]) -> bool {
        let [creases, _] = self.coordinate_map.creases();
        creases.iter().all(|[a, b, c]| {
            let mut sides = [0.0; 4];
            for (side, (u, v)) in sides.iter_mut().zip(us.into_iter().zip(vs)) {
                *side = a * (2.0 * u - 1.0) + b * (2.0 * v - 1.0) - c;
            }
            sides.iter().all(|side| *side >= -BESIDE) || sides.iter().all(|side| *side <= BESIDE)
        })
    }

    /// Whether places in the source lie on one side of each crease there, and what lies between them does.
    ///
    /// Between two points a smooth function goes beyond both by no more than an eighth of its second difference, and so by a
    /// fourth of a first one.
    fn beside_creases(&self, [us, vs]: [&[f64]; 2]) -> bool {
        let [_, creases] = self.coordinate_map.creases();
        creases.iter().all(|[a, b, c]| {
            let side = |k: usize| a * (2.0 * us[k] - 1.0) + b * (2.0 * vs[k] - 1.0) - c;
            let (mut least, mut most, mut step) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
            for k in 0..ALONG * DOWN {
                let here = side(k);
                (least, most) = (least.min(here), most.max(here));
                if k % ALONG > 0 {
                    step = step.max((here - side(k - 1)).abs());
                }
                if k >= ALONG {
                    step = step.max((here - side(k - ALONG)).abs());
                }
            }
            least > 0.25 * step || most < -0.25 * step
        })
    }

    /// The polynomial of a block, if there is one.
    pub fn of<R: Scalar>(&self, block: &Block) -> Result<CoordinatePolynomial<R>, Refused> {
        let Some((face, texel, [right, down])) = block.face else {
            return Err(Refused::Nowhere);
        };
        if !self.serve((block.columns, block.rows)) {
            return Err(Refused::Small);
        }
        let [half_columns, half_rows] = [block.columns, block.rows].map(|n| 0.5 * (n - 1) as f64);
        let mut uv = Tile::<f64, 3>::new();
        uv.0[2][..PLACES].fill(face as f64);
        let mut corners = [[0.0; 4]; 2];
        for (axis, row) in uv.0[..2].iter_mut().enumerate() {
            let first = self.along[axis].center(texel[axis] as f64);
            let step = self.along[axis].center(1.0) - self.along[axis].center(0.0);
            let across = step * right[axis] as f64 * half_columns;
            let along = step * down[axis] as f64 * half_rows;
            let place = |x: f64, y: f64| first + (across * (x + 1.0) + along * (y + 1.0));
            let [xs, ys] = &self.places;
            for ((at, x), y) in row.iter_mut().zip(xs).zip(ys) {
                *at = place(*x, *y);
            }
            // Half a texel beyond the centers.
            let [x, y] = [half_columns, half_rows].map(|half| 1.0 + 0.5 / half);
            corners[axis] = [place(-x, -y), place(x, -y), place(-x, y), place(x, y)];
        }
        if !self.between_creases(corners) {
            return Err(Refused::Bent);
        }
        self.coordinate_map.take(&mut uv, PLACES);
        let Tile([us, vs, faces]) = &uv;
        let face = faces[0];
        let (mut together, mut nowhere) = (true, true);
        for k in 0..PLACES {
            together &= !us[k].is_nan() & (faces[k] == face);
            nowhere &= us[k].is_nan();
        }
        if !together {
            return Err(if nowhere {
                Refused::Nowhere
            } else {
                Refused::Bent
            });
        }
        if !self.beside_creases([&us[..PLACES], &vs[..PLACES]]) {
            return Err(Refused::Bent);
        }
        let mut along = [R::default(); BLOCK.0];
        for (k, x) in along.iter_mut().enumerate() {
            *x = R::new(k as f64 / half_columns - 1.0);
        }
        let mut nodes = [R::default(); NODES];
        if block.columns >= RUN {
            let pairs = nodes.as_chunks_mut::<2>().0;
            for (pair, first) in pairs.iter_mut().zip(runs(block.columns)) {
                let middle = first as f64 + 0.5 * (RUN - 1) as f64;
                *pair = [-NODE, NODE].map(|node| R::new((middle + node) / half_columns - 1.0));
            }
        }
        let mut coefficients = [[[0.0; ALONG]; DOWN]; 2];
        let mut off = [[0.0; BETWEEN.len()]; 2];
        run_simd(Fit {
            patches: self,
            values: [&us[..PLACES], &vs[..PLACES]],
            coefficients: &mut coefficients,
            off: &mut off,
        });
        let polynomial = CoordinatePolynomial {
            coefficients,
            along,
            nodes,
            half_columns,
            half_rows,
            face: R::new(face),
            outline: self.outline,
        };
        let tolerances = self.tolerances(&polynomial);
        let mut both = off.iter().zip(tolerances);
        // What is no number is not near.
        let near = both.all(|(off, tolerance)| off.iter().all(|off| *off <= tolerance));
        if near {
            Ok(polynomial)
        } else {
            Err(Refused::Bent)
        }
    }
}

/// Those of xⁱ yʲ, by j and i.
type Coefficients = [[f64; ALONG]; DOWN];

/// The polynomials for values of both coordinates at all places, and how far they are from those where they are compared.
struct Fit<'a> {
    patches: &'a CoordinatePolynomials<'a>,
    values: [&'a [f64]; 2],
    coefficients: &'a mut [Coefficients; 2],
    off: &'a mut [[f64; BETWEEN.len()]; 2],
}

impl SimdWork for Fit<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Fit {
            patches,
            values,
            coefficients,
            off,
        } = self;
        let number = |x| f64x8::splat(simd, x);
        let both = values.into_iter().zip(coefficients).zip(off);
        for ((values, coefficients), off) in both {
            let (grid, between) = values.split_at(ALONG * DOWN);
            let mut rows = [number(0.0); DOWN];
            let powers = patches.powers_down.iter();
            for (values, powers) in grid.chunks_exact(ALONG).zip(powers) {
                let values = f64x8::from_slice(simd, values);
                for (row, power) in rows.iter_mut().zip(powers) {
                    *row += number(*power) * values;
                }
            }
            for (coefficients, row) in coefficients.iter_mut().zip(rows) {
                let mut sum = number(0.0);
                let powers = patches.powers_along.iter();
                for (value, powers) in row.to_array().into_iter().zip(powers) {
                    sum += number(value) * f64x8::load_array_ref(simd, powers);
                }
                *coefficients = sum.to_array();
            }
            let [x, y] = &patches.places;
            let x = f64x8::from_slice(simd, &x[ALONG * DOWN..]);
            let y = f64x8::from_slice(simd, &y[ALONG * DOWN..]);
            let mut there = number(0.0);
            for row in coefficients.iter().rev() {
                let mut sum = number(row[ALONG - 1]);
                for &coefficient in row[..ALONG - 1].iter().rev() {
                    sum = sum * x + number(coefficient);
                }
                there = there * y + sum;
            }
            *off = (there - f64x8::from_slice(simd, between)).abs().to_array();
        }
    }
}

/// A polynomial in x and y as one in x.
#[inline(always)]
fn at_y<R: Real, S: Simd>(simd: S, coefficients: &Coefficients, y: f64) -> [R; ALONG] {
    let y = f64x8::splat(simd, y);
    let mut row = f64x8::load_array_ref(simd, &coefficients[DOWN - 1]);
    for coefficients in coefficients[..DOWN - 1].iter().rev() {
        row = row * y + f64x8::load_array_ref(simd, coefficients);
    }
    let (row, mut rounded) = (row.to_array(), [R::ZERO; ALONG]);
    for k in 0..ALONG {
        rounded[k] = R::new(row[k]);
    }
    rounded
}

/// Its value: what changes along a row is summed by itself, in a tree, and rounded to the number's own place once.
#[inline(always)]
fn at_x<R: Real>(c: &[R; ALONG], x: R) -> R {
    let x2 = x * x;
    let low = (c[1] + c[2] * x) + (c[3] + c[4] * x) * x2;
    let high = (c[5] + c[6] * x) + c[7] * x2;
    c[0] + x * (low + high * (x2 * x2))
}

/// Source coordinates of the texels of a block.
pub struct CoordinatePolynomial<R> {
    coefficients: [Coefficients; 2],
    /// Where the texels of a row lie, from -1 to 1.
    along: [R; BLOCK.0],
    /// Where the nodes of its runs lie.
    nodes: [R; NODES],
    /// Half of the way from the first column to the last, and from the first row to the last.
    half_columns: f64,
    half_rows: f64,
    face: R,
    outline: Outline,
}

impl<R: Scalar> CoordinatePolynomial<R> {
    /// Writes two polynomials in x at some places along so many rows of texels from row `first` on: those that `at` has for a row's y.
    #[inline(always)]
    fn rows(
        &self,
        along: &[R],
        (first, block): (usize, &Block),
        [one, other]: [&mut [R]; 2],
        at: impl Fn(f64) -> [[R; ALONG]; 2],
    ) {
        let ones = one.chunks_exact_mut(along.len());
        let others = other.chunks_exact_mut(along.len());
        for (row, (one, other)) in ones.zip(others).take(block.rows).enumerate() {
            let [a, b] = at((first + row) as f64 / self.half_rows - 1.0);
            for ((&x, one), other) in along.iter().zip(one).zip(other) {
                *one = at_x(&a, x);
                *other = at_x(&b, x);
            }
        }
    }

    /// Writes the canonical (u, v, face) of the texels of some of its rows, a block whose first row is number `first`.
    pub fn write(&self, first: usize, block: &Block, uv: &mut Tile<R, 3>) {
        run_simd(Write {
            patch: self,
            first,
            block,
            uv,
        });
    }

    /// Whether the first `count` places of a tile lie on the face for certain.
    pub fn holds(&self, Tile([us, vs, _]): &Tile<R, 3>, count: usize) -> bool {
        let disk = self.outline == Outline::Disk;
        let mut places = us[..count].iter().zip(vs);
        self.outline != Outline::Shape
            && places.all(|(&u, &v)| {
                let at = Uv::flat(u, v);
                let (p, q) = at.pq();
                at.in_bounds(1) & (!disk | (p * p + q * q <= R::ONE))
            })
    }

    /// Whether the first `count` places of a tile, which come from the formula, are places of its face.
    pub fn has_face_of(&self, Tile([us, _, faces]): &Tile<R, 3>, count: usize) -> bool {
        let places = us[..count].iter().zip(faces);
        places.fold(true, |all, (u, &face)| {
            all & !u.is_nan() & (face == self.face)
        })
    }

    /// Writes, for the same texels, ∂u and ∂v from one column to the next, and from one row to the next.
    pub fn slopes(&self, first: usize, block: &Block, slopes: &mut Tile<R, 4>) {
        let along = &self.along[..block.columns];
        self.derivatives([[1, 0], [0, 1]], along, (first, block), &mut slopes.0);
    }

    /// Writes them at the nodes of runs ([`node_of`]).
    pub fn slopes_at_nodes(&self, first: usize, block: &Block, slopes: &mut Tile<R, 4>) {
        let orders = [[1, 0], [0, 1]];
        self.derivatives(orders, &self.nodes, (first, block), &mut slopes.0);
    }

    /// Writes there the second derivatives by rows.
    pub fn bends_at_nodes(&self, first: usize, block: &Block, bends: &mut Tile<R, 2>) {
        self.derivatives([[0, 2]], &self.nodes, (first, block), &mut bends.0);
    }

    /// Writes their second derivatives: of u and v by columns twice, by columns and rows, and by rows twice.
    pub fn bends(&self, first: usize, block: &Block, bends: &mut Tile<R, 6>) {
        let (along, orders) = (&self.along[..block.columns], [[2, 0], [1, 1], [0, 2]]);
        self.derivatives(orders, along, (first, block), &mut bends.0);
    }

    /// Writes derivatives of u and v, so many times by columns and by rows.
    fn derivatives<const N: usize>(
        &self,
        orders: [[usize; 2]; N],
        along: &[R],
        place: (usize, &Block),
        rows: &mut [[R; TILE]],
    ) {
        run_simd(Derivatives {
            patch: self,
            orders: &orders,
            along,
            place,
            rows,
        });
    }

    /// How far both sides of a texel, anywhere in the block, reach along u and along v, at most, in texels of a source that is `scale`
    /// texels an image.
    pub fn longest_sides(&self, scale: [f64; 2]) -> [[f64; 2]; 2] {
        let [by_columns, by_rows] = [self.half_columns, self.half_rows].map(terms);
        let mut sides = [[0.0; 2]; 2];
        for (axis, (coefficients, scale)) in self.coefficients.iter().zip(scale).enumerate() {
            for (j, row) in coefficients.iter().enumerate() {
                for (k, coefficient) in row.iter().enumerate() {
                    // Terms are those of half a texel.
                    let most = 2.0 * coefficient.abs() * scale;
                    sides[0][axis] += most * by_columns[1][k] * by_rows[0][j];
                    sides[1][axis] += most * by_columns[0][k] * by_rows[1][j];
                }
            }
        }
        sides
    }

    /// How narrow a texel is, anywhere in the block, at least, in texels of a source that is `scale` texels an image: the smaller singular
    /// value of its sides in the middle, less by how much they may differ from those.
    pub fn narrowest(&self, scale: [f64; 2]) -> f64 {
        let longest = self.longest_sides(scale);
        let (mut middle, mut change) = ([[0.0; 2]; 2], 0.0);
        for (axis, (coefficients, scale)) in self.coefficients.iter().zip(scale).enumerate() {
            middle[0][axis] = coefficients[0][1] * scale / self.half_columns;
            middle[1][axis] = coefficients[1][0] * scale / self.half_rows;
            for (longest, middle) in longest.iter().zip(middle) {
                let most = longest[axis] - middle[axis].abs();
                change += most * most;
            }
        }
        let [[ax, ay], [bx, by]] = middle;
        // Sums and differences that the singular values of two columns are half of.
        let [sum, difference] = [1.0, -1.0].map(|s| angle::length(ax + s * by, ay - s * bx));
        0.5 * (sum - difference).abs() - change.sqrt()
    }

    /// The most, in texels of a source that is `scale` texels an image, by which places in a texel are elsewhere than derivatives
    /// below an order say: those of the order, anywhere in the block, by half a texel along both.
    pub fn beyond(&self, order: usize, scale: [f64; 2]) -> f64 {
        let [by_columns, by_rows] = [self.half_columns, self.half_rows].map(terms);
        let mut most: f64 = 0.0;
        for (coefficients, scale) in self.coefficients.iter().zip(scale) {
            let mut off = 0.0;
            for (j, row) in coefficients.iter().enumerate() {
                for (k, coefficient) in row.iter().enumerate() {
                    let both = (0..=order).map(|n| by_columns[n][k] * by_rows[order - n][j]);
                    off += coefficient.abs() * both.sum::<f64>();
                }
            }
            most = most.max(off * scale);
        }
        most
    }
}

/// Terms of Taylor's series half a texel from a place, of a block that reaches so many texels from its middle: of each order what is
/// left of each power of a number up to 1.
fn terms(half: f64) -> [[f64; ALONG]; 4] {
    let (mut terms, mut share) = (BINOMIALS, 1.0);
    for terms in &mut terms {
        for term in terms {
            *term *= share;
        }
        share *= 0.5 / half;
    }
    terms
}

/// Of each power, how often each order of its derivatives is there: k! / n! (k - n)!.
const BINOMIALS: [[f64; ALONG]; 4] = {
    let mut rows = [[0.0; ALONG]; 4];
    let mut k = 0;
    while k < ALONG {
        rows[0][k] = 1.0;
        let mut n = 1;
        while n < 4 && n <= k {
            rows[n][k] = rows[n - 1][k] * (k - n + 1) as f64 / n as f64;
            n += 1;
        }
        k += 1;
    }
    rows
};

struct Derivatives<'a, R> {
    patch: &'a CoordinatePolynomial<R>,
    orders: &'a [[usize; 2]],
    along: &'a [R],
    place: (usize, &'a Block),
    rows: &'a mut [[R; TILE]],
}

impl<R: Scalar> SimdWork for Derivatives<'_, R> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let patch = self.patch;
        let pairs = self.rows.as_chunks_mut::<2>().0;
        for (&[by_x, by_y], [us, vs]) in self.orders.iter().zip(pairs) {
            let mut both = patch.coefficients;
            for coefficients in &mut both {
                for _ in 0..by_y {
                    *coefficients = along_y(coefficients, 1.0 / patch.half_rows);
                }
            }
            let [u, v] = &both;
            patch.rows(
                self.along,
                self.place,
                [us, vs],
                #[inline(always)]
                |y| {
                    let mut at = [at_y(simd, u, y), at_y(simd, v, y)];
                    for row in &mut at {
                        for _ in 0..by_x {
                            *row = along_x(*row, 1.0 / patch.half_columns);
                        }
                    }
                    at
                },
            );
        }
    }
}

/// The derivative of a polynomial in x, times a number.
#[inline(always)]
fn along_x<R: Real>(c: [R; ALONG], times: f64) -> [R; ALONG] {
    let mut derivative = [R::ZERO; ALONG];
    for k in 1..ALONG {
        derivative[k - 1] = c[k] * R::new(k as f64 * times);
    }
    derivative
}

/// The derivative of a polynomial in x and y by y, times a number.
#[inline(always)]
fn along_y(c: &Coefficients, times: f64) -> Coefficients {
    let mut derivative = [[0.0; ALONG]; DOWN];
    for j in 1..DOWN {
        for k in 0..ALONG {
            derivative[j - 1][k] = c[j][k] * (j as f64 * times);
        }
    }
    derivative
}

struct Write<'a, R> {
    patch: &'a CoordinatePolynomial<R>,
    first: usize,
    block: &'a Block,
    uv: &'a mut Tile<R, 3>,
}

impl<R: Scalar> SimdWork for Write<'_, R> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Write {
            patch,
            first,
            block,
            uv: Tile([us, vs, faces]),
        } = self;
        let [u, v] = &patch.coefficients;
        patch.rows(
            &patch.along[..block.columns],
            (first, block),
            [us, vs],
            #[inline(always)]
            |y| [at_y(simd, u, y), at_y(simd, v, y)],
        );
        faces[..block.columns * block.rows].fill(patch.face);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::raster::shape_of_size;
    use crate::image::texels::Centers;
    use crate::map::Map;
    use crate::projections::REGISTRY;
    use crate::projections::projection::Coverage;
    use glam::DMat3;
    use proptest::prelude::*;

    fn map(name: &str) -> Map {
        Map::new(name).unwrap()
    }

    fn smooth() -> impl Iterator<Item = &'static str> {
        REGISTRY
            .iter()
            .filter(|info| info.smooth)
            .map(|info| info.name)
    }

    /// Texels whose coordinates come from polynomials, all texels, and the farthest that one of those is off.
    fn compare(source: &str, target: &str, size: usize, rotation: Option<DMat3>) -> [f64; 3] {
        let (source, target) = (map(source), map(target));
        let raster = Raster::new(&target, &shape_of_size(&target, size)).unwrap();
        let from = Raster::new(&source, &shape_of_size(&source, 64)).unwrap();
        let coordinate_map = CoordinateMap::new(&source, &target, rotation);
        let patches = CoordinatePolynomials::new(coordinate_map, &from, &raster, 512).unwrap();
        // Where the source ends, polynomials stand for what lies a texel or more inside.
        let near = [1.0 / from.width as f64, 1.0 / from.height as f64];
        let inside = |place: [f64; 2]| {
            (0..2).all(|axis| (near[axis]..=1.0 - near[axis]).contains(&place[axis]))
                && from.holds_around(place, near)
        };
        let sphere = source.coverage() == Coverage::Sphere;
        let (centers, wide) = (Centers::<f32>::new(&raster), Centers::<f64>::new(&raster));
        let (mut uv, mut exact) = (Tile::<f32, 3>::new(), Tile::<f64, 3>::new());
        let (mut found, mut farthest) = (0, 0.0);
        raster.blocks(0, raster.rows, BLOCK, |whole| {
            let Ok(patch) = patches.of::<f32>(&whole) else {
                return;
            };
            for (row, block) in whole.bands(4, raster.columns) {
                let count = block.columns * block.rows;
                centers.of(&block, &mut uv);
                patch.write(row, &block, &mut uv);
                let place = |k: usize| [0, 1].map(|axis| f64::from(uv.0[axis][k]));
                let shape = from.outline == Outline::Shape;
                let serves = (shape || patch.holds(&uv, count))
                    && (sphere && !shape || (0..count).all(|k| inside(place(k))));
                if !serves {
                    continue;
                }
                found += count;
                wide.of(&block, &mut exact);
                coordinate_map.take(&mut exact, count);
                for k in 0..count {
                    let ([a, b, face], [u, v, there]) = (uv.at(k), exact.at(k));
                    let off = if f64::from(face) == there {
                        (f64::from(a) - u).abs().max((f64::from(b) - v).abs())
                    } else {
                        f64::INFINITY
                    };
                    farthest = if off <= farthest { farthest } else { off };
                }
            }
        });
        [found as f64, raster.texels() as f64, farthest]
    }

    /// The stated bound, in images: eight times the tolerance, for what lies between the places that were compared, and f32's
    /// rounding of a number's two parts, half of 2⁻²⁴ each.
    const BOUND: f64 = f32::EPSILON as f64;

    fn turned() -> DMat3 {
        DMat3::from_axis_angle(glam::DVec3::new(0.36, -0.48, 0.8), 1.1)
    }

    #[test]
    fn polynomials_are_near_the_formula_between_all_smooth_projections() {
        for source in smooth() {
            for target in smooth() {
                let few = ["latlong", "cube", "angular"];
                if source == target || !(few.contains(&source) || few.contains(&target)) {
                    continue;
                }
                for rotation in [None, Some(turned())] {
                    let [_, _, off] = compare(source, target, 256, rotation);
                    assert!(
                        off <= BOUND,
                        "{source} → {target}: {off:e}, turned {rotation:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn polynomials_are_near_the_formula_between_creases() {
        for info in REGISTRY.iter().filter(|info| !info.creases.is_empty()) {
            for source in smooth() {
                for (size, rotation) in [(256, None), (255, Some(turned()))] {
                    let [_, _, off] = compare(source, info.name, size, rotation);
                    let name = info.name;
                    assert!(off <= BOUND, "{source} → {name}: {off:e}, {rotation:?}");
                }
            }
        }
    }

    #[test]
    fn polynomials_are_near_the_formula_beside_creases_of_the_source() {
        for info in REGISTRY.iter().filter(|info| !info.creases.is_empty()) {
            for target in ["latlong", "cube", "angular", "octahedral", "healpix"] {
                if target == info.name {
                    continue;
                }
                for (size, rotation) in [(256, None), (255, Some(turned()))] {
                    let [_, _, off] = compare(info.name, target, size, rotation);
                    let name = info.name;
                    assert!(off <= BOUND, "{name} → {target}: {off:e}, {rotation:?}");
                }
            }
        }
    }

    #[test]
    fn most_of_a_large_image_comes_from_polynomials() {
        for (source, target, share) in [
            // Of whole blocks; most of these have a crease.
            ("latlong", "octahedral", 0.1),
            ("octahedral", "latlong", 0.1),
            ("healpix", "latlong", 0.1),
            ("latlong", "cube", 0.5),
            ("cube", "latlong", 0.5),
            ("sphere", "latlong", 0.5),
            ("latlong", "perspective", 0.5),
            ("mollweide", "latlong", 0.5),
            ("latlong", "hammer", 0.3),
            // Of the ellipse inside.
            ("sinusoidal", "latlong", 0.3),
            // Half of the sphere.
            ("equisolid", "latlong", 0.3),
        ] {
            let [found, all, _] = compare(source, target, 512, Some(turned()));
            assert!(found > share * all, "{source} → {target}: {}", found / all);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(256))]

        #[test]
        fn edges_of_faces_and_seams_are_noticed_however_they_lie(
            angles in prop::array::uniform3(-3.2f64..3.2),
            source in prop::sample::select(vec![
                "latlong", "cube", "dual_paraboloid", "cube_equiangular", "octahedral", "equal_area", "concentric", "healpix",
                "mollweide", "hammer", "sinusoidal",
            ]),
            size in 65usize..300,
        ) {
            let [a, b, c] = angles;
            let rotation = DMat3::from_euler(glam::EulerRot::YXZ, a, b, c);
            for target in ["latlong", "cube"] {
                let [_, _, off] = compare(source, target, size, Some(rotation));
                prop_assert!(off <= BOUND, "{} → {target}: {off:e}", source);
            }
        }
    }

    #[test]
    fn it_takes_on_its_values() {
        let powers = powers(POINTS_ALONG);
        for (i, coefficients) in powers.iter().enumerate() {
            for (j, &x) in POINTS_ALONG.iter().enumerate() {
                let wanted = f64::from(u8::from(i == j));
                assert!((at_x(coefficients, x) - wanted).abs() < 1e-13, "{i} {j}");
            }
        }
    }
}
