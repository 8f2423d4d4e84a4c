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

use crate::error::Error;
use crate::geometry::axes::Rotation;
use crate::image::ImageView;
use crate::image::raster::Raster;
use crate::image::rim;
use crate::image::texel::Texel;
use crate::image::texels::SolidAngles;
use crate::kernel::Scalar;
use crate::kernel::memory::expect_room;
use crate::kernel::tile::{TILE, Tile};
use crate::map::Map;
use crate::map::verbs::DecodeTile;

/// Numbers that packed sums go by.
pub const LANES: usize = 8;

/// Texels along the side of a patch.
pub const SIDE: usize = 16;
const _: () = assert!(ROOM <= TILE);
/// Texels of a patch.
pub const ROOM: usize = SIDE * SIDE;

/// Stands for no texel.
pub const NONE: u32 = u32::MAX;

/// The patches of an image.
pub struct Patches<'a> {
    map: &'a Map,
    raster: Raster,
    turn: Rotation,
    /// What the texels of a face count with; none where that is found row by row.
    weights: Option<Vec<f64>>,
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
    pub index: [u32; ROOM],
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
        if raster.texels() >= NONE as usize {
            return Err(Error::Shape(format!(
                "Expected an image of less than {NONE} texels, got {}.",
                raster.texels()
            )));
        }
        // Those of a rim have others' parts; those of several faces are the same.
        let weights = if again || raster.has_rim() || map.face_layout().faces > 1 {
            expect_room::<f64>(raster.width * raster.height)?;
            Some(rim::face_weights(map, &raster))
        } else {
            None
        };
        Ok(Patches {
            map,
            turn: map.view_rotation(None).inverse(),
            weights,
            cells: SolidAngles::new(map, &raster),
            across: raster.width.div_ceil(SIDE),
            down: raster.height.div_ceil(SIDE),
            raster,
        })
    }

    /// The image's texels.
    pub fn raster(&self) -> &Raster {
        &self.raster
    }

    /// How many rows of patches there are, of all faces.
    pub fn strips(&self) -> usize {
        self.map.face_layout().faces * self.down
    }

    /// What the texels of a row of patches count with, row by row.
    pub fn strip_weights(&self, strip: usize) -> std::borrow::Cow<'_, [f64]> {
        let (w, rows) = (self.raster.width, self.rows(strip));
        if let Some(weights) = &self.weights {
            return weights[rows.start * w..rows.end * w].into();
        }
        let mut found = vec![0.0; rows.len() * w];
        for (j, row) in rows.zip(found.chunks_exact_mut(w)) {
            self.cells.row(self.map, &self.raster, j, 0, row);
        }
        found.into()
    }

    fn rows(&self, strip: usize) -> std::ops::Range<usize> {
        let first = strip % self.down * SIDE;
        first..(first + SIDE).min(self.raster.height)
    }

    /// Finds the points of a patch of a strip with these weights, directions too if they are asked for; returns how many there are.
    pub fn points(
        &self,
        strip: usize,
        column: usize,
        weights: &[f64],
        with_directions: bool,
        points: &mut Points,
    ) -> usize {
        let raster = &self.raster;
        let face = strip / self.down;
        let view = raster.view(face);
        let columns = column * SIDE..((column + 1) * SIDE).min(raster.width);
        let mut n = 0;
        for (j, weights) in self.rows(strip).zip(weights.chunks_exact(raster.width)) {
            for i in columns.clone() {
                if weights[i] > 0.0 {
                    if with_directions {
                        let (u, v) = (
                            raster.along_u.center(i as f64),
                            raster.along_v.center(j as f64),
                        );
                        points.uv.set(n, [u, v, face as f64]);
                    }
                    points.weight[n] = weights[i];
                    points.index[n] = view.index(i, j) as u32;
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
pub fn flux<T: Texel>(image: &ImageView<'_, T>, index: &[u32], weight: &[f64], out: &mut [f64]) {
    let (channels, length) = (image.channels(), weight.len());
    let (light, last) = out.split_at_mut(channels * length);
    for (k, (&index, &weight)) in index.iter().zip(weight).enumerate() {
        if index != NONE {
            let texel = image.texel(index as usize);
            for (c, value) in texel.iter().enumerate() {
                light[c * length + k] = weight * value.load().to_f64();
            }
        }
    }
    if !last.is_empty() {
        last.copy_from_slice(weight);
    }
}
