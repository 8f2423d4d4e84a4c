//! HEALPix: pixel numbers of the sphere's hierarchical equal-area division.
//!
//! After Górski et al., "HEALPix: A Framework for High-Resolution Discretization and Fast Analysis of Data
//! Distributed on the Sphere", Astrophysical Journal 622 (2005). The sphere is twelve faces of nside² pixels, all of
//! 4π/(12 nside²) steradians. z points to the north pole, x to longitude 0. Faces 0 to 3 touch the north pole, 4 to 7
//! lie around the equator, 8 to 11 touch the south pole; within a face x runs north-east and y north-west
//! from its southern corner. *Nested* order counts face by face along a Z-order curve (the bits of x
//! and y in turn), *ring* order counts rings of equal latitude from the north, each from longitude 0 eastward.
//!
//! Two exact integer forms of a pixel lie between any two others: its [`FaceCell`] (face, x, y) and its
//! place [`OnRing`] (ring, pixels in a quadrant of it, azimuth in half pixels). Both orders and the center
//! of a pixel follow from either by additions, so that no formula exists twice.
//!
//! # Which pixel a direction falls into
//!
//! A border belongs to the pixel that the flooring in [`cell_of_direction`] gives it. Rounding moves a direction by at most
//! [`BORDER`] radians, so it can change the number of a direction only if that lies within this of a border.
//! float32 directions are computed in double precision: only what they hold decides.
//!
//! # Domain
//!
//! nside from 1 to 2²⁹; nested order is defined for powers of two. What is no direction (zero, NaN, infinite) has
//! pixel [`NONE`]; what is no pixel has the pixel NONE in the other order, and a center of NaN.
//!
//! # What makes it fast
//!
//! Straight lines of 64-bit integers and doubles that the compiler vectorizes, in chunks as in [`crate::kernel`].
//! No integer division, no table: a number below five is a sum of comparisons, a quotient and a square root come from a
//! double and are put right by one step, products are of 32-bit halves (one instruction on every level).

mod arrange;
mod between;
mod index;
mod place;
mod run;
#[cfg(feature = "python")]
mod unseen;

pub use arrange::Arrangement;
use between::between;
pub(crate) use index::Grid;
use index::{FaceCell, OnRing};
pub use place::BORDER;
pub(crate) use place::cell_of_direction;
use place::center;
#[cfg(feature = "python")]
pub(crate) use unseen::{unseen_to_nan_f32, unseen_to_nan_f64};

use crate::error::{Error, expect_length, expect_multiple};
use crate::kernel::threads;
use crate::kernel::tile::TILE;
use crate::number::real::Real;
use run::Wide;
use run::{Step, run, run_one_by_one};
use std::f64::consts::{FRAC_1_PI, PI};
use std::hint::select_unpredictable as choose;

/// The pixel of what has none.
pub const NONE: i64 = -1;

/// The finest division there is.
pub const MAX_NSIDE: i64 = 1 << 29;

/// How pixels are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Rings from the north.
    Ring,
    /// Face by face along a Z-order curve.
    Nested,
}

/// A division into 12 nside² pixels, and how they are counted.
#[derive(Clone, Copy, Debug)]
pub struct Pixels {
    grid: Grid,
    order: Order,
}

/// How two angles name a direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Angles {
    /// Angle from the north pole, and azimuth; radians.
    Colatitude,
    /// Longitude and latitude; degrees.
    LonLat,
}

impl Pixels {
    /// The division of the sphere into 12 nside² pixels.
    ///
    /// # Errors
    /// There is no such nside in that order.
    ///
    /// ```
    /// use spheremap::healpix::{Order, Pixels};
    /// assert!(Pixels::new(3, Order::Ring).is_ok());
    /// assert!(Pixels::new(3, Order::Nested).is_err()); // no power of two
    /// ```
    pub fn new(nside: i64, order: Order) -> Result<Pixels, Error> {
        if !(1..=MAX_NSIDE).contains(&nside) {
            return Err(Error::Contradiction(format!(
                "`nside` must be from 1 to {MAX_NSIDE}, got {nside}"
            )));
        }
        if order == Order::Nested && nside & (nside - 1) != 0 {
            return Err(Error::Contradiction(format!(
                "`nside` must be a power of two in nested order, got {nside}"
            )));
        }
        Ok(Pixels {
            grid: Grid::new(nside),
            order,
        })
    }

    /// Pixels of directions, three numbers each.
    ///
    /// # Errors
    /// The slices' lengths do not go together.
    ///
    /// ```
    /// use spheremap::healpix::{Order, Pixels};
    /// let ring = Pixels::new(2, Order::Ring)?;
    /// let mut pixels = [0; 2];
    /// ring.of_directions(&[0.0, 0.0, 1.0, 0.0, 0.0, -1.0], &mut pixels)?;
    /// assert_eq!(pixels, [0, 44]);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn of_directions<R: Wide<Number = f64>>(
        &self,
        directions: &[R],
        pixels: &mut [i64],
    ) -> Result<(), Error> {
        expect_multiple("directions", directions.len(), 3)?;
        expect_length("pixels", pixels.len(), directions.len() / 3)?;
        match self.order {
            Order::Ring => run(OfDirections::<false>(self.grid), directions, pixels),
            Order::Nested => run(OfDirections::<true>(self.grid), directions, pixels),
        }
        Ok(())
    }

    /// The unit vectors to the centers of pixels, three numbers each.
    ///
    /// # Errors
    /// The slices' lengths do not go together.
    ///
    /// ```
    /// use spheremap::healpix::{Order, Pixels};
    /// let base = Pixels::new(1, Order::Nested)?;
    /// let mut center = [0.0; 3];
    /// base.directions(&[4], &mut center)?; // the face around longitude 0 on the equator
    /// assert_eq!(center, [1.0, 0.0, 0.0]);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn directions(&self, pixels: &[i64], directions: &mut [f64]) -> Result<(), Error> {
        expect_length("directions", directions.len(), 3 * pixels.len())?;
        match self.order {
            Order::Ring => run(Directions::<false>(self.grid), pixels, directions),
            Order::Nested => run(Directions::<true>(self.grid), pixels, directions),
        }
        Ok(())
    }

    /// Pixels of directions given by two angles each.
    ///
    /// # Errors
    /// The slices' lengths do not go together.
    ///
    /// ```
    /// use spheremap::healpix::{Angles, Order, Pixels};
    /// let base = Pixels::new(1, Order::Nested)?;
    /// let mut pixels = [0];
    /// base.of_angles(Angles::LonLat, &[0.0, 0.0], &mut pixels)?;
    /// assert_eq!(pixels, [4]);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn of_angles(
        &self,
        angles: Angles,
        input: &[f64],
        pixels: &mut [i64],
    ) -> Result<(), Error> {
        expect_multiple("input", input.len(), 2)?;
        expect_length("pixels", pixels.len(), input.len() / 2)?;
        let lonlat = angles == Angles::LonLat;
        match self.order {
            Order::Ring => run(OfAngles::<false>(self.grid, lonlat), input, pixels),
            Order::Nested => run(OfAngles::<true>(self.grid, lonlat), input, pixels),
        }
        Ok(())
    }

    /// The two angles of the centers of pixels.
    ///
    /// # Errors
    /// The slices' lengths do not go together.
    ///
    /// ```
    /// use spheremap::healpix::{Angles, Order, Pixels};
    /// let base = Pixels::new(1, Order::Nested)?;
    /// let mut angles = [0.0; 2];
    /// base.angles(Angles::LonLat, &[4], &mut angles)?;
    /// assert_eq!(angles, [0.0, 0.0]);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn angles(&self, angles: Angles, pixels: &[i64], output: &mut [f64]) -> Result<(), Error> {
        expect_length("output", output.len(), 2 * pixels.len())?;
        let lonlat = angles == Angles::LonLat;
        match self.order {
            Order::Ring => run(ToAngles::<false>(self.grid, lonlat), pixels, output),
            Order::Nested => run(ToAngles::<true>(self.grid, lonlat), pixels, output),
        }
        Ok(())
    }

    /// The numbers of the eight pixels around each: south-west, west, north-west and so on clockwise to south.
    /// [`NONE`] where only three faces meet, and around what is no pixel.
    ///
    /// # Errors
    /// The slices' lengths do not go together.
    ///
    /// ```
    /// use spheremap::healpix::{Order, Pixels};
    /// let ring = Pixels::new(4, Order::Ring)?;
    /// let mut around = [0; 8];
    /// ring.neighbors(&[0], &mut around)?;
    /// assert_eq!(around, [4, 11, 3, 2, 1, 6, 5, 13]);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn neighbors(&self, pixels: &[i64], output: &mut [i64]) -> Result<(), Error> {
        expect_length("output", output.len(), pixels.len().saturating_mul(8))?;
        match self.order {
            Order::Ring => run_one_by_one(Neighbors::<false>(self.grid), pixels, output),
            Order::Nested => run_one_by_one(Neighbors::<true>(self.grid), pixels, output),
        }
        Ok(())
    }

    /// The four pixels around places given by two angles each, and their weights in bilinear interpolation; [`NONE`] and NaN
    /// around what is no place.
    ///
    /// # Errors
    /// The slices' lengths do not go together.
    ///
    /// ```
    /// use spheremap::healpix::{Angles, Order, Pixels};
    /// let ring = Pixels::new(2, Order::Ring)?;
    /// let (mut pixels, mut weights) = ([0; 4], [0.0; 4]);
    /// ring.interpolation(Angles::Colatitude, &[0.0, 0.0], &mut pixels, &mut weights)?;
    /// assert_eq!(pixels, [1, 2, 3, 0]); // all of those around the pole
    /// assert_eq!(weights, [0.25; 4]);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn interpolation(
        &self,
        angles: Angles,
        input: &[f64],
        pixels: &mut [i64],
        weights: &mut [f64],
    ) -> Result<(), Error> {
        expect_multiple("input", input.len(), 2)?;
        let length = (input.len() / 2).saturating_mul(4);
        expect_length("pixels", pixels.len(), length)?;
        expect_length("weights", weights.len(), length)?;
        let step = Between(self.grid, angles == Angles::LonLat);
        let blocks = input.chunks(2 * TILE);
        let results = pixels
            .chunks_mut(4 * TILE)
            .zip(weights.chunks_mut(4 * TILE));
        threads::each(
            length / 4,
            blocks.zip(results),
            |(input, (pixels, weights))| {
                let mut found = [0; 8 * TILE];
                let found = &mut found[..2 * pixels.len()];
                run(step, input, found);
                let numbers = pixels.as_chunks_mut::<4>().0.iter_mut();
                let into = numbers.zip(weights.as_chunks_mut::<4>().0);
                for ((number, weight), &[a, b, c, d, e, f, g, h]) in
                    into.zip(found.as_chunks::<8>().0)
                {
                    *number = [a, b, c, d];
                    *weight = [e, f, g, h].map(|bits| f64::from_bits(bits.cast_unsigned()));
                }
                if self.order == Order::Nested {
                    let mut ring = [0; 4 * TILE];
                    let ring = &mut ring[..pixels.len()];
                    ring.copy_from_slice(pixels);
                    run(ToNested(self.grid), ring, pixels);
                }
            },
        );
        Ok(())
    }

    /// The numbers that these pixels have in the other order.
    ///
    /// # Errors
    /// The slices' lengths do not go together.
    ///
    /// ```
    /// use spheremap::healpix::{Order, Pixels};
    /// let ring = Pixels::new(2, Order::Ring)?;
    /// let mut nested = [0; 3];
    /// ring.reordered(&[0, 1, -5], &mut nested)?;
    /// assert_eq!(nested, [3, 7, -1]); // what is no pixel stays none
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn reordered(&self, pixels: &[i64], output: &mut [i64]) -> Result<(), Error> {
        expect_length("output", output.len(), pixels.len())?;
        match self.order {
            Order::Ring => run(ToNested(self.grid), pixels, output),
            Order::Nested => run(ToRing(self.grid), pixels, output),
        }
        Ok(())
    }
}

/// Copies a map of `bytes` bytes a pixel into another arrangement.
///
/// # Errors
/// There is no such nside (nested order wants a power of two), a pixel has no bytes, or a slice has not 12 nside²
/// pixels.
///
/// ```
/// use spheremap::healpix::{Arrangement, arrange};
/// let ring: Vec<u8> = (0..48).collect();
/// let mut nested = [0; 48];
/// arrange(2, 1, (Arrangement::Ring, &ring), (Arrangement::Nested, &mut nested))?;
/// assert_eq!(nested[..4], [13, 5, 4, 0]);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn arrange(
    nside: i64,
    bytes: usize,
    source: (Arrangement, &[u8]),
    target: (Arrangement, &mut [u8]),
) -> Result<(), Error> {
    arrange_then(nside, bytes, source, target, &|_| ())
}

/// The same, with something done to each part of the target while it is in the cache.
pub(crate) fn arrange_then(
    nside: i64,
    bytes: usize,
    source: (Arrangement, &[u8]),
    target: (Arrangement, &mut [u8]),
    then: arrange::Then<'_>,
) -> Result<(), Error> {
    let nested = [source.0, target.0].contains(&Arrangement::Nested);
    let order = if nested { Order::Nested } else { Order::Ring };
    let grid = Pixels::new(nside, order)?.grid;
    if bytes == 0 {
        return Err(Error::Contradiction("a pixel has no bytes".into()));
    }
    let length = (12 * nside as usize * nside as usize).saturating_mul(bytes);
    expect_length("source", source.1.len(), length)?;
    expect_length("target", target.1.len(), length)?;
    arrange::copy(grid, bytes, source, target, then);
    Ok(())
}

#[derive(Clone, Copy)]
struct OfDirections<const NESTED: bool>(Grid);

impl<const NESTED: bool> Step<f64, i64, 3, 1> for OfDirections<NESTED> {
    #[inline(always)]
    fn apply(self, d: [f64; 3]) -> [i64; 1] {
        let (cell, is_direction) = cell_of_direction(self.0, d);
        let pixel = pixel_of::<NESTED>(self.0, cell);
        [choose(is_direction, pixel, NONE)]
    }
}

#[derive(Clone, Copy)]
struct Directions<const NESTED: bool>(Grid);

impl<const NESTED: bool> Step<i64, f64, 1, 3> for Directions<NESTED> {
    #[inline(always)]
    fn apply(self, [pixel]: [i64; 1]) -> [f64; 3] {
        let (pixel, is_pixel) = self.0.checked(pixel);
        let (z, sine, azimuth) = center(self.0, on_ring::<NESTED>(self.0, pixel));
        let (sin, cos) = f64::sin_cos_half_turns(azimuth);
        [sine * cos, sine * sin, z].map(|x| choose(is_pixel, x, f64::NAN))
    }
}

/// Half turns in a degree, or in a radian.
#[inline(always)]
fn half_turns_of(lonlat: bool) -> f64 {
    choose(lonlat, 1.0 / 180.0, FRAC_1_PI)
}

/// The latitude or the polar angle of a place, its azimuth in half turns from 0 to 2, and whether it is one.
#[inline(always)]
fn in_range(lonlat: bool, [a, b]: [f64; 2]) -> (f64, f64, bool) {
    let (tilt, turns) = (choose(lonlat, b, a), choose(lonlat, a, b));
    let (least, most) = (choose(lonlat, -90.0, 0.0), choose(lonlat, 90.0, PI));
    let turns = turns * half_turns_of(lonlat);
    let is_place = (tilt >= least) & (tilt <= most) & (turns.abs() < (1_u64 << 50) as f64);
    let azimuth = choose(is_place, turns, 0.0);
    // Whole turns come off before anything else.
    let azimuth = azimuth - 2.0 * Real::floor(0.5 * azimuth);
    (choose(is_place, tilt, 0.0), azimuth, is_place)
}

#[derive(Clone, Copy)]
struct OfAngles<const NESTED: bool>(Grid, bool);

impl<const NESTED: bool> Step<f64, i64, 2, 1> for OfAngles<NESTED> {
    #[inline(always)]
    fn apply(self, angles: [f64; 2]) -> [i64; 1] {
        let (tilt, azimuth, is_place) = in_range(self.1, angles);
        let tilt = tilt * half_turns_of(self.1);
        let (sin, cos) = f64::sin_cos_half_turns(tilt);
        let (sine, z) = (choose(self.1, cos, sin), choose(self.1, sin, cos));
        let (sin, cos) = f64::sin_cos_half_turns(azimuth);
        let (cell, _) = cell_of_direction(self.0, [sine * cos, sine * sin, z]);
        let pixel = pixel_of::<NESTED>(self.0, cell);
        [choose(is_place, pixel, NONE)]
    }
}

/// Ring numbers, and bits of weights: what an array holds is of one type.
#[derive(Clone, Copy)]
struct Between(Grid, bool);

impl Step<f64, i64, 2, 8> for Between {
    #[inline(always)]
    fn apply(self, angles: [f64; 2]) -> [i64; 8] {
        let (tilt, azimuth, is_place) = in_range(self.1, angles);
        // Beside a pole a difference of degrees is exact.
        let polar = choose(self.1, 90.0 - tilt, tilt) * half_turns_of(self.1);
        let (places, weights) = between(self.0, polar, azimuth);
        let [a, b, c, d] = places.map(|place| choose(is_place, self.0.ring(place), NONE));
        let [e, f, g, h] = weights.map(|x| choose(is_place, x, f64::NAN).to_bits().cast_signed());
        [a, b, c, d, e, f, g, h]
    }
}

#[derive(Clone, Copy)]
struct ToAngles<const NESTED: bool>(Grid, bool);

impl<const NESTED: bool> Step<i64, f64, 1, 2> for ToAngles<NESTED> {
    #[inline(always)]
    fn apply(self, [pixel]: [i64; 1]) -> [f64; 2] {
        let (pixel, is_pixel) = self.0.checked(pixel);
        let (z, sine, azimuth) = center(self.0, on_ring::<NESTED>(self.0, pixel));
        let azimuth = azimuth + choose(azimuth < 0.0, 2.0, 0.0);
        let angles = if self.1 {
            let polar = f64::half_turns(sine, z.abs());
            [
                180.0 * azimuth,
                180.0 * Real::negated_if(0.5 - polar, z < 0.0),
            ]
        } else {
            [PI * f64::half_turns(sine, z), PI * azimuth]
        };
        angles.map(|x| choose(is_pixel, x, f64::NAN))
    }
}

#[derive(Clone, Copy)]
struct ToNested(Grid);

impl Step<i64, i64, 1, 1> for ToNested {
    #[inline(always)]
    fn apply(self, [pixel]: [i64; 1]) -> [i64; 1] {
        let (pixel, is_pixel) = self.0.checked(pixel);
        let cell = self.0.cell(self.0.on_ring(pixel));
        [choose(is_pixel, self.0.nested(cell), NONE)]
    }
}

#[derive(Clone, Copy)]
struct ToRing(Grid);

impl Step<i64, i64, 1, 1> for ToRing {
    #[inline(always)]
    fn apply(self, [pixel]: [i64; 1]) -> [i64; 1] {
        let (pixel, is_pixel) = self.0.checked(pixel);
        let place = self.0.ring_of_cell(self.0.cell_of_nested(pixel));
        [choose(is_pixel, self.0.ring(place), NONE)]
    }
}

#[derive(Clone, Copy)]
struct Neighbors<const NESTED: bool>(Grid);

impl<const NESTED: bool> Step<i64, i64, 1, 8> for Neighbors<NESTED> {
    #[inline(always)]
    fn apply(self, [pixel]: [i64; 1]) -> [i64; 8] {
        let (pixel, is_pixel) = self.0.checked(pixel);
        let cell = if NESTED {
            self.0.cell_of_nested(pixel)
        } else {
            self.0.cell(self.0.on_ring(pixel))
        };
        if is_pixel & self.0.is_inside(cell) {
            return if NESTED {
                self.0.nested_around(cell)
            } else {
                self.0.ring_around(cell)
            };
        }
        let number = |cell| pixel_of::<NESTED>(self.0, cell);
        self.0
            .around(cell)
            .map(|cell| cell.filter(|_| is_pixel).map_or(NONE, number))
    }
}

#[inline(always)]
fn pixel_of<const NESTED: bool>(grid: Grid, cell: FaceCell) -> i64 {
    if NESTED {
        grid.nested(cell)
    } else {
        grid.ring(grid.ring_of_cell(cell))
    }
}

#[inline(always)]
fn on_ring<const NESTED: bool>(grid: Grid, pixel: i64) -> OnRing {
    if NESTED {
        grid.ring_of_cell(grid.cell_of_nested(pixel))
    } else {
        grid.on_ring(pixel)
    }
}
