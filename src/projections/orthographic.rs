//! The orthographic fisheye: a globe seen from far away.
//!
//! Source: the orthographic projection r = sin θ/sin(fov/2); fisheye lenses with r = f sin θ, and the sky over
//! a horizontal surface, where area in the disk is irradiance (Nusselt's analog). At 180° it is
//! MatCap's formula with another frame, and shares its careful rounding.
//!
//! Domain: all directions within fov/2 of the axis, else NaN. Singular: the rim at 180°, where the density
//! grows without bound and a coordinate rounded by ε moves the direction by √ε.

use super::matcap::{remainder, rounded_once};
use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::number::real::{Real, max};
use crate::projections::common::lens;
use crate::projections::projection::{Coverage, Info, Outline, Projection, Seam, Uv};
use std::f64::consts::PI;

/// A globe from far away.
#[derive(Clone, Copy, Debug)]
pub struct Orthographic {
    /// The angle of the rim from the axis, in half turns.
    angle: f64,
    /// The sine of that angle.
    rim: f64,
}

impl Orthographic {
    fn whole(self) -> bool {
        self.angle == 0.5
    }
}

impl Projection for Orthographic {
    const INFO: Info = Info {
        name: "orthographic",
        title: "Orthographic fisheye",
        source: "Orthographic projection; Snyder 1987, Map Projections: A Working Manual, p. 145; Nusselt 1928",
        summary: "Fisheye with r = sin θ: a globe from far away; area in the image is irradiance.",
        singular: "At fov = 180 the density grows without bound toward the rim.",
        axes: "+x -y -z",
        outline: Outline::Disk,
        parameters: &[lens::fov(180.0, 180.0)],
        smooth: true,
        // At the rim of a whole hemisphere a rounding of u is this much.
        round_trip: (4.8e-4, 2.5e-8),
        ..Info::PLAIN
    };
    const MEMORY_BOUND: bool = true;

    fn with_parameters(parameters: &[f64]) -> Self {
        let angle = parameters[0] / 360.0;
        Orthographic {
            angle,
            rim: f64::sin_cos_half_turns(angle).0,
        }
    }

    fn coverage(self) -> Coverage {
        Coverage::Cap(PI * self.angle)
    }

    fn density_range(self) -> (f64, f64) {
        let center = 4.0 * self.rim * self.rim;
        let rim = if self.whole() {
            0.0
        } else {
            f64::sin_cos_half_turns(self.angle).1
        };
        (center, center / rim)
    }

    fn seam(self) -> Seam {
        Seam::Ends
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let inverse = R::ONE / (x * x + y * y + z * z).sqrt();
        let (a, b, c) = (x * inverse, y * inverse, z * inverse);
        let half = remainder([a, b, c]) * R::HALF;
        let scale = R::new(1.0 / self.rim);
        let (p, q) = (a * scale, b * scale);
        let within = (p * p + q * q).at_most(R::new(1.0 + 8.0 * R::epsilon()));
        let inside = z.at_least(R::ZERO) & within;
        let nan = R::NAN;
        Uv::flat(
            R::select(inside, rounded_once(p, half), nan),
            R::select(inside, rounded_once(q, half), nan),
        )
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, q) = uv.pq();
        let (a, b) = (p * R::new(self.rim), q * R::new(self.rim));
        let c = remainder([a, b, R::ZERO]);
        [a, b, max(c, R::ZERO).sqrt()]
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        if self.whole() {
            return solid_angle::matcap(rect);
        }
        let t = self.rim * self.rim;
        solid_angle::bands(rect, |inner, outer| {
            let cosine = |r: f64| (1.0 - t * r * r).max(0.0).sqrt();
            t * (outer - inner) * (outer + inner) / (cosine(inner) + cosine(outer))
        })
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        let (p, q) = uv.pq();
        let t = R::new(self.rim * self.rim);
        let cosine = max(R::ONE - t * (p * p + q * q), R::ZERO).sqrt();
        R::new(4.0) * t / cosine
    }
}
