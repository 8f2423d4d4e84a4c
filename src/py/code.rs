//! Source text of maps as functions of the module.

use super::projection::PyProjection;
use crate::code::{self as printing, CodeOptions, Verb};
use crate::error::Error;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

/// Verbs of a map in a language.
#[pyfunction]
#[pyo3(signature = (projection, language, /, *, verbs, name, native, double))]
pub fn code(
    projection: &PyProjection,
    language: &str,
    verbs: Vec<String>,
    name: Option<&str>,
    native: bool,
    double: bool,
) -> PyResult<String> {
    let known = |name: &String| {
        let found = Verb::ALL.into_iter().find(|verb| verb.name() == name);
        found.ok_or_else(|| Error::unknown("verb", name, &Verb::ALL.map(Verb::name)))
    };
    let verbs = verbs.iter().map(known).collect::<Result<Vec<_>, _>>()?;
    let options = CodeOptions {
        verbs: &verbs,
        name,
        native,
        double,
    };
    Ok(printing::code(&projection.0, language, &options)?)
}

/// The verbs of `code`.
#[pyfunction]
pub fn code_verbs() -> Vec<&'static str> {
    Verb::ALL.map(Verb::name).to_vec()
}

/// The languages of `code`, each with its title, the ending of its files, and what is promised about bits.
#[pyfunction]
pub fn code_languages(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let list = PyList::empty(py);
    for language in printing::languages() {
        let dict = PyDict::new(py);
        dict.set_item("name", language.name)?;
        dict.set_item("title", language.title)?;
        dict.set_item("extension", language.extension)?;
        dict.set_item("double", language.double)?;
        dict.set_item("promise", language.promise)?;
        list.append(dict)?;
    }
    Ok(list)
}
