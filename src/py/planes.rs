//! Images whose channels are planes into texels and back, for the tensors of other libraries.

use super::arrays::{contiguous, disjoint, output, writable};
use super::gradients::{Number, array, made};
use super::stopping::released;
use crate::image::planes::Planes;
use numpy::PyUntypedArrayMethods;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Images (N, F, C, M) as texels (F·M, N·C).
#[pyfunction]
#[pyo3(signature = (planes, /))]
pub fn texels_of_planes<'py>(
    py: Python<'py>,
    planes: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    if contiguous::<f32>(planes)?.is_some() {
        texels_of::<f32>(py, planes)
    } else {
        texels_of::<f64>(py, planes)
    }
}

fn texels_of<'py, T: Number>(
    py: Python<'py>,
    planes: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let planes = array::<T>(planes, "planes")?;
    let shape = shape_of(planes.shape())?;
    let planes = planes.as_slice()?;
    let sides = [shape.faces * shape.side, shape.images * shape.channels];
    made(py, &sides, |out| {
        shape.texels_of(planes, out);
        Ok(())
    })
}

/// Fills images (N, F, C, M) with texels (F·M, N·C).
#[pyfunction]
#[pyo3(signature = (texels, planes, /))]
pub fn planes_of_texels<'py>(
    py: Python<'py>,
    texels: &Bound<'py, PyAny>,
    planes: &Bound<'py, PyAny>,
) -> PyResult<()> {
    if contiguous::<f32>(texels)?.is_some() {
        planes_of::<f32>(py, texels, planes)
    } else {
        planes_of::<f64>(py, texels, planes)
    }
}

fn planes_of<'py, T: Number>(
    py: Python<'py>,
    texels: &Bound<'py, PyAny>,
    planes: &Bound<'py, PyAny>,
) -> PyResult<()> {
    let texels = array::<T>(texels, "texels")?;
    let sides: Vec<usize> = planes.getattr("shape")?.extract()?;
    let shape = shape_of(&sides)?;
    let array = output::<T>(py, Some(planes), <T as super::arrays::Float>::NAME, &sides)?;
    let mut target = writable(&array)?;
    let (texels, planes) = (texels.as_slice()?, target.as_slice_mut()?);
    if texels.len() != planes.len() {
        return Err(PyValueError::new_err(
            "Expected as many numbers of texels as of planes.",
        ));
    }
    disjoint(texels, planes)?;
    released(py, || shape.planes_of(texels, planes))
}

fn shape_of(shape: &[usize]) -> PyResult<Planes> {
    match *shape {
        [images, faces, channels, side] => Ok(Planes {
            images,
            faces,
            channels,
            side,
        }),
        _ => Err(PyValueError::new_err(
            "Expected `planes` to be (N, F, C, M).",
        )),
    }
}
