//! The stereographic fisheye: angles are kept, small circles stay circles.
//!
//! Source: the stereographic projection from the direction opposite the axis, r = tan(θ/2)/tan(fov/4); the
//! "little planet" picture of panorama programs, and fisheye lenses with r = 2f tan(θ/2).
//!
//! Domain: all directions within fov/2 of the axis, else NaN. Singular: the direction opposite the axis lies
//! infinitely far away, and the range of fov ends at 359°. Density falls from the center to the rim by
//! 1/cos⁴(fov/4): wide views round directions near their center by as much more as texels there are larger.

use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::number::real::Real;
use crate::projections::common::lens;
use crate::projections::projection::{Coverage, Info, Outline, Projection, Seam, Uv};
use std::f64::consts::PI;

/// A conformal fisheye.
#[derive(Clone, Copy, Debug)]
pub struct Stereographic {
    /// The angle of the rim from the axis, in half turns.
    angle: f64,
    /// The tangent of half that angle.
    rim: f64,
}

impl Projection for Stereographic {
    const INFO: Info = Info {
        name: "stereographic",
        title: "Stereographic fisheye (little planet)",
        source: "Stereographic projection; Snyder 1987, Map Projections: A Working Manual, p. 154",
        summary: "Fisheye that keeps angles: small circles stay circles; little planets.",
        singular: "None in the image; the direction opposite the axis lies infinitely far away.",
        axes: "+x -y -z",
        outline: Outline::Disk,
        conformal: true,
        parameters: &[lens::fov(180.0, 359.0)],
        smooth: true,
        ..Info::PLAIN
    };
    const MEMORY_BOUND: bool = true;

    fn with_parameters(parameters: &[f64]) -> Self {
        let angle = parameters[0] / 360.0;
        let (sin, cos) = f64::sin_cos_half_turns(0.5 * angle);
        let rim = if angle == 0.5 { 1.0 } else { sin / cos };
        Stereographic { angle, rim }
    }

    fn coverage(self) -> Coverage {
        Coverage::Cap(PI * self.angle)
    }

    fn density_range(self) -> (f64, f64) {
        let s = self.rim * self.rim;
        (16.0 * s / ((1.0 + s) * (1.0 + s)), 16.0 * s)
    }

    fn seam(self) -> Seam {
        Seam::Ends
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let length = (x * x + y * y + z * z).sqrt();
        // Behind, L + z cancels and is (x² + y²)/(L - z). What that loses by underflow is outside of any fov.
        let near = length + z.abs();
        let front = z.at_least(R::ZERO);
        let numerator = R::select(front, R::ONE, near);
        let denominator = R::either(front, || near, || x * x + y * y);
        let factor = numerator / denominator * R::new(1.0 / self.rim);
        Uv::in_disk(x * factor, y * factor, R::truth(true))
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, q) = uv.pq();
        let (a, b) = (p * R::new(self.rim), q * R::new(self.rim));
        let s = a * a + b * b;
        let (one, two) = (R::ONE, R::TWO);
        let n = one / (one + s);
        [two * a * n, two * b * n, (one - s) * n]
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        let t = self.rim * self.rim;
        if t <= 1.0 {
            return solid_angle::azimuthal(
                rect,
                |s| 16.0 * t / ((1.0 + t * s) * (1.0 + t * s)),
                |s| 2.0 * t / (1.0 + t * s),
            );
        }
        // The density's poles at ±i/rim come too near the real axis for fixed rules.
        solid_angle::bands(rect, |inner, outer| {
            let width = (outer - inner) * (outer + inner);
            2.0 * t * width / ((1.0 + t * outer * outer) * (1.0 + t * inner * inner))
        })
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        let (p, q) = uv.pq();
        let t = R::new(self.rim * self.rim);
        let w = R::ONE + t * (p * p + q * q);
        R::new(16.0) * t / (w * w)
    }
}
