//! HEALPix pixel numbers: integers in and out.

use super::arrays::fits;
use super::arrays::{
    Points, contiguous, disjoint, finish, leading, output, points, reals, run, with_reals, writable,
};
use super::helpers::Helper;
use super::stopping::stoppable;
use crate::healpix::{Angles, Arrangement, Order, Pixels};
use crate::healpix::{arrange_then, unseen_to_nan_f32, unseen_to_nan_f64};
use numpy::{Element, PyArrayDyn, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

fn pixels(nside: i64, nest: bool) -> PyResult<Pixels> {
    let order = if nest { Order::Nested } else { Order::Ring };
    Ok(Pixels::new(nside, order)?)
}

fn angles(lonlat: bool) -> Angles {
    if lonlat {
        Angles::LonLat
    } else {
        Angles::Colatitude
    }
}

/// Pixels of directions: (..., 3) -> (...).
#[pyfunction]
#[pyo3(signature = (nside, directions, /, *, nest=false, out=None))]
pub fn healpix_vec2pix<'py>(
    py: Python<'py>,
    nside: i64,
    directions: &Bound<'py, PyAny>,
    nest: bool,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let pixels = pixels(nside, nest)?;
    let reals = reals(directions, "directions", out)?;
    with_reals!(&reals, d => {
        let work = |d: &[_], out: &mut [i64]| fits(pixels.of_directions(d, out));
        points(py, d, "directions", 3, out, "int64", &[], &work)
    })
}

/// Centers of pixels: (...) -> (..., 3).
#[pyfunction]
#[pyo3(signature = (nside, pixels, /, *, nest=false, out=None))]
pub fn healpix_pix2vec<'py>(
    py: Python<'py>,
    nside: i64,
    pixels: &Bound<'py, PyAny>,
    nest: bool,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let division = self::pixels(nside, nest)?;
    each(py, pixels, out, "float64", &[3], |pixels, out| {
        fits(division.directions(pixels, out));
    })
}

/// Pixels of pairs of angles: (..., 2) -> (...).
#[pyfunction]
#[pyo3(signature = (nside, angles, /, *, nest=false, lonlat=false, out=None))]
pub fn healpix_ang2pix<'py>(
    py: Python<'py>,
    nside: i64,
    angles: PyReadonlyArrayDyn<'py, f64>,
    nest: bool,
    lonlat: bool,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let pixels = pixels(nside, nest)?;
    let kind = self::angles(lonlat);
    let work = |angles: &[f64], out: &mut [i64]| fits(pixels.of_angles(kind, angles, out));
    let angles = Points::Plain(angles);
    points(py, &angles, "angles", 2, out, "int64", &[], &work)
}

/// Pairs of angles of the centers of pixels: (...) -> (..., 2).
#[pyfunction]
#[pyo3(signature = (nside, pixels, /, *, nest=false, lonlat=false))]
pub fn healpix_pix2ang<'py>(
    py: Python<'py>,
    nside: i64,
    pixels: &Bound<'py, PyAny>,
    nest: bool,
    lonlat: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let division = self::pixels(nside, nest)?;
    let kind = angles(lonlat);
    each(py, pixels, None, "float64", &[2], |pixels, out| {
        fits(division.angles(kind, pixels, out));
    })
}

/// Numbers in the other order than `nest`: (...) -> (...).
#[pyfunction]
#[pyo3(signature = (nside, pixels, /, *, nest, out=None))]
pub fn healpix_reorder<'py>(
    py: Python<'py>,
    nside: i64,
    pixels: &Bound<'py, PyAny>,
    nest: bool,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    // Either way one of the two is nested.
    self::pixels(nside, true)?;
    let division = self::pixels(nside, nest)?;
    each(py, pixels, out, "int64", &[], |pixels, out| {
        fits(division.reordered(pixels, out));
    })
}

/// The eight pixels around each: (...) -> (..., 8).
#[pyfunction]
#[pyo3(signature = (nside, pixels, /, *, nest=false))]
pub fn healpix_neighbors<'py>(
    py: Python<'py>,
    nside: i64,
    pixels: &Bound<'py, PyAny>,
    nest: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let division = self::pixels(nside, nest)?;
    each(py, pixels, None, "int64", &[8], |pixels, out| {
        fits(division.neighbors(pixels, out));
    })
}

/// The four pixels around places given by pairs of angles, and their weights: (..., 2) -> (..., 4) twice.
#[pyfunction]
#[pyo3(signature = (nside, angles, /, *, nest=false, lonlat=false))]
pub fn healpix_interpolation<'py>(
    py: Python<'py>,
    nside: i64,
    angles: PyReadonlyArrayDyn<'py, f64>,
    nest: bool,
    lonlat: bool,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    let division = self::pixels(nside, nest)?;
    let kind = self::angles(lonlat);
    let shape = [leading(angles.shape(), 2, "angles")?, &[4]].concat();
    let pixels = output::<i64>(py, None, "int64", &shape)?;
    let weights = output::<f64>(py, None, "float64", &shape)?;
    {
        let (mut into, mut by) = (writable(&pixels)?, writable(&weights)?);
        let (into, by) = (into.as_slice_mut()?, by.as_slice_mut()?);
        let angles = angles.as_slice()?;
        run(py, angles.len(), || {
            fits(division.interpolation(kind, angles, into, by));
        })?;
    }
    Ok((finish(pixels, false)?, finish(weights, false)?))
}

/// Numbers in a row from each of some, so many: the runs one after the other.
#[pyfunction]
#[pyo3(signature = (starts, lengths, /))]
pub fn healpix_runs<'py>(
    py: Python<'py>,
    starts: PyReadonlyArrayDyn<'py, i64>,
    lengths: PyReadonlyArrayDyn<'py, i64>,
) -> PyResult<Bound<'py, PyAny>> {
    let (starts, lengths) = (starts.as_slice()?, lengths.as_slice()?);
    let runs = || {
        starts
            .iter()
            .zip(lengths.iter().map(|&length| length.max(0) as usize))
    };
    let count = runs().map(|(_, length)| length).sum();
    let numbers = output::<i64>(py, None, "int64", &[count])?;
    {
        let mut target = writable(&numbers)?;
        let mut target = target.as_slice_mut()?;
        run(py, count, || {
            for (&start, length) in runs() {
                let (here, rest) = target.split_at_mut(length);
                for (k, number) in here.iter_mut().enumerate() {
                    *number = start + k as i64;
                }
                target = rest;
            }
        })?;
    }
    finish(numbers, false)
}

/// Copies a whole map, as bytes, from one arrangement into another: "ring", "nested" or "faces". `unseen` is the size of
/// floats among which healpy's mark becomes NaN, or 0.
#[pyfunction]
#[pyo3(signature = (nside, bytes, source, was, target, becomes, unseen, /))]
#[expect(
    clippy::too_many_arguments,
    reason = "what a call needs, each independent"
)]
pub fn healpix_arrange<'py>(
    py: Python<'py>,
    nside: i64,
    bytes: usize,
    source: PyReadonlyArrayDyn<'py, u8>,
    was: &str,
    target: &Bound<'py, PyArrayDyn<u8>>,
    becomes: &str,
    unseen: usize,
) -> PyResult<()> {
    let (was, becomes) = (arrangement(was)?, arrangement(becomes)?);
    let mut target = writable(target)?;
    let (source, target) = (source.as_slice()?, target.as_slice_mut()?);
    disjoint(source, target)?;
    let (source, target) = ((was, source), (becomes, target));
    stoppable(py, || match unseen {
        4 => arrange_then(nside, bytes, source, target, &unseen_to_nan_f32),
        8 => arrange_then(nside, bytes, source, target, &unseen_to_nan_f64),
        _ => arrange_then(nside, bytes, source, target, &|_| ()),
    })
}

fn arrangement(name: &str) -> PyResult<Arrangement> {
    match name {
        "ring" => Ok(Arrangement::Ring),
        "nested" => Ok(Arrangement::Nested),
        "faces" => Ok(Arrangement::Faces),
        _ => Err(PyValueError::new_err(format!("no arrangement is '{name}'"))),
    }
}

/// Takes `work` over pixel numbers.
fn each<'py, B: Element>(
    py: Python<'py>,
    pixels: &Bound<'py, PyAny>,
    out: Option<&Bound<'py, PyAny>>,
    dtype: &str,
    tail: &[usize],
    work: impl Fn(&[i64], &mut [B]) + Send + Sync,
) -> PyResult<Bound<'py, PyAny>> {
    let input = match contiguous::<i64>(pixels)? {
        Some(array) => array,
        None => {
            let array = Helper::AsIntegers.get(py)?.call1((pixels, "pixels", out))?;
            contiguous::<i64>(&array)?
                .ok_or_else(|| PyTypeError::new_err("Expected contiguous integers."))?
        }
    };
    let shape = [input.shape(), tail].concat();
    let array = output::<B>(py, out, dtype, &shape)?;
    {
        let mut target = writable(&array)?;
        let (input, target) = (input.as_slice()?, target.as_slice_mut()?);
        disjoint(input, target)?;
        run(py, input.len(), || work(input, target))?;
    }
    finish(array, out.is_some())
}
