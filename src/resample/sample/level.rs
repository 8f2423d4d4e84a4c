//! Lookups with a footprint, in one level of a mip chain.
//!
//! Texels of an ellipse may lie beyond an edge; each is then what the seam says.

use super::taps::Taps;
use super::texture::Texture;
use crate::image::texel::Texel;
use crate::kernel::Scalar;
use crate::number::real::Real;

/// A level that can be looked up.
pub(crate) trait Level: Sync {
    /// The bilinear value at a place of a face.
    fn bilinear(&self, face: usize, uv: [f64; 2], out: &mut [f64]);

    /// The elliptical weighted average at a place. `sides` are the two sides of the footprint, in texels of this
    /// level.
    fn ellipse(&self, face: usize, uv: [f64; 2], sides: [[f64; 2]; 2], out: &mut [f64]);
}

impl<T: Texel> Level for Texture<'_, T> {
    fn bilinear(&self, face: usize, uv: [f64; 2], out: &mut [f64]) {
        if !self.bilinear_inside(face, uv, out) {
            let mut taps = Taps::new();
            self.resolve(&mut taps, face, uv, 1.0);
            self.mean(&taps, out);
        }
    }

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
}

impl<T: Texel> Texture<'_, T> {
    /// The numbers of a texel.
    fn texel(&self, index: usize) -> &[T] {
        &self.texels[index * self.channels..][..self.channels]
    }

    /// A bilinear value all of whose texels are inside, as most are: a list of them would be an allocation. Else false, and also
    /// where one of them counts for nothing, for it may be no number.
    fn bilinear_inside(&self, face: usize, uv: [f64; 2], out: &mut [f64]) -> bool {
        let [x, y] = self.place(uv);
        let (left, top) = (Real::floor(x), Real::floor(y));
        let (tx, ty) = (x - left, y - top);
        let (i, j) = (left as isize, top as isize);
        let corners = [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)];
        if tx == 0.0 || ty == 0.0 || !corners.iter().all(|(i, j)| self.raster.holds(*i, *j)) {
            return false;
        }
        let view = self.raster.view(face);
        let [a, b, c, d] = corners.map(|(i, j)| self.texel(view.index(i as usize, j as usize)));
        let shares = [tx * (1.0 - ty), (1.0 - tx) * ty, tx * ty];
        for (k, out) in out.iter_mut().enumerate() {
            let [base, b, c, d] = [a[k], b[k], c[k], d[k]].map(|x| x.load().to_f64());
            let sum = shares[0] * (b - base) + shares[1] * (c - base) + shares[2] * (d - base);
            *out = base + sum;
        }
        true
    }

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
