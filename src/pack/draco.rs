//! Draco's octahedral normals: `draco2x2` to `draco30x2`, the first number its quantization bits.
//!
//! Source: Draco 1.5.7, compression/attributes/normal_compression_utils.h. x is the pole. The grid has 2ᵇ - 1
//! points a side, an odd number; the two larger components are rounded as the third follows, so that the
//! integers lie on the octahedron; edges are made canonical. It encodes in double and decodes in
//! float, which from 20 bits on adds to the error, by 1e-6 at most.
//!
//! Draco takes a vector whose components sum to 1e-6 or less for +x. Such a one is scaled first here, by a power of
//! two: its direction is kept, and the codes of all others are Draco's.

use super::literal::{Literal, Repeated, fields, pair};
use super::rounding::Rounding;
use super::{Family, Splits, Unit};
use crate::number::real::Real as _;
use std::sync::Arc;

#[derive(Clone, Copy)]
struct Draco {
    bits: u32,
}

/// Draco's normals.
pub const DRACO: Family = Family {
    name: "draco",
    title: "Draco's octahedral normals",
    source: "Draco 1.5.7, normal_compression_utils.h",
    summary: "What Draco and KHR_draco_mesh_compression store before prediction; x is the pole.",
    bits: &[
        4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30, 32, 34, 36, 38, 40, 42, 44, 46, 48,
        50, 52, 54, 56, 58, 60,
    ],
    roundings: &[Rounding::Nearest],
    splits: Splits::Fields {
        count: 2,
        signed: false,
    },
    unit: Unit::Step,
    bounds: &[2.2],
    exact: Some("Draco"),
    make: |bits, _| Arc::new(Repeated(Draco { bits: bits / 2 })),
    ..Family::DEFAULT
};

impl Draco {
    fn largest(self) -> i64 {
        (1 << self.bits) - 2
    }

    /// The grid point that Draco writes for one on an edge of the square, which meets itself.
    fn on_edges(self, s: i64, t: i64) -> (i64, i64) {
        let (last, center) = (self.largest(), self.largest() / 2);
        if (s == 0 && (t == 0 || t == last)) || (s == last && t == 0) {
            (last, last)
        } else if (s == 0 && t > center) || (s == last && t < center) {
            (s, last - t)
        } else if (t == last && s < center) || (t == 0 && s > center) {
            (last - s, t)
        } else {
            (s, t)
        }
    }
}

fn sum(d: [f64; 3]) -> f64 {
    d[0].abs() + d[1].abs() + d[2].abs()
}

/// A vector that Draco does not take for one without a direction.
fn beyond_guard(d: [f64; 3]) -> [f64; 3] {
    if sum(d) > 1e-6 {
        return d;
    }
    let scale = d
        .iter()
        .fold(0.0_f64, |most, x| most.max(x.abs()))
        .binade_scale();
    d.map(|x| x * scale)
}

impl Literal for Draco {
    fn encode(self, d: [f64; 3]) -> u64 {
        let d = d.map(|x| f64::from(x as f32));
        let center = self.largest() / 2;
        let d = beyond_guard(d);
        let scale = 1.0 / sum(d);
        let d = d.map(|x| x * scale);
        let round = |x: f64| (x * center as f64 + 0.5).floor() as i64;
        let (x, mut y) = (round(d[0]), round(d[1]));
        let mut z = center - x.abs() - y.abs();
        if z < 0 {
            y += if y > 0 { z } else { -z };
            z = 0;
        }
        if d[2] < 0.0 {
            z = -z;
        }
        let (s, t) = if x >= 0 {
            (y + center, z + center)
        } else {
            let folded = |a: i64, b: i64| {
                if a < 0 {
                    b.abs()
                } else {
                    self.largest() - b.abs()
                }
            };
            (folded(y, z), folded(z, y))
        };
        let (s, t) = self.on_edges(s, t);
        pair(s as u32, t as u32, self.bits)
    }

    fn decode(self, code: u64) -> [f64; 3] {
        let (s, t) = fields(code, self.bits);
        let scale = 2.0 / self.largest() as f32;
        let y = s as f32 * scale - 1.0;
        let z = t as f32 * scale - 1.0;
        let x = 1.0 - y.abs() - z.abs();
        let over = if -x < 0.0 { 0.0 } else { -x };
        let y = y + if y < 0.0 { over } else { -over };
        let z = z + if z < 0.0 { over } else { -over };
        let square = x * x + y * y + z * z;
        if f64::from(square) < 1e-6 {
            return [0.0; 3];
        }
        let scale = 1.0 / square.sqrt();
        [x * scale, y * scale, z * scale].map(f64::from)
    }

    fn canonical(self, code: u64) -> u64 {
        let (s, t) = fields(code, self.bits);
        // Beyond the grid lie a column and a row more, which are decoded and never written.
        if i64::from(s.max(t)) > self.largest() {
            return code;
        }
        let (s, t) = self.on_edges(s.into(), t.into());
        pair(s as u32, t as u32, self.bits)
    }

    fn step(self) -> f64 {
        2.0 / self.largest() as f64
    }
}
