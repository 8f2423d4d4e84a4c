//! The unified camera with the K matrix and the distortion of a calibration, as OpenCV's `cv2.omnidir` gives it.
//!
//! Source: Mei & Rives 2007, Single View Point Omnidirectional Camera Calibration from Planar Grids: (x, y)/(z + ξ|d|), then
//! [`Distortion`] with k1, k2, p1, p2. ξ = 0 is the pinhole camera. Kalibr's omni-radtan.
//!
//! Domain: directions that the rectangle shows, nearer to the axis than arccos(-ξ), or where ξ > 1 arccos(-1/ξ), at which the
//! image turns back; else NaN.

use crate::number::angle;
use crate::number::real::{Real, max};
use crate::projections::camera_brown_conrady::{RADIAL, TANGENTIAL};
use crate::projections::common::camera::{
    ASPECT, CAMERA, CX, CY, Camera, FX, FY, Lens, coefficient, grows_up_to,
};
use crate::projections::common::distortion::{Distortion, LONG, PLAIN, SHORT, Terms};
use crate::projections::projection::{Info, Visitor};
use std::f64::consts::PI;

/// A sphere seen from a point ξ behind its center, and a lens.
#[derive(Clone, Copy, Debug)]
pub struct UnifiedLens<const WAY: u8 = LONG> {
    xi: f64,
    distortion: Distortion<3, false, WAY>,
    /// Directions of a smaller cosine are not seen.
    least_cosine: f64,
}

/// A unified camera with a K matrix.
pub type CameraUnified = Camera<UnifiedLens>;

impl<const WAY: u8> UnifiedLens<WAY> {
    /// The unit direction of a point of the plane without distortion.
    #[inline(always)]
    fn sphere<R: Real>(self, [x, y]: [R; 2]) -> [R; 3] {
        let (xi, s) = (R::new(self.xi), x * x + y * y);
        let square = R::ONE + R::new((1.0 - self.xi) * (1.0 + self.xi)) * s;
        // Where ξ > 1 the plane ends, and there is no direction beyond.
        let eta = (xi + max(square, R::ZERO).sqrt()) / (R::ONE + s);
        [eta * x, eta * y, eta - xi]
    }

    /// The same lens by another way.
    fn by<const OTHER: u8>(self, distortion: Distortion<3, false, OTHER>) -> UnifiedLens<OTHER> {
        UnifiedLens {
            xi: self.xi,
            distortion,
            least_cosine: self.least_cosine,
        }
    }

    /// The angle from the axis of what lies at a radius of the plane.
    fn angle_of(self, r: f64) -> f64 {
        let [x, _, z] = self.sphere([r, 0.0]);
        PI * f64::half_turns(x, z)
    }
}

impl<const WAY: u8> Lens for UnifiedLens<WAY> {
    const NAMES: Info = Info {
        name: "camera_unified",
        title: "Calibrated camera: unified model (Mei)",
        source: "Mei, Rives 2007, Single View Point Omnidirectional Camera Calibration; OpenCV omnidirectional camera",
        summary: "A fisheye or a mirror by K, xi and D of OpenCV's cv2.omnidir; sm.camera makes it from pixels.",
        parameters: &[
            FX,
            FY,
            CX,
            CY,
            ASPECT,
            coefficient(
                "xi",
                [-1.0, 1.0, 10.0],
                "how far behind the sphere's center the point of view lies",
            ),
            coefficient("k1", RADIAL, "the coefficient of r²"),
            coefficient("k2", RADIAL, "the coefficient of r⁴"),
            coefficient("p1", TANGENTIAL, "the tangential coefficient of 2xy across"),
            coefficient("p2", TANGENTIAL, "the tangential coefficient of 2xy down"),
        ],
        ..CAMERA
    };

    fn new(coefficients: &[f64], reach: f64) -> Self {
        let [xi, k1, k2, p1, p2] = std::array::from_fn(|k| coefficients[k]);
        let at = |angle: f64| {
            let (sin, cos) = angle::sin_cos(angle);
            let depth = cos + xi;
            if depth > 0.0 {
                [sin / depth, (1.0 + xi * cos) / (depth * depth)]
            } else {
                [f64::NAN; 2]
            }
        };
        let angle = grows_up_to(PI, at);
        let terms = Terms {
            over: [k1, k2, 0.0],
            tangential: [p1, p2],
            ..Terms::NONE
        };
        UnifiedLens {
            xi,
            distortion: Distortion::new(terms, reach, at(angle)[0]),
            least_cosine: angle::cos(angle),
        }
    }

    fn accept<V: Visitor>(camera: Camera<Self>, visitor: V) -> V::Output {
        let lens = camera.lens();
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
        let length = (x * x + y * y + z * z).sqrt();
        let depth = z + R::new(self.xi) * length;
        let (point, inside) = self.distortion.distort([x / depth, y / depth]);
        let ahead = z.more(R::new(self.least_cosine) * length);
        (point, inside & ahead)
    }

    #[inline(always)]
    fn unproject<R: Real>(self, point: [R; 2]) -> [R; 3] {
        self.sphere(self.distortion.undistort(point))
    }

    #[inline(always)]
    fn holds<R: Real>(self, point: [R; 2]) -> R::Mask {
        self.distortion.holds(point)
    }

    fn rim(self) -> f64 {
        self.angle_of(self.distortion.end())
    }

    fn held_radius(self) -> f64 {
        self.distortion.held_radius()
    }
}
