//! Lambert's cylindrical equal-area map: longitude along a row, the sine of the latitude down the rows.
//!
//! Source: Lambert 1772; Snyder 1987, Map Projections: A Working Manual, section 10, with standard parallel 0. In the view
//! frame u = atan2(x, z)/2π + ½ and v = (1 + y)/2: Archimedes' theorem, that a sphere and its cylinder have the same area
//! between two planes.
//!
//! Domain: all directions. Singular: the poles, each a whole row, where u = ½; at the seam u = 0. Near the lower
//! pole v is near 1, and a coordinate rounded by ε moves a direction by √ε; near the upper one v is small and keeps its
//! digits, because 1 + y is written as (x² + z²)/(1 - y).

use crate::geometry::solid_angle::Rect;
use crate::number::real::{Real, max};
use crate::projections::projection;
use crate::projections::projection::{Coverage, Info, Projection, Seam, Uv};
use std::f64::consts::PI;

/// The cylinder of equal areas.
#[derive(Clone, Copy, Debug)]
pub struct LambertCylindrical;

impl Projection for LambertCylindrical {
    const INFO: Info = Info {
        name: "lambert_cylindrical",
        title: "Lambert cylindrical equal-area",
        known_as: &["cylindrical_equal_area", "cea"],
        source: "Lambert 1772; Snyder 1987, Map Projections: A Working Manual, section 10",
        summary: "Longitude along a row, the sine of latitude down the rows: texels of one solid angle in rings.",
        singular: "The poles, where u = 1/2; at the seam u = 0.",
        axes: "+x -y -z",
        aspect: (22, 7),
        equal_area: true,
        smooth: true,
        // Near the lower pole v is near 1, and 2√(ε/4) of angle are lost.
        round_trip: (3.6e-4, 1.6e-8),
        ..Info::PLAIN
    };

    const COMMON: bool = false;

    fn with_parameters(_: &[f64]) -> Self {
        LambertCylindrical
    }

    fn size(self, n: usize) -> (usize, usize) {
        // Texels on the horizon are squares.
        projection::size_of_aspect(PI, n)
    }

    fn graticule(self) -> Option<f64> {
        Some(1.0)
    }

    fn coverage(self) -> Coverage {
        Coverage::Sphere
    }

    fn density_range(self) -> (f64, f64) {
        (4.0 * PI, 4.0 * PI)
    }

    fn seam(self) -> Seam {
        Seam::Latlong
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let (zero, half) = (R::ZERO, R::HALF);
        let (ax, az) = (x.abs(), z.abs());
        let (xf, zf) = (ax.squarable(), az.squarable());
        let flat = xf * xf + zf * zf;
        let length = (flat + y * y).sqrt();
        let near = flat / (length * (length + y.abs()) * R::TWO);
        let longitude = R::half_turns(ax, z) * half;
        let west = x.at_most(zero);
        Uv::flat(
            half + longitude.negated_if(west),
            R::either(y.less(zero), || near, || R::ONE - near),
        )
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (one, two) = (R::ONE, R::TWO);
        let (p, q) = uv.pq();
        let (sin, cos) = R::sin_cos_half_turns(p);
        let flat = max(uv.v * (one - uv.v), R::ZERO).sqrt() * two;
        [flat * sin, q, flat * cos]
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        4.0 * PI * rect.area()
    }

    #[inline(always)]
    fn density<R: Real>(self, _: Uv<R>) -> R {
        R::new(4.0 * PI)
    }
}
