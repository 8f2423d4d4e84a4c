//! Windows: factors that fade high degrees out, so that a bright light does not ring.
//!
//! With x = l/width, a row of [`WINDOWS`] is a function of x that begins with 1, so that degree 0, the mean, stays
//! (Sloan 2008, "Stupid Spherical Harmonics Tricks"): Hann's (1 + cos πx)/2 and Lanczos' sin πx/πx, both 0 from
//! x = 1 on, and Gauss' exp(-(πx)²/12), which has the curvature of the second at 0 and is a function that is never
//! negative in space. Sines and exponentials are the library's own, so that every machine makes the same bits.

use crate::error::Error;
use crate::kernel::memory::expect_room;
use crate::number::real::Real;
use std::f64::consts::PI;

/// A window over degrees.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    /// Its name.
    pub name: &'static str,
    /// What a degree of l = x · width is multiplied by.
    fade: fn(f64) -> f64,
}

/// All windows.
pub const WINDOWS: [Window; 3] = [
    Window {
        name: "hann",
        fade: |x| {
            if x < 1.0 {
                0.5 * (1.0 + f64::sin_cos_half_turns(x).1)
            } else {
                0.0
            }
        },
    },
    Window {
        name: "lanczos",
        fade: |x| match x {
            0.0 => 1.0,
            x if x < 1.0 => f64::sin_cos_half_turns(x).0 / (PI * x),
            _ => 0.0,
        },
    },
    Window {
        name: "gauss",
        fade: |x| decay((PI * x) * (PI * x) / 12.0),
    },
];

/// The window of this name.
///
/// # Errors
/// No window has it.
///
/// ```
/// assert_eq!(spheremap::light::sh::windows::find("hann")?.name, "hann");
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn find(name: &str) -> Result<&'static Window, Error> {
    let found = WINDOWS.iter().find(|window| window.name == name);
    found.ok_or_else(|| Error::unknown("window", name, &WINDOWS.map(|window| window.name)))
}

impl Window {
    /// The factors of degrees 0 to `order`; by default the width is order + 1, the mildest that acts on
    /// all degrees.
    ///
    /// # Errors
    /// The width is not positive, or there is no memory for so many factors.
    ///
    /// ```
    /// use spheremap::light::sh::windows;
    /// assert_eq!(windows::find("hann")?.factors(None, 1)?, [1.0, 0.5]);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn factors(&self, width: Option<f64>, order: usize) -> Result<Vec<f64>, Error> {
        let width = width.unwrap_or(order.saturating_add(1) as f64);
        if width <= 0.0 || width.is_nan() {
            return Err(Error::Contradiction(format!(
                "`width` must be positive, got {width}."
            )));
        }
        expect_room::<f64>(order.saturating_add(1))?;
        Ok((0..=order).map(|l| (self.fade)(l as f64 / width)).collect())
    }
}

/// exp(-x) for x of at least 0.
fn decay(x: f64) -> f64 {
    // Beyond, it is below the smallest number.
    if x > 746.0 {
        return 0.0;
    }
    // One over what grows: a difference of sinh and cosh would cancel. A quarter is within their range.
    let far = x > 300.0;
    let (sinh, cosh) = Real::sinh_cosh(if far { 0.25 * x } else { x });
    let e = 1.0 / (sinh + cosh);
    if far { (e * e) * (e * e) } else { e }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_their_formulas() {
        let gauss = |x: f64| (-(PI * x).powi(2) / 12.0).exp();
        let check = |name: &str, formula: &dyn Fn(f64) -> f64| {
            for width in [0.5, 7.0, 40.0] {
                let got = find(name).unwrap().factors(Some(width), 30).unwrap();
                assert_eq!(got[0], 1.0, "{name}");
                for (l, got) in got.iter().enumerate().skip(1) {
                    let want = formula(l as f64 / width);
                    // Four units of the exponential, two of the sines, of numbers up to 1.
                    assert!((got - want).abs() < 1e-15, "{name} {l}: {got} {want}");
                }
            }
        };
        let below = |x: f64, y: f64| if x < 1.0 { y } else { 0.0 };
        check("hann", &|x| below(x, 0.5 * (1.0 + (PI * x).cos())));
        check("lanczos", &|x| below(x, (PI * x).sin() / (PI * x)));
        check("gauss", &gauss);
        for k in 0..1000 {
            let x = f64::from(k) * 0.75;
            let (got, want) = (decay(x), (-x).exp());
            // Four of the four units of the quarter's, and the rounding of subnormal numbers.
            assert!(
                (got - want).abs() <= 2e-15 * want * 4.0 + 1e-322,
                "{x}: {got} {want}"
            );
        }
    }

    #[test]
    fn bad_widths_and_names() {
        for width in [0.0, -1.0, f64::NAN] {
            let error = find("hann").unwrap().factors(Some(width), 3).unwrap_err();
            assert!(error.to_string().contains("must be positive"));
        }
        assert!(find("box").is_err());
    }

    #[test]
    fn more_degrees_than_there_is_room_for() {
        for order in [usize::MAX, usize::MAX - 1, 1 << 58] {
            let error = find("hann").unwrap().factors(None, order).unwrap_err();
            assert!(matches!(error, Error::Memory { .. }), "{error}");
        }
    }
}
