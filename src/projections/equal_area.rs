//! The equal-area octahedral square: the octahedral map's square with the same solid angle in every texel.
//!
//! Source: Clarberg 2008, Fast Equal-Area Mapping of the (Hemi)Sphere using SIMD, as pbrt-v4 has it
//! (`EqualAreaSquareToSphere`). With a = |p|, b = |q| and d = 1 - a - b: r = 1 - |d|, φ = (π/4)((b - a)/r + 1) from the x axis
//! in each quadrant, z = ±(1 - r²) with the sign of d, and r√(2 - r²) along φ.
//!
//! Domain: all directions; no singular point, but each pole is the tip of four creases. The fold is that of the octahedral
//! map: -z is all four corners and encodes to (1, 1).
//!
//! φ in half turns is n/2r with n = b within the diamond and 1 - a beyond it: no difference of two close
//! numbers. r is √(1 - |z|) written as √((x² + y²)/L(L + |z|)), which keeps its digits near the poles. The arctangent is
//! a true one: pbrt's polynomial is off by 6e-6 rad.

use super::octahedral::EDGES;
use crate::geometry::solid_angle::Rect;
use crate::number::real::{Real, sign};
use crate::projections::projection::{Coverage, Info, Projection, Seam, Uv};
use std::f64::consts::{FRAC_PI_4, PI};

/// √((x² + y²)/L(L + |z|)): the radius √(1 - |z|/L) of a direction in the equal-area disk of its hemisphere.
#[inline(always)]
pub(super) fn radius<R: Real>([x, y, z]: [R; 3]) -> R {
    let (xs, ys) = (x.squarable(), y.squarable());
    let flat = xs * xs + ys * ys;
    let length = (flat + z * z).sqrt();
    (flat / (length * (length + z.abs()))).sqrt()
}

/// The whole sphere in equal areas.
#[derive(Clone, Copy, Debug)]
pub struct EqualArea;

impl Projection for EqualArea {
    const INFO: Info = Info {
        name: "equal_area",
        title: "Equal-area octahedral map",
        known_as: &["clarberg"],
        source: "Clarberg 2008, Fast Equal-Area Mapping of the (Hemi)Sphere using SIMD; pbrt-v4",
        summary: "The octahedral square with texels of one solid angle; environment lights of pbrt-v4.",
        singular: "None; -z is all four corners and encodes to (1, 1). Creases meet at both poles.",
        axes: "+x +y +z",
        equal_area: true,
        creases: &EDGES,
        ..Info::PLAIN
    };

    fn with_parameters(_: &[f64]) -> Self {
        EqualArea
    }

    fn coverage(self) -> Coverage {
        Coverage::Sphere
    }

    fn density_range(self) -> (f64, f64) {
        (4.0 * PI, 4.0 * PI)
    }

    fn seam(self) -> Seam {
        Seam::Octahedral
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let one = R::ONE;
        let r = radius([x, y, z]);
        let n = r * (R::half_turns(y.abs(), x.abs()) * R::TWO);
        let m = r - n;
        let below = z.less(R::ZERO);
        let a = R::choose(below, one - n, m);
        let b = R::choose(below, one - m, n);
        Uv::centered(a * sign(x), b * sign(y), R::ZERO)
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (zero, one, two) = (R::ZERO, R::ONE, R::TWO);
        let (p, q) = uv.pq();
        let (a, b) = (p.abs(), q.abs());
        let distance = one - a - b;
        let below = distance.less(zero);
        let n = R::choose(below, one - a, b);
        let m = R::choose(below, one - b, a);
        let r = n + m;
        let outside = r.more(zero);
        let divisor = R::choose(outside, r, one);
        let (sin, cos) = R::sin_cos_half_turns(n / (divisor * two));
        let flat = r * (two - r * r).sqrt();
        // At the poles, tips of four creases, the derivatives are those along the middle of a quadrant, n = m.
        let (along, across) = (R::new(1.0 + FRAC_PI_4), R::new(1.0 - FRAC_PI_4));
        let x = (cos * flat).with_slope_of(!outside, || m * along + n * across);
        let y = (sin * flat).with_slope_of(!outside, || n * along + m * across);
        [x * sign(p), y * sign(q), distance * (one + r)]
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        4.0 * PI * rect.area()
    }

    #[inline(always)]
    fn density<R: Real>(self, _: Uv<R>) -> R {
        R::new(4.0 * PI)
    }
}
