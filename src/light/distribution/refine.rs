//! Bisection of cells in which the map's density is not straight.

use super::cells::is_straight;
use crate::geometry::solid_angle::Rect;
use crate::projections::projection::Visitor;
use crate::projections::projection::one;
use crate::projections::projection::{Outline, Projection, Uv};

/// A rectangle counts as smooth where nine points on it and nine on each half agree so well, relative: then they stand
/// for its exact solid angle, which costs a hundred times as much. Rims and creases do not pass.
const SMOOTH: f64 = 1e-7;

/// Halves a cell, with the two numbers that say where in it a sample lies, until the map's density in the part
/// that holds the sample is straight.
pub(super) struct Refine(pub(super) [f64; 7]);

impl Visitor for Refine {
    type Output = [f64; 7];

    fn visit<P: Projection>(self, p: P) -> [f64; 7] {
        let [mut u0, mut u1, mut v0, mut v1, face, mut s, mut t] = self.0;
        let exact = |u0, u1, v0, v1| p.solid_angle(Rect { u0, u1, v0, v1 });
        let at = |u, v| Uv { u, v, face };
        let smooth = |u0, u1, v0, v1| nine_points(u0, u1, v0, v1, |u, v| one::density(p, at(u, v)));
        // What nine points say of this half of a smooth rectangle.
        let mut half = None;
        // 48 halvings leave 2⁻²⁴ of each side.
        for _ in 0..48 {
            let corners = [at(u0, v0), at(u1, v0), at(u0, v1), at(u1, v1)];
            let corners_hold = corners.iter().all(|uv| one::contains(p, *uv));
            let area = (u1 - u0) * (v1 - v0);
            let densities = corners.map(|uv| one::density(p, uv));
            let straight = |here: f64| corners_hold && is_straight(densities, area, here);
            // It may be smooth along one axis alone, but then corners and nine points do not say the same.
            if half.is_some_and(straight) {
                return [u0, u1, v0, v1, face, s, t];
            }
            let along_u = u1 - u0 >= v1 - v0;
            let (um, vm) = (0.5 * (u0 + u1), 0.5 * (v0 + v1));
            let halves = if along_u {
                [[u0, um, v0, v1], [um, u1, v0, v1]]
            } else {
                [[u0, u1, v0, vm], [u0, u1, vm, v1]]
            };
            let mut parts = [0.0; 2];
            let mut here = 0.0;
            let mut known = false;
            if P::INFO.outline != Outline::Shape && corners_hold {
                here = half.unwrap_or_else(|| smooth(u0, u1, v0, v1));
                parts = halves.map(|[a, b, c, d]| smooth(a, b, c, d));
                known = (parts[0] + parts[1] - here).abs() <= SMOOTH * here;
            }
            if !known {
                here = exact(u0, u1, v0, v1);
            }
            if straight(here) {
                return [u0, u1, v0, v1, face, s, t];
            }
            if !known {
                let [[a, b, c, d], [e, f, g, h]] = halves;
                parts[0] = exact(a, b, c, d);
                parts[1] = rest(here, parts[0], || exact(e, f, g, h));
            }
            let first = choose(parts[0], parts[1], if along_u { &mut s } else { &mut t });
            half = known.then_some(parts[usize::from(!first)]);
            [u0, u1, v0, v1] = halves[usize::from(!first)];
        }
        let places = [
            (0.5 * (u0 + u1), 0.5 * (v0 + v1)),
            (u0, v0),
            (u1, v0),
            (u0, v1),
            (u1, v1),
        ];
        let held = places
            .into_iter()
            .find(|(u, v)| one::contains(p, at(*u, *v)));
        let (u, v) = held.unwrap_or(places[0]);
        [u, u, v, v, face, 0.5, 0.5]
    }
}

/// ∫ f over a rectangle by three points of Gauss and Legendre along each side.
#[inline(always)]
fn nine_points(u0: f64, u1: f64, v0: f64, v1: f64, f: impl Fn(f64, f64) -> f64) -> f64 {
    const X: f64 = 0.774_596_669_241_483_4;
    const NODES: [(f64, f64); 3] = [(-X, 5.0 / 18.0), (0.0, 8.0 / 18.0), (X, 5.0 / 18.0)];
    let (du, dv) = (0.5 * (u1 - u0), 0.5 * (v1 - v0));
    let (um, vm) = (0.5 * (u0 + u1), 0.5 * (v0 + v1));
    let mut sum = 0.0;
    for (y, wy) in NODES {
        for (x, wx) in NODES {
            sum += wx * wy * f(um + du * x, vm + dv * y);
        }
    }
    sum * 4.0 * du * dv
}

/// What is left of a solid angle: the difference, or itself where that would cancel.
fn rest(whole: f64, part: f64, itself: impl Fn() -> f64) -> f64 {
    if part < 0.75 * whole {
        whole - part
    } else {
        itself()
    }
}

/// Whether x lies in the first of two parts of this mass; x becomes its place in its part.
fn choose(a: f64, b: f64, x: &mut f64) -> bool {
    let share = a / (a + b);
    let first = *x < share || b <= 0.0;
    let place = if first {
        *x / share
    } else {
        (*x - share) / (1.0 - share)
    };
    *x = place.clamp(0.0, 1.0);
    first
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_keep_the_place_within() {
        let mut x = 0.25;
        assert!(choose(1.0, 1.0, &mut x));
        assert_eq!(x, 0.5);
        let mut x = 1.0;
        assert!(choose(2.0, 0.0, &mut x));
        assert_eq!(x, 1.0);
        let mut x = 0.0;
        assert!(!choose(0.0, 2.0, &mut x));
        assert_eq!(x, 0.0);
    }
}
