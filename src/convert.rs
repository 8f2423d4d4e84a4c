//! From one projection into another.
//!
//! The target is walked in tiles of a stored row: texel centres, their directions, the source's coordinates of
//! those, the filter. Coordinates exist for one tile at a time. They are f64: an f32 coordinate
//! of a 4096-wide image is off by 1/4000 of a texel, which would show in a conversion to the same
//! projection.

use crate::error::Error;
use crate::frame::Turn;
use crate::image::{Raster, Texel};
use crate::kernel::Scalar;
use crate::light::solid_angle::Rect;
use crate::map::{DecodeCanonical, EncodeCanonical, Map};
use crate::projection::Projection;
use crate::projections::Visitor;
use crate::sample::{Filter, Source, TILE};
use crate::threads;
use glam::DMat3;

/// Fills an image of `map` with what `source` (of `source_map`) shows when turned by `rotation`.
#[expect(
    clippy::too_many_arguments,
    reason = "each is one independent option of the call"
)]
pub fn convert<T: Texel>(
    source_map: &Map,
    source: &Source<'_, T>,
    map: &Map,
    shape: &[usize],
    rotation: Option<DMat3>,
    filter: Filter,
    fill: &[T],
    out: &mut [T],
) -> Result<(), Error> {
    let channels = fill.len();
    let into_source = source_map.turn(rotation);
    let from_target = map.turn(None).inverse();
    walk(map, shape, channels, out, fill, |uv, out| {
        let mut directions = [0.0; 3 * TILE];
        let directions = &mut directions[..uv.len()];
        map.visit_canonical(DecodeCanonical {
            turn: from_target,
            input: uv,
            output: directions,
        });
        source_map.visit_canonical(EncodeCanonical {
            turn: into_source,
            input: directions,
            output: uv,
        });
        source.lookup(filter, fill, uv, out);
    })
}

/// The direction of every texel centre; NaN outside the valid image.
pub fn directions<R: Scalar>(
    map: &Map,
    shape: &[usize],
    rotation: Option<DMat3>,
    out: &mut [R],
) -> Result<(), Error> {
    let turn: Turn = map.turn(rotation).inverse();
    let nan = [R::new(f64::NAN); 3];
    walk(map, shape, 3, out, &nan, |uv: &mut [R], out| {
        map.visit_canonical(DecodeCanonical {
            turn,
            input: uv,
            output: out,
        });
    })
}

/// Calls `work` with the canonical (u, v, face) of each tile of the image and the place of its texels.
fn walk<R: Scalar, T: Copy + Send + Sync>(
    map: &Map,
    shape: &[usize],
    channels: usize,
    out: &mut [T],
    empty: &[T],
    work: impl Fn(&mut [R], &mut [T]) + Sync,
) -> Result<(), Error> {
    let raster = Raster::new(map, shape)?;
    threads::rows(
        out,
        raster.columns * channels,
        raster.texels(),
        |row, out| {
            let mut uv = [R::default(); 3 * TILE];
            for run in raster.runs(row) {
                let out = &mut out[run.column * channels..][..run.length * channels];
                if run.face.is_none() {
                    out.chunks_exact_mut(channels)
                        .for_each(|texel| texel.copy_from_slice(empty));
                    continue;
                }
                for (tile, out) in out.chunks_mut(TILE * channels).enumerate() {
                    let n = out.len() / channels;
                    let uv = &mut uv[..3 * n];
                    raster.centres(&run, tile * TILE, n, uv);
                    work(uv, out);
                }
            }
        },
    );
    Ok(())
}

/// The exact solid angle of every texel, rims included; 0 where no face is.
pub fn solid_angles(map: &Map, shape: &[usize], out: &mut [f64]) -> Result<(), Error> {
    struct OfTexel(Rect);
    impl Visitor for OfTexel {
        type Output = f64;
        fn visit<P: Projection>(self, p: P) -> f64 {
            p.solid_angle(self.0)
        }
    }
    let raster = Raster::new(map, shape)?;
    threads::rows(out, raster.columns, raster.texels() * 16, |row, out| {
        for run in raster.runs(row) {
            let out = &mut out[run.column..][..run.length];
            let Some((_, start, step)) = run.face else {
                out.fill(0.0);
                continue;
            };
            for (k, out) in out.iter_mut().enumerate() {
                let at = |axis: usize| (start[axis] + k as isize * step[axis]) as usize;
                let (u0, u1) = raster.along_u.cell(at(0));
                let (v0, v1) = raster.along_v.cell(at(1));
                *out = map.visit_canonical(OfTexel(Rect { u0, u1, v0, v1 }));
            }
        }
    });
    Ok(())
}
