//! Several faces and where they lie.
//!
//! A projection numbers its faces in its own, canonical order and draws each in its own orientation.
//! A convention may store them in another order, each turned or flipped; a layout may put them side by
//! side in one image. Both are the same thing, an [`FaceLayout`]: for each canonical face its
//! [`FacePlacement`]. [`crate::map::layout`] takes coordinates there and back, so every verb works on every layout.
//!
//! Cells of a layout that hold no face are not part of the valid image.

use crate::number::real::Real;

/// The most faces that a projection may have.
pub const MAX_FACES: usize = 12;

/// One of the eight ways to put a square on itself: exchange u and v, then flip each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Orientation {
    /// u and v change places.
    pub swap: bool,
    /// Then u runs backward.
    pub flip_u: bool,
    /// Then v runs backward.
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
    pub(crate) fn then(self, next: Orientation) -> Orientation {
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
pub struct LayoutCell {
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
    /// An array of images; no neighbors.
    Apart,
    /// One image, from left to right in stored order.
    Row,
    /// One image, from top to bottom in stored order.
    Column,
    /// One image of so many columns and rows, filled row by row in stored order.
    Block(u8, u8),
    /// One image, each canonical face in its cell of a grid of so many columns and rows.
    Grid(u8, u8, &'static [LayoutCell]),
}

const fn cell(column: u8, row: u8) -> LayoutCell {
    LayoutCell {
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

/// Left, front, right, back in a row with up and down over and under front: neighbors in the picture
/// are neighbors on the cube.
pub(crate) const CROSS: &[LayoutCell] = &[
    cell(2, 1),
    cell(0, 1),
    cell(1, 0),
    cell(1, 2),
    cell(1, 1),
    cell(3, 1),
];

/// Up, front, down, back in a column, left and right beside front. Back continues down and so stands
/// on its head.
pub(crate) const VERTICAL_CROSS: &[LayoutCell] = &[
    cell(2, 1),
    cell(0, 1),
    cell(1, 0),
    cell(1, 2),
    cell(1, 1),
    LayoutCell {
        column: 1,
        row: 3,
        orientation: Orientation::TURNED,
    },
];

/// The same column with back not turned: as six images are pasted, not as a box unfolds.
const VERTICAL_CROSS_UPRIGHT: &[LayoutCell] = &[
    cell(2, 1),
    cell(0, 1),
    cell(1, 0),
    cell(1, 2),
    cell(1, 1),
    cell(1, 3),
];

/// Front, right, back, left in a row, up and down over and under front: a T on its side.
const TEE: &[LayoutCell] = &[
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
    ///
    /// # Panics
    /// There are more than 12.
    ///
    /// ```
    /// use spheremap::projections::FaceTable;
    /// assert_eq!(FaceTable::ordered(&[1, 0]).stored[..3], [1, 0, 2]);
    /// ```
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
pub struct FacePlacement {
    /// The stored face's number, where faces are apart.
    pub stored: usize,
    /// Cells from the left.
    pub column: usize,
    /// Cells from the top.
    pub row: usize,
    /// How it is drawn.
    pub orientation: Orientation,
    // Found once here: it takes searches, and kernels are called block by block.
    pub(crate) sides: Sides,
}

/// Where every face lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceLayout {
    /// How many faces there are.
    pub faces: usize,
    /// Whether they share one image.
    pub is_atlas: bool,
    /// Cells in a row of the image.
    pub columns: usize,
    /// Rows of cells.
    pub rows: usize,
    /// The place of each canonical face.
    pub places: [FacePlacement; MAX_FACES],
}

impl FaceLayout {
    /// One face, as it is.
    pub(crate) fn single() -> FaceLayout {
        FaceLayout::new(1, FaceTable::CANONICAL, Cells::Row)
    }

    /// The faces of a program's table in a layout.
    pub(crate) fn new(faces: usize, table: FaceTable, cells: Cells) -> FaceLayout {
        let (columns, rows) = match cells {
            Cells::Apart => (1, 1),
            Cells::Row => (faces, 1),
            Cells::Column => (1, faces),
            Cells::Block(columns, rows) | Cells::Grid(columns, rows, _) => {
                (columns as usize, rows as usize)
            }
        };
        let mut places = [FacePlacement::default(); MAX_FACES];
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
            *place = FacePlacement {
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
        FaceLayout {
            faces,
            is_atlas: !matches!(cells, Cells::Apart),
            columns,
            rows,
            places,
        }
    }

    /// Whether coordinates are the projection's own.
    pub(crate) fn is_canonical(&self) -> bool {
        let as_is = |(face, place): (usize, &FacePlacement)| {
            place.stored == face && place.orientation == Orientation::UPRIGHT
        };
        self.faces == 1 || !self.is_atlas && self.places[..self.faces].iter().enumerate().all(as_is)
    }
}

/// How one coordinate of a face lies along one side of the joined image.
///
/// place = start + sign · coordinate / cells. The start, a multiple of 1/cells, is kept in two parts, and the
/// place is held to the numbers that fall into its own cell when they are multiplied by the number of
/// cells: so a coordinate on the border of a cell comes back on the face that it left from, and
/// joining faces costs one rounding.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Side<R> {
    pub(crate) sign: R,
    pub(crate) high: R,
    pub(crate) low: R,
    pub(crate) first: R,
    pub(crate) last: R,
    pub(crate) cell: R,
}

/// The sides of a face along u and v, for each float type.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Sides {
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
            // Not negated after the sum: some compilers make one instruction of the two, and -0 of a zero becomes 0.
            let low = high.mul_add(-n, start) / n;
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
    /// The sides of no face: no cell has this number.
    pub(crate) const NOWHERE: Sides = {
        const SINGLE: Side<f32> = Side {
            sign: 1.0,
            high: 0.0,
            low: 0.0,
            first: 0.0,
            last: 0.0,
            cell: -1.0,
        };
        const DOUBLE: Side<f64> = Side {
            sign: 1.0,
            high: 0.0,
            low: 0.0,
            first: 0.0,
            last: 0.0,
            cell: -1.0,
        };
        Sides {
            single: [SINGLE; 2],
            double: [DOUBLE; 2],
        }
    };

    #[inline(always)]
    pub(crate) fn of<R: Real>(&self, axis: usize) -> Side<R> {
        let convert = |sign: f64, high: f64, low: f64, first: f64, last: f64, cell: f64| Side {
            sign: R::new(sign),
            high: R::new(high),
            low: R::new(low),
            first: R::new(first),
            last: R::new(last),
            cell: R::new(cell),
        };
        if R::epsilon() > 1e-10 {
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
