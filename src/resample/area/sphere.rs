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
    triangle(pole, a.1, b.1) + bulge(curve, [a, m, b], tolerance, 12)
}

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
    let inner = triangle(a.1, p.1, m.1) + triangle(m.1, q.1, b.1);
    // A series in even powers: the rest tells the next term, and how much smaller than it the one after is.
    let rest = inner - 0.25 * outer;
    let next = rest * (16.0 * rest / outer);
    if rest.abs().min(next.abs()) <= tolerance || depth == 0 {
        return outer + inner * (4.0 / 3.0) + rest * (4.0 / 45.0);
    }
    outer
        + bulge(curve, [a, p, m], 0.5 * tolerance, depth - 1)
        + bulge(curve, [m, q, b], 0.5 * tolerance, depth - 1)
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

    #[test]
    fn a_circle_of_latitude() {
        struct Parallel(f64);
        impl Curve for Parallel {
            fn at(&self, t: f64) -> Direction {
                let (s, c) = (2.0 * t).sin_cos();
                [self.0.sin() * c, self.0.sin() * s, self.0.cos()]
            }
        }
        for theta in [0.1, 1.0, 2.0] {
            let curve = Parallel(theta);
            let at = |t: f64| (t, curve.at(t));
            let got = swept(&curve, [0.0, 0.0, 1.0], [at(0.0), at(0.5), at(1.0)], 1e-12);
            assert!((got - 2.0 * (1.0 - theta.cos())).abs() < 1e-10, "{got}");
        }
    }
}
