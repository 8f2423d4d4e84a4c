//! Exact solid angles of texels: the integral of dω/(du dv) over a rectangle of the image.
//!
//! | map | method | source |
//! |---|---|---|
//! | lat-long | 2π Δu · 2 sin(π v_mid) sin(π Δv/2) | Archimedes' zone, difference of cosines as a product |
//! | cube, octahedral, hemi-octahedral | spherical polygons | Van Oosterom & Strackee 1983 |
//! | equal-area disk | area of a rectangle in a disk: trapezoids and a circular segment | elementary |
//! | MatCap | difference of arctangents across, Gauss–Legendre along | ∫dq/√(w-q²) = asin(q/√w) |
//! | perspective | a plane polygon, as a cube's | Van Oosterom & Strackee 1983 |
//! | cylindrical | longitude times a difference of sines | Archimedes' zone |
//! | stereographic and orthographic fisheyes | Gauss–Legendre along the azimuth over bands of closed form | ω = ∫ (cos θ_in - cos θ_out) dφ |
//! | other azimuthal | Gauss–Legendre; Green's theorem for big texels | ω = ∮ (1 - cos θ) dφ |
//! | lenses without a closed form | few points where they are smooth ([`smooth`]), along the border beside a rim ([`halved`]) | ω = ∮ (1 - cos θ) dφ |
//! | anything else | adaptive Gauss–Legendre, lines cut at the rim | [`quadrature`], [`outlined`] |
//!
//! Domain: finite rectangles with 0 ≤ u0 ≤ u1 ≤ 1 and the same in v. The bounds are taken as exact.
//! Results are never negative, and zero for an empty rectangle or one outside the valid image.
//!
//! **Widths are exact.** p = 2u - 1 rounds where u is below ¼, by as much as 5e-13 of a texel at
//! 8192². So no width is ever a difference of such p. The square is folded into its quadrants
//! (`Quarter`) and measured from its corners: 1 - u is exact for u ≥ ½, hence all widths, the
//! diamond a + b = ½, the diagonals a = b and the distance 1 - p² = 4a(1-a) to the rim are, too.
//! What still rounds is the position, and a shift of 1e-16 only moves the density a little.
//!
//! **Singular points.** The density of MatCap is infinite at the rim. The integrals are finite there,
//! and p = p_rim - t² turns the root into a smooth function. Octahedra have creases, where texels are
//! cut so that each piece is a plane polygon of one face. The poles of lat-long need the sine of the
//! distance to the *nearer* pole: π v rounds too much close to v = 1.
//!
//! **Accuracy**, measured against 45 digits up to 8192²: relative 7e-16 for the polygons and
//! lat-long, 3e-14 for MatCap, 1e-15 for [`azimuthal`] if its density is as good. (That of the
//! angular map goes to zero at the rim, and s = p² + q² knows the distance to it to 1e-16 only: 5e-13
//! in the outermost texels.) What the rim leaves of a texel errs by 2e-13 of a whole texel, for MatCap
//! with its pole there 5e-12. Bounds such as i/8191 are rounded and no better themselves.
//!
//! What did not help: inclusion–exclusion over the four corners of a texel (loses the ratio of the
//! sphere to the texel, seven digits at 8192²), the arctangent formula of cube maps (the same, it is
//! one), Green's theorem for small or thin texels (the edges cancel: 5e-12 in a strip of 0.55 × 0.02
//! at the rim of the angular map), one arctangent a triangle (a product of complex numbers adds the
//! angles for less and loses nothing), a 3- against a 4-point rule in [`quadrature`] (they agree by
//! chance often enough to let 2e-9 through).

mod disk;
mod gauss;
mod gnomonic;
mod polygon;
mod rect;
#[cfg(test)]
mod tests;

use crate::number::real::Real;
use std::f64::consts::PI;

pub use disk::{azimuthal, bands, disk_area, matcap};
pub use gauss::{halved, outlined, quadrature};
pub use gnomonic::{cube, hemioctahedral, octahedral, perspective, plane_rectangle};
pub use polygon::clip;
pub use rect::Rect;

/// The longest side of a rectangle that [`smooth`] is for.
const SMALL: f64 = 1.0 / 64.0;

/// Whether a rectangle is one that [`smooth`] is for, if the density is smooth in it.
pub fn is_small(r: Rect) -> bool {
    r.du().max(r.dv()) <= SMALL
}

/// ∫∫ density du dv over a rectangle that [is small](is_small) and in which the density is smooth: to 1e-10 where the
/// nearest singularity of the density, complex ones among them, is a tenth of the image away.
pub fn smooth(r: Rect, density: impl FnMut(f64, f64) -> f64) -> f64 {
    let side = r.du().max(r.dv());
    // A rule of n points errs by some (5 side)²ⁿ there.
    let rule: &gauss::Rule = if side <= 1.0 / 1600.0 {
        &gauss::G2
    } else if side <= 1.0 / 256.0 {
        &gauss::G3
    } else {
        &gauss::G4
    };
    gauss::tensor(rule, [r.u0, r.v0], [r.du(), r.dv()], density)
}

/// ∫ f(x) dx, over parts of at most a twentieth, by rules of three to sixteen points: to 1e-13 where the nearest singularity of f,
/// complex ones among them, is a tenth away.
pub fn integral(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    let parts = ((to - from) * 20.0).ceil().max(1.0);
    let at = |k: f64| from + (to - from) * (k / parts);
    // A rule of n points errs by some (5 side)²ⁿ there.
    let rule: &gauss::Rule = match to - from {
        side if side <= 1.0 / 1600.0 => &gauss::G3,
        side if side <= 1.0 / 256.0 => &gauss::G4,
        side if side <= 1.0 / 64.0 => &gauss::G6,
        _ => &gauss::G16,
    };
    (0..parts as usize)
        .map(|k| {
            let (a, b) = (at(k as f64), at((k + 1) as f64));
            gauss::line(rule, a, b - a, &f)
        })
        .sum()
}

/// Solid angle of a rectangle of the latitude-longitude map, the poles at v = 0 and v = 1.
pub fn latlong(r: Rect) -> f64 {
    let twice = r.v0 + r.v1;
    // 1 - v is exact where it matters, so both poles get the same digits.
    let pole = if twice > 1.0 {
        (1.0 - r.v0) + (1.0 - r.v1)
    } else {
        twice
    };
    let [middle, height] = [pole, r.dv()].map(|v| f64::sin_cos_half_turns(0.5 * v).0);
    4.0 * PI * r.du() * middle * height
}

/// Solid angle of a rectangle of a cylinder that spans `fov` radians across and the latitudes ±atan(`half_height`).
///
/// The zone's height is the difference of the sines y/√(1 + y²) of its two latitudes; on one side of the horizon
/// it is written as a quotient without that difference.
pub fn cylindrical(r: Rect, fov: f64, half_height: f64) -> f64 {
    let (a, b) = (
        half_height * (2.0 * r.v0 - 1.0),
        half_height * (2.0 * r.v1 - 1.0),
    );
    let (la, lb) = ((1.0 + a * a).sqrt(), (1.0 + b * b).sqrt());
    let width = 2.0 * half_height * r.dv();
    let zone = if a * b > 0.0 {
        width * (a + b) / ((a * lb + b * la) * la * lb)
    } else {
        b / lb - a / la
    };
    fov * r.du() * zone
}

/// A rectangle inside one quadrant of the square, measured from that quadrant's outer corner:
/// a = ½ - |u - ½| and b = ½ - |v - ½|, both in [0, ½].
///
/// In |p| = 1 - 2a and |q| = 1 - 2b the near corner (of the center) is (a1, b1), the far one (a0, b0).
#[derive(Clone, Copy)]
struct Quarter {
    a0: f64,
    a1: f64,
    b0: f64,
    b1: f64,
}

impl Quarter {
    /// Sum of `f` over the parts of `r` in the four quadrants. Every map here has their symmetry.
    fn sum(r: Rect, f: impl Fn(Self) -> f64) -> f64 {
        let (us, vs) = (fold(r.u0, r.u1), fold(r.v0, r.v1));
        let mut sum = 0.0;
        for [a0, a1] in us {
            for [b0, b1] in vs {
                if a0 < a1 && b0 < b1 {
                    sum += f(Self { a0, a1, b0, b1 });
                }
            }
        }
        sum
    }

    /// The mirror image in the diagonal.
    fn swap(self) -> Self {
        Self {
            a0: self.b0,
            a1: self.b1,
            b0: self.a0,
            b1: self.a1,
        }
    }

    /// Two halves, cut across the longer side.
    fn halves(self) -> [Self; 2] {
        if self.a1 - self.a0 >= self.b1 - self.b0 {
            let m = 0.5 * (self.a0 + self.a1);
            [Self { a1: m, ..self }, Self { a0: m, ..self }]
        } else {
            let m = 0.5 * (self.b0 + self.b1);
            [Self { b1: m, ..self }, Self { b0: m, ..self }]
        }
    }
}

/// The parts of an interval in the two halves of [0, 1], each as distances from its end of it.
fn fold(x0: f64, x1: f64) -> [[f64; 2]; 2] {
    [
        [x0.min(0.5), x1.min(0.5)],
        [1.0 - x1.max(0.5), 1.0 - x0.max(0.5)],
    ]
}
