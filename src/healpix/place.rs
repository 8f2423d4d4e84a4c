//! Directions to cells, and centers of pixels.

use super::index::{FaceCell, Grid, OnRing, double, floor};
use crate::number::math::{max, min};
use crate::number::real::Real;
// An `if` may become a branch, which keeps the loop from being vectorized.
use std::hint::select_unpredictable as choose;

/// A direction's number may be that of a neighbor where a border is nearer than this, in radians.
pub const BORDER: f64 = 4e-15;

/// The cell that a direction falls into, and whether it is a direction: finite and not zero.
#[inline(always)]
pub fn cell_of_direction(grid: Grid, [x, y, z]: [f64; 3]) -> (FaceCell, bool) {
    let scale = max(x.abs(), max(y.abs(), z.abs())).binade_scale();
    let (x, y, z) = (x * scale, y * scale, z * scale);
    let sum = x.abs() + y.abs() + z.abs();
    let is_direction = (sum > 0.0) & (sum < f64::INFINITY);
    let x = choose(is_direction, x, 1.0);
    let (y, z) = (choose(is_direction, y, 0.0), choose(is_direction, z, 0.0));

    // The quadrant q, and the point turned into the first one: u > 0 and w ≥ 0; the poles, whatever their zeros' signs, are in quadrant 0.
    let odd = ((x <= 0.0) & (y > 0.0)) | ((x >= 0.0) & (y < 0.0));
    let back = (y < 0.0) | ((y == 0.0) & (x < 0.0));
    let turn = i64::from(odd) + choose(back, 2, 0);
    let (x, y) = (x.abs(), y.abs());
    let along = 2.0 * f64::half_turns(choose(odd, x, y), choose(odd, y, x));

    let squared = x * x + y * y;
    let length = (squared + z * z).sqrt();
    let polar = 3.0 * z.abs() > 2.0 * length;
    // √(3 (1 - |z|/L)) without cancellation in a cap, ¾ z/L in the belt: one quotient.
    let numerator = choose(polar, 3.0 * squared, 0.75 * z);
    let denominator = length * choose(polar, length + z.abs(), 1.0);
    let quotient = numerator / denominator;

    let n = grid.nside;
    let side = double(n);
    // Numbers along the diagonals: in the belt up to 2 nside from the quadrant's own, in a cap below nside.
    let radius = quotient.abs().sqrt();
    let falling = choose(polar, along * radius, 0.5 + along - quotient);
    let rising = choose(polar, (1.0 - along) * radius, 0.5 + along + quotient);
    let most = choose(polar, side - 1.0, 2.0 * side - 1.0);
    let number = |t: f64| floor(min(max(side * t, 0.0), most));
    let (falling, rising) = (number(falling), number(rising));
    let belt = grid.belt(
        falling,
        rising,
        i64::from(falling >= n),
        i64::from(rising >= n),
    );
    let belt = FaceCell {
        face: (belt.face & 12) | ((belt.face + turn) & 3),
        ..belt
    };
    let south = z < 0.0;
    let cap = FaceCell {
        face: turn + choose(south, 8, 0),
        x: choose(south, falling, n - 1 - rising),
        y: choose(south, rising, n - 1 - falling),
    };
    let cell = FaceCell {
        face: choose(polar, cap.face, belt.face),
        x: choose(polar, cap.x, belt.x),
        y: choose(polar, cap.y, belt.y),
    };
    (cell, is_direction)
}

/// z, √(1 - z²) and the azimuth in half turns, within ±1, of a pixel's center.
#[inline(always)]
pub fn center(grid: Grid, place: OnRing) -> (f64, f64, f64) {
    let OnRing {
        ring,
        quadrant,
        halves,
    } = place;
    let halves = halves - choose(halves > 4 * quadrant, 8 * quadrant, 0);
    let azimuth = double(halves) / (4.0 * double(quadrant));
    let (z, sine) = heights(grid, ring, quadrant);
    (z, sine, azimuth)
}

/// z and √(1 - z²) of the centers on a ring.
#[inline(always)]
pub fn heights(grid: Grid, ring: i64, quadrant: i64) -> (f64, f64) {
    let n = grid.nside;
    let share = double(quadrant) / double(n);
    // 1 - |z| in a cap.
    let height = share * share * (1.0 / 3.0);
    let belt = double(2 * n - ring) / double(n) * (2.0 / 3.0);
    let in_belt = quadrant == n;
    let cap = Real::negated_if(1.0 - height, ring > 2 * n);
    let squared = choose(
        in_belt,
        (1.0 - belt) * (1.0 + belt),
        height * (2.0 - height),
    );
    (choose(in_belt, belt, cap), squared.sqrt())
}
