//! Comparing maps as a function of the module.

use super::projection::PyProjection;
use crate::map::compare as comparing;
use pyo3::prelude::*;

/// The rows of the signed permutation between two maps, if one serves all faces, whether it mirrors, and everything that
/// differs in words.
#[pyfunction]
#[pyo3(signature = (a, b, /))]
#[expect(clippy::type_complexity, reason = "three results")]
pub fn compare(
    a: &PyProjection,
    b: &PyProjection,
) -> PyResult<(Option<[[i8; 3]; 3]>, Option<bool>, Vec<String>)> {
    let found = comparing::compare(&a.0, &b.0)?;
    Ok((found.matrix, found.mirrored(), found.differences))
}

/// What a conversion that matches worlds does with directions, in words, where the worlds differ.
#[pyfunction]
#[pyo3(signature = (src, dst, /))]
pub fn worlds(src: &PyProjection, dst: &PyProjection) -> Option<String> {
    comparing::worlds(&src.0, &dst.0)
}
