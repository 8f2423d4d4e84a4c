//! A border of the right texels around each face, for convolutions that know nothing of spheres.
//!
//! What a border holds is the rule of the map's seam. Where texels join texels ([`super::seam`]) it is an exact
//! permutation of the image. Beyond a face of several, a mirrored rim or a cut it is the image in the direction that
//! the face's own formula, continued, gives: a cube's border texel is what the face would show if its picture were
//! larger. Texels of the neighbors do not lie there, so it is looked up. Around a disk, the rim is the mirror: the
//! radius goes on at the opposite side, or where nothing lies beyond, the rim is repeated.
//!
//! The border may be wider than the image; the texels inside it are the image's own, bit for bit, the corners around a
//! disk included. Singular: on the rim of a disk a lookup would hang on a rounding, so it stays 1e-9 of the radius
//! inside.

use super::filters::Filter;
use super::options::Options;
use super::sample::Sampler;
use super::seam::{Continued, Side, continued};
use crate::error::Error;
use crate::geometry::axes::Rotation;
use crate::image::raster::{FaceView, Raster, tuple};
use crate::image::texel::Texel;
use crate::image::view::ImageView;
use crate::kernel::Scalar;
use crate::kernel::threads;
use crate::map::Map;
use crate::projections::projection::one;
use crate::projections::projection::{Projection, Seam, Uv, Visitor};

/// The shape of an image of this shape with a border of `n` texels: faces that lie in one image are taken apart.
///
/// # Errors
/// The shape is none of the map's, or there is no room for the border.
///
/// ```
/// use spheremap::{Map, MapOptions, resample::padded_shape};
/// assert_eq!(padded_shape(&Map::new("latlong")?, &[4, 8], 2)?, [8, 12]);
/// let cross = Map::with("cube", MapOptions::new().layout("cross"))?;
/// assert_eq!(padded_shape(&cross, &[12, 16], 1)?, [6, 6, 6]);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn padded_shape(map: &Map, shape: &[usize], n: usize) -> Result<Vec<usize>, Error> {
    let raster = Raster::new(map, shape)?;
    let grown = |side: usize| n.checked_mul(2).and_then(|border| side.checked_add(border));
    match (grown(raster.height), grown(raster.width)) {
        (Some(rows), Some(columns)) if map.layout().is_none() => Ok(vec![rows, columns]),
        (Some(rows), Some(columns)) => Ok(vec![raster.faces(), rows, columns]),
        _ => Err(Error::Shape(format!(
            "An image of shape {} has no room for a border of {n} texels.",
            tuple(shape)
        ))),
    }
}

/// Puts a border of `n` texels around each face of an image; `out` has [`padded_shape`] with as many channels. `filter` is
/// for what lies between texels.
///
/// # Errors
/// For an `out` of another length, and a filter that looks no direction up.
///
/// ```
/// use spheremap::Map;
/// use spheremap::image::ImageView;
/// use spheremap::resample::{Filter, pad, padded_shape};
/// let map = Map::new("latlong")?;
/// let image = ImageView::new(&map, &[1, 4], 1, &[0.0, 1.0, 2.0, 3.0])?;
/// let mut out = vec![0.0; padded_shape(&map, &[1, 4], 1)?.iter().product()];
/// pad(&image, 1, Filter::Bilinear, &mut out)?;
/// assert_eq!(out[6..12], [3.0, 0.0, 1.0, 2.0, 3.0, 0.0]);
/// assert_eq!(out[..6], [1.0, 2.0, 3.0, 0.0, 1.0, 2.0]);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn pad<T: Texel>(
    image: &ImageView<'_, T>,
    n: usize,
    filter: Filter,
    out: &mut [T],
) -> Result<(), Error> {
    // Also where none is needed: which arguments are right is not the map's matter.
    filter.lookup()?;
    let (map, raster, channels) = (image.map(), image.raster(), image.channels());
    let whole = padded_shape(map, image.shape(), n)?;
    let wanted = whole
        .iter()
        .fold(channels, |all, side| all.saturating_mul(*side));
    if out.len() != wanted {
        return Err(Error::Shape(format!(
            "Expected room for {channels} channels of an image of shape {}, got {} texels.",
            tuple(&whole),
            out.len()
        )));
    }
    // A border is of the image and not of the world, by whose rounding a rim would lie on either side of itself.
    if map.pose().is_some() {
        let plain = map.unturned();
        let image = ImageView::new(&plain, image.shape(), channels, image.texels())?;
        return pad(&image, n, filter, out);
    }
    if matches!(map.layout(), None | Some("faces")) {
        return pad_faces(image, &whole, n, filter, out);
    }
    let apart = map.with_layout("faces")?;
    let shape = [raster.faces(), raster.height, raster.width];
    let texels = copied(image, &Raster::new(&apart, &shape)?);
    let image = ImageView::new(&apart, &shape, channels, &texels)?;
    pad_faces(&image, &whole, n, filter, out)
}

/// The texels of all faces as another raster of faces of the same size stores them.
fn copied<T: Texel>(image: &ImageView<'_, T>, target: &Raster) -> Vec<T> {
    let (raster, texels, channels) = (image.raster(), image.texels(), image.channels());
    let mut out = vec![T::default(); target.texels() * channels];
    for face in 0..target.faces() {
        for j in 0..target.height {
            for i in 0..target.width {
                let from = raster.view(face).index(i, j) * channels;
                let to = target.view(face).index(i, j) * channels;
                out[to..to + channels].copy_from_slice(&texels[from..from + channels]);
            }
        }
    }
    out
}

fn pad_faces<T: Texel>(
    image: &ImageView<'_, T>,
    whole: &[usize],
    n: usize,
    filter: Filter,
    out: &mut [T],
) -> Result<(), Error> {
    let (map, raster) = (image.map(), image.raster());
    let (around, seam) = (Raster::new(map, whole)?, map.seam());
    let (texels, channels) = (image.texels(), image.channels());
    let sides = [
        (raster.along_u, raster.width),
        (raster.along_v, raster.height),
    ]
    .map(|(axis, n)| Side {
        n,
        on_edges: axis.on_edges(),
    });
    // Repeated rims are looked up, too: the corners of the image hold nothing.
    let joined = seam != Seam::Ends || raster.contains(0.0, 0.0);
    threads::rows(
        out,
        around.columns * channels,
        around.texels(),
        |row, out| {
            for run in around.runs(row) {
                let Some((face, first, step)) = run.face else {
                    continue;
                };
                let view = raster.view(face);
                let out = &mut out[run.column * channels..][..run.length * channels];
                for (k, out) in out.chunks_mut(channels).enumerate() {
                    let at = [0, 1].map(|a| first[a] + k as isize * step[a] - n as isize);
                    if is_inside(raster, at) {
                        let index = view.index(at[0] as usize, at[1] as usize) * channels;
                        out.copy_from_slice(&texels[index..index + channels]);
                    } else if joined && let Some(there) = continued(seam, sides, at) {
                        put(out, texels, view, there);
                    }
                }
            }
        },
    );
    if !(joined && continued(seam, sides, [-1, -1]).is_some()) {
        let sampler = Sampler::new(image, &Options::new().filter(filter))?;
        for face in 0..raster.faces() {
            look_up(image, &sampler, &around, face, n, out)?;
        }
    }
    Ok(())
}

fn is_inside(raster: &Raster, [i, j]: [isize; 2]) -> bool {
    (0..raster.width as isize).contains(&i) && (0..raster.height as isize).contains(&j)
}

/// Writes what stands for a texel.
fn put<T: Texel>(out: &mut [T], texels: &[T], view: &FaceView, there: Continued) {
    let channels = out.len();
    let at = |[i, j]: [usize; 2]| &texels[view.index(i, j) * channels..][..channels];
    match there {
        Continued::Texel(texel) => out.copy_from_slice(at(texel)),
        Continued::Between([a, b]) => {
            for (out, (a, b)) in out.iter_mut().zip(at(a).iter().zip(at(b))) {
                let mean = a.load().to_f64() * 0.5 + b.load().to_f64() * 0.5;
                // Integers, which have no NaN, round half up, as everywhere.
                let is_integer = !T::NOTHING.is_nan();
                *out = T::from_f64(if is_integer {
                    (mean + 0.5).floor()
                } else {
                    mean
                });
            }
        }
    }
}

/// Fills the border of a face with lookups.
fn look_up<T: Texel>(
    image: &ImageView<'_, T>,
    sampler: &Sampler<'_, T>,
    around: &Raster,
    face: usize,
    n: usize,
    out: &mut [T],
) -> Result<(), Error> {
    let (map, raster, channels) = (image.map(), image.raster(), image.channels());
    let (mut places, mut uv) = (Vec::new(), Vec::new());
    for j in 0..around.height {
        for i in 0..around.width {
            let at = [i, j].map(|i| i as isize - n as isize);
            if !is_inside(raster, at) {
                places.push(around.view(face).index(i, j) * channels);
                let u = raster.along_u.center(at[0] as f64);
                uv.extend([u, raster.along_v.center(at[1] as f64), face as f64]);
            }
        }
    }
    let mut directions = vec![0.0; uv.len()];
    let seam = map.seam();
    if matches!(seam, Seam::RimOpposite | Seam::Ends) {
        map.visit_canonical(OverRim {
            repeats: seam == Seam::Ends,
            turn: map.view_rotation(None).inverse(),
            uv: &uv,
            directions: &mut directions,
        });
    } else {
        map.beyond(&uv, &mut directions);
    }
    let mut found = vec![T::default(); places.len() * channels];
    sampler.sample(&directions, &mut found)?;
    for (place, found) in places.into_iter().zip(found.chunks(channels)) {
        out[place..place + channels].copy_from_slice(found);
    }
    Ok(())
}

/// The directions that stand for places around a disk.
struct OverRim<'a> {
    /// Whether the rim is repeated; else the radius goes on at the opposite side: 1 + x is -(1 - x).
    repeats: bool,
    /// View to world.
    turn: Rotation,
    uv: &'a [f64],
    directions: &'a mut [f64],
}

impl Visitor for OverRim<'_> {
    type Output = ();
    fn visit<P: Projection>(self, projection: P) {
        const LIMIT: f64 = 1.0 - 1e-9;
        let directions = self.directions.as_chunks_mut::<3>().0;
        for (&[u, v, face], out) in self.uv.as_chunks::<3>().0.iter().zip(directions) {
            let (p, q) = (2.0 * u - 1.0, 2.0 * v - 1.0);
            let radius = (p * p + q * q).sqrt().max(1.0);
            let inside = if self.repeats {
                LIMIT
            } else {
                ((radius + 1.0).rem_euclid(2.0) - 1.0).clamp(-LIMIT, LIMIT)
            };
            let [u, v] = [p, q].map(|x| 0.5 + 0.5 * (x / radius * inside));
            *out = self.turn.apply(one::decode(projection, Uv { u, v, face }));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::MapOptions;

    fn padded(map: &Map, size: usize, n: usize) -> (Vec<usize>, Vec<f64>, Vec<f64>) {
        let shape = crate::image::raster::shape_of_size(map, size);
        let texels = shape.iter().product::<usize>();
        let image: Vec<f64> = (0..texels).map(|k| ((k * 37) % 101) as f64).collect();
        let view = ImageView::new(map, &shape, 1, &image).unwrap();
        let whole = padded_shape(map, &shape, n).unwrap();
        let mut out = vec![f64::NAN; whole.iter().product()];
        pad(&view, n, Filter::Bilinear, &mut out).unwrap();
        (whole, image, out)
    }

    fn map(name: &str, layout: Option<&str>) -> Map {
        let options = MapOptions {
            layout,
            ..MapOptions::default()
        };
        Map::with(name, options).unwrap()
    }

    #[test]
    fn every_texel_of_every_map_has_a_value_and_the_image_is_inside() {
        for info in crate::projections::REGISTRY {
            let (size, n) = (6, 2);
            let (whole, image, out) = padded(&map(info.name, None), size, n);
            assert!(out.iter().all(|x| x.is_finite()), "{}", info.name);
            let [.., rows, columns] = whole[..] else {
                panic!("{}", info.name);
            };
            let (height, width) = (rows - 2 * n, columns - 2 * n);
            if image.len() != whole[..whole.len() - 2].iter().product::<usize>() * height * width {
                continue;
            }
            for (k, x) in image.iter().enumerate() {
                let (face, j, i) = (k / (height * width), k / width % height, k % width);
                assert_eq!(
                    out[(face * rows + j + n) * columns + i + n],
                    *x,
                    "{}",
                    info.name
                );
            }
        }
    }

    #[test]
    fn a_layout_pads_as_its_faces_do() {
        let cross = map("cube", Some("cross"));
        let faces = map("cube", Some("faces"));
        let shape = crate::image::raster::shape_of_size(&cross, 4);
        let image: Vec<f64> = (0..shape.iter().product::<usize>())
            .map(|k| k as f64)
            .collect();
        let image = ImageView::new(&cross, &shape, 1, &image).unwrap();
        let apart = copied(&image, &Raster::new(&faces, &[6, 4, 4]).unwrap());
        let whole = padded_shape(&cross, &shape, 1).unwrap();
        assert_eq!(whole, [6, 6, 6]);
        let (mut a, mut b) = (vec![0.0; 216], vec![0.0; 216]);
        pad(&image, 1, Filter::Bilinear, &mut a).unwrap();
        let apart = ImageView::new(&faces, &[6, 4, 4], 1, &apart).unwrap();
        pad(&apart, 1, Filter::Bilinear, &mut b).unwrap();
        assert_eq!(a, b);
    }

    #[test]
    fn too_little_room_is_an_error() {
        let map = map("latlong", None);
        let image = ImageView::new(&map, &[2, 4], 1, &[0.0; 8]).unwrap();
        let mut out = [0.0; 8];
        let result = pad(&image, 1, Filter::Bilinear, &mut out);
        assert!(result.unwrap_err().to_string().contains("Expected room"));
        assert!(padded_shape(&map, &[2, 4], usize::MAX).is_err());
    }
}
