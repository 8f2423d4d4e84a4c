//! Images as numpy arrays: texel types, shapes with channels, fill values.

use super::arrays::{
    Reals, contiguous, disjoint, finish, helper, leading, output, reals, with_reals, writable,
};
use crate::error::Error;
use crate::image::raster::tuple;
use crate::image::texel::Texel;
use crate::map::Map;
use crate::resample::area;
use crate::resample::area::Statistic;
use crate::resample::lookup;
use crate::resample::mips;
use crate::resample::sample::{Filter, Source};
use crate::resample::trilinear;
use crate::resample::trilinear::Chained;
use glam::DMat3;
use half::f16;
use ndarray::ArrayView2;
use numpy::{Element, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// A texel type that numpy arrays hold.
pub trait PyTexel: Texel + Element {
    const NAME: &'static str;
    /// Whether this number is one of its values.
    fn fits(x: f64) -> bool;
}

macro_rules! texel {
    ($t:ty, $name:literal, $fits:expr) => {
        impl PyTexel for $t {
            const NAME: &'static str = $name;
            fn fits(x: f64) -> bool {
                $fits(x)
            }
        }
    };
}
texel!(u8, "uint8", |x| (0.0..=255.0).contains(&x));
texel!(u16, "uint16", |x| (0.0..=65535.0).contains(&x));
texel!(f16, "float16", |_| true);
texel!(f32, "float32", |_| true);
texel!(f64, "float64", |_| true);

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
    let converted = helper(object.py(), "as_image")?.call1((object, out))?;
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

/// An image as a row of channels for each texel.
fn texels<'a, T: PyTexel>(
    image: &'a PyReadonlyArrayDyn<'_, T>,
    channels: usize,
) -> PyResult<ArrayView2<'a, T>> {
    let slice = image.as_slice()?;
    ArrayView2::from_shape((slice.len() / channels, channels), slice)
        .map_err(|error| PyValueError::new_err(error.to_string()))
}

fn fill_texels<T: PyTexel>(fill: Option<&Bound<'_, PyAny>>, channels: usize) -> PyResult<Vec<T>> {
    let Some(fill) = fill else {
        return Ok(vec![T::from_f64(T::NOTHING); channels]);
    };
    let values = match fill.extract::<f64>() {
        Ok(value) => vec![value; channels],
        Err(_) => fill.extract::<Vec<f64>>().map_err(|_| {
            PyTypeError::new_err("Expected `fill` to be a number or one number a channel.")
        })?,
    };
    if values.len() != channels {
        return Err(PyValueError::new_err(format!(
            "Expected `fill` to have one number for each of {channels} channels, got {}.",
            values.len()
        )));
    }
    if let Some(value) = values.iter().find(|value| !T::fits(**value)) {
        return Err(PyValueError::new_err(format!(
            "`fill` {value} is no value of {}.",
            T::NAME
        )));
    }
    Ok(values.into_iter().map(T::from_f64).collect())
}

/// What a lookup is asked for besides its arrays.
pub struct Lookup<'a, 'py> {
    pub filter: &'a str,
    pub rotation: Option<DMat3>,
    pub fill: Option<&'a Bound<'py, PyAny>>,
    pub out: Option<&'a Bound<'py, PyAny>>,
    /// Whether NaN texels have no weight.
    pub skipna: bool,
    /// Whether texels that see more than one texel of the source are means.
    pub antialias: bool,
}

/// `Projection.sample`.
pub fn sample<'py>(
    py: Python<'py>,
    map: &Map,
    object: &Bound<'py, PyAny>,
    directions: &Bound<'py, PyAny>,
    options: &Lookup<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let directions = reals(directions, "directions", options.out)?;
    with_image!(image(object, options.out)?, image => sample_texels(py, map, &image, &directions, options))
}

fn sample_texels<'py, T: PyTexel>(
    py: Python<'py>,
    map: &Map,
    image: &PyReadonlyArrayDyn<'py, T>,
    directions: &Reals<'py>,
    options: &Lookup<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let filter = Filter::find(options.filter)?;
    let (shape, channels, texel) = split(map, image.shape())?;
    let fill = fill_texels::<T>(options.fill, channels)?;
    let source = Source::new(map, shape, texels(image, channels)?)?;
    with_reals!(directions, directions => {
        let mut shape = leading(directions.shape(), 3, "directions")?.to_vec();
        shape.extend_from_slice(texel);
        let array = output::<T>(py, options.out, T::NAME, &shape)?;
        {
            let mut target = writable(&array)?;
            let out = target.as_slice_mut()?;
            disjoint(image.as_slice()?, out)?;
            let rotation = options.rotation;
            directions.each(py, out, |directions, out| {
                source.sample(rotation, filter, &fill, directions, out);
            })?;
        }
        finish(array, options.out.is_some())
    })
}

/// How an image is turned into another.
enum Way {
    /// Looked up, antialiased or not.
    Looked(Filter, bool),
    /// Looked up in a mip chain.
    Chained(Chained),
    /// Counted by what texels cover.
    Statistic(Statistic),
}

impl Way {
    fn find(filter: &str, antialias: bool) -> Result<Way, Error> {
        if let Some(statistic) = Statistic::find(filter) {
            return Ok(Way::Statistic(statistic));
        }
        if let Some(chained) = Chained::find(filter) {
            return Ok(Way::Chained(chained));
        }
        let Ok(filter) = Filter::find(filter) else {
            let names = [
                &Filter::NAMES[..],
                &Chained::NAMES[..],
                &Statistic::NAMES[..],
            ];
            return Err(Error::unknown("filter", filter, &names.concat()));
        };
        // A mean of labels is no label.
        Ok(Way::Looked(filter, antialias && filter != Filter::Nearest))
    }
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
    let texels = image.as_slice()?;
    let chain = py.detach(|| mips::chain(map, shape, texels, channels))?;
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
    options: &Lookup<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    with_image!(image(object, options.out)?, image => convert_texels(py, &image, src, dst, shape, options))
}

fn convert_texels<'py, T: PyTexel>(
    py: Python<'py>,
    image: &PyReadonlyArrayDyn<'py, T>,
    src: &Map,
    dst: &Map,
    shape: &[usize],
    options: &Lookup<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    // The filter's name is looked at first.
    let way = Way::find(options.filter, options.antialias)?;
    let (source_shape, channels, texel) = split(src, image.shape())?;
    let fill = fill_texels::<T>(options.fill, channels)?;
    let texels = texels(image, channels)?;
    let source = Source::new(src, source_shape, texels)?;
    if options.skipna && !matches!(way, Way::Statistic(_)) {
        return Err(PyValueError::new_err(format!(
            "`skipna` needs filter 'area' or 'mode', got '{}'.",
            options.filter
        )));
    }
    let mut whole = shape.to_vec();
    whole.extend_from_slice(texel);
    let array = output::<T>(py, options.out, T::NAME, &whole)?;
    {
        let mut target = writable(&array)?;
        let out = target.as_slice_mut()?;
        disjoint(image.as_slice()?, out)?;
        let rotation = options.rotation;
        let skipna = options.skipna;
        py.detach(|| match way {
            Way::Statistic(statistic) => {
                let source = area::Source {
                    map: src,
                    shape: source_shape,
                    texels,
                    skipna,
                };
                area::convert(source, dst, shape, rotation, statistic, &fill, out)
            }
            Way::Chained(filter) => {
                trilinear::convert(&source, dst, shape, rotation, filter, &fill, out)
            }
            Way::Looked(filter, antialias) => {
                lookup::convert(&source, dst, shape, rotation, filter, antialias, &fill, out)
            }
        })?;
    }
    finish(array, options.out.is_some())
}
