//! Lookups of directions that say how much of the image they see.
//!
//! Either the level is given, or how the direction changes from one pixel of the caller's picture to the next; then the
//! footprint follows from it by the projection's Jacobian (`footprint`). Both go by the rules of graphics APIs (`lod`). Levels are
//! made once, with the sampler, and each knows its seams.
//!
//! Places, levels and footprints are computed in f64; texels are weighted as those of an image without levels, so that level 0 has its
//! bits, and by `ewa` in f64, rounded once.

use crate::error::Error;
use crate::image::texel::Texel;
use crate::image::view::ImageView;
use crate::kernel::threads;
use crate::kernel::tile::{TILE, Tile, Tuples};
use crate::map::verbs::EncodeTile;
use crate::resample::filters::MipmappedFilter;
use crate::resample::footprint::{Footprint, measure_pixels};
use crate::resample::level_lookups::LevelLookups;
use crate::resample::levels::{Aim, Levels};
use crate::resample::lod::{Between, lods_of_sides};
use crate::resample::mips;
use crate::resample::options::Options;
use crate::resample::sample::{ByTile, Level, Texture};
use crate::resample::weighted::{Looks, Weighted};
use glam::DMat3;

/// How many plain lookups one of these is worth.
pub(crate) const WORK: usize = 32;

/// How many tiles of lookups a thread takes at a time.
const TILES: usize = 16;

/// How much of an image lookups see. Where a number is NaN they see nothing.
#[derive(Clone, Copy, Debug)]
pub enum Detail<'a> {
    /// The level that each looks at, 0 for the image itself, and between two levels a mix that is linear in it.
    Lod(&'a [f64]),
    /// How what is looked up changes to the next pixel right and down, as many numbers as it has itself.
    Derivatives([&'a [f64]; 2]),
}

impl<'a> Detail<'a> {
    /// An error where it is not that of `count` lookups of `width` numbers each.
    pub(crate) fn expect(self, count: usize, width: usize) -> Result<(), Error> {
        let fits = match self {
            Detail::Lod(lod) => lod.len() == count,
            Detail::Derivatives(pair) => pair.iter().all(|d| d.len() == count * width),
        };
        if fits {
            return Ok(());
        }
        Err(Error::Shape(format!(
            "Expected a level, or two derivatives of {width} numbers, for each of {count} lookups."
        )))
    }

    /// That of `count` lookups from `first` on, of `width` numbers each.
    pub(crate) fn part(self, first: usize, count: usize, width: usize) -> Detail<'a> {
        match self {
            Detail::Lod(lod) => Detail::Lod(&lod[first..][..count]),
            Detail::Derivatives(pair) => {
                Detail::Derivatives(pair.map(|d| &d[first * width..][..count * width]))
            }
        }
    }

    /// Whether a number of lookup k, of `width` numbers, is NaN.
    pub(crate) fn is_nan(self, k: usize, width: usize) -> bool {
        match self {
            Detail::Lod(lod) => lod[k].is_nan(),
            Detail::Derivatives(pair) => {
                (pair.iter()).any(|d| d[k * width..][..width].iter().any(|x| x.is_nan()))
            }
        }
    }

    /// An error where a filter does not know what to do with it.
    pub(crate) fn expect_filter(self, filter: MipmappedFilter) -> Result<(), Error> {
        match (self, filter) {
            (Detail::Lod(_), MipmappedFilter::Ewa) => Err(Error::Contradiction(
                "filter 'ewa' averages over the footprint that `derivatives` say; a `lod` has none, and is for filter 'trilinear'".to_owned(),
            )),
            _ => Ok(()),
        }
    }

    /// Where lookup k goes, at this place; `footprint` makes its footprint of the derivatives.
    #[inline(always)]
    pub(crate) fn aim(
        self,
        levels: &Levels<'_, impl Level + ?Sized>,
        filter: MipmappedFilter,
        k: usize,
        place: [f64; 3],
        footprint: impl FnOnce([&'a [f64]; 2]) -> Footprint,
    ) -> Aim {
        match self {
            Detail::Lod(lod) => Aim::at(place, Between::by_lod(lod[k], levels.count())),
            Detail::Derivatives(pair) => {
                levels.aim(filter, &footprint(pair), Between::by_lod_of_length)
            }
        }
    }
}

/// An error unless each level has fewer texels than the one before.
fn expect_falling(first: usize, further: impl Iterator<Item = usize>) -> Result<(), Error> {
    let mut before = first;
    for texels in further {
        if texels >= before {
            return Err(Error::Shape(format!(
                "Expected every level to be smaller than the one before, got {texels} texels after {before}."
            )));
        }
        before = texels;
    }
    Ok(())
}

/// An image and its mip chain, to be looked up in directions.
///
/// ```
/// use spheremap::image::ImageView;
/// use spheremap::Map;
/// use spheremap::resample::{Detail, Filter, MipSampler, Options};
///
/// let latlong = Map::new("latlong")?;
/// let texels: Vec<f32> = (0..32).map(|k| (k % 2) as f32).collect();
/// let stripes = ImageView::new(&latlong, &[4, 8], 1, &texels)?;
/// let sampler = MipSampler::new(&stripes, &Options::new().filter(Filter::Trilinear))?;
/// let mut gray = [0.0];
/// sampler.sample(&[0.3, 0.1, -1.0], Detail::Lod(&[1.0]), &mut gray)?;
/// assert_eq!(gray, [0.5]);
/// # Ok::<(), spheremap::Error>(())
/// ```
#[derive(Debug)]
pub struct MipSampler<'a, T: Texel> {
    image: ImageView<'a, T>,
    filter: MipmappedFilter,
    rotation: Option<DMat3>,
    fill: Vec<T>,
    weighted: Option<Weighted<T>>,
    /// Levels that were given.
    given: Vec<ImageView<'a, T>>,
    /// Those that were made, if none were.
    chain: Vec<mips::Level<T::Float>>,
}

impl<'a, T: Texel> MipSampler<'a, T> {
    /// Of an image. Makes its levels.
    ///
    /// # Errors
    /// For a filter other than [`Trilinear`](crate::resample::Filter::Trilinear) and [`Ewa`](crate::resample::Filter::Ewa), a `fill` of another number of channels, an
    /// `alpha` that is no channel, and a `rotation` that is none; where there is no memory for the levels, or the call is stopped.
    ///
    /// ```
    /// use spheremap::image::ImageView;
    /// use spheremap::resample::{Filter, MipSampler, Options};
    /// let map = spheremap::Map::new("latlong")?;
    /// let image = ImageView::new(&map, &[1, 2], 1, &[1.0, 2.0])?;
    /// assert!(MipSampler::new(&image, &Options::new().filter(Filter::Ewa)).is_ok());
    /// assert!(MipSampler::new(&image, &Options::new()).is_err());
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn new(image: &ImageView<'a, T>, options: &Options) -> Result<Self, Error> {
        let filter = options.filter.of_footprints()?;
        let fill = options.fill.texel(image.channels())?;
        let opacity = options.opacity(image.channels())?;
        let weighted = Weighted::new(image, opacity, options.skipna)?;
        let chain = match &weighted {
            Some(weighted) => mips::chain(&weighted.image(image)?)?,
            None => mips::chain(image)?,
        };
        Ok(MipSampler {
            image: *image,
            filter,
            rotation: options.turn()?,
            fill,
            weighted,
            given: Vec::new(),
            chain,
        })
    }

    /// Of an image and further levels of the caller's, each smaller than the one before: prefiltered reflections, say.
    ///
    /// # Errors
    /// For levels of another map or number of channels, or no smaller than the one before, and as for [`MipSampler::new`]; options that weight texels are for
    /// levels that are made.
    ///
    /// ```
    /// use spheremap::image::ImageView;
    /// use spheremap::resample::{Detail, Filter, MipSampler, Options};
    /// let map = spheremap::Map::new("octahedral")?;
    /// let (sharp, rough) = ([1.0; 16], [3.0; 4]);
    /// let sharp = ImageView::new(&map, &[4, 4], 1, &sharp)?;
    /// let rough = ImageView::new(&map, &[2, 2], 1, &rough)?;
    /// let options = Options::new().filter(Filter::Trilinear);
    /// let sampler = MipSampler::of_levels(&sharp, &[rough], &options)?;
    /// let mut between = [0.0];
    /// sampler.sample(&[0.0, 0.0, 1.0], Detail::Lod(&[0.5]), &mut between)?;
    /// assert_eq!(between, [2.0]);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn of_levels(
        image: &ImageView<'a, T>,
        further: &[ImageView<'a, T>],
        options: &Options,
    ) -> Result<Self, Error> {
        let filter = options.filter.of_footprints()?;
        let channels = image.channels();
        let fits =
            |level: &ImageView<'a, T>| level.channels() == channels && level.map() == image.map();
        if !further.iter().all(fits) {
            return Err(Error::Shape(format!(
                "Expected every level to be an image of one projection with {channels} channels."
            )));
        }
        let texels = further.iter().map(|level| level.raster().texels());
        expect_falling(image.raster().texels(), texels)?;
        if options.alpha.is_some() || options.skipna {
            return Err(Error::Contradiction(
                "`alpha` and `skipna` weight the texels that levels are made of; these are made already".to_owned(),
            ));
        }
        Ok(MipSampler {
            image: *image,
            filter,
            rotation: options.turn()?,
            fill: options.fill.texel(channels)?,
            weighted: None,
            given: further.to_vec(),
            chain: Vec::new(),
        })
    }

    /// Looks world directions of any length up: three numbers each in, a texel each out.
    ///
    /// # Errors
    /// For lengths that do not fit, and a level for [`Ewa`](crate::resample::Filter::Ewa).
    ///
    /// ```
    /// use spheremap::image::ImageView;
    /// use spheremap::resample::{Detail, Filter, MipSampler, Options};
    /// let map = spheremap::Map::new("latlong")?;
    /// let texels: Vec<f32> = (0..32).map(|k| (k % 2) as f32).collect();
    /// let stripes = ImageView::new(&map, &[4, 8], 1, &texels)?;
    /// let sampler = MipSampler::new(&stripes, &Options::new().filter(Filter::Ewa))?;
    /// let (right, down) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    /// let mut gray = [0.0];
    /// sampler.sample(&[0.3, 0.1, -1.0], Detail::Derivatives([&right, &down]), &mut gray)?;
    /// assert!((gray[0] - 0.5).abs() < 0.1);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn sample(
        &self,
        directions: &[f64],
        detail: Detail<'_>,
        out: &mut [T],
    ) -> Result<(), Error> {
        let channels = self.image.channels();
        let count = out.len() / channels;
        if directions.len() != 3 * count || out.len() != count * channels {
            return Err(Error::Shape(format!(
                "Expected three numbers a direction, and `out` to have a texel of {channels} for each; got {} and {}.",
                directions.len(),
                out.len()
            )));
        }
        detail.expect(count, 3)?;
        detail.expect_filter(self.filter)?;
        let Some(weighted) = &self.weighted else {
            return self.look(&self.image, &self.fill, directions, detail, out);
        };
        let image = weighted.image(&self.image)?;
        let nothing = weighted.nothing();
        // Neither filter has negative weights.
        let looks = Looks {
            count,
            ringing: false,
        };
        weighted.mean(looks, &self.fill, out, |_, seen| {
            self.look(&image, &nothing, directions, detail, seen)
        })
    }

    fn look<U: Texel<Float = T::Float>>(
        &self,
        image: &ImageView<'_, U>,
        fill: &[U],
        directions: &[f64],
        detail: Detail<'_>,
        out: &mut [U],
    ) -> Result<(), Error> {
        let (map, channels) = (image.map(), image.channels());
        let raster = image.raster();
        let source = Texture::new(image);
        let given: Vec<_> = self.given.iter().map(Texture::new).collect();
        let mut smaller = Vec::with_capacity(self.chain.len());
        for (shape, texels) in &self.chain {
            smaller.push(Texture::new(&ImageView::new(map, shape, channels, texels)?));
        }
        let size = [raster.width, raster.height];
        let levels = if given.is_empty() {
            let all = std::iter::once(&source as &dyn ByTile<U::Float>);
            let smaller = smaller.iter().map(|x| x as &dyn ByTile<U::Float>);
            Levels::halved(size, all.chain(smaller))
        } else {
            let mut all = vec![(&source as &dyn ByTile<U::Float>, size)];
            for level in &given {
                all.push((level, [level.raster.width, level.raster.height]));
            }
            Levels::sized(all)
        };
        let turn = map.view_rotation(self.rotation);
        let count = out.len() / channels;
        threads::rows(out, TILES * TILE * channels, count * WORK, |part, out| {
            let mut looks = LevelLookups::new(&levels, self.filter, (channels, fill));
            let mut uv = Tile::new();
            let mut sides = Tile::new();
            let mut lods = [0.0; TILE];
            for (tile, out) in out.chunks_mut(TILE * channels).enumerate() {
                let (first, n) = ((part * TILES + tile) * TILE, out.len() / channels);
                let directions = directions[3 * first..][..3 * n].as_chunks::<3>().0;
                let detail = detail.part(first, n, 3);
                map.visit_canonical(EncodeTile {
                    turn,
                    input: Tuples::Interleaved(directions),
                    output: &mut uv,
                });
                let mut seen = detail;
                if let Detail::Derivatives(pair) = detail {
                    let pixels = (directions, pair.map(|d| d.as_chunks().0));
                    measure_pixels((map, turn), raster, &uv, pixels, &mut sides);
                    if self.filter == MipmappedFilter::Trilinear {
                        lods_of_sides(&sides, &mut lods[..n]);
                        seen = Detail::Lod(&lods[..n]);
                    }
                }
                // Nowhere if a lookup sees nothing.
                let aims = (0..n).map(|k| {
                    let place = uv.at(k);
                    let footprint = |_| {
                        let [ax, ay, bx, by] = sides.at(k);
                        Footprint::of_sides(place, [[ax, ay], [bx, by]])
                    };
                    (!place[0].is_nan() && !detail.is_nan(k, 3))
                        .then(|| seen.aim(&levels, self.filter, k, place, footprint))
                });
                looks.look(aims, out);
            }
        });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{Detail, MipSampler};
    use crate::image::view::ImageView;
    use crate::map::Map;
    use crate::resample::filters::Filter;
    use crate::resample::options::Options;

    #[test]
    fn what_does_not_fit_is_an_error() {
        let map = Map::new("cube").unwrap();
        let texels = [0.5_f32; 6 * 4 * 4 * 2];
        let image = ImageView::new(&map, &[6, 4, 4], 2, &texels).unwrap();
        let options = |filter| Options::new().filter(filter);
        assert!(MipSampler::new(&image, &options(Filter::Bilinear)).is_err());
        assert!(MipSampler::new(&image, &options(Filter::Ewa).alpha(2)).is_err());
        let ewa = MipSampler::new(&image, &options(Filter::Ewa)).unwrap();
        let tri = MipSampler::new(&image, &options(Filter::Trilinear)).unwrap();
        let (d, mut out) = ([1.0; 6], [0.0; 4]);
        assert!(tri.sample(&d, Detail::Lod(&[0.5; 2]), &mut out).is_ok());
        assert_eq!(out, [0.5; 4]);
        assert!(tri.sample(&d, Detail::Lod(&[0.5; 3]), &mut out).is_err());
        assert!(ewa.sample(&d, Detail::Lod(&[0.5; 2]), &mut out).is_err());
        assert!(
            tri.sample(&d[..5], Detail::Lod(&[0.5; 2]), &mut out)
                .is_err()
        );
        assert!(
            tri.sample(&d, Detail::Lod(&[0.5; 2]), &mut out[..3])
                .is_err()
        );
        let one = ImageView::new(&map, &[6, 1, 1], 2, &texels[..12]).unwrap();
        let three = ImageView::new(&map, &[6, 1, 1], 3, &texels[..18]).unwrap();
        let of_levels = |level, options: Options| MipSampler::of_levels(&image, &[level], &options);
        assert!(of_levels(one, options(Filter::Trilinear)).is_ok());
        assert!(of_levels(three, options(Filter::Trilinear)).is_err());
        assert!(of_levels(image, options(Filter::Trilinear)).is_err());
        assert!(of_levels(one, options(Filter::Trilinear).skipna(true)).is_err());
        let pair = |n: usize| Detail::Derivatives([&d[..6], &d[..n]]);
        assert!(ewa.sample(&d, pair(6), &mut out).is_ok());
        assert!(ewa.sample(&d, pair(3), &mut out).is_err());
    }
}
