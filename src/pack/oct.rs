//! The octahedral schemes `oct`, `woct` and `equal_area`: see [`super::fold`].
//!
//! `oct` is what glTF, engines and G-buffers use. `woct` is ours and nobody else reads it: a quarter of the
//! sphere's distortion is left, and with it the worst error falls to 8 % above what any code of as many
//! points can reach. `equal_area` is the map of pbrt's probes; its error is a little larger than woct's.

use super::fold::{EqualArea, Fold, HEX, NEAREST, PRECISE, Plain, Rounded, Warp, Warped};
use super::grid::{GRIDS, Grid};
use super::printed::Asked;
use super::rounding::Rounding;
use super::{Family, Scheme, Splits, Unit};
use crate::code::Program;
use crate::pack::kernel;
use crate::pack::kernel::{Decode, Encode};
use std::sync::Arc;

const ALL: &[Rounding] = &[Rounding::Nearest, Rounding::Precise, Rounding::Hex];

/// Every even number of bits.
pub(super) const EVEN: &[u32] = &[
    8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30, 32, 34, 36, 38, 40, 42, 44, 46, 48, 50, 52, 54,
    56, 58, 60, 62, 64,
];

/// The octahedral map.
pub const OCT: Family = Family {
    name: "oct",
    title: "Octahedral",
    source: "Meyer et al. 2010, On Floating-Point Normal Vectors; Cigolle et al. 2014, best of four",
    summary: "The standard: decoded everywhere, in any shader.",
    bits: EVEN,
    variants: &GRIDS,
    roundings: ALL,
    splits: Splits::Two,
    unit: Unit::Step,
    // Closed forms; hex within a thousandth of precise.
    bounds: &[
        3.0 / std::f64::consts::SQRT_2,
        std::f64::consts::SQRT_2,
        1.001 * std::f64::consts::SQRT_2,
    ],
    make: |bits, grid| Arc::new(Fold::new(Plain, Grid::new(grid, bits / 2))),
    ..Family::DEFAULT
};

/// Our warped octahedron.
pub const WOCT: Family = Family {
    name: "woct",
    title: "Warped octahedral",
    source: "spheremap: direction ∝ f(b), f(t) = t(1 + k(1 - t)), k = 11/16, b octahedral barycentrics",
    summary: "Ours: the smallest error of all that decode without a table; no other program reads it.",
    bits: EVEN,
    variants: &GRIDS,
    roundings: ALL,
    splits: Splits::Two,
    unit: Unit::Step,
    bounds: &[1.90, 1.194, 1.53],
    excess: 0.33,
    make: |bits, grid| Arc::new(Fold::new(Warped, Grid::new(grid, bits / 2))),
    standard: false,
    ..Family::DEFAULT
};

/// The equal-area octahedral map.
pub const EQUAL_AREA: Family = Family {
    name: "equal_area",
    title: "Equal-area octahedral",
    source: "Clarberg 2008, Fast Equal-Area Mapping of the (Hemi)Sphere using SIMD; pbrt-v4",
    summary: "Every code stands for nearly the same solid angle, so codes can be counted.",
    bits: EVEN,
    variants: &GRIDS,
    roundings: &[Rounding::Nearest, Rounding::Precise],
    splits: Splits::Two,
    unit: Unit::Step,
    bounds: &[2.15, 1.42],
    make: |bits, grid| Arc::new(Fold::new(EqualArea, Grid::new(grid, bits / 2))),
    ..Family::DEFAULT
};

/// Warps that are exact enough in f32 for fields of 16 bits.
trait Single: Warp {
    const SINGLE: bool;
}
impl Single for Plain {
    const SINGLE: bool = true;
}
impl Single for Warped {
    const SINGLE: bool = true;
}
impl Single for EqualArea {
    const SINGLE: bool = false;
}

fn encode<R: kernel::Cell, F: Warp>(
    fold: Fold<F>,
    rounding: Rounding,
    d: &[R],
    codes: &mut [R::Code],
) -> bool
where
    Rounded<Fold<F>, NEAREST>: Encode<R>,
    Fold<F>: Decode<R>,
{
    match rounding {
        Rounding::Nearest => kernel::encode(Rounded::<_, NEAREST>(fold), d, codes),
        Rounding::Precise => kernel::encode(Rounded::<_, PRECISE>(fold), d, codes),
        Rounding::Hex => kernel::encode(Rounded::<_, HEX>(fold), d, codes),
    }
}

impl<F: Single> Scheme for Fold<F> {
    fn encode(&self, rounding: Rounding, d: &[f64], codes: &mut [u64]) -> bool {
        encode(*self, rounding, d, codes)
    }

    fn decode(&self, codes: &[u64], d: &mut [f64]) {
        kernel::decode(*self, codes, d);
    }

    fn single(&self) -> bool {
        F::SINGLE && self.grid.bits <= 16
    }

    fn encode_single(&self, rounding: Rounding, d: &[f32], codes: &mut [u32]) -> bool {
        encode(*self, rounding, d, codes)
    }

    fn decode_single(&self, codes: &[u32], d: &mut [f32]) {
        kernel::decode(*self, codes, d);
    }

    fn canonical(&self, codes: &mut [u64]) {
        for code in codes {
            *code = self.representative(*code);
        }
    }

    fn step(&self) -> f64 {
        1.0 / self.grid.n
    }

    fn program(&self, asked: Asked) -> Option<Program> {
        Some(asked.program(*self))
    }
}
