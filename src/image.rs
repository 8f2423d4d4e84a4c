//! Images: shapes, texel types and where each texel of a face is stored.
//!
//! An image of several faces is seen as faces, whatever its layout: each canonical face is a strided view
//! of the stored texels ([`FaceView`]), and each stored row is a few runs of texels of one face
//! ([`Run`]). So sampling and conversion know nothing of crosses, strips, face orders and turned faces.

use crate::error::Error;
use crate::faces::{MAX_FACES, Place};
use crate::kernel::Scalar;
use crate::light::solid_angle::Rect;
use crate::map::{Grid, GridAxis, Map};
use crate::projection::{Outline, Projection, Uv};
use crate::projections::{Kind, Visitor};
use crate::tile::Tile;
use fearless_simd::{
    Bytes, Select, Simd, SimdBase, SimdCvtFloat, f32x4, f64x4, i32x4, u8x16, u16x8, u32x4,
};
use half::f16;

/// A texel type. Filters run in `Float` and round once.
pub trait Texel: Copy + Default + Send + Sync + Filtered<Self> + 'static {
    /// What filters compute in.
    type Float: Scalar + Texel<Float = Self::Float> + Filtered<Self>;
    /// The value.
    fn load(self) -> Self::Float;
    /// Those of four texels.
    #[inline(always)]
    fn load_four<S: Simd>(simd: S, texels: &[Self; 4]) -> Four<Self, S> {
        Four::<Self, S>::load_array(simd, texels.map(Self::load))
    }
    /// The nearest texel; integers saturate, and NaN is 0 there.
    fn store(x: Self::Float) -> Self;
    /// Those of four numbers.
    #[inline(always)]
    fn store_four<S: Simd>(_: S, numbers: Four<Self, S>) -> [Self; 4] {
        numbers.to_array().map(Self::store)
    }
    /// The texel for a number of the caller's.
    fn from_f64(x: f64) -> Self;
    /// What stands for "nothing": NaN, or 0 where there is none.
    const NOTHING: f64;
}

/// Four numbers as filters of texels of type T compute them.
pub type Four<T, S> = <<T as Texel>::Float as Scalar>::Four<S>;

/// What lookups among texels of type T are stored as: T itself, or the float that they are filtered in where
/// more is to be done with them before they are rounded.
pub trait Filtered<T: Texel>: Copy + Default + Send + Sync {
    /// A texel as it is.
    fn exact(texel: T) -> Self;
    /// A filtered value.
    fn filtered(x: T::Float) -> Self;
    /// Four of them.
    #[inline(always)]
    fn filtered_four<S: Simd>(_: S, numbers: Four<T, S>) -> [Self; 4] {
        numbers.to_array().map(Self::filtered)
    }
}

impl<T: Texel> Filtered<T> for T {
    #[inline(always)]
    fn exact(texel: T) -> T {
        texel
    }
    #[inline(always)]
    fn filtered(x: T::Float) -> T {
        T::store(x)
    }
    #[inline(always)]
    fn filtered_four<S: Simd>(simd: S, numbers: Four<T, S>) -> [T; 4] {
        T::store_four(simd, numbers)
    }
}

macro_rules! filtered_as_f32 {
    ($($t:ty),+) => {
        $(
            impl Filtered<$t> for f32 {
                #[inline(always)]
                fn exact(texel: $t) -> f32 {
                    texel.load()
                }
                #[inline(always)]
                fn filtered(x: f32) -> f32 {
                    x
                }
            }
        )+
    };
}
filtered_as_f32!(u8, u16, f16);

macro_rules! integer_texel {
    ($t:ty, $widen:ident, $narrow:ident) => {
        impl Texel for $t {
            type Float = f32;
            const NOTHING: f64 = 0.0;
            #[inline(always)]
            fn load(self) -> f32 {
                self as f32
            }
            #[inline(always)]
            fn load_four<S: Simd>(simd: S, texels: &[$t; 4]) -> f32x4<S> {
                f32x4::float_from($widen(simd, *texels).bitcast::<i32x4<S>>())
            }
            #[inline(always)]
            fn store(x: f32) -> $t {
                // NaN goes to 0 with the negative ones. The sum leaves the nearest integer in its last
                // bits; `as` would check the range again, number by number.
                const LARGEST: f32 = <$t>::MAX as f32;
                let x = if x > 0.0 { x } else { 0.0 };
                let x = if x < LARGEST { x } else { LARGEST };
                (x + MAGIC).to_bits() as $t
            }
            #[inline(always)]
            fn store_four<S: Simd>(simd: S, x: f32x4<S>) -> [$t; 4] {
                let number = |x| f32x4::splat(simd, x);
                let (zero, largest) = (number(0.0), number(<$t>::MAX as f32));
                let x = x.simd_gt(zero).select(x, zero);
                let x = x.simd_lt(largest).select(x, largest);
                $narrow(simd, (x + number(MAGIC)).bitcast())
            }
            fn from_f64(x: f64) -> $t {
                x.round_ties_even() as $t
            }
        }
    };
}
integer_texel!(u8, widen_u8, narrow_u8);
integer_texel!(u16, widen_u16, narrow_u16);

/// What leaves the nearest integer of a small number in the last bits of their sum.
const MAGIC: f32 = 8_388_608.0;

/// Four bytes as words. Of four conversions one by one the compiler made no better.
#[inline(always)]
fn widen_u8<S: Simd>(simd: S, bytes: [u8; 4]) -> u32x4<S> {
    let bytes: u8x16<S> = u32x4::splat(simd, u32::from_ne_bytes(bytes)).bitcast();
    let zero = u8x16::splat(simd, 0);
    let halves: u16x8<S> = simd.zip_low_u8x16(bytes, zero).bitcast();
    simd.zip_low_u16x8(halves, zero.bitcast()).bitcast()
}

/// The lowest bytes of four words.
#[inline(always)]
fn narrow_u8<S: Simd>(simd: S, words: u32x4<S>) -> [u8; 4] {
    let bytes: u8x16<S> = words.bitcast();
    let pairs = simd.unzip_low_u8x16(bytes, bytes);
    let lowest: u32x4<S> = simd.unzip_low_u8x16(pairs, pairs).bitcast();
    lowest.to_array()[0].to_ne_bytes()
}

/// Four halves as words.
#[inline(always)]
fn widen_u16<S: Simd>(simd: S, [a, b, c, d]: [u16; 4]) -> u32x4<S> {
    let halves = u16x8::load_array(simd, [a, b, c, d, 0, 0, 0, 0]);
    simd.zip_low_u16x8(halves, u16x8::splat(simd, 0)).bitcast()
}

/// The lower halves of four words.
#[inline(always)]
fn narrow_u16<S: Simd>(simd: S, words: u32x4<S>) -> [u16; 4] {
    let halves: u16x8<S> = words.bitcast();
    let [a, b, c, d, ..] = simd.unzip_low_u16x8(halves, halves).to_array();
    [a, b, c, d]
}

macro_rules! float_texel {
    ($t:ty, $float:ty, $load:expr, $store:expr, $from:expr $(, $four:ident)?) => {
        impl Texel for $t {
            type Float = $float;
            const NOTHING: f64 = f64::NAN;
            #[inline(always)]
            fn load(self) -> $float {
                $load(self)
            }
            $(
                #[inline(always)]
                fn load_four<S: Simd>(simd: S, texels: &[$t; 4]) -> Four<$t, S> {
                    // As they are: through an array the compiler loads them one by one.
                    $four::load_array_ref(simd, texels)
                }
            )?
            #[inline(always)]
            fn store(x: $float) -> $t {
                $store(x)
            }
            fn from_f64(x: f64) -> $t {
                $from(x)
            }
        }
    };
}
float_texel!(f16, f32, f16::to_f32, f16::from_f32, f16::from_f64);
float_texel!(f32, f32, |x| x, |x| x, |x| x as f32, f32x4);
float_texel!(f64, f64, |x| x, |x| x, |x| x, f64x4);

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
    kind: Kind,
    faces: usize,
    joined: bool,
    places: [Place; MAX_FACES],
    views: [FaceView; MAX_FACES],
}

impl Raster {
    /// The geometry of an image of this shape: (rows, columns), or (faces, rows, columns).
    pub fn new(map: &Map, shape: &[usize]) -> Result<Raster, Error> {
        let arrangement = map.arrangement();
        let expected = || Error::Shape(shape_error(map, shape));
        let (stored_faces, rows, columns) = match (arrangement.joined, shape) {
            (true, &[rows, columns]) => (1, rows, columns),
            (false, &[faces, rows, columns]) if faces == arrangement.faces => {
                (faces, rows, columns)
            }
            _ => return Err(expected()),
        };
        if rows == 0
            || columns == 0
            || rows % arrangement.rows != 0
            || columns % arrangement.columns != 0
        {
            return Err(expected());
        }
        if rows > LONGEST_SIDE || columns > LONGEST_SIDE {
            return Err(Error::Shape(format!(
                "Expected an image with sides of at most {LONGEST_SIDE}, got {}.",
                tuple(shape)
            )));
        }
        let (height, width) = (rows / arrangement.rows, columns / arrangement.columns);
        if arrangement.faces > 1 && height != width {
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
            outline: map.info().outline,
            kind: map.kind(),
            faces: arrangement.faces,
            joined: arrangement.joined,
            places: arrangement.places,
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
        self.views[..self.faces]
            .iter()
            .all(|view| view.steps() == [1, self.columns as isize])
            .then_some(self.columns)
    }

    fn origin(&self, face: usize) -> (usize, usize) {
        let place = self.places[face];
        if self.joined {
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
                    work(Block {
                        face: face.map(|(face, [i, j], [along, down])| {
                            let moved = column as isize;
                            let texel = [i + moved * along[0], j + moved * along[1]];
                            (face, texel, [along, down])
                        }),
                        start: (row - first) * self.columns + run.column + column,
                        columns: columns.min(run.length - column),
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
                self.contains(u, v)
            }
        }
    }

    /// Whether a place lies in the valid image of a face.
    pub fn contains(&self, u: f64, v: f64) -> bool {
        struct Contains(f64, f64);
        impl Visitor for Contains {
            type Output = bool;
            fn visit<P: Projection>(self, p: P) -> bool {
                p.contains(Uv::flat(self.0, self.1))
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

/// The coordinates of all texel centers of a face: computed once a call, for they cost a division each.
pub struct Centers<R> {
    u: Vec<R>,
    v: Vec<R>,
}

impl<R: Scalar> Centers<R> {
    /// Those of a raster.
    pub fn new(raster: &Raster) -> Self {
        let along = |axis: GridAxis, n: usize| {
            let center = |i: usize| R::new(axis.center(i as f64));
            (0..n).map(center).collect()
        };
        Centers {
            u: along(raster.along_u, raster.width),
            v: along(raster.along_v, raster.height),
        }
    }

    /// Writes the canonical (u, v, face) of the texels of a block, row by row, at most [`TILE`] in all. The block must
    /// lie on a face.
    #[inline(always)]
    pub fn of(&self, block: &Block, uv: &mut Tile<R, 3>) {
        let Some((face, texel, [along, down])) = block.face else {
            return;
        };
        let [us, vs, faces] = &mut uv.0;
        faces[..block.columns * block.rows].fill(R::new(face as f64));
        for row in 0..block.rows {
            let here = row * block.columns..(row + 1) * block.columns;
            let (us, vs) = (&mut us[here.clone()], &mut vs[here]);
            let row = row as isize;
            let first = [texel[0] + row * down[0], texel[1] + row * down[1]];
            if along == [1, 0] {
                vs.fill(self.v[first[1] as usize]);
                us.copy_from_slice(&self.u[first[0] as usize..][..block.columns]);
            } else {
                for (k, (u, v)) in us.iter_mut().zip(vs).enumerate() {
                    let at = |axis: usize| (first[axis] + k as isize * along[axis]) as usize;
                    (*u, *v) = (self.u[at(0)], self.v[at(1)]);
                }
            }
        }
    }
}

/// The shape of an image whose face has size `n`: a latlong's height, a square's side, a cube's face.
pub fn shape_of_size(map: &Map, n: usize) -> Vec<usize> {
    let arrangement = map.arrangement();
    let (width, height) = map.face_size(n);
    let (rows, columns) = (height * arrangement.rows, width * arrangement.columns);
    if arrangement.joined {
        vec![rows, columns]
    } else {
        vec![arrangement.faces, rows, columns]
    }
}

fn shape_error(map: &Map, shape: &[usize]) -> String {
    let arrangement = map.arrangement();
    let pattern = if !arrangement.joined {
        format!("({}, N, N)", arrangement.faces)
    } else if arrangement.faces > 1 {
        format!("({} N, {} N)", arrangement.rows, arrangement.columns)
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
    use crate::kernel::{Packed, packed, unpacked};

    /// Four numbers as texels, and these as numbers, side by side.
    struct Both<'a, T>([f32; 4], &'a mut [T; 4], &'a mut [f32; 4]);

    impl<T: Texel<Float = f32>> Packed for Both<'_, T> {
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) {
            let Both(numbers, texels, loaded) = self;
            *texels = T::store_four(simd, Four::<T, S>::load_array(simd, numbers));
            *loaded = T::load_four(simd, texels).to_array();
        }
    }

    fn four_are_four_times_one<T: Texel<Float = f32> + PartialEq + std::fmt::Debug>(most: f32) {
        let hard = [
            f32::NAN,
            -0.0,
            f32::INFINITY,
            f32::NEG_INFINITY,
            -1e-30,
            -1.5,
            1e30,
            most,
        ];
        let some = (0..4 * 512).map(|k| k as f32 * (most + 2.0) / 2040.5);
        let halves = [
            0.5,
            1.5,
            2.5,
            most - 0.5,
            most - 1.5,
            most + 0.25,
            most + 0.5,
            127.5,
        ];
        let all: Vec<f32> = hard.into_iter().chain(halves).chain(some).collect();
        for numbers in all.as_chunks::<4>().0 {
            let (mut texels, mut loaded) = ([T::default(); 4], [0.0; 4]);
            for best in [true, false] {
                let both = Both(*numbers, &mut texels, &mut loaded);
                if best {
                    packed(both);
                } else {
                    unpacked(both);
                }
                assert_eq!(texels, numbers.map(T::store), "{numbers:?}");
                assert_eq!(loaded, texels.map(T::load));
            }
        }
    }

    #[test]
    fn four_integers_are_stored_and_loaded_as_one_is() {
        four_are_four_times_one::<u8>(255.0);
        four_are_four_times_one::<u16>(65535.0);
    }
}
