//! Light: what is integrated over the sphere.

pub mod solid_angle;
