//! Lookups that may say how much of an image they see.

use super::arrays::{Parts, contiguous, converted, disjoint, finish, output, writable};
use super::helpers::Helper;
use super::images::{self, Asked, PyTexel, split, with_image};
use super::stopping::stoppable;
use crate::error::Error;
use crate::image::ImageView;
use crate::map::Map;
use crate::resample::flat::{self, Address};
use crate::resample::{Detail, Filter, MipSampler, Options};
use numpy::{PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};

/// What is looked up, and how much of the image each lookup sees.
pub struct Looks<'a, 'py> {
    /// Points.
    pub points: &'a Bound<'py, PyAny>,
    /// What the caller calls them.
    pub name: &'static str,
    /// How many numbers each has.
    pub width: usize,
    /// Levels.
    pub lod: Option<&'a Bound<'py, PyAny>>,
    /// Derivatives.
    pub derivatives: Option<&'a Bound<'py, PyAny>>,
    /// The levels behind the image, where the caller has them; of its dtype, and contiguous.
    pub levels: Vec<Bound<'py, PyAny>>,
    /// Where to put the result.
    pub out: Option<&'a Bound<'py, PyAny>>,
}

/// The filter of this name; without one, that which knows what to do.
pub fn filter(name: Option<&str>, detailed: bool) -> PyResult<Filter> {
    Ok(match name {
        Some(name) => Filter::find(name)?,
        None if detailed => Filter::Trilinear,
        None => Filter::Bilinear,
    })
}

/// An image, and the levels behind it where a caller gives a list of them.
pub fn levels<'py>(
    object: &Bound<'py, PyAny>,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<(Bound<'py, PyAny>, Vec<Bound<'py, PyAny>>)> {
    if object.is_instance_of::<PyList>() || object.is_instance_of::<PyTuple>() {
        let split = Helper::AsLevels.get(object.py())?.call1((object, out))?;
        return split.extract();
    }
    Ok((object.clone(), Vec::new()))
}

/// `Projection.sample` with a level or derivatives.
pub fn sample<'py>(
    py: Python<'py>,
    map: &Map,
    object: &Bound<'py, PyAny>,
    looks: &Looks<'_, 'py>,
    asked: Asked<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    with_image!(images::image(object, asked.out)?, image => sample_texels(py, map, &image, looks, asked))
}

fn sample_texels<'py, T: PyTexel>(
    py: Python<'py>,
    map: &Map,
    image: &PyReadonlyArrayDyn<'py, T>,
    looks: &Looks<'_, 'py>,
    Asked { options, alpha, .. }: Asked<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let (shape, channels, texel) = split(map, image.shape())?;
    let options = options.alpha(images::channel(alpha, image.shape(), channels)?);
    let view = ImageView::new(map, shape, channels, image.as_slice()?)?;
    let blocks = Blocks::new(py, looks)?;
    let further = looks.levels.iter().map(|level| {
        contiguous::<T>(level)?.ok_or_else(|| PyTypeError::new_err("Expected levels of one dtype."))
    });
    let further = further.collect::<PyResult<Vec<_>>>()?;
    let mut given = Vec::with_capacity(further.len());
    for level in &further {
        let (shape, channels, _) = split(map, level.shape())?;
        given.push(ImageView::new(map, shape, channels, level.as_slice()?)?);
    }
    let sampler = if given.is_empty() {
        stoppable(py, || MipSampler::new(&view, &options))?
    } else {
        MipSampler::of_levels(&view, &given, &options)?
    };
    blocks.each(
        py,
        image.as_slice()?,
        texel,
        looks,
        |points, detail, out| {
            // Without one nobody comes here.
            let detail = detail.unwrap_or(Detail::Lod(&[]));
            sampler.sample(points, detail, out)
        },
    )
}

/// A picture looked up at (u, v).
#[pyfunction]
#[pyo3(signature = (image, uv, /, *, filter, address, fill, lod, derivatives, out))]
#[expect(clippy::too_many_arguments, reason = "the Python signature")]
pub fn sample_uv<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    uv: &Bound<'py, PyAny>,
    filter: Option<&str>,
    address: (String, String),
    fill: &Bound<'py, PyAny>,
    lod: Option<&Bound<'py, PyAny>>,
    derivatives: Option<&Bound<'py, PyAny>>,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let looks = Looks {
        points: uv,
        name: "uv",
        width: 2,
        lod,
        derivatives,
        levels: Vec::new(),
        out,
    };
    let filter = self::filter(filter, lod.is_some() || derivatives.is_some())?;
    let options = Options::new()
        .filter(filter)
        .fill(images::fill(Some(fill))?);
    let address = [Address::find(&address.0)?, Address::find(&address.1)?];
    with_image!(images::image(image, out)?, image => picture(py, &image, &looks, address, &options))
}

fn picture<'py, T: PyTexel>(
    py: Python<'py>,
    image: &PyReadonlyArrayDyn<'py, T>,
    looks: &Looks<'_, 'py>,
    address: [Address; 2],
    options: &Options,
) -> PyResult<Bound<'py, PyAny>> {
    let shape = image.shape();
    let (&[height, width], texel) = shape
        .split_first_chunk::<2>()
        .filter(|(_, texel)| texel.len() < 2)
        .ok_or_else(|| {
            PyValueError::new_err(format!(
                "Expected `image` to have shape (H, W) or (H, W, C), got {}.",
                crate::image::raster::tuple(shape)
            ))
        })?;
    let channels = texel.first().copied().unwrap_or(1);
    let texels = image.as_slice()?;
    let blocks = Blocks::new(py, looks)?;
    let sampler = stoppable(py, || {
        flat::Sampler::new(texels, [width, height], channels, address, options)
    })?;
    blocks.each(py, texels, texel, looks, |points, detail, out| {
        sampler.sample(points, detail, out)
    })
}

/// Points and their details, as arrays of one shape but for the last axis.
struct Blocks<'py>(Vec<Bound<'py, PyAny>>);

impl<'py> Blocks<'py> {
    fn new(py: Python<'py>, looks: &Looks<'_, 'py>) -> PyResult<Self> {
        let arguments = (
            looks.points,
            looks.name,
            looks.width,
            looks.lod,
            looks.derivatives,
            looks.out,
        );
        let arrays = Helper::AsLookups.get(py)?.call1(arguments)?;
        Ok(Blocks(arrays.extract()?))
    }

    /// Takes `work` over the points, a block at a time; each makes a texel.
    fn each<T: PyTexel>(
        self,
        py: Python<'py>,
        image: &[T],
        texel: &[usize],
        looks: &Looks<'_, 'py>,
        work: impl Fn(&[f64], Option<Detail<'_>>, &mut [T]) -> Result<(), Error> + Sync,
    ) -> PyResult<Bound<'py, PyAny>> {
        let points = self.0[0].cast::<PyUntypedArray>()?;
        let mut shape = points.shape().to_vec();
        shape.pop();
        shape.extend_from_slice(texel);
        let channels = texel.first().copied().unwrap_or(1);
        let array = output::<T>(py, looks.out, T::NAME, &shape)?;
        {
            let mut target = writable(&array)?;
            let out = target.as_slice_mut()?;
            disjoint(image, out)?;
            let mut output = Parts(out);
            for block in Helper::LookupBlocks.get(py)?.call1((self.0,))?.try_iter()? {
                let block = block?.extract::<Vec<Bound<'_, PyAny>>>()?;
                let arrays = block.iter().map(converted::<f64>);
                let arrays = arrays.collect::<PyResult<Vec<_>>>()?;
                let numbers = arrays.iter().map(|array| array.as_slice());
                let numbers = numbers.collect::<Result<Vec<_>, _>>()?;
                let detail = match numbers[..] {
                    [_, lod] => Some(Detail::Lod(lod)),
                    [_, right, down] => Some(Detail::Derivatives([right, down])),
                    _ => None,
                };
                let points = numbers[0];
                let out = output.next(points.len() / looks.width * channels)?;
                stoppable(py, || work(points, detail, out))?;
            }
        }
        finish(array, looks.out.is_some())
    }
}
