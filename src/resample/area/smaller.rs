//! What antialiasing by area takes less time for than by lookups, and comes to the same: images that become smaller along straight rows.
//!
//! A texel that covers √2 texels of the source and more, along both sides, is a mean over all of it ([`crate::resample::antialias`]). Where what it
//! covers is a rectangle of texels, the mean is one over rows and one over columns, in one pass over the source: an image of parallels from
//! another one of parallels, by solid angle, and any image without a rim from a finer one of its own map. There texels weigh as much
//! as is covered of them in the plane of a face, as they do in windows of lookups; where the density changes by half within
//! a texel of the target, in images of few texels or beside a singular place, weights by solid angle need the other path.
//!
//! **What did not help.** Areas by solid angle from an image of the same map (`alike`): two to four times as long.

use crate::error::Error;
use crate::image::raster::Raster;
use crate::image::texel::Texel;
use crate::map::Map;
use crate::map::verbs::DensityCanonical;
use crate::projections::projection::Coverage;
use crate::resample::area::alike;
use crate::resample::area::graticule::{Graticule, Shares, edges, met};
use crate::resample::area::lattice::{Lattice, NOTHING};
use crate::resample::area::statistic::Of;
use crate::resample::filters::AreaFilter;
use crate::resample::request::{Request, Sight};

/// Columns and rows of the source that a texel covers, at least: places of less are spread over less of it.
const COARSER: f64 = std::f64::consts::SQRT_2;

/// By how much densities at opposite sides of a texel may differ, as a share of the one in its middle. Of noise, a mean that takes them for
/// alike is then off by a seventh of what it is at most, as means of few lookups are.
const UNEVEN: f64 = 1.0 / 2.0;

/// Texels of a face whose densities are looked at, along each side: densities are smooth between them, or they are on the sides of a face.
const LOOKED_AT: usize = 17;

/// Fills the image that a request asks for, if each of its texels covers a rectangle of several texels of the source, all of it.
/// False where that is not so.
pub(crate) fn convert_smaller<T: Texel>(
    request: Request<'_, T>,
    out: &mut [T],
) -> Result<bool, Error> {
    let image = request.image;
    let shares = shares((image.map(), image.shape()), request.sight())?;
    let of = Of {
        filter: AreaFilter::Area,
        skipna: false,
        whole: false,
    };
    if let Some(shares) = &shares {
        shares.convert(request, of, out);
    }
    Ok(shares.is_some())
}

/// What the images have in common, if that is rectangles of several texels.
fn shares((map, shape): (&Map, &[usize]), sight: Sight<'_>) -> Result<Option<Graticule>, Error> {
    let (source, target) = (
        Raster::new(map, shape)?,
        Raster::new(sight.map, sight.shape)?,
    );
    let coarser = |source: usize, target: usize| source as f64 >= COARSER * target as f64;
    if !coarser(source.height, target.height) || !coarser(source.width, target.width) {
        return Ok(None);
    }
    let mut shares = None;
    if map.coverage() == Coverage::Sphere {
        shares = Graticule::between((map, shape), sight)?;
    }
    let rim = source.has_rim() || target.has_rim();
    if shares.is_none() && alike::serves(map, sight) && !rim && is_even(sight.map, &target) {
        shares = of_one_map((map, shape), sight)?;
    }
    Ok(shares.filter(|all| all.fewest().iter().all(|fewest| *fewest >= COARSER)))
}

/// What an image and a smaller one of its map have in common in the planes of their faces, if these are stored as they are, one below the other.
fn of_one_map(
    (map, shape): (&Map, &[usize]),
    sight: Sight<'_>,
) -> Result<Option<Graticule>, Error> {
    let from = Lattice::new(map, shape, None)?.refine(1);
    let into = Lattice::new(sight.map, sight.shape, None)?.refine(1);
    let stacked = |lattice: &Lattice<'_>| {
        let raster = &lattice.raster;
        raster.columns == raster.width && raster.straight().is_some()
    };
    if !stacked(&from) || !stacked(&into) {
        return Ok(None);
    }
    let first = |lattice: &Lattice<'_>, face: usize| {
        lattice.raster.view(face).index(0, 0) / lattice.raster.columns
    };
    let mut faces: Vec<usize> = (0..into.raster.faces()).collect();
    faces.sort_by_key(|&face| first(&into, face));
    let [columns, rows] = [0, 1].map(|axis| {
        let [theirs, ours] = [&from, &into].map(|all| edges(all, axis).collect::<Vec<f64>>());
        let count = ours.len() - 1;
        let faces = if axis == 0 { &faces[..1] } else { &faces };
        Shares::new(count * faces.len(), |number, add| {
            let start = if axis == 0 {
                0
            } else {
                first(&from, faces[number / count])
            };
            let (a, b) = (ours[number % count], ours[number % count + 1]);
            for k in met(&theirs, [a, b]) {
                let own = theirs[k + 1] - theirs[k];
                let part = b.min(theirs[k + 1]) - a.max(theirs[k]);
                if part > NOTHING * own.min(b - a) {
                    add(start + k, part, part / own);
                }
            }
        })
    });
    Ok(Some(Graticule { rows, columns }))
}

/// Whether no texel of an image, as far as it is looked at, has densities that differ much.
fn is_even(map: &Map, target: &Raster) -> bool {
    let texels = |n: usize| {
        let count = n.min(LOOKED_AT);
        (0..count).map(move |k| k * (n - 1) / (count - 1).max(1))
    };
    let mut places = Vec::new();
    for face in 0..target.faces() {
        for j in texels(target.height) {
            for i in texels(target.width) {
                for (x, y) in [(0.0, 0.0), (-0.5, 0.0), (0.5, 0.0), (0.0, -0.5), (0.0, 0.5)] {
                    let u = target.along_u.center(i as f64 + x).clamp(0.0, 1.0);
                    let v = target.along_v.center(j as f64 + y).clamp(0.0, 1.0);
                    places.push([u, v, face as f64]);
                }
            }
        }
    }
    let mut densities = vec![0.0; places.len()];
    map.visit_canonical(DensityCanonical {
        input: places.as_flattened(),
        output: &mut densities,
    });
    let (texels, _) = densities.as_chunks::<5>();
    texels.iter().all(|[middle, left, right, above, below]| {
        let change = (left - right).abs().max((above - below).abs());
        change <= UNEVEN * middle
    })
}
