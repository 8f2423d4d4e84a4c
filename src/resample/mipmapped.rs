//! Conversion through a mip chain, as graphics hardware and film renderers do it.
//!
//! Which level a texel is taken from follows from its footprint in the source (`footprint`), and the values of the two
//! nearest levels are mixed (`levels`): linearly in the length, unlike lookups that are told a level or derivatives (`lod`).

use crate::error::Error;
use crate::image::raster::Raster;
use crate::image::texel::Texel;
use crate::image::texels::Centers;
use crate::image::view::ImageView;
use crate::kernel::tile::{TILE, Tile};
use crate::kernel::{interrupt, threads};
use crate::number::real::Real;
use crate::resample::coordinate_map::CoordinateMap;
use crate::resample::filters::MipmappedFilter;
use crate::resample::footprint::{Footprint, Part, measure};
use crate::resample::levels::Levels;
use crate::resample::lod::Between;
use crate::resample::mips;
use crate::resample::request::Request;
use crate::resample::sample::{Level, Texture};
use crate::resample::window::Window;

/// How much longer a lookup takes than a texel of the chain, about.
const LOOKUP: f64 = 4.0;

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
    // Texels of the source are averaged, those of the target looked up, which takes longer.
    let (averaged, looked_up) = (image.raster().texels() as f64, target.texels() as f64);
    let start = averaged / (averaged + LOOKUP * looked_up);
    let chain = interrupt::part(0.0, start, || mips::chain(image))?;
    let source = Texture::new(image);
    let mut smaller = Vec::with_capacity(chain.len());
    for (shape, texels) in &chain {
        let level = ImageView::new(image.map(), shape, channels, texels)?;
        smaller.push(Texture::new(&level));
    }
    let all = std::iter::once(&source as &dyn Level);
    let all = all.chain(smaller.iter().map(|level| level as &dyn Level));
    let levels = Levels::halved([source.raster.width, source.raster.height], all);
    let centers = Centers::new(&target);
    let work = |window: &Window, first: usize, band: &mut [T]| {
        let width = window.columns.len() * channels;
        let mut uv = Tile::new();
        let mut parts = [Part::default(); TILE];
        let mut footprints = [Footprint::default(); TILE];
        let mut values = vec![0.0; 2 * channels];
        let at = (window.rows.start + first, window.columns.clone());
        target.blocks_within(at, band.len() / width, (TILE, 1), |block| {
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
                levels.look(filter, footprint, Between::by_length, &mut values);
                for (out, value) in out.iter_mut().zip(&values) {
                    *out = T::store(<T::Float as Real>::new(*value));
                }
            }
        });
    };
    let window = request.window;
    window.fill(&target, window, (TILE, 1), out, |window, out| {
        let (width, points) = (window.columns.len() * channels, window.texels() * 32);
        interrupt::part(start, 1.0, || {
            threads::bands(out, width, points, 1, |first, band| {
                work(window, first, band)
            });
        });
    })
}
