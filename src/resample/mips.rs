//! Mip chains: an image and its smaller versions, each half as wide and high, in the same projection.
//!
//! A texel of a level is the mean, by solid angle, of the texels of the level before that its rectangle covers, whole or in
//! part; light is kept. Since every level is an image of the projection, lookups in it know its seams: that is what chains
//! made by halving a picture get wrong, at the left and right edge of a latlong as between the faces of a cube.
//!
//! A texel across a rim holds no value: what of the sphere it covers has that of the nearest texel that does
//! (`light::rim`). It is 0, as what converting does not reach.

use crate::error::Error;
use crate::image::texel::Texel;
use crate::image::view::ImageView;
use crate::kernel::interrupt;
use crate::kernel::memory::expect_room;
use crate::number::real::Real;
use crate::resample::halving::{Halving, Held};
use crate::resample::window::Window;

/// Texels that a band of rows is made of, about.
const BAND: usize = 1 << 18;

/// A smaller version of an image: its shape without channels, and its texels.
pub type Level<F> = (Vec<usize>, Vec<F>);

/// All levels but the first, down to faces of one texel along a side (two where the grid lies on corners).
///
/// # Errors
/// None for an image that is one.
///
/// ```
/// use spheremap::image::ImageView;
/// use spheremap::Map;
/// use spheremap::resample::chain;
///
/// let map = Map::new("cube")?;
/// let texels = vec![0.25_f32; 6 * 8 * 8];
/// let levels = chain(&ImageView::new(&map, &[6, 8, 8], 1, &texels)?)?;
/// assert_eq!(levels.len(), 3);
/// assert_eq!(levels[2], (vec![6, 1, 1], vec![0.25; 6]));
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn chain<T: Texel>(image: &ImageView<'_, T>) -> Result<Vec<Level<T::Float>>, Error> {
    let (map, channels) = (image.map(), image.channels());
    let mut levels = Vec::new();
    // Each takes a quarter of the one before.
    let mut rest = 0.25;
    let mut next = interrupt::part(0.0, 1.0 - rest, || half(image))?;
    while let Some(level) = next {
        let image = ImageView::new(map, &level.0, channels, &level.1)?;
        next = interrupt::part(1.0 - rest, 1.0 - 0.25 * rest, || half(&image))?;
        rest *= 0.25;
        levels.push(level);
    }
    Ok(levels)
}

/// The next level of an image, if it can be made smaller.
pub(crate) fn half<T: Texel>(image: &ImageView<'_, T>) -> Result<Option<Level<T::Float>>, Error> {
    let Some(halving) = Halving::new(image.map(), image.shape())? else {
        return Ok(None);
    };
    let (fine, coarse, channels) = (&halving.fine, &halving.coarse, image.channels());
    let whole = Window::whole(fine);
    let held = Held {
        texels: image.texels(),
        part: &whole,
        channels,
    };
    expect_room::<T::Float>(coarse.texels() * channels)?;
    let mut out = vec![<T::Float as Real>::new(0.0); coarse.texels() * channels];
    // Of one face a band at a time, for solid angles take more memory than bytes do. Several faces share them.
    let rows = if coarse.faces() > 1 {
        coarse.rows
    } else {
        (BAND / fine.width).max(1).min(coarse.rows)
    };
    let mut room = Vec::new();
    for (k, out) in out.chunks_mut(rows * coarse.columns * channels).enumerate() {
        let first = k * rows;
        let end = (first + rows).min(coarse.rows);
        let band = Window {
            rows: first..end,
            columns: 0..coarse.columns,
        };
        let [start, end] = [first, end].map(|row| row as f64 / coarse.rows as f64);
        interrupt::part(start, end, || halving.fill(held, &band, &mut room, out))?;
    }
    Ok(Some((halving.shape, out)))
}
