//! Importance sampling: directions drawn as often as an image is bright there.
//!
//! The density is **exact for each texel**: p(ω) = L / ∫ L dω, constant per steradian within a texel, L its luminance.
//! So an estimate L/p has no variance within a texel, a texel at a pole or a rim has no infinite density, and a
//! density is looked up without evaluating the map's. (Drawing (u, v) evenly within a texel would be
//! simpler, but then 1/p follows dω/(du dv): infinite at the poles of a latlong, and of infinite variance at the rim of a
//! MatCap.)
//!
//! # How a sample is drawn
//!
//! By inverting distribution functions, v first and then u, so that a low-discrepancy set stays one: no alias table,
//! which is faster in its inner loop but scatters neighbors. Each search starts from a guide table (the cutpoint
//! method, Chen and Asau 1974), which leaves a step or two. A tile of samples goes through each step together:
//! the loads of one step do not wait for each other, and those of the next tile are under way while this one is
//! computed, which is what a table larger than the cache needs.
//!
//! Within a cell the density of the *map* must be inverted as well. Where it is nearly a straight line in v, and
//! then in u, the inverse is a root ([`crate::map::verbs::DrawTile`]). The grid of cells is the image's, cut into
//! whole parts until a face has 512 of them or more along each side, as many as it needs for a straight line to be off by less
//! than [`STRAIGHT`] in most.
//! The cells in which it is not (across a rim, beside a crease or a singular point) are halved, by exact solid angles of
//! the halves, until the part that holds the sample is straight.
//!
//! # What the number of threads and the CPU do to it
//!
//! Nothing: samples do not depend on each other, and sums run in a fixed order. (The solid angles in the tables
//! come from the platform's sine, as everywhere.)
//!
//! # What did not help, and what was left out
//!
//! Searching without fetching ahead (the misses of one sample wait for each other: 20 % slower at 1024×512, 35 % at
//! 4096×2048); a guide as fine as the cells (no faster: it takes the cache from the tables). Left out: tables in f32,
//! in which a dim texel beside a sun loses its digits; a density of its own for each end of a cell, twice
//! the memory for what two evaluations of the formula cost.

mod cells;
mod draw;
mod lookup;
mod records;
mod refine;
mod row;
mod search;

use crate::error::{Error, expect_length};
use crate::geometry::axes::Rotation;
use crate::image::ImageView;
use crate::image::raster::Raster;
use crate::image::texel::Texel;
use crate::kernel::memory::expect_room;
use crate::kernel::pages;
use crate::kernel::threads;
use crate::light::kept::Kept;
use crate::map::Map;
use cells::Cells;
pub use cells::STRAIGHT;
use records::{Sources, recorded};
use row::Row;
use search::{accumulate, fill_guide, normalize};
use std::sync::Arc;

/// Cells along a side of a face, at least, and the share of them that may be nonlinear; else the next. Bisection is slow,
/// but a finer grid takes memory, however small the image.
const GRIDS: [(usize, f64); 3] = [(512, 0.1), (1024, 0.4), (2048, 1.0)];

/// Fewer buckets take more steps of a search, and leave more of the cache to what is searched.
const COLUMNS_A_BUCKET: usize = 4;

/// Texels whose channels samples return: f32 or f64.
pub trait Radiance: Texel {
    /// The records of texels of this type.
    #[doc(hidden)]
    fn records(texels: Vec<Self>) -> Records;
}

impl Radiance for f32 {
    fn records(texels: Vec<f32>) -> Records {
        Records::Single(texels)
    }
}

impl Radiance for f64 {
    fn records(texels: Vec<f64>) -> Records {
        Records::Double(texels)
    }
}

/// What samples return, each texel's channels and its density.
#[doc(hidden)]
#[derive(Clone, Debug)]
pub enum Records {
    /// Single precision.
    Single(Vec<f32>),
    /// Double precision.
    Double(Vec<f64>),
}

/// A density on the sphere, proportional to the luminance of an image.
#[derive(Debug)]
pub struct Distribution {
    map: Map,
    raster: Raster,
    into_view: Rotation,
    into_world: Rotation,
    /// Cells along u.
    columns: usize,
    /// Cells along u in a texel.
    split: usize,
    edges: Vec<f64>,
    rows: Vec<Row>,
    marginal: Vec<f64>,
    marginal_guide: Vec<u32>,
    /// For each row its distribution function, columns + 1 numbers from 0 to 1.
    conditional: Vec<f64>,
    guide: Vec<u32>,
    buckets: usize,
    /// A bit for each cell in which the map's density is not straight; empty if there is none.
    nonlinear: Vec<u64>,
    /// For each texel, face by face, the density per steradian.
    density: Vec<f32>,
    /// For each texel its channels, and its density once more: a sample finds both in one place.
    records: Records,
    channels: usize,
    integral: f64,
}

impl Distribution {
    /// The density of an image: for each stored texel a luminance that is finite and not negative, and its channels, which
    /// `sample` divides by the density.
    ///
    /// # Errors
    /// There is not one luminance a texel, a luminance is negative or NaN, or the image is black or too bright to sum.
    ///
    /// ```
    /// use spheremap::light::distribution::Distribution;
    /// use spheremap::{Map, image::ImageView};
    /// let map = Map::new("latlong")?;
    /// let white = ImageView::new(&map, &[4, 8], 1, &[1.0_f32; 4 * 8])?;
    /// let light = Distribution::new(&white, &[1.0; 4 * 8])?;
    /// assert!((light.integral() - 4.0 * std::f64::consts::PI).abs() < 1e-8);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn new<T: Radiance>(
        image: &ImageView<'_, T>,
        luminance: &[f64],
    ) -> Result<Distribution, Error> {
        let (map, raster, channels) = (image.map(), *image.raster(), image.channels());
        let (width, height, faces) = (raster.width, raster.height, map.info().faces);
        let texels = width * height * faces;
        expect_length("luminance", luminance.len(), raster.texels())?;
        let Cells {
            columns,
            split,
            edges,
            rows,
            solid_angles: mut conditional,
            nonlinear,
        } = Arc::unwrap_or_clone(fine_cells(map, &raster)?);
        // Where each texel's value is, its light and density, its channels, and the guides.
        let per_texel = 64 + 12 * channels;
        expect_room::<u8>(texels.saturating_mul(per_texel))?;
        let sources = Sources::new(map, &raster);
        let light = sources.of(luminance);
        expect_luminance(&light)?;
        accumulate(&mut conditional, columns, split, &rows, &light);
        let mut marginal = Vec::with_capacity(rows.len() + 1);
        let mut integral = 0.0;
        marginal.push(0.0);
        for row in conditional.chunks_exact(columns + 1) {
            integral += row[columns];
            marginal.push(integral);
        }
        expect_bright(integral)?;
        let points = conditional.len();
        threads::rows(&mut conditional, columns + 1, points, |_, row| {
            normalize(row)
        });
        normalize(&mut marginal);
        let buckets = columns.div_ceil(COLUMNS_A_BUCKET);
        let mut guide = vec![0; rows.len() * (buckets + 1)];
        pages::advise(&mut guide);
        threads::rows(&mut guide, buckets + 1, points, |row, guide| {
            fill_guide(&conditional[row * (columns + 1)..][..=columns], guide);
        });
        let mut marginal_guide = vec![0; 2 * rows.len() + 1];
        fill_guide(&marginal, &mut marginal_guide);

        let mut density = Vec::new();
        pages::reserve(&mut density, light.len());
        density.extend(light.iter().map(|light| (light / integral) as f32));
        let records = T::records(recorded(&sources, image.texels(), channels, &density));
        debug_assert_eq!(texels, light.len());
        let into_view = map.view_rotation(None);
        Ok(Distribution {
            map: map.clone(),
            raster,
            into_view,
            into_world: into_view.inverse(),
            columns,
            split,
            edges,
            rows,
            marginal,
            marginal_guide,
            conditional,
            guide,
            buckets,
            nonlinear,
            density,
            records,
            channels,
            integral,
        })
    }

    /// The integral of the luminance, ∫ L dω.
    ///
    /// ```
    /// use spheremap::light::distribution::Distribution;
    /// use spheremap::{Map, image::ImageView};
    /// let map = Map::new("latlong")?;
    /// let white = ImageView::new(&map, &[4, 8], 1, &[1.0_f32; 4 * 8])?;
    /// let light = Distribution::new(&white, &[2.0; 4 * 8])?;
    /// assert!((light.integral() - 8.0 * std::f64::consts::PI).abs() < 1e-8);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn integral(&self) -> f64 {
        self.integral
    }

    /// The numbers that a texel has.
    ///
    /// ```
    /// use spheremap::light::distribution::Distribution;
    /// use spheremap::{Map, image::ImageView};
    /// let map = Map::new("latlong")?;
    /// let white = ImageView::new(&map, &[4, 8], 3, &[1.0_f32; 3 * 4 * 8])?;
    /// let light = Distribution::new(&white, &[1.0; 4 * 8])?;
    /// assert_eq!(light.channels(), 3);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn channels(&self) -> usize {
        self.channels
    }
}

/// An error where a texel that covers something has a luminance that is negative or no number.
fn expect_luminance(luminance: &[f64]) -> Result<(), Error> {
    match luminance.iter().find(|x| x.is_nan() || **x < 0.0) {
        None => Ok(()),
        Some(wrong) => Err(Error::Contradiction(format!(
            "`luminance` must be finite and not negative, got {wrong}."
        ))),
    }
}

/// An error unless there is light to sample by, and not too much to sum.
fn expect_bright(integral: f64) -> Result<(), Error> {
    if integral > 0.0 && integral.is_finite() {
        return Ok(());
    }
    let what = if integral == 0.0 {
        "is black: there is nothing"
    } else {
        "is too bright"
    };
    Err(Error::Contradiction(format!(
        "the image {what} to sample by (its luminance integrates to {integral})"
    )))
}

/// The cells of the last images: of small ones they take longer than all else, up to half a second.
static CELLS: Kept<Cells> = Kept::new(MOST_KEPT);

/// How many of them are kept, 8 bytes each: those of the finest grid of a face, and a little more.
const MOST_KEPT: usize = 5 << 20;

/// The cells of an image, of the first grid that has few nonlinear ones.
fn fine_cells(map: &Map, raster: &Raster) -> Result<Arc<Cells>, Error> {
    let shape = [raster.height, raster.width];
    let found = || -> Result<Cells, Error> {
        let shorter = raster.width.min(raster.height);
        let (mut fine, mut few) = GRIDS[0];
        let mut cells = Cells::new(map, raster, fine)?;
        for next in &GRIDS[1..] {
            if cells.nonlinear_share() <= few || shorter >= next.0 {
                break;
            }
            (fine, few) = *next;
            cells = Cells::new(map, raster, fine)?;
        }
        Ok(cells)
    };
    CELLS.of(map, &shape, |cells| cells.solid_angles.len(), found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_a_fine_grid_are_straight_but_for_few() {
        for info in crate::projections::REGISTRY {
            let map = Map::new(info.name).unwrap();
            let shape = crate::image::raster::shape_of_size(&map, GRIDS[0].0);
            let texels: usize = shape.iter().product();
            let light = vec![1.0; texels];
            let radiance = vec![1.0_f32; texels];
            let view = ImageView::new(&map, &shape, 1, &radiance).unwrap();
            let made = Distribution::new(&view, &light).unwrap();
            let nonlinear: u32 = made.nonlinear.iter().map(|word| word.count_ones()).sum();
            // Most of them, even of the MatCap, whose density rises without bound toward the rim.
            let cells = made.rows.len() * made.columns;
            let share = f64::from(nonlinear) / cells as f64;
            assert!(share < 0.4, "{} {share}", info.name);
            let total = map.coverage().solid_angle();
            assert!(
                (made.integral() / total - 1.0).abs() < 1e-9,
                "{}",
                info.name
            );
        }
    }

    #[test]
    fn luminance_that_is_none_is_named() {
        let map = Map::new("latlong").unwrap();
        let image = ImageView::new(&map, &[1, 2], 1, &[1.0_f32; 2]).unwrap();
        let says = |luminance: [f64; 2]| {
            let error = Distribution::new(&image, &luminance).unwrap_err();
            error.to_string()
        };
        assert!(says([1.0, -2.0]).contains("not negative, got -2"));
        assert!(says([f64::NAN, 1.0]).contains("not negative, got NaN"));
        assert!(says([f64::INFINITY, 1.0]).contains("too bright"));
        assert!(says([0.0, -0.0]).contains("black"));
    }
}
