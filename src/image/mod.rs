//! Images: texel types, where each texel is stored, and what part of the sphere it stands for.

pub mod raster;
pub mod rim;
pub mod texel;
pub mod texels;
pub(crate) mod view;

pub use view::ImageView;
