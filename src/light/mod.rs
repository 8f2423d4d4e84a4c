//! Light: what is integrated over the sphere.

pub mod dfg;
pub mod distribution;
pub(crate) mod integrate;
pub(crate) mod lobe;
pub mod prefilter;
pub(crate) mod pyramid;
pub(crate) mod reflect;
pub mod sh;
pub(crate) mod texels;

pub use integrate::integrate;
pub use lobe::{Lobe, under};
pub use reflect::reflect;
