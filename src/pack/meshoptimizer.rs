//! meshoptimizer's octahedral filter: `meshoptimizer8x4` and `meshoptimizer16x4`.
//!
//! Source: meshoptimizer, src/vertexfilter.cpp (meshopt_encodeFilterOct and meshopt_decodeFilterOct) and
//! EXT_meshopt_compression of glTF. Four fields: two snorm coordinates, the 1 of their grid, and w, which
//! is written as 0 and not read. The decoder gives integers again, three snorm components; unpacking
//! gives those over their largest value, which is what a shader reads. Codes whose integers are the same are
//! two directions nevertheless, which the decoder rounds to one.

use super::literal::{Literal, Repeated};
use super::rounding::Rounding;
use super::{Family, Splits, Unit};
use std::sync::Arc;

#[derive(Clone, Copy)]
struct Filter {
    bits: u32,
}

/// The filter for glTF.
pub const MESHOPTIMIZER: Family = Family {
    name: "meshoptimizer",
    title: "meshoptimizer's octahedral filter",
    source: "meshoptimizer 0.23, src/vertexfilter.cpp; EXT_meshopt_compression",
    summary: "glTF's compressed normals before entropy coding; decodes to integer components.",
    bits: &[32, 64],
    roundings: &[Rounding::Nearest],
    splits: Splits::Fields {
        count: 4,
        signed: true,
    },
    unit: Unit::Step,
    // Decoding rounds once more, to components of as many bits.
    bounds: &[3.0],
    exact: Some("meshoptimizer"),
    make: |bits, _| Arc::new(Repeated(Filter { bits: bits / 4 })),
    ..Family::DEFAULT
};

impl Filter {
    fn one(self) -> f32 {
        ((1 << (self.bits - 1)) - 1) as f32
    }

    fn snorm(self, v: f32) -> u64 {
        let round = if v >= 0.0 { 0.5 } else { -0.5 };
        let v = v.clamp(-1.0, 1.0);
        let k = (v * self.one() + round) as i32;
        k as u64 & ((1 << self.bits) - 1)
    }

    fn whole(self, code: u64, which: u32) -> i64 {
        let shift = 64 - self.bits;
        ((code >> (which * self.bits)) << shift) as i64 >> shift
    }

    fn field(self, code: u64, which: u32) -> f32 {
        self.whole(code, which) as f32
    }
}

impl Literal for Filter {
    fn encode(self, d: [f64; 3]) -> u64 {
        let [x, y, z] = d.map(|x| x as f32);
        let sum = x.abs() + y.abs() + z.abs();
        let scale = if sum == 0.0 { 0.0 } else { 1.0 / sum };
        let (x, y) = (x * scale, y * scale);
        let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
        let (u, v) = if z >= 0.0 {
            (x, y)
        } else {
            ((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y))
        };
        let b = self.bits;
        self.snorm(u) | self.snorm(v) << b | self.snorm(1.0) << (2 * b)
    }

    fn decode(self, code: u64) -> [f64; 3] {
        let (x, y) = (self.field(code, 0), self.field(code, 1));
        let z = self.field(code, 2) - x.abs() - y.abs();
        let t = if z >= 0.0 { 0.0 } else { z };
        let x = x + if x >= 0.0 { t } else { -t };
        let y = y + if y >= 0.0 { t } else { -t };
        let length = (x * x + y * y + z * z).sqrt();
        let scale = self.one() / length;
        [x, y, z].map(|x| {
            let k = x * scale + if x >= 0.0 { 0.5 } else { -0.5 };
            f64::from(k as i32 as f32 / self.one())
        })
    }

    fn canonical(self, code: u64) -> u64 {
        let [x, y, one] = [0, 1, 2].map(|which| self.whole(code, which));
        let largest = self.one() as i64;
        // The least number has no opposite.
        let settled = |k: i64, beside: i64| {
            if beside.abs() == one && k.abs() <= largest {
                k.abs()
            } else {
                k
            }
        };
        let mask = (1 << self.bits) - 1;
        [settled(x, y), settled(y, x), one]
            .iter()
            .rev()
            .fold(0, |all, k| all << self.bits | (*k as u64 & mask))
    }

    fn step(self) -> f64 {
        1.0 / f64::from(self.one())
    }
}
