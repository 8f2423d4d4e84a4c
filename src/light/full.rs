//! Integrals of patches all of whose texels count, which nearly all are.
//!
//! Their sums come straight from the rows of the image, for nothing but weights has to be known of a texel: no list of points, no row of numbers for each
//! channel. Lanes are those of the list (a texel's column, for a full row of a patch is two times eight), and so are the bits; the
//! way by lists took 1.6 times as long.

use crate::image::ImageView;
use crate::image::texel::Texel;
use crate::kernel;
use crate::kernel::Scalar;
use crate::light::patches::{LANES, Patches, StripWeights, add_lanes};

/// The integrals of every channel of a patch and, last, of the constant 1; false where something has to be known of its texels by themselves.
pub(super) fn integrals<T: Texel>(
    image: &ImageView<'_, T>,
    patches: &Patches<'_>,
    (strip, column, weights): (usize, usize, &StripWeights<'_>),
    out: &mut [f64],
) -> bool {
    let (face, columns) = (patches.face(strip), patches.columns(&(column..column + 1)));
    let raster = patches.raster();
    if !raster.is_straight(face) || columns.len() % LANES != 0 {
        return false;
    }
    let (first, view) = (columns.start - weights.first(), raster.view(face));
    let channels = image.channels();
    let rows = patches.rows(strip).zip(weights.rows());
    let rows = rows.map(|(j, row)| {
        let start = view.index(columns.start, j) * channels;
        let texels = &image.texels()[start..][..columns.len() * channels];
        (texels, &row[first..][..columns.len()])
    });
    match channels {
        1 => sums::<T, 1>(rows, out),
        3 => sums::<T, 3>(rows, out),
        4 => sums::<T, 4>(rows, out),
        _ => false,
    }
}

/// Those of rows of texels of C numbers, and of what these count with.
fn sums<'a, T: Texel, const C: usize>(
    rows: impl Iterator<Item = (&'a [T], &'a [f64])>,
    out: &mut [f64],
) -> bool {
    let (mut light, mut whole) = ([[0.0; C]; LANES], [0.0; LANES]);
    let mut full = true;
    kernel::vectorize(
        #[inline(always)]
        || {
            for (texels, weights) in rows {
                let texels = texels.as_chunks::<C>().0.as_chunks::<LANES>().0;
                for (texels, weights) in texels.iter().zip(weights.as_chunks::<LANES>().0) {
                    for k in 0..LANES {
                        full &= weights[k] > 0.0;
                        whole[k] += weights[k];
                        for c in 0..C {
                            light[k][c] += weights[k] * texels[k][c].load().to_f64();
                        }
                    }
                }
            }
        },
    );
    if full {
        for (c, out) in out[..C].iter_mut().enumerate() {
            *out = add_lanes(&light.map(|lane| lane[c]));
        }
        out[C] = add_lanes(&whole);
    }
    full
}
