//! Lights and suns as functions of the module: images in, arrays and numbers out. `spheremap._lights` checks images and
//! makes its own types of what comes back.

use super::arrays::{finish, output, writable};
use super::images::{PyTexel, image, view, with_image};
use super::light::filled;
use super::projection::PyProjection;
use super::stopping::stoppable;
use crate::light::energy as report;
use crate::light::lights::{self as cut, Method};
use crate::light::sun::{self as suns, Sun};
use numpy::{PyArray1, PyReadonlyArray1, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Direction, solid angle, irradiance, surround and reach.
pub type PySun<'py> = (
    [f64; 3],
    f64,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    f64,
);

/// A sun as Python has it.
pub fn sun_as_tuple(py: Python<'_>, sun: Sun) -> PySun<'_> {
    (
        sun.direction,
        sun.solid_angle,
        PyArray1::from_vec(py, sun.irradiance),
        PyArray1::from_vec(py, sun.surround),
        sun.reach,
    )
}

/// At most `n` directional lights, brightest first: (N, 3) directions, (N, C) irradiances and (N,) solid angles.
#[pyfunction]
#[pyo3(signature = (object, projection, luminance, n, method, /))]
pub fn lights<'py>(
    py: Python<'py>,
    object: &Bound<'py, PyAny>,
    projection: &PyProjection,
    luminance: PyReadonlyArray1<'py, f64>,
    n: usize,
    method: &str,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    let method = Method::find(method)?;
    let weights = luminance.as_slice()?;
    let (channels, found) = with_image!(image(object, None)?, image => {
        let image = view(&projection.0, &image)?;
        (image.channels(), stoppable(py, || cut::lights(&image, weights, n, method))?)
    });
    let directions = filled(py, &[found.len(), 3], |out| {
        for (out, light) in out.chunks_mut(3).zip(&found) {
            out.copy_from_slice(&light.direction);
        }
        Ok(())
    })?;
    let irradiance = filled(py, &[found.len(), channels], |out| {
        for (out, light) in out.chunks_mut(channels).zip(&found) {
            out.copy_from_slice(&light.irradiance);
        }
        Ok(())
    })?;
    let solid_angle = filled(py, &[found.len()], |out| {
        for (out, light) in out.iter_mut().zip(&found) {
            *out = light.solid_angle;
        }
        Ok(())
    })?;
    Ok((directions, irradiance, solid_angle))
}

/// The sun of an image, if it has one.
#[pyfunction]
#[pyo3(signature = (object, projection, luminance, /))]
pub fn sun<'py>(
    py: Python<'py>,
    object: &Bound<'py, PyAny>,
    projection: &PyProjection,
    luminance: PyReadonlyArray1<'py, f64>,
) -> PyResult<Option<PySun<'py>>> {
    let weights = luminance.as_slice()?;
    let found = with_image!(image(object, None)?, image => {
        let image = view(&projection.0, &image)?;
        stoppable(py, || suns::find(&image, weights))?
    });
    Ok(found.map(|sun| sun_as_tuple(py, sun)))
}

/// A copy of an image in which its sun is painted over, and the sun.
#[pyfunction]
#[pyo3(signature = (object, projection, luminance, /))]
pub fn remove_sun<'py>(
    py: Python<'py>,
    object: &Bound<'py, PyAny>,
    projection: &PyProjection,
    luminance: PyReadonlyArray1<'py, f64>,
) -> PyResult<(Bound<'py, PyAny>, Option<PySun<'py>>)> {
    let weights = luminance.as_slice()?;
    with_image!(image(object, None)?, image => {
        let view = view(&projection.0, &image)?;
        let mut found = None;
        let array = changed(py, image.shape(), |out| {
            found = suns::remove(&view, weights, out)?;
            Ok(())
        })?;
        Ok((array, found.map(|sun| sun_as_tuple(py, sun))))
    })
}

/// A copy of an image with a sun added: its direction, solid angle and irradiance.
#[pyfunction]
#[pyo3(signature = (object, projection, direction, solid_angle, irradiance, /))]
pub fn add_sun<'py>(
    py: Python<'py>,
    object: &Bound<'py, PyAny>,
    projection: &PyProjection,
    direction: [f64; 3],
    solid_angle: f64,
    irradiance: Vec<f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let sun = Sun {
        direction,
        solid_angle,
        surround: vec![0.0; irradiance.len()],
        irradiance,
        reach: 0.0,
    };
    with_image!(image(object, None)?, image => {
        let view = view(&projection.0, &image)?;
        changed(py, image.shape(), |out| suns::add(&view, &sun, out))
    })
}

/// An image of this shape that `work` fills.
fn changed<'py, T: PyTexel>(
    py: Python<'py>,
    shape: &[usize],
    work: impl FnOnce(&mut [T]) -> Result<(), crate::error::Error> + Send,
) -> PyResult<Bound<'py, PyAny>> {
    let array = output::<T>(py, None, T::NAME, shape)?;
    {
        let mut target = writable(&array)?;
        let out = target.as_slice_mut()?;
        stoppable(py, || work(out))?;
    }
    finish(array, true)
}

/// The light of an image: solid angle, integral, mean luminance, peak and where it is, the darkest luminance above 0, how
/// many texels have a number below 0, and the sun.
#[pyfunction]
#[pyo3(signature = (object, projection, luminance, /))]
#[expect(clippy::type_complexity, reason = "eight results")]
pub fn energy<'py>(
    py: Python<'py>,
    object: &Bound<'py, PyAny>,
    projection: &PyProjection,
    luminance: PyReadonlyArray1<'py, f64>,
) -> PyResult<(
    f64,
    Bound<'py, PyArray1<f64>>,
    f64,
    f64,
    [f64; 3],
    f64,
    usize,
    Option<PySun<'py>>,
)> {
    let weights = luminance.as_slice()?;
    let found = with_image!(image(object, None)?, image => {
        let image = view(&projection.0, &image)?;
        stoppable(py, || report(&image, weights))?
    });
    let found = found.ok_or_else(|| PyValueError::new_err("The image holds no sphere."))?;
    Ok((
        found.solid_angle,
        PyArray1::from_vec(py, found.integral),
        found.luminance,
        found.peak,
        found.peak_direction,
        found.darkest,
        found.negative,
        found.sun.map(|sun| sun_as_tuple(py, sun)),
    ))
}
