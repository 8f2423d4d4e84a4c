//! From one projection into another.
//!
//! The target is walked in blocks: texel centers, their directions, the source's coordinates of those, the filter.
//! Coordinates exist for one block at a time. For images that are filtered in f32, and are the whole sphere, most of them
//! come from polynomials through a few (`patch`), and they are f32 as well (f64 ones took half of the time) unless a side
//! is so long that it would show. Where the source ends somewhere, rounding would decide on which side of its border
//! a texel lies, so that all are computed, in f64. Between two images of the same projection nothing is decoded, so that
//! what stays where it is stays what it is.

use crate::antialias::Antialias;
use crate::error::Error;
use crate::frame::Turn;
use crate::image::{Centers, Raster, Texel};
use crate::kernel::Scalar;
use crate::light::solid_angle::Rect;
use crate::map::Map;
use crate::patch::{self, Patch, Patches};
use crate::projection::Coverage;
use crate::route::Route;
use crate::sample::{Area, Filter, Lookups, Source};
use crate::threads;
use crate::tile::{TILE, Tile, TuplesMut};
use crate::verbs::DecodeTile;
use glam::DMat3;

/// The longest side for which f32 coordinates serve: they are off by up to 3·2⁻²³ of an image, 1/350 of a texel
/// there.
const SINGLE_SIDE: usize = 1 << 13;

/// The longest for which polynomials do: by as much there.
const PATCHED_SIDE: usize = 1 << 17;

/// Columns and rows of the target that are looked up together. Square-like blocks see a compact part of the
/// source: whole rows of a cube's top, for one, cross more of its rows than the CPU keeps page addresses for.
const BLOCK: (usize, usize) = (64, 4);

/// Those whose source coordinates one polynomial stands for.
const PATCH: (usize, usize) = patch::BLOCK;
const _: () = assert!(BLOCK.0 == PATCH.0 && BLOCK.0 * BLOCK.1 <= TILE);

/// Fills an image of `map` with what `source` shows when turned by `rotation`. With `antialias`, texels that see more than
/// one texel of the source are means of what they see.
#[expect(clippy::too_many_arguments, reason = "a verb with all its options")]
pub fn convert<T: Texel>(
    source: &Source<'_, T>,
    map: &Map,
    shape: &[usize],
    rotation: Option<DMat3>,
    filter: Filter,
    antialias: bool,
    fill: &[T],
    out: &mut [T],
) -> Result<(), Error> {
    let target = Raster::new(map, shape)?;
    let route = Route::new(source.map(), map, rotation);
    let single = size_of::<T::Float>() == size_of::<f32>();
    let rounds = single && !route.same() && source.map().coverage() == Coverage::Sphere;
    let longest = [source.raster(), &target]
        .iter()
        .map(|raster| raster.width.max(raster.height))
        .fold(0, usize::max);
    let job = Job {
        source,
        target,
        route,
        patches: rounds && longest <= PATCHED_SIDE,
        filter,
        antialias,
        fill,
    };
    if rounds && longest <= SINGLE_SIDE {
        job.run::<f32>(out);
    } else {
        job.run::<f64>(out);
    }
    Ok(())
}

struct Job<'s, 'a, T> {
    source: &'s Source<'a, T>,
    target: Raster,
    route: Route<'s>,
    /// Whether polynomials serve for coordinates.
    patches: bool,
    filter: Filter,
    antialias: bool,
    fill: &'s [T],
}

impl<T: Texel> Job<'_, '_, T> {
    /// Looks every texel of the target up where the route takes it.
    fn run<R: Scalar>(&self, out: &mut [T]) {
        let target = &self.target;
        let centers = Centers::new(target);
        let channels = self.fill.len();
        let width = target.columns * channels;
        let nothing = vec![T::Float::default(); channels];
        let patches = self
            .patches
            .then(|| Patches::new(self.route, self.source.raster(), target))
            .flatten();
        threads::bands(out, width, target.texels(), PATCH.1, |first, band| {
            let mut lookups = Lookups::new(self.source, self.filter, self.fill);
            let mut means = self
                .antialias
                .then(|| Antialias::new(self.source, target, self.route, self.filter, &nothing));
            let rows = band.len() / width;
            target.blocks(first, rows, PATCH, |whole| {
                let patches = patches.as_ref().filter(|_| !target.misses(&whole));
                let patch = patches.and_then(|patches| patches.of(&whole));
                if let Some(means) = &mut means {
                    means.next_patch();
                }
                for (row, block) in whole.bands(BLOCK.1, target.columns) {
                    let area = Area {
                        start: block.start,
                        columns: block.columns,
                        stride: target.columns,
                    };
                    if target.misses(&block) {
                        for row in 0..block.rows {
                            let out = &mut band[(area.start + row * area.stride) * channels..];
                            fill_texels(&mut out[..area.columns * channels], self.fill);
                        }
                        continue;
                    }
                    let count = block.columns * block.rows;
                    let patched = patch.as_ref().is_some_and(|patch: &Patch<R>| {
                        patch.write(row, &block, lookups.tile());
                        lookups.place(count) || patch.holds(lookups.tile(), count)
                    });
                    if !patched {
                        centers.of(&block, lookups.tile());
                        self.route.take(lookups.tile(), count);
                        lookups.place(count);
                    }
                    lookups.push(band, area);
                    if let Some(means) = &mut means {
                        // Texels of the block before, which are there since this one was pushed.
                        means.write(band);
                        let patch = patch.as_ref().filter(|_| patched).map(|patch| (patch, row));
                        means.block(&centers, &block, lookups.pushed(), patch, area);
                    }
                }
            });
            lookups.finish(band);
            if let Some(means) = &mut means {
                means.write(band);
            }
        });
    }
}

fn fill_texels<T: Copy>(out: &mut [T], texel: &[T]) {
    out.chunks_exact_mut(texel.len())
        .for_each(|out| out.copy_from_slice(texel));
}

/// The direction of every texel center; NaN outside the valid image.
pub fn directions<R: Scalar>(
    map: &Map,
    shape: &[usize],
    rotation: Option<DMat3>,
    out: &mut [R],
) -> Result<(), Error> {
    let turn: Turn = map.turn(rotation).inverse();
    let raster = Raster::new(map, shape)?;
    let centers = Centers::new(&raster);
    let width = 3 * raster.columns;
    threads::bands(out, width, raster.texels(), 1, |first, band| {
        let mut uv = Tile::new();
        raster.blocks(first, band.len() / width, (TILE, 1), |block| {
            let out = &mut band[3 * block.start..][..3 * block.columns];
            if block.face.is_none() {
                return out.fill(R::new(f64::NAN));
            }
            centers.of(&block, &mut uv);
            map.visit_canonical(DecodeTile {
                turn,
                input: &uv,
                output: TuplesMut::of(out),
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
