//! Lookups with a footprint, in one level of a mip chain.
//!
//! Texels of an ellipse may lie beyond an edge; each is then what the seam says.

use super::in_level::{InLevel, InTexture};
use super::taps::Taps;
use super::texture::Texture;
use crate::image::texel::Texel;
use crate::kernel::Scalar;
use crate::kernel::tile::prefetch_item;

/// A level whose texels can be averaged.
pub(crate) trait Level: Sync {
    /// The elliptical weighted average at a place of a face. `sides` are the two sides of the footprint, in texels of this
    /// level.
    fn ellipse(&self, face: usize, uv: [f64; 2], sides: [[f64; 2]; 2], out: &mut [f64]);

    /// Asks for the memory of the texels around a place, so many of this level's rows up and down.
    fn ask(&self, _face: usize, _uv: [f64; 2], _rows: f64) {}
}

/// A level that is looked up place by place.
pub(crate) trait ByPlace: Level {
    /// The bilinear value at a place of a face.
    fn bilinear(&self, face: usize, uv: [f64; 2], out: &mut [f64]);
}

/// A level that is looked up tile by tile, by filters that compute in F.
pub(crate) trait ByTile<F>: Level {
    /// Lookups of one thread.
    fn lookups(&self) -> Box<dyn InLevel<F> + '_>;
}

/// Rows that are asked for, at most: while the first ones of a larger footprint are added up, others come.
const MOST_ROWS: usize = 8;

impl<T: Texel> Level for Texture<'_, T> {
    fn ellipse(&self, face: usize, uv: [f64; 2], sides: [[f64; 2]; 2], out: &mut [f64]) {
        let mut taps = Taps::new();
        super::ellipse::each(self.place(uv), sides, |i, j, weight| {
            if self.raster.holds(i, j) {
                taps.push(self.raster.view(face).index(i as usize, j as usize), weight);
            } else {
                self.beyond(&mut taps, face, i, j, weight);
            }
        });
        self.mean(&taps, out);
    }

    fn ask(&self, face: usize, uv: [f64; 2], rows: f64) {
        let [x, y] = self.place(uv);
        let raster = &self.raster;
        let view = raster.view(face);
        // `as` takes negative numbers to 0.
        let column = (x as usize).min(raster.width - 1);
        let [first, last] = [y - rows, y + rows + 1.0].map(|y| (y as usize).min(raster.height - 1));
        for j in (first..=last).take(MOST_ROWS) {
            let at = view.index(column, j) * self.channels;
            prefetch_item(self.texels, at);
            // A pair lies on two lines now and then.
            prefetch_item(self.texels, at + 2 * self.channels - 1);
        }
    }
}

impl<T: Texel> ByTile<T::Float> for Texture<'_, T> {
    fn lookups(&self) -> Box<dyn InLevel<T::Float> + '_> {
        Box::new(InTexture::new(self))
    }
}

impl<T: Texel> Texture<'_, T> {
    /// The mean of texels by their weights.
    fn mean(&self, taps: &Taps, out: &mut [f64]) {
        let list = taps.list();
        let all: f64 = list.iter().map(|(_, weight)| weight).sum();
        let base = list.first().map_or(0, |(index, _)| *index);
        for (c, out) in out.iter_mut().enumerate() {
            let value = |index: usize| self.texels[index * self.channels + c].load().to_f64();
            let base = value(base);
            let sum: f64 = (list.iter())
                .map(|(index, weight)| weight * (value(*index) - base))
                .sum();
            *out = base + sum / all;
        }
    }
}
