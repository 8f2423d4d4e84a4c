//! numpy arrays in and out.

use super::helpers::Helper;
use super::stopping::released;
use crate::error::Error;
use crate::geometry::axes;
use crate::image::raster::tuple;
use crate::kernel::Scalar;
use crate::kernel::stream::Room;
use glam::DMat3;
use numpy::{
    BorrowError, Element, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyReadwriteArrayDyn,
    PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyMemoryError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// A float type that numpy arrays hold.
pub trait Float: Scalar + Element {
    /// numpy's name for it.
    const NAME: &'static str;
    /// Whether it is float32.
    const SINGLE: bool;
}
impl Float for f32 {
    const NAME: &'static str = "float32";
    const SINGLE: bool = true;
}
impl Float for f64 {
    const NAME: &'static str = "float64";
    const SINGLE: bool = false;
}

/// Points to read.
pub enum Points<'py, T: Element> {
    /// A C-contiguous array: the core reads it as it stands.
    Plain(PyReadonlyArrayDyn<'py, T>),
    /// A large array of another kind: numpy converts it block by block.
    Other(Bound<'py, PyUntypedArray>),
}

/// An array of reals, which is computed in one of the two float types.
pub enum Reals<'py> {
    F32(Points<'py, f32>),
    F64(Points<'py, f64>),
}

/// Runs the body with the array inside, whichever float type it has.
macro_rules! with_reals {
    ($reals:expr, $array:ident => $body:expr) => {
        match $reals {
            $crate::py::arrays::Reals::F32($array) => $body,
            $crate::py::arrays::Reals::F64($array) => $body,
        }
    };
}
pub(crate) use with_reals;

/// `object` as an array of T if it is one already, C-contiguous and aligned. What a subclass of numpy's has besides, a mask, is not to be
/// lost: numpy makes a plain array of it first.
pub fn contiguous<'py, T: Element>(
    object: &Bound<'py, PyAny>,
) -> PyResult<Option<PyReadonlyArrayDyn<'py, T>>> {
    match object.cast::<PyArrayDyn<T>>() {
        Ok(array) if is_plain(object) && array.is_c_contiguous() && is_aligned(array) => {
            let array = array.try_readonly().map_err(|_| {
                PyValueError::new_err("an input overlaps an array that another call is writing to")
            })?;
            Ok(Some(array))
        }
        _ => Ok(None),
    }
}

fn is_plain(object: &Bound<'_, PyAny>) -> bool {
    object
        .get_type()
        .is(object.py().get_type::<PyUntypedArray>())
}

/// Views into packed records need not be aligned.
fn is_aligned<T: Element>(array: &Bound<'_, PyArrayDyn<T>>) -> bool {
    array.data().is_aligned()
}

fn reals_as_they_are<'py>(object: &Bound<'py, PyAny>) -> PyResult<Option<Reals<'py>>> {
    if let Some(array) = contiguous::<f32>(object)? {
        return Ok(Some(Reals::F32(Points::Plain(array))));
    }
    Ok(contiguous::<f64>(object)?.map(|array| Reals::F64(Points::Plain(array))))
}

/// `object` as an array of reals. One that has to be converted must not overlap `out`.
pub fn reals<'py>(
    object: &Bound<'py, PyAny>,
    name: &str,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Reals<'py>> {
    if let Some(array) = reals_as_they_are(object)? {
        return Ok(array);
    }
    let arguments = (object, name, out);
    let found = Helper::AsPoints.get(object.py())?.call1(arguments)?;
    let (array, single) = found.extract::<(Bound<'py, PyAny>, bool)>()?;
    if let Some(array) = reals_as_they_are(&array)? {
        return Ok(array);
    }
    let array = array.cast_into::<PyUntypedArray>()?;
    Ok(if single {
        Reals::F32(Points::Other(array))
    } else {
        Reals::F64(Points::Other(array))
    })
}

impl<'py, T: Float> Points<'py, T> {
    /// numpy's name of the type it is computed in.
    pub fn dtype(&self) -> &'static str {
        T::NAME
    }

    /// The array's shape.
    pub fn shape(&self) -> &[usize] {
        match self {
            Points::Plain(array) => array.shape(),
            Points::Other(array) => array.shape(),
        }
    }

    /// Takes `work` over the points, each of which makes the same number of items of `output`.
    pub fn each<B: Send>(
        &self,
        py: Python<'py>,
        output: &mut [B],
        work: Work<'_, T, B>,
    ) -> PyResult<()> {
        match self {
            Points::Plain(array) => {
                let input = array.as_slice()?;
                disjoint(input, output)?;
                run(py, input.len(), || work(input, output))?;
            }
            Points::Other(array) => {
                let width = array.shape().last().copied().unwrap_or(1).max(1);
                let items = output.len() / (array.len() / width).max(1);
                let mut output = Parts(output);
                let arguments = (array, T::SINGLE);
                for block in Helper::Blocks.get(py)?.call1(arguments)?.try_iter()? {
                    let block = converted::<T>(&block?)?;
                    let input = block.as_slice()?;
                    let output = output.next(input.len() / width * items)?;
                    run(py, input.len(), || work(input, output))?;
                }
            }
        }
        Ok(())
    }
}

/// A block that numpy converted.
pub fn converted<'py, T: Element>(
    block: &Bound<'py, PyAny>,
) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    contiguous(block)?.ok_or_else(|| PyTypeError::new_err("a block was not converted"))
}

/// What is left to write of an output.
pub struct Parts<'a, T>(pub &'a mut [T]);

impl<'a, T> Parts<'a, T> {
    /// The next `n` items.
    pub fn next(&mut self, n: usize) -> PyResult<&'a mut [T]> {
        let (part, rest) = std::mem::take(&mut self.0)
            .split_at_mut_checked(n)
            .ok_or_else(|| PyValueError::new_err("an input changed its shape during the call"))?;
        self.0 = rest;
        Ok(part)
    }
}

/// Lets other Python threads run meanwhile, where there is enough work: giving the interpreter up and
/// taking it back costs more than a few dozen points.
pub fn run<T: Send>(
    py: Python<'_>,
    numbers: usize,
    work: impl FnOnce() -> T + Send,
) -> PyResult<T> {
    if numbers < 512 {
        Ok(work())
    } else {
        released(py, work)
    }
}

/// A new array, made by numpy so that large ones get its huge pages. The quick way for small ones cannot
/// report a lack of memory, nor more axes than numpy allows.
fn new_array<'py, T: Element>(
    py: Python<'py>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    const SMALL: usize = 1 << 12;
    // An array without items may still be larger than numpy allows.
    let items = shape
        .iter()
        .try_fold(1_usize, |items, n| items.checked_mul((*n).max(1)));
    if items.is_some_and(|items| items <= SMALL) && shape.len() <= 32 {
        return Ok(PyArrayDyn::<T>::zeros(py, shape, false));
    }
    let empty = py.import("numpy")?.getattr("empty")?;
    let array = empty
        .call1((PyTuple::new(py, shape)?, T::get_dtype(py)))
        .map_err(|error| {
            // That is what numpy raises for more bytes than there are addresses, and for more axes than it has.
            let bytes = items.and_then(|items| items.checked_mul(size_of::<T>()));
            let too_large = bytes.is_none_or(|bytes| isize::try_from(bytes).is_err());
            if too_large && error.is_instance_of::<PyValueError>(py) {
                PyMemoryError::new_err(format!("There is no room for an array of shape {shape:?}."))
            } else {
                error
            }
        })?;
    Ok(array.cast_into::<PyArrayDyn<T>>()?)
}

/// What is known of the memory of the array to write to.
pub fn room(out: Option<&Bound<'_, PyAny>>) -> Room {
    if out.is_some() {
        Room::Used
    } else {
        Room::Fresh
    }
}

/// The array to write to: `out` if it fits, else a new one.
pub fn output<'py, T: Element>(
    py: Python<'py>,
    out: Option<&Bound<'py, PyAny>>,
    dtype: &str,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    let Some(out) = out else {
        return new_array(py, shape);
    };
    let wrong_type = |got: String| {
        PyTypeError::new_err(format!(
            "Expected `out` to be an array of {dtype}, got {got}."
        ))
    };
    let Ok(array) = out.cast::<PyArrayDyn<T>>() else {
        return Err(match out.cast::<PyUntypedArray>() {
            Ok(array) => wrong_type(array.dtype().str()?.to_string()),
            Err(_) => wrong_type(out.get_type().name()?.to_string()),
        });
    };
    if array.shape() != shape {
        let (expected, got) = (tuple(shape), tuple(array.shape()));
        return Err(PyValueError::new_err(format!(
            "Expected `out` to have shape {expected}, got {got}."
        )));
    }
    if !array.is_c_contiguous() || !is_aligned(array) {
        return Err(PyValueError::new_err(
            "Expected `out` to be C-contiguous and aligned.",
        ));
    }
    Ok(array.clone())
}

/// The right to write to an array; an error where it is read-only or overlaps an input.
pub fn writable<'py, T: Element>(
    array: &Bound<'py, PyArrayDyn<T>>,
) -> PyResult<PyReadwriteArrayDyn<'py, T>> {
    array.try_readwrite().map_err(|error| {
        PyValueError::new_err(match error {
            BorrowError::NotWriteable => "`out` is read-only.",
            _ => "`out` overlaps an input or an array that another call is using.",
        })
    })
}

/// Takes the result of a call on slices of one shape, which cannot fail.
pub fn fits(result: Result<(), crate::error::Error>) {
    debug_assert_eq!(result, Ok(()));
}

/// An error if two slices share memory: arrays over one foreign buffer escape numpy's bookkeeping.
pub fn disjoint<A, B>(input: &[A], output: &[B]) -> PyResult<()> {
    let (a, b) = (input.as_ptr_range(), output.as_ptr_range());
    let apart = a.end as usize <= b.start as usize || b.end as usize <= a.start as usize;
    if apart || input.is_empty() || output.is_empty() {
        Ok(())
    } else {
        Err(PyValueError::new_err(
            "`out` overlaps an input or an array that another call is using.",
        ))
    }
}

/// The result of a call: a number where it has no dimensions and nobody gave an array.
pub fn finish<'py, T: Element>(
    array: Bound<'py, PyArrayDyn<T>>,
    given: bool,
) -> PyResult<Bound<'py, PyAny>> {
    if array.ndim() == 0 && !given {
        return array.get_item(PyTuple::empty(array.py()));
    }
    Ok(array.into_any())
}

/// The leading axes of an array whose last axis must have `width` entries.
pub fn leading<'a>(shape: &'a [usize], width: usize, name: &str) -> PyResult<&'a [usize]> {
    match shape.split_last() {
        Some((&last, leading)) if last == width => Ok(leading),
        _ => Err(PyValueError::new_err(format!(
            "Expected `{name}` to have shape (..., {width}), got {}.",
            tuple(shape)
        ))),
    }
}

/// What is done to the numbers of points: behind a pointer, for what is around it is much more code.
pub type Work<'a, A, B> = &'a (dyn Fn(&[A], &mut [B]) + Sync);

/// Takes `work` over an array of tuples: (..., width) in, (..., *tail) out.
#[expect(
    clippy::too_many_arguments,
    reason = "what a call needs, each independent"
)]
pub fn points<'py, A: Float, B: Element>(
    py: Python<'py>,
    input: &Points<'py, A>,
    name: &str,
    width: usize,
    out: Option<&Bound<'py, PyAny>>,
    dtype: &str,
    tail: &[usize],
    work: Work<'_, A, B>,
) -> PyResult<Bound<'py, PyAny>> {
    let shape = input.shape();
    let leading = leading(shape, width, name)?;
    // numpy allows 64 axes; two more may be added.
    let mut room = [0; 66];
    let n = leading.len() + tail.len();
    let shape = &mut room[..n];
    shape[..leading.len()].copy_from_slice(leading);
    shape[leading.len()..].copy_from_slice(tail);
    let array = output::<B>(py, out, dtype, shape)?;
    {
        let mut target = writable(&array)?;
        input.each(py, target.as_slice_mut()?, work)?;
    }
    finish(array, out.is_some())
}

/// The rotation that a caller gave.
pub fn rotation(object: Option<&Bound<'_, PyAny>>) -> PyResult<Option<DMat3>> {
    object.map(|object| matrix(object, "rotation")).transpose()
}

/// A rotation from a matrix or an object with `as_matrix`; errors call it `name`.
pub fn matrix(object: &Bound<'_, PyAny>, name: &str) -> PyResult<DMat3> {
    let array = Helper::AsRotation.get(object.py())?.call1((object, name))?;
    let array = array
        .cast::<PyArrayDyn<f64>>()
        .map_err(|_| PyTypeError::new_err(format!("`{name}` is no array")))?;
    let array = array
        .try_readonly()
        .map_err(|e| PyValueError::new_err(e.to_string()))?;
    let rows = array.as_slice()?.as_chunks::<3>().0;
    let rows: [[f64; 3]; 3] = rows
        .try_into()
        .map_err(|_| PyValueError::new_err(format!("Expected `{name}` to have shape (3, 3).")))?;
    axes::rotation(rows).map_err(|error| match error {
        Error::Rotation(why) => PyValueError::new_err(format!("`{name}` is no rotation: {why}")),
        error => error.into(),
    })
}
