//! Texels with weights of their own, of an image of which only parts are there: each part is weighed, what is weighed looked up
//! as any image, and a mean made of that. `spheremap.resample.seen_parts` does so.

use super::arrays::{finish, output, writable};
use super::images::{PyTexel, fill as filling, image, with_image};
use super::stopping::stoppable;
use crate::error::Error;
use crate::image::texel::Texel;
use crate::resample::weighted::{Looks, Weights};
use numpy::{Element, PyReadonlyArrayDyn};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// How texels are weighed: how many numbers each then has, and whether some are not finite and count for nothing; none where all weigh
/// the same.
#[pyfunction]
#[pyo3(signature = (object, channels, alpha, skipna, /))]
pub fn weights(
    object: &Bound<'_, PyAny>,
    channels: usize,
    alpha: Option<usize>,
    skipna: bool,
) -> PyResult<Option<(usize, bool)>> {
    expect_channels(channels, alpha)?;
    with_image!(image(object, None)?, image => {
        let found = Weights::of(image.as_slice()?, channels, alpha, skipna);
        Ok(found.map(|weights| (weights.width, weights.holes)))
    })
}

/// Products and weights of texels, in the floats in which they are filtered: (N, width).
#[pyfunction]
#[pyo3(signature = (object, channels, alpha, width, holes, /))]
pub fn weigh<'py>(
    py: Python<'py>,
    object: &Bound<'py, PyAny>,
    channels: usize,
    alpha: Option<usize>,
    width: usize,
    holes: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let weights = known(channels, alpha, width, holes)?;
    with_image!(image(object, None)?, image => weighed(py, &image, channels, weights))
}

fn weighed<'py, T: PyTexel>(
    py: Python<'py>,
    image: &PyReadonlyArrayDyn<'py, T>,
    channels: usize,
    weights: Weights,
) -> PyResult<Bound<'py, PyAny>>
where
    T::Float: Element,
{
    let texels = image.as_slice()?;
    let shape = [texels.len() / channels, weights.width];
    let array = output::<T::Float>(py, None, T::Float::NAME, &shape)?;
    {
        let mut target = writable(&array)?;
        let out = target.as_slice_mut()?;
        stoppable(py, || {
            weights.weigh_all(texels, out);
            Ok::<(), Error>(())
        })?;
    }
    finish(array, true)
}

/// Means, of what was looked up among weighed texels: by the filter and, where it rings and there are holes, by the four nearest
/// texels. Their dtype is that of `like`: (N, C).
#[pyfunction]
#[pyo3(signature = (like, channels, alpha, width, holes, seen, near, fill, /))]
#[expect(clippy::too_many_arguments, reason = "one call for each window")]
pub fn weighted_mean<'py>(
    py: Python<'py>,
    like: &Bound<'py, PyAny>,
    channels: usize,
    alpha: Option<usize>,
    width: usize,
    holes: bool,
    seen: &Bound<'py, PyAny>,
    near: Option<&Bound<'py, PyAny>>,
    fill: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let weights = known(channels, alpha, width, holes)?;
    with_image!(image(like, None)?, like => {
        mean(py, &like, channels, weights, [Some(seen), near], fill)
    })
}

fn mean<'py, T: PyTexel>(
    py: Python<'py>,
    _: &PyReadonlyArrayDyn<'py, T>,
    channels: usize,
    weights: Weights,
    looked: [Option<&Bound<'py, PyAny>>; 2],
    fill: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>>
where
    T::Float: Element,
{
    let arrays = looked
        .map(|looked| looked.map(|array| array.extract::<PyReadonlyArrayDyn<'py, T::Float>>()));
    let [Some(seen), near] = arrays else {
        return Err(PyValueError::new_err("Expected `seen`."));
    };
    let (seen, near) = (seen?, near.transpose()?);
    let seen = seen.as_slice()?;
    let near = near.as_ref().map(|near| near.as_slice()).transpose()?;
    let count = seen.len() / weights.width;
    if near.is_some_and(|near| near.len() != seen.len()) {
        return Err(PyValueError::new_err(
            "Expected `near` to be as long as `seen`.",
        ));
    }
    let fill = filling(fill)?.texel::<T>(channels)?;
    let array = output::<T>(py, None, T::NAME, &[count, channels])?;
    {
        let mut target = writable(&array)?;
        let out = target.as_slice_mut()?;
        let looks = Looks {
            count,
            ringing: near.is_some(),
        };
        stoppable(py, || {
            weights.mean(looks, &fill, out, |nearest, out| {
                out.copy_from_slice(near.filter(|_| nearest).unwrap_or(seen));
                Ok(())
            })
        })?;
    }
    finish(array, true)
}

fn expect_channels(channels: usize, alpha: Option<usize>) -> PyResult<()> {
    if channels == 0 || alpha.is_some_and(|alpha| alpha >= channels) {
        return Err(PyValueError::new_err(
            "Expected `alpha` to be one of the channels.",
        ));
    }
    Ok(())
}

fn known(channels: usize, alpha: Option<usize>, width: usize, holes: bool) -> PyResult<Weights> {
    expect_channels(channels, alpha)?;
    let fits = if holes {
        width == 2 * channels
    } else {
        width == channels || width == channels + 1
    };
    if !fits {
        return Err(PyValueError::new_err(
            "Expected a `width` that `weights` gave.",
        ));
    }
    Ok(Weights::with(channels, alpha, holes, width))
}
