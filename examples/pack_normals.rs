//! Normals of a mesh in 32 bits each, and what that costs.
//!
//!     cargo run --example pack_normals

use spheremap::pack::{Invalid, Packing, Rounding};
use spheremap::prelude::*;

fn main() -> Result<(), Error> {
    // The normals of a torus.
    let side = 128;
    let normals: Vec<[f32; 3]> = (0..side * side)
        .map(|k| {
            let turn = std::f32::consts::TAU / side as f32;
            let (s, c) = ((k % side) as f32 * turn).sin_cos();
            let (sin, cos) = ((k / side) as f32 * turn).sin_cos();
            [c * cos, sin, s * cos]
        })
        .collect();

    for name in ["oct16", "oct32", "rgb10a2"] {
        let packing = Packing::new(name)?;
        let mut codes = vec![0_u32; normals.len()];
        let flat = normals.as_flattened();
        // The index of a normal that is none; of these there is none.
        let bad = packing.pack(Rounding::Nearest, Invalid::Raise, flat, &mut codes)?;
        assert_eq!(bad, None);
        let mut back = vec![[0.0_f32; 3]; normals.len()];
        packing.unpack(&codes, back.as_flattened_mut())?;
        let pairs = normals.iter().zip(&back);
        let worst = pairs
            .map(|(a, b)| Vec3::from(*a).distance(Vec3::from(*b)))
            .fold(0.0, f32::max);
        println!(
            "{name:8} {:2} bits, off by {worst:.1e} at most",
            packing.stored_bits()
        );
    }
    Ok(())
}
