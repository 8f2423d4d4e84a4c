//! A pinhole camera with the K matrix of a calibration: [`Camera`] without distortion.
//!
//! Source: Hartley and Zisserman 2004, Multiple View Geometry, section 6.1: (a, b) = (x/z, y/z). It is `perspective` with two
//! focal lengths; COLMAP's SIMPLE_PINHOLE and PINHOLE.
//!
//! Domain: directions that the rectangle shows, z > 0 among them, else NaN. No singular point.

use crate::geometry::solid_angle;
use crate::number::real::Real;
use crate::projections::common::camera::{
    ASPECT, CAMERA, CX, CY, Camera, ClosedForm, FX, FY, Lens,
};
use crate::projections::projection::{Info, Outline};
use std::f64::consts::FRAC_PI_2;

/// No lens but a hole.
#[derive(Clone, Copy, Debug)]
pub struct Pinhole;

/// A pinhole camera with a K matrix.
pub type CameraPinhole = Camera<Pinhole>;

impl Lens for Pinhole {
    const NAMES: Info = Info {
        name: "camera_pinhole",
        title: "Calibrated camera: pinhole",
        source: "Hartley, Zisserman 2004, Multiple View Geometry, section 6.1; OpenCV camera calibration",
        summary: "A camera by its K matrix, without distortion; sm.camera makes it from pixels.",
        outline: Outline::Square,
        parameters: &[FX, FY, CX, CY, ASPECT],
        ..CAMERA
    };

    const CLOSED_FORM: Option<ClosedForm> = Some(solid_angle::perspective);

    fn new(_: &[f64], _: f64) -> Self {
        Pinhole
    }

    #[inline(always)]
    fn project<R: Real>(self, [x, y, z]: [R; 3]) -> ([R; 2], R::Mask) {
        ([x / z, y / z], z.more(R::ZERO))
    }

    #[inline(always)]
    fn unproject<R: Real>(self, [a, b]: [R; 2]) -> [R; 3] {
        let n = R::ONE / (R::ONE + a * a + b * b).sqrt();
        [a * n, b * n, n]
    }

    #[inline(always)]
    fn holds<R: Real>(self, _: [R; 2]) -> R::Mask {
        R::truth(true)
    }

    fn rim(self) -> f64 {
        FRAC_PI_2
    }

    fn held_radius(self) -> f64 {
        f64::INFINITY
    }
}
