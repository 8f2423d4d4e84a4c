//! Vectors, frames and areas on the sphere, in f64. Nothing here knows an image or a map.

pub(crate) mod axes;
pub(crate) mod mirror;
pub(crate) mod solid_angle;
pub(crate) mod vector;
pub(crate) mod world;

pub use axes::{Axes, from_angles, rotation, rows};
pub use solid_angle::Rect;
pub use world::{World, Worlds};
