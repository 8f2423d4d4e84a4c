//! Light: what is integrated over the sphere.

pub mod distribution;
pub mod rim;
pub mod solid_angle;
