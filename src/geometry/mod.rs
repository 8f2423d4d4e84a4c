//! Vectors, frames and areas on the sphere, in f64. Nothing here knows an image or a map.

pub mod axes;
pub mod solid_angle;
pub mod vector;
