//! One image into another: here, and only here, is decided how.

use crate::error::Error;
use crate::geometry::world::Worlds;
use crate::image::raster::Raster;
use crate::image::texel::Texel;
use crate::image::view::ImageView;
use crate::kernel::Scalar;
use crate::map::Map;
use crate::resample::filters::{ByMethod, Filter};
use crate::resample::options::Options;
use crate::resample::request::Request;
use crate::resample::sample::Sampler;
use crate::resample::weighted::{Looks, Weighted};
use crate::resample::window::Window;
use crate::resample::{area, lookup, mipmapped};

/// Fills an image of `map`, of this shape without channels, with what `image` shows, or an [`Options::window`] of it.
///
/// The worlds of both maps are matched: up stays up, what is ahead stays ahead, and nothing is mirrored
/// ([`Map::in_world_of`]), unless [`Options::worlds`] says that (x, y, z) stays what it is.
///
/// # Errors
/// For a shape that the map has not, a window beyond it, an `out` of another length, a `fill` of another number of channels or beyond the range
/// of `T`, and an `alpha` that is no channel.
///
/// ```
/// use spheremap::image::ImageView;
/// use spheremap::Map;
/// use spheremap::resample::{Filter, Options, convert};
///
/// let latlong = Map::new("latlong")?;
/// let cube = Map::new("cube")?;
/// let texels = vec![0.5_f32; 16 * 32 * 3];
/// let panorama = ImageView::new(&latlong, &[16, 32], 3, &texels)?;
/// let mut faces = vec![0.0; 6 * 8 * 8 * 3];
/// let options = Options::new().filter(Filter::Area);
/// convert(&panorama, &cube, &[6, 8, 8], &options, &mut faces)?;
/// assert!(faces.iter().all(|x| *x == 0.5));
/// assert!(convert(&panorama, &cube, &[6, 8, 8], &options, &mut faces[..10]).is_err());
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn convert<T: Texel>(
    image: &ImageView<'_, T>,
    map: &Map,
    shape: &[usize],
    options: &Options,
    out: &mut [T],
) -> Result<(), Error> {
    let channels = image.channels();
    let map = &match options.worlds {
        Worlds::Match => map.in_world_of(image.map()),
        Worlds::Literal => map.clone(),
    };
    let raster = Raster::new(map, shape)?;
    let window = match &options.window {
        Some(window) => window,
        None => &Window::whole(&raster),
    };
    window.check(&raster)?;
    let count = window.texels();
    if count.checked_mul(channels) != Some(out.len()) {
        return Err(Error::Shape(format!(
            "Expected `out` to have {count} texels of {channels} numbers each, got {} numbers.",
            out.len()
        )));
    }
    let fill = options.fill.texel(channels)?;
    let opacity = options.opacity(channels)?;
    // A mean and a mode leave NaN out as they go.
    let info = options.filter.info();
    let within = opacity.is_none() && matches!(options.filter.by_method(), ByMethod::Area(_));
    let skipna = options.skipna && !within && !info.takes_labels;
    let request = Request {
        image,
        map,
        shape,
        rotation: options.rotation,
        fill: &fill,
        window,
    };
    let Some(weighted) = Weighted::new(image, opacity, skipna)? else {
        return plain(request, options.filter, options, within, out);
    };
    let image = weighted.image(image)?;
    let nothing = weighted.nothing();
    let looks = Looks {
        count,
        ringing: info.ringing,
    };
    weighted.mean(looks, &fill, out, |near, seen| {
        let filter = if near {
            Filter::Bilinear
        } else {
            options.filter
        };
        let request = Request {
            image: &image,
            map,
            shape,
            rotation: options.rotation,
            fill: &nothing,
            window,
        };
        plain(request, filter, options, false, seen)
    })
}

/// What [`convert`] fills, as an array of its own.
///
/// # Errors
/// As for [`convert`].
///
/// ```
/// use spheremap::image::ImageView;
/// use spheremap::Map;
/// use spheremap::resample::{Options, converted};
///
/// let latlong = Map::new("latlong")?;
/// let octahedral = Map::new("octahedral")?;
/// let texels = vec![7_u8; 16 * 32];
/// let panorama = ImageView::new(&latlong, &[16, 32], 1, &texels)?;
/// let square = converted(&panorama, &octahedral, &[8, 8], &Options::new())?;
/// assert_eq!(square, vec![7; 64]);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn converted<T: Texel>(
    image: &ImageView<'_, T>,
    map: &Map,
    shape: &[usize],
    options: &Options,
) -> Result<Vec<T>, Error> {
    let raster = Raster::new(map, shape)?;
    let window = options.window.as_ref();
    let count = window.map_or(raster.texels(), Window::texels);
    let mut out = vec![T::default(); count * image.channels()];
    convert(image, map, shape, options, &mut out)?;
    Ok(out)
}

/// Looks world directions of any length up in an image: three numbers each in, a texel each out.
///
/// # Errors
/// As for [`Sampler::new`] and [`Sampler::sample`].
///
/// ```
/// use spheremap::image::ImageView;
/// use spheremap::Map;
/// use spheremap::resample::{Options, sample};
///
/// let latlong = Map::new("latlong")?;
/// let texels = [1.0_f32, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0];
/// let panorama = ImageView::new(&latlong, &[2, 4], 1, &texels)?;
/// let mut out = [0.5; 2];
/// sample(&panorama, &[0.0, 1.0, 0.0, 0.0, -1.0, 0.0], &Options::new(), &mut out)?;
/// assert_eq!(out, [1.0, 0.0]);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn sample<T: Texel, R: Scalar>(
    image: &ImageView<'_, T>,
    directions: &[R],
    options: &Options,
    out: &mut [T],
) -> Result<(), Error> {
    Sampler::new(image, options)?.sample(directions, out)
}

/// Converts an image whose texels all weigh the same.
fn plain<T: Texel>(
    request: Request<'_, T>,
    filter: Filter,
    options: &Options,
    skip_nan: bool,
    out: &mut [T],
) -> Result<(), Error> {
    match filter.by_method() {
        ByMethod::Lookup(lookup) => {
            let antialias = options.antialias && filter.info().antialiased;
            lookup::convert(request, lookup, antialias, out)
        }
        ByMethod::Mipmapped(filter) => mipmapped::convert(request, filter, out),
        ByMethod::Area(filter) => area::convert(request, filter, skip_nan && options.skipna, out),
    }
}

#[cfg(test)]
mod tests {
    use super::{convert, sample};
    use crate::error::Error;
    use crate::geometry::world::Worlds;
    use crate::image::view::ImageView;
    use crate::map::Map;
    use crate::resample::filters::Filter;
    use crate::resample::options::{Fill, Options};

    /// Up is up in both, and what lies ahead and to the right as well.
    #[test]
    fn worlds_are_matched_unless_they_are_not_to_be() {
        let [blender, unreal] = ["latlong:blender", "latlong:unreal"].map(|n| Map::new(n).unwrap());
        // Three channels: how far up, ahead and to the right, in the words of each program.
        let seen = |map: &Map, axes: [usize; 3]| {
            let mut texels = vec![0.0_f64; 16 * 32 * 3];
            crate::image::texels::directions(map, &[16, 32], None, &mut texels).unwrap();
            let texel = |d: &[f64]| axes.map(|k| d[k]);
            texels.chunks(3).flat_map(texel).collect::<Vec<_>>()
        };
        let source = seen(&blender, [2, 1, 0]);
        let image = ImageView::new(&blender, &[16, 32], 3, &source).unwrap();
        let off = |options: &Options| {
            let got = super::converted(&image, &unreal, &[16, 32], options).unwrap();
            let want = seen(&unreal, [2, 0, 1]);
            let far = got.iter().zip(&want).map(|(a, b)| (a - b).abs());
            far.fold(0.0, f64::max)
        };
        // Both panoramas have their texels at the same places, turned: what is left is rounding.
        assert!(off(&Options::new()) < 1e-12);
        assert!(off(&Options::new().worlds(Worlds::Literal)) > 1.0);
    }

    /// Converts a small panorama of three channels into this shape of a cube, into so many numbers.
    fn attempt(shape: &[usize], numbers: usize, options: &Options) -> Result<(), Error> {
        let latlong = Map::new("latlong")?;
        let cube = Map::new("cube")?;
        let texels = [100_u8; 8 * 16 * 3];
        let image = ImageView::new(&latlong, &[8, 16], 3, &texels)?;
        let mut out = vec![0; numbers];
        convert(&image, &cube, shape, options, &mut out)?;
        assert!(out.iter().all(|x| *x == 100));
        Ok(())
    }

    #[test]
    fn what_does_not_fit_is_an_error_with_every_filter() {
        for filter in Filter::ALL {
            let options = Options::new().filter(*filter);
            assert!(attempt(&[6, 4, 4], 288, &options).is_ok());
            assert!(attempt(&[6, 4, 4], 10, &options).is_err());
            assert!(attempt(&[6, 4, 4], 289, &options).is_err());
            assert!(attempt(&[6, 4, 5], 288, &options).is_err());
            assert!(attempt(&[4, 4], 288, &options).is_err());
            assert!(attempt(&[], 288, &options).is_err());
            let filled = |fill: Fill| attempt(&[6, 4, 4], 288, &options.clone().fill(fill));
            assert!(filled(Fill::Channels(vec![1.0; 3])).is_ok());
            assert!(filled(Fill::Channels(vec![1.0; 2])).is_err());
            assert!(filled(Fill::Channels(Vec::new())).is_err());
            assert!(filled(Fill::All(256.0)).is_err());
            assert!(filled(Fill::All(f64::NAN)).is_err());
            assert!(attempt(&[6, 4, 4], 288, &options.clone().alpha(3)).is_err());
            let alpha = attempt(&[6, 4, 4], 288, &options.clone().alpha(2));
            assert_eq!(alpha.is_ok(), *filter != Filter::Mode);
        }
    }

    #[test]
    fn lookups_of_other_lengths_are_errors() {
        let latlong = Map::new("latlong").unwrap();
        let image = ImageView::new(&latlong, &[1, 2], 1, &[0.5_f32; 2]).unwrap();
        let look = |numbers: usize, filter: Filter, out: &mut [f32]| {
            let options = Options::new().filter(filter);
            sample(&image, &vec![1.0; numbers], &options, out)
        };
        assert!(look(6, Filter::Bilinear, &mut [0.0; 2]).is_ok());
        assert!(look(6, Filter::Bilinear, &mut [0.0; 3]).is_err());
        assert!(look(5, Filter::Bilinear, &mut [0.0; 2]).is_err());
        assert!(look(6, Filter::Area, &mut [0.0; 2]).is_err());
        assert!(look(6, Filter::Ewa, &mut [0.0; 2]).is_err());
    }
}
