//! One image into another: here, and only here, is decided how.

use crate::error::Error;
use crate::geometry::world::Worlds;
use crate::image::raster::Raster;
use crate::image::texel::Texel;
use crate::image::view::ImageView;
use crate::kernel::Scalar;
use crate::kernel::memory::expect_room;
use crate::map::Map;
use crate::resample::filters::{ByMethod, Filter};
use crate::resample::options::Options;
use crate::resample::request::{Request, Sight};
use crate::resample::sample::Sampler;
use crate::resample::weighted::{Looks, Weighted};
use crate::resample::window::Window;
use crate::resample::{area, lookup, mipmapped};

/// Fills an image of `map`, of this shape without channels, with what `image` shows, or an [`Options::window`] of it.
///
/// The worlds of both maps are matched: up stays up, what is ahead stays ahead, and nothing is mirrored
/// ([`Map::in_world_of`]), unless [`Options::worlds`] says that (x, y, z) stays what it is.
///
/// Proportions are not checked: a shape other than [`Map::face_size`] tells gives an image that is stretched.
///
/// # Errors
/// For a shape that the map has not, a window beyond it, an `out` of another length, a `fill` of another number of channels or beyond the range
/// of `T`, an `alpha` that is no channel, and a `rotation` that is none.
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
    let map = &matched(map, image.map(), options);
    let window = &windowed(map, shape, options)?;
    let rotation = options.turn()?;
    let count = window.texels();
    expect_numbers(count, channels, out.len())?;
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
        rotation,
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
            rotation,
            fill: &nothing,
            window,
        };
        plain(request, filter, options, false, seen)
    })
}

/// What [`convert`] fills, by a filter of mip chains, where the further levels of the image's chain are there: as
/// [`chain`](crate::resample::chain) gives them. All texels weigh the same. Returns the tiles of the image itself, of at most so many rows
/// and columns, that were seen.
///
/// # Errors
/// As for [`convert`]; for another filter, and levels of other images.
pub(crate) fn convert_levels<T: Texel>(
    (image, levels): (&ImageView<'_, T>, &[ImageView<'_, T::Float>]),
    (map, shape): (&Map, &[usize]),
    tile: [usize; 2],
    options: &Options,
    out: &mut [T],
) -> Result<Vec<Window>, Error> {
    let channels = image.channels();
    let filter = options.filter.of_footprints()?;
    let map = &matched(map, image.map(), options);
    let window = &windowed(map, shape, options)?;
    expect_numbers(window.texels(), channels, out.len())?;
    if levels.iter().any(|level| level.channels() != channels) {
        return Err(Error::Shape(
            "Expected levels of as many channels as the image has.".to_owned(),
        ));
    }
    let request = Request {
        image,
        map,
        shape,
        rotation: options.turn()?,
        fill: &options.fill.texel(channels)?,
        window,
    };
    mipmapped::watched(request, levels, filter, tile, out)
}

/// The tiles that [`convert_levels`] sees of an image of `src` of a shape, where there are `levels` levels with it: those that the first of
/// `every` so many rows of the window see, and its last row.
///
/// # Errors
/// As for [`convert_levels`].
pub(crate) fn tiles_seen(
    (src, source_shape): (&Map, &[usize]),
    levels: usize,
    (map, shape): (&Map, &[usize]),
    (tile, every): ([usize; 2], usize),
    options: &Options,
) -> Result<Vec<Window>, Error> {
    let filter = options.filter.of_footprints()?;
    let source = Raster::new(src, source_shape)?;
    let map = &matched(map, src, options);
    let sight = Sight {
        map,
        shape,
        rotation: options.turn()?,
        window: &windowed(map, shape, options)?,
    };
    mipmapped::seen(sight, (src, &source), levels, (tile, every), filter)
}

/// A map in the world of a source, where worlds are matched.
fn matched(map: &Map, source: &Map, options: &Options) -> Map {
    match options.worlds {
        Worlds::Match => map.in_world_of(source),
        Worlds::Literal => map.clone(),
    }
}

/// The part of an image of this shape that is made.
fn windowed(map: &Map, shape: &[usize], options: &Options) -> Result<Window, Error> {
    let raster = Raster::new(map, shape)?;
    let window = (options.window.clone()).unwrap_or_else(|| Window::whole(&raster));
    window.check(&raster)?;
    Ok(window)
}

fn expect_numbers(count: usize, channels: usize, numbers: usize) -> Result<(), Error> {
    if count.checked_mul(channels) == Some(numbers) {
        return Ok(());
    }
    Err(Error::Shape(format!(
        "Expected `out` to have {count} texels of {channels} numbers each, got {numbers} numbers."
    )))
}

/// What [`convert`] fills, as an array of its own.
///
/// # Errors
/// As for [`convert`], and where there is no memory for the array.
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
    let texels = windowed(map, shape, options)?.texels();
    let count = texels.saturating_mul(image.channels());
    expect_room::<T>(count)?;
    let mut out = vec![T::default(); count];
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
            if antialias && filter == Filter::Bilinear && area::convert_smaller(request, out)? {
                return Ok(());
            }
            lookup::convert(request, lookup, antialias, out)
        }
        ByMethod::Mipmapped(filter) => mipmapped::convert(request, filter, out),
        ByMethod::Area(filter) => area::convert(request, filter, skip_nan && options.skipna, out),
    }
}

#[cfg(test)]
mod tests {
    use super::{convert, converted, sample};
    use crate::error::Error;
    use crate::geometry::world::Worlds;
    use crate::image::texels::directions;
    use crate::image::view::ImageView;
    use crate::map::Map;
    use crate::resample::filters::Filter;
    use crate::resample::mip_sampler::MipSampler;
    use crate::resample::options::{Fill, Options};
    use crate::resample::window::Window;
    use glam::{DMat3, DVec3};

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

    #[test]
    fn what_is_no_rotation_is_an_error_with_every_filter() {
        let latlong = Map::new("latlong").unwrap();
        let image = ImageView::new(&latlong, &[1, 2], 1, &[0.5_f32; 2]).unwrap();
        let wrong = [DVec3::new(1.0, 1.0, -1.0), DVec3::splat(2.0), DVec3::NAN];
        for turn in wrong.map(DMat3::from_diagonal) {
            for filter in Filter::ALL {
                let options = Options::new().filter(*filter).rotation(turn);
                let got = converted(&image, &latlong, &[1, 2], &options);
                assert!(matches!(got, Err(Error::Rotation(_))), "{filter:?} {turn}");
            }
            let options = Options::new().rotation(turn);
            let got = sample(&image, &[0.0, 0.0, 1.0], &options, &mut [0.0]);
            assert!(matches!(got, Err(Error::Rotation(_))));
            let levels = options.filter(Filter::Trilinear);
            assert!(MipSampler::new(&image, &levels).is_err());
            let toward = directions(&latlong, &[1, 2], Some(turn), &mut [0.0; 6]);
            assert!(matches!(toward, Err(Error::Rotation(_))));
        }
    }

    #[test]
    fn a_window_is_checked_before_there_is_room_for_it() {
        let latlong = Map::new("latlong").unwrap();
        let image = ImageView::new(&latlong, &[1, 2], 1, &[0.5_f32; 2]).unwrap();
        for end in [1 << 40, usize::MAX] {
            let window = Window {
                rows: 0..end,
                columns: 0..end,
            };
            let options = Options::new().window(window);
            assert!(matches!(
                converted(&image, &latlong, &[8, 16], &options),
                Err(Error::Shape(_))
            ));
        }
    }
}
