//! A pinhole camera with the distortion of a calibration, as OpenCV's `calibrateCamera` gives it.
//!
//! Source: OpenCV's camera calibration page; (x/z, y/z) and then [`Distortion`]. With k1 and k2, or k1, k2, p1 and p2, it is COLMAP's SIMPLE_RADIAL,
//! RADIAL and OPENCV, with k1 to k6 its FULL_OPENCV and OpenCV's CALIB_RATIONAL_MODEL, with s1 to s4 its
//! CALIB_THIN_PRISM_MODEL, with τx and τy its CALIB_TILTED_MODEL, which [`Tilt`] has; ROS's plumb_bob and rational_polynomial, Kalibr's pinhole-radtan.
//!
//! Domain: directions that the rectangle shows, z > 0, in front of where the polynomial turns back; else NaN.

use crate::number::angle;
use crate::number::real::Real;
use crate::projections::common::camera::{
    ASPECT, CAMERA, CX, CY, Camera, FX, FY, Lens, coefficient,
};
use crate::projections::common::distortion::{Distortion, LONG, PLAIN, SHORT, Terms};
use crate::projections::common::tilt::Tilt;
use crate::projections::projection::{Info, Visitor};

/// A lens that draws straight lines curved. Where it is not `WHOLE`, it has no prism and its sensor no tilt.
#[derive(Clone, Copy, Debug)]
pub struct BrownConrady<const WHOLE: bool = true, const WAY: u8 = LONG> {
    distortion: Distortion<3, WHOLE, WAY>,
    tilt: Tilt,
}

/// A pinhole camera with distortion.
pub type CameraBrownConrady = Camera<BrownConrady>;

/// Of a power of the radius.
pub const RADIAL: [f64; 3] = [-100.0, 0.0, 100.0];
/// Of what a lens that is not centered does: thousandths in most calibrations.
pub const TANGENTIAL: [f64; 3] = [-0.1, 0.0, 0.1];

/// Of an angle by which a sensor is tilted.
const TILT: [f64; 3] = [-1.0, 0.0, 1.0];

impl<const WHOLE: bool, const WAY: u8> BrownConrady<WHOLE, WAY> {
    /// The place on the lens's own plane, and how deep it lies.
    #[inline(always)]
    fn level<R: Real>(self, point: [R; 2]) -> ([R; 2], R) {
        if WHOLE {
            self.tilt.level(point)
        } else {
            (point, R::ONE)
        }
    }

    /// The same lens by another way.
    fn by<const OTHER: u8>(
        self,
        distortion: Distortion<3, false, OTHER>,
    ) -> BrownConrady<false, OTHER> {
        BrownConrady {
            distortion,
            tilt: self.tilt,
        }
    }
}

impl<const WHOLE: bool, const WAY: u8> Lens for BrownConrady<WHOLE, WAY> {
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
            coefficient(
                "tau_x",
                TILT,
                "the sensor's tilt about the image's horizontal, in radians",
            ),
            coefficient(
                "tau_y",
                TILT,
                "the sensor's tilt about the image's vertical, in radians",
            ),
        ],
        ..CAMERA
    };

    fn new(coefficients: &[f64], reach: f64) -> Self {
        let [k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4, tx, ty] =
            std::array::from_fn(|k| coefficients[k]);
        let terms = Terms {
            over: [k1, k2, k3],
            under: [k4, k5, k6],
            tangential: [p1, p2],
            prism: [[s1, s2], [s3, s4]],
        };
        let tilt = Tilt::new([tx, ty]);
        BrownConrady {
            distortion: Distortion::new(terms, tilt.reach(reach), f64::INFINITY),
            tilt,
        }
    }

    fn accept<V: Visitor>(camera: Camera<Self>, visitor: V) -> V::Output {
        let lens = camera.lens();
        if !lens.tilt.is_none() {
            return visitor.visit(camera);
        }
        if let Some(distortion) = lens.distortion.plain() {
            return visitor.visit(camera.with_lens(lens.by::<PLAIN>(distortion)));
        }
        match lens.distortion.short() {
            Some(distortion) => visitor.visit(camera.with_lens(lens.by::<SHORT>(distortion))),
            None => visitor.visit(camera),
        }
    }

    #[inline(always)]
    fn project<R: Real>(self, [x, y, z]: [R; 3]) -> ([R; 2], R::Mask) {
        let (point, inside) = self.distortion.distort([x / z, y / z]);
        let seen = inside & z.more(R::ZERO);
        if !WHOLE {
            return (point, seen);
        }
        let (point, ahead) = self.tilt.tilted(point);
        (point, seen & ahead)
    }

    #[inline(always)]
    fn unproject<R: Real>(self, point: [R; 2]) -> [R; 3] {
        let [x, y] = self.distortion.undistort(self.level(point).0);
        let n = R::ONE / (R::ONE + x * x + y * y).sqrt();
        [x * n, y * n, n]
    }

    /// That of the plane itself, cos³ θ, over how much of it is distorted there.
    #[inline(always)]
    fn density<R: Real>(self, point: [R; 2]) -> Option<R> {
        let (point, depth) = self.level(point);
        let (area, [x, y]) = self.distortion.shrinks(point);
        let n = R::ONE / (R::ONE + x * x + y * y).sqrt();
        let density = area * (n * n * n);
        Some(if WHOLE {
            density * self.tilt.shrinks(depth)
        } else {
            density
        })
    }

    #[inline(always)]
    fn holds<R: Real>(self, point: [R; 2]) -> R::Mask {
        if !WHOLE {
            return self.distortion.holds(point);
        }
        let (point, depth) = self.tilt.level(point);
        self.distortion.holds(point) & depth.more(R::ZERO)
    }

    fn rim(self) -> f64 {
        angle::atan(self.distortion.end())
    }

    fn held_radius(self) -> f64 {
        self.tilt.held_radius(self.distortion.held_radius())
    }
}
