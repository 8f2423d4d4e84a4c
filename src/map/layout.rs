//! Coordinates of faces to those of a stored image, and back.
//!
//! A projection computes canonical (u, v, face). Where its faces are stored in another order, turned, or side by side
//! in one image, a second formula takes that to the image's own coordinates ([`store`]) or back ([`locate`]). It knows
//! the [`FaceLayout`] and no projection: so there is one of it, and not one for each projection of several faces and
//! each of its verbs, which was a third of the library's code. The numbers between the two formulas stay in the
//! first-level cache.

use crate::kernel;
use crate::kernel::tile::{TILE, Tuples, TuplesMut};
use crate::kernel::{Frame, Point, Scalar};
use crate::number::real::Real;
use crate::projections::faces::{FaceLayout, MAX_FACES, Side, Sides};
use crate::projections::projection::Uv;

/// Faces in an face_layout: ATLAS in one image, or apart in another order. FACES is the most it has room for.
#[derive(Clone, Copy)]
struct LaidOut<const FACES: usize, const ATLAS: bool> {
    columns: f64,
    rows: f64,
    stored: [f64; FACES],
    sides: [Sides; FACES],
    swap: [f64; FACES],
}

/// A place on a canonical face.
#[derive(Clone, Copy)]
pub struct Located<R: Real> {
    /// Where on which face.
    pub place: Uv<R>,
    /// Whether there is one.
    pub found: R::Mask,
    /// How fast the face's coordinates along the image's u and v change.
    pub slope: [R; 2],
    /// Whether u of the image is v of the face.
    pub swapped: R::Mask,
}

impl<R: Real> Located<R> {
    /// The place where coordinates are the projection's own.
    pub fn canonical(place: Uv<R>) -> Self {
        Located {
            place,
            found: R::truth(true),
            slope: [R::ONE; 2],
            swapped: R::truth(false),
        }
    }

    /// (u, v, face), NaN where there is no place.
    #[inline(always)]
    fn or_nan(self) -> [R; 3] {
        let nan = R::NAN;
        [
            R::choose(self.found, self.place.u, nan),
            R::choose(self.found, self.place.v, nan),
            R::choose(self.found, self.place.face, nan),
        ]
    }
}

/// What the faces tried so far have of a place.
#[derive(Clone, Copy)]
struct Tried<R: Real> {
    place: Uv<R>,
    signs: [R; 2],
    swap: R,
    found: R::Mask,
}

impl<R: Real> Tried<R> {
    #[inline(always)]
    fn none() -> Self {
        let nan = R::NAN;
        Tried {
            place: Uv {
                u: nan,
                v: nan,
                face: nan,
            },
            signs: [nan; 2],
            swap: nan,
            found: R::truth(false),
        }
    }
}

/// How a face is stored.
#[derive(Clone, Copy)]
struct Kept<R: Real> {
    along: Side<R>,
    down: Side<R>,
    swap: R,
    stored: R,
}

impl<const FACES: usize, const ATLAS: bool> LaidOut<FACES, ATLAS> {
    fn new(face_layout: &FaceLayout) -> Self {
        let mut arranged = LaidOut {
            columns: face_layout.columns as f64,
            rows: face_layout.rows as f64,
            stored: [-1.0; FACES],
            sides: [Sides::NOWHERE; FACES],
            swap: [0.0; FACES],
        };
        for (face, place) in face_layout.places[..face_layout.faces].iter().enumerate() {
            arranged.stored[face] = place.stored as f64;
            arranged.sides[face] = place.sides;
            arranged.swap[face] = f64::from(u8::from(place.orientation.swap));
        }
        arranged
    }

    /// The place on a face at `uv`, if one is there.
    #[inline(always)]
    fn place<R: Real>(self, uv: Uv<R>) -> Located<R> {
        let cell = self.cell(uv);
        let mut tried = Tried::none();
        // Each face's place is computed and one is chosen: choosing the constants first saves the
        // arithmetic, but the compiler makes branches of it.
        macro_rules! try_face {
            ($($face:literal),+) => {$(
                if $face < FACES {
                    tried = self.try_face($face, uv, cell, tried);
                }
            )+};
        }
        try_face!(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11);
        self.located(uv, tried)
    }

    /// The same, face after face: what makes no lanes gains nothing by twelve faces written out.
    fn place_one<R: Real>(self, uv: Uv<R>) -> Located<R> {
        let cell = self.cell(uv);
        let tried = (0..FACES).fold(Tried::none(), |tried, face| {
            self.try_face(face, uv, cell, tried)
        });
        self.located(uv, tried)
    }

    /// The column and row of an atlas.
    #[inline(always)]
    fn cell<R: Real>(self, uv: Uv<R>) -> [R; 2] {
        let one = R::ONE;
        let cell = |x: R, cells: R| {
            let cell = (x * cells).floor();
            R::choose(cell.more(cells - one), cells - one, cell)
        };
        [
            cell(uv.u, R::new(self.columns)),
            cell(uv.v, R::new(self.rows)),
        ]
    }

    #[inline(always)]
    fn try_face<R: Real>(
        self,
        face: usize,
        uv: Uv<R>,
        [column, row]: [R; 2],
        mut tried: Tried<R>,
    ) -> Tried<R> {
        let (along, down) = (
            self.sides[face % FACES].of::<R>(0),
            self.sides[face % FACES].of::<R>(1),
        );
        let here = if ATLAS {
            column.equals(along.cell) & row.equals(down.cell)
        } else {
            uv.face.equals(R::new(self.stored[face % FACES]))
        };
        let a = ((uv.u - along.high) - along.low) * R::new(self.columns) * along.sign;
        let b = ((uv.v - down.high) - down.low) * R::new(self.rows) * down.sign;
        let (a, b) = (a.clamped(0.0, 1.0), b.clamped(0.0, 1.0));
        let turned = R::new(self.swap[face % FACES]);
        let swapped = turned.more(R::ZERO);
        let place = &mut tried.place;
        place.u = R::choose(here, R::choose(swapped, b, a), place.u);
        place.v = R::choose(here, R::choose(swapped, a, b), place.v);
        place.face = R::choose(here, R::new(face as f64), place.face);
        let [along_sign, down_sign] = tried.signs;
        tried.signs = [
            R::choose(here, along.sign, along_sign),
            R::choose(here, down.sign, down_sign),
        ];
        tried.swap = R::choose(here, turned, tried.swap);
        tried.found = tried.found | here;
        tried
    }

    #[inline(always)]
    fn located<R: Real>(self, uv: Uv<R>, tried: Tried<R>) -> Located<R> {
        let [along_sign, down_sign] = tried.signs;
        Located {
            place: tried.place,
            found: tried.found & uv.in_bounds(1),
            slope: [
                R::new(self.columns) * along_sign,
                R::new(self.rows) * down_sign,
            ],
            swapped: tried.swap.more(R::ZERO),
        }
    }

    /// A place on a canonical face to the stored image's coordinates.
    #[inline(always)]
    fn store<R: Real>(self, [u, v, face]: [R; 3]) -> [R; 3] {
        let mut kept = self.kept(0);
        macro_rules! choose {
            ($($face:literal),+) => {$(
                if $face < FACES {
                    kept = self.choose_face($face, face, kept);
                }
            )+};
        }
        choose!(1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11);
        self.stored([u, v], kept)
    }

    /// The same, face after face.
    fn store_one<R: Real>(self, [u, v, face]: [R; 3]) -> [R; 3] {
        let kept = (1..FACES).fold(self.kept(0), |kept, k| self.choose_face(k, face, kept));
        self.stored([u, v], kept)
    }

    /// How a face is stored.
    #[inline(always)]
    fn kept<R: Real>(self, face: usize) -> Kept<R> {
        Kept {
            along: self.sides[face % FACES].of(0),
            down: self.sides[face % FACES].of(1),
            swap: R::new(self.swap[face % FACES]),
            stored: R::new(self.stored[face % FACES]),
        }
    }

    #[inline(always)]
    fn choose_face<R: Real>(self, number: usize, face: R, kept: Kept<R>) -> Kept<R> {
        let here = face.equals(R::new(number as f64));
        let own = self.kept::<R>(number);
        Kept {
            along: choose_side(here, own.along, kept.along),
            down: choose_side(here, own.down, kept.down),
            swap: R::choose(here, own.swap, kept.swap),
            stored: R::choose(here, own.stored, kept.stored),
        }
    }

    #[inline(always)]
    fn stored<R: Real>(self, [u, v]: [R; 2], kept: Kept<R>) -> [R; 3] {
        let swapped = kept.swap.more(R::ZERO);
        let (u, v) = (R::choose(swapped, v, u), R::choose(swapped, u, v));
        // NaN passes both comparisons.
        let at = |x: R, side: Side<R>, cells: f64| {
            let x = side.high + (side.low + side.sign * x / R::new(cells));
            let x = R::choose(x.more(side.last), side.last, x);
            R::choose(x.less(side.first), side.first, x)
        };
        let (u, v) = (at(u, kept.along, self.columns), at(v, kept.down, self.rows));
        [u, v, R::choose(u.is_nan(), u, kept.stored)]
    }

    /// The stored image's coordinates to a place on a canonical face, NaN where there is none.
    #[inline(always)]
    fn locate<R: Real>(self, [u, v, face]: [R; 3]) -> [R; 3] {
        self.place(Uv { u, v, face }).or_nan()
    }

    /// The same, face after face.
    fn locate_one<R: Real>(self, [u, v, face]: [R; 3]) -> [R; 3] {
        self.place_one(Uv { u, v, face }).or_nan()
    }
}

#[inline(always)]
fn choose_side<R: Real>(first: R::Mask, a: Side<R>, b: Side<R>) -> Side<R> {
    Side {
        sign: R::choose(first, a.sign, b.sign),
        high: R::choose(first, a.high, b.high),
        low: R::choose(first, a.low, b.low),
        first: R::choose(first, a.first, b.first),
        last: R::choose(first, a.last, b.last),
        cell: b.cell,
    }
}

#[derive(Clone, Copy)]
struct Store<const FACES: usize, const ATLAS: bool>(LaidOut<FACES, ATLAS>);

impl<R: Real, const FACES: usize, const ATLAS: bool, const O: usize> Point<R, 3, O>
    for Store<FACES, ATLAS>
{
    #[inline(always)]
    fn apply(self, x: [R; 3]) -> [R; O] {
        let all = self.0.store(x);
        std::array::from_fn(|k| all[k])
    }
}

#[derive(Clone, Copy)]
struct Locate<const FACES: usize, const ATLAS: bool>(LaidOut<FACES, ATLAS>);

impl<R: Real, const FACES: usize, const ATLAS: bool, const I: usize> Point<R, I, 3>
    for Locate<FACES, ATLAS>
{
    #[inline(always)]
    fn apply(self, x: [R; I]) -> [R; 3] {
        let face = if I > 2 { x[2] } else { R::ZERO };
        self.0.locate([x[0], x[1], face])
    }
}

/// Chooses the smallest room for the faces.
macro_rules! with_room {
    ($face_layout:expr, |$arranged:ident| $atlas:expr, $apart:expr) => {
        match ($face_layout.faces, $face_layout.is_atlas) {
            (..=2, true) => {
                let $arranged = LaidOut::<2, true>::new($face_layout);
                $atlas
            }
            (..=2, false) => {
                let $arranged = LaidOut::<2, false>::new($face_layout);
                $apart
            }
            (..=6, true) => {
                let $arranged = LaidOut::<6, true>::new($face_layout);
                $atlas
            }
            (..=6, false) => {
                let $arranged = LaidOut::<6, false>::new($face_layout);
                $apart
            }
            (_, true) => {
                let $arranged = LaidOut::<MAX_FACES, true>::new($face_layout);
                $atlas
            }
            (_, false) => {
                let $arranged = LaidOut::<MAX_FACES, false>::new($face_layout);
                $apart
            }
        }
    };
}

/// Directions to the stored image's coordinates: `encode` computes canonical (u, v, face) of a block.
pub fn store<R: Scalar>(
    face_layout: &FaceLayout,
    directions: &[R],
    uv: &mut [R],
    encode: &dyn Fn(&[R], &mut [R]),
) {
    fn blocks<R: Scalar>(
        width: usize,
        directions: &[R],
        uv: &mut [R],
        encode: &dyn Fn(&[R], &mut [R]),
        store: impl Fn(&[R], &mut [R]),
    ) {
        let mut canonical = [R::default(); 3 * TILE];
        let blocks = directions.chunks(3 * TILE);
        for (directions, uv) in blocks.zip(uv.chunks_mut(width * TILE)) {
            let canonical = &mut canonical[..directions.len()];
            encode(directions, canonical);
            store(canonical, uv);
        }
    }
    with_room!(
        face_layout,
        |arranged| blocks(2, directions, uv, encode, |from, to| {
            let (from, to) = (Tuples::of(from), TuplesMut::of(to));
            kernel::run::<R, _, 3, 2>(Store(arranged), &Frame::plain(), from, to);
        }),
        blocks(3, directions, uv, encode, |from, to| {
            let (from, to) = (Tuples::of(from), TuplesMut::of(to));
            kernel::run::<R, _, 3, 3>(Store(arranged), &Frame::plain(), from, to);
        })
    );
}

/// The stored image's coordinates to canonical (u, v, face), NaN where there is no face; block by block,
/// `work(first, canonical)` with the number of the block's first place.
pub fn locate<R: Scalar>(face_layout: &FaceLayout, uv: &[R], work: &mut dyn FnMut(usize, &[R])) {
    fn blocks<R: Scalar>(
        width: usize,
        uv: &[R],
        work: &mut dyn FnMut(usize, &[R]),
        locate: impl Fn(&[R], &mut [R]),
    ) {
        let mut canonical = [R::default(); 3 * TILE];
        for (number, uv) in uv.chunks(width * TILE).enumerate() {
            let canonical = &mut canonical[..3 * (uv.len() / width)];
            locate(uv, canonical);
            work(number * TILE, canonical);
        }
    }
    with_room!(
        face_layout,
        |arranged| blocks(2, uv, work, |from, to| {
            let (from, to) = (Tuples::of(from), TuplesMut::of(to));
            kernel::run::<R, _, 2, 3>(Locate(arranged), &Frame::plain(), from, to);
        }),
        blocks(3, uv, work, |from, to| {
            let (from, to) = (Tuples::of(from), TuplesMut::of(to));
            kernel::run::<R, _, 3, 3>(Locate(arranged), &Frame::plain(), from, to);
        })
    );
}

/// One canonical (u, v, face) to the stored image's coordinates.
pub fn store_one<R: Real>(face_layout: &FaceLayout, canonical: [R; 3]) -> [R; 3] {
    with_room!(
        face_layout,
        |arranged| arranged.store_one(canonical),
        arranged.store_one(canonical)
    )
}

/// The stored image's coordinates of one place to canonical (u, v, face), NaN where there is no face.
pub fn locate_one<R: Real>(face_layout: &FaceLayout, uv: [R; 3]) -> [R; 3] {
    with_room!(
        face_layout,
        |arranged| arranged.locate_one(uv),
        arranged.locate_one(uv)
    )
}

/// The place on a canonical face, and how it changes with the stored image's coordinates.
pub fn place_one<R: Real>(face_layout: &FaceLayout, uv: Uv<R>) -> Located<R> {
    with_room!(
        face_layout,
        |arranged| arranged.place_one(uv),
        arranged.place_one(uv)
    )
}

/// Makes derivatives by canonical (u, v), as rows of two, derivatives by the stored image's coordinates.
pub fn scale_derivatives<R: Scalar>(face_layout: &FaceLayout, uv: &[R], jacobians: &mut [R]) {
    fn scale<R: Scalar>(
        width: usize,
        uv: &[R],
        jacobians: &mut [R],
        locate: impl Fn(Uv<R>) -> Located<R>,
    ) {
        for (uv, jacobian) in uv.chunks_exact(width).zip(jacobians.chunks_exact_mut(6)) {
            let at = locate(Uv {
                u: uv[0],
                v: uv[1],
                face: if width > 2 { uv[2] } else { R::ZERO },
            });
            for row in jacobian.as_chunks_mut::<2>().0 {
                let (along, down) = if at.swapped {
                    (row[1], row[0])
                } else {
                    (row[0], row[1])
                };
                *row = [along * at.slope[0], down * at.slope[1]];
            }
        }
    }
    with_room!(
        face_layout,
        |arranged| scale(2, uv, jacobians, |uv| arranged.place(uv)),
        scale(3, uv, jacobians, |uv| arranged.place(uv))
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projections::Cube;
    use crate::projections::faces::{CROSS, Cells, FaceTable, VERTICAL_CROSS};
    use crate::projections::projection::Projection;

    #[test]
    fn the_cross_is_continuous_where_cells_touch() {
        for cells in [Cells::Grid(4, 3, CROSS), Cells::Grid(3, 4, VERTICAL_CROSS)] {
            let face_layout = FaceLayout::new(6, FaceTable::CANONICAL, cells);
            let arranged = LaidOut::<6, true>::new(&face_layout);
            let (columns, rows) = (face_layout.columns as f64, face_layout.rows as f64);
            let mut shared = 0;
            for column in 0..face_layout.columns {
                for row in 0..face_layout.rows {
                    for (du, dv) in [(1.0, 0.5), (0.5, 1.0)] {
                        let at = |offset: f64| {
                            let (eu, ev) = if du == 1.0 {
                                (offset, 0.0)
                            } else {
                                (0.0, offset)
                            };
                            arranged.place(Uv::flat(
                                (column as f64 + du + eu) / columns,
                                (row as f64 + dv + ev) / rows,
                            ))
                        };
                        let (a, b) = (at(-1e-9), at(1e-9));
                        if a.found && b.found {
                            let (a, b) = (Cube.decode(a.place), Cube.decode(b.place));
                            let dot: f64 = (0..3).map(|k| a[k] * b[k]).sum();
                            assert!(dot > 1.0 - 1e-12);
                            shared += 1;
                        }
                    }
                }
            }
            assert_eq!(shared, 5, "six faces that hang together share five edges");
        }
    }
}
