//! Schemes that repeat another program to the bit: its formula, one direction at a time.
//!
//! Each is written as its program has it, in the order of its operations and in its precision, and
//! tested against the program where that can be run. They keep its habits: `rounding` is the
//! program's own, whatever is asked for.

use super::Scheme;
use super::rounding::Rounding;
use crate::number::real::Real;

/// Another program's code of a direction.
pub trait Literal: Copy + Send + Sync + 'static {
    /// The code of a finite direction that is not zero.
    fn encode(self, d: [f64; 3]) -> u64;

    /// The direction as the program decodes it.
    fn decode(self, code: u64) -> [f64; 3];

    /// The code that stands for all of the same direction, whether or not the program writes others.
    fn canonical(self, code: u64) -> u64;

    /// The step of its grid on [-1, 1].
    fn step(self) -> f64;
}

/// A literal formula as a scheme.
#[derive(Clone, Copy)]
pub struct Repeated<L>(pub L);

impl<L: Literal> Scheme for Repeated<L> {
    fn encode(&self, _: Rounding, d: &[f64], codes: &mut [u64]) -> bool {
        let mut good = true;
        for (&d, code) in d.as_chunks::<3>().0.iter().zip(codes) {
            let ok = super::has_direction(d);
            *code = if ok {
                self.0.encode(of_float_length(d))
            } else {
                0
            };
            good &= ok;
        }
        good
    }

    fn decode(&self, codes: &[u64], d: &mut [f64]) {
        for (&code, d) in codes.iter().zip(d.as_chunks_mut::<3>().0) {
            *d = self.0.decode(code);
        }
    }

    fn canonical(&self, codes: &mut [u64]) {
        for code in codes {
            *code = self.0.canonical(*code);
        }
    }

    fn step(&self) -> f64 {
        self.0.step()
    }
}

/// A vector that programs which compute in float can hold, and its sums: longer and shorter ones are scaled by a
/// power of two. There a program has infinities over infinities, and a code of the sign of NaN, which is the CPU's.
fn of_float_length(d: [f64; 3]) -> [f64; 3] {
    let most = d.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    if (f64::from(f32::MIN_POSITIVE)..0.25 * f64::from(f32::MAX)).contains(&most) {
        return d;
    }
    let scale = most.binade_scale();
    d.map(|x| x * scale)
}

/// Two fields side by side.
pub fn pair(low: u32, high: u32, bits: u32) -> u64 {
    u64::from(low) | u64::from(high) << bits
}

/// The fields of `pair`.
pub fn fields(code: u64, bits: u32) -> (u32, u32) {
    let mask = (1_u64 << bits) - 1;
    ((code & mask) as u32, ((code >> bits) & mask) as u32)
}
