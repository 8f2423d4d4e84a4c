//! Mip chains: an image and its smaller versions, each half as wide and high, in the same projection.
//!
//! A texel of a level is the mean, by solid angle, of the texels of the level before that its rectangle covers, whole or in
//! part; light is kept. Since every level is an image of the projection, lookups in it know its seams: that is what chains
//! made by halving a picture get wrong, at the left and right edge of a latlong as between the faces of a cube.
//!
//! A texel across a rim holds no value: what of the sphere it covers has that of the nearest texel that does
//! (`light::rim`). It is 0, as what converting does not reach.

use crate::error::Error;
use crate::image::raster::Raster;
use crate::image::rim;
use crate::image::texel::Texel;
use crate::image::view::ImageView;
use crate::kernel::Scalar;
use crate::kernel::memory::expect_room;
use crate::kernel::{interrupt, threads};
use crate::map::grid::GridAxis;
use crate::number::real::Real;

/// A smaller version of an image: its shape without channels, and its texels.
pub type Level<F> = (Vec<usize>, Vec<F>);

/// All levels but the first, down to faces of one texel along a side (two where the grid lies on corners).
///
/// # Errors
/// None for an image that is one.
///
/// ```
/// use spheremap::image::ImageView;
/// use spheremap::Map;
/// use spheremap::resample::chain;
///
/// let map = Map::new("cube")?;
/// let texels = vec![0.25_f32; 6 * 8 * 8];
/// let levels = chain(&ImageView::new(&map, &[6, 8, 8], 1, &texels)?)?;
/// assert_eq!(levels.len(), 3);
/// assert_eq!(levels[2], (vec![6, 1, 1], vec![0.25; 6]));
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn chain<T: Texel>(image: &ImageView<'_, T>) -> Result<Vec<Level<T::Float>>, Error> {
    let (map, channels) = (image.map(), image.channels());
    let mut levels = Vec::new();
    // Each takes a quarter of the one before.
    let mut rest = 0.25;
    let mut next = interrupt::part(0.0, 1.0 - rest, || half(image))?;
    while let Some(level) = next {
        let image = ImageView::new(map, &level.0, channels, &level.1)?;
        next = interrupt::part(1.0 - rest, 1.0 - 0.25 * rest, || half(&image))?;
        rest *= 0.25;
        levels.push(level);
    }
    Ok(levels)
}

/// The next level of an image, if it can be made smaller.
pub(crate) fn half<T: Texel>(image: &ImageView<'_, T>) -> Result<Option<Level<T::Float>>, Error> {
    let (map, shape, channels) = (image.map(), image.shape(), image.channels());
    let (fine, texels) = (*image.raster(), image.texels());
    if fine.width.min(fine.height) < 2 {
        return Ok(None);
    }
    let (rows, columns) = (map.face_layout().rows, map.face_layout().columns);
    let mut smaller = shape.to_vec();
    let n = smaller.len();
    smaller[n - 2] = fine.height / 2 * rows;
    smaller[n - 1] = fine.width / 2 * columns;
    let Ok(coarse) = Raster::new(map, &smaller) else {
        return Ok(None);
    };
    let wanted = coarse.faces() * coarse.height * coarse.width;
    expect_room::<f64>(fine.width * fine.height + wanted * (1 + 3 * channels))?;
    let weights = interrupt::part(0.0, 0.25, || rim::face_solid_angles(map, &fine));
    let across = shares(fine.along_u, fine.width, coarse.along_u, coarse.width);
    let down = shares(fine.along_v, fine.height, coarse.along_v, coarse.height);
    let value = |k: usize, c: usize| texels[k * channels + c].load().to_f64();
    // For each texel of each face: its weight, and for each channel the first value and the sum of what the others
    // differ by, so that a constant stays constant to the bit.
    let width = 1 + 2 * channels;
    if !fine.has_rim() && !coarse.has_rim() {
        let mut out = vec![<T::Float as Real>::new(0.0); coarse.texels() * channels];
        let work = |row: usize, out: &mut [T::Float]| {
            let mut sums = vec![0.0; width];
            for run in coarse.runs(row) {
                let Some((face, start, step)) = run.face else {
                    continue;
                };
                let view = fine.view(face);
                let out = &mut out[run.column * channels..][..run.length * channels];
                for (k, out) in out.chunks_exact_mut(channels).enumerate() {
                    let [i, j] = [0, 1].map(|c| (start[c] + k as isize * step[c]) as usize);
                    sums[0] = 0.0;
                    for &(y, part_v) in &down[j] {
                        for &(x, part_u) in &across[i] {
                            let weight = weights[y * fine.width + x] * part_u * part_v;
                            if weight > 0.0 {
                                let k = view.index(x, y);
                                add(&mut sums, weight, |c| value(k, c));
                            }
                        }
                    }
                    if sums[0] > 0.0 {
                        finish::<T>(&sums, out);
                    }
                }
            }
        };
        interrupt::part(0.25, 1.0, || {
            threads::rows(&mut out, coarse.columns * channels, fine.texels(), work);
        });
        return Ok(Some((smaller, out)));
    }
    let mut sums = vec![0.0; wanted * width];
    let work = |row: usize, out: &mut [f64]| {
        let (face, j) = (row / coarse.height, row % coarse.height);
        let view = fine.view(face);
        for (i, out) in out.chunks_exact_mut(width).enumerate() {
            for &(y, part_v) in &down[j] {
                for &(x, part_u) in &across[i] {
                    let weight = weights[y * fine.width + x] * part_u * part_v;
                    if weight > 0.0 {
                        // Of a texel across the rim the part belongs here, and the value to another.
                        let (x, y) = rim::nearest_valid_texel(&fine, x, y);
                        let k = view.index(x, y);
                        add(out, weight, |c| value(k, c));
                    }
                }
            }
        }
    };
    interrupt::part(0.25, 0.75, || {
        threads::rows(&mut sums, coarse.width * width, fine.texels(), work);
    });
    let place =
        |face: usize, i: usize, j: usize| ((face * coarse.height + j) * coarse.width + i) * width;
    let mut out = vec![<T::Float as Real>::new(0.0); coarse.texels() * channels];
    for face in 0..coarse.faces() {
        for j in 0..coarse.height {
            for i in 0..coarse.width {
                let (a, b) = rim::nearest_valid_texel(&coarse, i, j);
                if (a, b) != (i, j) {
                    let own = sums[place(face, i, j)..][..width].to_vec();
                    if own[0] > 0.0 {
                        let held = &mut sums[place(face, a, b)..][..width];
                        add(held, own[0], |c| own[1 + 2 * c] + own[2 + 2 * c] / own[0]);
                    }
                }
            }
        }
        for j in 0..coarse.height {
            for i in 0..coarse.width {
                let own = &sums[place(face, i, j)..][..width];
                if own[0] > 0.0 {
                    let at = coarse.view(face).index(i, j) * channels;
                    finish::<T>(own, &mut out[at..at + channels]);
                }
            }
        }
    }
    Ok(Some((smaller, out)))
}

fn add(sums: &mut [f64], weight: f64, value: impl Fn(usize) -> f64) {
    let new = sums[0] == 0.0;
    sums[0] += weight;
    for (c, sum) in sums[1..].chunks_exact_mut(2).enumerate() {
        if new {
            (sum[0], sum[1]) = (value(c), 0.0);
        }
        sum[1] += weight * (value(c) - sum[0]);
    }
}

/// Writes the mean that these sums are of, channel by channel.
fn finish<T: Texel>(sums: &[f64], out: &mut [T::Float]) {
    for (sum, out) in sums[1..].chunks_exact(2).zip(out) {
        *out = <T::Float as Real>::new(sum[0] + sum[1] / sums[0]);
    }
}

/// For each coarse cell along a side, the fine cells that it covers and which part of each.
fn shares(fine: GridAxis, count: usize, coarse: GridAxis, wanted: usize) -> Vec<Vec<(usize, f64)>> {
    let mut first = 0;
    (0..wanted)
        .map(|i| {
            let (low, high) = coarse.cell(i);
            while first + 1 < count && fine.cell(first).1 <= low {
                first += 1;
            }
            (first..count)
                .map(|k| (k, fine.cell(k)))
                .take_while(|(_, (from, _))| *from < high)
                .map(|(k, (from, to))| (k, (high.min(to) - low.max(from)) / (to - from)))
                // What rounding lets two edges that coincide have in common is nothing.
                .filter(|(_, part)| *part > 1e-9)
                .collect()
        })
        .collect()
}
