//! A sensor that is not square to the axis of its lens, as OpenCV's CALIB_TILTED_MODEL has it: that of a Scheimpflug camera.
//!
//! Source: Louhichi, Fournel, Lavest & Ben Aissia 2007, Self-calibration of Scheimpflug cameras: an easy protocol; OpenCV's camera
//! calibration page: with R(τx, τy) = Ry(τy) Rx(τx) a point p of the plane goes to P R (p, 1), where P moves what R made of
//! the axis back to it. So the axis stays, and with R's rows r1, r2, r3 it is (r33 r1 - r13 r3, r33 r2 - r23 r3)(p, 1) over r3 (p, 1).
//! Without a tilt every number stays as it is, to the bit.
//!
//! Domain: points in front of the line that the tilt takes to infinity, and what they become.

use crate::number::angle;
use crate::number::real::{Real, max};
use std::f64::consts::PI;

/// In how many directions circles are looked at.
const AZIMUTHS: usize = 96;
/// How far the extremes of so many places may be from those of a circle.
const SLACK: f64 = 0.005;

/// The plane of a lens to that of a sensor: p to M p/(1 + slant·p).
#[derive(Clone, Copy, Debug)]
pub struct Tilt {
    /// M.
    turn: [[f64; 2]; 2],
    /// Its inverse.
    back: [[f64; 2]; 2],
    slant: [f64; 2],
}

impl Tilt {
    /// With τx and τy in radians, each less than a quarter turn.
    pub fn new([x, y]: [f64; 2]) -> Self {
        let ((sx, cx), (sy, cy)) = (angle::sin_cos(x), angle::sin_cos(y));
        let r = [
            [cy, sy * sx, -sy * cx],
            [0.0, cx, sx],
            [sy, -cy * sx, cy * cx],
        ];
        let deep = r[2][2];
        let turn = [0, 1].map(|k| [0, 1].map(|i| (deep * r[k][i] - r[k][2] * r[2][i]) / deep));
        let area = turn[0][0] * turn[1][1] - turn[0][1] * turn[1][0];
        Tilt {
            turn,
            back: [
                [turn[1][1] / area, -turn[0][1] / area],
                [-turn[1][0] / area, turn[0][0] / area],
            ],
            slant: [r[2][0] / deep, r[2][1] / deep],
        }
    }

    /// Whether the sensor is square to the axis.
    pub fn is_none(self) -> bool {
        self.slant == [0.0; 2]
    }

    /// What a point of the lens's plane becomes, and whether it lies in front.
    #[inline(always)]
    pub fn tilted<R: Real>(self, p: [R; 2]) -> ([R; 2], R::Mask) {
        let depth = R::ONE + product(self.slant, p);
        (
            self.turn.map(|row| product(row, p) / depth),
            depth.more(R::ZERO),
        )
    }

    /// The point of the lens's plane, and how deep it lies: not in front where that is not positive.
    #[inline(always)]
    pub fn level<R: Real>(self, p: [R; 2]) -> ([R; 2], R) {
        let q = self.back.map(|row| product(row, p));
        let depth = R::ONE - product(self.slant, q);
        (q.map(|x| x / depth), depth)
    }

    /// The area of the lens's plane over that of the sensor at this depth.
    #[inline(always)]
    pub fn shrinks<R: Real>(self, depth: R) -> R {
        let [[a, b], [c, d]] = self.back;
        R::new(a * d - b * c) / (depth * depth * depth)
    }

    /// The radius of a disk of the lens's plane that is all of a disk of the sensor's, and may be more.
    pub fn reach(self, radius: f64) -> f64 {
        if self.is_none() {
            return radius;
        }
        let far = circle(radius).map(|p| {
            let ([x, y], depth) = self.level(p);
            if depth > 0.0 {
                angle::length(x, y)
            } else {
                f64::INFINITY
            }
        });
        far.fold(0.0, max) * (1.0 + SLACK)
    }

    /// The radius of a disk of the sensor's plane in which there is no more than a disk of the lens's, and may be less.
    pub fn held_radius(self, radius: f64) -> f64 {
        if self.is_none() {
            return radius;
        }
        let near = circle(radius).map(|p| {
            let ([x, y], ahead) = self.tilted(p);
            if ahead {
                angle::length(x, y)
            } else {
                f64::INFINITY
            }
        });
        near.fold(f64::INFINITY, f64::min) * (1.0 - SLACK)
    }
}

/// a·p.
#[inline(always)]
fn product<R: Real>(a: [f64; 2], [x, y]: [R; 2]) -> R {
    R::new(a[0]) * x + R::new(a[1]) * y
}

fn circle(radius: f64) -> impl Iterator<Item = [f64; 2]> {
    (0..AZIMUTHS).map(move |k| {
        let (sin, cos) = angle::sin_cos(2.0 * PI * k as f64 / AZIMUTHS as f64);
        [radius * cos, radius * sin]
    })
}
