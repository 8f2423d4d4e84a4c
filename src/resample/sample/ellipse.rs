//! The texels of an ellipse, and their weights.
//!
//! The elliptical weighted average is Heckbert's (Fundamentals of Texture Mapping and Image Warping, 1989): a Gaussian over
//! the ellipse that the target texel's circle becomes, and one texel wider for the reconstruction. The Gaussian e^(-2r²), cut at
//! r = 1, is lowered to end at 0.

/// Calls `texel` with each texel of the ellipse about a place, both in texels, and its weight. `sides` are two conjugate
/// radii.
pub(crate) fn each(
    [x, y]: [f64; 2],
    [[ax, ay], [bx, by]]: [[f64; 2]; 2],
    mut texel: impl FnMut(isize, isize, f64),
) {
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
    for j in (y - high).ceil() as isize..=(y + high).floor() as isize {
        for i in (x - wide).ceil() as isize..=(x + wide).floor() as isize {
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
