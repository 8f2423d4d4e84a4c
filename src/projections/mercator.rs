//! Mercator: the conformal cylinder, and the square of web maps.
//!
//! Source: Mercator 1569; Snyder 1987, Map Projections: A Working Manual, p. 41: x = λ, y = ln tan(π/4 + φ/2) on
//! the sphere. The poles lie infinitely far away, so that the map ends at ±`latitude`; with gd(π) = 85.05° it is a
//! square, the one that web maps cut into tiles.
//!
//! Domain: directions up to the stated latitude, else NaN. Singular: none within the image; u jumps from 1 to 0
//! behind the viewer, and the seam itself (x = ±0) has u = 0.
//!
//! y is asinh(tan φ) and tan φ is sinh y, which keep their digits at the equator and toward the poles: ln tan loses
//! them at the first, and sin φ, cos φ at either.

use super::cylindrical::longitude;
use crate::geometry::solid_angle::Rect;
use crate::number::real::Real;
use crate::projections::projection;
use crate::projections::projection::{Coverage, Info, Parameter, Projection, Seam, Uv};
use std::f64::consts::PI;

/// The conformal cylinder.
#[derive(Clone, Copy, Debug)]
pub struct Mercator {
    /// y of the bottom edge, in radians along the equator.
    edge: f64,
}

/// gd(π) in degrees: the latitude at which the map is a square.
const SQUARE: f64 = 85.051_128_779_806_59;

impl Projection for Mercator {
    const INFO: Info = Info {
        name: "mercator",
        title: "Mercator",
        source: "Mercator 1569; Snyder 1987, Map Projections: A Working Manual, p. 41",
        summary: "The conformal cylinder, north up; its square is the one that web maps cut into tiles.",
        singular: "None in the image, the poles lie infinitely far away; at the seam u = 0.",
        axes: "+x -y -z",
        conformal: true,
        parameters: &[Parameter {
            name: "latitude",
            default: SQUARE,
            above: 0.0,
            maximum: 89.99,
            unit: "degrees",
            doc: "the latitude of the bottom and top edges",
        }],
        smooth: true,
        ..Info::PLAIN
    };
    const EVEN_ROWS: bool = true;

    const COMMON: bool = false;

    fn with_parameters(parameters: &[f64]) -> Self {
        // From the pole, to which the distance in degrees is exact.
        let (cos, sin) = f64::sin_cos_half_turns((90.0 - parameters[0]) / 180.0);
        let edge = if parameters[0] == SQUARE {
            PI
        } else {
            Real::asinh(sin / cos)
        };
        Mercator { edge }
    }

    fn size(self, n: usize) -> (usize, usize) {
        projection::size_of_aspect(PI / self.edge, n)
    }

    fn graticule(self) -> Option<f64> {
        Some(1.0)
    }

    fn coverage(self) -> Coverage {
        let (sinh, cosh) = Real::sinh_cosh(self.edge);
        Coverage::Part(4.0 * PI * (sinh / cosh))
    }

    fn density_range(self) -> (f64, f64) {
        let (_, cosh) = Real::sinh_cosh(self.edge);
        let equator = 4.0 * PI * self.edge;
        (equator / (cosh * cosh), equator)
    }

    fn seam(self) -> Seam {
        Seam::Periodic
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let (p, h) = longitude(x, z);
        let q = (y / h).asinh() * R::new(1.0 / self.edge);
        Uv::in_square(p, q, R::truth(true))
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, q) = uv.pq();
        let (sin, cos) = R::sin_cos_half_turns(p);
        let (sinh, cosh) = (q * R::new(self.edge)).sinh_cosh();
        let n = R::ONE / cosh;
        [sin * n, sinh * n, cos * n]
    }

    /// 2π Δu (tanh b - tanh a), the difference as sinh(b - a)/(cosh a cosh b).
    fn solid_angle(self, rect: Rect) -> f64 {
        let [a, b] = [rect.v0, rect.v1].map(|v| self.edge * (2.0 * v - 1.0));
        let height = 2.0 * self.edge * (rect.v1 - rect.v0);
        let [(sinh, _), (_, cosh_a), (_, cosh_b)] = [height, a, b].map(Real::sinh_cosh);
        2.0 * PI * (rect.u1 - rect.u0) * (sinh / (cosh_a * cosh_b))
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        let (_, q) = uv.pq();
        let (_, cosh) = (q * R::new(self.edge)).sinh_cosh();
        R::new(4.0 * PI * self.edge) / (cosh * cosh)
    }
}
