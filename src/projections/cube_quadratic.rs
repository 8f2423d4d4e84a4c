//! The cube with S2's quadratic warp: nearly even texels for the price of a square root.
//!
//! Source: Google's S2 geometry library, `S2_QUADRATIC_PROJECTION`: u = (4s² - 1)/3 for s ≥ ½ and its mirror image below, which
//! with p = 2s - 1 is w(p) = p(|p| + 2)/3.
//!
//! Domain: all directions; no singular point; the density varies 2.10:1, with its maximum on the diagonals where
//! w = (√5 - 1)/4.
//!
//! The inverse √(1 + 3w) - 1 loses the digits of a small w; it is written as 3w/(√(1 + 3w) + 1).

use crate::number::real::Real;
use crate::projections::common::warped_cube::{Names, Warp, Warped};

/// w(p) = p(|p| + 2)/3.
#[derive(Clone, Copy, Debug)]
pub struct Quadratic;

/// S2's cube map.
pub type CubeQuadratic = Warped<Quadratic>;

impl Warp for Quadratic {
    const NAMES: Names = Names {
        name: "cube_quadratic",
        title: "Cube map with S2's quadratic warp",
        known_as: &["s2"],
        source: "Google S2 geometry library, S2_QUADRATIC_PROJECTION",
        summary: "Six faces, nearly even texels without trigonometry; cells of S2.",
        smooth: false,
        // |p| and |q|.
        creases: &[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    };
    const MEMORY_BOUND: bool = true;

    fn density_range() -> (f64, f64) {
        let middle = 16.0 / 9.0;
        let w = (5f64.sqrt() - 1.0) / 4.0;
        let square = 1.0 + 2.0 * w * w;
        let steepest = (1.0 + 3.0 * w) / (square * square.sqrt());
        (middle / 2f64.sqrt(), middle * steepest)
    }

    #[inline(always)]
    fn to_plane<R: Real>(p: R) -> R {
        p * (p.abs() + R::TWO) * R::new(1.0 / 3.0)
    }

    #[inline(always)]
    fn from_plane<R: Real>(component: R, major: R) -> R {
        let triple = component * R::new(3.0);
        triple / (major + (major * (major + triple.abs())).sqrt())
    }

    #[inline(always)]
    fn slope<R: Real>(p: R, _: R) -> R {
        (p.abs() + R::ONE) * R::new(2.0 / 3.0)
    }

    fn width(p0: f64, p1: f64, difference: f64) -> f64 {
        if p0 < 0.0 && p1 > 0.0 {
            Self::to_plane(p1) - Self::to_plane(p0)
        } else {
            difference * (p0.abs() + p1.abs() + 2.0) / 3.0
        }
    }
}
