//! Dual fisheye: two lenses back to back, as 360° cameras record them.
//!
//! Source: two equidistant fisheyes r = θ/(fov/2), θ from each lens's own axis; ffmpeg's `dfisheye` and the raw pictures
//! of two-lens cameras. Face 0 looks forward, face 1 backward, each unmirrored and upright as its lens sees the world:
//! what is right in the one is left in the other.
//!
//! Domain: all directions where fov ≥ 180, else those within fov/2 of either axis. Above 180° the pictures overlap.
//! `encode` takes the face whose hemisphere a direction lies in, z = 0 the first; `decode` gives the direction of every
//! place in either disk. Each direction is counted once: what a texel shows of the other hemisphere is not part of
//! its solid angle, though its density is as it is. Singular: none.

use super::angular::Angular;
use crate::geometry::solid_angle::Rect;
use crate::number::real::Real;
use crate::projections::common::lens;
use crate::projections::faces::STRIP_AND_COLUMN;
use crate::projections::projection::{Coverage, Info, Outline, Projection, Seam, Uv};

/// Two lenses back to back.
#[derive(Clone, Copy, Debug)]
pub struct DualFisheye {
    /// Either of them.
    lens: Angular,
}

impl Projection for DualFisheye {
    const INFO: Info = Info {
        name: "dual_fisheye",
        title: "Dual fisheye",
        known_as: &["dfisheye"],
        source: "Two equidistant fisheyes back to back; ffmpeg v360 dfisheye",
        summary: "The raw picture of a 360 camera: two equidistant fisheyes back to back, overlapping above 180 degrees.",
        singular: "None; z = 0 belongs to the first face.",
        axes: "+x -y -z",
        faces: 2,
        layouts: STRIP_AND_COLUMN,
        outline: Outline::Disk,
        parameters: &[lens::fov(180.0, 270.0)],
        ..Info::PLAIN
    };

    const COMMON: bool = false;

    fn with_parameters(parameters: &[f64]) -> Self {
        DualFisheye {
            lens: Angular::with_parameters(parameters),
        }
    }

    fn coverage(self) -> Coverage {
        if self.lens.rim < 0.5 {
            Coverage::Part(2.0 * self.lens.coverage().solid_angle())
        } else {
            Coverage::Sphere
        }
    }

    fn density_range(self) -> (f64, f64) {
        self.lens.density_range()
    }

    fn seam(self) -> Seam {
        if self.lens.rim == 0.5 {
            Seam::RimOtherFaceFlipped
        } else {
            Seam::Ends
        }
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let behind = z.less(R::ZERO);
        let uv = self.lens.encode([x.negated_if(behind), y, z.abs()]);
        let face = R::select(behind, R::ONE, R::ZERO);
        Uv { face, ..uv }
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let [x, y, z] = self.lens.decode(uv);
        let behind = uv.face.more(R::HALF);
        [x.negated_if(behind), y, z.negated_if(behind)]
    }

    fn own_radius(self) -> f64 {
        (0.25 / self.lens.rim).min(0.5)
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        // Above 180° the own hemisphere is the disk of a lens of 180°, within the square by this factor.
        let grow = 0.5 / self.own_radius();
        let own = |x: f64| (0.5 + (x - 0.5) * grow).clamp(0.0, 1.0);
        let rect = Rect {
            u0: own(rect.u0),
            u1: own(rect.u1),
            v0: own(rect.v0),
            v1: own(rect.v1),
        };
        Angular {
            rim: self.lens.rim / grow,
        }
        .solid_angle(rect)
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        self.lens.density(uv)
    }
}
