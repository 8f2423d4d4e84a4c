//! The class `Projection`: a map, with its verbs as methods.

use super::stopping::stoppable;
use crate::geometry::axes;
use crate::image::raster::{LONGEST_SIDE, Raster, shape_of_size};
use crate::image::texels;
use crate::map::{Map, MapOptions};
use crate::py::arrays;
use crate::py::arrays::{Float, finish, output, points, reals, with_reals, writable};
use crate::py::images;
use crate::py::images::Asked;
use crate::py::mip_lookups::{self, Looks};
use crate::resample;
use glam::DMat3;
use numpy::PyArray2;
use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// A map between directions and an image: a projection with its axes, grid, layout and parameters.
///
/// The base of `spheremap.Projection`, which has the verbs of images and light as well. Immutable,
/// hashable, picklable.
#[pyclass(
    name = "Projection",
    module = "spheremap._core",
    subclass,
    frozen,
    eq,
    hash
)]
#[derive(PartialEq, Eq, Hash)]
pub struct PyProjection(pub Map);

/// Whether a dtype is float32 and not float64.
fn wants_f32(dtype: &Bound<'_, PyAny>) -> PyResult<bool> {
    let made = dtype
        .py()
        .import("numpy")?
        .getattr("dtype")?
        .call1((dtype,));
    let Ok(dtype) = made else {
        return Err(PyTypeError::new_err(format!(
            "Expected `dtype` to be float32 or float64, got {}.",
            dtype.repr()?
        )));
    };
    match dtype.getattr("name")?.extract::<String>()?.as_str() {
        "float32" => Ok(true),
        "float64" => Ok(false),
        name => Err(PyTypeError::new_err(format!(
            "Expected `dtype` to be float32 or float64, got {name}."
        ))),
    }
}

/// Axes that the shape of anything has, at most.
const MOST_AXES: usize = 32;

/// A size (one number) or a whole shape.
pub fn size<'py>(map: &Map, size: &Bound<'py, PyAny>) -> PyResult<Vec<usize>> {
    let shape = match size.extract::<i64>() {
        Ok(n) if n >= 1 => shape_of_size(map, (n as usize).min(LONGEST_SIDE + 1)),
        Ok(n) => {
            return Err(PyValueError::new_err(format!(
                "Expected a size of at least 1, got {n}."
            )));
        }
        // A list of a trillion numbers is not read to its end.
        Err(_) if size.len().is_ok_and(|n| n > MOST_AXES) => {
            return Err(PyTypeError::new_err(
                "Expected `size` to be a whole number, or a shape of whole numbers.",
            ));
        }
        Err(_) => size
            .extract::<Vec<i64>>()
            .map_err(|_| {
                PyTypeError::new_err(
                    "Expected `size` to be a whole number, or a shape of whole numbers.",
                )
            })?
            .into_iter()
            .map(|n| usize::try_from(n).unwrap_or(0))
            .collect(),
    };
    Raster::new(map, &shape)?;
    Ok(shape)
}

/// The value of a parameter.
fn number(name: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    value.extract::<f64>().map_err(|error| {
        let py = value.py();
        match value.get_type().name() {
            Ok(got) if error.is_instance_of::<PyTypeError>(py) => {
                PyTypeError::new_err(format!("`{name}` must be a number, got {got}."))
            }
            _ if error.is_instance_of::<PyOverflowError>(py) => {
                PyValueError::new_err(format!("`{name}` must be a number that a float can hold."))
            }
            _ => error,
        }
    })
}

impl PyProjection {
    /// A map as an object of the caller's class, which may be one made in Python.
    fn like<'py>(slf: &Bound<'py, Self>, map: Map) -> PyResult<Bound<'py, PyAny>> {
        let made = PyProjection(map);
        let options = made.options(slf.py(), made.0.pose())?;
        Self::of_class(slf.get_type().as_any(), made.name(), &options)
    }

    /// An object of a class made in Python, which may refuse to be called.
    pub fn of_class<'py>(
        class: &Bound<'py, PyAny>,
        name: &str,
        options: &Bound<'py, PyDict>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let new = class.py().get_type::<PyProjection>().getattr("__new__")?;
        new.call((class, name), Some(options))
    }

    /// What the constructor takes beside the name: everything that makes it equal.
    fn options<'py>(&self, py: Python<'py>, pose: Option<DMat3>) -> PyResult<Bound<'py, PyDict>> {
        let options = self.parameters(py)?;
        options.set_item("convention", self.convention())?;
        options.set_item("axes", self.axes())?;
        options.set_item("grid", self.grid())?;
        options.set_item("layout", self.layout())?;
        options.set_item("world", self.world())?;
        if let Some(pose) = pose {
            options.set_item("pose", axes::rows(pose))?;
        }
        Ok(options)
    }

    fn directions_as<'py, T: Float>(
        &self,
        py: Python<'py>,
        shape: &[usize],
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut whole = shape.to_vec();
        whole.push(3);
        let array = output::<T>(py, None, T::NAME, &whole)?;
        {
            let mut target = writable(&array)?;
            let out = target.as_slice_mut()?;
            stoppable(py, || texels::directions(&self.0, shape, None, out))?;
        }
        finish(array, false)
    }
}

#[pymethods]
impl PyProjection {
    #[new]
    #[pyo3(signature = (name, /, *, convention=None, axes=None, grid=None, layout=None, world=None, pose=None, **parameters))]
    #[expect(clippy::too_many_arguments, reason = "the Python signature")]
    fn new(
        name: &str,
        convention: Option<&str>,
        axes: Option<&str>,
        grid: Option<&str>,
        layout: Option<&str>,
        world: Option<&str>,
        pose: Option<&Bound<'_, PyAny>>,
        parameters: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyProjection> {
        let mut values = Vec::new();
        if let Some(parameters) = parameters {
            for (name, value) in parameters {
                let name = name.extract::<String>()?;
                let value = number(&name, &value)?;
                values.push((name, value));
            }
        }
        let values: Vec<(&str, f64)> = values.iter().map(|(name, x)| (&**name, *x)).collect();
        let options = MapOptions {
            convention,
            axes,
            grid,
            layout,
            parameters: &values,
        };
        let mut map = Map::with(name, options)?;
        if let Some(world) = world {
            map = map.with_world(world.parse()?);
        }
        Ok(PyProjection(match pose {
            Some(pose) => map.turned(arrays::matrix(pose, "pose")?)?,
            None => map,
        }))
    }

    /// Image coordinates of directions: (..., 3) -> (..., 2), or (..., 3) as (u, v, face).
    #[pyo3(signature = (directions, out=None, /))]
    fn encode<'py>(
        &self,
        py: Python<'py>,
        directions: &Bound<'py, PyAny>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let map = &self.0;
        let reals = reals(directions, "directions", out)?;
        let room = arrays::room(out);
        with_reals!(&reals, d => {
            let work = |d: &[_], uv: &mut [_]| map.encode_to(None, d, uv, room);
            points(py, d, "directions", 3, out, d.dtype(), &[map.uv_width()], &work)
        })
    }

    /// Unit directions at image coordinates; NaN outside the valid image.
    #[pyo3(signature = (uv, out=None, /))]
    fn decode<'py>(
        &self,
        py: Python<'py>,
        uv: &Bound<'py, PyAny>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let map = &self.0;
        let reals = reals(uv, "uv", out)?;
        let room = arrays::room(out);
        with_reals!(&reals, uv => {
            let work = |uv: &[_], result: &mut [_]| map.decode_to(None, uv, result, room);
            points(py, uv, "uv", map.uv_width(), out, uv.dtype(), &[3], &work)
        })
    }

    /// Derivatives of the direction by u and v: (..., 3, 2).
    #[pyo3(signature = (uv, out=None, /))]
    fn jacobian<'py>(
        &self,
        py: Python<'py>,
        uv: &Bound<'py, PyAny>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let map = &self.0;
        let reals = reals(uv, "uv", out)?;
        with_reals!(&reals, uv => {
            let work = |uv: &[_], result: &mut [_]| map.jacobian_numbers(None, uv, result);
            points(py, uv, "uv", map.uv_width(), out, uv.dtype(), &[3, 2], &work)
        })
    }

    /// Steradians per unit of image area, dω/(du dv).
    #[pyo3(signature = (uv, out=None, /))]
    fn density<'py>(
        &self,
        py: Python<'py>,
        uv: &Bound<'py, PyAny>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let map = &self.0;
        let reals = reals(uv, "uv", out)?;
        with_reals!(&reals, uv => {
            let work = |uv: &[_], result: &mut [_]| map.density_numbers(uv, result);
            points(py, uv, "uv", map.uv_width(), out, uv.dtype(), &[], &work)
        })
    }

    /// Whether image coordinates lie in the valid image.
    #[pyo3(signature = (uv, /))]
    fn valid<'py>(&self, py: Python<'py>, uv: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let map = &self.0;
        with_reals!(&reals(uv, "uv", None)?, uv => {
            points(py, uv, "uv", map.uv_width(), None, "bool", &[], &|uv, valid| map.valid_numbers(uv, valid))
        })
    }

    /// Whether directions lie in the coverage.
    #[pyo3(signature = (directions, /))]
    fn covers<'py>(
        &self,
        py: Python<'py>,
        directions: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let map = &self.0;
        with_reals!(&reals(directions, "directions", None)?, d => {
            points(py, d, "directions", 3, None, "bool", &[], &|d, covered| map.covers_numbers(None, d, covered))
        })
    }

    /// The exact solid angle of every texel of an image of this size, in steradians.
    #[pyo3(signature = (size, /))]
    fn solid_angle<'py>(
        &self,
        py: Python<'py>,
        size: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let shape = self::size(&self.0, size)?;
        let array = output::<f64>(py, None, "float64", &shape)?;
        {
            let mut target = writable(&array)?;
            let out = target.as_slice_mut()?;
            stoppable(py, || texels::solid_angles(&self.0, &shape, out))?;
        }
        finish(array, false)
    }

    /// The direction of every texel center of an image of this size; NaN outside the valid image.
    #[pyo3(signature = (size, /, *, dtype))]
    fn directions<'py>(
        &self,
        py: Python<'py>,
        size: &Bound<'py, PyAny>,
        dtype: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let shape = self::size(&self.0, size)?;
        if wants_f32(dtype)? {
            self.directions_as::<f32>(py, &shape)
        } else {
            self.directions_as::<f64>(py, &shape)
        }
    }

    /// The shape of an image of this size, or this shape if it is one.
    #[pyo3(signature = (size, /))]
    fn shape<'py>(
        &self,
        py: Python<'py>,
        size: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self::size(&self.0, size)?)
    }

    /// What an image of this projection shows in directions.
    #[pyo3(signature = (image, directions, /, *, filter, fill, out=None, alpha=None, skipna=false, lod=None, derivatives=None))]
    #[expect(clippy::too_many_arguments, reason = "the Python signature")]
    fn sample<'py>(
        &self,
        py: Python<'py>,
        image: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
        filter: Option<&str>,
        fill: &Bound<'py, PyAny>,
        out: Option<&Bound<'py, PyAny>>,
        alpha: Option<i64>,
        skipna: bool,
        lod: Option<&Bound<'py, PyAny>>,
        derivatives: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let detailed = lod.is_some() || derivatives.is_some();
        let options = resample::Options::new()
            .filter(mip_lookups::filter(filter, detailed)?)
            .fill(images::fill(Some(fill))?)
            .skipna(skipna);
        let asked = Asked {
            options,
            alpha,
            out,
        };
        let (image, levels) = mip_lookups::levels(image, out)?;
        if !detailed && !levels.is_empty() {
            return Err(PyValueError::new_err(
                "Expected `lod` or `derivatives` for a list of levels.",
            ));
        }
        if !detailed {
            return images::sample(py, &self.0, &image, directions, asked);
        }
        let looks = Looks {
            points: directions,
            name: "directions",
            width: 3,
            lod,
            derivatives,
            levels,
            out,
        };
        mip_lookups::sample(py, &self.0, &image, &looks, asked)
    }

    /// This projection with its world turned: what it showed at d it shows at `pose`·d.
    #[pyo3(signature = (pose, /))]
    fn turned<'py>(
        slf: &Bound<'py, Self>,
        pose: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        PyProjection::_turned(slf, pose, "pose")
    }

    /// As `turned`, for a matrix that the caller knows by another name.
    #[pyo3(signature = (rotation, name, /))]
    fn _turned<'py>(
        slf: &Bound<'py, Self>,
        rotation: &Bound<'py, PyAny>,
        name: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        let turned = slf.get().0.turned(arrays::matrix(rotation, name)?)?;
        PyProjection::like(slf, turned)
    }

    /// This map with its directions in the world of another.
    #[pyo3(signature = (other, /))]
    fn in_world_of<'py>(
        slf: &Bound<'py, Self>,
        other: &PyProjection,
    ) -> PyResult<Bound<'py, PyAny>> {
        PyProjection::like(slf, slf.get().0.in_world_of(&other.0))
    }

    /// How the world of the map is turned: a matrix of shape (3, 3), or None.
    #[getter]
    fn pose<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray2<f64>>> {
        let rows = axes::rows(self.0.pose()?);
        Some(PyArray2::from_owned_array(py, ndarray::arr2(&rows)))
    }

    /// What `explain` prints.
    fn explanation(&self) -> String {
        self.0.explain()
    }

    /// Prints where the axes land, which way is up, chirality, grid, coverage and density.
    fn explain(&self, py: Python<'_>) -> PyResult<()> {
        let print = py.import("builtins")?.getattr("print")?;
        print.call1((self.0.explain().trim_end(),))?;
        Ok(())
    }

    /// The projection's name.
    #[getter]
    fn name(&self) -> &'static str {
        self.0.info().name
    }

    /// The convention it was made with.
    #[getter]
    fn convention(&self) -> Option<&'static str> {
        self.0.convention()
    }

    /// Which world axes point right, down and forward.
    #[getter]
    fn axes(&self) -> String {
        self.0.axes().to_string()
    }

    /// Which axes point to the right, up and ahead of a person in its world.
    #[getter]
    fn world(&self) -> String {
        self.0.world().to_string()
    }

    /// Where texel centers lie.
    #[getter]
    fn grid(&self) -> &'static str {
        self.0.grid().name()
    }

    /// How several faces are laid out.
    #[getter]
    fn layout(&self) -> Option<&'static str> {
        self.0.layout()
    }

    /// How many faces the image coordinates tell apart.
    #[getter]
    fn faces(&self) -> usize {
        self.0.faces()
    }

    /// The parameters by name.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (parameter, value) in self.0.info().parameters.iter().zip(self.0.parameters()) {
            dict.set_item(parameter.name, value)?;
        }
        Ok(dict)
    }

    /// The part of the sphere it holds: "sphere", "hemisphere", "cap" or "part".
    #[getter]
    fn coverage(&self) -> &'static str {
        self.0.coverage().name()
    }

    /// What lies beyond its edges: "ends", "latlong", "periodic", "octahedral", "faces", "rim-opposite",
    /// "rim-other-face", "rim-other-face-flipped", "rim-mirrored" or "cuts".
    #[getter]
    fn seam(&self) -> &'static str {
        self.0.seam().name()
    }

    /// The solid angle it holds, in steradians.
    #[getter]
    fn covered_solid_angle(&self) -> f64 {
        self.0.coverage().solid_angle()
    }

    /// The part of an image that holds sphere: 1, π/4 for a disk, 1/2 for a cross.
    #[getter]
    fn used_part(&self) -> f64 {
        self.0.used_part()
    }

    /// Whether all texels see the same solid angle.
    #[getter]
    fn equal_area(&self) -> bool {
        self.0.info().equal_area
    }

    /// Whether small circles stay circles.
    #[getter]
    fn conformal(&self) -> bool {
        self.0.info().conformal
    }

    /// Smallest and largest density over the valid image.
    #[getter]
    fn density_range(&self) -> (f64, f64) {
        self.0.density_range()
    }

    /// Its full name.
    #[getter]
    fn title(&self) -> &'static str {
        self.0.info().title
    }

    /// Where the formula comes from.
    #[getter]
    fn source(&self) -> &'static str {
        self.0.info().source
    }

    /// What it is, in one line.
    #[getter]
    fn summary(&self) -> &'static str {
        self.0.info().summary
    }

    /// Its singular points.
    #[getter]
    fn singular(&self) -> &'static str {
        self.0.info().singular
    }

    /// Whether its pictures (the first face's) are mirrored as seen from inside a right-handed world.
    #[getter]
    fn mirrored(&self) -> bool {
        self.0.mirrored()[0]
    }

    fn __repr__(&self) -> PyResult<String> {
        let map = &self.0;
        let plain = Map::with(
            map.info().name,
            MapOptions {
                convention: map.convention(),
                ..MapOptions::new()
            },
        )?;
        let mut text = format!("projection(\"{}\"", map.info().name);
        let mut add = |name: &str, value: &str| text.push_str(&format!(", {name}={value}"));
        if let Some(name) = map.convention() {
            add("convention", &format!("\"{name}\""));
        }
        if map.axes() != plain.axes() {
            add("axes", &format!("\"{}\"", map.axes()));
        }
        if map.grid() != plain.grid() {
            add("grid", &format!("\"{}\"", map.grid().name()));
        }
        if let Some(layout) = map.layout()
            && map.layout() != plain.layout()
        {
            add("layout", &format!("\"{layout}\""));
        }
        if map.world() != plain.world() {
            add("world", &format!("\"{}\"", map.world()));
        }
        let defaults = plain.parameters().iter();
        for ((parameter, value), default) in map
            .info()
            .parameters
            .iter()
            .zip(map.parameters())
            .zip(defaults)
        {
            if value != default {
                add(parameter.name, &format!("{value:?}"));
            }
        }
        text.push(')');
        if let Some(pose) = map.pose() {
            text.push_str(&format!(".turned({:?})", axes::rows(pose)));
        }
        Ok(text)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let py = slf.py();
        let rebuild = py.import("spheremap._core")?.getattr("_rebuild")?;
        let it = slf.get();
        let arguments = (slf.get_type(), it.name(), it.options(py, it.0.pose())?);
        (rebuild, arguments).into_pyobject(py)
    }
}
