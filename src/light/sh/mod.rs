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

mod adjoint;
pub(crate) mod apart;
pub(crate) mod basis;
pub mod conventions;
mod count;
pub(crate) mod evaluate;
pub(crate) mod fit;
pub mod lobes;
pub(crate) mod rings;
mod source;
pub mod windows;

pub use adjoint::project_adjoint;
pub use count::count;
pub use evaluate::{evaluate, rotate, scale_degrees};
pub use source::{HIGHEST_PRINTED, code};

use crate::error::Error;
use crate::image::ImageView;
use crate::image::texel::Texel;
use crate::kernel::interrupt;
use crate::light::texels::texels;
use crate::projections::projection::Coverage;

/// The highest order that images are analyzed to.
pub const HIGHEST: usize = 64;

/// What the texels of an image are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Samples {
    /// Each is the mean over its solid angle, as in photos and renderings: order 0 is ∫ L dω/√4π, to rounding.
    #[default]
    Means,
    /// Each is the value at its center: no degree leaks into another, order 0 included.
    Points,
}

/// The coefficients of an image: (order + 1)² rows of one number a channel.
///
/// # Errors
/// The image is too small for the order.
///
/// ```
/// use spheremap::{Map, image::ImageView, light::sh};
/// let map = Map::new("latlong")?;
/// let white = vec![1.0_f32; 16 * 32];
/// let white = ImageView::new(&map, &[16, 32], 1, &white)?;
/// let coefficients = sh::project(&white, 2, sh::Samples::Means)?;
/// assert_eq!(coefficients.len(), sh::count(2));
/// let mean = (4.0 * std::f64::consts::PI).sqrt(); // of the constant 1, times Y_0,0
/// assert!((coefficients[0] - mean).abs() < 1e-12);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn project<T: Texel>(
    image: &ImageView<'_, T>,
    order: usize,
    samples: Samples,
) -> Result<Vec<f64>, Error> {
    let (map, shape, channels) = (image.map(), image.shape(), image.channels());
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
        let own = match samples {
            Samples::Points => rings.analyze(image, order, &rings.exact()),
            Samples::Means => {
                let normal = fit::Sums::of_rings(&rings, image, order);
                kept(&normal, channels, order).ok_or_else(|| too_high(shape, order, highest / 2))?
            }
        };
        return evaluate::transformed(&own, channels, order, &rings.frame);
    }
    let texels = interrupt::part(0.0, 0.5, || texels(map, shape))?;
    if !whole {
        let flux = texels.flux(image, false)?;
        return Ok(interrupt::part(0.5, 1.0, || {
            fit::sums(&texels, &flux, channels, order)
        }));
    }
    let n = texels.weight.iter().filter(|w| **w > 0.0).count();
    let highest = (n as f64).sqrt() as usize;
    if count(order) > n {
        return Err(too_high(shape, order, highest.saturating_sub(1)));
    }
    let normal = interrupt::part(0.5, 1.0, || fit::Sums::new(&texels, image, order))?;
    let found = match samples {
        Samples::Points => normal.solution(channels, order),
        Samples::Means => kept(&normal, channels, order),
    };
    found.ok_or_else(|| too_high(shape, order, highest / 2))
}

/// The fit, but for order 0: that is the sum over the texels, which keeps the light.
fn kept(normal: &fit::Sums, channels: usize, order: usize) -> Option<Vec<f64>> {
    let mut found = normal.solution(channels, order)?;
    found[..channels].copy_from_slice(&normal.right[..channels]);
    Some(found)
}

fn too_high(shape: &[usize], order: usize, highest: usize) -> Error {
    Error::Shape(format!(
        "An image of shape {} holds spherical harmonics up to order {highest}, got `order` {order}.",
        crate::image::raster::tuple(shape)
    ))
}
