//! What the core asks of Python: the functions of `spheremap._arrays`, by name, and nothing else.
//!
//! Arrays that are not C-contiguous and of a native dtype take this way. A test looks each name up.

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyModule;

/// A function of `spheremap._arrays`.
#[derive(Clone, Copy)]
pub enum Helper {
    AsImage,
    AsIntegers,
    AsLevels,
    AsLookups,
    AsPair,
    AsPoints,
    AsRotation,
    Blocks,
    IndexText,
    LookupBlocks,
    PairedBlocks,
}

impl Helper {
    const ALL: [Helper; 11] = [
        Helper::AsImage,
        Helper::AsIntegers,
        Helper::AsLevels,
        Helper::AsLookups,
        Helper::AsPair,
        Helper::AsPoints,
        Helper::AsRotation,
        Helper::Blocks,
        Helper::IndexText,
        Helper::LookupBlocks,
        Helper::PairedBlocks,
    ];

    fn name(self) -> &'static str {
        match self {
            Helper::AsImage => "as_image",
            Helper::AsIntegers => "as_integers",
            Helper::AsLevels => "as_levels",
            Helper::AsLookups => "as_lookups",
            Helper::AsPair => "as_pair",
            Helper::AsPoints => "as_points",
            Helper::AsRotation => "as_rotation",
            Helper::Blocks => "blocks",
            Helper::IndexText => "index_text",
            Helper::LookupBlocks => "lookup_blocks",
            Helper::PairedBlocks => "paired_blocks",
        }
    }

    /// The function itself.
    pub fn get(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        static MODULE: PyOnceLock<Py<PyModule>> = PyOnceLock::new();
        let module = MODULE.get_or_try_init(py, || {
            PyModule::import(py, "spheremap._arrays").map(Bound::unbind)
        })?;
        module.bind(py).getattr(self.name())
    }
}

/// The functions of `spheremap._arrays` that the core calls.
#[pyfunction]
pub fn helpers() -> Vec<&'static str> {
    Helper::ALL.map(Helper::name).to_vec()
}
