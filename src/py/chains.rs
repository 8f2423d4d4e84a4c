//! Mip chains of images of which only a part is there: level by level, window by window. `spheremap.resample.chained` asks for them.

use super::arrays::{finish, output, writable};
use super::images::{PyTexel, fill as filling, image, split, with_image};
use super::projection::{PyProjection, size};
use super::stopping::stoppable;
use crate::geometry::world::Worlds;
use crate::image::ImageView;
use crate::image::rim::Across;
use crate::image::texel::Texel;
use crate::map::Map;
use crate::resample::convert::{convert_levels as converted, tiles_seen};
use crate::resample::halving::{Halving, Held};
use crate::resample::{Filter, Options, Window};
use numpy::{Element, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// The shapes, without channels, of the levels of an image's chain but the first.
#[pyfunction]
#[pyo3(signature = (projection, shape, /))]
pub fn level_shapes(
    projection: &PyProjection,
    shape: &Bound<'_, PyAny>,
) -> PyResult<Vec<Vec<usize>>> {
    let (map, mut shape) = (&projection.0, size(&projection.0, shape)?);
    let mut shapes = Vec::new();
    while let Some(smaller) = crate::resample::halving::smaller(map, &shape)? {
        shapes.push(smaller.clone());
        shape = smaller;
    }
    Ok(shapes)
}

/// How a level of a chain becomes the next one.
#[pyclass(name = "Halving", module = "spheremap._core", frozen)]
pub struct PyHalving {
    halving: Halving,
    rim: Vec<Across>,
}

#[pymethods]
impl PyHalving {
    /// Of a level of this shape, without channels.
    #[new]
    #[pyo3(signature = (projection, shape, /))]
    fn new(py: Python<'_>, projection: &PyProjection, shape: &Bound<'_, PyAny>) -> PyResult<Self> {
        let (map, shape) = (&projection.0, size(&projection.0, shape)?);
        stoppable(py, || {
            let halving = Halving::new(map, &shape)?.ok_or(Smallest)?;
            let rim = halving.rim();
            Ok::<_, PyErr>(PyHalving { halving, rim })
        })
    }

    /// The part of the level that a window of the next one is made of: each is the first row, the one after the last, and the same of
    /// columns. Rows are those of all faces where faces are apart.
    #[pyo3(signature = (window, /))]
    fn needs(&self, window: [usize; 4]) -> PyResult<[usize; 4]> {
        let window = as_window(window);
        window.check(&self.halving.coarse)?;
        Ok(ends(self.halving.needs(&self.rim, &window)))
    }

    /// A window of the next level, of the texels (H, W, C) of this part of the level: in floats.
    #[pyo3(signature = (texels, part, window, /))]
    fn window<'py>(
        &self,
        py: Python<'py>,
        texels: &Bound<'py, PyAny>,
        part: [usize; 4],
        window: [usize; 4],
    ) -> PyResult<Bound<'py, PyAny>> {
        let needed = self.needs(window)?;
        let holds =
            |first: usize, end: usize| part[first] <= needed[first] && needed[end] <= part[end];
        let (part, window) = (as_window(part), as_window(window));
        part.check(&self.halving.fine)?;
        if !(holds(0, 1) && holds(2, 3)) {
            return Err(PyValueError::new_err(
                "Expected `part` to hold what the window needs.",
            ));
        }
        with_image!(image(texels, None)?, texels => self.made(py, &texels, &part, &window))
    }
}

impl PyHalving {
    fn made<'py, T: PyTexel>(
        &self,
        py: Python<'py>,
        texels: &PyReadonlyArrayDyn<'py, T>,
        part: &Window,
        window: &Window,
    ) -> PyResult<Bound<'py, PyAny>>
    where
        T::Float: Element,
    {
        let &[rows, columns, channels] = texels.shape() else {
            return Err(PyValueError::new_err("Expected `texels` to be (H, W, C)."));
        };
        if [rows, columns] != [part.rows.len(), part.columns.len()] {
            return Err(PyValueError::new_err("Expected `texels` of the part."));
        }
        let shape = [window.rows.len(), window.columns.len(), channels];
        let array = output::<T::Float>(py, None, T::Float::NAME, &shape)?;
        {
            let mut target = writable(&array)?;
            let out = target.as_slice_mut()?;
            out.fill(T::Float::default());
            let held = Held {
                texels: texels.as_slice()?,
                part,
                channels,
            };
            stoppable(py, || self.halving.fill(held, window, &mut Vec::new(), out))?;
        }
        finish(array, true)
    }
}

/// What has no next level.
struct Smallest;

impl From<Smallest> for PyErr {
    fn from(_: Smallest) -> PyErr {
        PyValueError::new_err("Expected a level that can be made smaller.")
    }
}

fn as_window([top, bottom, left, right]: [usize; 4]) -> Window {
    Window {
        rows: top..bottom,
        columns: left..right,
    }
}

/// `convert` by a filter that looks levels up, where the levels behind the image are there, in floats; all texels weigh the same. With it
/// come the tiles of the image itself, of at most so many rows and columns, that were seen: the first row of each, the one after the last, and
/// the same of columns.
#[pyfunction]
#[pyo3(signature = (image, levels, src, dst, shape, tile, /, *, filter, fill, world, window))]
#[expect(clippy::too_many_arguments, reason = "one call for each window")]
pub fn convert_levels<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    levels: Vec<Bound<'py, PyAny>>,
    src: &PyProjection,
    dst: &PyProjection,
    shape: &Bound<'py, PyAny>,
    tile: [usize; 2],
    filter: &str,
    fill: &Bound<'py, PyAny>,
    world: &str,
    window: [usize; 4],
) -> PyResult<(Bound<'py, PyAny>, Vec<[usize; 4]>)> {
    let options = options(filter, world, window)?.fill(filling(Some(fill))?);
    let shape = size(&dst.0, shape)?;
    let to = (&dst.0, &shape[..]);
    with_image!(self::image(image, None)?, image => {
        looked_up(py, &image, &levels, &src.0, to, tile, &options)
    })
}

fn looked_up<'py, T: PyTexel>(
    py: Python<'py>,
    image: &PyReadonlyArrayDyn<'py, T>,
    levels: &[Bound<'py, PyAny>],
    src: &Map,
    to: (&Map, &[usize]),
    tile: [usize; 2],
    options: &Options,
) -> PyResult<(Bound<'py, PyAny>, Vec<[usize; 4]>)>
where
    T::Float: Element,
{
    let (source_shape, channels, texel) = split(src, image.shape())?;
    let view = ImageView::new(src, source_shape, channels, image.as_slice()?)?;
    let held = levels.iter().map(|level| level.extract());
    let held = held.collect::<Result<Vec<PyReadonlyArrayDyn<'py, T::Float>>, _>>()?;
    let mut further = Vec::with_capacity(held.len());
    for level in &held {
        let (shape, channels, _) = split(src, level.shape())?;
        further.push(ImageView::new(src, shape, channels, level.as_slice()?)?);
    }
    let Some(window) = &options.window else {
        return Err(PyValueError::new_err("Expected a window."));
    };
    let mut filled = vec![window.rows.len(), window.columns.len()];
    filled.extend_from_slice(texel);
    let array = output::<T>(py, None, T::NAME, &filled)?;
    let tiles = {
        let mut target = writable(&array)?;
        let out = target.as_slice_mut()?;
        stoppable(py, || converted((&view, &further), to, tile, options, out))?
    };
    Ok((finish(array, true)?, tiles.into_iter().map(ends).collect()))
}

/// The tiles that `convert_levels` sees of an image of this shape, whose chain has so many levels with it: those that the first of every
/// so many rows of the window see, and its last row.
#[pyfunction]
#[pyo3(signature = (src, source_shape, levels, dst, shape, tile, every, /, *, filter, world, window))]
#[expect(clippy::too_many_arguments, reason = "one call for each window")]
pub fn tiles_of_window(
    py: Python<'_>,
    src: &PyProjection,
    source_shape: &Bound<'_, PyAny>,
    levels: usize,
    dst: &PyProjection,
    shape: &Bound<'_, PyAny>,
    tile: [usize; 2],
    every: usize,
    filter: &str,
    world: &str,
    window: [usize; 4],
) -> PyResult<Vec<[usize; 4]>> {
    let options = options(filter, world, window)?;
    let (from, to) = (size(&src.0, source_shape)?, size(&dst.0, shape)?);
    let tiles = stoppable(py, || {
        let (from, to) = ((&src.0, &from[..]), (&dst.0, &to[..]));
        tiles_seen(from, levels, to, (tile, every), &options)
    })?;
    Ok(tiles.into_iter().map(ends).collect())
}

fn options(filter: &str, world: &str, window: [usize; 4]) -> PyResult<Options> {
    Ok(Options::new()
        .filter(Filter::find(filter)?)
        .worlds(Worlds::find(world)?)
        .window(as_window(window)))
}

fn ends(Window { rows, columns }: Window) -> [usize; 4] {
    [rows.start, rows.end, columns.start, columns.end]
}
