//! What flows back from lookups and from coordinates: for the tensors of other libraries.
//!
//! Arrays are contiguous and of one float type: who calls has seen to it.

use super::arrays::{Float, contiguous, finish, output, writable};
use super::images::split;
use super::projection::{PyProjection, size};
use super::stopping::stoppable;
use crate::error::Error;
use crate::image::ImageView;
use crate::image::texel::Texel;
use crate::map::Map;
use crate::resample::{self, Filter};
use numpy::{Element, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// A float type that texels are, and weights.
pub(super) trait Number: Float + Texel<Float = Self> {}
impl Number for f32 {}
impl Number for f64 {}

pub(super) fn array<'py, T: Element>(
    object: &Bound<'py, PyAny>,
    name: &str,
) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    contiguous(object)?.ok_or_else(|| {
        PyTypeError::new_err(format!(
            "Expected `{name}` to be contiguous, and of the dtype of the others."
        ))
    })
}

/// Makes an array of a shape by work that runs without the lock.
pub(super) fn made<'py, T: Number>(
    py: Python<'py>,
    shape: &[usize],
    work: impl FnOnce(&mut [T]) -> Result<(), Error> + Send,
) -> PyResult<Bound<'py, PyAny>> {
    let array = output::<T>(py, None, <T as Float>::NAME, shape)?;
    {
        let mut target = writable(&array)?;
        let out = target.as_slice_mut()?;
        stoppable(py, || work(out))?;
    }
    finish(array, true)
}

/// What flows back to the texels of images of a shape, (*shape, C), from lookups (N, C) in directions (N, 3).
#[pyfunction]
#[pyo3(signature = (projection, shape, filter, directions, gradient, /))]
pub fn sample_adjoint<'py>(
    py: Python<'py>,
    projection: &PyProjection,
    shape: &Bound<'py, PyAny>,
    filter: &str,
    directions: &Bound<'py, PyAny>,
    gradient: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let (map, filter) = (&projection.0, Filter::find(filter)?);
    let shape = size(map, shape)?;
    if contiguous::<f32>(gradient)?.is_some() {
        spread::<f32>(py, map, shape, filter, directions, gradient)
    } else {
        spread::<f64>(py, map, shape, filter, directions, gradient)
    }
}

fn spread<'py, T: Number>(
    py: Python<'py>,
    map: &Map,
    shape: Vec<usize>,
    filter: Filter,
    directions: &Bound<'py, PyAny>,
    gradient: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let directions = array::<T>(directions, "directions")?;
    let gradient = array::<T>(gradient, "gradient")?;
    let &[_, channels] = gradient.shape() else {
        return Err(PyValueError::new_err("Expected `gradient` to be (N, C)."));
    };
    let whole = [&shape[..], &[channels]].concat();
    let (directions, gradient) = (directions.as_slice()?, gradient.as_slice()?);
    made(py, &whole, |out| {
        resample::sample_adjoint(map, &shape, filter, directions, gradient, out)
    })
}

/// What flows back to u and v, (N, 2), from bilinear lookups (N, C) of directions (N, 3); NaN where they have rules of their own.
#[pyfunction]
#[pyo3(signature = (projection, image, directions, gradient, /))]
pub fn sample_slopes<'py>(
    py: Python<'py>,
    projection: &PyProjection,
    image: &Bound<'py, PyAny>,
    directions: &Bound<'py, PyAny>,
    gradient: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    if contiguous::<f32>(image)?.is_some() {
        slopes::<f32>(py, &projection.0, image, directions, gradient)
    } else {
        slopes::<f64>(py, &projection.0, image, directions, gradient)
    }
}

fn slopes<'py, T: Number>(
    py: Python<'py>,
    map: &Map,
    image: &Bound<'py, PyAny>,
    directions: &Bound<'py, PyAny>,
    gradient: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let image = array::<T>(image, "image")?;
    let directions = array::<T>(directions, "directions")?;
    let gradient = array::<T>(gradient, "gradient")?;
    let (shape, channels, _) = split(map, image.shape())?;
    let image = ImageView::new(map, shape, channels, image.as_slice()?)?;
    let (directions, gradient) = (directions.as_slice()?, gradient.as_slice()?);
    made(py, &[directions.len() / 3, 2], |out| {
        resample::sample_slopes(&image, directions, gradient, out)
    })
}

/// What flows back to directions (N, 3) from u and v of their places (N, 2).
#[pyfunction]
#[pyo3(signature = (projection, directions, gradient, /))]
pub fn encode_gradient<'py>(
    py: Python<'py>,
    projection: &PyProjection,
    directions: &Bound<'py, PyAny>,
    gradient: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    if contiguous::<f32>(directions)?.is_some() {
        pulled::<f32>(py, &projection.0, directions, gradient)
    } else {
        pulled::<f64>(py, &projection.0, directions, gradient)
    }
}

fn pulled<'py, T: Number>(
    py: Python<'py>,
    map: &Map,
    directions: &Bound<'py, PyAny>,
    gradient: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let directions = array::<T>(directions, "directions")?;
    let gradient = array::<T>(gradient, "gradient")?;
    let shape = directions.shape();
    let (directions, gradient) = (directions.as_slice()?, gradient.as_slice()?);
    made(py, shape, |out| {
        map.encode_gradient(directions, gradient, out)
    })
}

/// Sums of the texels of images (N, F, C, M) by the rows of a sparse matrix, which has places for columns: (N, F', C, M'), of so many faces.
#[pyfunction]
#[pyo3(signature = (ends, columns, weights, source, faces, /))]
pub fn sums_of_planes<'py>(
    py: Python<'py>,
    ends: &Bound<'py, PyAny>,
    columns: &Bound<'py, PyAny>,
    weights: &Bound<'py, PyAny>,
    source: &Bound<'py, PyAny>,
    faces: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let ends = array::<i32>(ends, "ends")?;
    let columns = array::<i32>(columns, "columns")?;
    let rows = (ends.as_slice()?, columns.as_slice()?);
    if contiguous::<f32>(source)?.is_some() {
        summed::<f32>(py, rows, weights, source, faces)
    } else {
        summed::<f64>(py, rows, weights, source, faces)
    }
}

fn summed<'py, T: Number>(
    py: Python<'py>,
    (ends, columns): (&[i32], &[i32]),
    weights: &Bound<'py, PyAny>,
    source: &Bound<'py, PyAny>,
    faces: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let weights = array::<T>(weights, "weights")?;
    let source = array::<T>(source, "source")?;
    let &[images, from, channels, _] = source.shape() else {
        return Err(PyValueError::new_err(
            "Expected `source` to be (N, F, C, M).",
        ));
    };
    let (weights, source) = (weights.as_slice()?, source.as_slice()?);
    let height = ends.len().saturating_sub(1) / faces.max(1);
    made(py, &[images, faces, channels, height], |out| {
        let matrix = (ends, columns, weights);
        resample::sums_of_planes(matrix, channels, [from, faces], source, out)
    })
}
