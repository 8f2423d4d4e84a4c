//! Perspective: a pinhole camera's picture, the central (gnomonic) projection on a plane.
//!
//! Source: the pinhole camera as computer vision writes it, (x/z, y/z) = K⁻¹ (u, v): with
//! t = tan(fov/2), a = (2u - 1 - 2cx) t and b = (2v - 1 - 2cy) t/aspect the direction is (a, b, 1) over its
//! length. `fov` is horizontal, that of the same picture with its axis in the middle: the focal length
//! is W/(2t) pixels, the same both ways where the image is `aspect` as wide as high, and the principal
//! point is ((½ + cx) W, (½ + cy) H).
//!
//! Domain: directions that the rectangle shows, z > 0 among them, else NaN. No singular point; toward 180° the
//! density falls with the cube of the cosine, which is why the range ends at 179°.

use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::number::real::Real;
use crate::projections::projection;
use crate::projections::projection::{Coverage, Info, Parameter, Projection, Seam, Uv};

/// A pinhole camera.
#[derive(Clone, Copy, Debug)]
pub struct Perspective {
    /// Half the picture's width and height, at distance 1.
    half: [f64; 2],
    /// Where the axis is, in the coordinates that run from -1 to 1.
    principal: [f64; 2],
    /// Width over height.
    aspect: f64,
}

impl Perspective {
    /// dω/(du dv) at the distance `s` squared from the axis on the plane.
    fn density_at(self, s: f64) -> f64 {
        let w = 1.0 + s;
        4.0 * self.half[0] * self.half[1] / (w * w.sqrt())
    }
}

impl Projection for Perspective {
    const INFO: Info = Info {
        name: "perspective",
        title: "Perspective (pinhole camera)",
        known_as: &["gnomonic", "pinhole", "rectilinear"],
        source: "Gnomonic projection; the pinhole camera matrix K as in Hartley and Zisserman 2004, section 6.1",
        summary: "What a pinhole camera sees: straight lines stay straight; views out of a panorama.",
        singular: "None in the image.",
        axes: "+x -y -z",
        parameters: &[
            Parameter {
                name: "fov",
                default: 90.0,
                above: 0.0,
                maximum: 179.0,
                unit: "degrees",
                doc: "the horizontal angle that the picture spans when its axis is in the middle",
            },
            Parameter {
                name: "aspect",
                default: 1.0,
                above: 0.0,
                maximum: 20.0,
                unit: "width/height",
                doc: "the picture's width over its height",
            },
            Parameter {
                name: "cx",
                default: 0.0,
                above: -2.0,
                maximum: 2.0,
                unit: "image widths",
                doc: "how far right of the middle the axis is",
            },
            Parameter {
                name: "cy",
                default: 0.0,
                above: -2.0,
                maximum: 2.0,
                unit: "image heights",
                doc: "how far below the middle the axis is",
            },
        ],
        smooth: true,
        ..Info::PLAIN
    };
    const MEMORY_BOUND: bool = true;

    fn with_parameters(parameters: &[f64]) -> Self {
        let (fov, aspect) = (parameters[0], parameters[1]);
        let (sin, cos) = f64::sin_cos_half_turns(fov / 360.0);
        let tan = if fov == 90.0 { 1.0 } else { sin / cos };
        Perspective {
            half: [tan, tan / aspect],
            principal: [2.0 * parameters[2], 2.0 * parameters[3]],
            aspect,
        }
    }

    fn size(self, n: usize) -> (usize, usize) {
        projection::size_of_aspect(self.aspect, n)
    }

    fn coverage(self) -> Coverage {
        Coverage::Part(self.solid_angle(Rect::WHOLE))
    }

    fn density_range(self) -> (f64, f64) {
        let (mut near, mut far) = (0.0, 0.0);
        for k in [0, 1] {
            let (low, high) = (-1.0 - self.principal[k], 1.0 - self.principal[k]);
            let nearest = 0f64.clamp(low, high) * self.half[k];
            let farthest = low.abs().max(high.abs()) * self.half[k];
            near += nearest * nearest;
            far += farthest * farthest;
        }
        (self.density_at(far), self.density_at(near))
    }

    fn seam(self) -> Seam {
        Seam::Ends
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let [half_x, half_y] = self.half;
        let p = x / z * R::new(1.0 / half_x) + R::new(self.principal[0]);
        let q = y / z * R::new(1.0 / half_y) + R::new(self.principal[1]);
        Uv::in_square(p, q, z.more(R::ZERO))
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, q) = uv.pq();
        let one = R::ONE;
        let a = (p - R::new(self.principal[0])) * R::new(self.half[0]);
        let b = (q - R::new(self.principal[1])) * R::new(self.half[1]);
        let n = one / (one + a * a + b * b).sqrt();
        [a * n, b * n, n]
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        solid_angle::perspective(rect, self.half, self.principal)
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        let (p, q) = uv.pq();
        let a = (p - R::new(self.principal[0])) * R::new(self.half[0]);
        let b = (q - R::new(self.principal[1])) * R::new(self.half[1]);
        let w = R::ONE + a * a + b * b;
        R::new(4.0 * self.half[0] * self.half[1]) / (w * w.sqrt())
    }
}
