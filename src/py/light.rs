//! Light as functions of the module: images in, float64 arrays out. `spheremap._light` and its neighbors
//! check images, choose defaults and restore dtypes.

use super::arrays::{finish, output, writable};
use super::images::{image, view, with_image};
use super::projection::{PyProjection, size};
use super::stopping::{released, stoppable};
use crate::image::{finite, rim, weights};
use crate::kernel::interrupt;
use crate::light::prefilter::{Distribution, Source};
use crate::light::{Lobe, dfg as table, integrate, lit, under};
use numpy::{PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Fills a new float64 array.
pub fn filled<'py>(
    py: Python<'py>,
    shape: &[usize],
    work: impl FnOnce(&mut [f64]) -> Result<(), crate::error::Error> + Send,
) -> PyResult<Bound<'py, PyAny>> {
    let array = output::<f64>(py, None, "float64", shape)?;
    {
        let mut target = writable(&array)?;
        let out = target.as_slice_mut()?;
        stoppable(py, || work(out))?;
    }
    finish(array, true)
}

/// A new float64 array of numbers that are known.
pub fn filled_with<'py>(
    py: Python<'py>,
    shape: &[usize],
    numbers: &[f64],
) -> PyResult<Bound<'py, PyAny>> {
    filled(py, shape, |out| {
        out.copy_from_slice(numbers);
        Ok(())
    })
}

/// Rows of three numbers.
pub fn directions<'a>(array: &'a PyReadonlyArrayDyn<'_, f64>, name: &str) -> PyResult<&'a [f64]> {
    match array.shape() {
        [_, 3] => Ok(array.as_slice()?),
        _ => Err(PyValueError::new_err(format!(
            "Expected `{name}` to have shape (N, 3)."
        ))),
    }
}

/// The solid angle that each texel counts with in a sum, parts of texels across a rim included: (H, W) or (F, N, N).
#[pyfunction]
#[pyo3(signature = (projection, shape, /))]
pub fn texel_weights<'py>(
    py: Python<'py>,
    projection: &PyProjection,
    shape: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let shape = size(&projection.0, shape)?;
    filled(py, &shape, |out| weights(&projection.0, &shape, out))
}

/// Which texels hold a value, 1 or 0 each: (H, W) or (F, N, N).
#[pyfunction]
#[pyo3(signature = (projection, shape, /))]
pub fn texels_held<'py>(
    py: Python<'py>,
    projection: &PyProjection,
    shape: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let shape = size(&projection.0, shape)?;
    let array = output::<u8>(py, None, "uint8", &shape)?;
    {
        let mut target = writable(&array)?;
        let out = target.as_slice_mut()?;
        stoppable(py, || rim::held(&projection.0, &shape, out))?;
    }
    finish(array, true)
}

/// Whether all numbers of an array are finite.
#[pyfunction]
#[pyo3(signature = (object, /))]
pub fn all_finite(py: Python<'_>, object: &Bound<'_, PyAny>) -> PyResult<bool> {
    with_image!(image(object, None)?, image => {
        let numbers = image.as_slice()?;
        released(py, || finite::all_finite(numbers))
    })
}

/// The luminance of each texel, whose channels are its last axis and make it with these weights.
#[pyfunction]
#[pyo3(signature = (object, weights, /))]
pub fn luminances<'py>(
    py: Python<'py>,
    object: &Bound<'py, PyAny>,
    weights: PyReadonlyArrayDyn<'py, f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let weights = weights.as_slice()?;
    with_image!(image(object, None)?, image => match image.shape() {
        [texels @ .., channels] if *channels == weights.len() && *channels > 0 => {
            let numbers = image.as_slice()?;
            filled(py, texels, |out| {
                lit::luminances(numbers, weights, out);
                Ok(())
            })
        }
        _ => Err(PyValueError::new_err("Expected a weight for each channel.")),
    })
}

/// ∫ L dω of each channel and, last, of the constant 1: (C + 1,).
#[pyfunction]
#[pyo3(signature = (object, projection, /))]
pub fn integrals<'py>(
    py: Python<'py>,
    object: &Bound<'py, PyAny>,
    projection: &PyProjection,
) -> PyResult<Bound<'py, PyAny>> {
    let map = &projection.0;
    with_image!(image(object, None)?, image => {
        let image = view(map, &image)?;
        filled(py, &[image.channels() + 1], |out| {
            out.copy_from_slice(&integrate::integrals(&image)?);
            Ok(())
        })
    })
}

/// ∫ L dω and ∫ L ω dω of each channel and, last, of the constant 1: (C + 1, 4).
#[pyfunction]
#[pyo3(signature = (object, projection, /))]
pub fn moments<'py>(
    py: Python<'py>,
    object: &Bound<'py, PyAny>,
    projection: &PyProjection,
) -> PyResult<Bound<'py, PyAny>> {
    let map = &projection.0;
    with_image!(image(object, None)?, image => {
        let image = view(map, &image)?;
        filled(py, &[image.channels() + 1, 4], |out| {
            out.copy_from_slice(integrate::moments(&image)?.as_flattened());
            Ok(())
        })
    })
}

/// The light under a lobe about each of (N, 3) unit directions: (N, C).
#[pyfunction]
#[pyo3(signature = (object, projection, normals, name, parameter, /))]
pub fn lobe<'py>(
    py: Python<'py>,
    object: &Bound<'py, PyAny>,
    projection: &PyProjection,
    normals: PyReadonlyArrayDyn<'py, f64>,
    name: &str,
    parameter: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let map = &projection.0;
    let lobe = Lobe::find(name, parameter)?;
    let normals = directions(&normals, "normals")?;
    with_image!(image(object, None)?, image => {
        let image = view(map, &image)?;
        filled(py, &[normals.len() / 3, image.channels()], |out| under(&image, lobe, normals, out))
    })
}

/// How many lookups take as long as making a texel of the source ready.
const READY: f64 = 8.0;

/// The image under a GGX or Charlie lobe, sampled: float32 of shape (*shape, C).
#[pyfunction]
#[pyo3(signature = (object, projection, target, shapes, alphas, name, samples, /))]
#[expect(clippy::too_many_arguments, reason = "one call for a whole chain")]
pub fn prefilter<'py>(
    py: Python<'py>,
    object: &Bound<'py, PyAny>,
    projection: &PyProjection,
    target: &PyProjection,
    shapes: Vec<Bound<'py, PyAny>>,
    alphas: Vec<f64>,
    name: &str,
    samples: usize,
) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let (map, target) = (&projection.0, &target.0);
    let distribution = Distribution::find(name)?;
    let shapes = shapes
        .iter()
        .map(|shape| size(target, shape))
        .collect::<PyResult<Vec<_>>>()?;
    with_image!(image(object, None)?, image => {
        let image = view(map, &image)?;
        // How long each level takes, about, and making the source ready: in lookups.
        let works = shapes.iter().zip(&alphas).map(|(shape, alpha)| {
            let samples = if *alpha > 0.0 { samples } else { 1 };
            (shape.iter().product::<usize>() as f64) * samples as f64
        });
        let ready = READY * image.raster().texels() as f64;
        let all = ready + works.clone().sum::<f64>();
        let mut done = ready / all;
        let source = stoppable(py, || interrupt::part(0.0, done, || Source::new(&image)))?;
        let mut levels = Vec::new();
        for ((shape, alpha), work) in shapes.iter().zip(&alphas).zip(works) {
            let mut whole = shape.clone();
            whole.push(image.channels());
            let array = output::<f32>(py, None, "float32", &whole)?;
            {
                let mut out = writable(&array)?;
                let out = out.as_slice_mut()?;
                let part = [done, done + work / all];
                stoppable(py, || {
                    interrupt::part(part[0], part[1], || {
                        source.filter(target, shape, distribution, *alpha, samples, out)
                    })
                })?;
                done = part[1];
            }
            levels.push(finish(array, true)?);
        }
        Ok(levels)
    })
}

/// The table of split sums over cos θ (columns) and roughness (rows): (N, N, 2), albedo and Fresnel part.
#[pyfunction]
#[pyo3(signature = (name, size, /))]
pub fn dfg<'py>(py: Python<'py>, name: &str, size: usize) -> PyResult<Bound<'py, PyAny>> {
    let distribution = Distribution::find(name)?;
    filled(py, &[size, size, 2], |out| {
        table::fill(distribution, size, out)
    })
}
