//! The equisolid-angle fisheye: each texel sees the same solid angle.
//!
//! Source: Lambert's azimuthal equal-area map, r = sin(θ/2)/sin(fov/4), as makers of fisheye lenses state
//! it (r = 2f sin(θ/2)). At 360° it is the mirror ball seen from inside, and shares that map's formula.
//!
//! Domain: all directions within fov/2 of the axis, else NaN. Singular: at 360° the direction opposite
//! the axis fills the rim and encodes to (1, ½), and a coordinate rounded by ε moves a direction there by √ε.

use super::sphere::{from_disk, to_disk};
use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::number::real::Real;
use crate::projections::common::lens;
use crate::projections::projection::{Coverage, Info, Outline, Projection, Seam, Uv};
use std::f64::consts::PI;

/// A fisheye of constant density.
#[derive(Clone, Copy, Debug)]
pub struct Equisolid {
    /// The angle of the rim from the axis, in half turns.
    angle: f64,
    /// The sine of half that angle.
    rim: f64,
}

impl Projection for Equisolid {
    const INFO: Info = Info {
        name: "equisolid",
        title: "Equisolid-angle fisheye",
        known_as: &["lambert", "laea"],
        source: "Lambert 1772, azimuthal equal-area; r = 2f sin(theta/2) of fisheye lenses (Ray 2002)",
        summary: "Fisheye whose texels all see the same solid angle; most photographic fisheye lenses.",
        singular: "At fov = 360 the direction opposite the axis fills the whole rim; it encodes to (1, 1/2).",
        axes: "+x -y -z",
        outline: Outline::Disk,
        equal_area: true,
        parameters: &[lens::fov(180.0, 360.0)],
        smooth: true,
        ..Info::PLAIN
    };
    const MEMORY_BOUND: bool = true;

    fn with_parameters(parameters: &[f64]) -> Self {
        let angle = parameters[0] / 360.0;
        Equisolid {
            angle,
            rim: f64::sin_cos_half_turns(0.5 * angle).0,
        }
    }

    fn coverage(self) -> Coverage {
        if self.angle == 1.0 {
            Coverage::Sphere
        } else {
            Coverage::Cap(PI * self.angle)
        }
    }

    fn density_range(self) -> (f64, f64) {
        let density = 16.0 * self.rim * self.rim;
        (density, density)
    }

    fn seam(self) -> Seam {
        if self.angle == 1.0 {
            Seam::RimOpposite
        } else {
            Seam::Ends
        }
    }

    #[inline(always)]
    fn encode<R: Real>(self, d: [R; 3]) -> Uv<R> {
        let (p, q) = to_disk(d, self.rim);
        Uv::in_disk(p, q, R::truth(true))
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, q) = uv.pq();
        from_disk(p * R::new(self.rim), q * R::new(self.rim))
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        16.0 * self.rim * self.rim * solid_angle::disk_area(rect)
    }

    #[inline(always)]
    fn density<R: Real>(self, _: Uv<R>) -> R {
        R::new(16.0 * self.rim * self.rim)
    }
}
