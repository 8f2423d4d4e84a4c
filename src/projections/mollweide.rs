//! Mollweide: the whole sphere in an ellipse, every texel the same solid angle, parallels straight.
//!
//! Source: Mollweide 1805; Snyder 1987, Map Projections: A Working Manual, p. 249: x = (2√2/π) λ cos θ, y = √2 sin θ
//! with 2θ + sin 2θ = π sin φ.
//!
//! Domain: all directions. Singular: the poles, where θ moves as the power ⅔ of the distance to the pole: a coordinate
//! rounded by ε moves a direction there by ε^¾ (4e-12 rad in f64, 1e-5 in f32). u jumps from one rim to the other
//! behind the viewer, and the seam itself (x = ±0) is the left rim.
//!
//! The equation is solved from the pole: ψ = π - 2|θ| has ψ - sin ψ = π(1 - sin|φ|), Kepler's for a parabola, whose
//! right side (x² + z²)/(L(L + |y|)) keeps its digits. ψ is a smooth function of the cube root of that side, also at
//! the pole, where Newton's method on θ converges linearly, as every textbook warns: a polynomial has nine digits of it,
//! and one step does for the rest, which f32 does not need.

use super::cylindrical::longitude;
use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::number::math::polynomial;
use crate::number::real::{Real, SINGLE, floored_square, max, min};
use crate::projections::projection::{Coverage, Info, Outline, Projection, Seam, Uv};
use std::f64::consts::PI;

/// The equal-area ellipse.
#[derive(Clone, Copy, Debug)]
pub struct Mollweide;

/// ψ over c, the cube root of 6 (ψ - sin ψ), by c²: to 5e-9 for ψ from 0 to π, from a fit of our own.
const ANGLE: [f64; 11] = [
    1.000_000_002_232_732,
    0.016_666_590_601_531_29,
    0.000_714_709_854_563_819_9,
    3.876_995_588_570_655_4e-5,
    3.487_589_803_980_583_6e-6,
    -4.542_649_105_250_807_7e-7,
    2.498_634_282_131_426_4e-7,
    -5.578_889_345_581_8e-8,
    8.315_896_082_806_819e-9,
    -6.743_593_215_194_141e-10,
    2.526_140_091_349_174_5e-11,
];

/// ψ - sin ψ, by its series below 1. `sin` is sin ψ.
#[inline(always)]
fn lag<R: Real>(psi: R, sin: R) -> R {
    let one = R::ONE;
    let s = psi * psi;
    let term = |rest: R, divisor: f64| one - s * R::new(1.0 / divisor) * rest;
    let rest = if R::epsilon() < SINGLE {
        term(term(term(one, 272.0), 210.0), 156.0)
    } else {
        one
    };
    let series = term(term(term(term(rest, 110.0), 72.0), 42.0), 20.0);
    R::either(
        psi.less(one),
        || s * psi * R::new(1.0 / 6.0) * series,
        || psi - sin,
    )
}

impl Projection for Mollweide {
    const INFO: Info = Info {
        name: "mollweide",
        title: "Mollweide",
        source: "Mollweide 1805; Snyder 1987, Map Projections: A Working Manual, p. 249",
        summary: "The whole sphere in an ellipse of equal areas, with straight parallels; sky surveys, world maps.",
        singular: "The poles, where a coordinate rounded by eps moves a direction by eps^(3/4); at the seam the left rim.",
        axes: "+x -y -z",
        aspect: (2, 1),
        outline: Outline::Disk,
        equal_area: true,
        smooth: true,
        // ε^¾ at the poles: 1 - |q| rounds by 3ε, and the distance to the pole is 1.55 (1 - |q|)^¾.
        round_trip: (1e-5, 5e-12),
        ..Info::PLAIN
    };

    const COMMON: bool = false;

    fn with_parameters(_: &[f64]) -> Self {
        Mollweide
    }

    fn coverage(self) -> Coverage {
        Coverage::Sphere
    }

    fn density_range(self) -> (f64, f64) {
        (16.0, 16.0)
    }

    fn seam(self) -> Seam {
        Seam::RimMirrored
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let (half, one) = (R::HALF, R::ONE);
        let (longitude, _) = longitude(x, z);
        let [xf, yf, zf] = [x, y, z].map(R::squarable);
        let across = xf * xf + zf * zf;
        let length = (across + yf * yf).sqrt();
        let side = R::new(PI) * (across / (length * (length + y.abs())));
        let c = (side * R::new(6.0)).cbrt();
        let s = floored_square(c);
        let [a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10] = ANGLE.map(R::new);
        let mut psi = c * (polynomial!(s; a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10));
        if R::epsilon() < SINGLE {
            let (sin, cos) = R::sin_cos_half_turns(psi * R::new(0.5 / PI));
            let two = R::TWO;
            psi = psi - (lag(psi, two * sin * cos) - side) / (two * sin * sin);
        }
        let (sin, cos) = R::sin_cos_half_turns(psi * R::new(0.5 / PI));
        // 1 - cos, which keeps its digits at the pole.
        let depth = half * (sin * sin / (one + cos));
        let up = y.less(R::ZERO);
        Uv::flat(
            (longitude * sin * half + half).clamped(0.0, 1.0),
            R::either(up, || depth, || one - depth),
        )
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, q) = uv.pq();
        let (one, two) = (R::ONE, R::TWO);
        // 1 - |q| from the nearer end of v, which keeps its digits at the pole.
        let below = min(uv.v, one - uv.v) * two;
        let below = max(below, R::ZERO);
        let aq = one - below;
        let s = (below * (one + aq)).sqrt();
        let psi = R::half_turns(s, aq) * R::new(2.0 * PI);
        let missing = lag(psi, two * s * aq) * R::new(1.0 / PI);
        let cos = (missing * (two - missing)).sqrt();
        let width = max(s, R::new(1e-30));
        let (sin_longitude, cos_longitude) = R::sin_cos_half_turns((p / width).clamped(-4.0, 4.0));
        let up = q.less(R::ZERO);
        [
            cos * sin_longitude,
            (one - missing).negated_if(up),
            cos * cos_longitude,
        ]
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        16.0 * solid_angle::disk_area(rect)
    }

    #[inline(always)]
    fn density<R: Real>(self, _: Uv<R>) -> R {
        R::new(16.0)
    }
}
