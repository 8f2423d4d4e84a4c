//! The concentric map: the hemisphere in a square, each texel of one solid angle.
//!
//! Source: Shirley and Chiu 1997, A Low Distortion Map Between Disk and Square: squares about the center become circles,
//! r = max(|p|, |q|), with the azimuth (π/4) of the ratio of the smaller to the larger coordinate from the nearer
//! axis; then the equal-area disk, z = 1 - r².
//!
//! Domain: directions with z ≥ 0, else NaN. No singular point; its creases are the diagonals. It is the inner diamond
//! of the equal-area octahedral map, turned by 45°, and as `hemioctahedral` is to `octahedral`.

use super::equal_area::radius;
use super::hemioctahedral::DIAGONALS;
use crate::geometry::solid_angle::Rect;
use crate::number::real::{Real, max, min};
use crate::projections::projection::{Coverage, Info, Projection, Seam, Uv};
use std::f64::consts::{FRAC_PI_4, PI, SQRT_2};

/// The hemisphere in equal areas.
#[derive(Clone, Copy, Debug)]
pub struct Concentric;

impl Projection for Concentric {
    const INFO: Info = Info {
        name: "concentric",
        title: "Concentric map of a hemisphere",
        known_as: &["shirley_chiu"],
        source: "Shirley and Chiu 1997, A Low Distortion Map Between Disk and Square",
        summary: "The hemisphere in a square, texels of one solid angle; sky domes, and samples of lobes.",
        singular: "None; its creases are the diagonals.",
        axes: "+x +y +z",
        equal_area: true,
        creases: &DIAGONALS,
        ..Info::PLAIN
    };

    fn with_parameters(_: &[f64]) -> Self {
        Concentric
    }

    fn coverage(self) -> Coverage {
        Coverage::Hemisphere
    }

    fn density_range(self) -> (f64, f64) {
        (2.0 * PI, 2.0 * PI)
    }

    fn seam(self) -> Seam {
        Seam::Ends
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let r = radius([x, y, z]);
        let (a, b) = (x.abs(), y.abs());
        let along_x = a.at_least(b);
        let minor = r * (R::half_turns(min(a, b), max(a, b)) * R::new(4.0));
        let p = R::choose(along_x, r, minor);
        let q = R::choose(along_x, minor, r);
        let zero = R::ZERO;
        let seen = z.at_least(zero);
        let edge = R::ONE;
        let (p, q) = (
            R::choose(p.more(edge), edge, p),
            R::choose(q.more(edge), edge, q),
        );
        let nan = R::NAN;
        Uv::centered(
            R::choose(seen, p.negated_if(x.less(zero)), nan),
            R::choose(seen, q.negated_if(y.less(zero)), nan),
            zero,
        )
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (zero, one) = (R::ZERO, R::ONE);
        let (p, q) = uv.pq();
        let (a, b) = (p.abs(), q.abs());
        let along_x = a.at_least(b);
        // One condition tells all four apart: `max` and `min` would both take b where they are equal, and its derivatives.
        let (r, minor) = (R::choose(along_x, a, b), R::choose(along_x, b, a));
        let outside = r.more(zero);
        let divisor = R::choose(outside, r, one);
        let (sin, cos) = R::sin_cos_half_turns(minor / (divisor * R::new(4.0)));
        let flat = r * (R::TWO - r * r).sqrt();
        let near = cos * flat;
        // At the center the derivatives are those along the p axis.
        let far = (sin * flat).with_slope_of(!outside, || minor * R::new(FRAC_PI_4 * SQRT_2));
        let x = R::choose(along_x, near, far);
        let y = R::choose(along_x, far, near);
        [
            x.negated_if(p.less(zero)),
            y.negated_if(q.less(zero)),
            (one - r) * (one + r),
        ]
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        2.0 * PI * rect.area()
    }

    #[inline(always)]
    fn density<R: Real>(self, _: Uv<R>) -> R {
        R::new(2.0 * PI)
    }
}
