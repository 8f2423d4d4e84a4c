//! Directions on the unit sphere to flat images and back, at memory speed.
//!
//! A [`Map`] is a projection with everything that a program decides about it: axes, grid, face order, layout. It takes
//! directions to image coordinates and back, says how much of the sphere a texel sees and what lies beyond an edge, for
//! environment maps, light probes, normal maps and 360° images.
//!
//! ```
//! use spheremap::prelude::*;
//!
//! // By name, with the convention of a program behind a colon, or by type.
//! let map = Map::new("latlong:mitsuba")?;
//! let octahedral = Map::from(Octahedral);
//!
//! // One point. Directions have any length; what is none has no place.
//! let (face, uv) = map.encode_one(DVec3::new(0.0, 0.0, 2.0)).expect("a direction");
//! assert_eq!((face, uv), (0, DVec2::new(0.5, 0.5)));
//! assert_eq!(map.encode_one(DVec3::ZERO), None);
//!
//! // Many: slices of numbers, of arrays or of glam's vectors, in f32 or f64.
//! let directions = vec![[0.6_f32, 0.0, 0.8]; 1000];
//! let mut uv = vec![[0.0_f32; 2]; 1000];
//! octahedral.encode(&directions, &mut uv)?;
//!
//! let mut back = vec![[0.0_f32; 3]; 1000];
//! octahedral.decode(&uv, &mut back)?;
//! assert!((back[0][0] - 0.6).abs() < 1e-6);
//! # Ok::<(), spheremap::Error>(())
//! ```
//!
//! # What is where
//!
//! | for | see |
//! |---|---|
//! | directions to image coordinates and back, derivatives, densities | [`Map`] |
//! | the projections, by type and as a list of claims | [`projections`] |
//! | how programs lay out their maps, and what turns one into another | [`conventions`], [`compare`] |
//! | one image into another, look-ups, mipmaps | [`image`], [`resample`] |
//! | irradiance, prefiltering, importance sampling | [`light`], [`light::sh`] |
//! | unit vectors in a few bits | [`pack`] |
//! | pixel numbers of HEALPix | [`healpix`] |
//! | axes and rotations | [`geometry`] |
//! | how many threads, which instructions, stopping a call | [`threads`], [`simd`], [`interrupt`] |
//!
//! # Frames
//!
//! A *direction* is any finite non-zero 3-vector; its length does not matter. The world is right-handed, +y
//! up and -z ahead unless a convention says otherwise; a conversion between two programs keeps up up ([`World`]). Formulas are written in the *view frame* of an image: x to the
//! right, y down, z toward its center. `axes` such as "+x -y -z" name the world axes that point there.
//!
//! # Coordinates
//!
//! (u, v) lie in [0, 1]²: u right along a row, v down from row 0. A map of several faces adds the face's
//! number. Texel (i, j) of a W×H image has its center at ((i + ½)/W, (j + ½)/H), unless the grid says that the
//! outer texels lie on the edges.
//!
//! # Guarantees
//!
//! - Zero, NaN and infinite directions, directions outside the coverage and coordinates outside the valid
//!   image give NaN in every component. Nothing panics on data; slices of wrong lengths are an [`Error`].
//! - Round trips hold 9.5e-7 rad in f32 and 2e-15 in f64 for directions of any length, except where a map itself loses
//!   digits: at the blind spot of the mirror ball (1.2e-3 / 6e-8), at the rim of a MatCap (4.8e-4 / 2.5e-8) and at other rims and
//!   poles. Each map's own bounds are the claim [`Info::round_trip`](projections::Info::round_trip) of the registry.
//! - Every instruction-set level and any number of threads give the same bits.
//! - Texel solid angles sum to the coverage's solid angle.
//!
//! # Features
//!
//! - `rayon` (on by default): large calls run on all cores. Without it, on the caller's thread.
//! - `python`: the module that the Python package `spheremap` is built on. A Rust program has no use for it.
//!
//! [`glam`] and [`half`] are exported, so that a program can use the versions whose types are taken here.

// Essays link to what they speak of, private or not: in `cargo doc --document-private-items` these links lead there.
#![allow(rustdoc::private_intra_doc_links)]
// What the Python face alone asks for. With it, whatever nobody asks for is an error again.
#![cfg_attr(not(feature = "python"), allow(dead_code))]
// The same bits everywhere: no function of the system's math library.
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

pub mod code;
mod error;
pub mod geometry;
pub mod healpix;
pub mod image;
mod kernel;
pub mod light;
mod map;
mod number;
pub mod pack;
pub mod projections;
pub mod resample;

#[cfg(debug_assertions)]
#[doc(hidden)]
pub mod shared;

// Tests of what is public, written as a program that uses the crate. They are compiled into its own tests: beside these, the crate
// would be compiled and optimized once more, for them alone.
#[cfg(test)]
extern crate self as spheremap;
#[cfg(test)]
#[path = "../tests"]
mod public {
    mod face;
    mod fuzzing;
    mod registry;
    mod textures;
}

#[cfg(feature = "python")]
mod py;

pub use error::Error;
pub use geometry::{World, Worlds};
pub use glam;
pub use half;
pub use kernel::Scalar;
pub use map::{Element, Grid, Map, MapOptions, compare, conventions};

/// What a program of a few lines needs: `use spheremap::prelude::*`.
///
/// ```
/// use spheremap::prelude::*;
/// let map = Map::from(Cube);
/// assert_eq!(map.encode_one(DVec3::Y), Some((2, DVec2::new(0.5, 0.5))));
/// ```
pub mod prelude {
    pub use crate::error::Error;
    pub use crate::geometry::{World, Worlds};
    pub use crate::healpix::Pixels;
    pub use crate::image::ImageView;
    pub use crate::map::{Element, Grid, Map, MapOptions};
    pub use crate::pack::Packing;
    pub use crate::projections::Projection;
    pub use crate::projections::types::*;
    pub use crate::resample::{Filter, Options, convert, converted, sample};
    pub use glam::{DMat3, DVec2, DVec3, Vec2, Vec3};
}

/// The instructions that loops are compiled for, chosen at run time; every level gives the same bits.
///
/// ```
/// use spheremap::simd;
/// assert!(simd::levels().contains(&simd::level()));
/// ```
pub mod simd {
    pub use crate::kernel::{force_level, level, levels};
}

/// Calls that can be stopped between two pieces of work, and tell how many of them are done.
///
/// ```
/// use spheremap::{Error, interrupt};
/// assert_eq!(interrupt::stoppable(|_| false, || 7), Ok::<i32, Error>(7));
/// ```
pub mod interrupt {
    pub use crate::kernel::interrupt::{Question, stoppable};
}

/// How many threads large calls use; any number gives the same bits.
///
/// ```
/// use spheremap::threads;
/// threads::set_count(1);
/// assert_eq!(threads::count(), 1);
/// ```
pub mod threads {
    pub use crate::kernel::threads::{count, set_count};
}

/// The code of README.md, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
