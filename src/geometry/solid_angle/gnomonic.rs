//! Maps whose pieces are central projections of planes: spherical polygons.
//!
//! A triangle a, b, c subtends Ω with tan(Ω/2) = det(a, b, c) / (abc + (a·b)c + (a·c)b + (b·c)a)
//! (Van Oosterom & Strackee, IEEE Trans. Biomed. Eng. 30, 1983). On a plane at the distance that an
//! image defines, the determinant is a constant times the area in the image, and so has no
//! cancellation at all. The terms below it are all positive for any texel that is not half a face.

use super::{Quarter, Rect};
use crate::geometry::vector::{Vec3, cross, dot, norm, sub};
use crate::number::angle;

/// Solid angle of a small convex planar polygon whose plane does not hold the origin.
///
/// Points in order, either way round. The polygon lies within a hemisphere, as a plane one does.
pub fn gnomonic_polygon(points: &[[f64; 3]]) -> f64 {
    fan(points, |i| {
        let a = points[0];
        dot(a, cross(sub(points[i], a), sub(points[i + 1], a)))
    })
}

/// Solid angle of a rectangle of one cube face, the plane (p, q, 1).
pub fn cube(r: Rect) -> f64 {
    let corners = [[r.u0, r.v0], [r.u1, r.v0], [r.u1, r.v1], [r.u0, r.v1]];
    patch(&corners, 4.0, |[u, v]| [2.0 * u - 1.0, 2.0 * v - 1.0, 1.0])
}

/// Solid angle of the rectangle p[0]..p[1] × q[0]..q[1] of the plane at distance 1, whose area is known to more
/// digits than its sides give.
pub fn plane_rectangle(p: [f64; 2], q: [f64; 2], area: f64) -> f64 {
    let points = [[p[0], q[0]], [p[1], q[0]], [p[1], q[1]], [p[0], q[1]]];
    fan(&points.map(|[p, q]| [p, q, 1.0]), |_| area)
}

/// Solid angle of a rectangle of a picture whose half sides at distance 1 are `half` and whose axis is at
/// `principal`, in coordinates from -1 to 1.
pub fn perspective(r: Rect, half: [f64; 2], principal: [f64; 2]) -> f64 {
    let corners = [[r.u0, r.v0], [r.u1, r.v0], [r.u1, r.v1], [r.u0, r.v1]];
    patch(&corners, 4.0 * half[0] * half[1], |uv| {
        let at = |k: usize| (2.0 * uv[k] - 1.0 - principal[k]) * half[k];
        [at(0), at(1), 1.0]
    })
}

/// Solid angle of a rectangle of the octahedral map.
pub fn octahedral(r: Rect) -> f64 {
    // The diamond |p| + |q| = 1 is a + b = ½; outside of it the face is folded out.
    let partner = |x| 0.5 - x;
    let upper = |[a, b]: [f64; 2]| [1.0 - 2.0 * a, 1.0 - 2.0 * b, 2.0 * (a + b) - 1.0];
    let lower = |[a, b]: [f64; 2]| [2.0 * b, 2.0 * a, 2.0 * (a + b) - 1.0];
    Quarter::sum(r, |c| {
        cut(c, partner, |upside, polygon| match upside {
            true => patch(polygon, 4.0, upper),
            false => patch(polygon, 4.0, lower),
        })
    })
}

/// Solid angle of a rectangle of the hemi-octahedral map.
pub fn hemioctahedral(r: Rect) -> f64 {
    // z = 1 - max(|p|, |q|) has its creases on the diagonals, a = b.
    let lift = |[a, b]: [f64; 2]| [1.0 - (a + b), b - a, 2.0 * a.min(b)];
    Quarter::sum(r, |c| cut(c, |x| x, |_, polygon| patch(polygon, 2.0, lift)))
}

/// Cut a rectangle by the line b = partner(a), an involution, and sum `f` over the two sides; its
/// first argument is true for b >= partner(a).
fn cut(c: Quarter, partner: impl Fn(f64) -> f64, f: impl Fn(bool, &[[f64; 2]]) -> f64) -> f64 {
    let corners = [[c.a0, c.b0], [c.a1, c.b0], [c.a1, c.b1], [c.a0, c.b1]];
    let side = corners.map(|[a, b]| b - partner(a));
    if side.iter().all(|&s| s >= 0.0) {
        return f(true, &corners);
    }
    if side.iter().all(|&s| s <= 0.0) {
        return f(false, &corners);
    }
    [true, false]
        .into_iter()
        .map(|above| {
            let sign = if above { 1.0 } else { -1.0 };
            let mut polygon = [[0.0; 2]; 5];
            let n = clip(&corners, side.map(|s| s * sign), &partner, &mut polygon);
            f(above, &polygon[..n])
        })
        .sum()
}

/// Sutherland–Hodgman for one line. Crossings lie on the line by construction, without a division.
fn clip(
    corners: &[[f64; 2]; 4],
    side: [f64; 4],
    partner: &impl Fn(f64) -> f64,
    polygon: &mut [[f64; 2]; 5],
) -> usize {
    let mut n = 0;
    for i in 0..4 {
        let (j, [a, b]) = ((i + 1) % 4, corners[i]);
        if side[i] >= 0.0 {
            polygon[n] = [a, b];
            n += 1;
        }
        if side[i] < 0.0 && side[j] > 0.0 || side[i] > 0.0 && side[j] < 0.0 {
            polygon[n] = if a == corners[j][0] {
                [a, partner(a)]
            } else {
                [partner(b), b]
            };
            n += 1;
        }
    }
    n
}

/// A polygon of the image on one plane. `scale` is det(a, b - a, c - a) over the cross product of
/// the image's differences, which are exact.
fn patch(polygon: &[[f64; 2]], scale: f64, lift: impl Fn([f64; 2]) -> Vec3) -> f64 {
    let mut points = [[0.0; 3]; 5];
    for (point, &corner) in points.iter_mut().zip(polygon) {
        *point = lift(corner);
    }
    let [a0, b0] = polygon.first().copied().unwrap_or_default();
    fan(&points[..polygon.len()], |i| {
        let ([a1, b1], [a2, b2]) = (polygon[i], polygon[i + 1]);
        scale * ((a1 - a0) * (b2 - b0) - (a2 - a0) * (b1 - b0))
    })
}

/// Fan of triangles (0, i, i+1) with the determinants `det(i)`. Their half angles add up as the
/// arguments of complex numbers, so that one arctangent serves them all.
fn fan(points: &[Vec3], det: impl Fn(usize) -> f64) -> f64 {
    if points.len() < 3 {
        return 0.0;
    }
    let (a, mut b) = (points[0], points[1]);
    let (la, mut lb, mut ab) = (norm(a), norm(b), dot(a, b));
    let (mut re, mut im) = (1.0, 0.0);
    for i in 1..points.len() - 1 {
        let c = points[i + 1];
        let (lc, ac) = (norm(c), dot(a, c));
        let x = la * lb * lc + ab * lc + ac * lb + dot(b, c) * la;
        let y = det(i);
        (re, im) = (re * x - im * y, re * y + im * x);
        (b, lb, ab) = (c, lc, ac);
    }
    2.0 * angle::atan2(im.abs(), re)
}
