//! From one projection into another.
//!
//! The target is walked in blocks: texel centers, their directions, the source's coordinates of those, the filter.
//! Coordinates exist for one block at a time. For images that are filtered in f32, and are the whole sphere, most of them
//! come from polynomials through a few (`patch`), and they are f32 as well (f64 ones took half of the time) unless a side
//! is so long that it would show. Where the source ends somewhere, rounding would decide on which side of its border
//! a texel lies, so that polynomials stand for those alone that need no texel beyond it, and all are f64. Between two images of the same projection nothing is decoded, so that
//! what stays where it is stays what it is. There, and in images that are filtered in f64, places are the formula's own, and
//! polynomials say only what shape texels have in the source that are averaged.

use crate::error::Error;
use crate::image::raster::{Block, Raster};
use crate::image::texel::Texel;
use crate::image::texels::Centers;
use crate::kernel::Scalar;
use crate::kernel::tile::TILE;
use crate::kernel::{interrupt, threads};
use crate::projections::projection::Coverage;
use crate::resample::antialias::Antialias;
use crate::resample::coordinate_map::CoordinateMap;
use crate::resample::filters::LookupFilter;
use crate::resample::polynomial;
use crate::resample::polynomial::{CoordinatePolynomial, CoordinatePolynomials, Refused};
use crate::resample::request::Request;
use crate::resample::sample::{Lookups, Rectangle, Sight, Texture};
use crate::resample::window::Window;

/// The longest side for which f32 coordinates serve: they are off by up to 3·2⁻²³ of an image, 1/350 of a texel
/// there.
const SINGLE_SIDE: usize = 1 << 13;

/// The longest for which polynomials do: by as much there.
const PATCHED_SIDE: usize = 1 << 17;

/// Columns and rows of the target that are looked up together. Square-like blocks see a compact part of the
/// source: whole rows of a cube's top, for one, cross more of its rows than the CPU keeps page addresses for.
const BLOCK: (usize, usize) = (64, 4);

/// Those whose source coordinates one polynomial stands for.
const PATCH: (usize, usize) = polynomial::BLOCK;
const _: () = assert!(BLOCK.0 == PATCH.0 && BLOCK.0 * BLOCK.1 <= TILE);

/// A patch of fewer texels is not worth it, ...
const FEWEST: usize = 512;

/// ... or where texels are averaged, which costs more than their places do: so many at least, and more where they see few of the source.
const FEWEST_MEANS: [usize; 2] = [32, 128];

/// Fills the image that a request asks for. With `antialias`, texels that see more than one texel of the source are means
/// of what they see.
pub(crate) fn convert<T: Texel>(
    request: Request<'_, T>,
    filter: LookupFilter,
    antialias: bool,
    out: &mut [T],
) -> Result<(), Error> {
    let target = Raster::new(request.map, request.shape)?;
    // Means look most texels of the source up, however few texels the target has.
    let cost = if antialias {
        (request.image.raster().texels() / target.texels().max(1)).max(1)
    } else {
        1
    };
    let rows = threads::band_rows(target.rows, target.texels() * cost, PATCH.1);
    let block = (PATCH.0, rows);
    let map = request.image.map();
    let coordinate_map = CoordinateMap::new(map, request.map, request.rotation);
    let single = size_of::<T::Float>() == size_of::<f32>();
    let whole = map.coverage() == Coverage::Sphere;
    let rounds = single && !coordinate_map.same();
    let longest = [request.image.raster(), &target]
        .iter()
        .map(|raster| raster.width.max(raster.height))
        .fold(0, usize::max);
    let job = Conversion {
        source: &Texture::new(request.image),
        target,
        coordinate_map,
        // At a border of the source the texel that is nearest decides alone.
        patches: (rounds || antialias)
            && longest <= PATCHED_SIDE
            && (whole || filter != LookupFilter::Nearest),
        rounds,
        whole,
        filter,
        antialias,
        cost,
        fill: request.fill,
    };
    let window = request.window;
    window.fill(&target, window, block, out, |blocks, out| {
        interrupt::part(0.0, 1.0, || {
            if rounds && whole && longest <= SINGLE_SIDE {
                job.run::<f32>(blocks, rows, out);
            } else {
                job.run::<f64>(blocks, rows, out);
            }
        });
    })
}

struct Conversion<'s, 'a, T> {
    source: &'s Texture<'a, T>,
    target: Raster,
    coordinate_map: CoordinateMap<'s>,
    /// Whether polynomials serve for coordinates, or for what texels are in the source.
    patches: bool,
    /// Whether coordinates may be as far off as polynomials are.
    rounds: bool,
    /// Whether the source is the whole sphere.
    whole: bool,
    filter: LookupFilter,
    antialias: bool,
    /// About how many texels of the source are looked up for one of the target.
    cost: usize,
    fill: &'s [T],
}

impl<'s, T: Texel> Conversion<'s, '_, T> {
    /// Looks every texel of the target up where the coordinate_map takes it.
    fn run<R: Scalar>(&self, window: &Window, rows: usize, out: &mut [T]) {
        let target = &self.target;
        let centers = Centers::new(target);
        let channels = self.fill.len();
        let columns = window.columns.len();
        let width = columns * channels;
        let nothing = vec![T::Float::default(); channels];
        let fewest = if self.antialias {
            (FEWEST / self.cost).clamp(FEWEST_MEANS[0], FEWEST_MEANS[1])
        } else {
            FEWEST
        };
        let patches = self
            .patches
            .then(|| {
                let source = &self.source.raster;
                let all = CoordinatePolynomials::new(self.coordinate_map, source, target, fewest)?;
                Some(if self.antialias {
                    all.for_means(source)
                } else {
                    all
                })
            })
            .flatten();
        let points = window.texels() * self.cost;
        threads::rows(out, rows * width, points, |number, band| {
            let first = window.rows.start + number * rows;
            let height = band.len() / width;
            let mut walk = Walk::<T, R> {
                job: self,
                centers: &centers,
                columns,
                patches: patches.as_ref(),
                lookups: Lookups::new(self.source, self.filter, self.fill),
                means: self.antialias.then(|| {
                    Antialias::new(
                        self.source,
                        target,
                        self.coordinate_map,
                        self.filter,
                        &nothing,
                    )
                }),
                band,
            };
            let band = (first, window.columns.clone());
            target.blocks_within(band, height, PATCH, |whole| walk.patch(whole));
            walk.finish();
        });
    }
}

/// What fills a band of the target.
struct Walk<'w, 's, 'a, T: Texel, R: Scalar> {
    job: &'w Conversion<'s, 'a, T>,
    centers: &'w Centers<R>,
    /// Those of the band.
    columns: usize,
    patches: Option<&'w CoordinatePolynomials<'s>>,
    lookups: Lookups<'w, 'a, T, T, R>,
    means: Option<Antialias<'w, 'a, T, R>>,
    band: &'w mut [T],
}

impl<T: Texel, R: Scalar> Walk<'_, '_, '_, T, R> {
    /// Fills a block of the size of a patch, or a part of one. Where no polynomial stands for all of it, smaller ones may for
    /// its quarters: a rim or a pole spoils what it touches alone.
    fn patch(&mut self, whole: Block) {
        let target = &self.job.target;
        let patches = self.patches.filter(|_| !target.misses(&whole));
        let patch = patches.map_or(Err(Refused::Nowhere), |patches| patches.of(&whole));
        if let Some(means) = &mut self.means {
            means.next_patch(&whole);
        }
        let bent = match (&patch, &mut self.means) {
            (Ok(patch), Some(means)) => means.is_bent(patch),
            (refused, _) => matches!(refused, Err(Refused::Bent)),
        };
        if bent && patches.is_some_and(|patches| patches.serve(whole.quarter())) {
            for part in whole.parts(whole.quarter(), self.columns) {
                self.patch(part);
            }
            return;
        }
        let patch = patch.ok();
        let rows = (BLOCK.0 * BLOCK.1 / whole.columns).max(1);
        for (row, block) in whole.bands(rows, self.columns) {
            self.block(&block, patch.as_ref().map(|patch| (patch, row)));
        }
    }

    /// Fills a block of at most a tile, by the rows of a polynomial from one on, if there is one.
    fn block(&mut self, block: &Block, patch: Option<(&CoordinatePolynomial<R>, usize)>) {
        let Walk {
            job,
            centers,
            columns,
            lookups,
            means,
            band,
            ..
        } = self;
        let target = &job.target;
        let channels = job.fill.len();
        let area = Rectangle {
            start: block.start,
            columns: block.columns,
            stride: *columns,
        };
        if target.misses(block) {
            for row in 0..block.rows {
                let out = &mut band[(area.start + row * area.stride) * channels..];
                fill_texels(&mut out[..area.columns * channels], job.fill);
            }
            return;
        }
        let count = block.columns * block.rows;
        let mut patch = patch;
        let written = patch.filter(|_| job.rounds);
        if let Some((patch, row)) = written {
            patch.write(row, block, lookups.tile());
        } else {
            centers.of(block, lookups.tile());
            job.coordinate_map.take(lookups.tile(), count);
            patch = patch.filter(|(patch, _)| patch.has_face_of(lookups.tile(), count));
        }
        let mut sight = Sight::Other;
        if let Some(means) = means {
            if means.waits() {
                // Those of the block before come after its lookups.
                lookups.finish(band);
                means.write(band);
            }
            if let Some(patch) = patch {
                sight = means.inside(block, lookups.tile(), patch, area);
            }
            if sight == Sight::Inside {
                means.write(band);
                return;
            }
        }
        let placed = lookups.place(count);
        if let Some((polynomial, _)) = written
            && !(placed || job.whole && polynomial.holds(lookups.tile(), count))
        {
            centers.of(block, lookups.tile());
            job.coordinate_map.take(lookups.tile(), count);
            lookups.place(count);
            patch = patch.filter(|(patch, _)| patch.has_face_of(lookups.tile(), count));
            // What lies on another face the polynomial knows nothing of.
            sight = Sight::Other;
        }
        if let Some(means) = means
            && sight != Sight::Single
            && means.block(centers, block, lookups.tile(), patch, area)
        {
            means.write(band);
            return;
        }
        lookups.push(band, area);
    }

    /// Does what is left to do.
    fn finish(mut self) {
        self.lookups.finish(self.band);
        if let Some(means) = &mut self.means {
            means.write(self.band);
        }
    }
}

fn fill_texels<T: Copy>(out: &mut [T], texel: &[T]) {
    out.chunks_exact_mut(texel.len())
        .for_each(|out| out.copy_from_slice(texel));
}
