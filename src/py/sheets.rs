//! Sums over the sphere sheet by sheet: of an image of which only a part is there. `spheremap.dask` asks for them.

use super::images::{image, view, with_image};
use super::light::{directions, filled, filled_with};
use super::lights::{PySun, sun_as_tuple};
use super::projection::{PyProjection, size};
use super::sh::samples;
use super::stopping::{released, stoppable};
use crate::error::expect_length;
use crate::image::raster::Raster;
use crate::light::integrate::{add_sheets as add, moments_of_sheet};
use crate::light::lit::{Cap, Lit, direction_of};
use crate::light::lobe::{of_all_sheets, under_sheet};
use crate::light::patches::{Patches, Sheet};
use crate::light::sh::apart::Apart;
use crate::light::survey::Survey;
use crate::light::{Lobe, integrate, sh, sun};
use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArrayDyn, PyUntypedArrayMethods};
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
    filled_with(py, &[found.len()], &found)
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
        filled_with(py, &[found.len()], &found)
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
    filled_with(py, &[sh::count(order), channels], &found)
}

/// What a sheet tells of its light: (8 + C,).
#[pyfunction]
#[pyo3(signature = (object, projection, number, luminance, /))]
pub fn survey_of<'py>(
    py: Python<'py>,
    object: &Bound<'py, PyAny>,
    projection: &PyProjection,
    number: usize,
    luminance: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let luminance = luminance.as_slice()?;
    with_image!(image(object, None)?, image => {
        let image = view(&projection.0, &image)?;
        let patches = Patches::of_parts(image.map(), image.shape())?;
        let sheet = numbered(&patches, number)?;
        expect_length("luminance", luminance.len(), image.channels())?;
        let survey = released(py, || {
            Survey::of_sheet(&image, luminance, &patches, &sheet)
        })?;
        let numbers = survey.numbers();
        filled_with(py, &[numbers.len()], &numbers)
    })
}

/// What all sheets, (N, 8 + C), tell of the light of an image: solid angle, integral, mean luminance, peak and where it is, the darkest
/// luminance above 0, how many texels have a number below 0, and how far from the peak a sun may be, if not anywhere.
#[pyfunction]
#[pyo3(signature = (parts, projection, shape, /))]
#[expect(clippy::type_complexity, reason = "eight results")]
pub fn energy_from<'py>(
    py: Python<'py>,
    parts: PyReadonlyArrayDyn<'py, f64>,
    projection: &PyProjection,
    shape: &Bound<'py, PyAny>,
) -> PyResult<(
    f64,
    Bound<'py, PyArray1<f64>>,
    f64,
    f64,
    [f64; 3],
    f64,
    usize,
    Option<f64>,
)> {
    let shape = size(&projection.0, shape)?;
    let per = match parts.shape() {
        &[_, per] if per > 8 => per,
        _ => {
            return Err(PyValueError::new_err(
                "Expected `parts` to have shape (N, 8 + C).",
            ));
        }
    };
    let sheets = parts
        .as_slice()?
        .chunks_exact(per)
        .filter_map(Survey::of_numbers);
    let survey = Survey::of_sheets(sheets, per - 8);
    let (peak, place) = survey
        .peak
        .ok_or_else(|| PyValueError::new_err("The image holds no sphere."))?;
    let raster = Raster::new(&projection.0, &shape)?;
    Ok((
        survey.solid_angle,
        PyArray1::from_vec(py, survey.integral),
        survey.luminance / survey.solid_angle,
        peak,
        direction_of(&projection.0, &raster, place),
        survey.darkest,
        survey.negative,
        sun::around(survey.widest),
    ))
}

/// The texels of a sheet within an angle of a direction, or all, or their means over blocks: (N, 6 + C), index, direction, solid
/// angle, luminance, light.
#[pyfunction]
#[pyo3(signature = (object, projection, number, luminance, direction, angle, block, /))]
#[expect(clippy::too_many_arguments, reason = "a function of Python")]
pub fn lit_of<'py>(
    py: Python<'py>,
    object: &Bound<'py, PyAny>,
    projection: &PyProjection,
    number: usize,
    luminance: PyReadonlyArray1<'py, f64>,
    direction: [f64; 3],
    angle: Option<f64>,
    block: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let luminance = luminance.as_slice()?;
    with_image!(image(object, None)?, image => {
        let image = view(&projection.0, &image)?;
        let patches = Patches::of_parts(image.map(), image.shape())?;
        let sheet = numbered(&patches, number)?;
        expect_length("luminance", luminance.len(), image.channels())?;
        let cap = angle.map(|angle| Cap::new(direction, angle));
        let lit = released(py, || {
            Lit::of_sheet(&image, luminance, &patches, &sheet, cap, block)
        })?;
        let numbers = lit.numbers();
        filled_with(py, &[lit.index.len(), 6 + image.channels()], &numbers)
    })
}

/// The sun among such texels of all sheets, if there is one.
#[pyfunction]
#[pyo3(signature = (texels, /))]
pub fn sun_from<'py>(
    py: Python<'py>,
    texels: PyReadonlyArrayDyn<'py, f64>,
) -> PyResult<Option<PySun<'py>>> {
    let &[_, per] = texels.shape() else {
        return Err(PyValueError::new_err(
            "Expected `texels` to have shape (N, 6 + C).",
        ));
    };
    let lit = Lit::of_numbers(texels.as_slice()?, per.saturating_sub(6));
    Ok(sun::among(&lit).map(|sun| sun_as_tuple(py, sun)))
}
