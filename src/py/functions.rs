//! The module's functions.

use super::helpers::Helper;
use super::projection::{PyProjection, size};
use super::stopping::stoppable;
use crate::geometry::axes;
use crate::geometry::world::Worlds;
use crate::kernel;
use crate::kernel::threads;
use crate::map::conventions;
use crate::projections::cost;
use crate::projections::projection::Visitor;
use crate::projections::projection::{Coverage, Projection};
use crate::projections::{Kind, REGISTRY};
use crate::py::arrays;
use crate::py::arrays::{
    Float, Parts, Points, Reals, converted, disjoint, finish, leading, output, reals, run, writable,
};
use crate::py::images;
use crate::py::images::Asked;
use crate::resample;
use crate::resample::Filter;
use numpy::{PyArray2, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

/// What a pickle calls: the class, and what makes one of it.
#[pyfunction]
#[pyo3(name = "_rebuild", signature = (class, name, options, /))]
pub fn rebuild<'py>(
    class: &Bound<'py, PyAny>,
    name: &str,
    options: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyAny>> {
    PyProjection::of_class(class, name, options)
}

/// Smaller versions of an image, in the same projection.
#[pyfunction]
#[pyo3(signature = (image, projection, /))]
pub fn mipmaps<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    projection: &PyProjection,
) -> PyResult<Vec<Bound<'py, PyAny>>> {
    images::mipmaps(py, &projection.0, image)
}

/// An image of one projection as an image of another.
#[pyfunction]
#[pyo3(signature = (image, src, dst, shape, /, *, rotation=None, filter="bilinear", fill=None, out=None, skipna=false, antialias=true, alpha=None, world="match", window=None))]
#[expect(clippy::too_many_arguments, reason = "the Python signature")]
pub fn convert<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    src: &PyProjection,
    dst: &PyProjection,
    shape: &Bound<'py, PyAny>,
    rotation: Option<&Bound<'py, PyAny>>,
    filter: &str,
    fill: Option<&Bound<'py, PyAny>>,
    out: Option<&Bound<'py, PyAny>>,
    skipna: bool,
    antialias: bool,
    alpha: Option<i64>,
    world: &str,
    window: Option<[usize; 4]>,
) -> PyResult<Bound<'py, PyAny>> {
    let window = window.map(|[top, bottom, left, right]| resample::Window {
        rows: top..bottom,
        columns: left..right,
    });
    let fill = match fill {
        Some(fill) => images::fill(Some(fill))?,
        None => 0.0.into(),
    };
    let options = resample::Options::new()
        .filter(Filter::find(filter)?)
        .rotation(arrays::rotation(rotation)?)
        .worlds(Worlds::find(world)?)
        .antialias(antialias)
        .fill(fill)
        .skipna(skipna)
        .window(window);
    let shape = size(&dst.0, shape)?;
    let asked = Asked {
        options,
        alpha,
        out,
    };
    images::convert(py, image, &src.0, &dst.0, &shape, asked)
}

/// The size of an image of `dst` that holds about as many texels a steradian as one of `src` of this shape.
#[pyfunction]
#[pyo3(signature = (shape, src, dst, /))]
pub fn matching_size(
    shape: &Bound<'_, PyAny>,
    src: &PyProjection,
    dst: &PyProjection,
) -> PyResult<usize> {
    let shape = size(&src.0, shape)?;
    Ok(resample::matching_size(&src.0, &dst.0, &shape)?)
}

/// The claims of every filter.
#[pyfunction]
pub fn filters(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let list = PyList::empty(py);
    for info in Filter::TABLE {
        let dict = PyDict::new(py);
        dict.set_item("name", info.name)?;
        dict.set_item("also", info.also)?;
        dict.set_item("title", info.title)?;
        dict.set_item("source", info.source)?;
        dict.set_item("takes", info.takes)?;
        dict.set_item("summary", info.summary)?;
        dict.set_item("method", info.method.name())?;
        dict.set_item("support", info.support)?;
        dict.set_item("interpolates", info.interpolates)?;
        dict.set_item("ringing", info.ringing)?;
        dict.set_item("takes_labels", info.takes_labels)?;
        dict.set_item("antialiased", info.antialiased)?;
        list.append(dict)?;
    }
    Ok(list)
}

/// Mirror reflection of the direction to the eye about a normal.
#[pyfunction]
#[pyo3(signature = (view, normal, /, *, out=None))]
pub fn reflect<'py>(
    py: Python<'py>,
    view: &Bound<'py, PyAny>,
    normal: &Bound<'py, PyAny>,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let pair = (reals(view, "view", out)?, reals(normal, "normal", out)?);
    match &pair {
        (Reals::F32(Points::Plain(v)), Reals::F32(Points::Plain(n)))
            if broadcasts(v.shape(), n.shape()) =>
        {
            return reflect_arrays(py, v, n, out);
        }
        (Reals::F64(Points::Plain(v)), Reals::F64(Points::Plain(n)))
            if broadcasts(v.shape(), n.shape()) =>
        {
            return reflect_arrays(py, v, n, out);
        }
        _ => {}
    }
    drop(pair);
    let pair = Helper::AsPair.get(py)?.call1((view, normal, out))?;
    let (view, normal, single) = pair.extract()?;
    if single {
        reflect_blocks::<f32>(py, &view, &normal, out)
    } else {
        reflect_blocks::<f64>(py, &view, &normal, out)
    }
}

/// Whether the core can pair these arrays as they are: the same shape, or one vector for all.
fn broadcasts(a: &[usize], b: &[usize]) -> bool {
    a == b || a == [3] || b == [3]
}

fn reflect_arrays<'py, T: Float>(
    py: Python<'py>,
    view: &PyReadonlyArrayDyn<'py, T>,
    normal: &PyReadonlyArrayDyn<'py, T>,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    leading(view.shape(), 3, "view")?;
    leading(normal.shape(), 3, "normal")?;
    let shape = if view.ndim() >= normal.ndim() {
        view.shape()
    } else {
        normal.shape()
    };
    let array = output::<T>(py, out, T::NAME, shape)?;
    {
        let mut target = writable(&array)?;
        let out = target.as_slice_mut()?;
        let (view, normal) = (view.as_slice()?, normal.as_slice()?);
        disjoint(view, out)?;
        disjoint(normal, out)?;
        stoppable(py, || crate::light::reflect(view, normal, out))?;
    }
    finish(array, out.is_some())
}

/// Reflects what numpy has to convert first: two arrays of one shape.
fn reflect_blocks<'py, T: Float>(
    py: Python<'py>,
    view: &Bound<'py, PyUntypedArray>,
    normal: &Bound<'py, PyUntypedArray>,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let array = output::<T>(py, out, T::NAME, view.shape())?;
    {
        let mut target = writable(&array)?;
        let mut output = Parts(target.as_slice_mut()?);
        let arguments = (view, normal, T::SINGLE);
        let blocks = Helper::PairedBlocks.get(py)?.call1(arguments)?;
        for pair in blocks.try_iter()? {
            let (view, normal) = pair?.extract::<(Bound<'_, PyAny>, Bound<'_, PyAny>)>()?;
            let (view, normal) = (converted::<T>(&view)?, converted::<T>(&normal)?);
            let (view, normal) = (view.as_slice()?, normal.as_slice()?);
            let out = output.next(view.len())?;
            run(py, out.len(), || crate::light::reflect(view, normal, out))??;
        }
    }
    finish(array, out.is_some())
}

/// The rotation of these angles in degrees: roll about +z, then pitch about +x, then yaw about +y.
#[pyfunction]
#[pyo3(signature = (yaw, pitch, roll))]
pub fn rotation(
    py: Python<'_>,
    yaw: f64,
    pitch: f64,
    roll: f64,
) -> PyResult<Bound<'_, PyArray2<f64>>> {
    if !(yaw.is_finite() && pitch.is_finite() && roll.is_finite()) {
        return Err(PyValueError::new_err(
            "`yaw`, `pitch` and `roll` must be finite.",
        ));
    }
    let rows = axes::rows(axes::from_angles(yaw, pitch, roll)).map(Vec::from);
    Ok(PyArray2::from_vec2(py, &rows)?)
}

/// The claims of every registered projection.
#[pyfunction]
pub fn registry(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    struct Claims;
    impl Visitor for Claims {
        type Output = (Coverage, (f64, f64), &'static str, (u32, u32), bool);
        fn visit<P: Projection>(self, p: P) -> Self::Output {
            (
                p.coverage(),
                p.density_range(),
                p.seam().name(),
                cost::steps(p),
                P::COMMON,
            )
        }
    }
    let list = PyList::empty(py);
    for info in REGISTRY {
        let defaults: Vec<f64> = info.parameters.iter().map(|p| p.default).collect();
        let Some(kind) = Kind::new(info.name, &defaults) else {
            continue;
        };
        let (coverage, density_range, seam, steps, common) = kind.visit(Claims);
        let parameters = PyList::empty(py);
        for parameter in info.parameters {
            let dict = PyDict::new(py);
            dict.set_item("name", parameter.name)?;
            dict.set_item("default", parameter.default)?;
            dict.set_item("minimum", parameter.above)?;
            dict.set_item("maximum", parameter.maximum)?;
            dict.set_item("unit", parameter.unit)?;
            dict.set_item("doc", parameter.doc)?;
            parameters.append(dict)?;
        }
        let dict = PyDict::new(py);
        dict.set_item("name", info.name)?;
        dict.set_item("title", info.title)?;
        dict.set_item("known_as", info.known_as)?;
        dict.set_item("source", info.source)?;
        dict.set_item("summary", info.summary)?;
        dict.set_item("singular", info.singular)?;
        dict.set_item("coverage", coverage.name())?;
        dict.set_item("coverage_solid_angle", coverage.solid_angle())?;
        dict.set_item("seam", seam)?;
        dict.set_item("steps", steps)?;
        dict.set_item("in_double", !common)?;
        dict.set_item("faces", info.faces)?;
        dict.set_item(
            "layouts",
            info.layouts.iter().map(|l| l.name).collect::<Vec<_>>(),
        )?;
        dict.set_item("axes", info.axes)?;
        dict.set_item("aspect", info.aspect)?;
        dict.set_item("equal_area", info.equal_area)?;
        dict.set_item("conformal", info.conformal)?;
        dict.set_item("density_range", density_range)?;
        dict.set_item("round_trip", info.round_trip)?;
        dict.set_item("parameters", parameters)?;
        dict.set_item(
            "conventions",
            conventions::of(info.name)
                .map(|c| c.name)
                .collect::<Vec<_>>(),
        )?;
        list.append(dict)?;
    }
    Ok(list)
}

/// Every convention.
#[pyfunction]
pub fn convention_table(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let list = PyList::empty(py);
    for row in conventions::all() {
        let parameters = PyDict::new(py);
        for (name, value) in row.parameters {
            parameters.set_item(name, value)?;
        }
        let dict = PyDict::new(py);
        dict.set_item("kind", row.kind)?;
        dict.set_item("name", row.name)?;
        dict.set_item("axes", row.axes)?;
        dict.set_item("grid", row.grid.name())?;
        dict.set_item("layout", row.layout)?;
        dict.set_item("parameters", parameters)?;
        dict.set_item("up", row.world.up())?;
        dict.set_item("forward", row.world.ahead())?;
        dict.set_item("left_handed", row.world.left_handed())?;
        dict.set_item("ahead", row.ahead)?;
        dict.set_item("note", row.note)?;
        dict.set_item("source", row.source)?;
        dict.set_item("version", row.version)?;
        dict.set_item("verified", row.verified())?;
        list.append(dict)?;
    }
    Ok(list)
}

/// Sets how many threads large calls use.
#[pyfunction]
#[pyo3(signature = (n, /))]
pub fn set_num_threads(n: i64) -> PyResult<()> {
    if !(1..=4096).contains(&n) {
        return Err(PyValueError::new_err(format!(
            "Expected between 1 and 4096 threads, got {n}."
        )));
    }
    threads::set_count(n as usize);
    Ok(())
}

/// How many threads large calls use.
#[pyfunction]
pub fn get_num_threads() -> usize {
    threads::count()
}

/// The instruction-set level that kernels run at.
#[pyfunction]
pub fn simd_level() -> &'static str {
    kernel::level()
}

/// The levels that this CPU runs, weakest first.
#[pyfunction]
pub fn simd_levels() -> Vec<&'static str> {
    kernel::levels().to_vec()
}

/// Makes kernels run at a level; None for the best.
#[pyfunction]
#[pyo3(signature = (name, /))]
pub fn set_simd_level(name: Option<&str>) -> PyResult<()> {
    if kernel::force_level(name) {
        Ok(())
    } else {
        let levels = kernel::levels().join(", ");
        let name = name.unwrap_or_default();
        Err(PyValueError::new_err(format!(
            "this CPU has no SIMD level '{name}'; there are {levels}"
        )))
    }
}

/// Raises for a word that is none of those known, and says which is near.
#[pyfunction]
#[pyo3(signature = (what, word, known, /))]
pub fn check_word(what: String, word: &str, known: Vec<String>) -> PyResult<()> {
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    if known.contains(&word) {
        return Ok(());
    }
    Err(crate::error::Error::unknown(what, word, &known).into())
}
