//! The equi-angular cube (EAC): texels of a face are equal steps of angle about the cube's axes.
//!
//! Source: w(p) = tan(πp/4); Bitterli and others before Google's "Bringing pixels front and center in VR video" (2017) gave it
//! its name. S2's tangent projection is the same map.
//!
//! Domain: all directions; no singular point; the density varies 1.414:1.

use crate::number::real::Real;
use crate::projections::common::warped_cube::{Names, Warp, Warped};
use std::f64::consts::{FRAC_PI_4, PI, SQRT_2};

/// w(p) = tan(πp/4).
#[derive(Clone, Copy, Debug)]
pub struct Equiangular;

/// The equi-angular cube map.
pub type CubeEquiangular = Warped<Equiangular>;

impl Warp for Equiangular {
    const NAMES: Names = Names {
        name: "cube_equiangular",
        title: "Equi-angular cube map (EAC)",
        known_as: &["eac"],
        source: "Google 2017, Bringing pixels front and center in VR video; S2's tangent projection",
        summary: "Six faces in equal steps of angle; 360-degree video, and texels within 1.42:1 of one solid angle.",
        smooth: true,
        creases: &[],
    };

    fn density_range() -> (f64, f64) {
        let middle = 0.25 * PI * PI;
        // Smallest at the middles of edges; corners have 4·3^(-3/2) = 0.77 of the middle's.
        (middle / SQRT_2, middle)
    }

    #[inline(always)]
    fn to_plane<R: Real>(p: R) -> R {
        let (sin, cos) = R::sin_cos_half_turns(p * R::new(0.25));
        sin / cos
    }

    #[inline(always)]
    fn from_plane<R: Real>(component: R, major: R) -> R {
        let p = R::half_turns(component.abs(), major) * R::new(4.0);
        p.negated_if(component.less(R::ZERO))
    }

    #[inline(always)]
    fn slope<R: Real>(_: R, plane: R) -> R {
        R::new(FRAC_PI_4) * (R::ONE + plane * plane)
    }

    fn width(p0: f64, p1: f64, difference: f64) -> f64 {
        let [(sin, _), (_, cos0), (_, cos1)] =
            [difference, p0, p1].map(|p| f64::sin_cos_half_turns(0.25 * p));
        sin / (cos0 * cos1)
    }
}
