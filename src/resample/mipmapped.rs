//! Conversion through a mip chain, as graphics hardware and film renderers do it.
//!
//! Which level a texel is taken from follows from its footprint in the source (`footprint`), and the values of the two
//! nearest levels are mixed. `trilinear` goes by the footprint's longer side and looks both levels up bilinearly: it never
//! aliases, and blurs where a footprint is long. `ewa` goes by the shorter axis and averages over the ellipse
//! (`sample::level`), whose longer axis is at most [`LONGEST`] times the shorter one.
//!
//! Between levels k and k + 1 the mix is linear in the length, ρ/2ᵏ - 1, and not in its logarithm, as in the level-of-detail
//! units of hardware: there is no logarithm whose bits are the same everywhere, and nobody can see the difference.

use crate::error::Error;
use crate::image::raster::Raster;
use crate::image::texel::Texel;
use crate::image::texels::Centers;
use crate::image::view::ImageView;
use crate::kernel::threads;
use crate::kernel::tile::{TILE, Tile};
use crate::number::real::Real;
use crate::resample::coordinate_map::CoordinateMap;
use crate::resample::filters::MipmappedFilter;
use crate::resample::footprint::{Footprint, Part, measure};
use crate::resample::mips;
use crate::resample::request::Request;
use crate::resample::sample::{Level, Texture};

/// The most that an ellipse is longer than wide; longer ones are made wider.
const LONGEST: f64 = 16.0;

/// Fills the image that a request asks for.
pub(crate) fn convert<T: Texel>(
    request: Request<'_, T>,
    filter: MipmappedFilter,
    out: &mut [T],
) -> Result<(), Error> {
    let (image, fill) = (request.image, request.fill);
    let target = Raster::new(request.map, request.shape)?;
    let coordinate_map = CoordinateMap::new(image.map(), request.map, request.rotation);
    let channels = image.channels();
    let chain = mips::chain(image)?;
    let source = Texture::new(image);
    let mut smaller = Vec::with_capacity(chain.len());
    for (shape, texels) in &chain {
        let level = ImageView::new(image.map(), shape, channels, texels)?;
        smaller.push(Texture::new(&level));
    }
    let mut levels: Vec<&dyn Level> = vec![&source];
    levels.extend(smaller.iter().map(|level| level as &dyn Level));
    let most = source.raster.width.max(source.raster.height) as f64;
    let centers = Centers::new(&target);
    let width = target.columns * channels;
    threads::bands(out, width, target.texels() * 32, 1, |first, band| {
        let mut uv = Tile::new();
        let mut parts = [Part::default(); TILE];
        let mut footprints = [Footprint::default(); TILE];
        let mut values = vec![0.0; 2 * channels];
        target.blocks(first, band.len() / width, (TILE, 1), |block| {
            let out = &mut band[block.start * channels..][..block.columns * channels];
            let out = out.chunks_exact_mut(channels);
            if block.face.is_none() {
                return out.for_each(|out| out.copy_from_slice(fill));
            }
            let n = block.columns;
            centers.of(&block, &mut uv);
            for (k, part) in parts[..n].iter_mut().enumerate() {
                *part = Part::of_texel(&target, uv.at(k));
            }
            measure(
                &coordinate_map,
                &source.raster,
                &parts[..n],
                &mut footprints,
            );
            for (footprint, out) in footprints[..n].iter().zip(out) {
                if footprint.source[0].is_nan() {
                    out.copy_from_slice(fill);
                    continue;
                }
                look(&levels, filter, most, footprint, &mut values);
                for (out, value) in out.iter_mut().zip(&values) {
                    *out = T::store(<T::Float as Real>::new(*value));
                }
            }
        });
    });
    Ok(())
}

/// The level below a length in source texels, and how far beyond it the length is on the way to the next one.
fn level(mut length: f64, levels: usize) -> (usize, f64) {
    let mut k = 0;
    while length >= 2.0 && k + 1 < levels {
        length *= 0.5;
        k += 1;
    }
    (k, (length - 1.0).clamp(0.0, 1.0))
}

/// Writes what a footprint shows into the first half of `values`.
fn look(
    levels: &[&dyn Level],
    filter: MipmappedFilter,
    most: f64,
    footprint: &Footprint,
    values: &mut [f64],
) {
    let face = footprint.source[2] as usize;
    let uv = [footprint.source[0], footprint.source[1]];
    let sides = match filter {
        MipmappedFilter::Trilinear => [[0.0; 2]; 2],
        MipmappedFilter::Ewa => rounded(footprint, most),
    };
    let length = match filter {
        MipmappedFilter::Trilinear => footprint.lengths()[0].max(footprint.lengths()[1]),
        MipmappedFilter::Ewa => axes(sides).1,
    };
    let (k, share) = level(length, levels.len());
    let (near, far) = values.split_at_mut(values.len() / 2);
    let one = |k: usize, out: &mut [f64]| match filter {
        MipmappedFilter::Trilinear => levels[k].bilinear(face, uv, out),
        MipmappedFilter::Ewa => {
            let scale = 0.5_f64.powi(k as i32);
            levels[k].ellipse(face, uv, sides.map(|side| side.map(|x| x * scale)), out);
        }
    };
    one(k, near);
    if share > 0.0 && k + 1 < levels.len() {
        one(k + 1, far);
        for (near, far) in near.iter_mut().zip(far) {
            *near += share * (*far - *near);
        }
    }
}

/// The longer and the shorter radius of the ellipse with these conjugate radii.
fn axes([[ax, ay], [bx, by]]: [[f64; 2]; 2]) -> (f64, f64) {
    let (xx, yy, xy) = (ax * ax + bx * bx, ay * ay + by * by, ax * ay + bx * by);
    let (middle, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let root = (half * half + xy * xy).sqrt();
    let longer = middle + root;
    let area = ax * by - ay * bx;
    // The product of both is the area: no difference of nearly equal numbers.
    (
        longer.sqrt(),
        if longer > 0.0 {
            area.abs() / longer.sqrt()
        } else {
            0.0
        },
    )
}

/// The footprint's sides, none longer than the source, made wide enough that the ellipse is not too long.
fn rounded(footprint: &Footprint, most: f64) -> [[f64; 2]; 2] {
    // At a singular place they are infinite or no numbers.
    let finite = |x: f64| if x.abs() <= 1e9 { x } else { 1e9 };
    let mut sides = footprint.sides.map(|side| side.map(finite));
    let (longer, shorter) = axes(sides);
    if longer > most {
        sides = sides.map(|side| side.map(|x| x * (most / longer)));
    }
    let (longer, shorter) = (longer.min(most), shorter * (most / longer).min(1.0));
    let wanted = longer / LONGEST;
    if shorter >= wanted || longer <= 1.0 {
        return sides;
    }
    // The ellipse's own axes, the shorter one stretched.
    let [[ax, ay], [bx, by]] = sides;
    let (xx, yy, xy) = (ax * ax + bx * bx, ay * ay + by * by, ax * ay + bx * by);
    let (x, y) = if xx >= yy {
        (longer * longer - yy, xy)
    } else {
        (xy, longer * longer - xx)
    };
    let norm = (x * x + y * y).sqrt();
    let (x, y) = if norm > 0.0 {
        (x / norm, y / norm)
    } else {
        (1.0, 0.0)
    };
    [[longer * x, longer * y], [-wanted * y, wanted * x]]
}
