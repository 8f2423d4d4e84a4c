//! Real spherical harmonics: Y_l,m for l up to [`HIGHEST`], of images of any map.
//!
//! Orthonormal, without the Condon–Shortley phase, z the polar axis, coefficient l² + l + m: Y_1,-1, Y_1,0 and
//! Y_1,1 are √(3/4π) times y, z and x (Ramamoorthi & Hanrahan 2001). Every other program's order, signs and
//! scales are a row of [`conventions`].
//!
//! Two ways from an image to coefficients:
//!
//! - **rings** ([`rings`]): where texels lie on circles of latitude, evenly spaced in both angles, a Fourier sum along
//!   each and Fejér's first rule (or Clenshaw and Curtis's) across them. That is exact for band-limited
//!   images: Σ over H rows integrates every product of degrees below H. Whether an image is such is
//!   found by looking at its directions, not at its name.
//! - **fit** ([`fit`]): everywhere else the coefficients are those of the least squares fit, weighted by solid angle. A
//!   band-limited image is its own best fit, so that there is no leak of one degree into another,
//!   which plain sums have, even with exact solid angles: 1e-5 at 512² and 1e-2 at 16².
//!
//! Where the coverage is a part of the sphere, the rest is black and the sums are plain.

pub mod basis;
pub mod conventions;
pub mod evaluate;
pub mod fit;
pub mod lobes;
pub mod rings;
pub mod windows;

use crate::error::Error;
use crate::image::texel::Texel;
use crate::light::texels::texels;
use crate::map::Map;
use crate::projections::projection::Coverage;
use evaluate::rotate;

/// The highest order that images are analyzed to.
pub const HIGHEST: usize = 64;

/// The number of coefficients up to an order.
pub fn count(order: usize) -> usize {
    (order + 1) * (order + 1)
}

/// The coefficients of an image: (order + 1)² rows of one number a channel.
pub fn project<T: Texel>(
    map: &Map,
    shape: &[usize],
    image: &[T],
    channels: usize,
    order: usize,
) -> Result<Vec<f64>, Error> {
    if order > HIGHEST {
        return Err(Error::Contradiction(format!(
            "Expected `order` to be at most {HIGHEST}, got {order}."
        )));
    }
    let whole = map.coverage() == Coverage::Sphere;
    if whole && let Some(rings) = rings::Rings::of(map, shape)? {
        let highest = rings.highest();
        if order > highest {
            return Err(too_high(shape, order, highest));
        }
        let own = rings.analyze(image, channels, order);
        return Ok(rotate(&own, channels, order, &rings.frame));
    }
    let texels = texels(map, shape)?;
    if !whole {
        let flux = texels.flux(image, channels, false);
        return Ok(fit::sums(&texels, &flux, channels, order));
    }
    let n = texels.weight.iter().filter(|w| **w > 0.0).count();
    let highest = (n as f64).sqrt() as usize;
    if count(order) > n {
        return Err(too_high(shape, order, highest.saturating_sub(1)));
    }
    fit::fitted(&texels, image, channels, order).ok_or_else(|| too_high(shape, order, highest / 2))
}

fn too_high(shape: &[usize], order: usize, highest: usize) -> Error {
    Error::Shape(format!(
        "An image of shape {} holds spherical harmonics up to order {highest}, got `order` {order}.",
        crate::image::raster::tuple(shape)
    ))
}
