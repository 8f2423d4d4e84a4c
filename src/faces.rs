//! Several faces and where they lie.
//!
//! A projection numbers its faces in its own, canonical order and draws each in its own orientation.
//! A convention may store them in another order, each turned or flipped; a layout may put them side by
//! side in one image. Both are the same thing, an [`Arrangement`]: for each canonical face its
//! [`Place`]. [`Arranged`] wraps a projection with it and is a projection again, so every verb works
//! on every layout.
//!
//! Cells of a layout that hold no face are not part of the valid image.

use crate::light::solid_angle::Rect;
use crate::projection::{Coverage, Info, Outline, Projection, Seam, Uv};
use crate::real::Real;

/// The most faces that a projection may have.
pub const MAX_FACES: usize = 12;

/// One of the eight ways to put a square on itself: exchange u and v, then flip each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Orientation {
    /// u and v change places.
    pub swap: bool,
    /// Then u runs backwards.
    pub flip_u: bool,
    /// Then v runs backwards.
    pub flip_v: bool,
}

impl Orientation {
    /// As it is.
    pub const UPRIGHT: Orientation = Orientation {
        swap: false,
        flip_u: false,
        flip_v: false,
    };
    /// Half a turn.
    pub const TURNED: Orientation = Orientation {
        swap: false,
        flip_u: true,
        flip_v: true,
    };

    /// First `self`, then `next`.
    pub fn then(self, next: Orientation) -> Orientation {
        let (u, v) = if next.swap {
            (self.flip_v, self.flip_u)
        } else {
            (self.flip_u, self.flip_v)
        };
        Orientation {
            swap: self.swap ^ next.swap,
            flip_u: u ^ next.flip_u,
            flip_v: v ^ next.flip_v,
        }
    }
}

/// Where a layout puts one canonical face.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Cells from the left.
    pub column: u8,
    /// Cells from the top.
    pub row: u8,
    /// How the face lies in it.
    pub orientation: Orientation,
}

/// A named way to lay out faces.
#[derive(Clone, Copy, Debug)]
pub struct LayoutSpec {
    /// The name.
    pub name: &'static str,
    /// How the faces lie.
    pub cells: Cells,
}

/// How the faces of a layout lie.
#[derive(Clone, Copy, Debug)]
pub enum Cells {
    /// An array of images; no neighbours.
    Apart,
    /// One image, from left to right in stored order.
    Row,
    /// One image, from top to bottom in stored order.
    Column,
    /// One image of so many columns and rows, filled row by row in stored order.
    Block(u8, u8),
    /// One image, each canonical face in its cell of a grid of so many columns and rows.
    Grid(u8, u8, &'static [Cell]),
}

const fn cell(column: u8, row: u8) -> Cell {
    Cell {
        column,
        row,
        orientation: Orientation::UPRIGHT,
    }
}

/// The layouts that any projection of several faces has.
pub const STRIP_AND_COLUMN: &[LayoutSpec] = &[
    LayoutSpec {
        name: "faces",
        cells: Cells::Apart,
    },
    LayoutSpec {
        name: "strip",
        cells: Cells::Row,
    },
    LayoutSpec {
        name: "column",
        cells: Cells::Column,
    },
];

/// Left, front, right, back in a row with up and down over and under front: neighbours in the picture
/// are neighbours on the cube.
const CROSS: &[Cell] = &[
    cell(2, 1),
    cell(0, 1),
    cell(1, 0),
    cell(1, 2),
    cell(1, 1),
    cell(3, 1),
];

/// Up, front, down, back in a column, left and right beside front. Back continues down and so stands
/// on its head.
const VERTICAL_CROSS: &[Cell] = &[
    cell(2, 1),
    cell(0, 1),
    cell(1, 0),
    cell(1, 2),
    cell(1, 1),
    Cell {
        column: 1,
        row: 3,
        orientation: Orientation::TURNED,
    },
];

/// The same column with back not turned: as six images are pasted, not as a box unfolds.
const VERTICAL_CROSS_UPRIGHT: &[Cell] = &[
    cell(2, 1),
    cell(0, 1),
    cell(1, 0),
    cell(1, 2),
    cell(1, 1),
    cell(1, 3),
];

/// Front, right, back, left in a row, up and down over and under front: a T on its side.
const TEE: &[Cell] = &[
    cell(1, 1),
    cell(3, 1),
    cell(0, 0),
    cell(0, 2),
    cell(0, 1),
    cell(2, 1),
];

/// The layouts of a cube. `dice` is the name that panorama tools give the cross.
pub const CUBE_LAYOUTS: &[LayoutSpec] = &[
    STRIP_AND_COLUMN[0],
    STRIP_AND_COLUMN[1],
    STRIP_AND_COLUMN[2],
    LayoutSpec {
        name: "cross",
        cells: Cells::Grid(4, 3, CROSS),
    },
    LayoutSpec {
        name: "vertical_cross",
        cells: Cells::Grid(3, 4, VERTICAL_CROSS),
    },
    LayoutSpec {
        name: "dice",
        cells: Cells::Grid(4, 3, CROSS),
    },
    LayoutSpec {
        name: "vertical_cross_upright",
        cells: Cells::Grid(3, 4, VERTICAL_CROSS_UPRIGHT),
    },
    LayoutSpec {
        name: "tee",
        cells: Cells::Grid(4, 3, TEE),
    },
    LayoutSpec {
        name: "3x2",
        cells: Cells::Block(3, 2),
    },
];

/// The order and orientation in which a program stores the faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FaceTable {
    /// `stored[f]` is the number under which canonical face f is stored.
    pub stored: [u8; MAX_FACES],
    /// How canonical face f is drawn.
    pub orientation: [Orientation; MAX_FACES],
}

impl FaceTable {
    /// Stored as the projection itself numbers and draws them.
    pub const CANONICAL: FaceTable = FaceTable {
        stored: [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11],
        orientation: [Orientation::UPRIGHT; MAX_FACES],
    };

    /// `stored` are the numbers under which the first canonical faces are stored, each as it is drawn.
    pub const fn ordered(stored: &[u8]) -> FaceTable {
        let mut table = FaceTable::CANONICAL;
        let mut face = 0;
        while face < stored.len() {
            table.stored[face] = stored[face];
            face += 1;
        }
        table
    }
}

/// Where one canonical face lies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Place {
    /// The stored face's number, where faces are apart.
    pub stored: usize,
    /// Cells from the left.
    pub column: usize,
    /// Cells from the top.
    pub row: usize,
    /// How it is drawn.
    pub orientation: Orientation,
    // Found once here: it takes searches, and kernels are called block by block.
    sides: Sides,
}

/// Where every face lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrangement {
    /// How many faces there are.
    pub faces: usize,
    /// Whether they share one image.
    pub joined: bool,
    /// Cells in a row of the image.
    pub columns: usize,
    /// Rows of cells.
    pub rows: usize,
    /// The place of each canonical face.
    pub places: [Place; MAX_FACES],
}

impl Arrangement {
    /// One face, as it is.
    pub fn single() -> Arrangement {
        Arrangement::new(1, FaceTable::CANONICAL, Cells::Row)
    }

    /// The faces of a program's table in a layout.
    pub fn new(faces: usize, table: FaceTable, cells: Cells) -> Arrangement {
        let (columns, rows) = match cells {
            Cells::Apart => (1, 1),
            Cells::Row => (faces, 1),
            Cells::Column => (1, faces),
            Cells::Block(columns, rows) | Cells::Grid(columns, rows, _) => {
                (columns as usize, rows as usize)
            }
        };
        let mut places = [Place::default(); MAX_FACES];
        for (face, place) in places.iter_mut().enumerate().take(faces) {
            let stored = table.stored[face] as usize;
            let (column, row, turned) = match cells {
                Cells::Apart => (0, 0, Orientation::UPRIGHT),
                Cells::Row => (stored, 0, Orientation::UPRIGHT),
                Cells::Column => (0, stored, Orientation::UPRIGHT),
                Cells::Block(columns, _) => {
                    let columns = columns as usize;
                    (stored % columns, stored / columns, Orientation::UPRIGHT)
                }
                Cells::Grid(_, _, cells) => {
                    let cell = cells[face];
                    (cell.column as usize, cell.row as usize, cell.orientation)
                }
            };
            let orientation = table.orientation[face].then(turned);
            let (flip_u, flip_v) = (orientation.flip_u, orientation.flip_v);
            *place = Place {
                stored,
                column,
                row,
                orientation,
                sides: Sides {
                    single: [
                        side_f32(column, columns, flip_u),
                        side_f32(row, rows, flip_v),
                    ],
                    double: [
                        side_f64(column, columns, flip_u),
                        side_f64(row, rows, flip_v),
                    ],
                },
            };
        }
        Arrangement {
            faces,
            joined: !matches!(cells, Cells::Apart),
            columns,
            rows,
            places,
        }
    }

    /// Whether coordinates are the projection's own.
    pub fn is_canonical(&self) -> bool {
        let as_is = |(face, place): (usize, &Place)| {
            place.stored == face && place.orientation == Orientation::UPRIGHT
        };
        self.faces == 1 || !self.joined && self.places[..self.faces].iter().enumerate().all(as_is)
    }
}

/// How one coordinate of a face lies along one side of the joined image.
///
/// place = start + sign · coordinate / cells. The start, a multiple of 1/cells, is kept in two parts, and the
/// place is held to the numbers that fall into its own cell when they are multiplied by the number of
/// cells: so a coordinate on the border of a cell comes back on the face that it left from, and
/// joining faces costs one rounding.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Side<R> {
    sign: R,
    high: R,
    low: R,
    first: R,
    last: R,
    cell: R,
}

/// The sides of a face along u and v, for each float type.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Sides {
    single: [Side<f32>; 2],
    double: [Side<f64>; 2],
}

macro_rules! side {
    ($name:ident, $t:ty) => {
        fn $name(cell: usize, cells: usize, flip: bool) -> Side<$t> {
            let n = cells as $t;
            let start = (cell + usize::from(flip)) as $t;
            let high = start / n;
            // The remainder of the division is a float, so this is its exact quotient, rounded.
            let low = -high.mul_add(n, -start) / n;
            // In this arithmetic and in exact arithmetic, so that any other decoder agrees.
            let holds = |x: $t| {
                let (from, to) = (cell as $t, (cell + 1) as $t);
                (x * n) as usize == cell && x.mul_add(n, -from) >= 0.0 && x.mul_add(n, -to) < 0.0
            };
            let (mut first, mut last) = (cell as $t / n, (cell + 1) as $t / n);
            while !holds(first) {
                first = first.next_up();
            }
            while cell + 1 < cells && !holds(last) {
                last = last.next_down();
            }
            Side {
                sign: if flip { -1.0 } else { 1.0 },
                high,
                low,
                first,
                last,
                cell: cell as $t,
            }
        }
    };
}
side!(side_f32, f32);
side!(side_f64, f64);

impl Sides {
    #[inline(always)]
    fn of<R: Real>(&self, axis: usize) -> Side<R> {
        let convert = |sign: f64, high: f64, low: f64, first: f64, last: f64, cell: f64| Side {
            sign: R::new(sign),
            high: R::new(high),
            low: R::new(low),
            first: R::new(first),
            last: R::new(last),
            cell: R::new(cell),
        };
        if R::EPSILON > 1e-10 {
            let s = &self.single[axis];
            let [sign, high, low] = [s.sign, s.high, s.low].map(f64::from);
            let [first, last, cell] = [s.first, s.last, s.cell].map(f64::from);
            convert(sign, high, low, first, last, cell)
        } else {
            let s = &self.double[axis];
            convert(s.sign, s.high, s.low, s.first, s.last, s.cell)
        }
    }
}

/// A projection whose faces are arranged: JOINED in one image, or apart in another order.
#[derive(Clone, Copy)]
pub struct Arranged<P, const JOINED: bool> {
    projection: P,
    columns: f64,
    rows: f64,
    stored: [f64; MAX_FACES],
    sides: [Sides; MAX_FACES],
    swap: [f64; MAX_FACES],
}

impl<P: Projection, const JOINED: bool> Arranged<P, JOINED> {
    /// `projection` in an arrangement.
    pub fn new(projection: P, arrangement: &Arrangement) -> Self {
        let mut arranged = Arranged {
            projection,
            columns: arrangement.columns as f64,
            rows: arrangement.rows as f64,
            stored: [-1.0; MAX_FACES],
            sides: arrangement.places.map(|place| place.sides),
            swap: [0.0; MAX_FACES],
        };
        for (face, place) in arrangement.places[..P::INFO.faces].iter().enumerate() {
            arranged.stored[face] = place.stored as f64;
            arranged.swap[face] = f64::from(u8::from(place.orientation.swap));
        }
        arranged
    }

    /// The place on a face at `uv`, if one is there.
    #[inline(always)]
    fn locate<R: Real>(self, uv: Uv<R>) -> Located<R> {
        let one = R::new(1.0);
        let (columns, rows) = (R::new(self.columns), R::new(self.rows));
        let cell = |x: R, cells: R| {
            let cell = (x * cells).floor();
            if cell > cells - one {
                cells - one
            } else {
                cell
            }
        };
        let (column, row) = (cell(uv.u, columns), cell(uv.v, rows));
        let nan = R::new(f64::NAN);
        let mut place = Uv {
            u: nan,
            v: nan,
            face: nan,
        };
        let (mut along_sign, mut down_sign, mut swap) = (nan, nan, nan);
        let mut found = false;
        // Each face's place is computed and one is chosen: choosing the constants first saves the
        // arithmetic, but the compiler makes branches of it.
        macro_rules! try_face {
            ($($face:literal),+) => {$(
                if $face < P::INFO.faces {
                    let (along, down) = (self.sides[$face].of::<R>(0), self.sides[$face].of::<R>(1));
                    let here = if JOINED {
                        (column == along.cell) & (row == down.cell)
                    } else {
                        uv.face == R::new(self.stored[$face])
                    };
                    let a = ((uv.u - along.high) - along.low) * columns * along.sign;
                    let b = ((uv.v - down.high) - down.low) * rows * down.sign;
                    let (a, b) = (a.clamped(0.0, 1.0), b.clamped(0.0, 1.0));
                    let turned = R::new(self.swap[$face]);
                    let swapped = turned > R::new(0.0);
                    place.u = if here { if swapped { b } else { a } } else { place.u };
                    place.v = if here { if swapped { a } else { b } } else { place.v };
                    place.face = if here { R::new($face as f64) } else { place.face };
                    along_sign = if here { along.sign } else { along_sign };
                    down_sign = if here { down.sign } else { down_sign };
                    swap = if here { turned } else { swap };
                    found |= here;
                }
            )+};
        }
        try_face!(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11);
        Located {
            place,
            found,
            slope: [columns * along_sign, rows * down_sign],
            swapped: swap > R::new(0.0),
        }
    }
}

/// A place on a canonical face.
struct Located<R> {
    place: Uv<R>,
    found: bool,
    /// How fast the face's coordinates along the image's u and v change.
    slope: [R; 2],
    swapped: bool,
}

impl<P: Projection, const JOINED: bool> Projection for Arranged<P, JOINED> {
    const INFO: Info = Info {
        faces: if JOINED { 1 } else { P::INFO.faces },
        outline: Outline::Square,
        ..P::INFO
    };

    fn with_parameters(_: &[f64]) -> Self {
        unreachable!("arranged projections are not in the registry")
    }

    fn coverage(self) -> Coverage {
        self.projection.coverage()
    }

    fn density_range(self) -> (f64, f64) {
        let (low, high) = self.projection.density_range();
        let cells = if JOINED {
            self.columns * self.rows
        } else {
            1.0
        };
        (low * cells, high * cells)
    }

    fn seam(self) -> Seam {
        self.projection.seam()
    }

    #[inline(always)]
    fn encode<R: Real>(self, d: [R; 3]) -> Uv<R> {
        let uv = self.projection.encode(d);
        let (mut along, mut down) = (self.sides[0].of::<R>(0), self.sides[0].of::<R>(1));
        let mut swap = R::new(self.swap[0]);
        let mut stored = R::new(self.stored[0]);
        macro_rules! choose {
            ($($face:literal),+) => {$(
                if $face < P::INFO.faces {
                    let here = uv.face == R::new($face as f64);
                    along = choose_side(here, self.sides[$face].of(0), along);
                    down = choose_side(here, self.sides[$face].of(1), down);
                    swap = if here { R::new(self.swap[$face]) } else { swap };
                    stored = if here { R::new(self.stored[$face]) } else { stored };
                }
            )+};
        }
        choose!(1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11);
        let swapped = swap > R::new(0.0);
        let (u, v) = (
            if swapped { uv.v } else { uv.u },
            if swapped { uv.u } else { uv.v },
        );
        let at = |x: R, side: Side<R>, cells: f64| {
            let x = side.high + (side.low + side.sign * x / R::new(cells));
            let x = if x > side.last { side.last } else { x };
            if x < side.first { side.first } else { x }
        };
        let (u, v) = (at(u, along, self.columns), at(v, down, self.rows));
        if JOINED {
            Uv::flat(u, v)
        } else {
            Uv { u, v, face: stored }
        }
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        self.projection.decode(self.locate(uv).place)
    }

    #[inline(always)]
    fn contains<R: Real>(self, uv: Uv<R>) -> bool {
        let (zero, one) = (R::new(0.0), R::new(1.0));
        let in_square = (uv.u >= zero) & (uv.u <= one) & (uv.v >= zero) & (uv.v <= one);
        let at = self.locate(uv);
        in_square & at.found & self.projection.contains(at.place)
    }

    #[inline(always)]
    fn jacobian<R: Real>(self, uv: Uv<R>) -> [[R; 3]; 2] {
        let at = self.locate(uv);
        let [a, b] = self.projection.jacobian(at.place);
        let along = if at.swapped { b } else { a };
        let down = if at.swapped { a } else { b };
        [
            along.map(|x| x * at.slope[0]),
            down.map(|x| x * at.slope[1]),
        ]
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        self.projection.solid_angle(rect)
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        let cells = if JOINED {
            self.columns * self.rows
        } else {
            1.0
        };
        self.projection.density(self.locate(uv).place) * R::new(cells)
    }
}

#[inline(always)]
fn choose_side<R: Real>(first: bool, a: Side<R>, b: Side<R>) -> Side<R> {
    Side {
        sign: if first { a.sign } else { b.sign },
        high: if first { a.high } else { b.high },
        low: if first { a.low } else { b.low },
        first: if first { a.first } else { b.first },
        last: if first { a.last } else { b.last },
        cell: b.cell,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projections::Cube;

    #[test]
    fn orientations_compose_like_maps() {
        let apply = |o: Orientation, (u, v): (i32, i32)| {
            let (u, v) = if o.swap { (v, u) } else { (u, v) };
            (if o.flip_u { -u } else { u }, if o.flip_v { -v } else { v })
        };
        let all: Vec<Orientation> = (0..8)
            .map(|b| Orientation {
                swap: b & 1 != 0,
                flip_u: b & 2 != 0,
                flip_v: b & 4 != 0,
            })
            .collect();
        for &a in &all {
            for &b in &all {
                assert_eq!(apply(a.then(b), (1, 2)), apply(b, apply(a, (1, 2))));
            }
        }
    }

    #[test]
    fn the_cross_is_continuous_where_cells_touch() {
        for cells in [Cells::Grid(4, 3, CROSS), Cells::Grid(3, 4, VERTICAL_CROSS)] {
            let arrangement = Arrangement::new(6, FaceTable::CANONICAL, cells);
            let arranged = Arranged::<Cube, true>::new(Cube, &arrangement);
            let (columns, rows) = (arrangement.columns as f64, arrangement.rows as f64);
            let mut shared = 0;
            for column in 0..arrangement.columns {
                for row in 0..arrangement.rows {
                    for (du, dv) in [(1.0, 0.5), (0.5, 1.0)] {
                        let at = |offset: f64| {
                            let (eu, ev) = if du == 1.0 {
                                (offset, 0.0)
                            } else {
                                (0.0, offset)
                            };
                            Uv::flat(
                                (column as f64 + du + eu) / columns,
                                (row as f64 + dv + ev) / rows,
                            )
                        };
                        let (a, b) = (at(-1e-9), at(1e-9));
                        if arranged.contains(a) && arranged.contains(b) {
                            let (a, b) = (arranged.decode(a), arranged.decode(b));
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
