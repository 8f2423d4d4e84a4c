//! Areas on the sphere, from edge differences: small triangles keep all their digits.

use crate::geometry::vector::{cross, dot, sub};
use crate::number::real::Real;
use std::f64::consts::PI;

/// A direction of unit length.
pub(super) type Direction = [f64; 3];

/// The signed area of a spherical triangle, positive where a, b, c turn about the outward normal
/// (Van Oosterom & Strackee 1983).
pub(super) fn triangle(a: Direction, b: Direction, c: Direction) -> f64 {
    let volume = dot(a, cross(sub(b, a), sub(c, a)));
    let base = 1.0 + dot(a, b) + dot(b, c) + dot(c, a);
    let half = volume / base;
    // The arctangent's series where the next term is below rounding.
    if half.abs() < 1e-4 && base > 0.0 {
        return 2.0 * half * (1.0 - half * half * (1.0 / 3.0));
    }
    let turns = f64::half_turns(volume.abs(), base);
    (2.0 * PI * turns).copysign(volume)
}

/// A smooth curve: its direction at a parameter.
pub(super) trait Curve {
    fn at(&self, t: f64) -> Direction;
}

/// The area that the curve from `a` to `b` sweeps about `pole`, to an error of about `tolerance`.
/// Each of a, m, b is a parameter and its direction, m in the middle.
///
/// Triangles under a halved curve shrink by 4 in sum (by 8 each), so two levels give the rest of the
/// series.
pub(super) fn swept(
    curve: &impl Curve,
    pole: Direction,
    [a, m, b]: [(f64, Direction); 3],
    tolerance: f64,
) -> f64 {
    triangle(pole, a.1, b.1) + bulge(curve, [a, m, b], tolerance, DEPTH)
}

/// How often a curve is halved.
const DEPTH: u32 = 12;

/// How many of these a half takes that lies no nearer to its chords than the whole: at a rim that is known to some digits alone, none
/// ever does.
const ROUGH: u32 = 3;

/// The area between a curve and its chord.
fn bulge(curve: &impl Curve, [a, m, b]: [(f64, Direction); 3], tolerance: f64, depth: u32) -> f64 {
    let outer = triangle(a.1, m.1, b.1);
    if outer.abs() <= tolerance {
        return outer * (4.0 / 3.0);
    }
    let middle = |from: f64, to: f64| {
        let t = 0.5 * (from + to);
        (t, curve.at(t))
    };
    let (p, q) = (middle(a.0, m.0), middle(m.0, b.0));
    let halves = [triangle(a.1, p.1, m.1), triangle(m.1, q.1, b.1)];
    let inner = halves[0] + halves[1];
    // A series in even powers: the rest tells the next term, and how much smaller than it the one after is.
    let rest = inner - 0.25 * outer;
    let next = rest * (16.0 * rest / outer);
    if rest.abs().min(next.abs()) <= tolerance || depth == 0 {
        return outer + inner * (4.0 / 3.0) + rest * (4.0 / 45.0);
    }
    // A quarter of it where the curve is smooth, half of it where it has a corner. Where it turns to its other side it may be
    // more, once.
    let rough = halves[0].abs() + halves[1].abs() > 0.7 * outer.abs();
    let depth = depth.saturating_sub(if rough { ROUGH } else { 1 });
    outer
        + bulge(curve, [a, p, m], 0.5 * tolerance, depth)
        + bulge(curve, [m, q, b], 0.5 * tolerance, depth)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::normalized;

    #[test]
    fn octant_and_needle() {
        let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        assert!((triangle(x, y, z) - 0.5 * PI).abs() < 1e-15);
        assert_eq!(triangle(x, z, y), -triangle(x, y, z));
        let e = 1e-5;
        let area = triangle(z, normalized([e, 0.0, 1.0]), normalized([0.0, e, 1.0]));
        assert!((area - 0.5 * e * e).abs() < 1e-9 * e * e, "{area}");
    }

    struct Parallel(f64);

    impl Curve for Parallel {
        fn at(&self, t: f64) -> Direction {
            let (s, c) = (2.0 * t).sin_cos();
            [self.0.sin() * c, self.0.sin() * s, self.0.cos()]
        }
    }

    #[test]
    fn a_circle_of_latitude() {
        for theta in [0.1, 1.0, 2.0] {
            let curve = Parallel(theta);
            let at = |t: f64| (t, curve.at(t));
            let got = swept(&curve, [0.0, 0.0, 1.0], [at(0.0), at(0.5), at(1.0)], 1e-12);
            assert!((got - 2.0 * (1.0 - theta.cos())).abs() < 1e-10, "{got}");
        }
    }

    #[test]
    fn a_curve_that_is_known_to_some_digits_is_given_up() {
        /// A parallel that is off by up to `error`, and counts how often it is asked.
        struct Rough {
            error: f64,
            asked: std::cell::Cell<u32>,
        }
        impl Curve for Rough {
            fn at(&self, t: f64) -> Direction {
                self.asked.set(self.asked.get() + 1);
                let noise = (t * 1e5).sin() * self.error;
                Parallel(1.0 + noise).at(t)
            }
        }
        for error in [1e-6, 1e-5, 1e-4, 1e-3] {
            let curve = Rough {
                error,
                asked: 0.into(),
            };
            let at = |t: f64| (t, curve.at(t));
            let got = swept(&curve, [0.0, 0.0, 1.0], [at(0.0), at(0.5), at(1.0)], 1e-9);
            let want = 2.0 * (1.0 - 1.0_f64.cos());
            // So much it may be off along its length, which is less than 2, and as much again between places.
            assert!((got - want).abs() < 4.0 * error, "{error} {got}");
            // Halved as often as it may be it is asked 16,384 times.
            assert!(curve.asked.get() < 5000, "{error} {}", curve.asked.get());
        }
    }
}
