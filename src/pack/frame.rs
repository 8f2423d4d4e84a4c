//! Tangent frames: a normal, a tangent as an angle about it, and handedness, in 32 or 64 bits.
//!
//! The lowest bits are the normal as `oct20` or `oct40`, rounded precisely; then come the angle, 11 or 23
//! bits of a turn, and the sign of the bitangent, set for -1. The angle counts from the first axis of the frame
//! of Duff et al. 2017, Building an Orthonormal Basis, Revisited, about the *decoded* normal: then
//! decoding finds the same frame, and its jump at z = 0 does no harm. The bitangent is
//! cross(normal, tangent) times the sign, as in glTF.
//!
//! A tangent need not be perpendicular: its part perpendicular to the normal that is given counts, and is turned into
//! the plane of the decoded normal. To project the whole tangent there would carry what lies along the normal into the
//! plane, by as much as the decoded normal is off. A tangent along the normal has no angle.
//! The formula is scalar: the frame of a code is decoded before it is encoded to.

use super::{Packing, Real, Rounding, Scheme, has_direction};
use crate::error::{Error, expect_length};
use crate::geometry::vector::dot;
use crate::kernel::threads;
use crate::number::real::Real as _;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Names and sizes: total bits, bits of the normal.
pub const FRAMES: &[(&str, u32, u32)] = &[("frame32", 32, 20), ("frame64", 64, 40)];

/// Points a block.
const BLOCK: usize = 1 << 12;

/// A way of packing frames.
#[derive(Debug)]
pub struct FramePacking {
    normal: Packing,
    normal_bits: u32,
    angle_bits: u32,
}

/// Two unit vectors that with `n` make a right-handed frame.
fn basis([x, y, z]: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let sign = if z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + z);
    let b = x * y * a;
    (
        [1.0 + sign * x * x * a, sign * b, -sign * x],
        [b, sign + y * y * a, -y],
    )
}

/// A vector scaled by a power of two to components of which the largest is about 1.
fn scaled(v: [f64; 3]) -> [f64; 3] {
    let largest = v.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    v.map(|x| x * largest.binade_scale())
}

/// The part of a vector that is perpendicular to another, neither tiny nor huge.
fn perpendicular(v: [f64; 3], to: [f64; 3]) -> [f64; 3] {
    let along = dot(v, to) / dot(to, to);
    [0, 1, 2].map(|k| v[k] - along * to[k])
}

impl FramePacking {
    /// The packing of frames of this name: "frame32" or "frame64".
    ///
    /// # Errors
    /// No packing of frames has it.
    ///
    /// ```
    /// use spheremap::pack::frame::FramePacking;
    /// assert!(FramePacking::new("frame32").is_ok());
    /// ```
    pub fn new(name: &str) -> Result<Self, Error> {
        let Some((_, bits, normal_bits)) = FRAMES.iter().find(|f| f.0 == name) else {
            let names: Vec<&str> = FRAMES.iter().map(|f| f.0).collect();
            return Err(Error::unknown("frame packing", name, &names));
        };
        Ok(FramePacking {
            normal: Packing::new(&format!("oct{normal_bits}"))?,
            normal_bits: *normal_bits,
            angle_bits: bits - normal_bits - 1,
        })
    }

    fn scheme(&self) -> &dyn Scheme {
        self.normal.scheme.as_ref()
    }

    fn encode(&self, normal: [f64; 3], [x, y, z, w]: [f64; 4]) -> Option<u64> {
        let mut code = [0];
        let tangent = [x, y, z];
        if !has_direction(normal) || !has_direction(tangent) || w.is_nan() {
            return None;
        }
        let tangent = perpendicular(scaled(tangent), scaled(normal));
        // Less is rounding, and no direction.
        if dot(tangent, tangent) <= 1e-24 {
            return None;
        }
        let mut n = [0.0; 3];
        f64::encode(self.scheme(), Rounding::Precise, &normal, &mut code);
        f64::decode(self.scheme(), &code, &mut n);
        let (t, b) = basis(n);
        let (c, s) = (dot(tangent, t), dot(tangent, b));
        let turn = 0.5 * f64::half_turns(s.abs(), c).negated_if(s < 0.0);
        let steps = 1_u64 << self.angle_bits;
        let angle = (turn * steps as f64).round_ties_even() as i64;
        let angle = angle.rem_euclid(steps as i64) as u64;
        let sign = u64::from(w < 0.0);
        Some(code[0] | angle << self.normal_bits | sign << (self.normal_bits + self.angle_bits))
    }

    fn decode(&self, code: u64) -> ([f64; 3], [f64; 4]) {
        let mut n = [0.0; 3];
        let normal = code & ((1 << self.normal_bits) - 1);
        f64::decode(self.scheme(), &[normal], &mut n);
        let (t, b) = basis(n);
        let steps = 1_u64 << self.angle_bits;
        let angle = (code >> self.normal_bits) & (steps - 1);
        let (sin, cos) = f64::sin_cos_half_turns(2.0 * angle as f64 / steps as f64);
        let negative = code >> (self.normal_bits + self.angle_bits) & 1 == 1;
        let tangent = [0, 1, 2].map(|k| cos * t[k] + sin * b[k]);
        let [x, y, z] = tangent;
        (n, [x, y, z, if negative { -1.0 } else { 1.0 }])
    }

    /// Codes of normals (three numbers each) and tangents (four); the index of the first that has none.
    ///
    /// # Errors
    /// There are not three numbers of normals and four of tangents for each code.
    ///
    /// ```
    /// use spheremap::pack::frame::FramePacking;
    /// let (frame, mut codes) = (FramePacking::new("frame32")?, [0]);
    /// assert_eq!(frame.pack(&[0.0, 0.0, 1.0], &[1.0, 0.0, 0.0, -1.0], &mut codes)?, None);
    /// let mut back = [0.0; 7]; // normal, tangent, sign
    /// frame.unpack(&codes, &mut back)?;
    /// assert_eq!(back[6], -1.0);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn pack(
        &self,
        normals: &[f64],
        tangents: &[f64],
        codes: &mut [u64],
    ) -> Result<Option<usize>, Error> {
        expect_length("normals", normals.len(), 3 * codes.len())?;
        expect_length("tangents", tangents.len(), 4 * codes.len())?;
        let first = AtomicUsize::new(usize::MAX);
        let points = codes.len();
        threads::rows(codes, BLOCK, points, |block, codes| {
            let (normals, tangents) = (normals.as_chunks::<3>().0, tangents.as_chunks::<4>().0);
            for (k, code) in codes.iter_mut().enumerate() {
                let at = block * BLOCK + k;
                *code = self.encode(normals[at], tangents[at]).unwrap_or_else(|| {
                    first.fetch_min(at, Ordering::Relaxed);
                    0
                });
            }
        });
        let first = first.into_inner();
        Ok((first != usize::MAX).then_some(first))
    }

    /// Normals and tangents of codes, seven numbers each.
    ///
    /// # Errors
    /// There is not room for seven numbers for each code.
    ///
    /// ```
    /// use spheremap::pack::frame::FramePacking;
    /// assert!(FramePacking::new("frame64")?.unpack(&[0], &mut [0.0; 6]).is_err());
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn unpack(&self, codes: &[u64], out: &mut [f64]) -> Result<(), Error> {
        expect_length("out", out.len(), 7 * codes.len())?;
        threads::blocks(codes, 1, out, 7, |codes, out| {
            for (code, out) in codes.iter().zip(out.as_chunks_mut::<7>().0) {
                let (n, t) = self.decode(*code);
                out[..3].copy_from_slice(&n);
                out[3..].copy_from_slice(&t);
            }
        });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_basis_is_right_handed_at_both_poles() {
        for n in [
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
            [0.6, 0.0, -0.8],
            [0.0, 1.0, 0.0],
        ] {
            let (t, b) = basis(n);
            let cross = [
                t[1] * b[2] - t[2] * b[1],
                t[2] * b[0] - t[0] * b[2],
                t[0] * b[1] - t[1] * b[0],
            ];
            assert!((dot(cross, n) - 1.0).abs() < 1e-15, "{n:?}");
        }
    }

    #[test]
    fn what_lies_along_the_normal_does_not_count() {
        let frame = FramePacking::new("frame64").unwrap();
        let (large, small) = (600_f64.exp2(), (-600_f64).exp2());
        let n = [1.0, 2.0, -2.0].map(|x| x * large);
        let code = |v: [f64; 3]| {
            let [x, y, z] = v.map(|x| x * small);
            frame.encode(n, [x, y, z, 1.0])
        };
        assert!(code([2.0, 1.0, 2.0]).is_some());
        // The same and four times the normal.
        assert_eq!(code([6.0, 9.0, -6.0]), code([2.0, 1.0, 2.0]));
        assert_eq!(code([1.0, 2.0, -2.0]), None);
    }
}
