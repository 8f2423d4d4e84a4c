//! Octahedral codes as pbrt-v4, Unreal Engine and Cesium have them: `pbrt16x2`, `unreal8x2` ..., `cesium8x2` ...
//!
//! Sources: pbrt-v4, src/pbrt/util/vecmath.h, class OctahedralVector (float, unorm16, the sign of a zero
//! counts); Unreal Engine, NaniteEncode.cpp, OctahedronEncode (float, truncation after adding a half, no search);
//! Cesium, AttributeCompression.octEncodeInRange, as quantized-mesh terrain has it (double, halves round up).

use super::literal::{Literal, Repeated, fields, pair};
use super::rounding::Rounding;
use super::{Family, Splits, Unit};
use std::sync::Arc;

const NEAREST: &[Rounding] = &[Rounding::Nearest];
const BOUND: &[f64] = &[2.13];

/// pbrt's OctahedralVector.
pub const PBRT: Family = Family {
    name: "pbrt",
    title: "pbrt-v4's OctahedralVector",
    source: "pbrt-v4, src/pbrt/util/vecmath.h",
    summary: "Normals and cones of light bounds in pbrt: two unorm16, a sign of zero counts.",
    bits: &[32],
    roundings: NEAREST,
    splits: Splits::Fields {
        count: 2,
        signed: false,
    },
    unit: Unit::Step,
    bounds: BOUND,
    exact: Some("pbrt-v4"),
    make: |_, _| Arc::new(Repeated(Pbrt)),
    ..Family::DEFAULT
};

/// Unreal's octahedral normals.
pub const UNREAL: Family = Family {
    name: "unreal",
    title: "Unreal Engine's octahedral normals",
    source: "Unreal Engine 5, NaniteEncode.cpp (OctahedronEncode) and OctahedralCommon.ush",
    summary: "Nanite's normals without its search: unorm of any number of bits.",
    bits: &[16, 18, 20, 22, 24, 26, 28, 30, 32],
    roundings: NEAREST,
    splits: Splits::Fields {
        count: 2,
        signed: false,
    },
    unit: Unit::Step,
    bounds: BOUND,
    exact: Some("Unreal Engine"),
    make: |bits, _| Arc::new(Repeated(Unreal { bits: bits / 2 })),
    ..Family::DEFAULT
};

/// Cesium's octahedral normals.
pub const CESIUM: Family = Family {
    name: "cesium",
    title: "Cesium's octahedral normals",
    source: "Cesium, AttributeCompression.octEncodeInRange; quantized-mesh 1.0, oct-encoded normals",
    summary: "Normals of quantized-mesh terrain and 3D Tiles point clouds.",
    bits: &[16, 32],
    roundings: NEAREST,
    splits: Splits::Fields {
        count: 2,
        signed: false,
    },
    unit: Unit::Step,
    bounds: BOUND,
    exact: Some("Cesium"),
    make: |bits, _| Arc::new(Repeated(Cesium { bits: bits / 2 })),
    ..Family::DEFAULT
};

/// The code that stands for all of the same direction: on an edge of the square, which meets itself, that of the
/// larger coordinate. The programs write the other one, too, for a component just below 0.
fn of_edges(code: u64, bits: u32) -> u64 {
    let (s, t) = fields(code, bits);
    let last = (1 << bits) - 1;
    let settled = |k: u32, beside: u32| {
        if beside == 0 || beside == last {
            k.max(last - k)
        } else {
            k
        }
    };
    pair(settled(s, t), settled(t, s), bits)
}

#[derive(Clone, Copy)]
struct Pbrt;

impl Literal for Pbrt {
    fn encode(self, d: [f64; 3]) -> u64 {
        let [x, y, z] = d.map(|x| x as f32);
        let sum = x.abs() + y.abs() + z.abs();
        let (x, y, z) = (x / sum, y / sum, z / sum);
        let (u, v) = if z >= 0.0 {
            (x, y)
        } else {
            let sign = |x: f32| 1_f32.copysign(x);
            ((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y))
        };
        let unorm = |f: f32| (((f + 1.0) / 2.0).clamp(0.0, 1.0) * 65535.0).round() as u32;
        pair(unorm(u), unorm(v), 16)
    }

    fn decode(self, code: u64) -> [f64; 3] {
        let (x, y) = fields(code, 16);
        let coordinate = |k: u32| -1.0 + 2.0 * (k as f32 / 65535.0);
        let (x, y) = (coordinate(x), coordinate(y));
        let z = 1.0 - (x.abs() + y.abs());
        let sign = |x: f32| 1_f32.copysign(x);
        let (x, y) = if z < 0.0 {
            ((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y))
        } else {
            (x, y)
        };
        let length = (x * x + y * y + z * z).sqrt();
        [x / length, y / length, z / length].map(f64::from)
    }

    fn canonical(self, code: u64) -> u64 {
        of_edges(code, 16)
    }

    fn step(self) -> f64 {
        2.0 / 65535.0
    }
}

#[derive(Clone, Copy)]
struct Unreal {
    bits: u32,
}

impl Unreal {
    fn largest(self) -> f32 {
        ((1 << self.bits) - 1) as f32
    }
}

impl Literal for Unreal {
    fn encode(self, d: [f64; 3]) -> u64 {
        let [x, y, z] = d.map(|x| x as f32);
        let sum = x.abs() + y.abs() + z.abs();
        let (x, y, z) = (x / sum, y / sum, z / sum);
        let (u, v) = if z < 0.0 {
            let (ax, ay) = (x.abs(), y.abs());
            (
                if x >= 0.0 { 1.0 - ay } else { ay - 1.0 },
                if y >= 0.0 { 1.0 - ax } else { ax - 1.0 },
            )
        } else {
            (x, y)
        };
        let scale = 0.5 * self.largest();
        let bias = 0.5 * self.largest() + 0.5;
        let last = (1 << self.bits) - 1;
        let field = |f: f32| ((f * scale + bias) as i32).clamp(0, last) as u32;
        pair(field(u), field(v), self.bits)
    }

    fn decode(self, code: u64) -> [f64; 3] {
        let (s, t) = fields(code, self.bits);
        let scale = 2.0 / self.largest();
        let (x, y) = (s as f32 * scale - 1.0, t as f32 * scale - 1.0);
        let z = 1.0 - x.abs() - y.abs();
        let over = if -z > 0.0 { -z } else { 0.0 };
        let x = x + if x >= 0.0 { -over } else { over };
        let y = y + if y >= 0.0 { -over } else { over };
        let length = (x * x + y * y + z * z).sqrt();
        [x / length, y / length, z / length].map(f64::from)
    }

    fn canonical(self, code: u64) -> u64 {
        of_edges(code, self.bits)
    }

    fn step(self) -> f64 {
        2.0 / f64::from(self.largest())
    }
}

#[derive(Clone, Copy)]
struct Cesium {
    bits: u32,
}

impl Cesium {
    fn largest(self) -> f64 {
        ((1_u64 << self.bits) - 1) as f64
    }
}

impl Literal for Cesium {
    fn encode(self, [x, y, z]: [f64; 3]) -> u64 {
        let sum = x.abs() + y.abs() + z.abs();
        let (x, y) = (x / sum, y / sum);
        let sign = |x: f64| if x < 0.0 { -1.0 } else { 1.0 };
        let (u, v) = if z < 0.0 {
            ((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y))
        } else {
            (x, y)
        };
        // Math.round: halves go up.
        let field = |f: f64| {
            let scaled = (f.clamp(-1.0, 1.0) * 0.5 + 0.5) * self.largest();
            let low = scaled.floor();
            (if scaled - low >= 0.5 { low + 1.0 } else { low }) as u32
        };
        pair(field(u), field(v), self.bits)
    }

    fn decode(self, code: u64) -> [f64; 3] {
        let (s, t) = fields(code, self.bits);
        let coordinate = |k: u32| f64::from(k) / self.largest() * 2.0 - 1.0;
        let (x, y) = (coordinate(s), coordinate(t));
        let z = 1.0 - (x.abs() + y.abs());
        let sign = |x: f64| if x < 0.0 { -1.0 } else { 1.0 };
        let (x, y) = if z < 0.0 {
            ((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y))
        } else {
            (x, y)
        };
        let length = (x * x + y * y + z * z).sqrt();
        [x / length, y / length, z / length]
    }

    fn canonical(self, code: u64) -> u64 {
        of_edges(code, self.bits)
    }

    fn step(self) -> f64 {
        2.0 / self.largest()
    }
}
