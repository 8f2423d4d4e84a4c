//! Pannini: wide views of architecture whose verticals and radial lines stay straight.
//!
//! Source: Sharpless, Postle & German 2010, Pannini: A New Projection for Rendering Wide Angle Perspective Images: the
//! picture on a cylinder, seen from a point `d` behind its axis: S = (d + 1)/(d + cos λ), x = S sin λ, y = S tan φ.
//! With s > 0 heights are taken toward those of the plane, y = ((1 - s) S + s/cos λ) tan φ, the paper's vertical
//! compression, which straightens horizontal lines as well. d = 0 is `perspective`, d = 1 Pannini's own,
//! d → ∞ the cylinder seen from afar. The horizontal angle is `fov`; the height follows from `aspect`.
//!
//! Domain: directions that the picture shows, else NaN; fov/2 must stay below arccos(-d), arccos(-1/d) where d > 1, and
//! 90° where s > 0. Singular: none in the image.

use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::number::angle;
use crate::number::real::Real;
use crate::projections::common::lens;
use crate::projections::projection;
use crate::projections::projection::one;
use crate::projections::projection::{Coverage, Info, Parameter, Projection, Seam, Uv};

/// A cylinder seen from behind its axis.
#[derive(Clone, Copy, Debug)]
pub struct Pannini {
    /// How far behind.
    d: f64,
    /// How far heights are those of the plane.
    s: f64,
    /// The longitude of the right edge, in radians.
    angle: f64,
    /// x of the right edge and y of the bottom one.
    half: [f64; 2],
    /// Width over height.
    aspect: f64,
}

impl Pannini {
    fn new(parameters: &[f64]) -> Self {
        let [fov, d, s, aspect] = [0, 1, 2, 3].map(|k| parameters[k]);
        let (sin, cos) = f64::sin_cos_half_turns(fov / 360.0);
        let width = (d + 1.0) / (d + cos) * sin;
        Pannini {
            d,
            s,
            angle: lens::rim(fov),
            half: [width, width / aspect],
            aspect,
        }
    }

    /// y over tan φ.
    #[inline(always)]
    fn height<R: Real>(self, scale: R, cos: R) -> R {
        if self.s == 0.0 {
            scale
        } else {
            R::new(1.0 - self.s) * scale + R::new(self.s) / cos
        }
    }

    /// (S, cos λ) from x.
    #[inline(always)]
    fn column<R: Real>(self, x: R) -> (R, R) {
        let one = R::ONE;
        let k = x * x * R::new(1.0 / ((self.d + 1.0) * (self.d + 1.0)));
        let root = (one + k * R::new((1.0 - self.d) * (1.0 + self.d))).sqrt();
        let cos = (root - k * R::new(self.d)) / (k + one);
        (R::new(self.d + 1.0) / (R::new(self.d) + cos), cos)
    }
}

impl Projection for Pannini {
    const INFO: Info = Info {
        name: "pannini",
        title: "Pannini",
        source: "Sharpless, Postle, German 2010, Pannini: A New Projection, eq. 1-3",
        summary: "Wide views whose verticals and radial lines stay straight: interiors, architecture, wide games.",
        singular: "None in the image.",
        axes: "+x -y -z",
        aspect: (2, 1),
        parameters: &[
            Parameter {
                name: "fov",
                default: 150.0,
                above: 0.0,
                maximum: 320.0,
                unit: "degrees",
                doc: "the horizontal angle that the picture spans",
            },
            Parameter {
                name: "d",
                default: 1.0,
                above: 0.0,
                maximum: 10.0,
                unit: "radii",
                doc: "how far behind the cylinder's axis the point of view lies",
            },
            Parameter {
                name: "s",
                default: 0.0,
                above: -1.0,
                maximum: 1.0,
                unit: "",
                doc: "how far heights are taken toward those of a plane, which straightens horizontal lines",
            },
            Parameter {
                name: "aspect",
                default: 2.0,
                above: 0.0,
                maximum: 20.0,
                unit: "width/height",
                doc: "the picture's width over its height, which gives its vertical angle",
            },
        ],
        smooth: true,
        ..Info::PLAIN
    };

    const COMMON: bool = false;

    fn check(parameters: &[f64]) -> Result<(), String> {
        let view = Pannini::new(parameters);
        let slope = |angle: f64| {
            let cos = angle::cos(angle);
            let (scale, depth) = ((view.d + 1.0) / (view.d + cos), view.d + cos);
            let upright = view.s == 0.0 || (cos > 0.02 && view.height(scale, cos) > 0.0);
            if depth > 0.0 && upright {
                (view.d + 1.0) * (1.0 + view.d * cos) / (depth * depth)
            } else {
                0.0
            }
        };
        lens::grows(view.angle, &slope, view.half[0], "`d` and `s`")
    }

    fn with_parameters(parameters: &[f64]) -> Self {
        Pannini::new(parameters)
    }

    fn size(self, n: usize) -> (usize, usize) {
        projection::size_of_aspect(self.aspect, n)
    }

    fn coverage(self) -> Coverage {
        Coverage::Part(self.solid_angle(Rect::WHOLE))
    }

    fn density_range(self) -> (f64, f64) {
        // Largest on the horizon and smallest on the edge above or below it, for each column.
        let along = |q: f64| lens::extremes(1.0, &|p| one::density(self, Uv::centered(p, q, 0.0)));
        let (horizon, edge) = (along(0.0), along(1.0));
        (horizon.0.min(edge.0), horizon.1.max(edge.1))
    }

    fn seam(self) -> Seam {
        Seam::Ends
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let (xf, zf) = (x.squarable(), z.squarable());
        let h = (xf * xf + zf * zf).sqrt();
        let (sin, cos, tan) = (x / h, z / h, y / h);
        let depth = R::new(self.d) + cos;
        let ahead = depth.more(R::ZERO) & (R::ONE + R::new(self.d) * cos).more(R::ZERO);
        let ahead = ahead & (cos.more(R::ZERO) | R::truth(self.s == 0.0));
        let scale = R::new(self.d + 1.0) / depth;
        let p = scale * sin * R::new(1.0 / self.half[0]);
        let q = self.height(scale, cos) * tan * R::new(1.0 / self.half[1]);
        Uv::in_square(p, q, ahead)
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, q) = uv.pq();
        let x = p * R::new(self.half[0]);
        let (scale, cos) = self.column(x);
        let sin = x / scale;
        let tan = q * R::new(self.half[1]) / self.height(scale, cos);
        let n = R::ONE / (sin * sin + tan * tan + cos * cos).sqrt();
        [sin * n, tan * n, cos * n]
    }

    /// ∫ (sin φ₁ - sin φ₀) dλ, along the columns.
    fn solid_angle(self, rect: Rect) -> f64 {
        let [a, b] = [rect.v0, rect.v1].map(|v| self.half[1] * (2.0 * v - 1.0));
        let tall = 2.0 * self.half[1] * (rect.v1 - rect.v0);
        solid_angle::integral(rect.u0, rect.u1, |u| {
            let x = self.half[0] * (2.0 * u - 1.0);
            let (scale, cos) = self.column(x);
            let height = self.height(scale, cos);
            let (a, b) = (a / height, b / height);
            let (la, lb) = ((1.0 + a * a).sqrt(), (1.0 + b * b).sqrt());
            // On one side of the horizon the difference of the sines as a quotient.
            let zone = if a * b > 0.0 {
                tall / height * (a + b) / ((a * lb + b * la) * la * lb)
            } else {
                b / lb - a / la
            };
            // dλ/dx, the derivative of x = S sin λ turned over.
            let depth = self.d + cos;
            let slope = depth * depth / ((self.d + 1.0) * (1.0 + self.d * cos));
            2.0 * self.half[0] * slope * zone
        })
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        let (p, q) = uv.pq();
        let (one, d) = (R::ONE, R::new(self.d));
        let (scale, cos) = self.column(p * R::new(self.half[0]));
        let height = self.height(scale, cos);
        let tan = q * R::new(self.half[1]) / height;
        let w = one + tan * tan;
        let depth = d + cos;
        let slope = depth * depth / (R::new(self.d + 1.0) * (one + d * cos));
        R::new(4.0 * self.half[0] * self.half[1]) * slope / (height * w * w.sqrt())
    }
}
