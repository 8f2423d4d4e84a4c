//! Lookups with a footprint, in one level of a mip chain.
//!
//! Texels of an ellipse may lie beyond an edge; each is then what the seam says.

use super::taps::Taps;
use super::texture::Texture;
use crate::image::texel::Texel;
use crate::kernel::Scalar;
use crate::kernel::tile::prefetch_item;
use crate::number::real::Real;

/// A level that can be looked up.
pub(crate) trait Level: Sync {
    /// The bilinear value at a place of a face.
    fn bilinear(&self, face: usize, uv: [f64; 2], out: &mut [f64]);

    /// The elliptical weighted average at a place. `sides` are the two sides of the footprint, in texels of this
    /// level.
    fn ellipse(&self, face: usize, uv: [f64; 2], sides: [[f64; 2]; 2], out: &mut [f64]);

    /// Asks for the memory of the texels around a place, so many of this level's rows up and down.
    fn ask(&self, _face: usize, _uv: [f64; 2], _rows: f64) {}
}

/// Rows that are asked for, at most: while the first ones of a larger footprint are added up, others come.
const MOST_ROWS: usize = 8;

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
        let raster = &self.raster;
        // One by one: a closure over an array of them is a call.
        let held = raster.holds(i, j)
            && raster.holds(i + 1, j)
            && raster.holds(i, j + 1)
            && raster.holds(i + 1, j + 1);
        if tx == 0.0 || ty == 0.0 || !held {
            return false;
        }
        let view = raster.view(face);
        let [right, down] = view.steps();
        let first = view.index(i as usize, j as usize);
        let (next, below) = (
            first.wrapping_add_signed(right),
            first.wrapping_add_signed(down),
        );
        let four = [first, next, below, below.wrapping_add_signed(right)];
        let shares = [tx * (1.0 - ty), (1.0 - tx) * ty, tx * ty];
        match self.channels {
            1 => self.mix_of::<1>(four, shares, out),
            3 => self.mix_of::<3>(four, shares, out),
            4 => self.mix_of::<4>(four, shares, out),
            _ => {
                let [a, b, c, d] = four.map(|index| self.texel(index));
                for (k, out) in out.iter_mut().enumerate() {
                    *out = mix([a[k], b[k], c[k], d[k]], shares);
                }
            }
        }
        true
    }

    /// The mix of four texels of C numbers.
    #[inline(always)]
    fn mix_of<const C: usize>(&self, four: [usize; 4], shares: [f64; 3], out: &mut [f64]) {
        let (texels, _) = self.texels.as_chunks::<C>();
        let [a, b, c, d] = four;
        let (a, b, c, d) = (texels[a], texels[b], texels[c], texels[d]);
        for (k, out) in out[..C].iter_mut().enumerate() {
            *out = mix([a[k], b[k], c[k], d[k]], shares);
        }
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

/// The mix of four numbers, of the last three by their shares.
#[inline(always)]
fn mix<T: Texel>(four: [T; 4], [b, c, d]: [f64; 3]) -> f64 {
    let number = |x: T| x.load().to_f64();
    let base = number(four[0]);
    base + (b * (number(four[1]) - base)
        + c * (number(four[2]) - base)
        + d * (number(four[3]) - base))
}
