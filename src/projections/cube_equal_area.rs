//! The quadrilateralized spherical cube: six faces whose texels all see the same solid angle.
//!
//! Source: O'Neill and Laubscher 1976, Extended Studies of a Quadrilateralized Spherical Cube Earth Data Base, the exact
//! projection (COBE's own is an approximation of it), as PROJ's `qsc` has it after Lambers and Kolb 2012. On a face, with a the larger and b
//! the smaller of the two components across it, m the one along its axis and θ = atan(b/a),
//! p = √((1 - cos φ)/(1 - cos φ₁)), cos φ = m/L, cos φ₁ = a/√(2a² + b²), and q/p = (12/π)(θ - asin(sin θ/√2)).
//!
//! Domain: all directions; no singular point; the creases are the diagonals of the faces.
//!
//! Written without differences of close numbers: with D = √(2a² + b²), p = √(D(D + a)/L(L + m)) and
//! q/p = (12/π) atan(b(a² + b²)/((aD + b²)(D + a))). Back, with t = (π/12) q/p, a : b = cos t - 1/√2 : sin t.

use super::cube::{axis_of_face, to_face};
use super::hemioctahedral::DIAGONALS;
use crate::geometry::solid_angle::Rect;
use crate::number::real::{Real, max, min};
use crate::projections::faces::CUBE_LAYOUTS;
use crate::projections::projection::one;
use crate::projections::projection::{Coverage, Info, Projection, Seam, Uv};
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Six faces in equal areas.
#[derive(Clone, Copy, Debug)]
pub struct CubeEqualArea;

/// The farthest that faces are continued, in p.
const FARTHEST: f64 = 1.75;

impl Projection for CubeEqualArea {
    const INFO: Info = Info {
        name: "cube_equal_area",
        title: "Equal-area cube map (quadrilateralized spherical cube)",
        known_as: &["qsc", "quadrilateralized"],
        source: "O'Neill and Laubscher 1976; PROJ, qsc",
        summary: "Six faces whose texels all see the same solid angle; sky surveys after COBE.",
        singular: "None; on ties x wins over y wins over z.",
        axes: "+x -y +z",
        faces: 6,
        layouts: CUBE_LAYOUTS,
        equal_area: true,
        creases: &DIAGONALS,
        ..Info::PLAIN
    };

    fn with_parameters(_: &[f64]) -> Self {
        CubeEqualArea
    }

    fn coverage(self) -> Coverage {
        Coverage::Sphere
    }

    fn density_range(self) -> (f64, f64) {
        (4.0 * PI / 6.0, 4.0 * PI / 6.0)
    }

    fn seam(self) -> Seam {
        Seam::Faces
    }

    #[inline(always)]
    fn encode<R: Real>(self, d: [R; 3]) -> Uv<R> {
        let ([x, y], m, face) = to_face(d);
        let (zero, one) = (R::ZERO, R::ONE);
        let (ax, ay) = (x.abs().squarable(), y.abs().squarable());
        let along_x = ax.at_least(ay);
        let (a, b) = (max(ax, ay), min(ax, ay));
        let (aa, bb) = (a * a, b * b);
        let flat = aa + bb;
        let across = (aa + flat).sqrt();
        let length = (flat + m * m).sqrt();
        let major = (across * (across + a) / (length * (length + m))).sqrt();
        let major = R::choose(major.more(one), one, major);
        let ratio = R::half_turns(b * flat, (a * across + bb) * (across + a)) * R::new(12.0);
        let minor = major * ratio;
        // On the diagonals the ratio may round above 1.
        let minor = R::choose(minor.more(major), major, minor);
        let p = R::choose(along_x, major, minor);
        let q = R::choose(along_x, minor, major);
        Uv::centered(p.negated_if(x.less(zero)), q.negated_if(y.less(zero)), face)
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (zero, one, two) = (R::ZERO, R::ONE, R::TWO);
        let (p, q) = uv.pq();
        let (ap, aq) = (p.abs(), q.abs());
        let along_p = ap.at_least(aq);
        // One condition tells all four apart: `max` and `min` would both take q where they are equal, and its derivatives.
        let (major, minor) = (R::choose(along_p, ap, aq), R::choose(along_p, aq, ap));
        let outside = major.more(zero);
        let divisor = R::choose(outside, major, one);
        let (s, c) = R::sin_cos_half_turns(minor / (divisor * R::new(24.0)));
        // cos t - 1/√2 from half the angle, which rounds less.
        let a = R::new(1.0 - FRAC_1_SQRT_2) - two * s * s;
        let b = two * s * c;
        let (aa, bb) = (a * a, b * b);
        let flat = aa + bb;
        let across = (aa + flat).sqrt();
        let square = across * (across + a);
        let versine = major * major * flat / square;
        let slope = (max(two - versine, zero) / square).sqrt();
        let out = major * slope;
        let far = a * out;
        // At a face's center the derivatives are those along the p axis.
        let near = (b * out).with_slope_of(!outside, || minor * slope * R::new(PI / 12.0));
        let x = R::choose(along_p, far, near);
        let y = R::choose(along_p, near, far);
        axis_of_face(
            [
                x.negated_if(p.less(zero)),
                y.negated_if(q.less(zero)),
                one - versine,
            ],
            uv.face,
        )
    }

    fn beyond(self, uv: Uv<f64>) -> Uv<f64> {
        let (p, q) = uv.pq();
        let [p, q] = [p, q].map(|x| x.clamped(-FARTHEST, FARTHEST));
        one::encode(self, one::decode(self, Uv::centered(p, q, uv.face)))
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        4.0 * PI / 6.0 * rect.area()
    }

    #[inline(always)]
    fn density<R: Real>(self, _: Uv<R>) -> R {
        R::new(4.0 * PI / 6.0)
    }
}
