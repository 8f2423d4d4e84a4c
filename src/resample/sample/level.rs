//! Lookups with a footprint, in one level of a mip chain.
//!
//! The elliptical weighted average is Heckbert's (Fundamentals of Texture Mapping and Image Warping, 1989): a Gaussian over
//! the ellipse that the target texel's circle becomes, and one texel wider for the reconstruction. Here its
//! texels may lie beyond an edge; each is then what the seam says. The Gaussian e^(-2r²), cut at r = 1, is
//! lowered to end at 0.

use super::taps::Taps;
use super::texture::Texture;
use crate::image::texel::Texel;
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
        let mut taps = Taps::new();
        self.resolve(&mut taps, face, uv, 1.0);
        self.mean(&taps, out);
    }

    fn ellipse(&self, face: usize, uv: [f64; 2], sides: [[f64; 2]; 2], out: &mut [f64]) {
        let [[ax, ay], [bx, by]] = sides;
        // p xx + q xy + r yy = 1 on the ellipse with these conjugate radii, widened by a texel.
        let (p, q, r) = (
            ay * ay + by * by + 1.0,
            -2.0 * (ax * ay + bx * by),
            ax * ax + bx * bx + 1.0,
        );
        let area = p * r - 0.25 * q * q;
        let (p, q, r) = (p / area, q / area, r / area);
        let determinant = p * r - 0.25 * q * q;
        let (wide, high) = ((r / determinant).sqrt(), (p / determinant).sqrt());
        let [x, y] = self.place(uv);
        let mut taps = Taps::new();
        for j in (y - high).ceil() as isize..=(y + high).floor() as isize {
            for i in (x - wide).ceil() as isize..=(x + wide).floor() as isize {
                let (dx, dy) = (i as f64 - x, j as f64 - y);
                let rr = p * dx * dx + q * dx * dy + r * dy * dy;
                if rr < 1.0 {
                    let weight = gaussian(rr);
                    if self.raster.holds(i, j) {
                        taps.push(self.raster.view(face).index(i as usize, j as usize), weight);
                    } else {
                        self.beyond(&mut taps, face, i, j, weight);
                    }
                }
            }
        }
        self.mean(&taps, out);
    }
}

/// e^(-2x) - e^(-2) for x from 0 to 1: the tenth partial sum of e^(-x/2), to the fourth power, off by 1e-9.
fn gaussian(x: f64) -> f64 {
    let y = -0.5 * x;
    let mut sum = 1.0;
    for k in (1..10).rev() {
        sum = 1.0 + sum * y / f64::from(k);
    }
    let squared = sum * sum;
    squared * squared - 0.135_335_283_236_612_7
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
