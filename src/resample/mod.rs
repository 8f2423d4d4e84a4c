//! One image into another: lookups, antialiasing, mip chains, means by solid angle.
//!
//! [`convert`] is the way from one image to another, [`sample`] that from directions to values; [`Options`] say how,
//! and [`filters`] is the table of what an option `filter` may be.

mod antialias;
mod area;
pub(crate) mod convert;
mod coordinate_map;
pub mod depth;
pub mod filters;
pub mod flat;
mod footprint;
pub(crate) mod halving;
pub(crate) mod layers;
mod level_lookups;
mod levels;
pub(crate) mod lod;
mod lookup;
mod mip_sampler;
pub(crate) mod mipmapped;
pub(crate) mod mips;
mod options;
mod pad;
mod polynomial;
mod request;
mod sample;
mod seam;
mod size;
mod sums;
mod trilinear;
pub(crate) mod weighted;
mod window;

pub(crate) use area::convert_light;
pub use convert::{convert, converted, sample};
pub use filters::Filter;
pub use mip_sampler::{Detail, MipSampler};
pub use mips::{Level, chain};
pub use options::{Fill, Options};
pub use pad::{pad, padded_shape};
pub(crate) use request::Request;
pub use sample::{Sampler, sample_adjoint, sample_slopes};
pub use size::matching_size;
pub use sums::sums_of_planes;
pub use window::Window;
