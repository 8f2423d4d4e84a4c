//! The texels of an image by patches: squares of [`SIDE`]² texels of one face, each with where it looks and what it counts with.
//!
//! A texel counts with its exact solid angle, at the direction of its center. A texel across the rim of a
//! disk may have its center outside the valid image: it holds no value (photographers print their credits
//! there), but a part of it sees the sphere. **That part is counted with the nearest texel of the same
//! face whose center is valid**, the first one in row order where two are as near. So the weights still sum to
//! the coverage's solid angle to rounding, and what lies outside never leaks in.
//!
//! Integrals are summed patch by patch, and nothing is kept of one. What asks for the directions of an image again and again has
//! them in a list ([`crate::light::texels`]), which holds the same patches.
//!
//! Patches lie in **sheets**, squares of [`SHEET`]² patches of one face, and all sums over the sphere are sums of sheets: each
//! by itself, and sheets as a tree. So the sheets of an image that no memory holds may be summed one by one, anywhere and in any
//! order, and their sums have the bits of the whole.

use crate::error::Error;
use crate::geometry::axes::Rotation;
use crate::image::ImageView;
use crate::image::raster::Raster;
use crate::image::rim;
use crate::image::rim::Across;
use crate::image::texel::Texel;
use crate::image::texels::SolidAngles;
use crate::kernel::Scalar;
use crate::kernel::memory::expect_room;
use crate::kernel::tile::{TILE, Tile};
use crate::light::kept::Kept;
use crate::map::Map;
use crate::map::verbs::DecodeTile;
use std::borrow::Cow;
use std::convert::Infallible;
use std::ops::Range;
use std::sync::Arc;

/// Numbers that packed sums go by.
pub const LANES: usize = 8;

/// The sum of lanes, as a tree.
pub fn add_lanes(s: &[f64; LANES]) -> f64 {
    ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]))
}

/// Texels along the side of a patch.
pub const SIDE: usize = 16;
const _: () = assert!(ROOM <= TILE);
/// Texels of a patch.
pub const ROOM: usize = SIDE * SIDE;

/// Patches along the side of a sheet.
pub const SHEET: usize = 32;

/// Stands for no texel.
pub const NONE: usize = usize::MAX;

/// A square of patches of one face.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sheet {
    /// Its rows of patches, counted through all faces.
    pub strips: Range<usize>,
    /// Its columns of patches.
    pub columns: Range<usize>,
}

/// What the texels of some columns of a row of patches count with.
pub struct StripWeights<'a> {
    rows: Cow<'a, [f64]>,
    /// The first column of texels.
    first: usize,
    /// How many there are.
    width: usize,
}

impl StripWeights<'_> {
    /// The first column of texels.
    pub fn first(&self) -> usize {
        self.first
    }

    /// Those of each row of texels.
    pub fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.rows.chunks_exact(self.width)
    }
}

/// The patches of an image.
pub struct Patches<'a> {
    map: &'a Map,
    raster: Raster,
    turn: Rotation,
    /// What the texels of a face count with; none where that is found row by row.
    weights: Option<Vec<f64>>,
    /// Where it is: the texels across the rim of a face, and their parts.
    across_rim: Arc<Rim>,
    cells: SolidAngles,
    /// How many patches a face has in a row.
    pub across: usize,
    /// How many rows of them.
    down: usize,
}

/// Points of a quadrature, filled up to a multiple of [`LANES`] with points of weight 0.
pub struct Points {
    /// Coordinates of centers.
    uv: Tile<f64, 3>,
    /// Unit directions, where they were asked for.
    pub direction: Tile<f64, 3>,
    /// Steradians.
    pub weight: [f64; ROOM],
    /// The stored texel of each.
    pub index: [usize; ROOM],
}

impl Points {
    /// Of an empty patch.
    pub fn new() -> Points {
        Points {
            uv: Tile::new(),
            direction: Tile::new(),
            weight: [0.0; ROOM],
            index: [NONE; ROOM],
        }
    }
}

impl<'a> Patches<'a> {
    /// Those of an image of this shape, of which each is asked for once, or several times.
    pub fn new(map: &'a Map, shape: &[usize], again: bool) -> Result<Self, Error> {
        let raster = Raster::new(map, shape)?;
        // Those of a rim have others' parts; those of several faces are the same.
        let weights = if again || raster.has_rim() || map.face_layout().faces > 1 {
            expect_room::<f64>(raster.width * raster.height)?;
            Some(rim::face_weights(map, &raster))
        } else {
            None
        };
        Ok(Patches::with(map, raster, weights, Arc::default()))
    }

    /// The same where a few of them are asked for: nothing is made of the whole, but a list of the texels across a rim.
    pub fn of_parts(map: &'a Map, shape: &[usize]) -> Result<Self, Error> {
        let raster = Raster::new(map, shape)?;
        let across_rim = across_rim(map, &raster, shape);
        Ok(Patches::with(map, raster, None, across_rim))
    }

    fn with(map: &'a Map, raster: Raster, weights: Option<Vec<f64>>, across_rim: Arc<Rim>) -> Self {
        Patches {
            map,
            turn: map.view_rotation(None).inverse(),
            weights,
            across_rim,
            cells: SolidAngles::new(map, &raster),
            across: raster.width.div_ceil(SIDE),
            down: raster.height.div_ceil(SIDE),
            raster,
        }
    }

    /// The image's texels.
    pub fn raster(&self) -> &Raster {
        &self.raster
    }

    /// What the texels of a face count with, where that is known of all of them.
    pub fn face_weights(&self) -> &[f64] {
        self.weights.as_deref().unwrap_or_default()
    }

    /// How many rows of patches there are, of all faces.
    pub fn strips(&self) -> usize {
        self.map.face_layout().faces * self.down
    }

    /// All of them as one.
    pub fn whole(&self) -> Sheet {
        Sheet {
            strips: 0..self.strips(),
            columns: 0..self.across,
        }
    }

    /// The sheets that they are in: face by face, row by row.
    pub fn sheets(&self) -> Vec<Sheet> {
        let mut sheets = Vec::new();
        for face in 0..self.map.face_layout().faces {
            for top in (0..self.down).step_by(SHEET) {
                for left in (0..self.across).step_by(SHEET) {
                    let bottom = (top + SHEET).min(self.down);
                    sheets.push(Sheet {
                        strips: face * self.down + top..face * self.down + bottom,
                        columns: left..(left + SHEET).min(self.across),
                    });
                }
            }
        }
        sheets
    }

    /// Where a sheet is stored: rows, those of all faces where faces are apart, and columns.
    pub fn stored(&self, sheet: &Sheet) -> [Range<usize>; 2] {
        let raster = &self.raster;
        let view = raster.view(sheet.strips.start / self.down);
        let (above, below) = (
            self.rows(sheet.strips.start).start,
            self.rows(sheet.strips.end - 1).end - 1,
        );
        let columns = self.columns(&sheet.columns);
        let corners = [(columns.start, above), (columns.end - 1, below)];
        let [a, b] = corners.map(|(i, j)| view.index(i, j));
        let span = |a: usize, b: usize| a.min(b)..a.max(b) + 1;
        [
            span(a / raster.columns, b / raster.columns),
            span(a % raster.columns, b % raster.columns),
        ]
    }

    /// What the texels of some columns of a row of patches count with.
    pub fn strip_weights(&self, strip: usize, columns: &Range<usize>) -> StripWeights<'_> {
        let (w, rows) = (self.raster.width, self.rows(strip));
        let columns = self.columns(columns);
        let (first, width) = (columns.start, columns.len());
        let rows = match &self.weights {
            Some(weights) if width == w => weights[rows.start * w..rows.end * w].into(),
            Some(weights) => {
                let mut found = Vec::with_capacity(rows.len() * width);
                for j in rows {
                    found.extend_from_slice(&weights[j * w..][columns.clone()]);
                }
                found.into()
            }
            None => self.found_weights(rows, columns).into(),
        };
        StripWeights { rows, first, width }
    }

    /// Those of rows and columns of texels, from the map.
    fn found_weights(&self, rows: Range<usize>, columns: Range<usize>) -> Vec<f64> {
        let width = columns.len();
        let mut found = vec![0.0; rows.len() * width];
        for (j, row) in rows.clone().zip(found.chunks_exact_mut(width)) {
            self.cells
                .row(self.map, &self.raster, j, columns.start, row);
        }
        let place = |[i, j]: [usize; 2]| {
            (rows.contains(&j) && columns.contains(&i))
                .then(|| (j - rows.start) * width + i - columns.start)
        };
        for (across, part) in self.across_rim.iter() {
            if let Some(place) = place(across.texel) {
                found[place] = 0.0;
            }
            if let Some(place) = place(across.owner) {
                found[place] += part;
            }
        }
        found
    }

    /// The rows of texels of a strip, on its face.
    pub fn rows(&self, strip: usize) -> Range<usize> {
        let first = strip % self.down * SIDE;
        first..(first + SIDE).min(self.raster.height)
    }

    /// The columns of texels of columns of patches.
    pub(super) fn columns(&self, columns: &Range<usize>) -> Range<usize> {
        columns.start * SIDE..(columns.end * SIDE).min(self.raster.width)
    }

    /// The face of a strip.
    pub fn face(&self, strip: usize) -> usize {
        strip / self.down
    }

    /// Finds the points of a patch of a strip with these weights, directions too if they are asked for; returns how many there are.
    pub fn points(
        &self,
        strip: usize,
        column: usize,
        weights: &StripWeights<'_>,
        with_directions: bool,
        points: &mut Points,
    ) -> usize {
        let raster = &self.raster;
        let face = self.face(strip);
        let view = raster.view(face);
        let columns = self.columns(&(column..column + 1));
        let mut n = 0;
        for (j, row) in self.rows(strip).zip(weights.rows()) {
            for (i, &weight) in columns.clone().zip(&row[columns.start - weights.first..]) {
                if weight > 0.0 {
                    if with_directions {
                        let (u, v) = (
                            raster.along_u.center(i as f64),
                            raster.along_v.center(j as f64),
                        );
                        points.uv.set(n, [u, v, face as f64]);
                    }
                    points.weight[n] = weight;
                    points.index[n] = view.index(i, j);
                    n += 1;
                }
            }
        }
        let end = n.next_multiple_of(LANES);
        points.weight[n..end].fill(0.0);
        points.index[n..end].fill(NONE);
        if with_directions {
            self.map.visit_canonical(DecodeTile {
                turn: self.turn,
                input: &points.uv,
                output: points.direction.first_mut(n),
            });
            for axis in &mut points.direction.0 {
                axis[n..end].fill(0.0);
            }
        }
        n
    }
}

/// Radiance times solid angle of the texels of a patch: a row for each channel and, if there is room for one more, the weights.
pub fn flux<T: Texel>(image: &ImageView<'_, T>, index: &[usize], weight: &[f64], out: &mut [f64]) {
    let (channels, length) = (image.channels(), weight.len());
    let (light, last) = out.split_at_mut(channels * length);
    for (k, (&index, &weight)) in index.iter().zip(weight).enumerate() {
        if index != NONE {
            let texel = image.texel(index);
            for (c, value) in texel.iter().enumerate() {
                light[c * length + k] = weight * value.load().to_f64();
            }
        }
    }
    if !last.is_empty() {
        last.copy_from_slice(weight);
    }
}

/// Texels across a rim, and the part of the sphere that each covers.
type Rim = Vec<(Across, f64)>;

/// That of the last image with a rim, however long it is: many parts ask for it.
static LAST: Kept<Rim> = Kept::new(1);

/// The texels across the rim of a face, by rows, and the part of the sphere that each covers.
fn across_rim(map: &Map, raster: &Raster, shape: &[usize]) -> Arc<Rim> {
    if !raster.has_rim() {
        return Arc::default();
    }
    let find = || {
        let cells = SolidAngles::new(map, raster);
        let part = |i, j| cells.of(map, raster, i, j);
        let found = rim::across(raster, |i, j| part(i, j) > 0.0);
        let with_part = |across: Across| (across, part(across.texel[0], across.texel[1]));
        Ok::<_, Infallible>(found.into_iter().map(with_part).collect())
    };
    let Ok(found) = LAST.of(map, shape, |_| 1, find);
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::raster::shape_of_size;
    use crate::projections::REGISTRY;

    #[test]
    fn what_is_found_for_a_part_is_what_the_whole_counts_with() {
        for info in REGISTRY {
            let map = Map::new(info.name).unwrap();
            let shape = shape_of_size(&map, 71);
            let whole = Patches::new(&map, &shape, true).unwrap();
            let parts = Patches::of_parts(&map, &shape).unwrap();
            let columns = 1..parts.across.min(4);
            for strip in 0..parts.strips() {
                let of =
                    |patches: &Patches<'_>| patches.strip_weights(strip, &columns).rows.to_vec();
                assert_eq!(of(&whole), of(&parts), "{} {strip}", info.name);
            }
        }
    }
}
