//! By what lobes multiply each degree: A_l = 2π ∫ K(t) P_l(t) dt, over t = cos θ from -1 to 1.
//!
//! A convolution with a function K that is round about its axis multiplies every coefficient of degree l by A_l
//! (Funk 1916, Hecke 1918), whatever its m. One row of [`LOBES`] is one K:
//!
//! - **cosine**: max(0, t), which makes irradiance of radiance: π, 2π/3, π/4, 0, -π/24, ... (Ramamoorthi & Hanrahan
//!   2001), a multiple of Phong's lobe of exponent 1;
//! - **cone**: 1 within an angle. ∫ P_l over the cone is (P_l-1 - P_l+1)/(2l + 1). Both nearly cancel in a small
//!   cone, so the recurrence runs over the differences D_l = P_l - P_l+1 instead, which
//!   (l + 1) D_l = l D_l-1 + (2l + 1)(1 - cos) P_l makes without any;
//! - **phong**: max(0, t)^e, with A_l/A_l-2 = (e - l + 2)/(e + l + 1) (Ramamoorthi & Hanrahan 2002);
//! - **vmf**: von Mises and Fisher's exp(κ (t - 1)). Ratios of modified spherical Bessel functions, by their continued
//!   fraction from above (Miller); upward they lose all digits.
//!
//! All but the cosine's are normalized: A_0 = 1. Singular points: a cone whose cosine rounds to 1 is a point, all 1;
//! κ = 0 and a cone of 180° are the whole sphere, 1, 0, 0, ...

use crate::error::Error;
use crate::number::real::Real;
use std::f64::consts::PI;

/// The highest degree that factors are given for.
pub const HIGHEST: usize = 10_000;

/// A lobe about an axis.
#[derive(Clone, Copy, Debug)]
pub struct Lobe {
    /// Its name.
    pub name: &'static str,
    /// The name of its parameter, if it has one: a cone's is in degrees.
    pub parameter: Option<&'static str>,
    /// Why a value cannot be its parameter.
    check: fn(f64) -> Result<(), Error>,
    /// The factors of degrees 0 to an order.
    factors: fn(f64, usize) -> Vec<f64>,
}

/// All lobes.
pub const LOBES: [Lobe; 4] = [
    Lobe {
        name: "cosine",
        parameter: None,
        check: |_| Ok(()),
        factors: |_, order| phong(1.0, order).iter().map(|a| PI * a).collect(),
    },
    Lobe {
        name: "cone",
        parameter: Some("half_angle"),
        check: |angle| {
            if angle > 0.0 && angle <= 180.0 {
                return Ok(());
            }
            Err(Error::Parameter {
                name: "half_angle",
                above: 0.0,
                maximum: 180.0,
                value: angle,
            })
        },
        factors: cone,
    },
    Lobe {
        name: "phong",
        parameter: Some("exponent"),
        check: |exponent| nonnegative("exponent", exponent),
        factors: phong,
    },
    Lobe {
        name: "vmf",
        parameter: Some("kappa"),
        check: |kappa| nonnegative("kappa", kappa),
        factors: von_mises_fisher,
    },
];

/// The lobe of this name.
///
/// # Errors
/// No lobe has it.
///
/// ```
/// assert_eq!(spheremap::light::sh::lobes::find("cosine")?.factors(0.0, 1)?.len(), 2);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn find(name: &str) -> Result<&'static Lobe, Error> {
    let found = LOBES.iter().find(|lobe| lobe.name == name);
    found.ok_or_else(|| Error::unknown("lobe", name, &LOBES.map(|lobe| lobe.name)))
}

impl Lobe {
    /// The factors of degrees 0 to `order`. A lobe without a parameter takes any.
    ///
    /// # Errors
    /// The order is above [`HIGHEST`], or the parameter out of its range.
    ///
    /// ```
    /// use spheremap::light::sh::lobes;
    /// let cosine = lobes::find("cosine")?.factors(0.0, 2)?;
    /// assert!((cosine[2] - std::f64::consts::FRAC_PI_4).abs() < 1e-15);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn factors(&self, parameter: f64, order: usize) -> Result<Vec<f64>, Error> {
        if order > HIGHEST {
            return Err(Error::Contradiction(format!(
                "Expected `order` to be at most {HIGHEST}, got {order}."
            )));
        }
        (self.check)(parameter)?;
        Ok((self.factors)(parameter, order))
    }
}

fn nonnegative(name: &str, value: f64) -> Result<(), Error> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    Err(Error::Contradiction(format!(
        "`{name}` must be at least 0 and finite, got {value}."
    )))
}

fn phong(exponent: f64, order: usize) -> Vec<f64> {
    let mut factors = vec![1.0, (exponent + 1.0) / (exponent + 2.0)];
    for l in 2..=order {
        let degree = l as f64;
        factors.push(factors[l - 2] * (exponent - degree + 2.0) / (exponent + degree + 1.0));
    }
    factors.truncate(order + 1);
    factors
}

fn cone(half_angle: f64, order: usize) -> Vec<f64> {
    let (_, cos) = f64::sin_cos_half_turns(half_angle / 180.0);
    let (sin, _) = f64::sin_cos_half_turns(half_angle / 360.0);
    let mut factors = vec![1.0; order + 1];
    if cos >= 1.0 {
        return factors;
    }
    // 1 - cos, without its cancellation.
    let height = 2.0 * sin * sin;
    // P_l and D_l = P_l - P_l+1.
    let (mut legendre, mut difference) = (1.0, height);
    for (l, factor) in factors.iter_mut().enumerate().skip(1) {
        let (degree, twice) = (l as f64, (2 * l + 1) as f64);
        let before = difference;
        legendre -= before;
        difference = (degree * before + twice * height * legendre) / (degree + 1.0);
        *factor = (before + difference) / (twice * height);
    }
    factors
}

fn von_mises_fisher(kappa: f64, order: usize) -> Vec<f64> {
    let mut factors = vec![0.0; order + 1];
    factors[0] = 1.0;
    if kappa == 0.0 {
        return factors;
    }
    // So far above the order the fraction has forgotten with what it began, or that was right: a bound of the ratio (Amos 1974), 1/(x + s), which is
    // off by (order + ahead)/κ².
    let ahead = (40.0 * (order + 1) as f64).sqrt() + kappa.min(1e9).sqrt() * 12.0;
    let first = order + 20 + ahead as usize;
    let x = ((first + 1) as f64 / kappa).min(1e100);
    let s = (x * x + 1.0).sqrt();
    // What ratios lack of 1, which they are nearly: to add to these would round a hundred thousand times.
    let mut lack = (x + x * x / (s + 1.0)) / (x + s);
    for l in (1..=first).rev() {
        // No infinity, of which nothing could be taken: κ may be next to 0.
        let more = ((2 * l + 1) as f64 / kappa).min(1e300) - lack;
        let ratio = 1.0 / (1.0 + more);
        lack = more * ratio;
        if l <= order {
            factors[l] = ratio;
        }
    }
    for l in 1..=order {
        factors[l] *= factors[l - 1];
    }
    factors
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Legendre's polynomials at t, by Bonnet's recurrence.
    fn legendre(order: usize, t: f64) -> Vec<f64> {
        let mut p = vec![1.0, t];
        for l in 1..order {
            let k = l as f64;
            p.push(((2.0 * k + 1.0) * t * p[l] - k * p[l - 1]) / (k + 1.0));
        }
        p
    }

    /// Midpoints over [low, 1]: 1e-8 for 2e5 of them and kernels with a bounded second derivative.
    fn integrals(low: f64, kernel: impl Fn(f64) -> f64) -> Vec<f64> {
        const N: usize = 200_000;
        let mut sums = vec![0.0; 9];
        for k in 0..N {
            let t = low + (1.0 - low) * (k as f64 + 0.5) / N as f64;
            for (sum, p) in sums.iter_mut().zip(legendre(8, t)) {
                *sum += kernel(t) * p * (1.0 - low) / N as f64;
            }
        }
        sums
    }

    #[test]
    fn factors_are_integrals_with_legendre_polynomials() {
        let check = |name: &str, parameter: f64, low: f64, kernel: &dyn Fn(f64) -> f64| {
            let got = find(name).unwrap().factors(parameter, 8).unwrap();
            let want = integrals(low, kernel);
            let scale = got[0] / want[0];
            for (got, want) in got.iter().zip(&want) {
                assert!((got - scale * want).abs() < 1e-8, "{name}: {got} {want}");
            }
        };
        check("cosine", 0.0, 0.0, &|t| t);
        check("cone", 60.0, 0.5, &|_| 1.0);
        check("phong", 7.5, 0.0, &|t| t.powf(7.5));
        check("vmf", 12.0, -1.0, &|t| (12.0 * (t - 1.0)).exp());
    }

    #[test]
    fn narrow_lobes_are_nearly_points() {
        for kappa in [1e5, 1e7, 1e8, 1e10, 1e20, 1e300] {
            let a = find("vmf").unwrap().factors(kappa, 60).unwrap();
            // coth κ - 1/κ, and Bessel's recurrence.
            assert!((a[1] - (1.0 - 1.0 / kappa)).abs() < 1e-15, "{kappa}");
            for l in 1..60 {
                let next = a[l - 1] - (2 * l + 1) as f64 / kappa * a[l];
                assert!((a[l + 1] - next).abs() < 1e-15, "{kappa} {l}");
            }
        }
    }

    #[test]
    fn ends_of_ranges() {
        let factors = |name, parameter| find(name).unwrap().factors(parameter, 3);
        assert_eq!(factors("vmf", 0.0).unwrap(), [1.0, 0.0, 0.0, 0.0]);
        assert!(
            factors("vmf", 5e-324).unwrap()[1..]
                .iter()
                .all(|a| *a < 1e-299)
        );
        assert_eq!(factors("cone", 1e-9).unwrap(), [1.0; 4]);
        // A sphere has nothing but its mean: what is left is the rounding of sums of two to five terms.
        assert!(
            factors("cone", 180.0).unwrap()[1..]
                .iter()
                .all(|a| a.abs() < 1e-15)
        );
        assert_eq!(find("phong").unwrap().factors(3.0, 0).unwrap(), [1.0]);
        for (name, bad) in [("cone", 0.0), ("cone", 181.0), ("cone", f64::NAN)] {
            assert!(
                factors(name, bad)
                    .unwrap_err()
                    .to_string()
                    .contains("half_angle")
            );
        }
        for bad in [-1.0, f64::INFINITY, f64::NAN] {
            assert!(factors("phong", bad).is_err() && factors("vmf", bad).is_err());
        }
        assert!(find("cosine").unwrap().factors(0.0, HIGHEST + 1).is_err());
        assert!(find("blinn").is_err());
    }
}
