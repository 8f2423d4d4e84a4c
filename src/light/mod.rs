//! Light: what is integrated over the sphere.

pub mod dfg;
pub mod distribution;
pub mod energy;
pub mod integrate;
pub mod lights;
pub mod lit;
pub mod lobe;
pub mod prefilter;
pub mod pyramid;
pub mod reflect;
pub mod sh;
pub mod sun;
pub mod texels;
