//! A pinhole camera with the distortion of a calibration, as OpenCV's `calibrateCamera` gives it.
//!
//! Source: OpenCV's camera calibration page; (x/z, y/z) and then [`Distortion`]. With k1 and k2, or k1, k2, p1 and p2, it is COLMAP's SIMPLE_RADIAL,
//! RADIAL and OPENCV, with k1 to k6 its FULL_OPENCV and OpenCV's CALIB_RATIONAL_MODEL, with s1 to s4 its
//! CALIB_THIN_PRISM_MODEL; ROS's plumb_bob and rational_polynomial, Kalibr's pinhole-radtan. OpenCV's tilt of the sensor has no formula here.
//!
//! Domain: directions that the rectangle shows, z > 0, in front of where the polynomial turns back; else NaN.

use crate::number::real::Real;
use crate::projections::common::angle;
use crate::projections::common::camera::{
    ASPECT, CAMERA, CX, CY, Camera, FX, FY, Lens, coefficient,
};
use crate::projections::common::distortion::{Distortion, Terms};
use crate::projections::projection::Info;

/// A lens that draws straight lines curved.
#[derive(Clone, Copy, Debug)]
pub struct BrownConrady<const PRISM: bool = true, const SHORT: bool = false>(
    Distortion<3, PRISM, SHORT>,
);

/// A pinhole camera with distortion.
pub type CameraBrownConrady = Camera<BrownConrady>;

/// Of a power of the radius.
pub const RADIAL: [f64; 3] = [-100.0, 0.0, 100.0];
/// Of what a lens that is not centered does: thousandths in most calibrations.
pub const TANGENTIAL: [f64; 3] = [-0.1, 0.0, 0.1];

impl<const PRISM: bool, const SHORT: bool> Lens for BrownConrady<PRISM, SHORT> {
    type Short = BrownConrady<false, true>;

    const NAMES: Info = Info {
        name: "camera_brown_conrady",
        title: "Calibrated camera: Brown-Conrady distortion (OpenCV)",
        source: "Brown 1966, Decentering Distortion of Lenses; OpenCV camera calibration",
        summary: "A camera by K and distCoeffs of OpenCV's calibrateCamera; sm.camera makes it from pixels.",
        parameters: &[
            FX,
            FY,
            CX,
            CY,
            ASPECT,
            coefficient("k1", RADIAL, "the numerator's coefficient of r²"),
            coefficient("k2", RADIAL, "the numerator's coefficient of r⁴"),
            coefficient("p1", TANGENTIAL, "the tangential coefficient of 2xy across"),
            coefficient("p2", TANGENTIAL, "the tangential coefficient of 2xy down"),
            coefficient("k3", RADIAL, "the numerator's coefficient of r⁶"),
            coefficient("k4", RADIAL, "the denominator's coefficient of r²"),
            coefficient("k5", RADIAL, "the denominator's coefficient of r⁴"),
            coefficient("k6", RADIAL, "the denominator's coefficient of r⁶"),
            coefficient(
                "s1",
                TANGENTIAL,
                "the thin prism's coefficient of r² across",
            ),
            coefficient(
                "s2",
                TANGENTIAL,
                "the thin prism's coefficient of r⁴ across",
            ),
            coefficient("s3", TANGENTIAL, "the thin prism's coefficient of r² down"),
            coefficient("s4", TANGENTIAL, "the thin prism's coefficient of r⁴ down"),
        ],
        ..CAMERA
    };

    fn new(coefficients: &[f64], reach: f64) -> Self {
        let [k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4] =
            std::array::from_fn(|k| coefficients[k]);
        let terms = Terms {
            over: [k1, k2, k3],
            under: [k4, k5, k6],
            tangential: [p1, p2],
            prism: [[s1, s2], [s3, s4]],
        };
        BrownConrady(Distortion::new(terms, reach, f64::INFINITY))
    }

    fn short(self) -> Option<Self::Short> {
        self.0.short().map(BrownConrady)
    }

    #[inline(always)]
    fn project<R: Real>(self, [x, y, z]: [R; 3]) -> ([R; 2], R::Mask) {
        let (point, inside) = self.0.distort([x / z, y / z]);
        (point, inside & z.more(R::ZERO))
    }

    #[inline(always)]
    fn unproject<R: Real>(self, point: [R; 2]) -> [R; 3] {
        let [x, y] = self.0.undistort(point);
        let n = R::ONE / (R::ONE + x * x + y * y).sqrt();
        [x * n, y * n, n]
    }

    /// That of the plane itself, cos³ θ, over how much of it is distorted there.
    #[inline(always)]
    fn density<R: Real>(self, point: [R; 2]) -> Option<R> {
        let (area, [x, y]) = self.0.shrinks(point);
        let n = R::ONE / (R::ONE + x * x + y * y).sqrt();
        Some(area * (n * n * n))
    }

    #[inline(always)]
    fn holds<R: Real>(self, point: [R; 2]) -> R::Mask {
        self.0.holds(point)
    }

    fn rim(self) -> f64 {
        angle::atan(self.0.end())
    }

    fn held_radius(self) -> f64 {
        self.0.held_radius()
    }
}
