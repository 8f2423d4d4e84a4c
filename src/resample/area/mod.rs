//! Conservative conversion: each target texel is the mean of the source over the texel's own solid angle.
//!
//! # What is computed
//!
//! With w_ij the solid angle that target texel i and source texel j have in common,
//! out_i = Σ_j w_ij L_j / Σ_j w_ij. This is first-order conservative remapping as climate models use it
//! (Jones 1999, First- and Second-Order Conservative Remapping Schemes for Grids in Spherical
//! Coordinates; SCRIP; ESMF). Since Σ_j w_ij is the texel's solid angle and Σ_i w_ij is the source
//! texel's, Σ L dω over the image is kept, whatever is converted into what: a sun of one texel keeps
//! its energy. Weights are not negative, so no texel is darker or brighter than the source, and a constant
//! stays that constant.
//!
//! SCRIP integrates along straight lines in latitude and longitude, ESMF cuts polygons with
//! great-circle edges, and both need special care at poles. Here cells are what they are: their edges
//! are the projection's own curves, cut at exact crossings and integrated until
//! the error is below 1e-9 of a cell (`overlay`), without a polygon anywhere. A cell of 22° is as exact
//! as one of a second of arc.
//!
//! # Rules
//!
//! - A target texel that the source covers in part is the mean over the covered part, and the energy
//!   that is kept is that of the covered part. One that the source does not cover takes `fill`.
//! - A texel across a rim, whose center lies outside the valid image, holds no value that any reader counts (photographers
//!   print credits there). What of the sphere it covers belongs to the nearest texel whose center lies inside, in the source
//!   and in the target: that one is the mean over both parts. So sums over the texels that hold values keep the light.
//! - In the target a texel across the rim repeats its owner's value. So sums over all texels by their own solid angles keep
//!   the light as well, and an image seen by a program that knows no rim has no dark edge.
//! - NaN and infinity spread to every texel that they touch, unless they are skipped: then their weight is 0.
//!
//! # Five paths
//!
//! Where columns of both images are meridians and rows parallels about one axis, a share is a product of two lengths
//! (`graticule`): one pass over rows and one along them. Where both are of one map and neither is turned, shares are rectangles in the
//! plane of a face (`alike`). All other images go one of three ways.
//!
//! The fast path (`sweep`) takes eight cells of the target at once (`eight`). Their corners go into the source through the
//! vectorized kernels, and neighboring corners tell each edge's cubic in the source's plane (`edges`). Cut at the lines between
//! source cells, it adds area and moments to them by Green's theorem, as renderers of fonts do for pixels; a density
//! that is linear in a cell (`plane`) makes solid angles of them. Small images are refined first, so that this is right to
//! 1e-7 of a cell, unless so many cells would take longer than the general path; large texels are cut, so that edges are short;
//! edges that are still too long for a cubic are cut into up to 64 parts, each cell's on its own. Two cells that share an edge have the same cubic: what one loses the other gains.
//!
//! A cell that meets a seam or a pole is followed edge by edge, as finely as it needs, and closed along the sides of the
//! source's faces (`seams`, `arc`, `shares`, and `density`, which is quadratic).
//!
//! The general path (`overlay`) is right everywhere and costs 3 to 10 µs a texel, of lenses without a closed form 60.
//!
//! Every cell is checked: where the sum of its shares is not its solid angle to 5e-7, as beside a rim or on a crease
//! of the density, the next path has it. They may lie side by side, for each is as near to the true
//! border as that. Images with few texels take the general path in all.
//!
//! # What did not help
//!
//! One cell at a time with pieces in lists, shared by neighbors: each piece was computed once instead of twice, and it was three
//! times as slow. Corners and middles of sides instead of corners alone: three times the places, and no fewer cells that
//! need more. Clipping polygons: for 1e-7 of a 16×8 image's texel an edge needs a thousand corners. Summing the
//! source's own prefix sums around each texel (Green's theorem for the light itself): cheap at
//! any size, but a sun of 1e9 leaves 1e-7 of rounding in every texel of its row, and an infinite
//! texel the whole row.

mod alike;
mod fast;
mod frame;
mod general;
mod graticule;
mod lattice;
mod smaller;
mod sphere;
mod statistic;
mod sweep;
#[cfg(test)]
mod tests;
mod traced;

use crate::error::Error;
use crate::geometry::solid_angle::Rect;
use crate::image::raster::Raster;
use crate::image::rim::{self, Across};
use crate::image::texel::Texel;
use crate::image::texels::solid_angle_of;
use crate::image::view::ImageView;
use crate::kernel::tile::prefetch_item;
use crate::kernel::{interrupt, threads};
use crate::resample::area::alike::{Alike, Room};
use crate::resample::area::frame::frame;
use crate::resample::area::graticule::Graticule;
use crate::resample::area::lattice::Lattice;
use crate::resample::area::statistic::{Of, Tallies};
use crate::resample::area::sweep::{Add, Sweep, Tally};
use crate::resample::area::traced::density::Density;
use crate::resample::filters::AreaFilter;
use crate::resample::request::Request;
use crate::resample::window::Window;
pub(crate) use smaller::convert_smaller;

/// Fills the image that a request asks for with what each of its texels covers, by `filter`. With `skipna`, what is not finite has no
/// weight.
pub(crate) fn convert<T: Texel>(
    request: Request<'_, T>,
    filter: AreaFilter,
    skipna: bool,
    out: &mut [T],
) -> Result<(), Error> {
    let tally = Tally::default();
    let of = Of {
        filter,
        skipna,
        whole: false,
    };
    convert_by(Path::Best, &tally, request, of, out)
}

/// Fills the image that a request asks for with means by area, as if the source were black where it holds nothing.
pub(crate) fn convert_light<T: Texel>(request: Request<'_, T>, out: &mut [T]) -> Result<(), Error> {
    let tally = Tally::default();
    let of = Of {
        filter: AreaFilter::Area,
        skipna: false,
        whole: true,
    };
    convert_by(Path::Best, &tally, request, of, out)
}

/// Which way cells may go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Path {
    /// Whatever takes the least time.
    Best,
    /// The fast one where it serves.
    #[cfg(test)]
    Fast,
    /// Never the fast one.
    #[cfg(test)]
    General,
}

/// How many cells of a refined source take as long, on the fast path, as a texel of source or target on the general one: 0.3 to 1 µs, and 4 to 10.
const CELLS: f64 = 14.0;

/// Source cells along the side of a target cell for which a target is refined.
const WIDEST: f64 = 12.0;

/// Target cells along a side of a face, at least, on the fast path.
const FEWEST_TARGET: usize = 64;

#[inline(never)]
fn convert_by<T: Texel>(
    path: Path,
    tally: &Tally,
    request: Request<'_, T>,
    of: Of,
    out: &mut [T],
) -> Result<(), Error> {
    let Request {
        image,
        map,
        shape,
        rotation,
        fill,
        window,
    } = request;
    if path == Path::Best
        && !of.whole
        && let Some(graticule) = Graticule::between((image.map(), image.shape()), request.sight())?
    {
        graticule.convert(request, of, out);
        return Ok(());
    }
    let alike = path == Path::Best && alike::serves(image.map(), request.sight());
    let frame = frame(image.map(), map, rotation);
    let source = || Ok(Lattice::new(image.map(), image.shape(), None)?.counted_once());
    let mut from = source()?;
    let mut into = Lattice::new(map, shape, Some(frame))?;
    let channels = image.channels();
    let texels = into.raster.texels();
    let fast = match path {
        Path::Best if alike => false,
        Path::Best => {
            let parts = parts_for(&from, fast::plane::FEWEST) as f64;
            // Of either image that part which the other covers, if it covers less.
            let covered = [&from, &into].map(|lattice| lattice.map.coverage().solid_angle());
            let seen = |texels: usize, own: f64, other: f64| texels as f64 * (other / own).min(1.0);
            let source = seen(from.raster.texels(), covered[0], covered[1]);
            let target = seen(texels, covered[1], covered[0]);
            source * parts * parts <= CELLS * (source + target)
        }
        #[cfg(test)]
        Path::Fast => true,
        #[cfg(test)]
        Path::General => false,
    };
    let mut coarse = None;
    let mut followed = None;
    let mut varies = [[true; 2]; 2];
    if alike {
        let narrow = shorter_side(&from) / shorter_side(&into) / alike::MOST;
        (from, into) = (from.refine(1), into.refine(power(narrow)));
    } else if fast {
        // The general path has texels as they are: around a blind spot it is the less exact the finer cells are.
        coarse = Some(from);
        followed = Some(finer(source()?, traced::density::FEWEST));
        (from, into) = refined(source()?, into);
        varies = [Density::varies(&from), Density::varies(&into)];
    }
    let parts = into.refined;
    let cost = if alike || fast {
        CELL_COST * parts * parts
    } else {
        COST
    };
    let alike = alike.then(|| Alike::new(&from, &into));
    let rim = Rim::new(&into.raster);
    let side = (sweep::BLOCK / parts).max(1);
    let height = threads::band_rows(into.raster.rows, texels * cost, side);
    let work = |window: &Window, number: usize, band: &mut [T]| {
        let columns = window.columns.len();
        let first = window.rows.start + number * height;
        let [coarse, followed] =
            [&coarse, &followed].map(|lattice| lattice.as_ref().unwrap_or(&from));
        let mut cells = match &alike {
            Some(alike) => Cells::Alike(alike, Room::default()),
            None => {
                let lattices = [&from, followed, coarse];
                Cells::Sweep(Box::new(Sweep::new(lattices, &into, varies, fast)))
            }
        };
        let mut tallies = Tallies::new(image, of, side * side);
        let rows = band.len() / (columns * channels);
        let at = (first, window.columns.clone());
        into.raster.blocks_within(at, rows, (side, side), |block| {
            let Some((face, texel, [along, down])) = block.face else {
                for row in 0..block.rows {
                    let out = &mut band[(block.start + row * columns) * channels..];
                    let out = &mut out[..block.columns * channels];
                    out.chunks_exact_mut(channels)
                        .for_each(|out| out.copy_from_slice(fill));
                }
                return;
            };
            let at = |column: usize, row: usize| {
                [0, 1].map(|axis| {
                    let step = column as isize * along[axis] + row as isize * down[axis];
                    (texel[axis] + step) as usize
                })
            };
            let (p, q) = (at(0, 0), at(block.columns - 1, block.rows - 1));
            let low = [0, 1].map(|axis| p[axis].min(q[axis]));
            let high = [0, 1].map(|axis| p[axis].max(q[axis]) + 1);
            let across = high[0] - low[0];
            tallies.clear();
            // Cells of a large texel come in blocks.
            let step = sweep::BLOCK;
            let starts = |axis: usize| (low[axis] * parts..high[axis] * parts).step_by(step);
            for y in starts(1) {
                for x in starts(0) {
                    let end = [
                        (x + step).min(high[0] * parts),
                        (y + step).min(high[1] * parts),
                    ];
                    let near = |face, low, high| fetch(&from, image, face, low, high);
                    cells.each(face, [x, y], end, &near, &mut |[x, y], weights| {
                        let number = (y / parts - low[1]) * across + x / parts - low[0];
                        tallies.add(number, weights);
                    });
                }
            }
            for Across { texel, owner } in rim.owned_within(low, high) {
                let number = (owner[1] - low[1]) * across + owner[0] - low[0];
                let [x, y] = texel.map(|k| k * parts);
                let end = [x + parts, y + parts];
                cells.each(face, [x, y], end, &|_, _, _| (), &mut |_, weights| {
                    tallies.add(number, weights);
                });
            }
            for row in 0..block.rows {
                for column in 0..block.columns {
                    let [i, j] = at(column, row);
                    let start = (block.start + row * columns + column) * channels;
                    let number = (j - low[1]) * across + i - low[0];
                    let least = if of.whole {
                        solid_angle_of(into.map, &into.raster, i, j)
                    } else {
                        0.0
                    };
                    tallies.store(number, least, fill, &mut band[start..][..channels]);
                }
            }
        });
        cells.count(tally);
    };
    // Owners of texels across the rim are near, and may lie in other blocks.
    let mut needed = window.clone();
    for (texel, owner) in rim.stored(&into.raster) {
        if window.index(texel, &into.raster).is_some() {
            needed.include(owner, &into.raster);
        }
    }
    window.fill(&into.raster, &needed, (side, height), out, |window, out| {
        interrupt::part(0.0, 1.0, || {
            let width = window.columns.len() * channels;
            threads::rows(out, height * width, window.texels() * cost, |k, band| {
                work(window, k, band)
            });
        });
        for (texel, owner) in rim.stored(&into.raster) {
            let [to, from] = [texel, owner].map(|texel| window.index(texel, &into.raster));
            if let (Some(to), Some(from)) = (to, from) {
                out.copy_within(from * channels..(from + 1) * channels, to * channels);
            }
        }
    })
}

/// The cells of a target, and what they cover.
enum Cells<'l, 'a> {
    /// Of a map that is the source's.
    Alike(&'l Alike<'l, 'a>, Room),
    Sweep(Box<Sweep<'l, 'a>>),
}

impl Cells<'_, '_> {
    /// Calls `add` with each cell from `low` to before `high` on a face, and what it covers; and first, where that is not
    /// known long before, `near` with boxes of the source's cells.
    fn each(
        &mut self,
        face: usize,
        low: [usize; 2],
        high: [usize; 2],
        near: &dyn Fn(usize, [usize; 2], [usize; 2]),
        add: Add<'_>,
    ) {
        match self {
            Cells::Alike(alike, room) => alike.cells(room, face, low, high, add),
            Cells::Sweep(sweep) => sweep.cells(face, low, high, near, add),
        }
    }

    fn count(&self, tally: &Tally) {
        if let Cells::Sweep(sweep) = self {
            sweep.count(tally);
        }
    }
}

/// The target's texels across its rim, by owner.
struct Rim {
    across: Vec<Across>,
}

impl Rim {
    fn new(raster: &Raster) -> Rim {
        let mut across = rim::across(raster, |i, j| {
            let ((u0, u1), (v0, v1)) = (raster.along_u.cell(i), raster.along_v.cell(j));
            raster.solid_angle(Rect { u0, u1, v0, v1 }) > 0.0
        });
        across.sort_by_key(|Across { texel, owner }| (owner[1], owner[0], texel[1], texel[0]));
        Rim { across }
    }

    /// All of them on all faces, and their owners, as they are stored.
    fn stored<'a>(&'a self, raster: &'a Raster) -> impl Iterator<Item = (usize, usize)> + 'a {
        let views = raster.views()[..raster.faces()].iter();
        views.flat_map(|view| {
            let stored = |[i, j]: [usize; 2]| view.index(i, j);
            let all = self.across.iter();
            all.map(move |Across { texel, owner }| (stored(*texel), stored(*owner)))
        })
    }

    /// Those whose owners lie in a rectangle.
    fn owned_within(&self, low: [usize; 2], high: [usize; 2]) -> impl Iterator<Item = Across> + '_ {
        (low[1]..high[1]).flat_map(move |row| {
            let first = |column| {
                self.across
                    .partition_point(|Across { owner, .. }| (owner[1], owner[0]) < (row, column))
            };
            self.across[first(low[0])..first(high[0])].iter().copied()
        })
    }
}

/// Both lattices as the fast path needs them.
fn refined<'a>(from: Lattice<'a>, into: Lattice<'a>) -> (Lattice<'a>, Lattice<'a>) {
    let from = finer(from, fast::plane::FEWEST);
    // Cells a steradian, the square root of it.
    let fine = |lattice: &Lattice<'_>| {
        let faces = lattice.map.info().faces;
        let cells = (faces * lattice.columns * lattice.rows) as f64;
        (cells / lattice.map.coverage().solid_angle()).sqrt()
    };
    let into = into.refine(1);
    let smooth = FEWEST_TARGET as f64 / shorter_side(&into);
    let narrow = fine(&from) / fine(&into) / WIDEST;
    let into = into.refine(even(smooth.max(narrow)));
    (from, into)
}

/// A source in at least so many cells along each side.
fn finer<'a>(from: Lattice<'a>, fewest: usize) -> Lattice<'a> {
    let parts = parts_for(&from, fewest);
    from.refine(parts)
}

/// Into how many parts sides of an image's texels are cut for so many cells.
fn parts_for(lattice: &Lattice<'_>, fewest: usize) -> usize {
    even(fewest as f64 / shorter_side(lattice))
}

fn shorter_side(lattice: &Lattice<'_>) -> f64 {
    lattice.raster.width.min(lattice.raster.height) as f64
}

/// A whole number of parts, at least so many: an even one, or one.
fn even(least: f64) -> usize {
    match least.ceil() as usize {
        0 | 1 => 1,
        k => k.next_multiple_of(2),
    }
}

/// A power of two of parts, at least so many: sides whose ratio is one stay on each other.
fn power(least: f64) -> usize {
    (least.ceil() as usize).next_power_of_two()
}

/// Cells of a box that are fetched, at most.
const FETCHED: usize = 1 << 13;

/// Asks for the texels of a box of source cells. Blocks of a target jump about in the source, where nothing but the
/// corners of the next block tells what comes.
fn fetch<T: Texel>(
    from: &Lattice<'_>,
    image: &ImageView<'_, T>,
    face: usize,
    low: [usize; 2],
    high: [usize; 2],
) {
    let (all, channels) = (image.texels(), image.channels());
    let line = (64 / (channels * size_of::<T>()).max(1)).max(1);
    let [low, high] = [low, high].map(|at| at.map(|k| k / from.refined));
    if (high[0] - low[0]) * (high[1] - low[1]) > FETCHED {
        return;
    }
    let view = from.raster.view(face);
    for y in low[1]..=high[1].min(from.raster.height - 1) {
        for x in (low[0]..=high[0].min(from.raster.width - 1)).step_by(line) {
            prefetch_item(all, view.index(x, y) * channels);
        }
    }
}

/// Points that a texel counts for when threads are handed out, and a cell on the fast path.
const COST: usize = 256;
const CELL_COST: usize = 16;
