//! Depth images: the distance along the ray, and the depth along a face's axis that a z-buffer holds.
//!
//! z is the distance times the cosine of the angle to the axis of the face. Each face of several has an axis of its own,
//! the direction of its middle, whatever the layout. A map of one face has one, the forward axis of the image, which
//! need not be the middle of the picture: a perspective whose principal point is moved keeps it.
//!
//! 0 (as "nothing"), NaN and infinity stay what they are, and so does what lies where the image holds no sphere. Behind
//! the axis z is negative. Singular: at a right angle to the axis z is 0, from where no distance comes back: it is
//! infinite there.

use crate::error::Error;
use crate::image::raster::Raster;
use crate::image::texels::Centers;
use crate::kernel::Scalar;
use crate::kernel::threads;
use crate::kernel::tile::{TILE, Tile, TuplesMut};
use crate::map::Map;
use crate::map::verbs::DecodeTile;
use crate::projections::projection::one;
use crate::projections::projection::{Projection, Uv, Visitor};

/// What a depth image holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// The distance to the eye.
    Distance,
    /// The depth along the axis of the face.
    Z,
}

impl Depth {
    /// The kind of this name.
    ///
    /// ```
    /// use spheremap::resample::depth::Depth;
    /// assert_eq!(Depth::find("z"), Some(Depth::Z));
    /// assert_eq!(Depth::find("w"), None);
    /// ```
    pub fn find(name: &str) -> Option<Depth> {
        match name {
            "distance" => Some(Depth::Distance),
            "z" => Some(Depth::Z),
            _ => None,
        }
    }
}

/// Turns depths of the other kind into `target`, in place.
///
/// # Errors
/// The shape is none of the map's, or there is not one depth a texel.
///
/// A wall at z = 2, seen by a camera of 90° whose corner texels look past (±1/2, ±1/2, 1):
///
/// ```
/// use spheremap::Map;
/// use spheremap::resample::depth::{Depth, convert_depth};
/// let mut wall = [2.0; 4];
/// let camera = Map::new("perspective")?;
/// convert_depth(&camera, &[2, 2], Depth::Distance, &mut wall)?;
/// assert!((wall[0] - 2.0 * 1.5_f64.sqrt()).abs() < 1e-14);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn convert_depth<R: Scalar>(
    map: &Map,
    shape: &[usize],
    target: Depth,
    depth: &mut [R],
) -> Result<(), Error> {
    let raster = Raster::new(map, shape)?;
    if depth.len() != raster.texels() {
        return Err(Error::Shape(format!(
            "Expected {} depths, got {}.",
            raster.texels(),
            depth.len()
        )));
    }
    let turn = map.view_rotation(None).inverse();
    let axes: Vec<[f64; 3]> = if map.layout().is_none() {
        vec![[0.0, 0.0, 1.0]]
    } else {
        let middle = |face: usize| map.visit_canonical(Middle(face as f64));
        (0..raster.faces()).map(middle).collect()
    };
    let axes: Vec<[f64; 3]> = axes.into_iter().map(|axis| turn.apply(axis)).collect();
    let centers = Centers::new(&raster);
    threads::bands(depth, raster.columns, raster.texels(), 1, |first, band| {
        let (mut uv, mut directions) = (Tile::new(), [0.0; 3 * TILE]);
        raster.blocks(first, band.len() / raster.columns, (TILE, 1), |block| {
            let Some((face, _, _)) = block.face else {
                return;
            };
            let directions = &mut directions[..3 * block.columns];
            centers.of(&block, &mut uv);
            map.visit_canonical(DecodeTile {
                turn,
                input: &uv,
                output: TuplesMut::of(directions),
            });
            let [x, y, z] = axes[face];
            let texels = &mut band[block.start..][..block.columns];
            for (depth, d) in texels.iter_mut().zip(directions.as_chunks::<3>().0) {
                let (cos, value) = (x * d[0] + y * d[1] + z * d[2], depth.to_f64());
                if value != 0.0 && value.is_finite() && !cos.is_nan() {
                    *depth = R::new(match target {
                        Depth::Z => value * cos,
                        Depth::Distance => value / cos,
                    });
                }
            }
        });
    });
    Ok(())
}

/// The direction of the middle of a face.
struct Middle(f64);

impl Visitor for Middle {
    type Output = [f64; 3];
    fn visit<P: Projection>(self, p: P) -> [f64; 3] {
        let (u, v, face) = (0.5, 0.5, self.0);
        one::decode(p, Uv { u, v, face })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::raster::shape_of_size;
    use crate::image::texels::directions;
    use crate::map::MapOptions;

    #[test]
    fn there_and_back() {
        for info in crate::projections::REGISTRY {
            let map = Map::new(info.name).unwrap();
            let shape = shape_of_size(&map, 10);
            let far: Vec<f64> = (0..shape.iter().product::<usize>())
                .map(|k| 1.0 + (k % 7) as f64)
                .collect();
            let mut z = far.clone();
            convert_depth(&map, &shape, Depth::Z, &mut z).unwrap();
            let mut depth = z.clone();
            convert_depth(&map, &shape, Depth::Distance, &mut depth).unwrap();
            for (k, far) in far.iter().enumerate() {
                // From a right angle to the axis nothing comes back. Elsewhere a product and a quotient round once each.
                if z[k] != 0.0 {
                    let off = (depth[k] / far - 1.0).abs();
                    assert!(off < 4.0 * f64::EPSILON, "{}: {k}", info.name);
                }
            }
        }
    }

    #[test]
    fn a_room_has_flat_walls() {
        let options = MapOptions {
            layout: Some("cross"),
            ..MapOptions::default()
        };
        let map = Map::with("cube", options).unwrap();
        let shape = shape_of_size(&map, 8);
        let texels = shape.iter().product::<usize>();
        let mut toward = vec![0.0_f64; 3 * texels];
        directions(&map, &shape, None, &mut toward).unwrap();
        let mut depth: Vec<f64> = toward
            .as_chunks::<3>()
            .0
            .iter()
            .map(|d| 1.0 / d.iter().fold(0.0_f64, |most, x| most.max(x.abs())))
            .collect();
        depth[8] = 0.0;
        convert_depth(&map, &shape, Depth::Z, &mut depth).unwrap();
        for (k, depth) in depth.iter().enumerate() {
            if k == 8 {
                assert_eq!(*depth, 0.0);
            } else if !toward[3 * k].is_nan() {
                assert!((depth - 1.0).abs() < 4.0 * f64::EPSILON);
            }
        }
        assert!(convert_depth(&map, &shape, Depth::Z, &mut depth[1..]).is_err());
    }
}
