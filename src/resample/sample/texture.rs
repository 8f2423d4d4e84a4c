//! An image as lookups need it.

use super::continuations::Continuations;
use super::place::Support;
use crate::image::raster::Raster;
use crate::image::texel::Texel;
use crate::image::view::ImageView;
use crate::map::Map;
use crate::projections::projection::{Outline, Seam};

/// An image that can be looked up: it knows what lies beyond its edges.
pub(crate) struct Texture<'a, T> {
    pub(crate) map: &'a Map,
    pub(crate) raster: Raster,
    pub(crate) texels: &'a [T],
    pub(crate) channels: usize,
    pub(crate) seam: Seam,
    pub(crate) continuations: Continuations,
}

impl<'a, T: Texel> Texture<'a, T> {
    pub(crate) fn new(image: &ImageView<'a, T>) -> Self {
        Texture {
            texels: image.texels(),
            ..Texture::geometry(image.map(), image.raster(), image.channels())
        }
    }

    /// An image without its texels: what lies where.
    pub(crate) fn geometry(map: &'a Map, raster: &Raster, channels: usize) -> Self {
        Texture {
            map,
            raster: *raster,
            texels: &[],
            channels,
            seam: map.seam(),
            continuations: Continuations::default(),
        }
    }

    /// Within this distance from a disk's center all texels that a filter reaches are valid.
    pub(crate) fn safe(&self, reach: Support) -> f64 {
        if self.raster.outline != Outline::Disk {
            return f64::INFINITY;
        }
        let spacing = 2.0
            / (self
                .raster
                .along_u
                .index()
                .0
                .min(self.raster.along_v.index().0));
        let texels = reach.shift.max(reach.after as f64);
        (1.0 - std::f64::consts::SQRT_2 * texels * spacing).max(0.0)
    }
}
