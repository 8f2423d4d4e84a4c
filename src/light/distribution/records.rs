//! What each texel holds, gathered for samples.

use crate::geometry::solid_angle::Rect;
use crate::image::raster::Raster;
use crate::image::rim::nearest_valid_texel;
use crate::image::texel::Texel;
use crate::kernel::pages;
use crate::kernel::threads;
use crate::projections::projection::Outline;

/// For each texel, face by face, the stored texel that holds its value; none where it covers nothing.
pub(super) fn sources(raster: &Raster, faces: usize) -> Vec<Option<usize>> {
    let mut sources = vec![None; raster.width * raster.height * faces];
    threads::rows(
        &mut sources,
        raster.width,
        sources_work(raster, faces),
        |row, sources| {
            let (face, j) = (row / raster.height, row % raster.height);
            let view = raster.view(face);
            for (i, source) in sources.iter_mut().enumerate() {
                if covers_some(raster, i, j) {
                    let (a, b) = nearest_valid_texel(raster, i, j);
                    *source = Some(view.index(a, b));
                }
            }
        },
    );
    sources
}

fn sources_work(raster: &Raster, faces: usize) -> usize {
    raster.width * raster.height * faces
}

/// Whether a part of texel (i, j) lies in the valid image.
fn covers_some(raster: &Raster, i: usize, j: usize) -> bool {
    if !raster.has_rim() {
        return true;
    }
    let ((u0, u1), (v0, v1)) = (raster.along_u.cell(i), raster.along_v.cell(j));
    if raster.outline == Outline::Shape {
        return raster.holds(i as isize, j as isize)
            || raster.solid_angle(Rect { u0, u1, v0, v1 }) > 0.0;
    }
    let (p, q) = (0.5_f64.clamp(u0, u1) - 0.5, 0.5_f64.clamp(v0, v1) - 0.5);
    p * p + q * q < 0.25
}

pub(super) fn recorded<T: Texel>(
    sources: &[Option<usize>],
    stored: &[T],
    channels: usize,
    density: &[f32],
) -> Vec<T> {
    let mut out = Vec::with_capacity(sources.len() * (channels + 1));
    pages::advise(&mut out);
    for (source, density) in sources.iter().zip(density) {
        match source {
            Some(texel) => out.extend_from_slice(&stored[texel * channels..][..channels]),
            None => out.extend(std::iter::repeat_n(T::default(), channels)),
        }
        out.push(T::from_f64(f64::from(*density)));
    }
    out
}
