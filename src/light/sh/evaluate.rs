//! Functions on the sphere from their coefficients: looked up, turned, and multiplied degree by degree.
//!
//! Coefficients are rows of one number a channel, row l² + l + m. A product with a factor for each degree is a
//! convolution with a function that is round about its axis (Funk 1916, Hecke 1918): the factors of lobes are
//! [`super::lobes`], those of windows [`super::windows`].

use super::basis::{Basis, Points, analyze_points};
use super::{count, rings};
use crate::error::{Error, expect_length, expect_multiple};
use crate::geometry::axes::rotation;
use crate::kernel::threads;

/// The value at each direction (three numbers of any length): one number a channel. NaN for a direction
/// that is none.
///
/// # Errors
/// The coefficients are not those of an order, or the slices' lengths do not go together.
///
/// ```
/// use spheremap::light::sh;
/// let half = 0.5 * std::f64::consts::PI.sqrt().recip(); // Y_0,0
/// let mut out = [0.0];
/// sh::evaluate(&[2.0], 1, &[0.0, 0.0, 1.0], &mut out)?;
/// assert!((out[0] - 2.0 * half).abs() < 1e-15);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn evaluate(
    coefficients: &[f64],
    channels: usize,
    directions: &[f64],
    out: &mut [f64],
) -> Result<(), Error> {
    let rows = (coefficients.len() / channels.max(1)).isqrt().max(1);
    expect_length(
        "coefficients",
        coefficients.len(),
        rows * rows * channels.max(1),
    )?;
    expect_multiple("directions", directions.len(), 3)?;
    expect_length("out", out.len(), directions.len() / 3 * channels)?;
    let order = rows - 1;
    let basis = Basis::new(order);
    threads::rows(
        out,
        256 * channels,
        directions.len() / 3 * (order + 1),
        |part, out| {
            let n = out.len() / channels;
            let directions = &directions[3 * 256 * part..][..3 * n];
            let mut points = Points::default();
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
    Ok(())
}

/// The coefficients of the image turned by a rotation (rows): f'(M d) = f(d).
///
/// A band-limited function is known from its values on a grid of rings of the same order. So it is looked up
/// at the turned grid and analyzed again, which is exact but for rounding, at any order, and needs
/// no recursion over rotation matrices.
///
/// # Errors
/// There are not (order + 1)² coefficients a channel, or `matrix` is no rotation.
///
/// ```
/// use spheremap::light::sh;
/// let quarter = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]; // x to y
/// let turned = sh::rotate(&[0.0, 0.0, 0.0, 1.0], 1, 1, &quarter)?; // Y_1,1 is along x, Y_1,-1 along y
/// assert!((turned[1] - 1.0).abs() < 1e-14);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn rotate(
    coefficients: &[f64],
    channels: usize,
    order: usize,
    matrix: &[[f64; 3]; 3],
) -> Result<Vec<f64>, Error> {
    rotation(*matrix)?;
    transformed(coefficients, channels, order, matrix)
}

/// The same by any orthogonal matrix: frames of images may mirror.
pub(super) fn transformed(
    coefficients: &[f64],
    channels: usize,
    order: usize,
    matrix: &[[f64; 3]; 3],
) -> Result<Vec<f64>, Error> {
    if channels == 0 {
        return Err(Error::Shape(
            "Expected coefficients of at least one channel, got 0.".to_owned(),
        ));
    }
    let expected = count(order).saturating_mul(channels);
    expect_length("coefficients", coefficients.len(), expected)?;
    let grid = rings::grid(2 * order + 1);
    let mut directions = Vec::with_capacity(3 * grid.len());
    for k in 0..grid.len() {
        let d = grid.direction(k);
        // Back by the transpose.
        let [a, b, c] = matrix;
        directions.extend([0, 1, 2].map(|i| a[i] * d[0] + b[i] * d[1] + c[i] * d[2]));
    }
    let mut values = vec![0.0; channels * grid.len()];
    evaluate(coefficients, channels, &directions, &mut values)?;
    Ok(analyze_points(&grid, &values, channels, order))
}

/// The coefficients with those of degree l multiplied by `factors[l]`.
///
/// ```
/// use spheremap::light::sh::scale_degrees;
/// assert_eq!(scale_degrees(&[1.0, 1.0, 1.0, 1.0], 1, &[1.0, 0.5])?, [1.0, 0.5, 0.5, 0.5]);
/// # Ok::<(), spheremap::Error>(())
/// ```
///
/// # Errors
/// There are not as many degrees of coefficients as factors.
pub fn scale_degrees(
    coefficients: &[f64],
    channels: usize,
    factors: &[f64],
) -> Result<Vec<f64>, Error> {
    let expected = factors.len() * factors.len() * channels;
    expect_length("coefficients", coefficients.len(), expected)?;
    let rows = coefficients.chunks(channels.max(1)).enumerate();
    Ok(rows
        .flat_map(|(k, row)| row.iter().map(move |x| x * factors[k.isqrt()]))
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_rotations_rotate() {
        let of = |m: [f64; 3], channels| {
            let matrix = [[m[0], 0.0, 0.0], [0.0, m[1], 0.0], [0.0, 0.0, m[2]]];
            rotate(&[0.0, 0.0, 1.0, 0.0], channels, 1, &matrix)
        };
        assert!(of([-1.0, -1.0, 1.0], 1).is_ok());
        for wrong in [[1.0, 1.0, -1.0], [2.0; 3], [f64::NAN; 3]] {
            assert!(matches!(of(wrong, 1), Err(Error::Rotation(_))));
        }
        for channels in [0, 3, usize::MAX] {
            assert!(of([1.0; 3], channels).is_err());
        }
        assert!(rotate(&[], 0, usize::MAX, &[[0.0; 3]; 3]).is_err());
        assert_eq!(count(usize::MAX), usize::MAX);
    }
}
