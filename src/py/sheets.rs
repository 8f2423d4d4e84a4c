//! Sums over the sphere sheet by sheet: of an image of which only a part is there. `spheremap.dask` asks for them.

use super::images::{image, view, with_image};
use super::light::{directions, filled};
use super::projection::{PyProjection, size};
use super::sh::samples;
use super::stopping::stoppable;
use crate::light::integrate::{add_sheets as add, moments_of_sheet};
use crate::light::lobe::{of_all_sheets, under_sheet};
use crate::light::patches::{Patches, Sheet};
use crate::light::sh::apart::Apart;
use crate::light::sh::{self};
use crate::light::{Lobe, integrate};
use numpy::{PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Where the sheets of an image are stored: (N, 4), the first row, the one after the last, the same of columns. Rows are those of all
/// faces where faces are apart.
#[pyfunction]
#[pyo3(signature = (projection, shape, /))]
pub fn sheets(projection: &PyProjection, shape: &Bound<'_, PyAny>) -> PyResult<Vec<[usize; 4]>> {
    let shape = size(&projection.0, shape)?;
    let patches = Patches::of_parts(&projection.0, &shape)?;
    let sheets = patches.sheets();
    let place = |sheet: &Sheet| {
        let [rows, columns] = patches.stored(sheet);
        [rows.start, rows.end, columns.start, columns.end]
    };
    Ok(sheets.iter().map(place).collect())
}

/// One of them, by its number.
fn numbered(patches: &Patches<'_>, number: usize) -> PyResult<Sheet> {
    let found = patches.sheets().into_iter().nth(number);
    found.ok_or_else(|| PyValueError::new_err(format!("There is no sheet {number}.")))
}

/// The integrals of a sheet for each channel and, last, of the constant 1, each with its three moments of direction, if they are asked
/// for: (C + 1, 1) or (C + 1, 4).
#[pyfunction]
#[pyo3(signature = (object, projection, number, with_directions, /))]
pub fn moments_of<'py>(
    py: Python<'py>,
    object: &Bound<'py, PyAny>,
    projection: &PyProjection,
    number: usize,
    with_directions: bool,
) -> PyResult<Bound<'py, PyAny>> {
    with_image!(image(object, None)?, image => {
        let image = view(&projection.0, &image)?;
        let patches = Patches::of_parts(image.map(), image.shape())?;
        let sheet = numbered(&patches, number)?;
        let rows = image.channels() + 1;
        filled(py, &[rows, if with_directions { 4 } else { 1 }], |out| {
            if with_directions {
                let found: Vec<integrate::Moments> = moments_of_sheet(&image, &patches, &sheet)?;
                out.copy_from_slice(found.as_flattened());
            } else {
                let found: Vec<[f64; 1]> = moments_of_sheet(&image, &patches, &sheet)?;
                out.copy_from_slice(found.as_flattened());
            }
            Ok(())
        })
    })
}

/// The sum of what was found of each sheet, (N, K), in the order in which the sums of a whole image are: (K,).
#[pyfunction]
#[pyo3(signature = (parts, /))]
pub fn add_sheets<'py>(
    py: Python<'py>,
    parts: PyReadonlyArrayDyn<'py, f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let &[_, per] = parts.shape() else {
        return Err(PyValueError::new_err(
            "Expected `parts` to have shape (N, K).",
        ));
    };
    let found = add(parts.as_slice()?, per);
    filled(py, &[found.len()], |out| {
        out.copy_from_slice(&found);
        Ok(())
    })
}

/// The sums of a sheet under a lobe about each of (N, 3) unit directions, those of the constant 1 last: (N, C + 1).
#[pyfunction]
#[pyo3(signature = (object, projection, number, normals, name, parameter, /))]
pub fn lobe_of<'py>(
    py: Python<'py>,
    object: &Bound<'py, PyAny>,
    projection: &PyProjection,
    number: usize,
    normals: PyReadonlyArrayDyn<'py, f64>,
    name: &str,
    parameter: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let lobe = Lobe::find(name, parameter)?;
    let normals = directions(&normals, "normals")?;
    with_image!(image(object, None)?, image => {
        let image = view(&projection.0, &image)?;
        let patches = Patches::of_parts(image.map(), image.shape())?;
        let sheet = numbered(&patches, number)?;
        filled(py, &[normals.len() / 3, image.channels() + 1], |out| {
            under_sheet(&image, &patches, &sheet, lobe, normals, out)
        })
    })
}

/// The light under a lobe, from the sums of all sheets, (N, C + 1): (N, C).
#[pyfunction]
#[pyo3(signature = (sums, projection, name, parameter, /))]
pub fn lobe_from<'py>(
    py: Python<'py>,
    sums: PyReadonlyArrayDyn<'py, f64>,
    projection: &PyProjection,
    name: &str,
    parameter: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let lobe = Lobe::find(name, parameter)?;
    let &[n, rows] = sums.shape() else {
        return Err(PyValueError::new_err(
            "Expected `sums` to have shape (N, C + 1).",
        ));
    };
    let channels = rows.saturating_sub(1);
    let numbers = sums.as_slice()?;
    filled(py, &[n, channels], |out| {
        of_all_sheets(&projection.0, lobe, numbers, channels, out)
    })
}

/// What a sheet gives for the spherical harmonics of an image: (K,).
#[pyfunction]
#[pyo3(signature = (object, projection, number, order, points, /))]
pub fn sh_of<'py>(
    py: Python<'py>,
    object: &Bound<'py, PyAny>,
    projection: &PyProjection,
    number: usize,
    order: usize,
    points: bool,
) -> PyResult<Bound<'py, PyAny>> {
    with_image!(image(object, None)?, image => {
        let image = view(&projection.0, &image)?;
        let apart = Apart::new(image.map(), image.shape(), order, samples(points))?;
        let sheet = numbered(apart.patches(), number)?;
        let found = stoppable(py, || apart.of_sheet(&image, &sheet))?;
        filled(py, &[found.len()], |out| {
            out.copy_from_slice(&found);
            Ok(())
        })
    })
}

/// The coefficients of an image, from what all of its sheets give, in their order: ((order + 1)², C).
#[pyfunction]
#[pyo3(signature = (parts, projection, shape, channels, order, points, /))]
pub fn sh_from<'py>(
    py: Python<'py>,
    parts: PyReadonlyArrayDyn<'py, f64>,
    projection: &PyProjection,
    shape: &Bound<'py, PyAny>,
    channels: usize,
    order: usize,
    points: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let shape = size(&projection.0, shape)?;
    let apart = Apart::new(&projection.0, &shape, order, samples(points))?;
    let numbers = parts.as_slice()?;
    let found = stoppable(py, || apart.project(numbers, channels))?;
    filled(py, &[sh::count(order), channels], |out| {
        out.copy_from_slice(&found);
        Ok(())
    })
}
