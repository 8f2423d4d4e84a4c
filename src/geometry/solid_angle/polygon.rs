//! Polygons of an image that is folded: what of a texel lies on each side of a fold.
//!
//! They have few corners, and lie in arrays: in lists, finding room for them took as long as their solid angles.

use super::gnomonic::gnomonic_polygon;

/// A convex polygon of an image, of up to eight corners.
#[derive(Clone, Copy, Default)]
pub struct Polygon {
    corners: [[f64; 2]; 8],
    count: usize,
}

impl Polygon {
    fn push(&mut self, corner: [f64; 2]) {
        self.corners[self.count] = corner;
        self.count += 1;
    }

    /// Its corners, in order.
    pub fn corners(&self) -> &[[f64; 2]] {
        &self.corners[..self.count]
    }

    /// The solid angle of the plane polygon whose corners these are.
    pub fn solid_angle(&self, lift: impl Fn([f64; 2]) -> [f64; 3]) -> f64 {
        gnomonic_polygon(&self.corners.map(lift)[..self.count])
    }
}

/// The part of a convex polygon, of up to seven corners, where a linear function is not negative.
pub fn clip(polygon: &[[f64; 2]], side: impl Fn([f64; 2]) -> f64) -> Polygon {
    let mut part = Polygon::default();
    for (i, &a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let (at_a, at_b) = (side(a), side(b));
        if at_a >= 0.0 {
            part.push(a);
        }
        if at_a < 0.0 && at_b > 0.0 || at_a > 0.0 && at_b < 0.0 {
            let t = at_a / (at_a - at_b);
            part.push([0, 1].map(|k| a[k] + t * (b[k] - a[k])));
        }
    }
    part
}
