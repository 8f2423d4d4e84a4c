//! One image into another: lookups, antialiasing, mip chains, means by solid angle.

pub mod antialias;
pub mod area;
pub mod convert;
pub mod coordinate_map;
pub mod filters;
pub mod footprint;
pub mod lookup;
pub mod mipmapped;
pub mod mips;
pub mod options;
pub mod polynomial;
mod request;
pub mod sample;
pub mod size;
mod weighted;
