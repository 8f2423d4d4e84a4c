//! The texels of an image as points of a quadrature: directions and weights, in blocks.
//!
//! What a texel counts with: [`crate::light::patches`].
//!
//! Blocks are squares of [`SIDE`]² texels of one face, so that a block is a small patch of the sphere: it has
//! an axis and a radius, and sums over the sphere can often deal with a block as a whole. Each is stored
//! as rows of numbers (x, y, z, weight), filled up to a multiple of [`LANES`] with points of weight 0.
//!
//! Finding all this takes longer than most sums over it, so the last few are kept, up to [`KEPT`] texels.

use crate::error::Error;
use crate::image::ImageView;
use crate::image::texel::Texel;
use crate::kernel::interrupt;
use crate::kernel::memory::expect_room;
use crate::kernel::threads;
use crate::kernel::tile::TILE;
use crate::light::kept::Kept;
use crate::light::patches::{self, LANES, NONE, Patches, Points, SIDE, Sheet};
use crate::map::Map;
use std::sync::{Arc, Mutex};

/// How many texels are remembered, over all images.
const KEPT: usize = 1 << 21;

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

impl Block {
    /// Of points in these directions.
    fn new(start: usize, count: usize, direction: &[[f64; TILE]; 3]) -> Block {
        let mut sum = [0.0; 3];
        for (sum, row) in sum.iter_mut().zip(direction) {
            row[..count].iter().for_each(|x| *sum += x);
        }
        let size = (sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]).sqrt();
        let (mut axis, mut cos_radius) = ([0.0, 0.0, 1.0], -1.0_f64);
        if size > 1e-3 * count as f64 {
            axis = sum.map(|s| s / size);
            let [x, y, z] = direction;
            cos_radius = (0..count)
                .map(|k| axis[0] * x[k] + axis[1] * y[k] + axis[2] * z[k])
                .fold(1.0, f64::min);
        }
        Block {
            start,
            length: count.next_multiple_of(LANES),
            axis,
            cos_radius,
        }
    }
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
    index: Vec<usize>,
    /// The blocks.
    pub blocks: Vec<Block>,
    /// Which blocks lie in each sheet, in their order.
    pub sheets: Vec<Vec<usize>>,
    /// How many texels the image stores.
    pub stored: usize,
    /// Sums of spherical harmonics over the points, by order.
    moments: Mutex<Vec<(usize, Arc<Vec<f64>>)>>,
}

static LAST: Kept<Texels> = Kept::new(KEPT);

/// The texels of an image of this map and shape.
pub fn texels(map: &Map, shape: &[usize]) -> Result<Arc<Texels>, Error> {
    LAST.of(
        map,
        shape,
        |texels| texels.stored,
        || Texels::new(map, shape),
    )
}

impl Texels {
    fn new(map: &Map, shape: &[usize]) -> Result<Texels, Error> {
        let patches = interrupt::part(0.0, 0.25, || Patches::new(map, shape, true))?;
        Texels::of(&patches, &patches.whole(), &patches.sheets())
    }

    /// Those of a sheet alone.
    pub fn of_sheet(patches: &Patches<'_>, sheet: &Sheet) -> Result<Texels, Error> {
        Texels::of(patches, sheet, std::slice::from_ref(sheet))
    }

    /// Those of a rectangle of patches, which is made of sheets.
    fn of(patches: &Patches<'_>, part: &Sheet, sheets: &[Sheet]) -> Result<Texels, Error> {
        let Sheet {
            strips: of_strips,
            columns,
        } = part;
        let (across, strips) = (columns.len(), of_strips.len());
        let stored = patches.raster().texels();
        let work = across * strips * SIDE * SIDE;
        // How many texels of each patch hold a value.
        let mut counts = vec![0; strips * across];
        threads::rows(&mut counts, across, work, |strip, counts| {
            let weights = patches.strip_weights(of_strips.start + strip, columns);
            for row in weights.rows() {
                for (count, row) in counts.iter_mut().zip(row.chunks(SIDE)) {
                    *count += row.iter().filter(|weight| **weight > 0.0).count();
                }
            }
        });
        let room = |count: &usize| count.next_multiple_of(LANES);
        let all: usize = counts.iter().map(room).sum();
        expect_room::<[f64; 5]>(all)?;
        let mut axes = [0, 1, 2].map(|_| vec![0.0; all]);
        let (mut weight, mut index) = (vec![0.0; all], vec![NONE; all]);
        let mut slices = Vec::with_capacity(counts.len());
        {
            let [x, y, z] = &mut axes;
            let mut rest = (
                &mut x[..],
                &mut y[..],
                &mut z[..],
                &mut weight[..],
                &mut index[..],
            );
            let mut start = 0;
            for count in &counts {
                let n = room(count);
                let (x, xs) = rest.0.split_at_mut(n);
                let (y, ys) = rest.1.split_at_mut(n);
                let (z, zs) = rest.2.split_at_mut(n);
                let (weight, weights) = rest.3.split_at_mut(n);
                let (index, indices) = rest.4.split_at_mut(n);
                rest = (xs, ys, zs, weights, indices);
                slices.push((start, *count, [x, y, z, weight], index, None));
                start += n;
            }
        }
        interrupt::part(0.25, 1.0, || {
            threads::rows(&mut slices, across, work, |strip, slices| {
                let strip = of_strips.start + strip;
                let weights = patches.strip_weights(strip, columns);
                let mut points = Points::new();
                for (column, (start, count, numbers, index, block)) in slices.iter_mut().enumerate()
                {
                    if *count == 0 {
                        continue;
                    }
                    let column = columns.start + column;
                    patches.points(strip, column, &weights, true, &mut points);
                    let length = index.len();
                    let [x, y, z] = &points.direction.0;
                    for (to, from) in numbers.iter_mut().zip([x, y, z, &points.weight]) {
                        to.copy_from_slice(&from[..length]);
                    }
                    index.copy_from_slice(&points.index[..length]);
                    *block = Some(Block::new(*start, *count, &points.direction.0));
                }
            });
        });
        let blocks: Vec<Block> = slices.into_iter().filter_map(|slices| slices.4).collect();
        interrupt::check()?;
        // Patches that hold nothing are no blocks.
        let mut number = vec![NONE; counts.len()];
        let filled = (0..counts.len()).filter(|&k| counts[k] > 0);
        filled.enumerate().for_each(|(n, k)| number[k] = n);
        let in_sheet = |sheet: &Sheet| -> Vec<usize> {
            let places = sheet.strips.clone().flat_map(|strip| {
                let row = (strip - of_strips.start) * across;
                sheet.columns.clone().map(move |c| row + c - columns.start)
            });
            let numbers = places.map(|place| number[place]);
            numbers.filter(|n| *n != NONE).collect()
        };
        let [x, y, z] = axes;
        Ok(Texels {
            x,
            y,
            z,
            weight,
            index,
            blocks,
            sheets: sheets.iter().map(in_sheet).collect(),
            stored,
            moments: Mutex::default(),
        })
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
        let points = block.start..block.start + block.length;
        patches::flux(
            image,
            &self.index[points.clone()],
            &self.weight[points],
            out,
        );
    }

    /// Numbers of the points, `channels` each, as an image stores them: 0 of texels that hold no value.
    pub fn stored(&self, numbers: &[f64], channels: usize) -> Vec<f64> {
        let mut out = vec![0.0; self.stored * channels];
        let points = numbers.chunks_exact(channels).zip(&self.index);
        for (numbers, index) in points.filter(|(_, index)| **index != NONE) {
            out[*index * channels..][..channels].copy_from_slice(numbers);
        }
        out
    }

    /// The directions of a block, by components.
    pub fn directions(&self, block: &Block) -> [&[f64]; 3] {
        let points = block.start..block.start + block.length;
        [&self.x, &self.y, &self.z].map(|axis| &axis[points.clone()])
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
