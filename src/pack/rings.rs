//! `rings`: points evenly spaced on circles of latitude, as many on each as keep the worst error even.
//!
//! Source: Smith, Petrova, Schaefer 2012, Encoding Normal Vectors using Optimized Spherical Coordinates.
//! Ring j of R lies at the colatitude (j + ½)π/R and owns the band of height π/R about it. It has the
//! fewest points that leave nothing in the band farther than ε from one; codes count along the
//! rings from +z. [`TABLE`] has, for each number of bits, R and sin²(ε/2) for the smallest ε whose points
//! fit, found by bisection for each R about √(πn)/2.
//!
//! `nearest` looks at the direction's own ring, `precise` at its neighbors too. Decoding searches the rings'
//! first codes.

use super::rounding::Rounding;
use super::{Family, Scheme, Unit};
use crate::number::real::Real;
use std::sync::Arc;

/// Bits, rings, codes, sin²(ε/2).
const TABLE: &[(u32, u32, u64, f64)] = &[
    (8, 14, 256, 0.006650762750861581),
    (10, 28, 1_024, 0.001595686504909931),
    (12, 56, 4_096, 0.0003907279013901974),
    (14, 114, 16_384, 9.688045271670422e-05),
    (16, 226, 65_536, 2.4089763327125398e-05),
    (18, 454, 262_144, 6.007233718177164e-06),
    (20, 908, 1_048_576, 1.4999475411798994e-06),
    (22, 1_813, 4_194_304, 3.7474834272871733e-07),
    (24, 3_629, 16_777_214, 9.365699942350276e-08),
    (26, 7_260, 67_108_850, 2.341047905727916e-08),
    (28, 14_522, 268_435_456, 5.85214633070651e-09),
    (30, 29_041, 1_073_741_824, 1.4629773573218335e-09),
    (32, 58_081, 4_294_967_295, 3.65736927498305e-10),
];

struct Rings {
    /// The first code of each ring, and the number of codes.
    starts: Vec<u64>,
}

/// Points on rings.
pub const RINGS: Family = Family {
    name: "rings",
    title: "Optimized rings",
    source: "Smith, Petrova, Schaefer 2012, Encoding Normal Vectors using Optimized Spherical Coordinates",
    summary: "The smallest mean error of all from 12 bits on; decoding needs a table of rings.",
    bits: &[8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30, 32],
    roundings: &[Rounding::Nearest, Rounding::Precise],
    unit: Unit::Root,
    bounds: &[2.62, 2.60],
    codes: |bits| {
        TABLE
            .iter()
            .find(|row| row.0 == bits)
            .map_or(0, |row| row.2)
    },
    make: |bits, _| Arc::new(Rings::new(bits)),
    slow: true,
    ..Family::DEFAULT
};

impl Rings {
    fn new(bits: u32) -> Rings {
        let &(_, rings, _, reach) = TABLE.iter().find(|row| row.0 == bits).unwrap_or(&TABLE[0]);
        let rings = f64::from(rings);
        let half_band = f64::sin_cos_half_turns(0.25 / rings).0;
        let left = reach - half_band * half_band;
        let mut starts = vec![0];
        let mut code = 0;
        for j in 0..rings as u32 {
            // Both hemispheres count alike; the edge of the band nearer to the equator is the longer.
            let from_pole = f64::from(j.min(rings as u32 - 1 - j));
            let sin = f64::sin_cos_half_turns((from_pole + 0.5) / rings).0;
            let edge = f64::sin_cos_half_turns((from_pole + 1.0) / rings).0;
            let s = left / (sin * edge);
            let count = if s >= 1.0 {
                1.0
            } else {
                // Half of the longest gap, in half turns.
                let gap = 2.0 * f64::half_turns(s.sqrt(), (1.0 - s).sqrt());
                (1.0 / gap).ceil()
            };
            code += count as u64;
            starts.push(code);
        }
        Rings { starts }
    }

    fn rings(&self) -> f64 {
        (self.starts.len() - 1) as f64
    }

    fn point(&self, ring: usize, i: u64) -> [f64; 3] {
        let count = self.starts[ring + 1] - self.starts[ring];
        let (sin, cos) = f64::sin_cos_half_turns(2.0 * i as f64 / count as f64);
        let (h, z) = f64::sin_cos_half_turns((ring as f64 + 0.5) / self.rings());
        [cos * h, sin * h, z]
    }

    fn nearest(&self, [x, y, z]: [f64; 3], reach: usize) -> u64 {
        let around = 0.5 * f64::half_turns(y.abs(), x).negated_if(y < 0.0);
        let down = f64::half_turns((x * x + y * y).sqrt(), z);
        let last = self.starts.len() - 2;
        let own = ((down * self.rings()) as usize).min(last);
        let mut best = (f64::INFINITY, 0);
        for ring in own.saturating_sub(reach)..=(own + reach).min(last) {
            let start = self.starts[ring];
            let count = self.starts[ring + 1] - start;
            let i = (around * count as f64).round_ties_even() as i64;
            let i = i.rem_euclid(count as i64) as u64;
            let q = self.point(ring, i);
            let e = [q[0] - x, q[1] - y, q[2] - z];
            let far = e[0] * e[0] + e[1] * e[1] + e[2] * e[2];
            if far < best.0 {
                best = (far, start + i);
            }
        }
        best.1
    }
}

impl Scheme for Rings {
    fn encode(&self, rounding: Rounding, d: &[f64], codes: &mut [u64]) -> bool {
        let reach = usize::from(rounding != Rounding::Nearest);
        super::each(d, codes, |d| self.nearest(d, reach))
    }

    fn decode(&self, codes: &[u64], d: &mut [f64]) {
        for (&code, d) in codes.iter().zip(d.as_chunks_mut::<3>().0) {
            let ring = self.starts.partition_point(|&start| start <= code) - 1;
            let ring = ring.min(self.starts.len() - 2);
            *d = self.point(ring, code - self.starts[ring]);
        }
    }

    fn canonical(&self, _: &mut [u64]) {}

    fn step(&self) -> f64 {
        1.0 / (self.starts[self.starts.len() - 1] as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_points_as_the_table_says() {
        for &(bits, rings, codes, _) in TABLE {
            let made = Rings::new(bits);
            assert_eq!(made.starts.len(), rings as usize + 1);
            assert_eq!(made.starts.last(), Some(&codes), "{bits}");
            assert!(codes <= 1 << bits);
        }
    }
}
