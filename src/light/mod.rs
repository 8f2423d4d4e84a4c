//! Light: what is integrated over the sphere.

pub mod dfg;
pub mod distribution;
mod energy;
mod full;
pub(crate) mod integrate;
mod kept;
pub mod lights;
pub(crate) mod lit;
pub(crate) mod lobe;
pub(crate) mod patches;
pub mod prefilter;
pub(crate) mod pyramid;
pub(crate) mod reflect;
pub mod sh;
pub mod sun;
pub(crate) mod survey;
pub(crate) mod texels;

pub use energy::{Energy, energy};
pub use integrate::{Moments, integrate, moments};
pub use lobe::{Lobe, under};
pub use reflect::reflect;
