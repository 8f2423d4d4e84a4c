//! Hammer (Hammer–Aitoff): the whole sphere in an ellipse, every texel the same solid angle, round at the rim.
//!
//! Source: Hammer 1892; Snyder 1987, Map Projections: A Working Manual, p. 182 (and his Aitoff of FITS sky maps, which
//! astronomers mean by AIT): Lambert's azimuthal equal-area map of the direction with half the longitude, twice
//! as wide: x = 2√2 cos φ sin(λ/2)/√(1 + cos φ cos(λ/2)), y = √2 sin φ/√(...).
//!
//! Domain: all directions. Singular: none but the poles, where meridians meet; u jumps from one rim to the other behind
//! the viewer, and the seam itself (x = ±0) is the left rim.
//!
//! Half the longitude is taken by roots, cos(λ/2) = √((1 + cos λ)/2), of the larger of sine and cosine; the other
//! follows from sin λ = 2 sin(λ/2) cos(λ/2), so that nothing cancels.

use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::number::real::{Real, max};
use crate::projections::projection::{Coverage, Info, Outline, Projection, Seam, Uv};

/// The equal-area ellipse of half longitudes.
#[derive(Clone, Copy, Debug)]
pub struct Hammer;

impl Projection for Hammer {
    const INFO: Info = Info {
        name: "hammer",
        title: "Hammer (Hammer-Aitoff)",
        known_as: &["hammer_aitoff"],
        source: "Hammer 1892; Snyder 1987, Map Projections: A Working Manual, p. 182; FITS AIT",
        summary: "The whole sphere in an ellipse of equal areas, less sheared at the rim than Mollweide's; sky maps.",
        singular: "The poles, where meridians meet; at the seam the left rim.",
        axes: "+x -y -z",
        aspect: (2, 1),
        outline: Outline::Disk,
        equal_area: true,
        smooth: true,
        // A unit of u is 8 radians at the rim, and not 2π.
        round_trip: (1.25e-6, 2.6e-15),
        ..Info::PLAIN
    };

    const COMMON: bool = false;

    fn with_parameters(_: &[f64]) -> Self {
        Hammer
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
        let (zero, half) = (R::ZERO, R::HALF);
        let ax = x.abs();
        let (xf, yf, zf) = (ax.squarable(), y.squarable(), z.squarable());
        let flat = xf * xf + zf * zf;
        let h = flat.sqrt();
        let square = flat + yf * yf;
        let length = square.sqrt();
        // h times the larger of sin(λ/2) and cos(λ/2), and the other.
        let large = (half * (flat + h * zf.abs())).sqrt();
        let small = half * ax * h / max(large, R::new(1e-30));
        let front = z.at_least(zero);
        let along = R::select(front, small, large);
        let ahead = R::select(front, large, small);
        let n = (square + length * ahead).sqrt();
        let west = x.at_most(zero);
        Uv::centered(
            (along / n).clamped(-1.0, 1.0).negated_if(west),
            (y / n).clamped(-1.0, 1.0),
            zero,
        )
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, q) = uv.pq();
        let (one, two) = (R::ONE, R::TWO);
        // 1 - p² - q²: at the rim its rounding turns the direction.
        let b = (one - p.abs()) * (one + p.abs()) - q * q;
        let n = max(one + b, R::ZERO).sqrt();
        let a = p * n;
        // At the poles, where both vanish, the direction is the axis.
        let h = max(a * a + b * b, R::new(1e-30)).sqrt();
        let x = two * a * b / h;
        [x, q * n, (b - a) * (b + a) / h]
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        16.0 * solid_angle::disk_area(rect)
    }

    #[inline(always)]
    fn density<R: Real>(self, _: Uv<R>) -> R {
        R::new(16.0)
    }
}
