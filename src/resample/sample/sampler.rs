//! An image made ready to be looked up in directions, again and again.

use super::lookups::Lookups;
use super::rectangle::Rectangle;
use super::texture::Texture;
use crate::error::Error;
use crate::image::texel::Texel;
use crate::image::view::ImageView;
use crate::kernel::Scalar;
use crate::kernel::threads;
use crate::kernel::tile::{TILE, Tuples};
use crate::map::verbs::EncodeTile;
use crate::resample::filters::LookupFilter;
use crate::resample::options::Options;
use crate::resample::weighted::{Looks, Weighted};
use glam::DMat3;

/// Directions that are looked up together where texels have weights: what their lookups need is twice a result.
const CHUNK: usize = 1 << 16;

/// An image that can be looked up in directions, with options that were checked.
#[derive(Debug)]
pub struct Sampler<'a, T: Texel> {
    image: ImageView<'a, T>,
    filter: LookupFilter,
    ringing: bool,
    rotation: Option<DMat3>,
    fill: Vec<T>,
    weighted: Option<Weighted<T>>,
}

impl<'a, T: Texel> Sampler<'a, T> {
    /// Of an image. [`Options::antialias`] does not concern it: a direction has no width.
    ///
    /// # Errors
    /// For a filter that looks no direction up, a `fill` of another number of channels, an `alpha` that is no channel, and a `rotation` that is none.
    ///
    /// ```
    /// use spheremap::image::ImageView;
    /// use spheremap::resample::{Filter, Options, Sampler};
    /// let map = spheremap::Map::new("latlong")?;
    /// let image = ImageView::new(&map, &[1, 2], 1, &[1.0, 2.0])?;
    /// assert!(Sampler::new(&image, &Options::new()).is_ok());
    /// assert!(Sampler::new(&image, &Options::new().filter(Filter::Area)).is_err());
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn new(image: &ImageView<'a, T>, options: &Options) -> Result<Self, Error> {
        let filter = options.filter.of_points()?;
        let fill = options.fill.texel(image.channels())?;
        let opacity = options.opacity(image.channels())?;
        let skipna = options.skipna && !options.filter.info().takes_labels;
        Ok(Sampler {
            image: *image,
            filter,
            ringing: options.filter.info().ringing,
            rotation: options.turn()?,
            fill,
            weighted: Weighted::new(image, opacity, skipna)?,
        })
    }

    /// Looks up world directions of any length: three numbers each in, a texel each out.
    ///
    /// # Errors
    /// For lengths that do not fit.
    ///
    /// ```
    /// use spheremap::image::ImageView;
    /// use spheremap::resample::{Filter, Options, Sampler};
    /// let map = spheremap::Map::new("latlong")?;
    /// let image = ImageView::new(&map, &[1, 2], 1, &[1.0, 2.0])?;
    /// let nearest = Sampler::new(&image, &Options::new().filter(Filter::Nearest))?;
    /// let mut seen = [0.0; 2];
    /// nearest.sample(&[-1.0, 0.0, 0.0, 1.0, 0.0, 0.0], &mut seen)?;
    /// assert_eq!(seen.map(f64::abs), [1.0, 2.0]);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn sample<R: Scalar>(&self, directions: &[R], out: &mut [T]) -> Result<(), Error> {
        let channels = self.image.channels();
        let count = directions.len() / 3;
        if !directions.len().is_multiple_of(3) {
            return Err(Error::Shape(format!(
                "Expected three numbers a direction, got {} numbers.",
                directions.len()
            )));
        }
        if out.len() != count * channels {
            return Err(Error::Shape(format!(
                "Expected `out` to have {count} texels of {channels} numbers each, got {} numbers.",
                out.len()
            )));
        }
        let Some(weighted) = &self.weighted else {
            self.look(&self.image, self.filter, &self.fill, directions, out);
            return Ok(());
        };
        let image = weighted.image(&self.image)?;
        let nothing = weighted.nothing();
        for (directions, out) in directions
            .chunks(3 * CHUNK)
            .zip(out.chunks_mut(CHUNK * channels))
        {
            let looks = Looks {
                count: directions.len() / 3,
                ringing: self.ringing,
            };
            weighted.mean(looks, &self.fill, out, |plain, seen| {
                let filter = if plain {
                    LookupFilter::Bilinear
                } else {
                    self.filter
                };
                self.look(&image, filter, &nothing, directions, seen);
                Ok(())
            })?;
        }
        Ok(())
    }

    fn look<U: Texel, R: Scalar>(
        &self,
        image: &ImageView<'_, U>,
        filter: LookupFilter,
        fill: &[U],
        directions: &[R],
        out: &mut [U],
    ) {
        let texture = Texture::new(image);
        let turn = texture.map.view_rotation(self.rotation);
        threads::blocks(directions, 3, out, texture.channels, |directions, out| {
            let mut lookups = Lookups::new(&texture, filter, fill);
            for (tile, directions) in directions.chunks(3 * TILE).enumerate() {
                texture.map.visit_canonical(EncodeTile {
                    turn,
                    input: Tuples::of(directions),
                    output: lookups.tile(),
                });
                lookups.place(directions.len() / 3);
                let area = Rectangle {
                    start: tile * TILE,
                    columns: TILE,
                    stride: TILE,
                };
                lookups.push(out, area);
            }
            lookups.finish(out);
        });
    }
}
