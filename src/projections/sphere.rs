//! The OpenGL sphere map: a photo of an ideal mirror ball from infinity.
//!
//! Source: the OpenGL specification, `GL_SPHERE_MAP`: m = 2√(rx² + ry² + (rz+1)²), s = rx/m + ½,
//! t = ry/m + ½; its inverse rz = -8u² + 8u - 8v² + 8v - 3, rx = 2√(-4u² + 4u - 4v² + 4v - 1)(2u - 1).
//! The normal of the ball where it reflects the viewer's axis into r is n = r + (0, 0, 1), so the
//! image coordinates are the normal's x and y. With z toward the viewer this is Lambert's azimuthal
//! equal-area map exactly: density 16 everywhere; what degrades at the rim is the shape.
//!
//! Domain: all directions. Singular: r = (0, 0, -1), behind the ball, which the whole rim shows; it
//! encodes to (1, ½).
//!
//! The printed form is 0/0 at the blind spot and assumes |r| = 1. Here the distance from the center is
//! sin(θ/2), from whichever of h/√(2L(L+z)) and √((L-z)/2L) does not cancel, along the azimuth. Choosing
//! numerator and denominator before the one division and root keeps it at two roots and one division,
//! which is what its time goes to; the azimuth as a unit vector cost two divisions and a root more.

use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::number::real::{Real, max, scaled};
use crate::projections::projection::{Coverage, Info, Outline, Projection, Seam, Uv};

/// A direction of any length near 1 in Lambert's map, whose disk has radius 1/`rim`; (1/`rim`, 0) for the direction
/// opposite the center. Scaled under the root, it costs no rounding of its own.
#[inline(always)]
pub(super) fn to_disk<R: Real>([x, y, z]: [R; 3], rim: f64) -> (R, R) {
    let (zero, one) = (R::ZERO, R::ONE);
    let (xs, ys, _) = scaled(x, y);
    let hs = xs * xs + ys * ys;
    let blind = hs.vanishes();
    let length = (x * x + y * y + z * z).sqrt();
    let near = length + z.abs();
    let front = z.at_least(zero);
    // In front (x, y)/√(2L(L+z)); behind (x, y)/h · √((L-z)/2L), with h at the scale of x and y.
    let lift = R::select(blind, one, zero);
    let a = R::either(front, || x, || xs + lift);
    let b = R::select(front, y, ys);
    let numerator = R::select(front, one, near);
    let hs = hs + lift;
    let denominator = length * R::new(2.0 * rim * rim) * R::select(front, near, hs);
    let factor = (numerator / denominator).sqrt();
    (a * factor, b * factor)
}

/// The unit direction at a point of the unit disk of Lambert's map.
#[inline(always)]
pub(super) fn from_disk<R: Real>(p: R, q: R) -> [R; 3] {
    let s = p * p + q * q;
    let one = R::ONE;
    let c = max(one - s, R::ZERO);
    let root = c.sqrt() * R::TWO;
    [p * root, q * root, c - (one - c)]
}

/// The mirror ball.
#[derive(Clone, Copy, Debug)]
pub struct Sphere;

impl Projection for Sphere {
    const INFO: Info = Info {
        name: "sphere",
        title: "Sphere map (mirror ball)",
        known_as: &["mirror_ball", "chrome_ball", "lambert", "laea"],
        source: "OpenGL specification, GL_SPHERE_MAP",
        summary: "A photo of an ideal mirror ball from infinity; exactly Lambert's azimuthal equal-area map.",
        singular: "The direction behind the ball fills the whole rim; it encodes to (1, 1/2).",
        axes: "+x -y +z",
        outline: Outline::Disk,
        equal_area: true,
        smooth: true,
        // At the blind spot a rounding of u is this much.
        round_trip: (1.2e-3, 6e-8),
        ..Info::PLAIN
    };
    const MEMORY_BOUND: bool = true;

    fn with_parameters(_: &[f64]) -> Self {
        Sphere
    }

    fn coverage(self) -> Coverage {
        Coverage::Sphere
    }

    fn density_range(self) -> (f64, f64) {
        (16.0, 16.0)
    }

    fn seam(self) -> Seam {
        Seam::RimOpposite
    }

    #[inline(always)]
    fn encode<R: Real>(self, d: [R; 3]) -> Uv<R> {
        let (p, q) = to_disk(d, 1.0);
        Uv::centered(p.clamped(-1.0, 1.0), q.clamped(-1.0, 1.0), R::ZERO)
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, q) = uv.pq();
        from_disk(p, q)
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        16.0 * solid_angle::disk_area(rect)
    }

    #[inline(always)]
    fn density<R: Real>(self, _: Uv<R>) -> R {
        R::new(16.0)
    }
}
