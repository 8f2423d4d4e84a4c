//! Looking directions up in an image.
//!
//! Directions become image coordinates, these become texels and fractions (`place`), and windows of texels
//! are read and weighted (`gather`): block by block, each step a plain loop. Nearly every lookup has its
//! window inside one face. The others meet an edge, and what lies beyond is the projection's
//! [`Seam`]: `border` resolves it, in f64, into stored texels with weights that sum to 1, texel by texel of
//! the window (`surroundings`), and a result is base + Σ w (texel - base): a constant image stays constant to the
//! bit, here as on the short way.
//!
//! Texels whose center lies outside the valid image (the corners around a disk, where photographers
//! print their credits; the empty cells of a cross) never take part.
//!
//! What did not help: continuing the image by its nearest texels (an error of first order at every seam), and a
//! padded copy of the source (a copy a call, for the few lookups that need it).

mod adjoint;
mod border;
mod continuations;
mod corners;
mod edges;
pub(crate) mod ellipse;
mod gather;
mod in_level;
mod level;
mod look;
mod lookups;
mod mean;
mod ones;
mod pairs;
mod parallelograms;
mod place;
mod rectangle;
mod runs;
mod sampler;
mod seen;
mod shapes;
pub(crate) mod slices;
mod spread;
mod surroundings;
mod taps;
mod texture;
mod weights;
mod wide;

pub use adjoint::{sample_adjoint, sample_slopes};
pub(crate) use in_level::{Held, InLevel};
pub(crate) use level::{ByPlace, ByTile, Level};
pub(crate) use lookups::Lookups;
pub(crate) use mean::Rooms;
pub(crate) use parallelograms::{Parallelograms, TOGETHER, any_several};
pub(crate) use rectangle::Rectangle;
pub(crate) use runs::{Runs, Sight};
pub use sampler::Sampler;
pub(crate) use seen::{Seen, Watched};
pub(crate) use shapes::SEVERAL;
pub(crate) use spread::{LANES, MOST, Spread, Spreads, count, division, spread};
pub(crate) use texture::Texture;
