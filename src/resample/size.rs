//! How large an image must be to hold what another one does.

use crate::error::Error;
use crate::image::raster::{Raster, shape_of_size};
use crate::map::Map;

/// Of a size this large the shape tells the proportions of an image, whatever its sides are rounded to.
const PROBE: usize = 256;

/// The size of an image of `dst` that holds about as many texels a steradian as one of `src` of this shape, without
/// channels: both counted over what they cover of the sphere.
///
/// # Errors
/// For a shape that `src` has not.
///
/// ```
/// use spheremap::Map;
/// use spheremap::resample::matching_size;
///
/// let latlong = Map::new("latlong")?;
/// let cube = Map::new("cube")?;
/// // 512 × 1024 texels on six faces: √(2¹⁹/6) along each.
/// assert_eq!(matching_size(&latlong, &cube, &[512, 1024])?, 296);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn matching_size(src: &Map, dst: &Map, shape: &[usize]) -> Result<usize, Error> {
    let held = Raster::new(src, shape)?.texels() as f64 * src.used_part();
    let unit = shape_of_size(dst, PROBE).iter().product::<usize>() as f64 / (PROBE * PROBE) as f64;
    let wanted = held / src.coverage().solid_angle() * dst.coverage().solid_angle()
        / (unit * dst.used_part());
    Ok((wanted.sqrt().round_ties_even() as usize).max(1))
}
