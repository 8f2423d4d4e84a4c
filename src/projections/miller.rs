//! Miller's cylinder: Mercator's shape at temperate latitudes, with the poles on the map.
//!
//! Source: Miller 1942; Snyder 1987, Map Projections: A Working Manual, p. 88: x = λ, y = (5/4) ln tan(π/4 + 2φ/5).
//!
//! Domain: all directions. Singular: the poles, each a whole row, where u = ½; u jumps from 1 to 0 behind the viewer,
//! and the seam itself (x = ±0) has u = 0.
//!
//! The logarithm is asinh tan(4φ/5), which keeps its digits at the equator. Both it and its inverse are odd and analytic
//! from pole to pole, so that f32 takes a polynomial for either.

use super::cylindrical::longitude;
use crate::geometry::solid_angle::Rect;
use crate::number::math::polynomial;
use crate::number::real::{Real, SINGLE, floored_square};
use crate::projections::projection;
use crate::projections::projection::{Coverage, Info, Projection, Seam, Uv};
use std::f64::consts::PI;

/// A cylinder between Mercator's and the equirectangular one.
#[derive(Clone, Copy, Debug)]
pub struct Miller;

/// asinh tan 72°: four fifths of y at the pole.
const EDGE: f64 = 1.842_730_034_701_113;

/// q over the latitude in half turns, by the square of that: to 3e-8, from a fit of our own.
const ROW: [f64; 11] = [
    1.363_886_254_692_267_7,
    1.435_819_577_244_548_8,
    2.270_911_375_906_792_7,
    3.945_770_579_371_583,
    14.900_010_527_545_133,
    -99.720_792_788_481_12,
    1_302.287_436_969_907,
    -8_419.784_959_531_387,
    35_102.668_555_423_6,
    -80_448.788_084_042_22,
    83_864.868_057_007_77,
];

/// The latitude in half turns over q, by q²: to 7e-9, from a fit of our own.
const LATITUDE: [f64; 11] = [
    0.733_198_979_653_852_8,
    -0.414_947_159_041_671_95,
    0.352_206_728_398_996_8,
    -0.346_655_558_011_555_34,
    0.365_203_425_214_312_6,
    -0.383_127_644_980_960_1,
    0.364_100_469_329_706_9,
    -0.280_532_997_042_371_06,
    0.155_691_785_026_817_2,
    -0.053_585_049_986_825_62,
    0.008_447_023_633_872_685,
];

/// x times a polynomial in x².
#[inline(always)]
fn odd<R: Real>(x: R, coefficients: [f64; 11]) -> R {
    let [a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10] = coefficients.map(R::new);
    let s = floored_square(x);
    x * (polynomial!(s; a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10))
}

impl Miller {
    /// The latitude in half turns.
    #[inline(always)]
    fn latitude<R: Real>(q: R) -> R {
        if R::epsilon() >= SINGLE {
            return odd(q, LATITUDE);
        }
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

    fn graticule(self) -> Option<f64> {
        Some(1.0)
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
        let q = if R::epsilon() < SINGLE {
            let (sin, cos) = R::sin_cos_half_turns(latitude * R::new(0.8));
            (sin / cos).asinh() * R::new(1.0 / EDGE)
        } else {
            odd(latitude, ROW)
        };
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
        let [a, b] = [rect.v0, rect.v1].map(|v| 0.5 * Miller::latitude(2.0 * v - 1.0));
        let (_, cos) = f64::sin_cos_half_turns(a + b);
        let (sin, _) = f64::sin_cos_half_turns(b - a);
        4.0 * PI * (rect.u1 - rect.u0) * (cos * sin).max(0.0)
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
