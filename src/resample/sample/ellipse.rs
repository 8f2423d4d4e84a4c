//! The texels of an ellipse, and their weights.
//!
//! The elliptical weighted average is Heckbert's (Fundamentals of Texture Mapping and Image Warping, 1989): a Gaussian over
//! the ellipse that the target texel's circle becomes, and one texel wider for the reconstruction. The Gaussian e^(-2r²), cut at
//! r = 1, is lowered to end at 0.

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

/// Calls `texel` with each texel of the ellipse about a place, both in texels, and its weight. `sides` are two conjugate
/// radii.
pub(crate) fn each(
    place: [f64; 2],
    sides: [[f64; 2]; 2],
    mut texel: impl FnMut(isize, isize, f64),
) {
    let form = Form::of(sides);
    let [columns, rows] = form.texels(place);
    let ([x, y], Form { p, q, r, .. }) = (place, form);
    for j in rows {
        for i in columns.clone() {
            let (dx, dy) = (i as f64 - x, j as f64 - y);
            let rr = p * dx * dx + q * dx * dy + r * dy * dy;
            if rr < 1.0 {
                texel(i, j, gaussian(rr));
            }
        }
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
