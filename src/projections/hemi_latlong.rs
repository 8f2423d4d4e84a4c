//! Latitude-longitude of the upper hemisphere: skies over a ground.
//!
//! Source: the `skylatlong` of sky databases (skylibs, Laval HDR sky database): u is the longitude, v twice the angle from
//! the zenith over π. As `hemioctahedral` is the upper half of `octahedral`, this is that of `latlong`; the front half,
//! which VR180 cameras store, is a crop of a latlong.
//!
//! Domain: directions up to the horizon, else NaN. Singular: the zenith, a whole row, where u = ½; u jumps from 1 to 0
//! behind the viewer, and the seam itself (x = ±0) has u = 0.

use super::cylindrical::longitude;
use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::number::real::Real;
use crate::projections::projection::{Coverage, Info, Projection, Seam, Uv};
use std::f64::consts::PI;

/// The panorama of a sky.
#[derive(Clone, Copy, Debug)]
pub struct HemiLatlong;

impl Projection for HemiLatlong {
    const INFO: Info = Info {
        name: "hemi_latlong",
        title: "Latitude-longitude of the upper hemisphere",
        source: "skylatlong of skylibs and of the Laval HDR sky database; u = atan2(x, z)/2pi + 1/2, v = 2 theta/pi",
        summary: "Longitude along a row, zenith to horizon down the rows: skies over a ground.",
        singular: "The zenith, where u = 1/2; at the seam u = 0.",
        axes: "+x -y -z",
        aspect: (4, 1),
        smooth: true,
        ..Info::PLAIN
    };
    const EVEN_ROWS: bool = true;

    const COMMON: bool = false;

    fn with_parameters(_: &[f64]) -> Self {
        HemiLatlong
    }

    fn graticule(self) -> Option<f64> {
        Some(1.0)
    }

    fn coverage(self) -> Coverage {
        Coverage::Part(2.0 * PI)
    }

    fn density_range(self) -> (f64, f64) {
        (0.0, PI * PI)
    }

    fn seam(self) -> Seam {
        Seam::Cuts
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let half = R::HALF;
        let (longitude, h) = longitude(x, z);
        let v = R::half_turns(h, -y) * R::TWO;
        let (below, nan) = (y.more(R::ZERO), R::NAN);
        Uv::flat(
            R::select(below, nan, half + longitude * half),
            R::select(below, nan, v.clamped(0.0, 1.0)),
        )
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, _) = uv.pq();
        let (sin_longitude, cos_longitude) = R::sin_cos_half_turns(p);
        let (sin, cos) = R::sin_cos_half_turns(uv.v * R::HALF);
        [sin * sin_longitude, -cos, sin * cos_longitude]
    }

    /// Over the zenith half a turn around; below the horizon the horizon.
    fn beyond(self, uv: Uv<f64>) -> Uv<f64> {
        let u = uv.u + if uv.v < 0.0 { 0.5 } else { 0.0 };
        Uv::flat(u.rem_euclid(1.0), uv.v.abs().min(1.0))
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        solid_angle::latlong(Rect {
            v0: 0.5 * rect.v0,
            v1: 0.5 * rect.v1,
            ..rect
        })
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        let (sin, _) = R::sin_cos_half_turns(uv.v * R::HALF);
        R::new(PI * PI) * sin
    }
}
