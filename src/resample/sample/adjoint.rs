//! What flows back from lookups: to the texels, and to the places that were looked up.
//!
//! A lookup is a sum of texels by weights; its adjoint adds what comes back to the same texels by the same weights. So both have one
//! source: `place` finds windows inside a face, `border` what stands for the others. Each texel is summed in the order of the lookups,
//! whatever the number of threads: places of many lookups are found by all threads, and then each thread goes through all of them
//! and adds to rows of its own. Rows go to threads in narrow stripes, since lookups that follow each other see the same part of an image.
//!
//! What did not help: a sparse matrix, of which the transposed product took four times as long as the lookups that it came from.

use super::place::{Places, Support};
use super::taps::Taps;
use super::texture::Texture;
use crate::error::{Error, expect_length};
use crate::geometry::axes::Rotation;
use crate::image::raster::Raster;
use crate::image::texel::Texel;
use crate::image::view::ImageView;
use crate::kernel::tile::{TILE, Tile, Tuples, prefetch_item};
use crate::kernel::{Scalar, threads};
use crate::map::Map;
use crate::map::verbs::EncodeTile;
use crate::number::real::Real;
use crate::projections::projection::{Outline, Seam};
use crate::resample::filters::claims::{Kernel, Visitor};
use crate::resample::filters::{Filter, LookupFilter};

/// Lookups of one block, which one thread places.
const BLOCK: usize = 8 * TILE;

/// Blocks that are placed before texels are added to.
const BLOCKS: usize = 16;

/// Rows that follow each other and have one thread.
const STRIPE: usize = 8;

/// How many lookups ahead texels are asked for.
const AHEAD: usize = 12;

/// The row of a lookup that sees no window inside a face.
const NO_ROW: u32 = u32::MAX;

/// Lookups in images of one map and shape, texels of one number.
struct Lookups<'a, T> {
    texture: Texture<'a, T>,
    turn: Rotation,
    filter: LookupFilter,
    support: Support,
}

impl<'a, T: Texel<Float = T> + Scalar> Lookups<'a, T> {
    fn new(texture: Texture<'a, T>, filter: LookupFilter) -> Self {
        let support = match filter {
            LookupFilter::Nearest => Support::NEAREST,
            _ => Support::PAIR,
        };
        Lookups {
            turn: texture.map.view_rotation(None),
            texture,
            filter,
            support,
        }
    }

    /// How many texels rows are apart where windows inside a face are added to as they lie. Wide filters are texels and weights.
    fn straight(&self) -> Option<usize> {
        let narrow = matches!(self.filter, LookupFilter::Nearest | LookupFilter::Bilinear);
        self.texture.raster.straight().filter(|_| narrow)
    }

    /// Finds the windows of at most a tile of directions.
    fn place<R: Scalar>(&self, directions: &[R], uv: &mut Tile<R, 3>, places: &mut Places<T>) {
        let (raster, count) = (&self.texture.raster, directions.len() / 3);
        self.texture.map.visit_canonical(EncodeTile {
            turn: self.turn,
            input: Tuples::of(directions),
            output: uv,
        });
        let safe = self.texture.safe(self.support);
        places.set((raster, 1), self.support, safe, uv, count);
        if raster.outline == Outline::Shape {
            places.leave_out_rim(raster, self.support, uv, count);
        }
    }

    /// The texels and weights of a place; none where it is nowhere.
    fn weigh(&self, taps: &mut Taps, [u, v, face]: [f64; 3]) {
        if !u.is_nan() {
            self.filter.visit(Weigh {
                texture: &self.texture,
                taps,
                face: face as usize,
                uv: [u, v],
            });
        }
    }
}

struct Weigh<'l, 'a, T> {
    texture: &'l Texture<'a, T>,
    taps: &'l mut Taps,
    face: usize,
    uv: [f64; 2],
}

impl<T: Texel> Visitor for Weigh<'_, '_, T> {
    type Output = ();
    fn nearest(self) {
        self.taps
            .push(self.texture.nearest(self.face, self.uv), 1.0);
    }
    fn bilinear(self) {
        self.texture.resolve(self.taps, self.face, self.uv, 1.0);
    }
    fn separable<K: Kernel<TAPS>, const TAPS: usize>(self) {
        let kernel = K::weights;
        self.texture.window(self.taps, self.face, self.uv, kernel);
    }
}

/// The places of some lookups.
struct Block<T> {
    /// The stored row of the upper left texel of each, and its column.
    rows: Vec<u32>,
    columns: Vec<u32>,
    x: Vec<T>,
    y: Vec<T>,
    /// Which lookup sees which texel by how much, of those that have no window.
    others: Vec<(usize, usize, T)>,
}

impl<T: Texel<Float = T> + Scalar> Block<T> {
    fn new() -> Self {
        Block {
            rows: Vec::with_capacity(BLOCK),
            columns: Vec::with_capacity(BLOCK),
            x: Vec::with_capacity(BLOCK),
            y: Vec::with_capacity(BLOCK),
            others: Vec::new(),
        }
    }

    fn clear(&mut self) {
        self.rows.clear();
        self.columns.clear();
        self.x.clear();
        self.y.clear();
        self.others.clear();
    }

    fn place<R: Scalar>(&mut self, lookups: &Lookups<'_, T>, directions: &[R]) {
        self.clear();
        let straight = lookups.straight();
        let over = 1.0 / straight.unwrap_or(1) as f64;
        let (mut uv, mut places) = (Tile::<R, 3>::new(), Places::<T>::new());
        for (tile, directions) in directions.chunks(3 * TILE).enumerate() {
            let count = directions.len() / 3;
            lookups.place(directions, &mut uv, &mut places);
            self.x.extend_from_slice(&places.tx[..count]);
            self.y.extend_from_slice(&places.ty[..count]);
            for k in 0..count {
                let (mut row, mut column) = (NO_ROW, 0);
                match straight {
                    Some(columns) if places.inside[k] => {
                        // The middle of a texel is farther from a whole number than rounding is.
                        let found = ((places.first[k] as f64 + 0.5) * over) as usize;
                        row = found as u32;
                        column = (places.first[k] - found * columns) as u32;
                    }
                    _ => {
                        let mut taps = Taps::new();
                        lookups.weigh(&mut taps, uv.at(k).map(Scalar::to_f64));
                        let seen = taps.list().iter();
                        let lookup = tile * TILE + k;
                        self.others
                            .extend(seen.map(|&(texel, weight)| (lookup, texel, T::new(weight))));
                    }
                }
                self.rows.push(row);
                self.columns.push(column);
            }
        }
    }
}

/// Adds what comes back of a block to rows, of which those of other threads are empty.
struct Adding<'r, 'a, T> {
    rows: &'r mut [&'a mut [T]],
    channels: usize,
    columns: usize,
}

impl<T: Texel<Float = T> + Scalar> Adding<'_, '_, T> {
    fn bilinear<const CHANNELS: usize>(&mut self, block: &Block<T>, gradient: &[T]) {
        let channels = if CHANNELS > 0 {
            CHANNELS
        } else {
            self.channels
        };
        let one = T::ONE;
        let lookups = block.rows.iter().zip(&block.columns);
        let lookups = lookups.zip(block.x.iter().zip(&block.y));
        let lookups = lookups.zip(gradient.chunks_exact(channels));
        for (k, (((&row, &column), (&x, &y)), back)) in lookups.enumerate() {
            if let (Some(&row), Some(&column)) =
                (block.rows.get(k + AHEAD), block.columns.get(k + AHEAD))
            {
                for row in [row as usize, (row as usize).wrapping_add(1)] {
                    if let Some(row) = self.rows.get(row) {
                        prefetch_item(row, column as usize * channels);
                    }
                }
            }
            let first = column as usize * channels;
            for (row, share) in [(row as usize, one - y), ((row as usize).wrapping_add(1), y)] {
                let row = self.rows.get_mut(row);
                let Some(pair) = row.and_then(|row| row.get_mut(first..first + 2 * channels))
                else {
                    continue;
                };
                let (left, right) = pair.split_at_mut(channels);
                let (a, b) = (share * (one - x), share * x);
                for ((left, right), &back) in left.iter_mut().zip(right).zip(back) {
                    *left = *left + a * back;
                    *right = *right + b * back;
                }
            }
        }
    }

    fn nearest(&mut self, block: &Block<T>, gradient: &[T]) {
        let lookups = block.rows.iter().zip(&block.columns);
        for ((&row, &column), back) in lookups.zip(gradient.chunks_exact(self.channels)) {
            self.add(row as usize, column as usize, T::ONE, back);
        }
    }

    fn others(&mut self, block: &Block<T>, gradient: &[T]) {
        for &(lookup, texel, weight) in &block.others {
            let back = &gradient[lookup * self.channels..][..self.channels];
            self.add(texel / self.columns, texel % self.columns, weight, back);
        }
    }

    fn add(&mut self, row: usize, column: usize, weight: T, back: &[T]) {
        let first = column * self.channels;
        let row = self.rows.get_mut(row);
        if let Some(texel) = row.and_then(|row| row.get_mut(first..first + self.channels)) {
            for (texel, &back) in texel.iter_mut().zip(back) {
                *texel = *texel + weight * back;
            }
        }
    }
}

/// The adjoint of [`sample`](crate::resample::sample): what flows back to the texels of an image from what was looked up in it.
///
/// With any filter of lookups, for `gradient` with as many numbers for each of `directions` as a texel has. `texels` are written.
/// ⟨A x, y⟩ = ⟨x, Aᵀ y⟩ to rounding, across seams and rims too, and the bits are those of any number of threads.
///
/// # Errors
/// For other filters than those of lookups, and lengths that do not fit.
///
/// ```
/// use spheremap::Map;
/// use spheremap::resample::{Filter, sample_adjoint};
/// let map = Map::new("latlong")?;
/// let mut texels = [0.0_f64; 8];
/// // Straight ahead, between four texels of the two rows.
/// sample_adjoint(&map, &[2, 4], Filter::Bilinear, &[0.0, 0.0, -1.0], &[1.0], &mut texels)?;
/// assert_eq!(texels, [0.0, 0.25, 0.25, 0.0, 0.0, 0.25, 0.25, 0.0]);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn sample_adjoint<T: Texel<Float = T> + Scalar, R: Scalar>(
    map: &Map,
    shape: &[usize],
    filter: Filter,
    directions: &[R],
    gradient: &[T],
    texels: &mut [T],
) -> Result<(), Error> {
    let filter = filter.of_points()?;
    let raster = Raster::new(map, shape)?;
    let channels = texels.len() / raster.texels();
    let count = directions.len() / 3;
    expect_length("texels", texels.len(), raster.texels() * channels)?;
    expect_length("directions", directions.len(), 3 * count)?;
    expect_length("gradient", gradient.len(), count * channels)?;
    texels.fill(T::default());
    if channels == 0 {
        return Ok(());
    }
    let texture = Texture::geometry(map, &raster, 1);
    let lookups = Lookups::new(texture, filter);
    let mut owners = owned(texels, raster.columns * channels);
    let mut blocks: Vec<Block<T>> = (0..BLOCKS.min(count.div_ceil(BLOCK)))
        .map(|_| Block::new())
        .collect();
    let chunks = directions.chunks(3 * BLOCK * BLOCKS);
    for (directions, gradient) in chunks.zip(gradient.chunks(channels * BLOCK * BLOCKS)) {
        let used = (directions.len() / 3).div_ceil(BLOCK);
        let blocks = &mut blocks[..used];
        let work = blocks.iter_mut().zip(directions.chunks(3 * BLOCK));
        threads::each(count, work, |(block, directions)| {
            block.place(&lookups, directions);
        });
        let blocks = &*blocks;
        threads::each(count, owners.iter_mut(), |rows| {
            let mut adding = Adding {
                rows,
                channels,
                columns: raster.columns,
            };
            for (block, gradient) in blocks.iter().zip(gradient.chunks(channels * BLOCK)) {
                match (filter, channels) {
                    (LookupFilter::Nearest, _) => adding.nearest(block, gradient),
                    (_, 1) => adding.bilinear::<1>(block, gradient),
                    (_, 3) => adding.bilinear::<3>(block, gradient),
                    (_, 4) => adding.bilinear::<4>(block, gradient),
                    _ => adding.bilinear::<0>(block, gradient),
                }
                adding.others(block, gradient);
            }
        });
    }
    Ok(())
}

/// The rows of each thread; those of others are empty.
fn owned<T>(texels: &mut [T], width: usize) -> Vec<Vec<&mut [T]>> {
    let count = threads::count().max(1);
    let mut owners: Vec<Vec<&mut [T]>> = (0..count).map(|_| Vec::new()).collect();
    for (number, row) in texels.chunks_mut(width).enumerate() {
        let mut row = Some(row);
        for (owner, rows) in owners.iter_mut().enumerate() {
            let own = number / STRIPE % count == owner;
            rows.push(own.then(|| row.take()).flatten().unwrap_or_default());
        }
    }
    owners
}

/// What flows back to (u, v) of a face from bilinear lookups in an image: two numbers for each of `directions`.
///
/// `gradient` has as many numbers for each direction as a texel has. Between four texels of a face a lookup is linear along u and along
/// v; so it is beside the border of an image that is one rectangle. Where lookups have rules of their own, at rims and beside edges of
/// faces, it is NaN; outside the coverage nothing changes, and it is 0.
///
/// # Errors
/// For lengths that do not fit.
///
/// ```
/// use spheremap::Map;
/// use spheremap::image::ImageView;
/// use spheremap::resample::sample_slopes;
/// let map = Map::new("latlong")?;
/// let image = ImageView::new(&map, &[2, 4], 1, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0])?;
/// let mut slopes = [0.0; 2];
/// sample_slopes(&image, &[0.0, 0.0, -1.0], &[1.0], &mut slopes)?;
/// assert_eq!(slopes, [4.0, 8.0]); // a texel more along u is 1 of 4 of it, along v 4 of 2
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn sample_slopes<T: Texel<Float = T> + Scalar, R: Scalar>(
    image: &ImageView<'_, T>,
    directions: &[R],
    gradient: &[T],
    slopes: &mut [T],
) -> Result<(), Error> {
    let (channels, count) = (image.channels(), directions.len() / 3);
    expect_length("directions", directions.len(), 3 * count)?;
    expect_length("gradient", gradient.len(), count * channels)?;
    expect_length("slopes", slopes.len(), 2 * count)?;
    if channels == 0 {
        slopes.fill(T::default());
        return Ok(());
    }
    let texture = Texture::new(image);
    let lookups = Lookups::new(texture, LookupFilter::Bilinear);
    let parts = directions.chunks(3 * BLOCK);
    let parts = parts.zip(gradient.chunks(channels * BLOCK));
    threads::each(
        count,
        parts.zip(slopes.chunks_mut(2 * BLOCK)),
        |((directions, gradient), slopes)| match channels {
            1 => of_block::<T, R, 1>(&lookups, directions, gradient, slopes),
            3 => of_block::<T, R, 3>(&lookups, directions, gradient, slopes),
            4 => of_block::<T, R, 4>(&lookups, directions, gradient, slopes),
            _ => of_block::<T, R, 0>(&lookups, directions, gradient, slopes),
        },
    );
    Ok(())
}

fn of_block<T: Texel<Float = T> + Scalar, R: Scalar, const CHANNELS: usize>(
    lookups: &Lookups<'_, T>,
    directions: &[R],
    gradient: &[T],
    slopes: &mut [T],
) {
    let texture = &lookups.texture;
    let channels = if CHANNELS > 0 {
        CHANNELS
    } else {
        texture.channels
    };
    let raster = &texture.raster;
    let scales = [raster.along_u.index().0, raster.along_v.index().0].map(T::new);
    let straight = lookups.straight();
    let (mut uv, mut places) = (Tile::<R, 3>::new(), Places::<T>::new());
    let tiles = directions.chunks(3 * TILE);
    let tiles = tiles.zip(gradient.chunks(channels * TILE));
    for ((directions, gradient), slopes) in
        tiles.zip(slopes.as_chunks_mut::<2>().0.chunks_mut(TILE))
    {
        lookups.place(directions, &mut uv, &mut places);
        for (k, slope) in slopes.iter_mut().enumerate() {
            if let (Some(row), Some(&first)) = (straight, places.first.get(k + AHEAD)) {
                for first in [first, first.wrapping_add(row)] {
                    prefetch_item(texture.texels, first.wrapping_mul(channels));
                }
            }
            let back = &gradient[k * channels..][..channels];
            let window = straight.filter(|_| places.inside[k]).map(|row| {
                let first = places.first[k];
                [first, first + 1, first + row, first + row + 1]
            });
            let ([a, b, c, d], x, y) = if let Some(window) = window {
                let corners = window.map(|texel| {
                    let numbers = &texture.texels[texel * channels..][..channels];
                    dot(numbers, back)
                });
                (corners, places.tx[k], places.ty[k])
            } else {
                let [u, v, face] = uv.at(k).map(Scalar::to_f64);
                if u.is_nan() {
                    *slope = [T::default(); 2];
                    continue;
                }
                match beside_border(texture, face as usize, [u, v], back) {
                    Some(found) => found,
                    None => {
                        *slope = [T::NAN; 2];
                        continue;
                    }
                }
            };
            let one = T::ONE;
            let by_u = (b - a) * (one - y) + (d - c) * y;
            let by_v = (c - a) * (one - x) + (d - b) * x;
            *slope = [by_u * scales[0], by_v * scales[1]];
        }
    }
}

#[inline(always)]
fn dot<T: Real>(a: &[T], b: &[T]) -> T {
    let pairs = a.iter().zip(b);
    pairs.fold(T::ZERO, |sum, (&a, &b)| sum + a * b)
}

/// Four texels about a place beside the border of a rectangle, of each the product with what comes back, and the place between them.
/// None where a lookup has rules of its own.
#[cold]
#[inline(never)]
fn beside_border<T: Texel<Float = T> + Scalar>(
    texture: &Texture<'_, T>,
    face: usize,
    uv: [f64; 2],
    back: &[T],
) -> Option<([T; 4], T, T)> {
    let raster = &texture.raster;
    if texture.seam == Seam::Faces || raster.faces() > 1 || raster.has_rim() {
        return None;
    }
    let [x, y] = texture.place(uv);
    let (left, top) = (x.floor(), y.floor());
    let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(di, dj)| {
        let (i, j) = (left as isize + di, top as isize + dj);
        let mut taps = Taps::new();
        if raster.holds(i, j) {
            taps.push(raster.view(face).index(i as usize, j as usize), 1.0);
        } else {
            texture.beyond(&mut taps, face, i, j, 1.0);
        }
        let terms = taps.list().iter().map(|&(texel, weight)| {
            let numbers = &texture.texels[texel * texture.channels..][..texture.channels];
            T::new(weight) * dot(numbers, back)
        });
        terms.fold(T::ZERO, |sum, term| sum + term)
    });
    Some((corners, T::new(x - left), T::new(y - top)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::resample::{Options, sample};

    /// ⟨A x, y⟩ and ⟨x, Aᵀ y⟩ of lookups in every direction of a lattice.
    #[test]
    fn it_is_the_adjoint_of_what_sample_does() {
        let directions: Vec<f64> = (0..300)
            .flat_map(|k| {
                let (z, phi) = (1.0 - (2 * k + 1) as f64 / 300.0, 2.4 * k as f64);
                let r = (1.0 - z * z).sqrt();
                [r * phi.cos(), r * phi.sin(), z]
            })
            .collect();
        let number = |k: usize| (k * 7919 % 101) as f64 / 101.0;
        for (name, shape) in [
            ("latlong", vec![6, 12]),
            ("cube", vec![6, 5, 5]),
            ("sphere", vec![9, 9]),
            ("mollweide", vec![8, 16]),
        ] {
            let map = Map::new(name).unwrap();
            let texels: usize = shape.iter().product();
            let x: Vec<f64> = (0..3 * texels).map(number).collect();
            let y: Vec<f64> = (0..900).map(|k| number(k + 5)).collect();
            let image = ImageView::new(&map, &shape, 3, &x).unwrap();
            for filter in [Filter::Bilinear, Filter::Nearest, Filter::CatmullRom] {
                let options = Options::new().filter(filter);
                let (mut seen, mut back) = (vec![0.0; 900], vec![0.0; 3 * texels]);
                sample(&image, &directions, &options, &mut seen).unwrap();
                sample_adjoint(&map, &shape, filter, &directions, &y, &mut back).unwrap();
                let left: f64 = seen.iter().zip(&y).map(|(a, b)| a * b).sum();
                let right: f64 = x.iter().zip(&back).map(|(a, b)| a * b).sum();
                // Two sums of some thousand products of numbers up to 1.
                assert!((left - right).abs() < 1e-12 * left, "{name} {left} {right}");
            }
        }
    }
}
