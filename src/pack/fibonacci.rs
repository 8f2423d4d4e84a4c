//! `fibonacci`: the spherical Fibonacci points, numbered from +z to -z.
//!
//! Source: Keinert, Innmann, Sänger, Stamminger 2015, Spherical Fibonacci Mapping. Of n = 2ᵇⁱᵗˢ points, point i lies
//! at azimuth 2π·frac(i/Φ) and z = 1 - (2i + 1)/n. frac(i/Φ) is exact to 2⁻⁶⁴ as a product of integers modulo 2⁶⁴.
//!
//! Encoding: near the latitude of a direction the points form a lattice on the cylinder, whose short
//! steps are two neighboring Fibonacci numbers of points. `nearest` looks at the four corners of the
//! cell, as the paper does; `precise` at the sixteen around it, which near the poles finds a nearer one
//! now and then. No two codes share a direction, and ±z have one each, half a step away. It is scalar
//! code: the lattice depends on the latitude.

use super::rounding::Rounding;
use super::{Family, Scheme, Unit};
use crate::number::real::Real;
use std::sync::Arc;

#[derive(Clone, Copy)]
struct Fibonacci {
    n: f64,
}

/// Spherical Fibonacci points.
pub const FIBONACCI: Family = Family {
    name: "fibonacci",
    title: "Spherical Fibonacci",
    source: "Keinert, Innmann, Sänger, Stamminger 2015, Spherical Fibonacci Mapping",
    summary: "A mean error near the least there can be; codes are numbered from +z down to -z.",
    bits: &[8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30, 32],
    roundings: &[Rounding::Nearest, Rounding::Precise],
    unit: Unit::Root,
    bounds: &[2.80, 2.74],
    make: |bits, _| {
        Arc::new(Fibonacci {
            n: (bits as f64).exp2(),
        })
    },
    slow: true,
    ..Family::DEFAULT
};

/// 2⁶⁴/Φ.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// The square of the golden ratio.
const PHI_SQUARED: f64 = 2.618_033_988_749_895;

/// frac(i/Φ).
fn turn(i: u64) -> f64 {
    (i.wrapping_mul(GOLDEN) >> 11) as f64 * (-53_f64).exp2()
}

impl Fibonacci {
    fn point(self, i: u64) -> [f64; 3] {
        let below = (2 * i + 1) as f64 / self.n;
        let h = (below * (2.0 - below)).sqrt();
        let (sin, cos) = f64::sin_cos_half_turns(2.0 * turn(i));
        [cos * h, sin * h, 1.0 - below]
    }

    fn nearest(self, [x, y, z]: [f64; 3], reach: i64) -> u64 {
        let n = self.n;
        let h2 = x * x + y * y;
        let around = 0.5 * f64::half_turns(y.abs(), x).negated_if(y < 0.0);
        // The two Fibonacci numbers whose steps are shortest here: Φ²ᵏ ≤ n·π·√5·sin²θ.
        let area = n * std::f64::consts::PI * 5_f64.sqrt() * h2;
        let (mut f0, mut f1, mut power) = (1_u64, 2_u64, PHI_SQUARED * PHI_SQUARED * PHI_SQUARED);
        while power <= area {
            (f0, f1) = (f1, f0 + f1);
            power *= PHI_SQUARED;
        }
        let signed = |f: u64| {
            let t = turn(f);
            if t > 0.5 { t - 1.0 } else { t }
        };
        let (u0, u1) = (signed(f0), signed(f1));
        let (v0, v1) = (f0 as f64, f1 as f64);
        // a·(u0, v0) + b·(u1, v1) = (azimuth, number).
        let number = 0.5 * (n * (1.0 - z) - 1.0);
        let determinant = u0 * v1 - u1 * v0;
        let a = ((around * v1 - u1 * number) / determinant).floor() as i64;
        let b = ((u0 * number - around * v0) / determinant).floor() as i64;
        let mut best = (f64::INFINITY, 0);
        for da in -reach..=1 + reach {
            for db in -reach..=1 + reach {
                let i = (a + da) * f0 as i64 + (b + db) * f1 as i64;
                let i = i.clamp(0, n as i64 - 1) as u64;
                let q = self.point(i);
                let e = [q[0] - x, q[1] - y, q[2] - z];
                let far = e[0] * e[0] + e[1] * e[1] + e[2] * e[2];
                // The order of the search must not show: ties go to the smaller number.
                if far < best.0 || (far == best.0 && i < best.1) {
                    best = (far, i);
                }
            }
        }
        best.1
    }
}

impl Scheme for Fibonacci {
    fn encode(&self, rounding: Rounding, d: &[f64], codes: &mut [u64]) -> bool {
        let reach = i64::from(rounding != Rounding::Nearest);
        super::each(d, codes, |d| self.nearest(d, reach))
    }

    fn decode(&self, codes: &[u64], d: &mut [f64]) {
        for (code, d) in codes.iter().zip(d.as_chunks_mut::<3>().0) {
            // Beyond the last there is no point; it stands for them.
            *d = self.point((*code).min(self.n as u64 - 1));
        }
    }

    fn canonical(&self, _: &mut [u64]) {}

    fn step(&self) -> f64 {
        1.0 / self.n.sqrt()
    }
}
