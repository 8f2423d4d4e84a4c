//! A fisheye whose radial polynomial comes before its tangential and prism terms, as COLMAP's RAD_TAN_THIN_PRISM_FISHEYE has it.
//!
//! Source: Meta's Project Aria, "Camera Intrinsic Models", FisheyeRadTanThinPrism (Fisheye624); its terms are those of Weng, Cohen &
//! Herniou 1992. A direction at the angle θ from the axis lies at the radius r = θ (1 + k0 θ² + k1 θ⁴ + ... + k5 θ¹²); of that place (x, y)
//! a = x + 2 p1 x y + p0 (r² + 2x²) + s0 r² + s1 r⁴, b = y + p1 (r² + 2y²) + 2 p0 x y + s2 r² + s3 r⁴. `camera_thin_prism_fisheye` has its
//! terms of θ instead of r. Each of both is a [`Distortion`], and so has its inverse.
//!
//! Domain: directions that the rectangle shows, in front of where the polynomial or the other terms turn back; else NaN, and nothing nearer
//! than 3e-6 to the direction opposite the axis, which would have a circle of places. Singular: nothing.

use crate::number::real::{Real, scaled};
use crate::projections::camera_brown_conrady::{RADIAL, TANGENTIAL};
use crate::projections::common::camera::{
    ASPECT, CAMERA, CX, CY, Camera, FX, FY, Lens, coefficient, reaches,
};
use crate::projections::common::distortion::{Distortion, LONG, SHORT, Terms};
use crate::projections::projection::{Info, Visitor};
use std::f64::consts::PI;

/// An equidistant fisheye, a polynomial, and what is not round.
#[derive(Clone, Copy, Debug)]
pub struct TwiceBentFisheye<const WAY: u8 = LONG> {
    radial: Distortion<6, false, WAY>,
    bend: Distortion<1, true, WAY>,
    /// The angle at which the first of both ends.
    rim: f64,
}

/// A fisheye camera with all terms of COLMAP's RAD_TAN_THIN_PRISM_FISHEYE.
pub type CameraRadTanThinPrismFisheye = Camera<TwiceBentFisheye>;

/// The largest angle from the axis: the direction opposite has no single place.
const FARTHEST: f64 = PI * (1.0 - 1e-6);

impl<const WAY: u8> TwiceBentFisheye<WAY> {
    /// The place on the plane whose radius is θ.
    #[inline(always)]
    fn plane<R: Real>(self, point: [R; 2]) -> [R; 2] {
        self.radial.undistort(self.bend.undistort(point))
    }
}

impl<const WAY: u8> Lens for TwiceBentFisheye<WAY> {
    const NAMES: Info = Info {
        name: "camera_rad_tan_thin_prism_fisheye",
        title: "Calibrated camera: radial-tangential thin-prism fisheye (COLMAP)",
        source: "Project Aria, Camera Intrinsic Models: Fisheye624; COLMAP RAD_TAN_THIN_PRISM_FISHEYE",
        summary: "A fisheye by the numbers of COLMAP's RAD_TAN_THIN_PRISM_FISHEYE; sm.camera makes it from pixels.",
        parameters: &[
            FX,
            FY,
            CX,
            CY,
            ASPECT,
            coefficient(
                "k0",
                RADIAL,
                "the coefficient of the angle's cube, in radians",
            ),
            coefficient("k1", RADIAL, "the coefficient of its fifth power"),
            coefficient("k2", RADIAL, "the coefficient of its seventh power"),
            coefficient("k3", RADIAL, "the coefficient of its ninth power"),
            coefficient("k4", RADIAL, "the coefficient of its eleventh power"),
            coefficient("k5", RADIAL, "the coefficient of its thirteenth power"),
            coefficient("p0", TANGENTIAL, "the tangential coefficient of 2xy down"),
            coefficient("p1", TANGENTIAL, "the tangential coefficient of 2xy across"),
            coefficient(
                "s0",
                TANGENTIAL,
                "the thin prism's coefficient of r² across",
            ),
            coefficient(
                "s1",
                TANGENTIAL,
                "the thin prism's coefficient of r⁴ across",
            ),
            coefficient("s2", TANGENTIAL, "the thin prism's coefficient of r² down"),
            coefficient("s3", TANGENTIAL, "the thin prism's coefficient of r⁴ down"),
        ],
        ..CAMERA
    };

    fn new(coefficients: &[f64], reach: f64) -> Self {
        let [k0, k1, k2, k3, k4, k5, p0, p1, s0, s1, s2, s3] =
            std::array::from_fn(|k| coefficients[k]);
        let over = Terms {
            over: [k0, k1, k2, k3, k4, k5],
            ..Terms::NONE
        };
        let around = Terms {
            tangential: [p1, p0],
            prism: [[s0, s1], [s2, s3]],
            ..Terms::NONE
        };
        let bend = Distortion::new(around, reach, f64::INFINITY);
        let radial = Distortion::new(over, bend.end(), FARTHEST);
        let radius = |angle: f64| radial.distort([angle, 0.0]).0[0];
        TwiceBentFisheye {
            radial,
            bend,
            rim: reaches(bend.end(), radial.end(), radius),
        }
    }

    fn accept<V: Visitor>(camera: Camera<Self>, visitor: V) -> V::Output {
        let lens = camera.lens();
        match (lens.radial.short(), lens.bend.short()) {
            (Some(radial), Some(bend)) => {
                visitor.visit(camera.with_lens(TwiceBentFisheye::<SHORT> {
                    radial,
                    bend,
                    rim: lens.rim,
                }))
            }
            _ => visitor.visit(camera),
        }
    }

    #[inline(always)]
    fn project<R: Real>(self, [x, y, z]: [R; 3]) -> ([R; 2], R::Mask) {
        let (xs, ys, unscale) = scaled(x, y);
        let hs = (xs * xs + ys * ys).sqrt();
        // On the axis the azimuth is that of (1, 0).
        let on_axis = R::select(hs.vanishes(), R::ONE, R::ZERO);
        let factor = R::half_turns(hs * unscale, z) * R::new(PI) / (hs + on_axis);
        let (round, seen) = self.radial.distort([(xs + on_axis) * factor, ys * factor]);
        let (point, inside) = self.bend.distort(round);
        (point, seen & inside)
    }

    #[inline(always)]
    fn unproject<R: Real>(self, point: [R; 2]) -> [R; 3] {
        let [x, y] = self.plane(point);
        let s = ((x * x + y * y) * R::new(1.0 / (PI * PI))).clamped(0.0, 1.0);
        let t = s.sqrt();
        let factor = R::sinc_half_turns(s, t) * R::new(1.0 / PI);
        [x * factor, y * factor, R::cos_half_turns(s, t)]
    }

    /// sin θ/θ on the plane itself, over how much of it is distorted there, twice.
    #[inline(always)]
    fn density<R: Real>(self, point: [R; 2]) -> Option<R> {
        let (last, round) = self.bend.shrinks(point);
        let (first, [x, y]) = self.radial.shrinks(round);
        let s = ((x * x + y * y) * R::new(1.0 / (PI * PI))).clamped(0.0, 1.0);
        Some(last * first * (R::sinc_half_turns(s, s.sqrt()) * R::new(1.0 / PI)))
    }

    #[inline(always)]
    fn holds<R: Real>(self, point: [R; 2]) -> R::Mask {
        self.bend.holds(point) & self.radial.holds(self.bend.undistort(point))
    }

    fn rim(self) -> f64 {
        self.rim
    }

    fn held_radius(self) -> f64 {
        let ([r, _], _) = self.radial.distort([self.rim, 0.0]);
        self.bend.nearest(r)
    }
}
