//! What the lens models share: fisheyes whose image radius is a growing function of the angle from the axis.
//!
//! Their images are disks, and the rim is at `fov`/2. Texels inside are integrated by rules that check themselves,
//! those at the rim along the azimuth over bands of closed form.

use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::number::angle;
use crate::projections::projection::Parameter;
use std::f64::consts::PI;

/// The angle that the image's diameter spans.
pub const fn fov(default: f64, maximum: f64) -> Parameter {
    Parameter {
        name: "fov",
        default,
        above: 0.0,
        maximum,
        unit: "degrees",
        doc: "the angle that the image's diameter spans",
    }
}

/// How far the slope of the image radius may fall below that of its chord. Below, the lens turns back so nearly that a
/// radius rounded by ε moves an angle by a hundred.
pub const LEAST_SLOPE: f64 = 0.01;

/// Whether the image radius grows all the way from the axis to `rim`, an angle; if not, a message. Where there is no image the slope is 0.
pub fn grows(rim: f64, slope: &dyn Fn(f64) -> f64, radius: f64, names: &str) -> Result<(), String> {
    let least = LEAST_SLOPE * radius / rim;
    // A radius below 0 is that of a lens whose image ended before.
    let slow = if radius > 0.0 {
        first_at_most(least, rim, slope)
    } else {
        Some(rim)
    };
    let Some(slow) = slow else {
        return Ok(());
    };
    // At its end a lens turns back, or its image runs away from all that lies before. A slope of 0 is what rounding makes of it.
    let found = match first_at_most(1e-9 * slope(0.0), PI, slope) {
        Some(end) if end <= rim => format!("stops growing at {:.4}", end.to_degrees()),
        Some(end) if slow == 0.0 || slope(rim) <= least => {
            format!("stops growing at {:.4}, too near to that", end.to_degrees())
        }
        _ => format!("all but stops growing at {:.4}", slow.to_degrees()),
    };
    Err(format!(
        "Expected {names} of a lens whose image radius grows up to `fov`/2 = {} degrees from the axis, got one that \
         {found}.",
        (rim.to_degrees() * 1e9).round() / 1e9
    ))
}

/// The first angle up to `end` at which a slope is at most `least`.
fn first_at_most(least: f64, end: f64, slope: &dyn Fn(f64) -> f64) -> Option<f64> {
    const STEPS: usize = 2048;
    let at = |k: usize| end * k as f64 / STEPS as f64;
    // What is not a number does not grow.
    let stands = |angle: f64| {
        let slope = slope(angle);
        slope.is_nan() || slope <= least
    };
    let k = (0..=STEPS).find(|&k| stands(at(k)))?;
    let (mut low, mut high) = (at(k.saturating_sub(1)), at(k));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if stands(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    Some(high)
}

/// The smallest and the largest value of a smooth function on [0, end].
pub fn extremes(end: f64, f: &dyn Fn(f64) -> f64) -> (f64, f64) {
    const STEPS: usize = 512;
    let at = |k: usize| end * k as f64 / STEPS as f64;
    let largest = |sign: f64| {
        let g = |x: f64| sign * f(x);
        let best = (0..=STEPS)
            .max_by(|&a, &b| g(at(a)).total_cmp(&g(at(b))))
            .unwrap_or(0);
        let (mut low, mut high) = (at(best.saturating_sub(1)), at((best + 1).min(STEPS)));
        for _ in 0..80 {
            let third = (high - low) / 3.0;
            if g(low + third) < g(high - third) {
                low += third;
            } else {
                high -= third;
            }
        }
        sign * g(at(best)).max(g(0.5 * (low + high)))
    };
    (largest(-1.0), largest(1.0))
}

/// cos a - cos b, without that difference.
pub fn band(a: f64, b: f64) -> f64 {
    2.0 * angle::sin(0.5 * (a + b)) * angle::sin(0.5 * (b - a))
}

/// Whether a rectangle is small and lies in the disk.
pub fn is_smooth(rect: Rect) -> bool {
    solid_angle::is_small(rect) && is_in_disk(rect)
}

fn is_in_disk(rect: Rect) -> bool {
    let far = |a: f64, b: f64| (2.0 * a - 1.0).abs().max((2.0 * b - 1.0).abs());
    let (p, q) = (far(rect.u0, rect.u1), far(rect.v0, rect.v1));
    p * p + q * q < 1.0
}

/// The solid angle of a rectangle of an image whose disk shows the angles `theta(r)` from the axis.
pub fn solid_angle(
    rect: Rect,
    density: impl Fn(f64, f64) -> f64,
    theta: impl Fn(f64) -> f64,
) -> f64 {
    if is_smooth(rect) {
        return solid_angle::smooth(rect, density);
    }
    if is_in_disk(rect) {
        return solid_angle::quadrature(rect, &density);
    }
    solid_angle::bands(rect, |inner, outer| {
        band(theta(inner), theta(outer)).max(0.0)
    })
}

/// `fov` in degrees as the angle of the rim in radians.
pub fn rim(fov: f64) -> f64 {
    fov / 360.0 * PI
}
