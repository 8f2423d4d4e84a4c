//! The transposed of [`project`](super::project): what flows back to the texels from coefficients, for gradients.
//!
//! Projecting is S Yᵀ W: each texel times its weight, sums with the basis, and what the fit makes of these. W is diagonal
//! and the fit symmetric, so the transposed is a function on the sphere, whose coefficients are those of the gradient after
//! the same fit, at the texels' directions and times their weights.

use super::evaluate::{evaluate, transformed};
use super::fit::Normal;
use super::rings::Rings;
use super::{HIGHEST, Samples, count, too_high};
use crate::error::{Error, expect_length};
use crate::kernel::memory::expect_room;
use crate::light::texels::texels;
use crate::map::Map;
use crate::projections::projection::Coverage;

/// What flows back to the texels of an image, `channels` numbers each, from as many of each of the (order + 1)²
/// coefficients.
///
/// # Errors
/// The gradient is not that of the coefficients of an order, or the image is too small for the order.
///
/// ```
/// use spheremap::{Map, light::sh};
/// let map = Map::new("cube")?;
/// let back = sh::project_adjoint(&map, &[6, 4, 4], &[(4.0 * std::f64::consts::PI).sqrt()], 1, sh::Samples::Means)?;
/// assert!((back.iter().sum::<f64>() - 4.0 * std::f64::consts::PI).abs() < 1e-12); // all solid angles
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn project_adjoint(
    map: &Map,
    shape: &[usize],
    gradient: &[f64],
    channels: usize,
    samples: Samples,
) -> Result<Vec<f64>, Error> {
    let channels = channels.max(1);
    let order = (gradient.len() / channels).isqrt().max(1) - 1;
    expect_length("gradient", gradient.len(), count(order) * channels)?;
    if order > HIGHEST {
        return Err(too_high(shape, order, HIGHEST));
    }
    let whole = map.coverage() == Coverage::Sphere;
    if whole && let Some(rings) = Rings::of(map, shape)? {
        if order > rings.highest() {
            return Err(too_high(shape, order, rings.highest()));
        }
        let [a, b, c] = rings.frame;
        let back = [0, 1, 2].map(|k| [a[k], b[k], c[k]]);
        let own = transformed(gradient, channels, order, &back)?;
        let (function, weights) = match samples {
            Samples::Points => (own, rings.exact()),
            Samples::Means => {
                let normal = Normal::moments_of_rings(&rings, order);
                let fitted = normal.transposed(&own, channels);
                let fitted = fitted.ok_or_else(|| too_high(shape, order, rings.highest() / 2))?;
                (fitted, rings.solid_angles())
            }
        };
        let points = rings.points(&weights);
        return weighted(
            &function,
            channels,
            [&points.x, &points.y, &points.z],
            &points.weight,
        )
        .map(|mut found| {
            // Rows of points are filled up to whole vectors.
            found.truncate(shape.iter().product::<usize>() * channels);
            found
        });
    }
    let texels = texels(map, shape)?;
    let function = if whole {
        let n = texels.weight.iter().filter(|w| **w > 0.0).count();
        let highest = (n as f64).sqrt() as usize;
        if count(order) > n {
            return Err(too_high(shape, order, highest.saturating_sub(1)));
        }
        let normal = Normal::moments_of(&texels, order);
        let fitted = match samples {
            Samples::Points => normal.fitted(gradient, channels),
            Samples::Means => normal.transposed(gradient, channels),
        };
        fitted.ok_or_else(|| too_high(shape, order, highest / 2))?
    } else {
        gradient.to_vec()
    };
    let axes = [&texels.x[..], &texels.y, &texels.z];
    let found = weighted(&function, channels, axes, &texels.weight)?;
    Ok(texels.stored(&found, channels))
}

/// Values of a function at points, times their weights.
fn weighted(
    function: &[f64],
    channels: usize,
    [x, y, z]: [&[f64]; 3],
    weights: &[f64],
) -> Result<Vec<f64>, Error> {
    expect_room::<f64>((3 + channels) * weights.len())?;
    let mut directions = Vec::with_capacity(3 * weights.len());
    for ((x, y), z) in x.iter().zip(y).zip(z) {
        directions.extend([*x, *y, *z]);
    }
    let mut found = vec![0.0; channels * weights.len()];
    evaluate(function, channels, &directions, &mut found)?;
    for (values, weight) in found.chunks_exact_mut(channels).zip(weights) {
        for value in values {
            // A point that only fills a row up has no direction.
            *value = if *weight == 0.0 { 0.0 } else { *value * weight };
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::ImageView;
    use crate::light::sh::project;
    use crate::map::MapOptions;

    /// Numbers between 0 and 1 that follow no pattern.
    fn numbers(count: usize, seed: u64) -> Vec<f64> {
        (0..count as u64)
            .map(|k| ((k * 2_654_435_761 + seed * 40_503) % 1_000_003) as f64 / 1_000_003.0)
            .collect()
    }

    #[test]
    fn it_is_the_transposed_on_rings_elsewhere_and_on_parts_of_the_sphere() -> Result<(), Error> {
        for (name, grid, shape) in [
            ("latlong", "centers", &[12, 24][..]),
            ("latlong", "corners", &[13, 25]),
            ("latlong", "corners-v", &[13, 24]),
            ("cube", "centers", &[6, 8, 8]),
            ("perspective", "centers", &[10, 10]),
        ] {
            let map = Map::with(name, MapOptions::new().grid(grid))?;
            let texels: usize = shape.iter().product();
            let (image, gradient) = (numbers(2 * texels, 1), numbers(2 * count(3), 2));
            let view = ImageView::new(&map, shape, 2, &image)?;
            for samples in [Samples::Means, Samples::Points] {
                let found = project(&view, 3, samples)?;
                let back = project_adjoint(&map, shape, &gradient, 2, samples)?;
                let product =
                    |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
                let (left, right) = (product(&found, &gradient), product(&image, &back));
                // A fit ends where its residual is 1e-13.
                assert!((left - right).abs() < 1e-11, "{name}: {left} and {right}");
            }
        }
        Ok(())
    }
}
