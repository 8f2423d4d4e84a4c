//! The registry of languages: one line each.

mod array_api;
mod bits;
mod c;
mod cuda;
mod glsl;
mod glsl_es;
mod hlsl;
mod jax;
mod msl;
mod numpy;
mod opencl;
mod osl;
mod slang;
mod torch;
mod wgsl;

use crate::code::dialect::Dialect;

/// Every language, in the order of tables.
pub const ALL: &[&dyn Dialect] = &[
    &glsl::Glsl,
    &glsl_es::GlslEs,
    &hlsl::Hlsl,
    &slang::Slang,
    &wgsl::Wgsl,
    &msl::Msl,
    &osl::Osl,
    &c::C,
    &cuda::Cuda,
    &opencl::OpenCl,
    &numpy::NumPy,
    &array_api::ArrayApi,
    &torch::Torch,
    &jax::Jax,
];
