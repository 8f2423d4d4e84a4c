//! Packed unit vectors: codes of any unsigned dtype.

use super::helpers::Helper;
use super::stopping::stoppable;
use crate::error::Error;
use crate::pack;
use crate::pack::frame::FramePacking;
use crate::pack::{Invalid, Packing, Rounding, Store};
use crate::py::arrays;
use crate::py::arrays::{
    Float, contiguous, converted, disjoint, finish, output, reals, with_reals, writable,
};
use numpy::{Element, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

/// A float type that both numpy arrays and schemes know.
pub trait Number: Float + pack::Real {}
impl Number for f32 {}
impl Number for f64 {}

/// An integer type that both numpy arrays and schemes know.
pub trait Word: Store + Element {
    /// numpy's name for it.
    const NAME: &'static str;
}
impl Word for u8 {
    const NAME: &'static str = "uint8";
}
impl Word for u16 {
    const NAME: &'static str = "uint16";
}
impl Word for u32 {
    const NAME: &'static str = "uint32";
}
impl Word for u64 {
    const NAME: &'static str = "uint64";
}

/// Runs the body with W as the type that codes of this packing are stored in.
macro_rules! with_word {
    ($packing:expr, $w:ident => $body:expr) => {
        match $packing.stored_bits() {
            8 => {
                type $w = u8;
                $body
            }
            16 => {
                type $w = u16;
                $body
            }
            32 => {
                type $w = u32;
                $body
            }
            _ => {
                type $w = u64;
                $body
            }
        }
    };
}

/// A scheme of packing unit vectors, resolved once.
#[pyclass(name = "Packer", module = "spheremap._core", frozen)]
pub struct PyPacker(Packing);

fn rounding_name(rounding: Rounding) -> &'static str {
    match rounding {
        Rounding::Nearest => "nearest",
        Rounding::Precise => "precise",
        Rounding::Hex => "hex",
    }
}

/// How the caller wants a direction rounded; a scheme with one way takes the default for it.
fn rounding(packing: &Packing, name: &str) -> PyResult<Rounding> {
    let known = packing.family.roundings;
    if let Some(found) = known.iter().find(|r| rounding_name(**r) == name) {
        return Ok(*found);
    }
    if name == "precise"
        && let [only] = known
    {
        return Ok(*only);
    }
    let names: Vec<String> = known
        .iter()
        .map(|r| format!("'{}'", rounding_name(*r)))
        .collect();
    Err(PyValueError::new_err(format!(
        "Expected `rounding` of '{}' to be {}, got '{name}'.",
        packing.name,
        names.join(" or ")
    )))
}

fn pack_points<'py, T: Number, W: Word>(
    py: Python<'py>,
    packing: &Packing,
    rounding: Rounding,
    invalid: Invalid,
    input: &arrays::Points<'py, T>,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let shape = arrays::leading(input.shape(), 3, "directions")?;
    let array = output::<W>(py, out, W::NAME, shape)?;
    let mut first = None;
    {
        use std::sync::atomic::{AtomicUsize, Ordering};
        let bad = AtomicUsize::new(usize::MAX);
        let done = AtomicUsize::new(0);
        let mut target = writable(&array)?;
        // Blocks come one after another, on this thread.
        input.each(py, target.as_slice_mut()?, &|d: &[T], codes: &mut [W]| {
            let before = done.fetch_add(codes.len(), Ordering::Relaxed);
            if let Ok(Some(k)) = packing.pack(rounding, invalid, d, codes) {
                bad.fetch_min(before + k, Ordering::Relaxed);
            }
        })?;
        let bad = bad.into_inner();
        if bad != usize::MAX {
            first = Some(bad);
        }
    }
    if let Some(k) = first {
        let place = Helper::IndexText.get(py)?.call1((k, shape.to_vec()))?;
        let what = if packing.family.hemisphere {
            "zero, not finite or below the hemisphere z >= 0"
        } else {
            "zero or not finite"
        };
        return Err(PyValueError::new_err(format!(
            "`directions`{place} is {what}; `invalid` can be \"zero\" or \"ignore\"."
        )));
    }
    finish(array, out.is_some())
}

fn codes_of<'py, W: Word>(
    codes: &Bound<'py, PyAny>,
) -> PyResult<numpy::PyReadonlyArrayDyn<'py, W>> {
    match contiguous::<W>(codes)? {
        Some(array) => Ok(array),
        None => converted(codes),
    }
}

fn check_range<W: Word>(
    packing: &Packing,
    codes: &[W],
    shape: &[usize],
    py: Python<'_>,
) -> PyResult<()> {
    match packing.first_out_of_range(codes) {
        None => Ok(()),
        Some(k) => {
            let place = Helper::IndexText.get(py)?.call1((k, shape.to_vec()))?;
            Err(PyValueError::new_err(format!(
                "Expected `codes` of '{}' to be in [0, {}], got {} at `codes`{place}.",
                packing.name,
                packing.codes().wrapping_sub(1),
                codes[k].word()
            )))
        }
    }
}

fn unpack_codes<'py, T: Number, W: Word>(
    py: Python<'py>,
    packing: &Packing,
    codes: &Bound<'py, PyAny>,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let input = codes_of::<W>(codes)?;
    check_range(packing, input.as_slice()?, input.shape(), py)?;
    let mut shape = input.shape().to_vec();
    shape.push(3);
    let array = output::<T>(py, out, T::NAME, &shape)?;
    {
        let mut target = writable(&array)?;
        let d = target.as_slice_mut()?;
        let codes = input.as_slice()?;
        disjoint(codes, d)?;
        arrays::run(py, d.len(), || packing.unpack(codes, d))??;
    }
    finish(array, out.is_some())
}

#[pymethods]
impl PyPacker {
    #[new]
    #[pyo3(signature = (name, /))]
    fn new(name: &str) -> PyResult<Self> {
        Ok(PyPacker(Packing::new(name)?))
    }

    /// What the scheme claims about itself.
    fn about<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let p = &self.0;
        let bounds = PyDict::new(py);
        for &rounding in p.family.roundings {
            bounds.set_item(rounding_name(rounding), p.bound(rounding))?;
        }
        let dict = PyDict::new(py);
        dict.set_item("name", &p.name)?;
        dict.set_item("family", p.family.name)?;
        dict.set_item("title", p.family.title)?;
        dict.set_item("source", p.family.source)?;
        dict.set_item("summary", p.family.summary)?;
        dict.set_item("bits", p.bits)?;
        dict.set_item("variant", p.variant)?;
        dict.set_item(
            "codes",
            if p.codes() == 0 {
                1_u128 << 64
            } else {
                u128::from(p.codes())
            },
        )?;
        dict.set_item("stored_bits", p.stored_bits())?;
        dict.set_item("fields", p.fields)?;
        dict.set_item("signed", p.signed())?;
        dict.set_item("hemisphere", p.family.hemisphere)?;
        dict.set_item("exact", p.family.exact)?;
        dict.set_item("standard", p.family.standard)?;
        dict.set_item("slow", p.family.slow)?;
        dict.set_item("bounds", bounds)?;
        Ok(dict)
    }

    /// Codes of directions, one word each.
    #[pyo3(signature = (directions, /, rounding, invalid, out=None))]
    fn pack<'py>(
        &self,
        py: Python<'py>,
        directions: &Bound<'py, PyAny>,
        rounding: &str,
        invalid: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let rounding = self::rounding(&self.0, rounding)?;
        let invalid = match invalid {
            "raise" => Invalid::Raise,
            "zero" => Invalid::Zero,
            "ignore" => Invalid::Ignore,
            _ => {
                return Err(PyValueError::new_err(format!(
                    "Expected `invalid` to be 'raise', 'zero' or 'ignore', got '{invalid}'."
                )));
            }
        };
        let reals = reals(directions, "directions", out)?;
        with_reals!(&reals, d => {
            with_word!(self.0, W => pack_points::<_, W>(py, &self.0, rounding, invalid, d, out))
        })
    }

    /// Directions of codes, one word each, of the dtype that the scheme stores.
    #[pyo3(signature = (codes, /, single, out=None))]
    fn unpack<'py>(
        &self,
        py: Python<'py>,
        codes: &Bound<'py, PyAny>,
        single: bool,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        with_word!(self.0, W => if single {
            unpack_codes::<f32, W>(py, &self.0, codes, out)
        } else {
            unpack_codes::<f64, W>(py, &self.0, codes, out)
        })
    }

    /// Functions of the scheme as source text of a language.
    #[pyo3(signature = (language, /, *, verbs, rounding, name, native, double))]
    fn code(
        &self,
        language: &str,
        verbs: Vec<String>,
        rounding: &str,
        name: Option<&str>,
        native: bool,
        double: bool,
    ) -> PyResult<String> {
        let known = |name: &String| {
            let found = pack::Verb::ALL.into_iter().find(|verb| verb.name() == name);
            found
                .ok_or_else(|| Error::unknown("verb", name, &pack::Verb::ALL.map(pack::Verb::name)))
        };
        let verbs = verbs.iter().map(known).collect::<Result<Vec<_>, _>>()?;
        let options = pack::CodeOptions {
            verbs: &verbs,
            rounding: self::rounding(&self.0, rounding)?,
            name,
            native,
            double,
        };
        Ok(self.0.code(language, &options)?)
    }

    /// One code for each direction.
    #[pyo3(signature = (codes, /))]
    fn canonical<'py>(
        &self,
        py: Python<'py>,
        codes: &Bound<'py, PyUntypedArray>,
    ) -> PyResult<Bound<'py, PyAny>> {
        with_word!(self.0, W => {
            let input = codes_of::<W>(codes.as_any())?;
            check_range(&self.0, input.as_slice()?, input.shape(), py)?;
            let array = output::<W>(py, None, W::NAME, input.shape())?;
            {
                let mut target = writable(&array)?;
                let (codes, out) = (input.as_slice()?, target.as_slice_mut()?);
                arrays::run(py, out.len(), || self.0.canonical(codes, out))??;
            }
            // Always an array: the caller may look at its fields.
            Ok(array.into_any())
        })
    }
}

/// The names of all schemes with their family, bits and variant.
#[pyfunction]
pub fn packing_table(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let list = PyList::empty(py);
    for (name, family, bits, variant, fields) in pack::names() {
        list.append((name, family.name, bits, variant, fields))?;
    }
    Ok(list)
}

/// Codes of frames: contiguous float64 normals (..., 3) and tangents (..., 4); and the first that has none.
#[pyfunction]
#[pyo3(signature = (normals, tangents, name, /))]
pub fn pack_frames<'py>(
    py: Python<'py>,
    normals: numpy::PyReadonlyArrayDyn<'py, f64>,
    tangents: numpy::PyReadonlyArrayDyn<'py, f64>,
    name: &str,
) -> PyResult<(Bound<'py, PyAny>, Option<usize>)> {
    let packing = FramePacking::new(name)?;
    let shape = arrays::leading(normals.shape(), 3, "normals")?;
    if arrays::leading(tangents.shape(), 4, "tangents")? != shape {
        return Err(PyValueError::new_err(
            "normals and tangents differ in shape",
        ));
    }
    let array = output::<u64>(py, None, "uint64", shape)?;
    let first = {
        let mut target = writable(&array)?;
        let (normals, tangents) = (normals.as_slice()?, tangents.as_slice()?);
        let codes = target.as_slice_mut()?;
        stoppable(py, || packing.pack(normals, tangents, codes))?
    };
    Ok((array.into_any(), first))
}

/// Seven numbers of each code, contiguous uint64: the normal, the tangent and the bitangent's sign.
#[pyfunction]
#[pyo3(signature = (codes, name, /))]
pub fn unpack_frames<'py>(
    py: Python<'py>,
    codes: numpy::PyReadonlyArrayDyn<'py, u64>,
    name: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let packing = FramePacking::new(name)?;
    let mut shape = codes.shape().to_vec();
    shape.push(7);
    let array = output::<f64>(py, None, "float64", &shape)?;
    {
        let mut target = writable(&array)?;
        let (codes, out) = (codes.as_slice()?, target.as_slice_mut()?);
        stoppable(py, || packing.unpack(codes, out))?;
    }
    Ok(array.into_any())
}
