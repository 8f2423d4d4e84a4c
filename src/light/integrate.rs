//! Integrals over the sphere: ∫ L dω and ∫ L ω dω.
//!
//! dω is sin θ dθ dφ; in an image it is the exact solid angle of a texel ([`crate::light::patches`]). Sums are f64:
//! eight lanes within a block of 256 texels, lanes as a tree, the blocks of a sheet as a tree, sheets as a tree. The order
//! depends on the image's shape alone.

use crate::error::Error;
use crate::image::ImageView;
use crate::image::texel::Texel;
use crate::kernel;
use crate::kernel::SimdWork;
use crate::kernel::interrupt;
use crate::kernel::memory::expect_room;
use crate::kernel::threads;
use crate::light::full;
use crate::light::patches::{LANES, Patches, Points, ROOM, Sheet, add_lanes, flux};
use crate::light::texels::{Texels, texels};
use fearless_simd::{Simd, SimdBase, f64x8};

/// ∫ f dω and the three components of ∫ f ω dω.
pub type Moments = [f64; 4];

/// The integral of an image over the sphere, ∫ L dω: one number a channel.
///
/// # Errors
/// There is no memory for it.
///
/// ```
/// use spheremap::{Map, image::ImageView, light::integrate};
/// let map = Map::new("octahedral")?;
/// let white = vec![1.0_f32; 8 * 8];
/// let total = integrate(&ImageView::new(&map, &[8, 8], 1, &white)?)?;
/// assert!((total[0] - 4.0 * std::f64::consts::PI).abs() < 1e-12);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn integrate<T: Texel>(image: &ImageView<'_, T>) -> Result<Vec<f64>, Error> {
    let mut integrals = integrals(image)?;
    integrals.pop();
    Ok(integrals)
}

/// The integral of every channel of an image and, last, of the constant 1.
///
/// # Errors
/// There is no memory for it.
pub fn integrals<T: Texel>(image: &ImageView<'_, T>) -> Result<Vec<f64>, Error> {
    Ok(summed(image)?.into_iter().map(|[sum]| sum).collect())
}

/// The moments of every channel of an image and, last, of the constant 1: its integral, and the sum of its directions, each as
/// long as the light from it.
///
/// # Errors
/// There is no memory for it.
///
/// ```
/// use spheremap::{Map, image::ImageView, light::moments};
/// let map = Map::new("octahedral")?;
/// let white = vec![2.0_f32; 8 * 8];
/// let moments = moments(&ImageView::new(&map, &[8, 8], 1, &white)?)?;
/// assert!((moments[0][0] - 8.0 * std::f64::consts::PI).abs() < 1e-12);
/// // Light from everywhere comes from nowhere in particular.
/// assert!(moments[0][1..].iter().all(|sum| sum.abs() < 1e-12));
/// assert_eq!(moments[0][0], 2.0 * moments[1][0]);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn moments<T: Texel>(image: &ImageView<'_, T>) -> Result<Vec<Moments>, Error> {
    summed(image)
}

/// Images of so many texels are summed by the list that is kept of them: they come again and again. Of more, making the list
/// takes longer than several sums without one.
const LISTED: usize = 1 << 19;

/// The first moments of every channel and of the constant 1.
fn summed<T: Texel, const N: usize>(image: &ImageView<'_, T>) -> Result<Vec<[f64; N]>, Error> {
    let rows = image.channels() + 1;
    let sheets: Vec<[f64; N]> = if image.raster().texels() <= LISTED {
        sheets_by_list(image)?
    } else {
        let patches = Patches::new(image.map(), image.shape(), false)?;
        let all = moments_by_patch(image, &patches, &patches.whole())?;
        let across = patches.across;
        let sheets = patches.sheets();
        let of = |sheet: &Sheet| {
            let strips = sheet.strips.clone();
            let parts = strips.flat_map(|strip| {
                let row = &all[rows * across * strip..][..rows * across];
                &row[rows * sheet.columns.start..rows * sheet.columns.end]
            });
            sum_of_patches(parts.copied().collect(), rows)
        };
        sheets.iter().flat_map(of).collect()
    };
    Ok((0..rows).map(|row| tree(&sheets[row..], rows)).collect())
}

/// The moments of every channel of a sheet and, last, of the constant 1: what the whole is the tree of ([`add_sheets`]). Nothing
/// else of the image is looked at.
///
/// # Errors
/// There is no memory for it.
pub fn moments_of_sheet<T: Texel, const N: usize>(
    image: &ImageView<'_, T>,
    patches: &Patches<'_>,
    sheet: &Sheet,
) -> Result<Vec<[f64; N]>, Error> {
    let all = moments_by_patch(image, patches, sheet)?;
    Ok(sum_of_patches(all, image.channels() + 1))
}

/// The sum of what was found of each sheet, `per` numbers each.
pub fn add_sheets(parts: &[f64], per: usize) -> Vec<f64> {
    let n = parts.len() / per.max(1);
    if n <= 1 {
        return parts.to_vec();
    }
    let (a, b) = parts.split_at(n / 2 * per);
    let (mut a, b) = (add_sheets(a, per), add_sheets(b, per));
    a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
    a
}

/// Those of each sheet, from the list.
fn sheets_by_list<T: Texel, const N: usize>(
    image: &ImageView<'_, T>,
) -> Result<Vec<[f64; N]>, Error> {
    let rows = image.channels() + 1;
    let texels = texels(image.map(), image.shape())?;
    expect_room::<[f64; N]>(rows * texels.blocks.len())?;
    let mut all = vec![[0.0; N]; rows * texels.blocks.len()];
    threads::rows(&mut all, 16 * rows, rows * texels.x.len(), |part, all| {
        let mut light = vec![0.0; rows * ROOM];
        for (block, all) in texels.blocks[16 * part..].iter().zip(all.chunks_mut(rows)) {
            let light = &mut light[..rows * block.length];
            light.fill(0.0);
            texels.block_flux(image, block, light);
            sum_rows(texels.directions(block), light, all);
        }
    });
    let of = |blocks: &Vec<usize>| {
        let parts = blocks.iter().flat_map(|k| &all[rows * k..][..rows]);
        sum_of_patches(parts.copied().collect(), rows)
    };
    Ok(texels.sheets.iter().flat_map(of).collect())
}

/// Those of each patch, without a list: a patch stays in the cache, and nothing is kept of it.
fn moments_by_patch<T: Texel, const N: usize>(
    image: &ImageView<'_, T>,
    patches: &Patches<'_>,
    part: &Sheet,
) -> Result<Vec<[f64; N]>, Error> {
    let rows = image.channels() + 1;
    let (across, strips) = (part.columns.len(), part.strips.len());
    expect_room::<[f64; N]>(rows * across * strips)?;
    let mut all = vec![[0.0; N]; rows * across * strips];
    threads::rows(
        &mut all,
        rows * across,
        rows * across * strips * ROOM,
        |strip, all| {
            let strip = part.strips.start + strip;
            let weights = patches.strip_weights(strip, &part.columns);
            let mut points = Points::new();
            let mut light = vec![0.0; rows * ROOM];
            for (column, all) in part.columns.clone().zip(all.chunks_mut(rows)) {
                let patch = (strip, column, &weights);
                if N == 1 && full::integrals(image, patches, patch, all.as_flattened_mut()) {
                    continue;
                }
                let length = patches
                    .points(strip, column, &weights, N > 1, &mut points)
                    .next_multiple_of(LANES);
                let light = &mut light[..rows * length];
                light.fill(0.0);
                let (index, weight) = (&points.index[..length], &points.weight[..length]);
                flux(image, index, weight, light);
                let directions = points.direction.0.each_ref().map(|axis| &axis[..length]);
                sum_rows(directions, light, all);
            }
        },
    );
    interrupt::check()?;
    Ok(all)
}

/// The sum of the patches of a sheet. Those that hold nothing are none: the constant is 0 there alone.
fn sum_of_patches<const N: usize>(mut all: Vec<[f64; N]>, rows: usize) -> Vec<[f64; N]> {
    let mut kept = 0;
    for patch in 0..all.len() / rows {
        if all[patch * rows + rows - 1][0] > 0.0 {
            all.copy_within(patch * rows..(patch + 1) * rows, kept);
            kept += rows;
        }
    }
    all.truncate(kept);
    (0..rows)
        .map(|row| tree(all.get(row..).unwrap_or_default(), rows))
        .collect()
}

/// The sum of every `rows`-th of the moments, as a tree.
fn tree<const N: usize>(all: &[[f64; N]], rows: usize) -> [f64; N] {
    let n = all.len().div_ceil(rows);
    if n <= 1 {
        return all.first().copied().unwrap_or([0.0; N]);
    }
    let half = n / 2 * rows;
    let (a, b) = (tree(&all[..half], rows), tree(&all[half..], rows));
    std::array::from_fn(|k| a[k] + b[k])
}

/// The moments of each row of numbers of each block: `rows` of them a block.
pub(crate) fn block_moments(texels: &Texels, flux: &[f64], rows: usize) -> Vec<Moments> {
    let mut all = vec![[0.0; 4]; rows * texels.blocks.len()];
    threads::rows(&mut all, 16 * rows, flux.len() / 4, |part, all| {
        for (block, all) in texels.blocks[16 * part..].iter().zip(all.chunks_mut(rows)) {
            let values = &flux[rows * block.start..][..rows * block.length];
            sum_rows(texels.directions(block), values, all);
        }
    });
    all
}

/// The moments of each of some rows of numbers, one for each of these directions.
fn sum_rows<const N: usize>(points: [&[f64]; 3], flux: &[f64], out: &mut [[f64; N]]) {
    let length = points[0].len().max(1);
    for (row, moments) in flux.chunks_exact(length).zip(out) {
        let mut sums = [[0.0; LANES]; N];
        kernel::run_simd(Sum {
            points,
            row,
            sums: &mut sums,
        });
        *moments = std::array::from_fn(|k| add_lanes(&sums[k]));
    }
}

struct Sum<'a, const N: usize> {
    points: [&'a [f64]; 3],
    row: &'a [f64],
    sums: &'a mut [[f64; LANES]; N],
}

impl<const N: usize> SimdWork for Sum<'_, N> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let row = self.row.as_chunks::<LANES>().0;
        let points = self.points.map(|p| &p.as_chunks::<LANES>().0[..row.len()]);
        let mut sums = [f64x8::splat(simd, 0.0); N];
        for i in 0..row.len() {
            let value = f64x8::load_array_ref(simd, &row[i]);
            sums[0] += value;
            for k in 1..N {
                sums[k] += value * f64x8::load_array_ref(simd, &points[k - 1][i]);
            }
        }
        for (sum, out) in sums.iter().zip(self.sums) {
            sum.store_array(out);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::raster::shape_of_size;
    use crate::map::Map;

    #[test]
    fn with_a_list_and_sheet_by_sheet_sums_have_the_same_bits() {
        for name in [
            "latlong",
            "octahedral",
            "cube",
            "angular",
            "mollweide",
            "cube:filament",
        ] {
            (1..=4).for_each(|channels| they_have_the_same_bits(name, channels));
        }
    }

    fn they_have_the_same_bits(name: &str, channels: usize) {
        let map = Map::new(name).unwrap();
        // More than a sheet along a side.
        let shape = shape_of_size(&map, 530);
        let count: usize = shape.iter().product();
        let light: Vec<f32> = (0..channels * count).map(|k| (k % 101) as f32).collect();
        let image = ImageView::new(&map, &shape, channels, &light).unwrap();
        let listed: Vec<Moments> = sheets_by_list(&image).unwrap();
        let patches = Patches::of_parts(&map, &shape).unwrap();
        let sheets = patches.sheets();
        let rows = channels + 1;
        assert!(sheets.len() > 3 && listed.len() == rows * sheets.len());
        let mut parts = Vec::new();
        for (sheet, listed) in sheets.iter().zip(listed.chunks(rows)) {
            let found: Vec<Moments> = moments_of_sheet(&image, &patches, sheet).unwrap();
            assert_eq!(found, listed, "{name}");
            let alone: Vec<[f64; 1]> = moments_of_sheet(&image, &patches, sheet).unwrap();
            for (all, one) in found.iter().zip(alone) {
                assert_eq!(all[0], one[0], "{name}");
            }
            parts.extend(found.into_iter().flatten());
        }
        let whole = moments(&image).unwrap();
        assert_eq!(whole.as_flattened(), add_sheets(&parts, 4 * rows), "{name}");
    }
}
