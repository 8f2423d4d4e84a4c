//! From one projection into another.
//!
//! The target is walked in tiles of a stored row: texel centres, their directions, the source's coordinates of
//! those, the filter. Coordinates exist for one tile at a time. For images that are filtered in f32 they are f32 as
//! well (f64 ones took half of the time) unless a side is so long that it would show, or the source ends somewhere and
//! rounding would decide on which side of its border a texel lies; between two images of the same projection
//! nothing is decoded, so that what stays where it is stays what it is.

use crate::error::Error;
use crate::frame::Turn;
use crate::image::{Centres, Raster, Texel};
use crate::kernel::Scalar;
use crate::light::solid_angle::Rect;
use crate::map::Map;
use crate::projection::{Coverage, Projection, Uv};
use crate::projections::Visitor;
use crate::sample::{Area, Filter, Lookups, Source, TILE};
use crate::threads;
use crate::verbs::{DecodeCanonical, EncodeCanonical};
use glam::DMat3;

/// The longest side for which f32 coordinates serve: they are off by up to 3·2⁻²³ of an image, 1/350 of a texel
/// there.
const SINGLE_SIDE: usize = 1 << 13;

/// Columns and rows of the target that are looked up together. Square-like blocks see a compact part of the
/// source: whole rows of a cube's top, for one, cross more of its rows than the CPU keeps page addresses for.
const BLOCK: (usize, usize) = (64, 4);
const _: () = assert!(BLOCK.0 * BLOCK.1 <= TILE);

/// Fills an image of `map` with what `source` shows when turned by `rotation`.
pub fn convert<T: Texel>(
    source: &Source<'_, T>,
    map: &Map,
    shape: &[usize],
    rotation: Option<DMat3>,
    filter: Filter,
    fill: &[T],
    out: &mut [T],
) -> Result<(), Error> {
    let target = Raster::new(map, shape)?;
    let single = size_of::<T::Float>() == size_of::<f32>();
    let short = [source.raster(), &target]
        .iter()
        .all(|raster| raster.width.max(raster.height) <= SINGLE_SIDE);
    if rotation.is_none() && source.map().same_formula(map) {
        look(
            source,
            &target,
            filter,
            fill,
            out,
            |uv: &mut [[f64; 3]]| {
                map.visit_canonical(OnlyValid(uv));
            },
        );
    } else if single && short && source.map().coverage() == Coverage::Sphere {
        resample::<T, f32>(source, map, &target, rotation, filter, fill, out);
    } else {
        resample::<T, f64>(source, map, &target, rotation, filter, fill, out);
    }
    Ok(())
}

fn resample<T: Texel, R: Scalar>(
    source: &Source<'_, T>,
    map: &Map,
    target: &Raster,
    rotation: Option<DMat3>,
    filter: Filter,
    fill: &[T],
    out: &mut [T],
) {
    let into_source = source.map().turn(rotation);
    let from_target = map.turn(None).inverse();
    look(source, target, filter, fill, out, |uv: &mut [[R; 3]]| {
        let mut directions = [[R::default(); 3]; TILE];
        let directions = &mut directions[..uv.len()];
        map.visit_canonical(DecodeCanonical {
            turn: from_target,
            input: uv.as_flattened(),
            output: directions.as_flattened_mut(),
        });
        source.map().visit_canonical(EncodeCanonical {
            turn: into_source,
            input: directions.as_flattened(),
            output: uv.as_flattened_mut(),
        });
    });
}

/// Looks up every texel of `target` where `into_source` takes its canonical (u, v, face).
fn look<T: Texel, R: Scalar>(
    source: &Source<'_, T>,
    target: &Raster,
    filter: Filter,
    fill: &[T],
    out: &mut [T],
    into_source: impl Fn(&mut [[R; 3]]) + Sync,
) {
    let centres = Centres::new(target);
    let channels = fill.len();
    let width = target.columns * channels;
    threads::bands(out, width, target.texels(), BLOCK.1, |first, band| {
        let mut lookups = Lookups::new(source, filter, fill);
        let mut uv = [[R::default(); 3]; TILE];
        let rows = band.len() / width;
        target.blocks(first, rows, BLOCK, |block| {
            let area = Area {
                start: block.start,
                columns: block.columns,
                stride: target.columns,
            };
            if block.face.is_none() {
                for row in 0..block.rows {
                    let out = &mut band[(area.start + row * area.stride) * channels..];
                    fill_texels(&mut out[..area.columns * channels], fill);
                }
                return;
            }
            let uv = &mut uv[..block.columns * block.rows];
            centres.of(&block, uv);
            into_source(uv);
            lookups.push(uv, band, area);
        });
        lookups.finish(band);
    });
}

fn fill_texels<T: Copy>(out: &mut [T], texel: &[T]) {
    out.chunks_exact_mut(texel.len())
        .for_each(|out| out.copy_from_slice(texel));
}

/// Makes NaN of coordinates outside the valid image.
struct OnlyValid<'a, R>(&'a mut [[R; 3]]);

impl<R: Scalar> Visitor for OnlyValid<'_, R> {
    type Output = ();
    fn visit<P: Projection>(self, p: P) {
        for [u, v, face] in self.0 {
            let uv = Uv {
                u: *u,
                v: *v,
                face: *face,
            };
            if !p.contains(uv) {
                *u = R::new(f64::NAN);
            }
        }
    }
}

/// The direction of every texel centre; NaN outside the valid image.
pub fn directions<R: Scalar>(
    map: &Map,
    shape: &[usize],
    rotation: Option<DMat3>,
    out: &mut [R],
) -> Result<(), Error> {
    let turn: Turn = map.turn(rotation).inverse();
    let raster = Raster::new(map, shape)?;
    let centres = Centres::new(&raster);
    let width = 3 * raster.columns;
    threads::bands(out, width, raster.texels(), 1, |first, band| {
        let mut uv = [[R::default(); 3]; TILE];
        raster.blocks(first, band.len() / width, (TILE, 1), |block| {
            let out = &mut band[3 * block.start..][..3 * block.columns];
            if block.face.is_none() {
                return out.fill(R::new(f64::NAN));
            }
            let uv = &mut uv[..block.columns];
            centres.of(&block, uv);
            map.visit_canonical(DecodeCanonical {
                turn,
                input: uv.as_flattened(),
                output: out,
            });
        });
    });
    Ok(())
}

/// The exact solid angle of every texel, rims included; 0 where no face is.
pub fn solid_angles(map: &Map, shape: &[usize], out: &mut [f64]) -> Result<(), Error> {
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
                *out = map.solid_angle(Rect { u0, u1, v0, v1 });
            }
        }
    });
    Ok(())
}
