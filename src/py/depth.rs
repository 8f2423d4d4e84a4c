//! Depth images as a function of the module.

use super::arrays::writable;
use super::projection::{PyProjection, size};
use super::stopping::stoppable;
use crate::resample::depth::{self, Depth};
use numpy::{PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// Turns an array of float32 or float64, which holds depths of the other kind, into depths of this one.
#[pyfunction]
#[pyo3(signature = (array, projection, shape, target, /))]
pub fn convert_depth<'py>(
    py: Python<'py>,
    array: &Bound<'py, PyAny>,
    projection: &PyProjection,
    shape: &Bound<'py, PyAny>,
    target: &str,
) -> PyResult<()> {
    let target = Depth::find(target)
        .ok_or_else(|| PyValueError::new_err(format!("unknown kind of depth '{target}'")))?;
    let (map, shape) = (&projection.0, size(&projection.0, shape)?);
    if let Ok(array) = array.cast::<PyArrayDyn<f32>>() {
        return in_place(array, |out| {
            stoppable(py, || depth::convert_depth(map, &shape, target, out))
        });
    }
    if let Ok(array) = array.cast::<PyArrayDyn<f64>>() {
        return in_place(array, |out| {
            stoppable(py, || depth::convert_depth(map, &shape, target, out))
        });
    }
    Err(PyTypeError::new_err(
        "Expected an array of float32 or float64.",
    ))
}

fn in_place<T: numpy::Element>(
    array: &Bound<'_, PyArrayDyn<T>>,
    work: impl FnOnce(&mut [T]) -> PyResult<()>,
) -> PyResult<()> {
    if !array.is_c_contiguous() || !array.data().is_aligned() {
        return Err(PyValueError::new_err("Expected `out` to be C-contiguous."));
    }
    work(writable(array)?.as_slice_mut()?)
}
