//! The texels of an image as points of a quadrature: directions and weights, in blocks.
//!
//! A texel counts with its exact solid angle, at the direction of its center. A texel across the rim of a
//! disk may have its center outside the valid image: it holds no value (photographers print their credits
//! there), but a part of it sees the sphere. **That part is counted with the nearest texel of the same
//! face whose center is valid**, the first one in row order where two are as near. So the weights still sum to
//! the coverage's solid angle to rounding, and what lies outside never leaks in.
//!
//! Blocks are squares of [`SIDE`]² texels of one face, so that a block is a small patch of the sphere: it has
//! an axis and a radius, and sums over the sphere can often deal with a block as a whole. Each is stored
//! as rows of numbers (x, y, z, weight), filled up to a multiple of [`LANES`] with points of weight 0.
//!
//! Finding all this takes longer than most sums over it, so the last few are kept, up to [`KEPT`] texels.

use crate::error::Error;
use crate::image::ImageView;
use crate::image::raster::Raster;
use crate::image::rim;
use crate::image::texel::Texel;
use crate::kernel::Scalar;
use crate::kernel::interrupt;
use crate::kernel::memory::expect_room;
use crate::kernel::threads;
use crate::kernel::tile::{TILE, Tile};
use crate::map::Map;
use crate::map::verbs::DecodeTile;
use std::sync::{Arc, Mutex};

/// Numbers that packed sums go by.
pub const LANES: usize = 8;

/// Texels along the side of a block.
pub const SIDE: usize = 16;
const _: () = assert!(SIDE * SIDE <= TILE);

/// How many texels are remembered, over all images.
const KEPT: usize = 1 << 21;

/// Stands for no texel.
const NONE: u32 = u32::MAX;

/// Texels next to one another.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// Where its points begin.
    pub start: usize,
    /// How many there are, those of weight 0 included.
    pub length: usize,
    /// The unit vector through its middle.
    pub axis: [f64; 3],
    /// The cosine of the angle from the axis to the farthest point; -1 if there is no such cone.
    pub cos_radius: f64,
}

/// All texels of an image that hold a value.
#[derive(Debug)]
pub struct Texels {
    /// Components of the unit directions.
    pub x: Vec<f64>,
    /// The second.
    pub y: Vec<f64>,
    /// The third.
    pub z: Vec<f64>,
    /// Steradians.
    pub weight: Vec<f64>,
    /// The stored texel of each point.
    index: Vec<u32>,
    /// The blocks.
    pub blocks: Vec<Block>,
    /// How many texels the image stores.
    pub stored: usize,
    /// Sums of spherical harmonics over the points, by order.
    moments: Mutex<Vec<(usize, Arc<Vec<f64>>)>>,
}

type Kept = Vec<(Map, Vec<usize>, Arc<Texels>)>;
static KEEP: Mutex<Kept> = Mutex::new(Vec::new());

/// The texels of an image of this map and shape.
pub fn texels(map: &Map, shape: &[usize]) -> Result<Arc<Texels>, Error> {
    let lock = || {
        KEEP.lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
    };
    {
        let mut keep = lock();
        if let Some(place) = keep.iter().position(|(m, s, _)| m == map && s == shape) {
            let found = keep.remove(place);
            let texels = Arc::clone(&found.2);
            keep.push(found);
            return Ok(texels);
        }
    }
    let made = Arc::new(Texels::new(map, shape)?);
    if made.stored <= KEPT {
        let mut keep = lock();
        keep.push((map.clone(), shape.to_vec(), Arc::clone(&made)));
        while keep.iter().map(|(_, _, t)| t.stored).sum::<usize>() > KEPT {
            keep.remove(0);
        }
    }
    Ok(made)
}

impl Texels {
    fn new(map: &Map, shape: &[usize]) -> Result<Texels, Error> {
        let raster = Raster::new(map, shape)?;
        if raster.texels() >= NONE as usize {
            return Err(Error::Shape(format!(
                "Expected an image of less than {NONE} texels, got {}.",
                raster.texels()
            )));
        }
        let (w, h) = (raster.width, raster.height);
        let faces = map.face_layout().faces;
        expect_room::<f64>(w * h)?;
        let weights = interrupt::part(0.0, 0.25, || rim::face_weights(map, &raster));
        let (across, down) = (w.div_ceil(SIDE), h.div_ceil(SIDE));
        let turn = map.view_rotation(None).inverse();

        // Every block has room for all its texels first, and is closed up afterward.
        let room = SIDE * SIDE;
        // What is made first, and what is closed up of it while both are there: five numbers each.
        expect_room::<[f64; 10]>(faces * across * down * room)?;
        let mut points = vec![[0.0_f64; 5]; faces * across * down * room];
        let find = |number: usize, points: &mut [[f64; 5]]| {
            let face = number / (across * down);
            let (row, column) = (number % (across * down) / across, number % across);
            let mut uv = Tile::new();
            let mut directions = Tile::new();
            let mut places = [(0, 0); SIDE * SIDE];
            let mut n = 0;
            for j in row * SIDE..((row + 1) * SIDE).min(h) {
                for i in column * SIDE..((column + 1) * SIDE).min(w) {
                    if weights[j * w + i] > 0.0 {
                        let (u, v) = (
                            raster.along_u.center(i as f64),
                            raster.along_v.center(j as f64),
                        );
                        uv.set(n, [u, v, face as f64]);
                        places[n] = (i, j);
                        n += 1;
                    }
                }
            }
            map.visit_canonical(DecodeTile {
                turn,
                input: &uv,
                output: directions.first_mut(n),
            });
            for (k, &(i, j)) in places[..n].iter().enumerate() {
                let [x, y, z] = directions.at(k);
                let index = raster.view(face).index(i, j) as f64;
                points[k] = [x, y, z, weights[j * w + i], index];
            }
        };
        interrupt::part(0.25, 1.0, || {
            threads::rows(&mut points, room, faces * w * h, find);
        });
        drop(weights);

        let blocks = points.chunks(room).len();
        let count = points.iter().filter(|p| p[3] != 0.0).count() + blocks * (LANES - 1);
        let mut texels = Texels {
            x: Vec::with_capacity(count),
            y: Vec::with_capacity(count),
            z: Vec::with_capacity(count),
            weight: Vec::with_capacity(count),
            index: Vec::with_capacity(count),
            blocks: Vec::with_capacity(blocks),
            stored: raster.texels(),
            moments: Mutex::default(),
        };
        for block in points.chunks(room) {
            let n = block.iter().position(|p| p[3] == 0.0).unwrap_or(room);
            if n > 0 {
                texels.push(&block[..n]);
            }
        }
        interrupt::check()?;
        Ok(texels)
    }

    fn push(&mut self, points: &[[f64; 5]]) {
        let start = self.x.len();
        let length = points.len().next_multiple_of(LANES);
        let mut sum = [0.0; 3];
        for p in points {
            self.x.push(p[0]);
            self.y.push(p[1]);
            self.z.push(p[2]);
            self.weight.push(p[3]);
            self.index.push(p[4] as u32);
            (0..3).for_each(|k| sum[k] += p[k]);
        }
        for rows in [&mut self.x, &mut self.y, &mut self.z, &mut self.weight] {
            rows.resize(start + length, 0.0);
        }
        self.index.resize(start + length, NONE);
        let size = (sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]).sqrt();
        let (mut axis, mut cos_radius) = ([0.0, 0.0, 1.0], -1.0_f64);
        if size > 1e-3 * points.len() as f64 {
            axis = sum.map(|s| s / size);
            cos_radius = points
                .iter()
                .map(|p| axis[0] * p[0] + axis[1] * p[1] + axis[2] * p[2])
                .fold(1.0, f64::min);
        }
        self.blocks.push(Block {
            start,
            length,
            axis,
            cos_radius,
        });
    }

    /// Radiance times solid angle, channel by channel within each block: the numbers of channel c of
    /// a block lie at `channels * start + c * length`. A last channel is the weight alone, if asked for.
    ///
    /// # Errors
    /// There is no memory for it.
    pub fn flux<T: Texel>(
        &self,
        image: &ImageView<'_, T>,
        with_weight: bool,
    ) -> Result<Vec<f64>, Error> {
        let channels = image.channels();
        let rows = channels + usize::from(with_weight);
        expect_room::<f64>(rows * self.x.len())?;
        let mut flux = vec![0.0; rows * self.x.len()];
        let mut parts = Vec::with_capacity(self.blocks.len());
        let mut rest = flux.as_mut_slice();
        for block in &self.blocks {
            let (part, after) = rest.split_at_mut(rows * block.length);
            parts.push((block, part));
            rest = after;
        }
        threads::rows(&mut parts, 64, self.x.len() * rows, |_, parts| {
            for (block, part) in parts {
                self.block_flux(image, block, part);
            }
        });
        Ok(flux)
    }

    /// That of one block, as many rows as `out` has room for: all channels and, if there is one more, the weight.
    pub fn block_flux<T: Texel>(&self, image: &ImageView<'_, T>, block: &Block, out: &mut [f64]) {
        let channels = image.channels();
        let points = block.start..block.start + block.length;
        let (index, weight) = (&self.index[points.clone()], &self.weight[points]);
        let (light, last) = out.split_at_mut(channels * block.length);
        for (k, (&index, &weight)) in index.iter().zip(weight).enumerate() {
            if index != NONE {
                let texel = image.texel(index as usize);
                for (c, value) in texel.iter().enumerate() {
                    light[c * block.length + k] = weight * value.load().to_f64();
                }
            }
        }
        if !last.is_empty() {
            last.copy_from_slice(weight);
        }
    }

    /// What `make` finds for an order, kept with the texels.
    pub(crate) fn moments(&self, order: usize, make: impl Fn() -> Vec<f64>) -> Arc<Vec<f64>> {
        let lock = || {
            let kept = self.moments.lock();
            kept.unwrap_or_else(std::sync::PoisonError::into_inner)
        };
        if let Some((_, found)) = lock().iter().find(|(o, _)| *o == order) {
            return Arc::clone(found);
        }
        let made = Arc::new(make());
        if interrupt::check().is_ok() {
            lock().push((order, Arc::clone(&made)));
        }
        made
    }
}
