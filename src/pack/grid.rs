//! Grids on [-1, 1]: how an integer field of b bits counts.
//!
//! With n steps from the middle to an end, a field holds one of
//!
//! - `snorm`: k/n, k = -n..n, n = 2ᵇ⁻¹ - 1: 0 and ±1 are exact. The field -2ᵇ⁻¹ reads as -n, as Direct3D
//!   and Vulkan have it, and is never written.
//! - `unorm`: 2k/(2ᵇ - 1) - 1, k = 0..2ᵇ - 1: ±1 are exact and 0 is not.
//! - `centers`: (2k + 1)/2ᵇ - 1: the centers of a texture's texels. No two places share a direction.
//!
//! Schemes work in steps: a lattice of integers shifted by `offset`, 0 or ½, on [-n, n].

use super::kernel::{Cell, Lattice};
use crate::number::real::max;

/// A grid of one coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Bits a field.
    pub bits: u32,
    /// Steps from the middle to the end of the coordinate.
    pub n: f64,
    /// 0 or ½: the lattice point next to the middle, not below it.
    pub offset: f64,
    /// What is added to a lattice point to get its field.
    pub shift: f64,
    /// Whether fields count in two's complement.
    pub signed: bool,
}

/// The names of the grids; the first is the default.
pub const GRIDS: [&str; 3] = ["snorm", "unorm", "centers"];

impl Grid {
    /// The grid of this name with fields of `bits` bits.
    pub fn new(name: &str, bits: u32) -> Grid {
        let half = (bits as f64 - 1.0).exp2();
        let (n, offset, shift, signed) = match name {
            "unorm" => (half - 0.5, 0.5, half - 0.5, false),
            "centers" => (half, 0.5, half - 0.5, false),
            _ => (half - 1.0, 0.0, 0.0, true),
        };
        Grid {
            bits,
            n,
            offset,
            shift,
            signed,
        }
    }

    /// Whether the outermost lattice points lie on ±n.
    pub fn reaches_the_end(self) -> bool {
        self.n - self.offset == (self.n - self.offset).floor()
    }

    /// The field of a lattice point as a number, not below zero.
    pub fn unsigned<R: Lattice>(self, place: R) -> R {
        let field = place + R::new(self.shift);
        if self.signed {
            let all = R::new(f64::from(self.bits).exp2());
            R::select(field.less(R::ZERO), field + all, field)
        } else {
            field
        }
    }

    /// The lattice point of such a number.
    pub fn of_unsigned<R: Lattice>(self, field: R) -> R {
        if self.signed {
            let all = f64::from(self.bits).exp2();
            let negative = field.at_least(R::new(0.5 * all));
            let place = R::select(negative, field - R::new(all), field);
            max(place, R::new(-self.n))
        } else {
            field - R::new(self.shift)
        }
    }

    /// The field of a lattice point.
    #[inline(always)]
    pub fn field<R: Cell>(self, place: R) -> R::Code {
        let mask = (1_u64 << self.bits) - 1;
        (place + R::new(self.shift)).integer() & R::code(mask)
    }

    /// The lattice point of a field, from a word whose lowest bits are the field.
    #[inline(always)]
    pub fn place<R: Cell>(self, word: R::Code) -> R {
        if self.signed {
            max(R::from_signed(word, self.bits), R::new(-self.n))
        } else {
            let mask = (1_u64 << self.bits) - 1;
            R::from_integer(word & R::code(mask)) - R::new(self.shift)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_comes_back_and_ends_are_where_they_belong() {
        for (name, ends) in [
            ("snorm", 1.0),
            ("unorm", 1.0),
            ("centers", 1.0 - 1.0 / 256.0),
        ] {
            let grid = Grid::new(name, 8);
            let mut largest = 0_f64;
            for field in 0..256_u32 {
                let place: f32 = grid.place::<f32>(field | 0xab00);
                largest = largest.max(place as f64 / grid.n);
                let back = grid.field(place);
                let canonical = if name == "snorm" && field == 128 {
                    129
                } else {
                    field
                };
                assert_eq!(back, canonical, "{name}");
            }
            assert_eq!(largest, ends, "{name}");
            assert_eq!(grid.reaches_the_end(), name != "centers", "{name}");
        }
    }
}
