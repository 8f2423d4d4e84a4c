//! Borders as a function of the module.

use super::arrays::{disjoint, finish, output, writable};
use super::images::{PyTexel, image, split, with_image};
use super::projection::PyProjection;
use super::stopping::stoppable;
use crate::image::ImageView;
use crate::map::Map;
use crate::resample;
use crate::resample::Filter;
use numpy::{PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;

/// The image with a border of `n` texels around each face.
#[pyfunction]
#[pyo3(signature = (object, projection, n, filter, /))]
pub fn pad<'py>(
    py: Python<'py>,
    object: &Bound<'py, PyAny>,
    projection: &PyProjection,
    n: usize,
    filter: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let filter = Filter::find(filter)?;
    with_image!(image(object, None)?, image => padded(py, &projection.0, &image, n, filter))
}

fn padded<'py, T: PyTexel>(
    py: Python<'py>,
    map: &Map,
    image: &PyReadonlyArrayDyn<'py, T>,
    n: usize,
    filter: Filter,
) -> PyResult<Bound<'py, PyAny>> {
    let (shape, channels, texel) = split(map, image.shape())?;
    let mut whole = resample::padded_shape(map, shape, n)?;
    whole.extend_from_slice(texel);
    let view = ImageView::new(map, shape, channels, image.as_slice()?)?;
    let array = output::<T>(py, None, T::NAME, &whole)?;
    {
        let mut target = writable(&array)?;
        let out = target.as_slice_mut()?;
        disjoint(view.texels(), out)?;
        stoppable(py, || resample::pad(&view, n, filter, out))?;
    }
    finish(array, true)
}
