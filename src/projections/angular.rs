//! Debevec's angular map (light probe): the distance from the center is the angle from the axis.
//!
//! Source: Debevec 1998 and the Light Probe Image Gallery: r = acos(Dz)/(π √(Dx² + Dy²)), u = ½ + Dx r/2,
//! v = ½ + Dy r/2. With a field of view below 360° it is the equidistant fisheye.
//!
//! Domain: all directions within fov/2 of the axis, else NaN. Singular: at 360° the direction opposite
//! the axis fills the rim and encodes to (1, ½). The center is no singular point, though the printed
//! form is 0/0 there.
//!
//! acos loses half the digits near ±z (2.4e-4 rad in f32); the angle is atan2(h, z) instead.

use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::number::angle;
use crate::number::real::{Real, min, scaled};
use crate::projections::common::lens;
use crate::projections::projection::{Coverage, Info, Outline, Projection, Seam, Uv};
use std::f64::consts::PI;

/// The light probe, or equidistant fisheye.
#[derive(Clone, Copy, Debug)]
pub struct Angular {
    /// The angle that the image's radius stands for, in half turns: fov/360°.
    pub(super) rim: f64,
}

/// sin(π√s)/(π√s) for s from 0 to 1, to rounding at 1 as well, where it is 0: (1 - s) times what is left of the series.
fn sinc(s: f64) -> f64 {
    // The coefficients of sin(π√s)/(π√s), fourteen of which and the sums of all that follow count, sum to 0.
    const REST: [f64; 14] = {
        let mut terms = [1.0; 24];
        let mut k = 1;
        while k < terms.len() {
            terms[k] = -terms[k - 1] * (PI * PI) / ((2 * k) as f64 * (2 * k + 1) as f64);
            k += 1;
        }
        let (mut rest, mut tail) = ([0.0; 14], 0.0);
        while k > 1 {
            k -= 1;
            tail -= terms[k];
            if k <= rest.len() {
                rest[k - 1] = tail;
            }
        }
        rest
    };
    let sum = REST.into_iter().rev().reduce(|sum, term| sum * s + term);
    (1.0 - s) * sum.unwrap_or_default()
}

impl Projection for Angular {
    const INFO: Info = Info {
        name: "angular",
        title: "Angular map (light probe)",
        known_as: &["light_probe", "angular_map", "equidistant", "fisheye"],
        source: "Debevec 1998, Rendering Synthetic Objects into Real Scenes; Light Probe Image Gallery",
        summary: "Distance from the center is the angle from the axis; light probes and equidistant fisheyes.",
        singular: "At fov = 360 the direction opposite the axis fills the whole rim; it encodes to (1, 1/2).",
        axes: "+x -y -z",
        outline: Outline::Disk,
        parameters: &[lens::fov(360.0, 360.0)],
        smooth: true,
        ..Info::PLAIN
    };

    fn with_parameters(parameters: &[f64]) -> Self {
        Angular {
            rim: parameters[0] / 360.0,
        }
    }

    fn coverage(self) -> Coverage {
        if self.rim == 1.0 {
            Coverage::Sphere
        } else {
            Coverage::Cap(PI * self.rim)
        }
    }

    fn density_range(self) -> (f64, f64) {
        let full = 4.0 * PI * PI * self.rim * self.rim;
        // sin(π)/π is 0 and not what a rounded π gives.
        let rim = if self.rim == 1.0 {
            0.0
        } else {
            angle::sin(PI * self.rim) / (PI * self.rim)
        };
        (full * rim, full)
    }

    fn seam(self) -> Seam {
        if self.rim == 1.0 {
            Seam::RimOpposite
        } else {
            Seam::Ends
        }
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let (zero, one) = (R::ZERO, R::ONE);
        let (xs, ys, unscale) = scaled(x, y);
        let hs = (xs * xs + ys * ys).sqrt();
        // On the axis the azimuth is that of (1, 0).
        let on_axis = R::select(hs.vanishes(), one, zero);
        let radius = R::half_turns(hs * unscale, z) * R::new(1.0 / self.rim);
        let inside = radius.at_most(R::new(1.0 + 2.0 * R::epsilon()));
        let factor = radius / (hs + on_axis);
        Uv::held((xs + on_axis) * factor, ys * factor, inside)
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, q) = uv.pq();
        let rim = R::new(self.rim);
        let (a, b) = (p * rim, q * rim);
        let s = a * a + b * b;
        let one = R::ONE;
        let s = min(s, one);
        let r = s.sqrt();
        let sinc = R::sinc_half_turns(s, r);
        [a * sinc, b * sinc, R::cos_half_turns(s, r)]
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        let (rim, square) = (self.rim * PI, self.rim * self.rim);
        solid_angle::azimuthal(
            rect,
            |s| 4.0 * rim * rim * sinc(square * s).max(0.0),
            // (1 - cos x)/s = 2 sin²(x/2)/s.
            |s| 0.5 * rim * rim * sinc(0.25 * square * s).powi(2),
        )
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        let (p, q) = uv.pq();
        let rim = R::new(self.rim);
        let s = (p * p + q * q) * rim * rim;
        let one = R::ONE;
        let s = min(s, one);
        let r = s.sqrt();
        // sin πr as 2 sin(πr/2) cos(πr/2): with the sine alone, the compiler branches between its two
        // polynomials and does not vectorize.
        let (sin, cos) = R::sin_cos_half_turns(r * R::HALF);
        let center = r.less(R::new(1e-9));
        let divisor = R::select(center, one, r);
        let sinc = R::select(center, R::new(PI), R::TWO * sin * cos / divisor);
        R::new(4.0 * PI) * rim * rim * sinc
    }
}

#[cfg(test)]
mod tests {
    use super::sinc;
    use std::f64::consts::PI;

    #[test]
    fn sinc_is_the_sine_over_its_angle() {
        assert_eq!((sinc(0.0), sinc(1.0)), (1.0, 0.0));
        for k in 1..1000 {
            let r = f64::from(k) / 1000.0;
            // The sine of what is left to π has all of its digits.
            let want = (PI * r.min(1.0 - r)).sin() / (PI * r);
            // 1 - r² loses one near 1.
            let bound = 4.0 * f64::EPSILON + f64::EPSILON / (1.0 - r);
            let got = sinc(r * r);
            assert!((got / want - 1.0).abs() < bound, "{r} {got} {want}");
        }
    }
}
