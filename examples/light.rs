//! What a sky sheds on surfaces: its integral, irradiance, the same in nine numbers, and samples toward its sun.
//!
//!     cargo run --example light

use spheremap::light::distribution::Distribution;
use spheremap::light::{Lobe, integrate, sh, under};
use spheremap::prelude::*;

fn main() -> Result<(), Error> {
    // A dim sky above the horizon with a sun of one texel.
    let mut sky: Vec<f64> = (0..64 * 128)
        .map(|k| if k < 32 * 128 { 0.5 } else { 0.1 })
        .collect();
    sky[12 * 128 + 40] = 2000.0;
    let map = Map::new("latlong")?;
    let image = ImageView::new(&map, &[64, 128], 1, &sky)?;

    let total = integrate(&image)?;
    println!("in all      {:.3}", total[0]);

    let normals = [DVec3::Y, DVec3::X, DVec3::NEG_Y];
    let flat: Vec<f64> = normals.iter().flat_map(|n| n.to_array()).collect();
    let mut irradiance = [0.0; 3];
    under(&image, Lobe::Cosine, &flat, &mut irradiance)?;
    println!("irradiance  {irradiance:.3?} above, beside, below");

    // Nine coefficients hold the irradiance of any light to about a percent of the largest.
    let light = sh::project(&image, 2, sh::Samples::Means)?;
    let cosine = sh::lobes::find("cosine")?.factors(0.0, 2)?;
    let smooth = sh::scale_degrees(&light, 1, &cosine)?;
    let mut nine = [0.0; 3];
    sh::evaluate(&smooth, 1, &flat, &mut nine)?;
    println!("from nine   {nine:.3?}");

    // Directions drawn as often as the sky is bright there.
    let distribution = Distribution::new(&image, &sky)?;
    let xi: Vec<f64> = (0..2 * 256).map(|k| (k as f64 * 0.618_034) % 1.0).collect();
    let (mut directions, mut pdf) = (vec![0.0; 3 * 256], vec![0.0; 256]);
    distribution.sample(&xi, &mut directions, &mut pdf, &mut [])?;
    let at_sun = pdf.iter().filter(|pdf| **pdf > 1.0).count();
    println!("{at_sun} of 256 samples go to the sun");
    Ok(())
}
