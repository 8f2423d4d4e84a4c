//! Angles in radians for the constructors of maps, from the library's own functions.
//!
//! The last bit of a system's tangent differs from one C library to another, and what a constructor finds with it is in every result.

use crate::number::real::Real;
use std::f64::consts::PI;

/// Sine and cosine.
pub fn sin_cos(angle: f64) -> (f64, f64) {
    f64::sin_cos_half_turns(angle / PI)
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
    use super::{acos, atan, cos, length, sin_cos, tan};
    use std::f64::consts::PI;

    #[test]
    fn they_are_the_functions_of_these_names() {
        for k in 0..=1000 {
            let angle = PI * f64::from(k) / 1000.0;
            let (sin, cosine) = sin_cos(angle);
            // Two roundings of the angle, and their own.
            assert!((sin - angle.sin()).abs() < 1e-15 && (cosine - angle.cos()).abs() < 1e-15);
            assert_eq!(cos(angle), cosine);
            assert!((acos(cosine) - angle).abs() < 1e-7);
            assert!(length(sin, cosine) - 1.0 < 1e-15);
            if k < 490 {
                assert!((tan(angle) - angle.tan()).abs() < 1e-14 * (1.0 + angle.tan().powi(2)));
                assert!((atan(angle.tan()) - angle).abs() < 1e-15);
            }
        }
        assert_eq!(atan(f64::INFINITY), PI / 2.0);
    }
}
