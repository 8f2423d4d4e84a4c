//! Spherical harmonics as functions of the module: float64 arrays in, float64 arrays out. `spheremap.sh` checks
//! numbers and restores shapes.

use super::images::{image, view, with_image};
use super::light::{directions, filled, filled_with};
use super::projection::PyProjection;
use super::stopping::stoppable;
use crate::light::sh;
use crate::light::sh::conventions::{self, CONVENTIONS, Storage};
use crate::light::sh::{lobes, windows};
use numpy::{PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Coefficients of an image in the orthonormal real basis: ((order + 1)², C).
#[pyfunction]
#[pyo3(signature = (object, projection, order, points, /))]
pub fn sh_project<'py>(
    py: Python<'py>,
    object: &Bound<'py, PyAny>,
    projection: &PyProjection,
    order: usize,
    points: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let map = &projection.0;
    with_image!(image(object, None)?, image => {
        let image = view(map, &image)?;
        let found = stoppable(py, || sh::project(&image, order, samples(points)))?;
        filled_with(py, &[sh::count(order), image.channels()], &found)
    })
}

/// What flows back to the texels of an image of a shape, from ((order + 1)², C) coefficients: (texels, C).
#[pyfunction]
#[pyo3(signature = (array, projection, shape, points, /))]
pub fn sh_project_adjoint<'py>(
    py: Python<'py>,
    array: PyReadonlyArrayDyn<'py, f64>,
    projection: &PyProjection,
    shape: Vec<usize>,
    points: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let (rows, channels, _) = coefficients(&array)?;
    let texels = shape.iter().product::<usize>();
    filled(py, &[texels, channels], |out| {
        let found = sh::project_adjoint(&projection.0, &shape, rows, channels, samples(points))?;
        out.copy_from_slice(&found);
        Ok(())
    })
}

/// What texels are.
pub fn samples(points: bool) -> sh::Samples {
    if points {
        sh::Samples::Points
    } else {
        sh::Samples::Means
    }
}

/// An order from the number of coefficients.
fn coefficients<'a>(array: &'a PyReadonlyArrayDyn<'_, f64>) -> PyResult<(&'a [f64], usize, usize)> {
    if let &[rows, channels] = array.shape()
        && rows > 0
        && channels > 0
        && rows.isqrt().pow(2) == rows
    {
        return Ok((array.as_slice()?, channels, rows.isqrt() - 1));
    }
    Err(PyValueError::new_err(
        "Expected `coefficients` to have shape ((order + 1)², C).",
    ))
}

/// The function that ((order + 1)², C) coefficients describe, at (N, 3) directions: (N, C).
#[pyfunction]
#[pyo3(signature = (array, points, /))]
pub fn sh_evaluate<'py>(
    py: Python<'py>,
    array: PyReadonlyArrayDyn<'py, f64>,
    points: PyReadonlyArrayDyn<'py, f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let (rows, channels, _) = coefficients(&array)?;
    let points = directions(&points, "directions")?;
    filled(py, &[points.len() / 3, channels], |out| {
        sh::evaluate(rows, channels, points, out)
    })
}

/// The function of ((order + 1)², C) coefficients as source text of a language.
#[pyfunction]
#[pyo3(signature = (array, language, name, double, /))]
pub fn sh_code(
    array: PyReadonlyArrayDyn<'_, f64>,
    language: &str,
    name: &str,
    double: bool,
) -> PyResult<String> {
    let (rows, channels, _) = coefficients(&array)?;
    Ok(sh::code(rows, channels, language, name, double)?)
}

/// Coefficients of the function turned by a (3, 3) orthogonal matrix.
#[pyfunction]
#[pyo3(signature = (array, matrix, /))]
pub fn sh_rotate<'py>(
    py: Python<'py>,
    array: PyReadonlyArrayDyn<'py, f64>,
    matrix: PyReadonlyArrayDyn<'py, f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let (rows, channels, order) = coefficients(&array)?;
    let matrix: &[[f64; 3]; 3] = match directions(&matrix, "matrix")?.as_chunks::<3>().0 {
        rows if rows.len() == 3 => rows
            .try_into()
            .map_err(|_| PyValueError::new_err("Expected a (3, 3) matrix."))?,
        _ => return Err(PyValueError::new_err("Expected a (3, 3) matrix.")),
    };
    filled(py, &[rows.len() / channels, channels], |out| {
        out.copy_from_slice(&sh::rotate(rows, channels, order, matrix)?);
        Ok(())
    })
}

/// Coefficients with those of degree l multiplied by the l-th factor.
#[pyfunction]
#[pyo3(signature = (array, factors, /))]
pub fn sh_scale_degrees<'py>(
    py: Python<'py>,
    array: PyReadonlyArrayDyn<'py, f64>,
    factors: PyReadonlyArrayDyn<'py, f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let (rows, channels, order) = coefficients(&array)?;
    let factors = factors.as_slice()?;
    if factors.len() != order + 1 {
        return Err(PyValueError::new_err(format!(
            "Expected {} factors, got {}.",
            order + 1,
            factors.len()
        )));
    }
    filled(py, &[rows.len() / channels, channels], |out| {
        out.copy_from_slice(&sh::scale_degrees(rows, channels, factors)?);
        Ok(())
    })
}

/// By what the lobe of this name multiplies degrees 0 to an order.
#[pyfunction]
#[pyo3(signature = (name, parameter, order, /))]
pub fn sh_lobe<'py>(
    py: Python<'py>,
    name: &str,
    parameter: f64,
    order: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let factors = lobes::find(name)?.factors(parameter, order)?;
    filled_with(py, &[factors.len()], &factors)
}

/// By what the window of this name multiplies degrees 0 to an order.
#[pyfunction]
#[pyo3(signature = (name, width, order, /))]
pub fn sh_window<'py>(
    py: Python<'py>,
    name: &str,
    width: Option<f64>,
    order: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let factors = windows::find(name)?.factors(width, order)?;
    filled_with(py, &[factors.len()], &factors)
}

/// Name, note and source of each convention of coefficients.
#[pyfunction]
pub fn sh_convention_table() -> Vec<(&'static str, &'static str, &'static str)> {
    let rows = CONVENTIONS.iter();
    rows.map(|row| (row.name, row.note, row.source)).collect()
}

/// The array in which a convention has its coefficients: "rows", "squares" or "complex".
#[pyfunction]
#[pyo3(signature = (name, /))]
pub fn sh_storage(name: &str) -> PyResult<&'static str> {
    Ok(match conventions::find(name)?.storage {
        Storage::Rows => "rows",
        Storage::Squares => "squares",
        Storage::Complex => "complex",
    })
}

/// (N, C) coefficients of one convention as (M, C) ones of another; complex ones are (N, C, 2).
#[pyfunction]
#[pyo3(signature = (array, src, dst, /))]
pub fn sh_convert<'py>(
    py: Python<'py>,
    array: PyReadonlyArrayDyn<'py, f64>,
    src: &str,
    dst: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let (src, dst) = (conventions::find(src)?, conventions::find(dst)?);
    let channels = array.shape().get(1).copied().unwrap_or(1);
    let found = conventions::convert(array.as_slice()?, channels, src, dst)?;
    let mut shape = vec![found.len() / channels, channels];
    if dst.storage == Storage::Complex {
        shape = vec![found.len() / (2 * channels), channels, 2];
    }
    filled(py, &shape, |out| {
        out.copy_from_slice(&found);
        Ok(())
    })
}
