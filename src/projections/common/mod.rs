//! What several projections share.

pub mod camera;
pub mod distortion;
pub mod lens;
pub mod tilt;
pub mod warped_cube;
