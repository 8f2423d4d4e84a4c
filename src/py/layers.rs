//! Views of one panorama put together, of which `spheremap.cameras.stitch` makes a few rows at a time.

use super::arrays::{Float, contiguous, disjoint, finish, output, writable};
use super::images::{PyTexel, image, with_image};
use super::stopping::released;
use crate::resample::layers;
use numpy::{Element, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Adds a layer, of channels and a weight, to another one of its shape and dtype, or puts it where it weighs more.
#[pyfunction]
#[pyo3(signature = (total, layer, nearest, /))]
pub fn add_layer<'py>(
    py: Python<'py>,
    total: &Bound<'py, PyAny>,
    layer: &Bound<'py, PyAny>,
    nearest: bool,
) -> PyResult<()> {
    if let Some(layer) = contiguous::<f32>(layer)? {
        return added(py, total, &layer, nearest);
    }
    match contiguous::<f64>(layer)? {
        Some(layer) => added(py, total, &layer, nearest),
        None => Err(PyValueError::new_err(
            "Expected `layer` to be a C-contiguous array of float32 or float64.",
        )),
    }
}

fn added<'py, F: Float>(
    py: Python<'py>,
    total: &Bound<'py, PyAny>,
    layer: &PyReadonlyArrayDyn<'py, F>,
    nearest: bool,
) -> PyResult<()> {
    let channels = channels_of(layer.shape())?;
    let array = output::<F>(py, Some(total), F::NAME, layer.shape())?;
    let mut target = writable(&array)?;
    let (layer, total) = (layer.as_slice()?, target.as_slice_mut()?);
    disjoint(layer, total)?;
    released(py, || layers::add(total, layer, channels, nearest))
}

/// The values of a layer by its weights, in the dtype of `like`: (N, channels).
#[pyfunction]
#[pyo3(signature = (total, like, /))]
pub fn divide_layer<'py>(
    py: Python<'py>,
    total: &Bound<'py, PyAny>,
    like: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    with_image!(image(like, None)?, like => divided(py, total, &like))
}

fn divided<'py, T: PyTexel>(
    py: Python<'py>,
    total: &Bound<'py, PyAny>,
    _: &PyReadonlyArrayDyn<'py, T>,
) -> PyResult<Bound<'py, PyAny>>
where
    T::Float: Element,
{
    let Some(total) = contiguous::<T::Float>(total)? else {
        return Err(PyValueError::new_err(
            "Expected `total` to be a C-contiguous array of the floats of `like`.",
        ));
    };
    let channels = channels_of(total.shape())?;
    let total = total.as_slice()?;
    let array = output::<T>(py, None, T::NAME, &[total.len() / (channels + 1), channels])?;
    {
        let mut target = writable(&array)?;
        let out = target.as_slice_mut()?;
        released(py, || layers::divide(total, channels, out))?;
    }
    finish(array, true)
}

/// How many channels there are beside the weight.
fn channels_of(shape: &[usize]) -> PyResult<usize> {
    match shape.last() {
        Some(&width) if width > 1 => Ok(width - 1),
        _ => Err(PyValueError::new_err(
            "Expected a layer to have a channel and a weight.",
        )),
    }
}
