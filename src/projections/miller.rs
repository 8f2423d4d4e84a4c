//! Miller's cylinder: Mercator's shape at temperate latitudes, with the poles on the map.
//!
//! Source: Miller 1942; Snyder 1987, Map Projections: A Working Manual, p. 88: x = λ, y = (5/4) ln tan(π/4 + 2φ/5).
//!
//! Domain: all directions. Singular: the poles, each a whole row, where u = ½; u jumps from 1 to 0 behind the viewer,
//! and the seam itself (x = ±0) has u = 0.
//!
//! The logarithm is asinh tan(4φ/5), which keeps its digits at the equator.

use super::cylindrical::longitude;
use crate::geometry::solid_angle::Rect;
use crate::number::real::Real;
use crate::projections::projection;
use crate::projections::projection::{Coverage, Info, Projection, Seam, Uv};
use std::f64::consts::PI;

/// A cylinder between Mercator's and the equirectangular one.
#[derive(Clone, Copy, Debug)]
pub struct Miller;

/// asinh tan 72°: four fifths of y at the pole.
const EDGE: f64 = 1.842_730_034_701_113;

impl Miller {
    /// The latitude in half turns.
    #[inline(always)]
    fn latitude<R: Real>(q: R) -> R {
        let (sinh, _) = (q * R::new(EDGE)).sinh_cosh();
        (R::half_turns(sinh.abs(), R::ONE) * R::new(1.25)).negated_if(q.less(R::ZERO))
    }
}

impl Projection for Miller {
    const INFO: Info = Info {
        name: "miller",
        title: "Miller cylindrical",
        source: "Miller 1942; Snyder 1987, Map Projections: A Working Manual, p. 88",
        summary: "A compromise of Mercator and latlong that shows the poles; world maps.",
        singular: "The poles, where u = 1/2; at the seam u = 0.",
        axes: "+x -y -z",
        aspect: (15, 11),
        smooth: true,
        ..Info::PLAIN
    };
    const EVEN_ROWS: bool = true;

    const COMMON: bool = false;

    fn with_parameters(_: &[f64]) -> Self {
        Miller
    }

    fn size(self, n: usize) -> (usize, usize) {
        projection::size_of_aspect(PI / (1.25 * EDGE), n)
    }

    fn coverage(self) -> Coverage {
        Coverage::Sphere
    }

    fn density_range(self) -> (f64, f64) {
        (0.0, 5.0 * PI * EDGE)
    }

    fn seam(self) -> Seam {
        Seam::Latlong
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let half = R::HALF;
        let (longitude, h) = longitude(x, z);
        let latitude = R::half_turns(h, -y) - half;
        let (sin, cos) = R::sin_cos_half_turns(latitude * R::new(0.8));
        let q = (sin / cos).asinh() * R::new(1.0 / EDGE);
        Uv::centered(longitude, q.clamped(-1.0, 1.0), R::ZERO)
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, q) = uv.pq();
        let (sin_longitude, cos_longitude) = R::sin_cos_half_turns(p);
        let (sin, cos) = R::sin_cos_half_turns(Miller::latitude(q));
        [cos * sin_longitude, sin, cos * cos_longitude]
    }

    /// 2π Δu times the difference of sines, as a product.
    fn solid_angle(self, rect: Rect) -> f64 {
        let [a, b] = [rect.v0, rect.v1].map(|v| 0.5 * PI * Miller::latitude(2.0 * v - 1.0));
        4.0 * PI * (rect.u1 - rect.u0) * ((a + b).cos() * (b - a).sin()).max(0.0)
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        let (_, q) = uv.pq();
        let (_, cos) = R::sin_cos_half_turns(Miller::latitude(q));
        let (_, cosh) = (q * R::new(EDGE)).sinh_cosh();
        let cos = R::select(cos.less(R::ZERO), R::ZERO, cos);
        R::new(5.0 * PI * EDGE) * cos / cosh
    }
}
