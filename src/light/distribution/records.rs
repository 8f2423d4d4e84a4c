//! What each texel holds, gathered for samples.

use crate::geometry::solid_angle::Rect;
use crate::image::raster::Raster;
use crate::image::rim::nearest_valid_texel;
use crate::image::texel::Texel;
use crate::kernel::pages;
use crate::kernel::threads;
use crate::map::Map;
use crate::projections::projection::Outline;
use std::borrow::Cow;

/// Where the values of texels are, face by face.
pub(super) enum Sources {
    /// They are stored in this order.
    InOrder,
    /// For each texel the stored one that holds its value; none where it covers nothing.
    Listed(Vec<Option<usize>>),
}

impl Sources {
    pub(super) fn new(map: &Map, raster: &Raster) -> Sources {
        let layout = map.face_layout();
        if layout.is_canonical() && !raster.has_rim() {
            Sources::InOrder
        } else {
            Sources::Listed(sources(raster, layout.faces))
        }
    }

    /// One number a texel, from one a stored texel: 0 where there is none.
    pub(super) fn of<'n>(&self, stored: &'n [f64]) -> Cow<'n, [f64]> {
        match self {
            Sources::InOrder => stored.into(),
            Sources::Listed(sources) => {
                let of = |source: &Option<usize>| source.map_or(0.0, |texel| stored[texel]);
                sources.iter().map(of).collect()
            }
        }
    }
}

fn sources(raster: &Raster, faces: usize) -> Vec<Option<usize>> {
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
    sources: &Sources,
    stored: &[T],
    channels: usize,
    density: &[f32],
) -> Vec<T> {
    let width = channels + 1;
    let mut out = vec![T::default(); density.len() * width];
    pages::advise(&mut out);
    let points = out.len();
    threads::rows(&mut out, TOGETHER * width, points, |number, out| {
        for (k, record) in (number * TOGETHER..).zip(out.chunks_exact_mut(width)) {
            let source = match sources {
                Sources::InOrder => Some(k),
                Sources::Listed(sources) => sources[k],
            };
            if let Some(texel) = source {
                record[..channels].copy_from_slice(&stored[texel * channels..][..channels]);
            }
            record[channels] = T::from_f64(f64::from(density[k]));
        }
    });
    out
}

/// Records that are put together at a time.
const TOGETHER: usize = 1 << 12;
