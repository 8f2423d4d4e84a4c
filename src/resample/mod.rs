//! One image into another: lookups, antialiasing, mip chains, means by solid angle.

pub mod antialias;
pub mod area;
pub mod coordinate_map;
pub mod depth;
pub mod footprint;
pub mod lookup;
pub mod mips;
pub mod pad;
pub mod polynomial;
pub mod sample;
mod seam;
pub mod trilinear;
