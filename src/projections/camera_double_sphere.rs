//! The double-sphere camera with the K matrix of a calibration, as Basalt and Kalibr give it.
//!
//! Source: Usenko, Demmel & Cremers 2018, The Double Sphere Camera Model, equations 40 to 52; see `double_sphere`.
//!
//! Domain: directions that the rectangle shows, nearer to the axis than the paper's equation 43 allows, as in the programs whose numbers
//! these are; else NaN. The image itself may go on beyond, or end before: see `double_sphere`.

use crate::number::angle;
use crate::number::real::{Real, max};
use crate::projections::common::camera::{
    ASPECT, CAMERA, CX, CY, Camera, FX, FY, LET_OUT, Lens, coefficient, grows_up_to,
};
use crate::projections::projection::Info;
use std::f64::consts::PI;

/// Two spheres.
#[derive(Clone, Copy, Debug)]
pub struct TwoSpheres {
    xi: f64,
    alpha: f64,
    /// Directions of a smaller cosine are not seen.
    least_cosine: f64,
    /// The square of the image radius there.
    limit: f64,
}

/// A double-sphere camera with a K matrix.
pub type CameraDoubleSphere = Camera<TwoSpheres>;

impl TwoSpheres {
    /// The divisor of the image coordinates and d2, from |d|, z and x² + y².
    #[inline(always)]
    fn depth<R: Real>(self, length: R, z: R, s: R) -> (R, R) {
        let ahead = R::new(self.xi) * length + z;
        let far = (s + ahead * ahead).sqrt();
        (
            R::new(self.alpha) * far + R::new(1.0 - self.alpha) * ahead,
            far,
        )
    }
}

impl Lens for TwoSpheres {
    const NAMES: Info = Info {
        name: "camera_double_sphere",
        title: "Calibrated camera: double sphere",
        source: "Usenko, Demmel, Cremers 2018, The Double Sphere Camera Model, eq. 40-52",
        summary: "A fisheye by fx, fy, cx, cy, xi, alpha of Basalt or Kalibr; sm.camera makes it from pixels.",
        parameters: &[
            FX,
            FY,
            CX,
            CY,
            ASPECT,
            coefficient(
                "xi",
                [-1.0, -0.2, 1.0],
                "how far the second sphere's center lies before the first's",
            ),
            coefficient(
                "alpha",
                [0.0, 0.6, 1.0],
                "where the pinhole lies, as alpha/(1 - alpha) behind the second sphere's center",
            ),
        ],
        ..CAMERA
    };

    fn new(coefficients: &[f64], _: f64) -> Self {
        let [xi, alpha] = [coefficients[0], coefficients[1]];
        let mut lens = TwoSpheres {
            xi,
            alpha,
            least_cosine: 0.0,
            limit: 0.0,
        };
        let w1 = alpha.min(1.0 - alpha) / alpha.max(1.0 - alpha);
        let w2 = (w1 + xi) / (2.0 * w1 * xi + xi * xi + 1.0).sqrt();
        let spheres = lens;
        let at = |angle: f64| {
            let (sin, cos) = angle::sin_cos(angle);
            let (depth, far) = spheres.depth(1.0, cos, sin * sin);
            if cos > -w2 && depth > 0.0 {
                let slope = (1.0 + xi * cos) * (1.0 - alpha + alpha * (cos + xi) / far);
                [sin / depth, slope / (depth * depth)]
            } else {
                [f64::NAN; 2]
            }
        };
        let angle = grows_up_to(PI, at);
        lens.limit = at(angle)[0].powi(2);
        lens.least_cosine = angle::cos(angle);
        lens
    }

    #[inline(always)]
    fn project<R: Real>(self, [x, y, z]: [R; 3]) -> ([R; 2], R::Mask) {
        let s = x * x + y * y;
        let length = (s + z * z).sqrt();
        let (depth, _) = self.depth(length, z, s);
        let ahead = z.more(R::new(self.least_cosine) * length);
        ([x / depth, y / depth], ahead)
    }

    #[inline(always)]
    fn unproject<R: Real>(self, [a, b]: [R; 2]) -> [R; 3] {
        let (one, xi, alpha) = (R::ONE, R::new(self.xi), R::new(self.alpha));
        let s = a * a + b * b;
        let inner = max(one - R::new(2.0 * self.alpha - 1.0) * s, R::ZERO);
        let mz = (one - alpha * alpha * s) / (alpha * inner.sqrt() + R::new(1.0 - self.alpha));
        let square = mz * mz;
        let root = (square + R::new((1.0 - self.xi) * (1.0 + self.xi)) * s).sqrt();
        let factor = (mz * xi + root) / (square + s);
        [factor * a, factor * b, factor * mz - xi]
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
