//! Dual paraboloid: two faces, each the stereographic image of a hemisphere.
//!
//! Source: Heidrich & Seidel 1998, View-independent Environment Maps, equations 1 and 2: a mirrored
//! paraboloid shows (x, y)/(1 + |z|); u = x/m + ½, v = y/m + ½ with m = 2(1 + |z|). Face 0 holds z ≥ 0,
//! face 1 the rest, not flipped. Each face is stereographic projection, so the map is conformal.
//!
//! Domain: all directions. Valid inside each face's disk. No singular point; the density varies 4:1.

use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::number::real::Real;
use crate::projections::faces::{LayoutSpec, STRIP_AND_COLUMN};
use crate::projections::projection::{Coverage, Info, Outline, Projection, Seam, Uv};

/// The two paraboloids.
#[derive(Clone, Copy, Debug)]
pub struct DualParaboloid;

const LAYOUTS: &[LayoutSpec] = STRIP_AND_COLUMN;

impl Projection for DualParaboloid {
    const INFO: Info = Info {
        name: "dual_paraboloid",
        title: "Dual paraboloid",
        known_as: &["paraboloid"],
        source: "Heidrich, Seidel 1998, View-independent Environment Maps, eq. 1-2",
        summary: "Two mirrored paraboloids, each a stereographic hemisphere; reflection lookups in one pass.",
        singular: "None; the two rims are one circle.",
        axes: "+x -y +z",
        faces: 2,
        layouts: LAYOUTS,
        outline: Outline::Disk,
        conformal: true,
        smooth: true,
        ..Info::PLAIN
    };
    const MEMORY_BOUND: bool = true;

    fn with_parameters(_: &[f64]) -> Self {
        DualParaboloid
    }

    fn coverage(self) -> Coverage {
        Coverage::Sphere
    }

    fn density_range(self) -> (f64, f64) {
        (4.0, 16.0)
    }

    fn seam(self) -> Seam {
        Seam::RimOtherFace
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let length = (x * x + y * y + z * z).sqrt();
        let inverse = R::ONE / (length + z.abs());
        let face = R::select(z.at_least(R::ZERO), R::ZERO, R::ONE);
        Uv::centered(x * inverse, y * inverse, face)
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, q) = uv.pq();
        let (one, two) = (R::ONE, R::TWO);
        let s = p * p + q * q;
        let inverse = one / (one + s);
        let z = (one - s) * inverse;
        let z = R::either(uv.face.less(R::HALF), || z, || -z);
        [two * p * inverse, two * q * inverse, z]
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        solid_angle::azimuthal(
            rect,
            |s| 16.0 / ((1.0 + s) * (1.0 + s)),
            |s| 2.0 / (1.0 + s),
        )
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        let (p, q) = uv.pq();
        let w = R::ONE + p * p + q * q;
        R::new(16.0) / (w * w)
    }
}
