//! Conversion through a mip chain, as graphics hardware and film renderers do it.
//!
//! Which level a texel is taken from follows from its footprint in the source (`footprint`), and the values of the two
//! nearest levels are mixed (`levels`): linearly in the length, unlike lookups that are told a level or derivatives (`lod`).

use crate::error::Error;
use crate::image::raster::{Block, Raster};
use crate::image::texel::Texel;
use crate::image::texels::Centers;
use crate::image::view::ImageView;
use crate::kernel::tile::{TILE, Tile};
use crate::kernel::{interrupt, threads};
use crate::map::Map;
use crate::resample::coordinate_map::CoordinateMap;
use crate::resample::filters::MipmappedFilter;
use crate::resample::footprint::{Footprint, Measuring, Part};
use crate::resample::level_lookups::LevelLookups;
use crate::resample::levels::Levels;
use crate::resample::lod::Between;
use crate::resample::mip_sampler::WORK;
use crate::resample::mips;
use crate::resample::request::{Request, Sight};
use crate::resample::sample::{ByPlace, ByTile, Level, Seen, Texture, Watched};
use crate::resample::window::Window;

/// Columns and rows of a block.
const BLOCK: (usize, usize) = (TILE, 1);

/// How much longer a lookup takes than a texel of the chain, about.
const LOOKUP: f64 = 4.0;

/// Fills the image that a request asks for.
pub(crate) fn convert<T: Texel>(
    request: Request<'_, T>,
    filter: MipmappedFilter,
    out: &mut [T],
) -> Result<(), Error> {
    let image = request.image;
    let target = Raster::new(request.map, request.shape)?;
    // Texels of the source are averaged, those of the target looked up, which takes longer.
    let (averaged, looked_up) = (image.raster().texels() as f64, target.texels() as f64);
    let start = averaged / (averaged + LOOKUP * looked_up);
    let chain = interrupt::part(0.0, start, || mips::chain(image))?;
    let mut smaller = Vec::with_capacity(chain.len());
    for (shape, texels) in &chain {
        smaller.push(ImageView::new(
            image.map(),
            shape,
            image.channels(),
            texels,
        )?);
    }
    let source = Texture::new(image);
    interrupt::part(start, 1.0, || {
        look_up(request, &source, &smaller, filter, out)
    })
}

/// Fills it from its image and the further levels of the image's chain. Returns the tiles of the image, of so many rows and columns,
/// that were seen.
pub(crate) fn watched<T: Texel>(
    request: Request<'_, T>,
    smaller: &[ImageView<'_, T::Float>],
    filter: MipmappedFilter,
    tile: [usize; 2],
    out: &mut [T],
) -> Result<Vec<Window>, Error> {
    let image = request.image;
    let seen = Seen::new(image.map(), image.raster(), tile);
    let source = Watched {
        texture: &Texture::new(image),
        seen: &seen,
    };
    look_up(request, &source, smaller, filter, out)?;
    Ok(seen.tiles())
}

fn look_up<T: Texel>(
    request: Request<'_, T>,
    source: &dyn ByTile<T::Float>,
    smaller: &[ImageView<'_, T::Float>],
    filter: MipmappedFilter,
    out: &mut [T],
) -> Result<(), Error> {
    let (image, fill) = (request.image, request.fill);
    let (channels, raster) = (image.channels(), image.raster());
    let walk = Walk::new(request.sight(), image.map(), raster)?;
    let smaller: Vec<_> = smaller.iter().map(Texture::new).collect();
    let all = std::iter::once(source);
    let all = all.chain(smaller.iter().map(|level| level as &dyn ByTile<T::Float>));
    let levels = Levels::halved([raster.width, raster.height], all);
    let work = |window: &Window, first: usize, band: &mut [T]| {
        let rows = band.len() / (window.columns.len() * channels);
        let mut looks = LevelLookups::new(&levels, filter, (channels, fill));
        walk.each(window, first, rows, |block, footprints| {
            let out = &mut band[block.start * channels..][..block.columns * channels];
            let aims = footprints.iter().map(|footprint| {
                (!footprint.source[0].is_nan())
                    .then(|| levels.aim(filter, footprint, Between::by_length))
            });
            looks.look(aims, out);
        });
    };
    let window = request.window;
    window.fill(&walk.target, window, BLOCK, out, |window, out| {
        let (width, points) = (window.columns.len() * channels, window.texels() * WORK);
        threads::bands(out, width, points, 1, |first, band| {
            work(window, first, band)
        });
    })
}

/// The tiles, of at most so many rows and columns, that the first of every so many rows of a window, and its last row, see of an image
/// of this map and geometry itself, where the image's chain has so many levels.
pub(crate) fn seen(
    sight: Sight<'_>,
    (map, raster): (&Map, &Raster),
    levels: usize,
    (tile, every): ([usize; 2], usize),
    filter: MipmappedFilter,
) -> Result<Vec<Window>, Error> {
    let walk = Walk::new(sight, map, raster)?;
    let image = Seen::new(map, raster, tile);
    let all = std::iter::once(&image as &dyn ByPlace);
    let all = all.chain((1..levels).map(|_| &Unread as &dyn ByPlace));
    let levels = Levels::halved([raster.width, raster.height], all);
    if sight.window.texels() == 0 {
        return Ok(Vec::new());
    }
    // What is not asked for may be computed with it.
    let window = sight.window.blocks(&walk.target, BLOCK);
    let last = window.rows.len() - 1;
    let mut rows: Vec<_> = (0..last).step_by(every.max(1)).chain([last]).collect();
    let points = rows.len() * window.columns.len() * WORK;
    threads::rows(&mut rows, 1, points, |_, row| {
        walk.each(&window, row[0], 1, |_, footprints| {
            for footprint in footprints {
                if !footprint.source[0].is_nan() {
                    let aim = levels.aim(filter, footprint, Between::by_length);
                    levels.look(&aim, &mut [0.0; 2]);
                }
            }
        });
    });
    Ok(image.tiles())
}

/// A level of which nobody wants to know.
struct Unread;

impl ByPlace for Unread {
    fn bilinear(&self, _: usize, _: [f64; 2], _: &mut [f64]) {}
}

impl Level for Unread {
    fn ellipse(&self, _: usize, _: [f64; 2], _: [[f64; 2]; 2], _: &mut [f64]) {}
}

/// What texels of a target see of a source, block by block.
struct Walk<'a> {
    target: Raster,
    source: &'a Raster,
    coordinate_map: CoordinateMap<'a>,
    centers: Centers<f64>,
}

impl<'a> Walk<'a> {
    fn new(sight: Sight<'a>, map: &'a Map, source: &'a Raster) -> Result<Self, Error> {
        let target = Raster::new(sight.map, sight.shape)?;
        Ok(Walk {
            target,
            source,
            coordinate_map: CoordinateMap::new(map, sight.map, sight.rotation),
            centers: Centers::new(&target),
        })
    }

    /// Calls `work` with the blocks of so many rows of a window, and the footprints of the texels of each. What lies on no face
    /// sees nothing.
    fn each(
        &self,
        window: &Window,
        first: usize,
        rows: usize,
        mut work: impl FnMut(&Block, &[Footprint]),
    ) {
        let mut uv = Tile::new();
        let mut footprints = [Footprint::default(); TILE];
        let mut measuring = Measuring::new();
        let nothing = Footprint {
            source: [f64::NAN; 3],
            ..Footprint::default()
        };
        let at = (window.rows.start + first, window.columns.clone());
        self.target.blocks_within(at, rows, BLOCK, |block| {
            let n = block.columns;
            if block.face.is_none() {
                footprints[..n].fill(nothing);
                return work(&block, &footprints[..n]);
            }
            self.centers.of(&block, &mut uv);
            let parts = (0..n).map(|k| Part::of_texel(&self.target, uv.at(k)));
            measuring.measure(&self.coordinate_map, self.source, parts);
            for (k, footprint) in footprints[..n].iter_mut().enumerate() {
                *footprint = measuring.at(k);
            }
            work(&block, &footprints[..n]);
        });
    }
}

#[cfg(test)]
mod tests {
    use crate::image::view::ImageView;
    use crate::map::Map;
    use crate::resample::convert::{convert_levels, tiles_seen};
    use crate::resample::window::Window;
    use crate::resample::{Filter, Options, chain, converted};
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        /// Of an image no texel is read but those of tiles that are seen.
        #[test]
        fn tiles_that_are_not_seen_need_not_be_there(
            (map, shape) in prop::sample::select(vec![
                ("latlong", vec![70, 140]),
                ("cube", vec![6, 33, 33]),
                ("cube:filament", vec![99, 132]),
                ("angular", vec![90, 90]),
                ("octahedral", vec![64, 64]),
                ("dual_fisheye", vec![2, 50, 50]),
                ("sinusoidal", vec![50, 100]),
            ]),
            filter in prop::sample::select(vec![Filter::Trilinear, Filter::Ewa]),
            size in prop::sample::select(vec![12_usize, 40, 90]),
            ends in prop::array::uniform4(0.0..1.0),
        ) {
            let (source, target) = (Map::new(map).unwrap(), Map::new("angular").unwrap());
            let (columns, to) = (shape[shape.len() - 1], [size, size]);
            let count: usize = shape.iter().product();
            let mut texels: Vec<f32> = (0..count).map(|k| (k as f32 * 0.37).sin()).collect();
            let image = ImageView::new(&source, &shape, 1, &texels).unwrap();
            let range = |a: f64, b: f64, all: usize| {
                let [a, b] = [a.min(b), a.max(b)].map(|x| (x * all as f64) as usize);
                a..(b + 1)
            };
            let window = Window {
                rows: range(ends[0], ends[1], to[0]),
                columns: range(ends[2], ends[3], to[1]),
            };
            let options = Options::new().filter(filter).window(window);
            let whole = converted(&image, &target, &to, &options).unwrap();
            let chain = chain(&image).unwrap();
            let levels: Vec<_> = (chain.iter())
                .map(|(shape, texels)| ImageView::new(&source, shape, 1, texels).unwrap())
                .collect();
            let all = 1 + levels.len();
            let seen = tiles_seen((&source, &shape), all, (&target, &to), ([7, 9], 1), &options).unwrap();
            for (k, texel) in texels.iter_mut().enumerate() {
                let (row, column) = (k / columns, k % columns);
                if !seen.iter().any(|tile| tile.rows.contains(&row) && tile.columns.contains(&column)) {
                    *texel = f32::NAN;
                }
            }
            let image = ImageView::new(&source, &shape, 1, &texels).unwrap();
            let mut part = vec![0.0; whole.len()];
            let watched = convert_levels((&image, &levels), (&target, &to), [7, 9], &options, &mut part).unwrap();
            prop_assert_eq!(watched.iter().filter(|tile| !seen.contains(tile)).count(), 0);
            prop_assert!(part.iter().zip(&whole).all(|(a, b)| a.to_bits() == b.to_bits()));
        }
    }
}
