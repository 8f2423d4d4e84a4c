//! Images as numpy arrays: texel types, shapes with channels, fill values.

use super::arrays::{
    Reals, contiguous, disjoint, finish, leading, output, reals, with_reals, writable,
};
use super::helpers::Helper;
use super::stopping::stoppable;
use crate::image::ImageView;
use crate::image::raster::tuple;
use crate::image::texel::Texel;
use crate::kernel::memory::expect_room;
use crate::map::Map;
use crate::resample;
use crate::resample::Sampler;
use crate::resample::{Fill, Options};
use half::f16;
use numpy::{Element, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use std::sync::OnceLock;

/// A texel type that numpy arrays hold.
pub trait PyTexel: Texel + Element {}
impl<T: Texel + Element> PyTexel for T {}

/// An image of any of them.
pub enum Image<'py> {
    U8(PyReadonlyArrayDyn<'py, u8>),
    U16(PyReadonlyArrayDyn<'py, u16>),
    F16(PyReadonlyArrayDyn<'py, f16>),
    F32(PyReadonlyArrayDyn<'py, f32>),
    F64(PyReadonlyArrayDyn<'py, f64>),
}

/// Runs the body with the array inside, whichever texels it has.
macro_rules! with_image {
    ($image:expr, $array:ident => $body:expr) => {
        match $image {
            $crate::py::images::Image::U8($array) => $body,
            $crate::py::images::Image::U16($array) => $body,
            $crate::py::images::Image::F16($array) => $body,
            $crate::py::images::Image::F32($array) => $body,
            $crate::py::images::Image::F64($array) => $body,
        }
    };
}
pub(crate) use with_image;

fn as_it_is<'py>(object: &Bound<'py, PyAny>) -> PyResult<Option<Image<'py>>> {
    Ok(if let Some(a) = contiguous(object)? {
        Some(Image::F32(a))
    } else if let Some(a) = contiguous(object)? {
        Some(Image::U8(a))
    } else if let Some(a) = contiguous(object)? {
        Some(Image::F16(a))
    } else if let Some(a) = contiguous(object)? {
        Some(Image::U16(a))
    } else {
        contiguous(object)?.map(Image::F64)
    })
}

/// `object` as an image. One that has to be converted must not overlap `out`.
pub fn image<'py>(
    object: &Bound<'py, PyAny>,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Image<'py>> {
    if let Some(image) = as_it_is(object)? {
        return Ok(image);
    }
    let converted = Helper::AsImage.get(object.py())?.call1((object, out))?;
    as_it_is(&converted)?
        .ok_or_else(|| PyTypeError::new_err("Expected an image of a supported dtype."))
}

/// An image's shape without channels, how many channels, and the shape of one of its texels.
pub fn split<'a>(map: &Map, shape: &'a [usize]) -> PyResult<(&'a [usize], usize, &'a [usize])> {
    let dimensions = if map.face_layout().is_atlas { 2 } else { 3 };
    if shape.len() != dimensions && shape.len() != dimensions + 1 {
        let pattern = if dimensions == 2 {
            "(H, W) or (H, W, C)"
        } else {
            "(F, N, N) or (F, N, N, C)"
        };
        return Err(PyValueError::new_err(format!(
            "Expected an image of projection '{}' to have shape {pattern}, got {}.",
            map.info().name,
            tuple(shape)
        )));
    }
    let (image, texel) = shape.split_at(dimensions);
    let channels = texel.first().copied().unwrap_or(1);
    if channels == 0 {
        return Err(PyValueError::new_err(
            "Expected an image with at least one channel, got 0.",
        ));
    }
    Ok((image, channels, texel))
}

/// An array as an image of a map.
pub fn view<'a, T: PyTexel>(
    map: &'a Map,
    image: &'a PyReadonlyArrayDyn<'_, T>,
) -> PyResult<ImageView<'a, T>> {
    let (shape, channels, _) = split(map, image.shape())?;
    Ok(ImageView::new(map, shape, channels, image.as_slice()?)?)
}

/// The value that a caller gave for where there is none: a number or one number a channel.
pub fn fill(fill: Option<&Bound<'_, PyAny>>) -> PyResult<Fill> {
    let Some(fill) = fill else {
        return Ok(Fill::Nothing);
    };
    if let Ok(value) = fill.extract::<f64>() {
        return Ok(value.into());
    }
    // Whoever reads a sequence makes room for all that it says it holds.
    expect_room::<f64>(fill.len().unwrap_or(0))?;
    let values = fill.extract::<Vec<f64>>().map_err(|_| {
        PyTypeError::new_err("Expected `fill` to be a number or one number a channel.")
    })?;
    Ok(values.into())
}

/// The channel of opacity among those of an image of this shape, counted from the last one where it is negative.
pub fn channel(alpha: Option<i64>, shape: &[usize], channels: usize) -> PyResult<Option<usize>> {
    let Some(alpha) = alpha else {
        return Ok(None);
    };
    let count = channels as i64;
    if channels < 2 || !(-count..count).contains(&alpha) {
        return Err(PyValueError::new_err(format!(
            "Expected `alpha` to be the number of one of at least 2 channels, got {alpha} for an image of shape {}.",
            tuple(shape)
        )));
    }
    Ok(Some(alpha.rem_euclid(count) as usize))
}

/// What a lookup is asked for besides its arrays.
pub struct Asked<'a, 'py> {
    /// All but the channel of opacity, whose number depends on the image.
    pub options: Options,
    /// That channel.
    pub alpha: Option<i64>,
    /// Where to put the result.
    pub out: Option<&'a Bound<'py, PyAny>>,
}

/// `Projection.sample`.
pub fn sample<'py>(
    py: Python<'py>,
    map: &Map,
    object: &Bound<'py, PyAny>,
    directions: &Bound<'py, PyAny>,
    asked: Asked<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let directions = reals(directions, "directions", asked.out)?;
    with_image!(image(object, asked.out)?, image => sample_texels(py, map, &image, &directions, asked))
}

fn sample_texels<'py, T: PyTexel>(
    py: Python<'py>,
    map: &Map,
    image: &PyReadonlyArrayDyn<'py, T>,
    directions: &Reals<'py>,
    Asked {
        options,
        alpha,
        out,
    }: Asked<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let (shape, channels, texel) = split(map, image.shape())?;
    let options = options.alpha(channel(alpha, image.shape(), channels)?);
    let view = ImageView::new(map, shape, channels, image.as_slice()?)?;
    let sampler = Sampler::new(&view, &options)?;
    with_reals!(directions, directions => {
        let mut shape = leading(directions.shape(), 3, "directions")?.to_vec();
        shape.extend_from_slice(texel);
        let array = output::<T>(py, out, T::NAME, &shape)?;
        {
            let mut target = writable(&array)?;
            let out = target.as_slice_mut()?;
            disjoint(image.as_slice()?, out)?;
            let failed = OnceLock::new();
            directions.each(py, out, &|directions, out| {
                if let Err(error) = sampler.sample(directions, out) {
                    failed.get_or_init(|| error);
                }
            })?;
            if let Some(error) = failed.into_inner() {
                return Err(error.into());
            }
        }
        finish(array, out.is_some())
    })
}

/// `mipmaps`: the levels of a chain but the first.
pub fn mipmaps<'py>(
    py: Python<'py>,
    map: &Map,
    object: &Bound<'py, PyAny>,
) -> PyResult<Vec<Bound<'py, PyAny>>> {
    with_image!(image(object, None)?, image => levels(py, map, &image))
}

fn levels<'py, T: PyTexel>(
    py: Python<'py>,
    map: &Map,
    image: &PyReadonlyArrayDyn<'py, T>,
) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let (shape, channels, texel) = split(map, image.shape())?;
    let view = ImageView::new(map, shape, channels, image.as_slice()?)?;
    let chain = stoppable(py, || resample::chain(&view))?;
    let mut levels = Vec::with_capacity(chain.len());
    for (mut shape, texels) in chain {
        shape.extend_from_slice(texel);
        let array = output::<T>(py, None, T::NAME, &shape)?;
        for (out, x) in writable(&array)?.as_slice_mut()?.iter_mut().zip(texels) {
            *out = T::store(x);
        }
        levels.push(finish(array, false)?);
    }
    Ok(levels)
}

/// `convert`: `shape` is the target's, without channels.
pub fn convert<'py>(
    py: Python<'py>,
    object: &Bound<'py, PyAny>,
    src: &Map,
    dst: &Map,
    shape: &[usize],
    asked: Asked<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    with_image!(image(object, asked.out)?, image => convert_texels(py, &image, src, dst, shape, asked))
}

fn convert_texels<'py, T: PyTexel>(
    py: Python<'py>,
    image: &PyReadonlyArrayDyn<'py, T>,
    src: &Map,
    dst: &Map,
    shape: &[usize],
    Asked {
        options,
        alpha,
        out,
    }: Asked<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let (source_shape, channels, texel) = split(src, image.shape())?;
    let options = options.alpha(channel(alpha, image.shape(), channels)?);
    let view = ImageView::new(src, source_shape, channels, image.as_slice()?)?;
    let mut filled = match &options.window {
        Some(window) => vec![window.rows.len(), window.columns.len()],
        None => shape.to_vec(),
    };
    filled.extend_from_slice(texel);
    let array = output::<T>(py, out, T::NAME, &filled)?;
    {
        let mut target = writable(&array)?;
        let into = target.as_slice_mut()?;
        disjoint(view.texels(), into)?;
        stoppable(py, || resample::convert(&view, dst, shape, &options, into))?;
    }
    finish(array, out.is_some())
}
