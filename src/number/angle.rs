//! Angles in radians, from the library's own functions: for constructors of maps, solid angles and all else that is no formula of a map.
//!
//! The last bit of a system's sine differs from one C library and one CPU to another, and what is found with it is in every result.

use crate::number::real::Real;
use std::f64::consts::PI;

/// Sine and cosine. Not inlined, as little as the system's: there are many callers.
#[inline(never)]
pub fn sin_cos(angle: f64) -> (f64, f64) {
    f64::sin_cos_half_turns(angle / PI)
}

/// The sine.
pub fn sin(angle: f64) -> f64 {
    sin_cos(angle).0
}

/// The cosine.
pub fn cos(angle: f64) -> f64 {
    sin_cos(angle).1
}

/// The tangent.
pub fn tan(angle: f64) -> f64 {
    let (sin, cos) = sin_cos(angle);
    sin / cos
}

/// The angle of a radius of the plane at distance 1.
pub fn atan(r: f64) -> f64 {
    PI * f64::half_turns(r, 1.0)
}

/// The angle of (x, y) from the first axis, from -π to π. Not inlined either.
#[inline(never)]
pub fn atan2(y: f64, x: f64) -> f64 {
    (PI * f64::half_turns(y.abs(), x)).copysign(y)
}

/// The angle of a sine of at least 0, up to π/2.
pub fn asin(sin: f64) -> f64 {
    atan2(sin, ((1.0 - sin) * (1.0 + sin)).sqrt())
}

/// The angle of a cosine, from 0 to π.
pub fn acos(cos: f64) -> f64 {
    PI * f64::half_turns(((1.0 - cos) * (1.0 + cos)).sqrt(), cos)
}

/// The length of a vector of ordinary numbers.
pub fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

#[cfg(test)]
mod tests {
    use super::{acos, asin, atan, atan2, cos, length, sin, sin_cos, tan};
    use std::f64::consts::PI;

    #[test]
    fn they_are_the_functions_of_these_names() {
        for k in 0..=1000 {
            let angle = PI * f64::from(k) / 1000.0;
            let (sine, cosine) = sin_cos(angle);
            // Two roundings of the angle, and their own.
            assert!((sine - angle.sin()).abs() < 1e-15 && (cosine - angle.cos()).abs() < 1e-15);
            assert_eq!((sin(angle), cos(angle)), (sine, cosine));
            assert!((acos(cosine) - angle).abs() < 1e-7);
            assert!((length(sine, cosine) - 1.0).abs() < 1e-15);
            for signed in [angle, -angle] {
                let (y, x) = signed.sin_cos();
                // Three units of the quotient, and that of π.
                assert!((atan2(y, x) - y.atan2(x)).abs() <= 4.0 * f64::EPSILON * angle);
            }
            if k < 490 {
                let bound = 4.0 * f64::EPSILON / angle.cos();
                assert!((asin(angle.sin()) - angle.sin().asin()).abs() <= bound * angle);
            }
            if k < 490 {
                assert!((tan(angle) - angle.tan()).abs() < 1e-14 * (1.0 + angle.tan().powi(2)));
                assert!((atan(angle.tan()) - angle).abs() < 1e-15);
            }
        }
        assert_eq!(atan(f64::INFINITY), PI / 2.0);
    }
}
