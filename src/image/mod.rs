//! Images: texel types, where each texel is stored, and what part of the sphere it stands for.

pub(crate) mod finite;
mod halves;
pub(crate) mod pieces;
pub(crate) mod planes;
pub(crate) mod raster;
pub(crate) mod rim;
pub(crate) mod texel;
pub(crate) mod texels;
pub(crate) mod view;

pub use raster::shape_of_size;
pub use rim::weights;
pub use texel::Texel;
pub use texels::{directions, solid_angles};
pub use view::ImageView;
