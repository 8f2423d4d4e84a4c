//! Directions to image coordinates and back, one and many, by name and by type.
//!
//!     cargo run --example encode

use spheremap::prelude::*;

fn main() -> Result<(), Error> {
    // As Mitsuba lays out its environment maps.
    let map = Map::new("latlong:mitsuba")?;
    for (name, direction) in [("+x", DVec3::X), ("+y", DVec3::Y), ("+z", DVec3::Z)] {
        match map.encode_one(direction) {
            Some((_, uv)) => println!("{name} lands at u = {:.3}, v = {:.3}", uv.x, uv.y),
            None => println!("{name} is not in the image"),
        }
    }

    // A spiral of directions through an octahedral map and back.
    let octahedral = Map::from(Octahedral);
    let spiral: Vec<Vec3> = (0..1000)
        .map(|k| {
            let z = 1.0 - 2.0 * (k as f32 + 0.5) / 1000.0;
            let (sin, cos) = (2.4 * k as f32).sin_cos();
            let r = (1.0 - z * z).sqrt();
            Vec3::new(r * cos, r * sin, z)
        })
        .collect();
    let mut uv = vec![Vec2::ZERO; spiral.len()];
    octahedral.encode(&spiral, &mut uv)?;
    let mut back = vec![Vec3::ZERO; spiral.len()];
    octahedral.decode(&uv, &mut back)?;
    let pairs = spiral.iter().zip(&back);
    let worst = pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    println!(
        "{} directions there and back: off by {worst:.1e} at most",
        spiral.len()
    );
    assert!(worst < 1e-6);

    // What lengths do not go together is said.
    let error = octahedral.encode(&spiral, &mut uv[1..]).unwrap_err();
    println!("one place short: {error}");
    Ok(())
}
