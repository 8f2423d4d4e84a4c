//! An image: a map, a shape and texels that fit together. Whoever holds one need not check again.

use crate::error::Error;
use crate::image::raster::Raster;
use crate::image::texel::Texel;
use crate::map::Map;

/// An image that somebody else owns: how it maps the sphere, its shape, and its texels.
#[derive(Clone, Copy, Debug)]
pub struct ImageView<'a, T> {
    map: &'a Map,
    shape: &'a [usize],
    raster: Raster,
    texels: &'a [T],
    channels: usize,
}

impl<'a, T: Texel> ImageView<'a, T> {
    /// An image of `map`. `shape` is (rows, columns), or (faces, rows, columns) where faces are not laid out in one
    /// image; `texels` are its texels row by row, `channels` numbers each. Proportions are not checked: an image may be stretched.
    ///
    /// # Errors
    /// For a shape that the map has not, no channels, and another number of texels.
    ///
    /// ```
    /// use spheremap::image::ImageView;
    /// use spheremap::Map;
    ///
    /// let map = Map::new("latlong")?;
    /// let texels = [0.5_f32; 4 * 8 * 3];
    /// assert_eq!(ImageView::new(&map, &[4, 8], 3, &texels)?.channels(), 3);
    /// assert!(ImageView::new(&map, &[4, 8], 3, &texels[1..]).is_err());
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn new(
        map: &'a Map,
        shape: &'a [usize],
        channels: usize,
        texels: &'a [T],
    ) -> Result<Self, Error> {
        let raster = Raster::new(map, shape)?;
        if channels == 0 {
            return Err(Error::Shape(
                "Expected an image with at least one channel, got 0.".to_owned(),
            ));
        }
        let expected = raster.texels().checked_mul(channels);
        if expected != Some(texels.len()) {
            return Err(Error::Shape(format!(
                "Expected {} texels of {channels} numbers each, got {} numbers.",
                raster.texels(),
                texels.len()
            )));
        }
        Ok(ImageView {
            map,
            shape,
            raster,
            texels,
            channels,
        })
    }

    /// How it maps the sphere.
    ///
    /// ```
    /// use spheremap::{Map, image::ImageView};
    /// let map = Map::new("latlong")?;
    /// assert_eq!(ImageView::new(&map, &[1, 2], 1, &[1.0, 2.0])?.map(), &map);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn map(&self) -> &'a Map {
        self.map
    }

    /// Its shape, without channels.
    ///
    /// ```
    /// use spheremap::{Map, image::ImageView};
    /// let map = Map::new("latlong")?;
    /// assert_eq!(ImageView::new(&map, &[1, 2], 1, &[1.0, 2.0])?.shape(), [1, 2]);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn shape(&self) -> &'a [usize] {
        self.shape
    }

    /// Its geometry.
    pub(crate) fn raster(&self) -> &Raster {
        &self.raster
    }

    /// How many numbers a texel has.
    ///
    /// ```
    /// use spheremap::{Map, image::ImageView};
    /// let map = Map::new("latlong")?;
    /// assert_eq!(ImageView::new(&map, &[1, 2], 3, &[0.0; 6])?.channels(), 3);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Its texels, row by row, [`ImageView::channels`] numbers each.
    ///
    /// ```
    /// use spheremap::{Map, image::ImageView};
    /// let map = Map::new("latlong")?;
    /// assert_eq!(ImageView::new(&map, &[1, 2], 1, &[1.0, 2.0])?.texels(), [1.0, 2.0]);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn texels(&self) -> &'a [T] {
        self.texels
    }

    /// The numbers of one texel.
    ///
    /// # Panics
    /// There is no texel of this index.
    ///
    /// ```
    /// use spheremap::{Map, image::ImageView};
    /// let map = Map::new("latlong")?;
    /// assert_eq!(ImageView::new(&map, &[1, 2], 1, &[1.0, 2.0])?.texel(1), [2.0]);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    #[inline(always)]
    pub fn texel(&self, index: usize) -> &'a [T] {
        &self.texels[index * self.channels..][..self.channels]
    }
}

#[cfg(test)]
mod tests {
    use super::ImageView;
    use crate::map::Map;

    #[test]
    fn what_does_not_fit_is_an_error() {
        let map = Map::new("cube").unwrap();
        let texels = [0_u8; 6 * 4 * 4 * 2];
        assert!(ImageView::new(&map, &[6, 4, 4], 2, &texels).is_ok());
        for (shape, channels, count) in [
            (&[4, 4][..], 2, 192),
            (&[6, 4, 5], 2, 192),
            (&[6, 4, 4], 0, 192),
            (&[6, 4, 4], 2, 191),
            (&[6, 4, 4], usize::MAX, 192),
            (&[], 1, 1),
        ] {
            let view = ImageView::new(&map, shape, channels, &texels[..count]);
            assert!(view.is_err(), "{shape:?} {channels} {count}");
        }
    }
}
