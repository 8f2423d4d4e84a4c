//! MatCap: the unit normal itself, seen from the front.
//!
//! Source: the lit-sphere shading of Sloan et al. 2001, as modeling programs use it: a material is
//! a picture of a ball, looked up by the normal in view space, u = nx/2 + ½, v = ny/2 + ½. The same map
//! is the orthographic view of a hemisphere.
//!
//! Toward the rim an error δ of a coordinate turns the direction by √(2δ), so that every rounding counts.
//! Encoding normalizes twice, the second time by the remainder 1 - |n|² of the first result, computed without
//! rounding, and rounds the coordinate once; decoding takes z from the same remainder. With plain sums
//! the round trip was off by up to 5.4e-4 rad in f32.
//!
//! Domain: z ≥ 0; behind it NaN. Singular: the rim, where the density 4/√(1-p²-q²) grows without bound
//! and a coordinate rounded by ε moves the direction by √ε.

use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::number::real::{Real, max};
use crate::projections::projection::{Coverage, Info, Outline, Projection, Seam, Uv};

/// 1 - |n|² for |n| near 1, without rounding: the heads lie on a grid so coarse that their squares and
/// sums are exact, and what the tails add is small.
#[inline(always)]
pub(super) fn remainder<R: Real>(n: [R; 3]) -> R {
    let grid = R::new(if R::epsilon() > 1e-10 {
        1.5 * 2048.0
    } else {
        1.5 * 67_108_864.0
    });
    let heads = n.map(|x| (x + grid) - grid);
    let tail = |k: usize| (n[k] - heads[k]) * (n[k] + heads[k]);
    let exact = R::ONE - heads[0] * heads[0] - heads[1] * heads[1] - heads[2] * heads[2];
    exact - (tail(0) + tail(1) + tail(2))
}

/// ½ + p(1 + correction)/2 with one rounding: what the first sum rounds off is carried on.
#[inline(always)]
pub(super) fn rounded_once<R: Real>(p: R, correction: R) -> R {
    let half = R::HALF;
    let x = p * half;
    let sum = half + x;
    (sum + ((x - (sum - half)) + x * correction)).clamped(0.0, 1.0)
}

/// The lit sphere.
#[derive(Clone, Copy, Debug)]
pub struct Matcap;

impl Projection for Matcap {
    const INFO: Info = Info {
        name: "matcap",
        title: "MatCap (lit sphere)",
        known_as: &["litsphere"],
        source: "Sloan, Martin, Gooch, Gooch 2001, The Lit Sphere, section 3",
        summary: "The view-space normal as a place on the picture of a ball.",
        singular: "The density grows without bound toward the rim.",
        axes: "+x -y +z",
        outline: Outline::Disk,
        smooth: true,
        // At the rim a rounding of u is this much.
        round_trip: (4.8e-4, 2.5e-8),
        ..Info::PLAIN
    };
    const MEMORY_BOUND: bool = true;

    fn with_parameters(_: &[f64]) -> Self {
        Matcap
    }

    fn coverage(self) -> Coverage {
        Coverage::Hemisphere
    }

    fn density_range(self) -> (f64, f64) {
        (4.0, f64::INFINITY)
    }

    fn seam(self) -> Seam {
        Seam::Ends
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let inverse = R::ONE / (x * x + y * y + z * z).sqrt();
        let (p, q, r) = (x * inverse, y * inverse, z * inverse);
        let half = remainder([p, q, r]) * R::HALF;
        let uv = Uv::flat(rounded_once(p, half), rounded_once(q, half));
        let nan = R::NAN;
        let front = z.at_least(R::ZERO);
        Uv {
            u: R::select(front, uv.u, nan),
            v: R::select(front, uv.v, nan),
            face: uv.face,
        }
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, q) = uv.pq();
        let c = remainder([p, q, R::ZERO]);
        [p, q, max(c, R::ZERO).sqrt()]
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        solid_angle::matcap(rect)
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        let (p, q) = uv.pq();
        R::new(4.0) / max(R::ONE - (p * p + q * q), R::ZERO).sqrt()
    }
}
