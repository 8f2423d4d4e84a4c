//! Integrals over the sphere: ∫ L dω and ∫ L ω dω.
//!
//! dω is sin θ dθ dφ; in an image it is the exact solid angle of a texel ([`crate::light::texels`]). Sums are f64:
//! eight lanes within a block of 256 texels, lanes as a tree, blocks as a tree. The order depends on
//! the image's shape alone.

use crate::error::Error;
use crate::image::ImageView;
use crate::image::texel::Texel;
use crate::kernel;
use crate::kernel::SimdWork;
use crate::kernel::threads;
use crate::light::texels::{LANES, Texels, texels};
use fearless_simd::{Simd, SimdBase, f64x8};

/// ∫ f dω and the three components of ∫ f ω dω.
pub type Moments = [f64; 4];

/// The sum of lanes, as a tree.
pub fn add_lanes(s: &[f64; LANES]) -> f64 {
    ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]))
}

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
    let moments = moments(image)?;
    let channels = &moments[..image.channels()];
    Ok(channels.iter().map(|m| m[0]).collect())
}

/// The moments of every channel of an image and, last, of the constant 1.
///
/// # Errors
/// There is no memory for it.
pub fn moments<T: Texel>(image: &ImageView<'_, T>) -> Result<Vec<Moments>, Error> {
    let rows = image.channels() + 1;
    let texels = texels(image.map(), image.shape())?;
    let flux = texels.flux(image, true)?;
    let all = block_moments(&texels, &flux, rows);
    Ok((0..rows).map(|row| tree(&all[row..], rows)).collect())
}

/// The sum of every `rows`-th of the moments, as a tree.
fn tree(all: &[Moments], rows: usize) -> Moments {
    let n = all.len().div_ceil(rows);
    if n <= 1 {
        return all.first().copied().unwrap_or_default();
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
            let span = block.start..block.start + block.length;
            let points = [
                &texels.x[span.clone()],
                &texels.y[span.clone()],
                &texels.z[span],
            ];
            let values = &flux[rows * block.start..][..rows * block.length];
            for (row, moments) in values.chunks_exact(block.length).zip(all) {
                let mut sums = [[0.0; LANES]; 4];
                kernel::run_simd(Sum {
                    points,
                    row,
                    sums: &mut sums,
                });
                *moments = std::array::from_fn(|k| add_lanes(&sums[k]));
            }
        }
    });
    all
}

struct Sum<'a> {
    points: [&'a [f64]; 3],
    row: &'a [f64],
    sums: &'a mut [[f64; LANES]; 4],
}

impl SimdWork for Sum<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let row = self.row.as_chunks::<LANES>().0;
        let [x, y, z] = self.points.map(|p| &p.as_chunks::<LANES>().0[..row.len()]);
        let mut sums = [f64x8::splat(simd, 0.0); 4];
        for i in 0..row.len() {
            let value = f64x8::load_array_ref(simd, &row[i]);
            sums[0] += value;
            sums[1] += value * f64x8::load_array_ref(simd, &x[i]);
            sums[2] += value * f64x8::load_array_ref(simd, &y[i]);
            sums[3] += value * f64x8::load_array_ref(simd, &z[i]);
        }
        for (sum, out) in sums.iter().zip(self.sums) {
            sum.store_array(out);
        }
    }
}
