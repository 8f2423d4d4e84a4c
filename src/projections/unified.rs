//! The unified camera: a sphere seen from a point off its center; mirrors with a lens, and most fisheyes.
//!
//! Source: Geyer & Daniilidis 2000, A Unifying Theory for Central Panoramic Systems; Mei & Rives 2007, Single View
//! Point Omnidirectional Camera Calibration from Planar Grids: (x, y)/(z + ξ|d|), with the radius over that at
//! fov/2. ξ → 0 is a pinhole camera, ξ = 1 the stereographic fisheye and a parabolic mirror, between them
//! lie hyperbolic mirrors. OpenCV's `cv2.omnidir` is this with a distortion polynomial on top.
//!
//! Domain: directions within fov/2 of the axis, else NaN; fov/2 must stay below arccos(-ξ) where ξ ≤ 1, from which
//! on the image lies infinitely far away, and below arccos(-1/ξ) where ξ > 1, at which it turns back. Singular:
//! none in the image.

use crate::geometry::solid_angle::Rect;
use crate::number::angle;
use crate::number::real::Real;
use crate::projections::common::lens;
use crate::projections::projection::one;
use crate::projections::projection::{Coverage, Info, Outline, Parameter, Projection, Seam, Uv};

/// A sphere seen from a point ξ behind its center.
#[derive(Clone, Copy, Debug)]
pub struct Unified {
    /// How far the point lies behind.
    xi: f64,
    /// The angle of the rim from the axis, in radians.
    angle: f64,
    /// The image radius there.
    radius: f64,
}

impl Unified {
    fn new(parameters: &[f64]) -> Self {
        let (angle, xi) = (lens::rim(parameters[0]), parameters[1]);
        let (sin, cos) = f64::sin_cos_half_turns(parameters[0] / 360.0);
        Unified {
            xi,
            angle,
            radius: sin / (cos + xi),
        }
    }

    /// η, with which (a, b) on the image plane is the unit direction (ηa, ηb, η - ξ), from a² + b².
    #[inline(always)]
    fn eta<R: Real>(self, s: R) -> R {
        let (one, xi) = (R::ONE, R::new(self.xi));
        let root = (one + R::new((1.0 - self.xi) * (1.0 + self.xi)) * s).sqrt();
        (xi + root) / (one + s)
    }
}

impl Projection for Unified {
    const INFO: Info = Info {
        name: "unified",
        title: "Unified camera (Mei)",
        known_as: &["mei"],
        source: "Geyer, Daniilidis 2000; Mei, Rives 2007, eq. 1; OpenCV omnidirectional camera model",
        summary: "A sphere seen from a point off its center: catadioptric cameras and calibrated fisheyes.",
        singular: "None in the image.",
        axes: "+x -y -z",
        outline: Outline::Disk,
        parameters: &[
            lens::fov(180.0, 359.0),
            Parameter {
                name: "xi",
                default: 0.9,
                above: 0.0,
                maximum: 4.0,
                unit: "radii",
                doc: "how far behind the sphere's center the point of view lies",
            },
        ],
        smooth: true,
        ..Info::PLAIN
    };

    const COMMON: bool = false;

    fn check(parameters: &[f64]) -> Result<(), String> {
        let lens = Unified::new(parameters);
        let slope = |angle: f64| {
            let depth = angle::cos(angle) + lens.xi;
            if depth > 0.0 {
                (1.0 + lens.xi * angle::cos(angle)) / (depth * depth)
            } else {
                0.0
            }
        };
        lens::grows(lens.angle, &slope, lens.radius, "`xi`")
    }

    fn with_parameters(parameters: &[f64]) -> Self {
        Unified::new(parameters)
    }

    fn coverage(self) -> Coverage {
        Coverage::Cap(self.angle)
    }

    fn density_range(self) -> (f64, f64) {
        lens::extremes(1.0, &|r| one::density(self, Uv::centered(r, 0.0, 0.0)))
    }

    fn seam(self) -> Seam {
        Seam::Ends
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let length = (x * x + y * y + z * z).sqrt();
        let depth = z + R::new(self.xi) * length;
        let factor = R::new(1.0 / self.radius) / depth;
        // Where ξ > 1 the image turns back: what lies behind would appear a second time.
        let ahead = depth.more(R::ZERO) & (length + R::new(self.xi) * z).more(R::ZERO);
        Uv::in_disk(x * factor, y * factor, ahead)
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, q) = uv.pq();
        let (a, b) = (p * R::new(self.radius), q * R::new(self.radius));
        let eta = self.eta(a * a + b * b);
        [eta * a, eta * b, eta - R::new(self.xi)]
    }

    fn is_smooth(self, rect: Rect, _corners: impl Fn() -> [f64; 4]) -> bool {
        lens::is_smooth(rect)
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        let theta = |r: f64| {
            let r = r * self.radius;
            let eta = self.eta(r * r);
            angle::atan2(eta * r, eta - self.xi)
        };
        lens::solid_angle(rect, |u, v| one::density(self, Uv::flat(u, v)), theta)
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        let (p, q) = uv.pq();
        let (a, b) = (p * R::new(self.radius), q * R::new(self.radius));
        let eta = self.eta(a * a + b * b);
        let slope = R::ONE + R::new(self.xi) * (eta - R::new(self.xi));
        R::new(4.0 * self.radius * self.radius) * (eta * eta * eta) / slope
    }
}
