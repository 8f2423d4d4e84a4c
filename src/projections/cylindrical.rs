//! Cylindrical perspective: the picture on the inside of a cylinder, unrolled.
//!
//! Source: the central cylindrical projection of map makers and panorama programs: with F = fov, the
//! longitude is (2u - 1) F/2 and the tangent of the latitude is (2v - 1) (F/2)/aspect. Vertical lines stay
//! straight. Texels are square at the horizon where the image is `aspect` as wide as high, so that
//! the height of the picture follows from its width: tan(vertical fov/2) = (F/2)/aspect, F in radians.
//!
//! Domain: directions within fov/2 of longitude and the stated latitude, else NaN. Singular: none within the
//! image; at fov = 360 u jumps from 1 to 0 behind the viewer, and the seam itself (x = ±0) has u = 0.

use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::number::real::Real;
use crate::projections::projection;
use crate::projections::projection::{Coverage, Info, Parameter, Projection, Seam, Uv};
use std::f64::consts::PI;

/// An unrolled cylinder.
#[derive(Clone, Copy, Debug)]
pub struct Cylindrical {
    /// The longitude of the right edge, in half turns.
    edge: f64,
    /// The tangent of the latitude of the bottom edge.
    half_height: f64,
    /// Width over height.
    aspect: f64,
}

/// The longitude in half turns, -1 at the seam, and the distance from the axis, of a direction of length near 1.
#[inline(always)]
pub(super) fn longitude<R: Real>(x: R, z: R) -> (R, R) {
    let (ax, az) = (x.abs(), z.abs());
    // What is dropped is an angle from the pole below any rounding unit.
    let (xf, zf) = (ax.squarable(), az.squarable());
    let h = (xf * xf + zf * zf).sqrt();
    let west = x.at_most(R::ZERO);
    (R::half_turns(ax, z).negated_if(west), h)
}

impl Projection for Cylindrical {
    const INFO: Info = Info {
        name: "cylindrical",
        title: "Cylindrical perspective",
        source: "Central cylindrical projection; Snyder 1987, Map Projections: A Working Manual, p. 30",
        summary: "The picture on a cylinder around the viewer: vertical lines stay straight; wide panoramas.",
        singular: "None in the image; at fov = 360 the seam has u = 0.",
        axes: "+x -y -z",
        aspect: (4, 1),
        parameters: &[
            Parameter {
                name: "fov",
                default: 360.0,
                above: 0.0,
                maximum: 360.0,
                unit: "degrees",
                doc: "the horizontal angle that the picture spans",
            },
            Parameter {
                name: "aspect",
                default: 4.0,
                above: 0.0,
                maximum: 20.0,
                unit: "width/height",
                doc: "the picture's width over its height, which gives its vertical angle",
            },
        ],
        smooth: true,
        ..Info::PLAIN
    };
    const EVEN_ROWS: bool = true;

    fn with_parameters(parameters: &[f64]) -> Self {
        let (edge, aspect) = (parameters[0] / 360.0, parameters[1]);
        Cylindrical {
            edge,
            half_height: PI * edge / aspect,
            aspect,
        }
    }

    fn size(self, n: usize) -> (usize, usize) {
        projection::size_of_aspect(self.aspect, n)
    }

    fn graticule(self) -> Option<f64> {
        Some(self.edge)
    }

    fn coverage(self) -> Coverage {
        Coverage::Part(self.solid_angle(Rect::WHOLE))
    }

    fn density_range(self) -> (f64, f64) {
        let horizon = 4.0 * PI * self.edge * self.half_height;
        let w = 1.0 + self.half_height * self.half_height;
        (horizon / (w * w.sqrt()), horizon)
    }

    fn seam(self) -> Seam {
        if self.edge == 1.0 {
            Seam::Periodic
        } else {
            Seam::Ends
        }
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let (longitude, h) = longitude(x, z);
        let p = longitude * R::new(1.0 / self.edge);
        let q = y / h * R::new(1.0 / self.half_height);
        Uv::in_square(p, q, R::truth(true))
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, q) = uv.pq();
        let one = R::ONE;
        let (sin, cos) = R::sin_cos_half_turns(p * R::new(self.edge));
        let y = q * R::new(self.half_height);
        let n = one / (one + y * y).sqrt();
        [sin * n, y * n, cos * n]
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        solid_angle::cylindrical(rect, 2.0 * PI * self.edge, self.half_height)
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        let (_, q) = uv.pq();
        let y = q * R::new(self.half_height);
        let w = R::ONE + y * y;
        R::new(4.0 * PI * self.edge * self.half_height) / (w * w.sqrt())
    }
}
