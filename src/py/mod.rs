//! The Python face: parse, match the dtype, detach, call. Nothing else happens here.
//!
//! Array types are told apart by looking at the dtype before extracting; an enum of array types derived
//! for extraction tries each in turn and cost 11 µs a call. Arrays that are not C-contiguous float32 or
//! float64 take the friendly path through `spheremap._arrays`.

mod arrays;
mod chains;
mod code;
mod compare;
mod depth;
mod distribution;
mod functions;
mod gradients;
mod healpix;
mod helpers;
mod images;
mod layers;
mod light;
mod lights;
mod lonlat;
mod mip_lookups;
mod pack;
mod pad;
mod planes;
mod projection;
mod sh;
mod sheets;
mod stopping;
mod weighted;

use pyo3::prelude::*;

/// The compiled core of spheremap.
///
/// It needs no lock of the interpreter: its classes are frozen, and what is shared lies behind atomics and mutexes.
#[pymodule(gil_used = false)]
mod _core {
    #[pymodule_export]
    use super::chains::{PyHalving, convert_levels, level_shapes, tiles_of_window};
    #[pymodule_export]
    use super::code::{code, code_languages, code_verbs};
    #[pymodule_export]
    use super::compare::{compare, worlds};
    #[pymodule_export]
    use super::depth::convert_depth;
    #[pymodule_export]
    use super::distribution::PyDistribution;
    #[pymodule_export]
    use super::functions::{
        check_word, convention_table, convert, filters, get_num_threads, matching_size, mipmaps,
        rebuild, reflect, registry, rotation, set_num_threads, set_simd_level, simd_level,
        simd_levels,
    };
    #[pymodule_export]
    use super::gradients::{encode_gradient, sample_adjoint, sample_slopes, sums_of_planes};
    #[pymodule_export]
    use super::healpix::{
        healpix_ang2pix, healpix_arrange, healpix_interpolation, healpix_neighbors,
        healpix_pix2ang, healpix_pix2vec, healpix_reorder, healpix_runs, healpix_vec2pix,
    };
    #[pymodule_export]
    use super::helpers::helpers;
    #[pymodule_export]
    use super::layers::{add_layer, divide_layer};
    #[pymodule_export]
    use super::light::{
        all_finite, dfg, integrals, lobe, luminances, moments, prefilter, texel_weights,
        texels_held,
    };
    #[pymodule_export]
    use super::lights::{add_sun, energy, lights, remove_sun, sun};
    #[pymodule_export]
    use super::lonlat::{directions_to_lonlat, lonlat_to_directions};
    #[pymodule_export]
    use super::mip_lookups::sample_uv;
    #[pymodule_export]
    use super::pack::{PyPacker, pack_frames, packing_table, unpack_frames};
    #[pymodule_export]
    use super::pad::pad;
    #[pymodule_export]
    use super::planes::{planes_of_texels, texels_of_planes};
    #[pymodule_export]
    use super::projection::PyProjection;
    #[pymodule_export]
    use super::sh::{
        sh_code, sh_convention_table, sh_convert, sh_evaluate, sh_lobe, sh_project,
        sh_project_adjoint, sh_rotate, sh_scale_degrees, sh_storage, sh_window,
    };
    #[pymodule_export]
    use super::sheets::{
        add_sheets, energy_from, lit_of, lobe_from, lobe_of, moments_of, sh_from, sh_of, sheets,
        sun_from, survey_of,
    };
    #[pymodule_export]
    use super::stopping::tell_progress;
    #[pymodule_export]
    use super::weighted::{weigh, weighted_mean, weights};

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}

impl From<crate::error::Error> for PyErr {
    fn from(error: crate::error::Error) -> PyErr {
        match error {
            crate::error::Error::Memory { .. } => {
                pyo3::exceptions::PyMemoryError::new_err(error.to_string())
            }
            _ => pyo3::exceptions::PyValueError::new_err(error.to_string()),
        }
    }
}
