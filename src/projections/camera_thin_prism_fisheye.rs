//! A fisheye with radial, tangential and thin-prism distortion, as COLMAP's THIN_PRISM_FISHEYE has it.
//!
//! Source: Weng, Cohen & Herniou 1992, Camera Calibration with Distortion Models and Accuracy Evaluation, on the plane of an equidistant fisheye,
//! where a direction lies at its angle θ from the axis; then [`Distortion`] with k1 to k4, p1, p2 and a prism of r² alone. ETH3D's
//! cameras. Without tangential terms and prism it is `camera_kannala_brandt`.
//!
//! Domain: directions that the rectangle shows, in front of where the polynomial turns back; else NaN, and nothing nearer than 3e-6
//! to the direction opposite the axis, which would have a circle of places. Singular: nothing.

use crate::number::real::{Real, scaled};
use crate::projections::camera_brown_conrady::{RADIAL, TANGENTIAL};
use crate::projections::common::camera::{
    ASPECT, CAMERA, CX, CY, Camera, FX, FY, Lens, coefficient,
};
use crate::projections::common::distortion::{Distortion, LONG, SHORT, Terms};
use crate::projections::projection::{Info, Visitor};
use std::f64::consts::PI;

/// An equidistant fisheye, and a lens before it.
#[derive(Clone, Copy, Debug)]
pub struct BentFisheye<const WAY: u8 = LONG>(Distortion<4, true, WAY>);

/// A fisheye camera with all of COLMAP's terms.
pub type CameraThinPrismFisheye = Camera<BentFisheye>;

/// The largest angle from the axis: the direction opposite has no single place.
const FARTHEST: f64 = PI * (1.0 - 1e-6);

impl<const WAY: u8> Lens for BentFisheye<WAY> {
    const NAMES: Info = Info {
        name: "camera_thin_prism_fisheye",
        title: "Calibrated camera: thin-prism fisheye (COLMAP)",
        source: "Weng, Cohen, Herniou 1992, Camera Calibration with Distortion Models; COLMAP THIN_PRISM_FISHEYE",
        summary: "A fisheye by the numbers of COLMAP's THIN_PRISM_FISHEYE; sm.camera makes it from pixels.",
        parameters: &[
            FX,
            FY,
            CX,
            CY,
            ASPECT,
            coefficient(
                "k1",
                RADIAL,
                "the coefficient of the angle's cube, in radians",
            ),
            coefficient("k2", RADIAL, "the coefficient of its fifth power"),
            coefficient("p1", TANGENTIAL, "the tangential coefficient of 2xy across"),
            coefficient("p2", TANGENTIAL, "the tangential coefficient of 2xy down"),
            coefficient("k3", RADIAL, "the coefficient of its seventh power"),
            coefficient("k4", RADIAL, "the coefficient of its ninth power"),
            coefficient(
                "s1",
                TANGENTIAL,
                "the thin prism's coefficient of r² across",
            ),
            coefficient("s2", TANGENTIAL, "the thin prism's coefficient of r² down"),
        ],
        ..CAMERA
    };

    fn new(coefficients: &[f64], reach: f64) -> Self {
        let [k1, k2, p1, p2, k3, k4, s1, s2] = std::array::from_fn(|k| coefficients[k]);
        let terms = Terms {
            over: [k1, k2, k3, k4],
            under: [0.0; 3],
            tangential: [p1, p2],
            prism: [[s1, 0.0], [s2, 0.0]],
        };
        BentFisheye(Distortion::new(terms, reach, FARTHEST))
    }

    fn accept<V: Visitor>(camera: Camera<Self>, visitor: V) -> V::Output {
        match camera.lens().0.short() {
            Some(distortion) => visitor.visit(camera.with_lens(BentFisheye::<SHORT>(distortion))),
            None => visitor.visit(camera),
        }
    }

    #[inline(always)]
    fn project<R: Real>(self, [x, y, z]: [R; 3]) -> ([R; 2], R::Mask) {
        let (xs, ys, unscale) = scaled(x, y);
        let hs = (xs * xs + ys * ys).sqrt();
        // On the axis the azimuth is that of (1, 0).
        let on_axis = R::select(hs.vanishes(), R::ONE, R::ZERO);
        let factor = R::half_turns(hs * unscale, z) * R::new(PI) / (hs + on_axis);
        self.0.distort([(xs + on_axis) * factor, ys * factor])
    }

    #[inline(always)]
    fn unproject<R: Real>(self, point: [R; 2]) -> [R; 3] {
        let [x, y] = self.0.undistort(point);
        let s = ((x * x + y * y) * R::new(1.0 / (PI * PI))).clamped(0.0, 1.0);
        let t = s.sqrt();
        let factor = R::sinc_half_turns(s, t) * R::new(1.0 / PI);
        [x * factor, y * factor, R::cos_half_turns(s, t)]
    }

    /// sin θ/θ on the plane itself, over how much of it is distorted there.
    #[inline(always)]
    fn density<R: Real>(self, point: [R; 2]) -> Option<R> {
        let (area, [x, y]) = self.0.shrinks(point);
        let s = ((x * x + y * y) * R::new(1.0 / (PI * PI))).clamped(0.0, 1.0);
        Some(area * (R::sinc_half_turns(s, s.sqrt()) * R::new(1.0 / PI)))
    }

    #[inline(always)]
    fn holds<R: Real>(self, point: [R; 2]) -> R::Mask {
        self.0.holds(point)
    }

    fn rim(self) -> f64 {
        self.0.end()
    }

    fn held_radius(self) -> f64 {
        self.0.held_radius()
    }
}
