//! A panorama in a file to the six faces of a cube, laid out as a cross, in another.
//!
//!     cargo run --example convert [panorama.ppm cross.ppm]
//!
//! The files are binary PPM of 8 bits a channel. Without arguments a sky is painted and converted in a folder for what
//! may be lost.

use spheremap::prelude::*;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::{env, fs};

/// Width, height and the texels, three numbers each.
type Image = (usize, usize, Vec<u8>);

fn read(path: &Path) -> Result<Image, Box<dyn Error>> {
    let bytes = fs::read(path)?;
    // "P6", width, height and 255, each ended by one space or line feed.
    let mut rest = &bytes[..];
    let mut word = || -> Option<String> {
        let end = rest.iter().position(u8::is_ascii_whitespace)?;
        let text = String::from_utf8(rest[..end].to_vec()).ok()?;
        rest = &rest[end + 1..];
        Some(text)
    };
    let header = [word(), word(), word(), word()].map(Option::unwrap_or_default);
    let [magic, width, height, most] = &header;
    if magic != "P6" || most != "255" {
        return Err(format!("{} is no PPM of 8 bits", path.display()).into());
    }
    Ok((width.parse()?, height.parse()?, rest.to_vec()))
}

fn write(path: &Path, (width, height, texels): &Image) -> std::io::Result<()> {
    let header = format!("P6\n{width} {height}\n255\n");
    fs::write(path, [header.as_bytes(), texels].concat())
}

/// A panorama that shows each direction in a color of its own.
fn painted() -> Result<Image, Box<dyn Error>> {
    let (map, width, height) = (Map::new("latlong")?, 256, 128);
    let centers = (0..width * height).map(|k| {
        let (i, j) = (k % width, k / width);
        [
            (i as f32 + 0.5) / width as f32,
            (j as f32 + 0.5) / height as f32,
        ]
    });
    let uv: Vec<[f32; 2]> = centers.collect();
    let mut directions = vec![[0.0; 3]; uv.len()];
    map.decode(&uv, &mut directions)?;
    let color = |x: f32| (127.5 * (x + 1.0)).round() as u8;
    Ok((
        width,
        height,
        directions
            .as_flattened()
            .iter()
            .map(|x| color(*x))
            .collect(),
    ))
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<PathBuf> = env::args_os().skip(1).map(PathBuf::from).collect();
    let (from, into) = match &arguments[..] {
        [from, into] => (from.clone(), into.clone()),
        _ => {
            let folder = env::temp_dir();
            let from = folder.join("spheremap-panorama.ppm");
            write(&from, &painted()?)?;
            (from, folder.join("spheremap-cross.ppm"))
        }
    };

    let (width, height, texels) = read(&from)?;
    let panorama = Map::new("latlong")?;
    let cross = Map::with("cube", MapOptions::new().layout("cross"))?;
    let side = height / 2;
    let shape = [3 * side, 4 * side];
    let source_shape = [height, width];
    let image = ImageView::new(&panorama, &source_shape, 3, &texels)?;
    let out = converted(&image, &cross, &shape, &Options::new())?;

    write(&into, &(shape[1], shape[0], out))?;
    println!("{} to {}", from.display(), into.display());
    Ok(())
}
