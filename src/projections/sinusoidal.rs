//! Sinusoidal (Sanson–Flamsteed): rows as long as their parallels, every texel the same solid angle.
//!
//! Source: Snyder 1987, Map Projections: A Working Manual, p. 243: x = λ cos φ, y = φ.
//!
//! Domain: all directions. Valid between the two sine curves |2u - 1| ≤ sin πv. Singular: the poles, two points of the
//! outline; u jumps from one rim to the other behind the viewer, and the seam itself (x = ±0) is the left rim.

use super::cylindrical::longitude;
use crate::geometry::solid_angle::Rect;
use crate::number::angle;
use crate::number::real::{Real, max};
use crate::projections::projection::{Coverage, Info, Outline, Projection, Seam, Uv};
use std::f64::consts::PI;

/// Parallels at their lengths.
#[derive(Clone, Copy, Debug)]
pub struct Sinusoidal;

/// Area of the part of p0..p1 × q0..q1 under p = cos(πq/2), all in the first quadrant.
fn area(p0: f64, p1: f64, q0: f64, q1: f64) -> f64 {
    // The rim leaves the right side at `right`, and the left side at `left`.
    let rim = |p: f64| (angle::acos(p.min(1.0)) * (2.0 / PI)).clamp(q0, q1);
    let (right, left) = (rim(p1), rim(p0));
    let under = {
        let (_, cos) = f64::sin_cos_half_turns(0.25 * (left + right));
        let (sin, _) = f64::sin_cos_half_turns(0.25 * (left - right));
        4.0 / PI * cos * sin
    };
    (right - q0) * (p1 - p0) + (under - p0 * (left - right)).max(0.0)
}

impl Projection for Sinusoidal {
    const INFO: Info = Info {
        name: "sinusoidal",
        title: "Sinusoidal (Sanson-Flamsteed)",
        known_as: &["sanson_flamsteed"],
        source: "Snyder 1987, Map Projections: A Working Manual, p. 243",
        summary: "Rows as long as their parallels: equal areas without a latlong's waste; satellite grids (MODIS).",
        singular: "The poles, two points of the outline; at the seam the left rim.",
        axes: "+x -y -z",
        aspect: (2, 1),
        outline: Outline::Shape,
        equal_area: true,
        smooth: true,
        ..Info::PLAIN
    };

    const COMMON: bool = false;

    fn with_parameters(_: &[f64]) -> Self {
        Sinusoidal
    }

    fn coverage(self) -> Coverage {
        Coverage::Sphere
    }

    fn used_part(self) -> f64 {
        // The mean of sin πv.
        std::f64::consts::FRAC_2_PI
    }

    fn density_range(self) -> (f64, f64) {
        (2.0 * PI * PI, 2.0 * PI * PI)
    }

    fn held_ellipse(self) -> Option<[[f64; 2]; 2]> {
        Some([[0.0; 2], [0.9, 0.75]])
    }

    fn seam(self) -> Seam {
        Seam::RimMirrored
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let half = R::HALF;
        let (longitude, h) = longitude(x, z);
        let yf = y.squarable();
        let cos = h / (h * h + yf * yf).sqrt();
        Uv::flat(
            (longitude * cos * half + half).clamped(0.0, 1.0),
            R::half_turns(h, -y),
        )
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, _) = uv.pq();
        let (cos, up) = R::sin_cos_half_turns(uv.v);
        let width = max(cos, R::new(1e-30));
        let (sin_longitude, cos_longitude) = R::sin_cos_half_turns((p / width).clamped(-4.0, 4.0));
        [cos * sin_longitude, -up, cos * cos_longitude]
    }

    #[inline(always)]
    fn contains<R: Real>(self, uv: Uv<R>) -> R::Mask {
        let (p, _) = uv.pq();
        // That of `decode` itself, which is then found once; beyond the bounds it means nothing.
        let (width, _) = R::sin_cos_half_turns(uv.v);
        uv.in_bounds(1) & p.abs().at_most(width + R::new(8.0 * R::epsilon()))
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        // The quadrants are alike. 2u - 1 is exact where u ≥ ½.
        let fold = |a: f64, b: f64| {
            [
                [1.0 - a.min(0.5), 1.0 - b.min(0.5)],
                [b.max(0.5), a.max(0.5)],
            ]
        };
        let mut sum = 0.0;
        for [u1, u0] in fold(rect.u0, rect.u1) {
            for [v1, v0] in fold(rect.v0, rect.v1) {
                if u1 > u0 && v1 > v0 {
                    sum += area(
                        2.0 * u0 - 1.0,
                        2.0 * u1 - 1.0,
                        2.0 * v0 - 1.0,
                        2.0 * v1 - 1.0,
                    );
                }
            }
        }
        0.5 * PI * PI * sum
    }

    #[inline(always)]
    fn density<R: Real>(self, _: Uv<R>) -> R {
        R::new(2.0 * PI * PI)
    }
}
