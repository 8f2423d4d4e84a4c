//! Shapes, and where each texel of a face is stored.
//!
//! An image of several faces is seen as faces, whatever its layout: each canonical face is a strided view
//! of the stored texels ([`FaceView`]), and each stored row is a few runs of texels of one face
//! ([`Run`]). So sampling and conversion know nothing of crosses, strips, face orders and turned faces.

use crate::error::Error;
use crate::geometry::solid_angle::Rect;
use crate::map::Map;
use crate::map::grid::{Grid, GridAxis};
use crate::projections::Kind;
use crate::projections::faces::{FacePlacement, MAX_FACES};
use crate::projections::projection::one;
use crate::projections::projection::{Outline, Projection, Uv, Visitor};
use std::ops::Range;

/// Where the texels of one canonical face are stored: texel (i, j) at `start + i·along_u + j·along_v`.
#[derive(Clone, Copy, Debug, Default)]
pub struct FaceView {
    start: isize,
    along_u: isize,
    along_v: isize,
}

impl FaceView {
    /// The index of texel (i, j) of the face.
    #[inline(always)]
    pub fn index(&self, i: usize, j: usize) -> usize {
        let (right, down) = (i as isize * self.along_u, j as isize * self.along_v);
        (self.start + right + down) as usize
    }

    /// The same in a part, so many columns wide, of the image, which has `columns`: alone it is there, and begins at a row and a
    /// column.
    pub fn within(&self, columns: usize, [top, left]: [usize; 2], width: usize) -> FaceView {
        let (columns, width) = (columns as isize, width as isize);
        let (row, column) = (self.start / columns, self.start % columns);
        let step = |step: isize| {
            if step.abs() == columns {
                step.signum() * width
            } else {
                step
            }
        };
        FaceView {
            start: (row - top as isize) * width + column - left as isize,
            along_u: step(self.along_u),
            along_v: step(self.along_v),
        }
    }

    /// How far apart in the image neighbors along u and along v are.
    pub fn steps(&self) -> [isize; 2] {
        [self.along_u, self.along_v]
    }
}

/// Consecutive texels of a stored row that lie on one face, or on none.
#[derive(Clone, Copy, Debug)]
pub struct Run {
    /// The first stored column.
    pub column: usize,
    /// How many there are.
    pub length: usize,
    /// The canonical face, if any, with the first texel on it and the step to the next.
    pub face: Option<(usize, [isize; 2], [isize; 2])>,
}

/// A rectangle of texels of one face, or of none, in a band of stored rows.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// The canonical face, if any, with the first texel on it and the steps to the next one in the stored
    /// row and to the one in the next row.
    pub face: Option<(usize, [isize; 2], [[isize; 2]; 2])>,
    /// The first texel in the band.
    pub start: usize,
    /// Texels in a row.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
}

impl Block {
    /// Columns and rows of a quarter, rounded up.
    pub fn quarter(&self) -> (usize, usize) {
        (self.columns.div_ceil(2), self.rows.div_ceil(2))
    }

    /// The blocks of at most so many columns and rows that it is made of, in an image of so many columns.
    pub fn parts(
        self,
        (width, height): (usize, usize),
        columns: usize,
    ) -> impl Iterator<Item = Block> {
        self.bands(height, columns).flat_map(move |(_, band)| {
            (0..band.columns).step_by(width).map(move |first| {
                let face = band.face.map(|(face, [i, j], [right, down])| {
                    let moved = first as isize;
                    let texel = [i + moved * right[0], j + moved * right[1]];
                    (face, texel, [right, down])
                });
                Block {
                    face,
                    start: band.start + first,
                    columns: width.min(band.columns - first),
                    ..band
                }
            })
        })
    }

    /// The blocks of at most so many rows that it is made of, each with the number of its first row, in an image of
    /// so many columns.
    pub fn bands(self, rows: usize, columns: usize) -> impl Iterator<Item = (usize, Block)> {
        (0..self.rows).step_by(rows).map(move |first| {
            let face = self.face.map(|(face, [i, j], [along, down])| {
                let moved = first as isize;
                let texel = [i + moved * down[0], j + moved * down[1]];
                (face, texel, [along, down])
            });
            let band = Block {
                face,
                start: self.start + first * columns,
                rows: rows.min(self.rows - first),
                ..self
            };
            (first, band)
        })
    }
}

/// The longest side that an image may have; products of two sides then fit any counter.
pub const LONGEST_SIDE: usize = 1 << 28;

/// The geometry of an image in a map's layout.
#[derive(Clone, Copy, Debug)]
pub struct Raster {
    /// Texels along u of a face.
    pub width: usize,
    /// Texels along v of a face.
    pub height: usize,
    /// Columns of the stored image.
    pub columns: usize,
    /// Rows of the stored image, those of all faces where faces are apart.
    pub rows: usize,
    /// The grid along u.
    pub along_u: GridAxis,
    /// The grid along v.
    pub along_v: GridAxis,
    /// What part of a face holds sphere.
    pub outline: Outline,
    /// The middle and the half axes of an ellipse of places that a face holds, in p and q.
    held: Option<[[f64; 2]; 2]>,
    kind: Kind,
    faces: usize,
    is_atlas: bool,
    places: [FacePlacement; MAX_FACES],
    views: [FaceView; MAX_FACES],
}

impl Raster {
    /// The geometry of an image of this shape: (rows, columns), or (faces, rows, columns).
    pub fn new(map: &Map, shape: &[usize]) -> Result<Raster, Error> {
        let face_layout = map.face_layout();
        let expected = || Error::Shape(shape_error(map, shape));
        let (stored_faces, rows, columns) = match (face_layout.is_atlas, shape) {
            (true, &[rows, columns]) => (1, rows, columns),
            (false, &[faces, rows, columns]) if faces == face_layout.faces => {
                (faces, rows, columns)
            }
            _ => return Err(expected()),
        };
        if rows == 0
            || columns == 0
            || rows % face_layout.rows != 0
            || columns % face_layout.columns != 0
        {
            return Err(expected());
        }
        if rows > LONGEST_SIDE || columns > LONGEST_SIDE {
            return Err(Error::Shape(format!(
                "Expected an image with sides of at most {LONGEST_SIDE}, got {}.",
                tuple(shape)
            )));
        }
        let (height, width) = (rows / face_layout.rows, columns / face_layout.columns);
        if face_layout.faces > 1 && height != width {
            return Err(expected());
        }
        let corners = match map.grid() {
            Grid::Centers => false,
            Grid::Corners => width == 1 || height == 1,
            Grid::CornersV => height == 1,
        };
        if corners {
            return Err(Error::Contradiction(format!(
                "grid '{}' puts the first and last texel on opposite edges and needs at least 2 of them, \
                 got {height} rows and {width} columns",
                map.grid().name()
            )));
        }
        let (along_u, along_v) = map.grid().axes(width, height);
        let mut raster = Raster {
            width,
            height,
            columns,
            rows: rows * stored_faces,
            along_u,
            along_v,
            outline: map.outline(),
            held: map.held_ellipse(),
            kind: map.kind(),
            faces: face_layout.faces,
            is_atlas: face_layout.is_atlas,
            places: face_layout.places,
            views: [FaceView::default(); MAX_FACES],
        };
        for face in 0..raster.faces {
            raster.views[face] = raster.face_view(face);
        }
        Ok(raster)
    }

    /// How many texels are stored.
    pub fn texels(&self) -> usize {
        self.rows * self.columns
    }

    /// Where a canonical face is stored.
    #[inline(always)]
    pub fn view(&self, face: usize) -> &FaceView {
        &self.views[face % MAX_FACES]
    }

    /// How many faces it has.
    pub fn faces(&self) -> usize {
        self.faces
    }

    /// Where all faces are stored.
    pub fn views(&self) -> &[FaceView; MAX_FACES] {
        &self.views
    }

    /// How far apart the rows of every face are stored, where each face's rows are stored as rows.
    pub fn straight(&self) -> Option<usize> {
        (0..self.faces)
            .all(|face| self.is_straight(face))
            .then_some(self.columns)
    }

    /// Whether a face's rows are stored as rows.
    #[inline(always)]
    pub fn is_straight(&self, face: usize) -> bool {
        self.view(face).steps() == [1, self.columns as isize]
    }

    fn origin(&self, face: usize) -> (usize, usize) {
        let place = self.places[face];
        if self.is_atlas {
            (place.column * self.width, place.row * self.height)
        } else {
            (0, place.stored * self.height)
        }
    }

    fn face_view(&self, face: usize) -> FaceView {
        let (column, row) = self.origin(face);
        let o = self.places[face].orientation;
        let columns = self.columns as isize;
        let (mut start, mut steps) = (row as isize * columns + column as isize, [1, columns]);
        if o.flip_u {
            start += (self.width as isize - 1) * steps[0];
            steps[0] = -steps[0];
        }
        if o.flip_v {
            start += (self.height as isize - 1) * steps[1];
            steps[1] = -steps[1];
        }
        if o.swap {
            steps.swap(0, 1);
        }
        FaceView {
            start,
            along_u: steps[0],
            along_v: steps[1],
        }
    }

    /// The runs that stored row `row` is made of.
    pub fn runs(&self, row: usize) -> impl Iterator<Item = Run> + '_ {
        let cells = self.columns / self.width;
        (0..cells).map(move |cell| {
            let column = cell * self.width;
            let face = (0..self.faces).find(|&face| {
                let (left, top) = self.origin(face);
                left == column && (top..top + self.height).contains(&row)
            });
            let face = face.map(|face| {
                let o = self.places[face].orientation;
                let (w, h) = (self.width as isize, self.height as isize);
                let y = row as isize - self.origin(face).1 as isize;
                let b = if o.flip_v { h - 1 - y } else { y };
                let (a, step) = if o.flip_u { (w - 1, -1) } else { (0, 1) };
                if o.swap {
                    (face, [b, a], [0, step])
                } else {
                    (face, [a, b], [step, 0])
                }
            });
            Run {
                column,
                length: self.width,
                face,
            }
        })
    }

    /// Calls `work` with the blocks, of at most `columns` × `rows` texels, that `height` stored rows from row
    /// `first` on are made of.
    pub fn blocks(
        &self,
        first: usize,
        height: usize,
        size: (usize, usize),
        work: impl FnMut(Block),
    ) {
        self.blocks_within((first, 0..self.columns), height, size, work);
    }

    /// The same for a band of some columns alone, which is as wide as these.
    pub fn blocks_within(
        &self,
        (first, within): (usize, Range<usize>),
        height: usize,
        (columns, rows): (usize, usize),
        mut work: impl FnMut(Block),
    ) {
        let mut row = first;
        while row < first + height {
            let in_cell = self.height - row % self.height;
            let rows = rows.min(in_cell).min(first + height - row);
            for run in self.runs(row) {
                let face = run.face.map(|(face, texel, along)| {
                    let o = self.places[face].orientation;
                    let down = if o.flip_v { -1 } else { 1 };
                    let down = if o.swap { [down, 0] } else { [0, down] };
                    (face, texel, [along, down])
                });
                for column in (0..run.length).step_by(columns) {
                    let stored = run.column + column;
                    if !within.contains(&stored) {
                        continue;
                    }
                    work(Block {
                        face: face.map(|(face, [i, j], [along, down])| {
                            let moved = column as isize;
                            let texel = [i + moved * along[0], j + moved * along[1]];
                            (face, texel, [along, down])
                        }),
                        start: (row - first) * within.len() + stored - within.start,
                        columns: columns.min(run.length - column).min(within.end - stored),
                        rows,
                    });
                }
            }
            row += rows;
        }
    }

    /// Whether texel (i, j) of a face has its center in the valid image.
    #[inline(always)]
    pub fn holds(&self, i: isize, j: isize) -> bool {
        let inside =
            (0..self.width as isize).contains(&i) && (0..self.height as isize).contains(&j);
        if !inside {
            return false;
        }
        let center = || (self.along_u.center(i as f64), self.along_v.center(j as f64));
        match self.outline {
            Outline::Square => true,
            Outline::Disk => {
                let (u, v) = center();
                let (p, q) = (2.0 * u - 1.0, 2.0 * v - 1.0);
                p * p + q * q <= 1.0 + 8.0 * f64::EPSILON
            }
            Outline::Shape => {
                let (u, v) = center();
                self.holds_around([u, v], [0.0; 2]) || self.contains(u, v)
            }
        }
    }

    /// Whether any texel of a face has its center in the valid image: not if that is a disk so small that it lies between centers.
    pub fn holds_any(&self) -> bool {
        if self.outline == Outline::Square {
            return true;
        }
        // From the middle of what is held on, where nearly all have one.
        let [i, j] = [0, 1].map(|axis| {
            let middle = self
                .held
                .map_or(0.5, |[middle, _]| 0.5 + 0.5 * middle[axis]);
            let (along, n) = [(self.along_u, self.width), (self.along_v, self.height)][axis];
            let (scale, offset) = along.index();
            // `as` takes negative numbers to 0.
            ((middle * scale + offset).round() as usize).min(n - 1)
        });
        (0..self.height).any(|down| {
            let y = (j + down) % self.height;
            (0..self.width).any(|right| {
                let x = (i + right) % self.width;
                self.holds(x as isize, y as isize)
            })
        })
    }

    /// Whether all of the square that is no farther than `reach` from a place of it, along u and along v, is valid for certain.
    #[inline(always)]
    pub fn holds_around(&self, place: [f64; 2], reach: [f64; 2]) -> bool {
        if self.outline == Outline::Square {
            return true;
        }
        self.held.is_some_and(|[middle, half]| {
            let [p, q] = [0, 1].map(|axis| {
                let from_middle = (2.0 * place[axis] - 1.0 - middle[axis]).abs();
                (from_middle + 2.0 * reach[axis]) / half[axis]
            });
            p * p + q * q < 1.0
        })
    }

    /// Whether a place lies in the valid image of a face.
    pub fn contains(&self, u: f64, v: f64) -> bool {
        struct Contains(f64, f64);
        impl Visitor for Contains {
            type Output = bool;
            fn visit<P: Projection>(self, p: P) -> bool {
                one::contains(p, Uv::flat(self.0, self.1))
            }
        }
        self.kind.visit(Contains(u, v))
    }

    /// The solid angle that a rectangle of a face sees.
    pub fn solid_angle(&self, rect: Rect) -> f64 {
        struct Get(Rect);
        impl Visitor for Get {
            type Output = f64;
            fn visit<P: Projection>(self, p: P) -> f64 {
                p.solid_angle(self.0)
            }
        }
        self.kind.visit(Get(rect))
    }

    /// Whether a block holds nothing for certain: it lies on no face, or outside the disk that is the valid image.
    pub fn misses(&self, block: &Block) -> bool {
        let Some((_, texel, [along, down])) = block.face else {
            return true;
        };
        let (columns, rows) = (block.columns as isize - 1, block.rows as isize - 1);
        // From the middle to the nearest center, along u and along v; more than a rim is ever let out.
        let [p, q] = [(0, self.along_u), (1, self.along_v)].map(|(axis, grid)| {
            let last = texel[axis] + along[axis] * columns + down[axis] * rows;
            let [a, b] = [texel[axis], last].map(|i| 2.0 * grid.center(i as f64) - 1.0);
            if a * b <= 0.0 {
                0.0
            } else {
                a.abs().min(b.abs())
            }
        });
        self.outline == Outline::Disk && p * p + q * q > 1.0 + 1e-5
    }

    /// Whether texels may lie outside the valid image, all of them or in part.
    pub fn has_rim(&self) -> bool {
        self.outline != Outline::Square
    }
}

/// The shape of an image whose face has size `n`: a latlong's height, a square's side, a cube's face.
///
/// ```
/// use spheremap::{Map, image::shape_of_size};
/// assert_eq!(shape_of_size(&Map::new("latlong")?, 4), [4, 8]);
/// assert_eq!(shape_of_size(&Map::new("cube")?, 4), [6, 4, 4]);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn shape_of_size(map: &Map, n: usize) -> Vec<usize> {
    let face_layout = map.face_layout();
    let (width, height) = map.face_size(n);
    let rows = height.saturating_mul(face_layout.rows);
    let columns = width.saturating_mul(face_layout.columns);
    if face_layout.is_atlas {
        vec![rows, columns]
    } else {
        vec![face_layout.faces, rows, columns]
    }
}

fn shape_error(map: &Map, shape: &[usize]) -> String {
    let face_layout = map.face_layout();
    let pattern = if !face_layout.is_atlas {
        format!("({}, N, N)", face_layout.faces)
    } else if face_layout.faces > 1 {
        format!("({} N, {} N)", face_layout.rows, face_layout.columns)
    } else {
        "(H, W)".to_owned()
    };
    let layout = map
        .layout()
        .map(|name| format!(" in layout '{name}'"))
        .unwrap_or_default();
    format!(
        "Expected an image of projection '{}'{layout} to have shape {pattern}, got {}.",
        map.info().name,
        tuple(shape)
    )
}

/// A shape as Python prints it.
pub fn tuple(shape: &[usize]) -> String {
    match shape {
        [n] => format!("({n},)"),
        _ => format!(
            "({})",
            shape
                .iter()
                .map(usize::to_string)
                .collect::<Vec<_>>()
                .join(", ")
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projections::REGISTRY;
    use proptest::prelude::*;

    /// No place of which nobody asks is invalid: on a lattice finer than what an ellipse leaves out.
    fn check(map: &Map) {
        const N: usize = 96;
        let (width, height) = map.face_size(N);
        let shape = shape_of_size(map, N);
        let raster = Raster::new(map, &shape).unwrap();
        for k in 0..width * height {
            let place = [
                (k % width) as f64 / (width - 1) as f64,
                (k / width) as f64 / (height - 1) as f64,
            ];
            assert!(
                !raster.holds_around(place, [0.0; 2]) || raster.contains(place[0], place[1]),
                "{map:?} at {place:?}"
            );
        }
    }

    #[test]
    fn what_is_held_around_a_place_is_valid() {
        REGISTRY
            .iter()
            .for_each(|info| check(&Map::new(info.name).unwrap()));
        // Its radius nearly stands still on its way, and Newton's method leaps in a ring a 250th of the whole wide.
        let lens = "fx=0.2981204592059587,fy=0.2981204592059587,cx=0.22513046973071082,\
            k1=0.15932955429457513,k2=-0.0771938385164017,k3=-0.7586935812977378,k4=0.4793922628417673";
        check(&Map::new(&format!("camera_kannala_brandt({lens})")).unwrap());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        #[test]
        fn what_is_held_around_a_place_is_valid_for_any_camera(
            focal in 0.1..2.0,
            middle in -0.3..0.3,
            strengths in prop::array::uniform8(-0.3..0.3),
            lens in prop::sample::select(
                REGISTRY.iter().filter(|info| info.name.starts_with("camera_")).collect::<Vec<_>>(),
            ),
        ) {
            let own = lens.parameters.iter().skip(5).zip(strengths).map(|(parameter, strength)| {
                let (low, high) = (parameter.above, parameter.maximum);
                let value = parameter.default + f64::powi(strength, 3) * (high - low);
                format!("{}={}", parameter.name, value.clamp(low + 1e-9, high))
            });
            let sensor = [format!("fx={focal}"), format!("fy={focal}"), format!("cx={middle}")];
            let text: Vec<_> = sensor.into_iter().chain(own).collect();
            // Not all coefficients make a lens.
            if let Ok(map) = Map::new(&format!("{}({})", lens.name, text.join(","))) {
                check(&map);
            }
        }
    }
}
