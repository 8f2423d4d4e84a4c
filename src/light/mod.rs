//! Light: what is integrated over the sphere.

pub mod distribution;
pub mod rim;
pub mod dfg;
pub mod integrate;
pub mod lobe;
pub mod prefilter;
pub mod pyramid;
pub mod sh;
pub mod solid_angle;
pub mod texels;
