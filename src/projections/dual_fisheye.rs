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

use super::lens;
use crate::faces::STRIP_AND_COLUMN;
use crate::light::solid_angle::{self, Rect};
use crate::projection::{Coverage, Info, Outline, Projection, Seam, Uv};
use crate::real::{Real, scaled};
use std::f64::consts::PI;

/// Two lenses back to back.
#[derive(Clone, Copy, Debug)]
pub struct DualFisheye {
    /// The angle of each rim from its axis, in half turns.
    rim: f64,
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
        DualFisheye { rim: parameters[0] / 360.0 }
    }

    fn coverage(self) -> Coverage {
        if self.rim < 0.5 {
            Coverage::Part(2.0 * Coverage::Cap(PI * self.rim).solid_angle())
        } else {
            Coverage::Sphere
        }
    }

    fn density_range(self) -> (f64, f64) {
        let full = 4.0 * PI * PI * self.rim * self.rim;
        let (sin, _) = f64::sin_cos_half_turns(self.rim);
        (full * sin / (PI * self.rim), full)
    }

    fn seam(self) -> Seam {
        if self.rim == 0.5 { Seam::RimOtherFaceFlipped } else { Seam::Ends }
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let (zero, one) = (R::new(0.0), R::new(1.0));
        let (xs, ys, unscale) = scaled(x, y);
        let hs = (xs * xs + ys * ys).sqrt();
        // On an axis the azimuth does not matter: the radius is 0.
        let on_axis = if hs.vanishes() { one } else { zero };
        let radius = R::half_turns(hs * unscale, z.abs()) * R::new(1.0 / self.rim);
        let inside = radius <= R::new(1.0 + 2.0 * R::EPSILON);
        let radius = if inside { radius } else { R::new(f64::NAN) };
        let factor = radius / (hs + on_axis);
        let behind = z < zero;
        Uv::centred(
            (xs * factor).clamped(-1.0, 1.0).negated_if(behind),
            (ys * factor).clamped(-1.0, 1.0),
            if behind { one } else { zero },
        )
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, q) = uv.pq();
        let rim = R::new(self.rim);
        let (a, b) = (p * rim, q * rim);
        let s = a * a + b * b;
        let one = R::new(1.0);
        let s = if s < one { s } else { one };
        let r = s.sqrt();
        let sinc = R::sinc_half_turns(s, r);
        let behind = uv.face > R::new(0.5);
        [
            (a * sinc).negated_if(behind),
            b * sinc,
            R::cos_half_turns(s, r).negated_if(behind),
        ]
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        // Above 180° the own hemisphere is the disk of a face of 180°, within the square by this factor.
        let grow = (2.0 * self.rim).max(1.0);
        let rim = PI * self.rim / grow;
        let own = |x: f64| (0.5 + (x - 0.5) * grow).clamp(0.0, 1.0);
        let rect = Rect { u0: own(rect.u0), u1: own(rect.u1), v0: own(rect.v0), v1: own(rect.v1) };
        let sinc = |x: f64| if x < 1e-9 { 1.0 } else { x.sin() / x };
        solid_angle::azimuthal(
            rect,
            |s| 4.0 * rim * rim * sinc(rim * s.sqrt()),
            |s| 0.5 * rim * rim * sinc(0.5 * rim * s.sqrt()).powi(2),
        )
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        let (p, q) = uv.pq();
        let rim = R::new(self.rim);
        let s = (p * p + q * q) * rim * rim;
        let one = R::new(1.0);
        let s = if s < one { s } else { one };
        R::new(4.0 * PI) * rim * rim * R::sinc_half_turns(s, s.sqrt())
    }
}
