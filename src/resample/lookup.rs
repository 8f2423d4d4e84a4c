//! From one projection into another.
//!
//! The target is walked in blocks: texel centers, their directions, the source's coordinates of those, the filter.
//! Coordinates exist for one block at a time. For images that are filtered in f32, and are the whole sphere, most of them
//! come from polynomials through a few (`patch`), and they are f32 as well (f64 ones took half of the time) unless a side
//! is so long that it would show. Where the source ends somewhere, rounding would decide on which side of its border
//! a texel lies, so that all are computed, in f64. Between two images of the same projection nothing is decoded, so that
//! what stays where it is stays what it is.

use crate::error::Error;
use crate::image::raster::Raster;
use crate::image::texel::Texel;
use crate::image::texels::Centers;
use crate::kernel::Scalar;
use crate::kernel::tile::TILE;
use crate::kernel::{interrupt, threads};
use crate::projections::projection::Coverage;
use crate::resample::antialias::Antialias;
use crate::resample::coordinate_map::CoordinateMap;
use crate::resample::filters::LookupFilter;
use crate::resample::polynomial;
use crate::resample::polynomial::{CoordinatePolynomial, CoordinatePolynomials};
use crate::resample::request::Request;
use crate::resample::sample::{Lookups, Rectangle, Texture};

/// The longest side for which f32 coordinates serve: they are off by up to 3·2⁻²³ of an image, 1/350 of a texel
/// there.
const SINGLE_SIDE: usize = 1 << 13;

/// The longest for which polynomials do: by as much there.
const PATCHED_SIDE: usize = 1 << 17;

/// Columns and rows of the target that are looked up together. Square-like blocks see a compact part of the
/// source: whole rows of a cube's top, for one, cross more of its rows than the CPU keeps page addresses for.
const BLOCK: (usize, usize) = (64, 4);

/// Those whose source coordinates one polynomial stands for.
const PATCH: (usize, usize) = polynomial::BLOCK;
const _: () = assert!(BLOCK.0 == PATCH.0 && BLOCK.0 * BLOCK.1 <= TILE);

/// Fills the image that a request asks for. With `antialias`, texels that see more than one texel of the source are means
/// of what they see.
pub(crate) fn convert<T: Texel>(
    request: Request<'_, T>,
    filter: LookupFilter,
    antialias: bool,
    out: &mut [T],
) -> Result<(), Error> {
    let target = Raster::new(request.map, request.shape)?;
    let map = request.image.map();
    let coordinate_map = CoordinateMap::new(map, request.map, request.rotation);
    let single = size_of::<T::Float>() == size_of::<f32>();
    let rounds = single && !coordinate_map.same() && map.coverage() == Coverage::Sphere;
    let longest = [request.image.raster(), &target]
        .iter()
        .map(|raster| raster.width.max(raster.height))
        .fold(0, usize::max);
    let job = Conversion {
        source: &Texture::new(request.image),
        target,
        coordinate_map,
        patches: rounds && longest <= PATCHED_SIDE,
        filter,
        antialias,
        fill: request.fill,
    };
    interrupt::part(0.0, 1.0, || {
        if rounds && longest <= SINGLE_SIDE {
            job.run::<f32>(out);
        } else {
            job.run::<f64>(out);
        }
    });
    Ok(())
}

struct Conversion<'s, 'a, T> {
    source: &'s Texture<'a, T>,
    target: Raster,
    coordinate_map: CoordinateMap<'s>,
    /// Whether polynomials serve for coordinates.
    patches: bool,
    filter: LookupFilter,
    antialias: bool,
    fill: &'s [T],
}

impl<T: Texel> Conversion<'_, '_, T> {
    /// Looks every texel of the target up where the coordinate_map takes it.
    fn run<R: Scalar>(&self, out: &mut [T]) {
        let target = &self.target;
        let centers = Centers::new(target);
        let channels = self.fill.len();
        let width = target.columns * channels;
        let nothing = vec![T::Float::default(); channels];
        let patches = self
            .patches
            .then(|| CoordinatePolynomials::new(self.coordinate_map, &self.source.raster, target))
            .flatten();
        threads::bands(out, width, target.texels(), PATCH.1, |first, band| {
            let mut lookups = Lookups::new(self.source, self.filter, self.fill);
            let mut means = self.antialias.then(|| {
                Antialias::new(
                    self.source,
                    target,
                    self.coordinate_map,
                    self.filter,
                    &nothing,
                )
            });
            let rows = band.len() / width;
            target.blocks(first, rows, PATCH, |whole| {
                let patches = patches.as_ref().filter(|_| !target.misses(&whole));
                let patch = patches.and_then(|patches| patches.of(&whole));
                if let Some(means) = &mut means {
                    means.next_patch();
                }
                for (row, block) in whole.bands(BLOCK.1, target.columns) {
                    let area = Rectangle {
                        start: block.start,
                        columns: block.columns,
                        stride: target.columns,
                    };
                    if target.misses(&block) {
                        for row in 0..block.rows {
                            let out = &mut band[(area.start + row * area.stride) * channels..];
                            fill_texels(&mut out[..area.columns * channels], self.fill);
                        }
                        continue;
                    }
                    let count = block.columns * block.rows;
                    let patched = patch
                        .as_ref()
                        .is_some_and(|patch: &CoordinatePolynomial<R>| {
                            patch.write(row, &block, lookups.tile());
                            lookups.place(count) || patch.holds(lookups.tile(), count)
                        });
                    if !patched {
                        centers.of(&block, lookups.tile());
                        self.coordinate_map.take(lookups.tile(), count);
                        lookups.place(count);
                    }
                    lookups.push(band, area);
                    if let Some(means) = &mut means {
                        // Texels of the block before, which are there since this one was pushed.
                        means.write(band);
                        let patch = patch.as_ref().filter(|_| patched).map(|patch| (patch, row));
                        means.block(&centers, &block, lookups.pushed(), patch, area);
                    }
                }
            });
            lookups.finish(band);
            if let Some(means) = &mut means {
                means.write(band);
            }
        });
    }
}

fn fill_texels<T: Copy>(out: &mut [T], texel: &[T]) {
    out.chunks_exact_mut(texel.len())
        .for_each(|out| out.copy_from_slice(texel));
}
