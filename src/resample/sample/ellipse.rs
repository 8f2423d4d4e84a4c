//! The texels of an ellipse, and their weights.
//!
//! The elliptical weighted average is Heckbert's (Fundamentals of Texture Mapping and Image Warping, 1989): a Gaussian over
//! the ellipse that the target texel's circle becomes, and one texel wider for the reconstruction. The Gaussian e^(-2r²), cut at
//! r = 1, is lowered to end at 0.

use crate::kernel::vectorize;
use crate::number::math::polynomial;
use std::ops::RangeInclusive;

/// p xx + q xy + r yy = 1 on the ellipse, which reaches so far along x and y.
struct Form {
    p: f64,
    q: f64,
    r: f64,
    reach: [f64; 2],
}

impl Form {
    /// Of the ellipse with these conjugate radii, widened by a texel.
    fn of([[ax, ay], [bx, by]]: [[f64; 2]; 2]) -> Form {
        let (p, q, r) = (
            ay * ay + by * by + 1.0,
            -2.0 * (ax * ay + bx * by),
            ax * ax + bx * bx + 1.0,
        );
        let area = p * r - 0.25 * q * q;
        let (p, q, r) = (p / area, q / area, r / area);
        let determinant = p * r - 0.25 * q * q;
        let reach = [(r / determinant).sqrt(), (p / determinant).sqrt()];
        Form { p, q, r, reach }
    }

    /// The columns and rows of the rectangle around it, about a place.
    fn texels(&self, place: [f64; 2]) -> [RangeInclusive<isize>; 2] {
        [0, 1].map(|axis| {
            let (x, reach) = (place[axis], self.reach[axis]);
            (x - reach).ceil() as isize..=(x + reach).floor() as isize
        })
    }
}

/// The columns and rows of the rectangle in which [`each`] finds texels.
pub(crate) fn texels(place: [f64; 2], sides: [[f64; 2]; 2]) -> [RangeInclusive<isize>; 2] {
    Form::of(sides).texels(place)
}

/// Texels whose weights are found together.
const TOGETHER: usize = 32;

/// Texels of a rectangle: their columns and rows, how far they are from the place, and their weights where they lie in the ellipse.
struct Batch {
    texels: [(isize, isize); TOGETHER],
    off: [[f64; TOGETHER]; 2],
    squares: [f64; TOGETHER],
    weights: [f64; TOGETHER],
    count: usize,
}

impl Batch {
    /// Finds the weights of those that are there, calls `texel` with the ones inside, and begins again.
    fn weigh(&mut self, form: &Form, texel: &mut impl FnMut(isize, isize, f64)) {
        let Form { p, q, r, .. } = *form;
        let [across, down] = &self.off;
        vectorize(
            #[inline(always)]
            || {
                for k in 0..self.count.next_multiple_of(8).min(TOGETHER) {
                    let (dx, dy) = (across[k], down[k]);
                    self.squares[k] = p * dx * dx + q * dx * dy + r * dy * dy;
                    self.weights[k] = gaussian(self.squares[k]);
                }
            },
        );
        for (k, (i, j)) in self.texels.into_iter().enumerate().take(self.count) {
            if self.squares[k] < 1.0 {
                texel(i, j, self.weights[k]);
            }
        }
        self.count = 0;
    }
}

/// Calls `texel` with each texel of the ellipse about a place, both in texels, and its weight. `sides` are two conjugate
/// radii.
pub(crate) fn each(
    place: [f64; 2],
    sides: [[f64; 2]; 2],
    mut texel: impl FnMut(isize, isize, f64),
) {
    let form = Form::of(sides);
    let [columns, rows] = form.texels(place);
    let [x, y] = place;
    let mut batch = Batch {
        texels: [(0, 0); TOGETHER],
        off: [[0.0; TOGETHER]; 2],
        squares: [0.0; TOGETHER],
        weights: [0.0; TOGETHER],
        count: 0,
    };
    for j in rows {
        for i in columns.clone() {
            let k = batch.count;
            batch.texels[k] = (i, j);
            (batch.off[0][k], batch.off[1][k]) = (i as f64 - x, j as f64 - y);
            batch.count += 1;
            if batch.count == TOGETHER {
                batch.weigh(&form, &mut texel);
            }
        }
    }
    batch.weigh(&form, &mut texel);
}

/// e^(-2x) - e^(-2) for x from 0 to 1: the tenth partial sum of e^(-x/2), to the fourth power, off by 1e-9.
#[inline(always)]
fn gaussian(x: f64) -> f64 {
    let y = -0.5 * x;
    let sum = polynomial!(y; 1.0, 1.0, 1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0 / 720.0, 1.0 / 5040.0, 1.0 / 40320.0, 1.0 / 362_880.0);
    let squared = sum * sum;
    squared * squared - 0.135_335_283_236_612_7
}
