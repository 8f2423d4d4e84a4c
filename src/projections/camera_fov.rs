//! The field-of-view camera with the K matrix of a calibration, as COLMAP, Kalibr and PTAM have it.
//!
//! Source: Devernay & Faugeras 2001, Straight Lines Have to Be Straight, equations 13 and 14: where a pinhole has the radius r, the lens has
//! atan(2 r tan(ω/2))/ω. With h/z for r that is φ/ω, φ the angle of (z, 2 h tan(ω/2)), which goes on behind the camera.
//!
//! Domain: directions that the rectangle shows, in front of where the lens nearly stands still; else NaN.

use crate::number::angle;
use crate::number::real::{Real, scaled};
use crate::projections::common::camera::{
    ASPECT, CAMERA, CX, CY, Camera, FX, FY, LET_OUT, Lens, coefficient, grows_up_to,
};
use crate::projections::projection::Info;
use std::f64::consts::PI;

/// A lens whose image radius is an angle: that of the direction, its plane stretched.
#[derive(Clone, Copy, Debug)]
pub struct Stretched {
    /// ω.
    omega: f64,
    /// 2 tan(ω/2), by which the plane is stretched.
    stretch: f64,
    /// The largest angle from the axis.
    end: f64,
    /// The image radius there.
    limit: f64,
}

/// A field-of-view camera with a K matrix.
pub type CameraFov = Camera<Stretched>;

impl Lens for Stretched {
    const NAMES: Info = Info {
        name: "camera_fov",
        title: "Calibrated camera: field of view (FOV)",
        source: "Devernay, Faugeras 2001, Straight Lines Have to Be Straight, eq. 13-14",
        summary: "A camera by fx, fy, cx, cy, omega of COLMAP's FOV or Kalibr; sm.camera makes it from pixels.",
        parameters: &[
            FX,
            FY,
            CX,
            CY,
            ASPECT,
            coefficient(
                "omega",
                [0.0, 0.9, 3.1],
                "the field of view of an ideal lens of this kind, in radians",
            ),
        ],
        ..CAMERA
    };

    fn new(coefficients: &[f64], _: f64) -> Self {
        let omega = coefficients[0];
        let (sin, cos) = angle::sin_cos(0.5 * omega);
        let stretch = 2.0 * sin / cos;
        let at = |angle: f64| {
            let (sin, cos) = angle::sin_cos(angle);
            let square = cos * cos + (stretch * sin).powi(2);
            [
                PI * f64::half_turns(stretch * sin, cos) / omega,
                stretch / (omega * square),
            ]
        };
        let end = grows_up_to(PI, at);
        Stretched {
            omega,
            stretch,
            end,
            limit: at(end)[0],
        }
    }

    #[inline(always)]
    fn project<R: Real>(self, [x, y, z]: [R; 3]) -> ([R; 2], R::Mask) {
        let (xs, ys, unscale) = scaled(x, y);
        let hs = (xs * xs + ys * ys).sqrt();
        // On the axis the azimuth is that of (1, 0).
        let on_axis = R::select(hs.vanishes(), R::ONE, R::ZERO);
        let t = R::half_turns(hs * unscale * R::new(self.stretch), z);
        let last = self.limit * self.omega / PI * (1.0 + 2.0 * f64::EPSILON);
        let factor = t * R::new(PI / self.omega) / (hs + on_axis);
        (
            [(xs + on_axis) * factor, ys * factor],
            t.at_most(R::new(last)),
        )
    }

    #[inline(always)]
    fn unproject<R: Real>(self, [a, b]: [R; 2]) -> [R; 3] {
        let turns = R::new((self.omega / PI).powi(2));
        let s = ((a * a + b * b) * turns).clamped(0.0, 1.0);
        let t = s.sqrt();
        // sin φ over the radius.
        let factor = R::sinc_half_turns(s, t) * R::new(self.omega / PI);
        let (x, y) = (a * factor, b * factor);
        let z = R::cos_half_turns(s, t) * R::new(self.stretch);
        let n = R::ONE / (x * x + y * y + z * z).sqrt();
        [x * n, y * n, z * n]
    }

    #[inline(always)]
    fn holds<R: Real>(self, [a, b]: [R; 2]) -> R::Mask {
        (a * a + b * b).at_most(R::new(self.limit * self.limit * (1.0 + LET_OUT)))
    }

    fn rim(self) -> f64 {
        self.end
    }

    fn held_radius(self) -> f64 {
        self.limit
    }
}
