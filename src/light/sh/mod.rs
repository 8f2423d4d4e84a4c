//! Real spherical harmonics: Y_l,m for l up to [`HIGHEST`], of images of any map.
//!
//! Orthonormal, without the Condon–Shortley phase, z the polar axis, coefficient l² + l + m: Y_1,-1, Y_1,0 and
//! Y_1,1 are √(3/4π) times y, z and x (Ramamoorthi & Hanrahan 2001). Every other program's order and signs are a
//! matter of the Python layer.
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
mod count;
pub mod fit;
pub mod rings;

use crate::error::Error;
use crate::image::texel::Texel;
use crate::light::texels::texels;
use crate::map::Map;
use crate::projections::projection::Coverage;
use basis::Basis;
pub use count::count;

/// The highest order that images are analyzed to.
pub const HIGHEST: usize = 64;

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

/// The value at each direction (three numbers of any length): one number a channel. NaN for a direction
/// that is none.
pub fn evaluate(coefficients: &[f64], channels: usize, directions: &[f64], out: &mut [f64]) {
    let order = ((coefficients.len() / channels) as f64).sqrt() as usize - 1;
    let basis = Basis::new(order);
    crate::kernel::threads::rows(
        out,
        256 * channels,
        directions.len() / 3 * (order + 1),
        |part, out| {
            let n = out.len() / channels;
            let directions = &directions[3 * 256 * part..][..3 * n];
            let mut points = basis::Points::default();
            for d in directions.as_chunks::<3>().0 {
                let size = d.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
                // Scaled first: squares of small and large components would vanish and overflow.
                let d = d.map(|c| c / size);
                let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
                points.push(d.map(|c| c / length), 0.0);
            }
            points.fill_up();
            basis.synthesize(&points, coefficients, channels, out);
        },
    );
}

/// The coefficients of the image turned by an orthogonal matrix (rows): f'(M d) = f(d).
///
/// A band-limited function is known from its values on a grid of rings of the same order. So it is looked up
/// at the turned grid and analyzed again, which is exact but for rounding, at any order, and needs
/// no recursion over rotation matrices.
pub fn rotate(
    coefficients: &[f64],
    channels: usize,
    order: usize,
    matrix: &[[f64; 3]; 3],
) -> Vec<f64> {
    let grid = rings::grid(2 * order + 1);
    let mut directions = Vec::with_capacity(3 * grid.len());
    for k in 0..grid.len() {
        let d = grid.direction(k);
        // Back by the transpose.
        let [a, b, c] = matrix;
        directions.extend([0, 1, 2].map(|i| a[i] * d[0] + b[i] * d[1] + c[i] * d[2]));
    }
    let mut values = vec![0.0; channels * grid.len()];
    evaluate(coefficients, channels, &directions, &mut values);
    basis::analyze_points(&grid, &values, channels, order)
}
