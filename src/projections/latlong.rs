//! Latitude-longitude (equirectangular): the angles themselves.
//!
//! Source: plate carrée, as every program has it, with other axes each: u = atan2(x, z)/2π + ½,
//! v = θ/π, θ the angle from the top (-y in the view frame).
//!
//! Domain: all directions. Singular: the poles, each a whole row, where u = ½; u jumps from 1 to 0
//! behind the viewer, and the seam itself (x = ±0) has u = 0.
//!
//! θ is atan2(hypot(x, z), -y): acos(-y) loses half the digits near the poles.

use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::number::real::Real;
use crate::projections::projection::{Coverage, Info, Projection, Seam, Uv};
use std::f64::consts::PI;

/// The panorama.
#[derive(Clone, Copy, Debug)]
pub struct Latlong;

impl Projection for Latlong {
    const INFO: Info = Info {
        name: "latlong",
        title: "Latitude-longitude (equirectangular)",
        known_as: &[
            "equirectangular",
            "equirect",
            "erp",
            "spherical",
            "panorama",
        ],
        source: "Plate carree; u = atan2(x, z)/2pi + 1/2, v = theta/pi",
        summary: "Longitude along a row, latitude down the rows; the common form of HDR environments.",
        singular: "The poles, where u = 1/2; at the seam u = 0.",
        axes: "+x -y -z",
        aspect: (2, 1),
        smooth: true,
        ..Info::PLAIN
    };
    const EVEN_ROWS: bool = true;

    fn with_parameters(_: &[f64]) -> Self {
        Latlong
    }

    fn graticule(self) -> Option<f64> {
        Some(1.0)
    }

    fn coverage(self) -> Coverage {
        Coverage::Sphere
    }

    fn density_range(self) -> (f64, f64) {
        (0.0, 2.0 * PI * PI)
    }

    fn seam(self) -> Seam {
        Seam::Latlong
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let half = R::HALF;
        let (ax, az) = (x.abs(), z.abs());
        // What is dropped is an angle from the pole below any rounding unit.
        let (xf, zf) = (ax.squarable(), az.squarable());
        let h = (xf * xf + zf * zf).sqrt();
        let longitude = R::half_turns(ax, z) * half;
        let west = x.at_most(R::ZERO);
        Uv::flat(half + longitude.negated_if(west), R::half_turns(h, -y))
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, _) = uv.pq();
        let (sin_longitude, cos_longitude) = R::sin_cos_half_turns(p);
        let (sin, cos) = R::sin_cos_half_turns(uv.v);
        [sin * sin_longitude, -cos, sin * cos_longitude]
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        solid_angle::latlong(rect)
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        let (sin, _) = R::sin_cos_half_turns(uv.v);
        R::new(2.0 * PI * PI) * sin
    }
}
