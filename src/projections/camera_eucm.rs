//! The enhanced unified camera (EUCM) with the K matrix of a calibration: an ellipsoid instead of a sphere.
//!
//! Source: Khomutenko, Garcia & Martinet 2016, An Enhanced Unified Camera Model, equations 5 to 11: with
//! ρ = √(β(x² + y²) + z²) the image is (x, y)/(α ρ + (1 - α) z). β = 1 is the unified camera with ξ = α/(1 - α). With α = ½ it is
//! Fitzgibbon's division model, whose rays are (a, b, 1 - β/4 (a² + b²)): of a barrel where β > 0, and of a pincushion where β < 0,
//! when the ellipsoid is a hyperboloid.
//!
//! Domain: directions that the rectangle shows, z > -wρ with w = α/(1 - α), or its inverse where α > ½; else NaN. Where β < 0 the rays
//! turn back at ρ = 0, and end a little before, where their slope has fallen to a hundredth of its chord.

use crate::number::angle;
use crate::number::real::{Real, max};
use crate::projections::common::camera::{
    ASPECT, CAMERA, CX, CY, Camera, FX, FY, LET_OUT, Lens, coefficient, grows_up_to, last,
};
use crate::projections::common::lens::LEAST_SLOPE;
use crate::projections::projection::Info;
use std::f64::consts::PI;

/// An ellipsoid seen from behind its center.
#[derive(Clone, Copy, Debug)]
pub struct Ellipsoid {
    alpha: f64,
    beta: f64,
    /// Directions of a smaller cosine are not seen.
    least_cosine: f64,
    /// The square of the image radius there.
    limit: f64,
}

/// An enhanced unified camera with a K matrix.
pub type CameraEucm = Camera<Ellipsoid>;

impl Lens for Ellipsoid {
    const NAMES: Info = Info {
        name: "camera_eucm",
        title: "Calibrated camera: enhanced unified model (EUCM)",
        source: "Khomutenko, Garcia, Martinet 2016, An Enhanced Unified Camera Model, eq. 5-11",
        summary: "A fisheye by fx, fy, cx, cy, alpha, beta of Kalibr; sm.camera makes it from pixels.",
        parameters: &[
            FX,
            FY,
            CX,
            CY,
            ASPECT,
            coefficient(
                "alpha",
                [0.0, 0.5, 1.0],
                "where the point of view lies, as alpha/(1 - alpha) behind the ellipsoid's center",
            ),
            coefficient(
                "beta",
                [-100.0, 1.0, 100.0],
                "the square of the ellipsoid's depth over its width; a hyperboloid's where it is negative",
            ),
        ],
        ..CAMERA
    };

    fn new(coefficients: &[f64], _: f64) -> Self {
        let [alpha, beta] = [coefficients[0], coefficients[1]];
        let w = alpha.min(1.0 - alpha) / alpha.max(1.0 - alpha);
        let at = |angle: f64| {
            let (sin, cos) = angle::sin_cos(angle);
            let far = (beta * sin * sin + cos * cos).sqrt();
            let depth = alpha * far + (1.0 - alpha) * cos;
            if cos > -w * far && depth > 0.0 {
                // d/dθ of sin θ/depth, where dρ/dθ = (β - 1) sin θ cos θ/ρ.
                let turn = alpha * (beta - 1.0) * sin * cos / far - (1.0 - alpha) * sin;
                [sin / depth, (cos * depth - sin * turn) / (depth * depth)]
            } else {
                [f64::NAN; 2]
            }
        };
        let grown = grows_up_to(PI, at);
        let angle = last(grown, |angle| {
            let [radius, slope] = at(angle);
            beta >= 0.0 || slope * angle * LEAST_SLOPE < radius
        });
        Ellipsoid {
            alpha,
            beta,
            least_cosine: angle::cos(angle),
            limit: at(angle)[0].powi(2),
        }
    }

    #[inline(always)]
    fn project<R: Real>(self, [x, y, z]: [R; 3]) -> ([R; 2], R::Mask) {
        let s = x * x + y * y;
        let far = (R::new(self.beta) * s + z * z).sqrt();
        let depth = R::new(self.alpha) * far + R::new(1.0 - self.alpha) * z;
        let ahead = z.more(R::new(self.least_cosine) * (s + z * z).sqrt());
        ([x / depth, y / depth], ahead)
    }

    #[inline(always)]
    fn unproject<R: Real>(self, [a, b]: [R; 2]) -> [R; 3] {
        let (one, alpha) = (R::ONE, R::new(self.alpha));
        let s = a * a + b * b;
        let bs = R::new(self.beta) * s;
        let inner = max(one - R::new(2.0 * self.alpha - 1.0) * bs, R::ZERO);
        let mz = (one - alpha * alpha * bs) / (alpha * inner.sqrt() + R::new(1.0 - self.alpha));
        let n = one / (s + mz * mz).sqrt();
        [a * n, b * n, mz * n]
    }

    #[inline(always)]
    fn holds<R: Real>(self, [a, b]: [R; 2]) -> R::Mask {
        (a * a + b * b).at_most(R::new(self.limit * (1.0 + LET_OUT)))
    }

    fn rim(self) -> f64 {
        angle::acos(self.least_cosine)
    }

    fn held_radius(self) -> f64 {
        self.limit.sqrt()
    }
}
