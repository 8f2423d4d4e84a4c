//! What several projections share.

pub mod lens;
pub mod warped_cube;
