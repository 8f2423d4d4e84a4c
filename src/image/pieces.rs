//! Solid angles where the density is smooth, which for nearly all texels it is: integrals of a polynomial.
//!
//! A face is cut into pieces, and those that are not smooth into quarters, down to [`LEAST`] texels a side. In a piece, whatever the
//! map, the density is a polynomial of degree N - 1 in u and in v, through its values at Chebyshev's points, those on the border among
//! them (Trefethen 2013, Approximation Theory and Approximation Practice, chapter 3). Where its last coefficients are rounding, so is what is left out:
//! they tell a crease, a pole or a rim beside the piece, of which no map has to be asked. The integral over a texel is a sum of products of
//! mean powers, (x₀ᵏ + x₀ᵏ⁻¹ x₁ + … + x₁ᵏ)/(k + 1), in which nothing cancels.
//!
//! A texel costs five operations for each power, in lanes, whatever the density costs. Pieces are those of the face, and are found when one
//! of their texels is first asked for: a texel has the same bits in whatever part of the image it is asked for.
//!
//! What did not help: twelve points along a side, with which pieces of an octahedron have to be a 32nd of a side; stricter last coefficients, as there are
//! more pieces and results are no better.

use crate::image::raster::Raster;
use crate::kernel::vectorize;
use crate::map::Map;
use crate::map::grid::GridAxis;
use crate::map::verbs::DensityOwn;
use crate::number::real::Real;
use std::ops::Range;
use std::sync::{LazyLock, OnceLock};

/// Points along a side of a piece.
const N: usize = 16;

/// One in so many points along a side is looked at first, corners among them; of an equal-area map no more are: what it holds is convex.
const FEWER: usize = 5;
const FEW: usize = (N - 1) / FEWER + 1;
const _: () = assert!((N - 1).is_multiple_of(FEWER));

/// Texels along the shorter side of the smallest pieces. With fewer, the points of a piece cost more than its texels do by themselves.
const LEAST: usize = 8;

/// Of larger faces, a part of the side: those beside a rim are as many as are parts along it, and each takes two kilobytes.
const SMALLEST: usize = 256;

/// The most pieces along a side of a face before any is cut.
const ACROSS: usize = 8;

/// The last coefficients of a smooth density, of the most that it is.
const ROUNDING: f64 = 1e-14;

/// The most that a density of which rounding is relative to the most is more than the least.
const RANGE: f64 = 8.0;

/// The pieces of a face.
pub(crate) struct Pieces {
    /// Where columns begin and, last, where they end.
    edges: Vec<f64>,
    across: usize,
    down: usize,
    pieces: Vec<OnceLock<Piece>>,
}

/// Columns and rows of texels.
#[derive(Clone)]
struct Part {
    columns: Range<usize>,
    rows: Range<usize>,
}

enum Piece {
    Smooth(Box<Polynomial>),
    /// Left and right above, left and right below.
    Quarters(Box<[Piece; 4]>),
    /// Of texels that are asked for one by one.
    Rough,
}

/// A density as Σ c[l][k] xᵏ yˡ, each divided by (k + 1) (l + 1), where x and y go from -1 to 1.
pub(crate) struct Polynomial {
    along_u: Scale,
    along_v: Scale,
    coefficients: [[f64; N]; N],
}

#[derive(Clone, Copy)]
struct Scale {
    middle: f64,
    half: f64,
}

impl Scale {
    fn new(axis: GridAxis, cells: &Range<usize>) -> Scale {
        let (from, to) = (axis.cell(cells.start).0, axis.cell(cells.end - 1).1);
        Scale {
            middle: 0.5 * (from + to),
            half: 0.5 * (to - from),
        }
    }

    /// The point from -1 to 1 of a coordinate.
    #[inline(always)]
    fn of(self, x: f64) -> f64 {
        (x - self.middle) * (1.0 / self.half)
    }
}

impl Pieces {
    /// Those of a face; none of a face so small that its points are as many as its texels, of one whose rows are alike, or of a map that
    /// shows some of the sphere twice.
    pub(crate) fn new(map: &Map, raster: &Raster) -> Option<Pieces> {
        if map.has_even_rows() || map.overlaps() {
            return None;
        }
        let [across, down] = [raster.width, raster.height].map(|n| ACROSS.min(n / LEAST));
        (across * down >= ACROSS * ACROSS / 2).then(|| Pieces {
            edges: raster.along_u.edges(0..raster.width),
            across,
            down,
            pieces: (0..across * down).map(|_| OnceLock::new()).collect(),
        })
    }

    /// Writes those of row j from a column on, where the density is smooth; calls `other` for each range of columns where it is not.
    pub(crate) fn row(
        &self,
        of: (&Map, &Raster),
        j: usize,
        first: usize,
        out: &mut [f64],
        mut other: impl FnMut(Range<usize>, &mut [f64]),
    ) {
        let sides = of.1.along_v.cell(j);
        self.each(of, j, first..first + out.len(), |columns, found| {
            let out = &mut out[columns.start - first..columns.end - first];
            match found {
                Some(polynomial) => {
                    polynomial.row(sides, &self.edges[columns.start..=columns.end], out);
                }
                None => other(columns, out),
            }
        });
    }

    /// Writes those of parts of row j, from one side to another and between edges: `texel` says which column a part is of. Calls `other` with
    /// parts that no polynomial is for.
    pub(crate) fn parts(
        &self,
        of: (&Map, &Raster),
        (j, sides): (usize, (f64, f64)),
        (texel, edges): (impl Fn(usize) -> usize, &[f64]),
        out: &mut [f64],
        mut other: impl FnMut(Range<usize>, &mut [f64]),
    ) {
        let Some(last) = out.len().checked_sub(1) else {
            return;
        };
        let numbers: Vec<usize> = (0..out.len()).map(&texel).collect();
        self.each(of, j, texel(0)..texel(last) + 1, |columns, found| {
            let which = |column| numbers.partition_point(|number| *number < column);
            let parts = which(columns.start)..which(columns.end);
            let out = &mut out[parts.clone()];
            match found {
                Some(polynomial) => {
                    polynomial.row(sides, &edges[parts.start..=parts.end], out);
                }
                None => other(parts, out),
            }
        });
    }

    /// Calls `work` for each range of some columns of row j that one polynomial is for, or none.
    pub(crate) fn each(
        &self,
        (map, raster): (&Map, &Raster),
        j: usize,
        wanted: Range<usize>,
        mut work: impl FnMut(Range<usize>, Option<&Polynomial>),
    ) {
        let mut rough = wanted.start..wanted.start;
        let down = place(j, raster.height, self.down);
        let mut i = wanted.start;
        while i < wanted.end {
            let across = place(i, raster.width, self.across);
            let part = Part {
                columns: span(across, raster.width, self.across),
                rows: span(down, raster.height, self.down),
            };
            let piece = self.pieces[down * self.across + across]
                .get_or_init(|| Piece::new(map, raster, &part));
            i = part.columns.end;
            piece.each(&part, j, &wanted, &mut |columns, found| {
                if found.is_some() {
                    // Those beside each other that none is for come at once.
                    if !rough.is_empty() {
                        work(rough.clone(), None);
                    }
                    work(columns.clone(), found);
                    rough = columns.end..columns.end;
                } else {
                    rough.end = columns.end;
                }
            });
        }
        if !rough.is_empty() {
            work(rough, None);
        }
    }
}

/// In which of some parts of a side cell i lies.
fn place(i: usize, n: usize, parts: usize) -> usize {
    let guess = i * parts / n;
    // Where parts begin is rounded down.
    if guess + 1 < parts && i >= span(guess + 1, n, parts).start {
        guess + 1
    } else {
        guess
    }
}

/// The cells of a part of a side.
fn span(part: usize, n: usize, parts: usize) -> Range<usize> {
    part * n / parts..(part + 1) * n / parts
}

impl Part {
    fn quarters(&self) -> [Part; 4] {
        let [left, right] = halves(&self.columns);
        let [above, below] = halves(&self.rows);
        [
            (&left, &above),
            (&right, &above),
            (&left, &below),
            (&right, &below),
        ]
        .map(|(columns, rows)| Part {
            columns: columns.clone(),
            rows: rows.clone(),
        })
    }
}

fn halves(range: &Range<usize>) -> [Range<usize>; 2] {
    let middle = range.start + range.len() / 2;
    [range.start..middle, middle..range.end]
}

impl Piece {
    fn new(map: &Map, raster: &Raster, part: &Part) -> Piece {
        let found = Polynomial::find(map, raster, part);
        match found {
            Found::Smooth(polynomial) => return Piece::Smooth(polynomial),
            Found::Nothing => return Piece::Rough,
            Found::Rough => {}
        }
        let least = LEAST.max(raster.width.min(raster.height) / SMALLEST);
        if part.columns.len().min(part.rows.len()) < 2 * least {
            return Piece::Rough;
        }
        let quarters = part.quarters().map(|part| Piece::new(map, raster, &part));
        if quarters.iter().all(|piece| matches!(piece, Piece::Rough)) {
            return Piece::Rough;
        }
        Piece::Quarters(Box::new(quarters))
    }

    /// Calls `work` for each range of wanted columns of row j that one polynomial, or none, is for.
    fn each<'p>(
        &'p self,
        part: &Part,
        j: usize,
        wanted: &Range<usize>,
        work: &mut impl FnMut(&Range<usize>, Option<&'p Polynomial>),
    ) {
        let here = part.columns.start.max(wanted.start)..part.columns.end.min(wanted.end);
        if here.is_empty() {
            return;
        }
        match self {
            Piece::Smooth(polynomial) => work(&here, Some(polynomial)),
            Piece::Rough => work(&here, None),
            Piece::Quarters(quarters) => {
                for (quarter, part) in quarters.iter().zip(part.quarters()) {
                    if part.rows.contains(&j) {
                        quarter.each(&part, j, wanted, work);
                    }
                }
            }
        }
    }
}

enum Found {
    Smooth(Box<Polynomial>),
    Rough,
    /// No point lies in the valid image.
    Nothing,
}

/// What densities at points of a piece tell of it.
#[derive(PartialEq)]
enum Level {
    /// None lies in the valid image.
    Nothing,
    Not,
    /// They differ by little, and none is larger.
    UpTo(f64),
}

impl Level {
    fn of(densities: &[f64]) -> Level {
        if densities.iter().all(|x| x.is_nan()) {
            return Level::Nothing;
        }
        let least = densities
            .iter()
            .fold(f64::INFINITY, |least, x| least.min(*x));
        let most = densities.iter().fold(0.0, |most: f64, x| most.max(*x));
        let finite = densities.iter().all(|x| x.is_finite());
        if finite && least > 0.0 && least * RANGE >= most {
            Level::UpTo(most)
        } else {
            Level::Not
        }
    }
}

impl Polynomial {
    fn find(map: &Map, raster: &Raster, part: &Part) -> Found {
        let along_u = Scale::new(raster.along_u, &part.columns);
        let along_v = Scale::new(raster.along_v, &part.rows);
        let chebyshev = &*CHEBYSHEV;
        let at = |scale: Scale| {
            chebyshev.points.map(|x| {
                let (low, high) = (scale.middle - scale.half, scale.middle + scale.half);
                (scale.middle + scale.half * x).clamp(low.max(0.0), high.min(1.0))
            })
        };
        let (us, vs) = (at(along_u), at(along_v));
        let ask = |step: usize, out: &mut [f64]| {
            let mut places = Vec::with_capacity(3 * out.len());
            for u in us.into_iter().step_by(step) {
                for v in vs.into_iter().step_by(step) {
                    places.extend([u, v]);
                    if raster.faces() > 1 {
                        places.push(0.0);
                    }
                }
            }
            map.visit_canonical(DensityOwn {
                input: &places,
                output: out,
            });
            Level::of(out)
        };
        let equal_area = map.info().equal_area;
        let mut values = [[0.0; N]; N];
        let all = values.as_flattened_mut();
        // Most that are not level are told by a few.
        let few = ask(FEWER, &mut all[..FEW * FEW]);
        let level = if equal_area || few == Level::Not {
            few
        } else {
            ask(1, all)
        };
        let most = match level {
            Level::Nothing => return Found::Nothing,
            Level::Not => return Found::Rough,
            Level::UpTo(most) => most,
        };
        let coefficients = if equal_area {
            let mut coefficients = [[0.0; N]; N];
            coefficients[0][0] = most;
            coefficients
        } else if let Some(coefficients) = chebyshev.coefficients(&values, most) {
            coefficients
        } else {
            return Found::Rough;
        };
        Found::Smooth(Box::new(Polynomial {
            along_u,
            along_v,
            coefficients,
        }))
    }

    /// Writes those of cells of a row, all of them in the piece, which lie between these edges.
    pub(crate) fn row(&self, (v0, v1): (f64, f64), edges: &[f64], out: &mut [f64]) {
        let (y0, y1) = (self.along_v.of(v0), self.along_v.of(v1));
        let dv = v1 - v0;
        vectorize(
            #[inline(always)]
            || {
                let (mut power, mut sum) = (1.0, 1.0);
                let mut of_row = self.coefficients[0];
                for along_u in &self.coefficients[1..] {
                    power *= y0;
                    sum = sum * y1 + power;
                    for (of_row, coefficient) in of_row.iter_mut().zip(along_u) {
                        *of_row += coefficient * sum;
                    }
                }
                for ((u0, u1), out) in edges.iter().zip(&edges[1..]).zip(out) {
                    let (u0, u1) = (*u0, *u1);
                    let (x0, x1) = (self.along_u.of(u0), self.along_u.of(u1));
                    let (mut power, mut sum, mut density) = (1.0, 1.0, of_row[0]);
                    for coefficient in &of_row[1..] {
                        power *= x0;
                        sum = sum * x1 + power;
                        density += coefficient * sum;
                    }
                    *out = density * ((u1 - u0) * dv);
                }
            },
        );
    }
}

/// What makes a polynomial of the values at points from -1 to 1.
struct Chebyshev {
    points: [f64; N],
    /// From values to coefficients of Chebyshev's polynomials.
    terms: [[f64; N]; N],
    /// From these to those of mean powers, which are those of powers divided by k + 1.
    mean_powers: [[f64; N]; N],
}

static CHEBYSHEV: LazyLock<Chebyshev> = LazyLock::new(|| {
    let last = (N - 1) as f64;
    // The sines of parts of a right angle: those at the ends are 1 and -1 to the bit.
    let points: [f64; N] = std::array::from_fn(|a| {
        let (sin, _) = f64::sin_cos_half_turns(0.5 - a as f64 / last);
        sin
    });
    let mut polynomials = [[0.0; N]; N];
    let mut powers = [[0.0; N]; N];
    for k in 0..N {
        for (a, x) in points.into_iter().enumerate() {
            polynomials[k][a] = match k {
                0 => 1.0,
                1 => x,
                _ => 2.0 * x * polynomials[k - 1][a] - polynomials[k - 2][a],
            };
            // The coefficient of xᵃ.
            powers[k][a] = match (k, a) {
                (0, 0) | (1, 1) => 1.0,
                (0 | 1, _) => 0.0,
                (_, 0) => -powers[k - 2][0],
                _ => 2.0 * powers[k - 1][a - 1] - powers[k - 2][a],
            };
        }
    }
    let at_end = |k: usize| if k == 0 || k == N - 1 { 0.5 } else { 1.0 };
    let terms = std::array::from_fn(|k| {
        std::array::from_fn(|a| 2.0 / last * at_end(k) * at_end(a) * polynomials[k][a])
    });
    let mean_powers =
        std::array::from_fn(|a| std::array::from_fn(|k| powers[k][a] / (a + 1) as f64));
    Chebyshev {
        points,
        terms,
        mean_powers,
    }
});

impl Chebyshev {
    /// What a polynomial has of mean powers, those along the second side first; none where its last terms are more than rounding of
    /// the most that the values are.
    fn coefficients(&self, values: &[[f64; N]; N], most: f64) -> Option<[[f64; N]; N]> {
        let is_rounding = |terms: &[f64]| terms.iter().all(|x| x.abs() <= ROUNDING * most);
        let mut found = None;
        vectorize(
            #[inline(always)]
            || {
                let terms = &self.terms;
                let [.., next, last] = terms;
                let last = &[*next, *last];
                // A crease is mostly told by the last terms along one side, which are an eighth of the way.
                let last_along_u = product(terms, &transposed(&product(last, values)));
                if !is_rounding(last_along_u.as_flattened()) {
                    return;
                }
                let along_u = transposed(&product(terms, values));
                if !is_rounding(product(last, &along_u).as_flattened()) {
                    return;
                }
                let both = transposed(&product(terms, &along_u));
                let powers = &self.mean_powers;
                found = Some(product(powers, &transposed(&product(powers, &both))));
            },
        );
        found
    }
}

#[inline(always)]
fn product<const ROWS: usize, const COLUMNS: usize>(
    a: &[[f64; N]; ROWS],
    b: &[[f64; COLUMNS]; N],
) -> [[f64; COLUMNS]; ROWS] {
    let mut product = [[0.0; COLUMNS]; ROWS];
    for (row, out) in a.iter().zip(&mut product) {
        for (x, b) in row.iter().zip(b) {
            for (out, y) in out.iter_mut().zip(b) {
                *out += x * y;
            }
        }
    }
    product
}

#[inline(always)]
fn transposed<const ROWS: usize, const COLUMNS: usize>(
    a: &[[f64; COLUMNS]; ROWS],
) -> [[f64; ROWS]; COLUMNS] {
    let mut turned = [[0.0; ROWS]; COLUMNS];
    for (i, row) in a.iter().enumerate() {
        for (turned, x) in turned.iter_mut().zip(row) {
            turned[i] = *x;
        }
    }
    turned
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::raster::shape_of_size;
    use crate::image::texels::{SolidAngles, solid_angle_of};
    use crate::projections::REGISTRY;
    use proptest::prelude::*;

    #[test]
    fn solid_angles_are_those_of_closed_forms() {
        for info in REGISTRY {
            let map = Map::new(info.name).unwrap();
            // Pieces that are not alike, and some that are cut.
            for n in [101, 230] {
                let raster = Raster::new(&map, &shape_of_size(&map, n)).unwrap();
                let cells = SolidAngles::new(&map, &raster);
                let mut row = vec![0.0; raster.width];
                for j in (0..raster.height).step_by(7) {
                    cells.row(&map, &raster, j, 0, &mut row);
                    for (i, found) in row.iter().enumerate().skip(j % 5).step_by(5) {
                        let itself = solid_angle_of(&map, &raster, i, j);
                        // Of lenses `smooth` errs by 1e-10, of triangles the exact form by 2e-13.
                        let bound = if info.smooth { 1e-10 } else { 1e-12 };
                        let off = (found - itself).abs();
                        assert!(off <= bound * itself, "{} {n} {i} {j}: {off}", info.name);
                    }
                }
            }
        }
    }

    #[test]
    fn no_crease_lies_within_a_smooth_piece() {
        let map = Map::new("octahedral").unwrap();
        // In the middle of a column, or between two; and on the diagonal of the pieces, or beside it.
        for n in [128, 129, 200, 257, 301] {
            let raster = Raster::new(&map, &[n, n]).unwrap();
            let pieces = Pieces::new(&map, &raster).unwrap();
            let mut smooth = 0;
            for j in 0..n {
                let mut sum = vec![0.0; n];
                let mut rough = vec![false; n];
                pieces.row((&map, &raster), j, 0, &mut sum, |columns, _| {
                    rough[columns].fill(true);
                });
                for i in (0..n).filter(|&i| !rough[i]) {
                    smooth += 1;
                    // The sums of |2u - 1| and |2v - 1| at the corners lie on one side of 1.
                    let at = |k: usize| (2.0 * k as f64 / n as f64 - 1.0).abs();
                    let corners = [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)];
                    let inner = corners.map(|(i, j)| at(i) + at(j) < 1.0);
                    let outer = corners.map(|(i, j)| at(i) + at(j) > 1.0);
                    assert!(
                        !(inner.contains(&true) && outer.contains(&true)),
                        "{n} {i} {j}"
                    );
                    assert!(n % 2 == 0 || (i != n / 2 && j != n / 2), "{n} {i} {j}");
                }
            }
            assert!(smooth > n * n / 3, "{n} {smooth}");
        }
    }

    #[test]
    fn a_density_that_is_nearly_smooth_is_not() {
        let map = Map::new("octahedral").unwrap();
        let raster = Raster::new(&map, &[1 << 12, 1 << 12]).unwrap();
        let is_smooth = |columns, rows| {
            let found = Polynomial::find(&map, &raster, &Part { columns, rows });
            matches!(found, Found::Smooth(_))
        };
        // Up to the crease in the middle, and a texel beyond.
        assert!(is_smooth(1920..2048, 1700..1800));
        assert!(!is_smooth(1921..2049, 1700..1800));
    }

    proptest! {
        #[test]
        fn each_cell_is_in_the_part_that_is_told(n in 12_usize..5000, parts in 1..=ACROSS, i in 0_usize..5000) {
            let (i, parts) = (i % n, parts.min(n / LEAST));
            let part = place(i, n, parts);
            prop_assert!(part < parts && span(part, n, parts).contains(&i));
        }

        /// A texel has the same bits in whatever part of a row it is asked for.
        #[test]
        fn parts_of_a_row_have_the_bits_of_the_row(
            name in prop::sample::select(vec!["octahedral", "angular", "cube", "sinusoidal", "camera_fov", "matcap"]),
            j in 0_usize..140,
            ends in prop::array::uniform2(0_usize..140),
        ) {
            let map = Map::new(name).unwrap();
            let raster = Raster::new(&map, &shape_of_size(&map, 140)).unwrap();
            let mut whole = vec![0.0; raster.width];
            SolidAngles::new(&map, &raster).row(&map, &raster, j, 0, &mut whole);
            let (from, to) = (ends[0].min(ends[1]), ends[0].max(ends[1]) + 1);
            let mut part = vec![0.0; to - from];
            SolidAngles::new(&map, &raster).row(&map, &raster, j, from, &mut part);
            prop_assert!(part.iter().zip(&whole[from..]).all(|(a, b)| a.to_bits() == b.to_bits()));
        }
    }
}
