//! Runs of texels of the target that follow each other in a row: parallelograms of nearly one shape.
//!
//! Where coordinates hardly bend, what 16 texels in a row see differs by where it lies, and by a little that is proportional to the
//! number of the texel. So shapes and how places are spread over them are found once a run, from the slopes at two nodes
//! of it, and its texels take the places of one number together: an offset from each center, no lane of which is idle. With a shape for each
//! texel, to find shapes and places took two thirds of the time that the lookups did.
//!
//! Only runs that lie inside of a face are answered for, with all texels that their lookups take part in.

use super::look::Room;
use super::lookups::support;
use super::mean::{Chunks, Margin, Rooms, Way, find, has_windows, put, texels_of};
use super::shapes::{Shapes, moved, off};
use super::slices::Sides;
use super::spread::{LANES, NUMBERS, division};
use super::texture::Texture;
use crate::image::raster::Raster;
use crate::image::texel::Texel;
use crate::kernel::tile::{TILE, Tile};
use crate::kernel::{Scalar, vectorize};
use crate::resample::filters::LookupFilter;
use crate::resample::polynomial::{self, NODE, RUN};

const _: () = assert!(RUN == LANES);

/// The most of a block: of 17 columns each row has two.
const RUNS: usize = 2 * TILE / LANES;

/// How far the first and the last texel of a run are from its middle.
const HALF: f32 = 0.5 * (LANES as f32 - 1.0);

/// What the texels of a block see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sight {
    /// A texel of the source each, but for those whose means were found.
    Single,
    /// Several, all of them inside of a face.
    Inside,
    /// Something is in the way.
    Other,
}

/// The runs of a block.
pub(crate) struct Runs {
    /// How many there are, and which texel of the block each begins with.
    count: usize,
    first: [usize; RUNS],
    /// Those that see several texels inside of a face, and how many these are: by the way in which means are found.
    inside: [[usize; RUNS]; 2],
    held: [usize; 2],
    /// The way in which they are being found.
    way: Way,
    /// In the middle of each run.
    shapes: Shapes<RUNS>,
    /// By how much the part of each side that places are spread over changes from one texel to the next.
    changes: [[[f32; RUNS]; 2]; 2],
    /// The centers of all texels, in texels of the source.
    centers: [[f64; TILE]; 2],
    /// Where the texels begin that they are in, and how far right and down they are from there.
    starts: [usize; TILE],
    off: [[f32; TILE]; 2],
    /// How many numbers lie from a texel to those right and below.
    steps: [i32; 2],
}

impl Runs {
    pub(crate) fn new() -> Self {
        Runs {
            count: 0,
            first: [0; RUNS],
            inside: [[0; RUNS]; 2],
            held: [0; 2],
            way: Way::Places,
            shapes: Shapes::NONE,
            changes: [[[0.0; RUNS]; 2]; 2],
            centers: [[0.0; TILE]; 2],
            starts: [0; TILE],
            off: [[0.0; TILE]; 2],
            steps: [0; 2],
        }
    }

    /// Takes over a block of so many columns and rows of a face: the places of its texels, and what its polynomial has at the nodes of runs:
    /// ∂u and ∂v to the right, and ∂u and ∂v down; and the second derivatives down, if they matter.
    pub(crate) fn set<R: Scalar>(
        &mut self,
        (raster, face, filter): (&Raster, usize, LookupFilter),
        [columns, rows]: [usize; 2],
        places: &Tile<R, 3>,
        (slopes, down): (&Tile<R, 4>, &Tile<R, 2>),
    ) -> Sight {
        self.held = [0; 2];
        self.shape(raster, [columns, rows], (slopes, down));
        let totals = &self.shapes.totals[..self.count];
        if totals.iter().all(|total| *total <= 1.0) {
            return Sight::Single;
        }
        let around = support(filter);
        let margin = Margin::new(raster, face, around);
        let grids = [raster.along_u.index(), raster.along_v.index()];
        let mut all = [None; RUNS];
        let windows = has_windows(filter);
        vectorize(
            #[inline(always)]
            || {
                for (axis, (scale, offset)) in grids.into_iter().enumerate() {
                    let centers = self.centers[axis].iter_mut().zip(&places.0[axis]);
                    for (center, place) in centers {
                        *center = place.to_f64() * scale + offset;
                    }
                }
                for (run, all) in all[..self.count].iter_mut().enumerate() {
                    let (total, fits) = (self.shapes.totals[run], self.shapes.fits[run]);
                    let way = Way::ALL
                        .into_iter()
                        .find(|way| way.takes(total, windows & fits));
                    let mut held = way.is_some();
                    let [x, y] = self.reach(run).map(f64::from);
                    let own = self.first[run]..self.first[run] + LANES;
                    let [xs, ys] = self.centers.each_ref().map(|row| &row[own.clone()]);
                    for (&center_x, &center_y) in xs.iter().zip(ys) {
                        let (inside_x, end_x) = margin.holds(0, center_x, x);
                        let (inside_y, end_y) = margin.holds(1, center_y, y);
                        held &= inside_x & inside_y & !(end_x & end_y);
                    }
                    *all = way.filter(|_| held);
                }
            },
        );
        for (run, way) in all.into_iter().enumerate().take(self.count) {
            if let Some(way) = way
                && self.is_valid(run, raster, around.after)
            {
                let held = &mut self.held[way as usize];
                self.inside[way as usize][*held] = run;
                *held += 1;
            }
        }
        let single = self.shapes.totals[..self.count].iter();
        let single = single.filter(|total| **total <= 1.0).count();
        match self.count - self.held.iter().sum::<usize>() {
            0 => Sight::Inside,
            rest if rest == single => Sight::Single,
            _ => Sight::Other,
        }
    }

    /// Whether any sees several texels inside of a face.
    pub(crate) fn any_inside(&self) -> bool {
        self.held != [0; 2]
    }

    /// Finds shapes.
    fn shape<R: Scalar>(
        &mut self,
        raster: &Raster,
        [columns, rows]: [usize; 2],
        (slopes, down): (&Tile<R, 4>, &Tile<R, 2>),
    ) {
        let scales = [raster.along_u.index().0, raster.along_v.index().0];
        let (mut middle, mut second) = ([[0.0; RUNS]; 4], [[0.0; RUNS]; 6]);
        self.count = 0;
        for row in 0..rows {
            for (number, first) in polynomial::runs(columns).enumerate() {
                let run = self.count;
                self.first[run] = row * columns + first;
                let at = polynomial::node_of(row, number);
                let nodes = |row: &[R; TILE], axis: usize| {
                    [row[at], row[at + 1]].map(|x| x.to_f64() * scales[axis])
                };
                for (k, row) in slopes.0.iter().enumerate() {
                    let [a, b] = nodes(row, k % 2);
                    middle[k][run] = (0.5 * (a + b)) as f32;
                    // ∂²u and ∂²v to the right from the first two, right and down from the others.
                    second[k][run] = ((b - a) / (2.0 * NODE)) as f32;
                }
                for (axis, row) in down.0.iter().enumerate() {
                    let [a, b] = nodes(row, axis);
                    second[4 + axis][run] = (0.5 * (a + b)) as f32;
                }
                self.count += 1;
            }
        }
        vectorize(
            #[inline(always)]
            || {
                self.shapes.set(&middle, &second);
                for side in [0, 1] {
                    let [x, y] = [&middle[2 * side], &middle[2 * side + 1]];
                    for k in 0..RUNS {
                        let (share, _) = division((x[k] * x[k] + y[k] * y[k]).sqrt());
                        self.changes[side][0][k] = share * second[2 * side][k];
                        self.changes[side][1][k] = share * second[2 * side + 1][k];
                    }
                }
            },
        );
    }

    /// How far places of any texel of a run are from its center along x and y, at most.
    #[inline(always)]
    fn reach(&self, run: usize) -> [f32; 2] {
        let [[ax, ay], [bx, by]] = &self.changes;
        let [x, y] = &self.shapes.reach;
        let more = |a: &[f32; RUNS], b: &[f32; RUNS]| 0.5 * HALF * (a[run].abs() + b[run].abs());
        [x[run] + more(ax, bx), y[run] + more(ay, by)]
    }

    /// Whether the image is valid wherever a run reaches, and so many texels around it, for certain.
    fn is_valid(&self, run: usize, raster: &Raster, around: usize) -> bool {
        if !raster.has_rim() {
            return true;
        }
        let own = self.first[run]..self.first[run] + LANES;
        let grids = [raster.along_u.index(), raster.along_v.index()];
        let reach = self.reach(run);
        let (mut place, mut reaches) = ([0.0; 2], [0.0; 2]);
        for axis in [0, 1] {
            let (scale, offset) = grids[axis];
            let centers = &self.centers[axis][own.clone()];
            let least = centers.iter().copied().fold(f64::INFINITY, f64::min);
            let most = centers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            place[axis] = (0.5 * (least + most) - offset) / scale;
            let reach = 0.5 * (most - least) + f64::from(reach[axis]) + around as f64;
            reaches[axis] = reach / scale;
        }
        raster.holds_around(place, reaches)
    }

    /// Finds the means of all texels of the runs that see several texels inside of a face: `done` there, and a texel in `means`. Returns
    /// how many that are.
    pub(crate) fn means<T: Texel>(
        &mut self,
        (source, filter): (&Texture<'_, T>, LookupFilter),
        (face, rooms): (usize, &mut Rooms<T::Float>),
        done: &mut [bool; TILE],
        means: &mut [T],
    ) -> usize {
        for way in Way::ALL {
            self.way = way;
            let held = self.held[way as usize];
            if held > 0 && find((source, filter, way), face, (self, rooms), means) {
                for &run in &self.inside[way as usize][..held] {
                    done[self.first[run]..][..LANES].fill(true);
                }
            }
        }
        done.iter().filter(|done| **done).count()
    }
}

impl<F: Scalar> Chunks<F> for Runs {
    fn sides(&self, chunk: usize, into: &mut Sides) {
        let run = self.inside[Way::Windows as usize][chunk];
        let own = self.first[run];
        into.count = LANES;
        for (k, texel) in into.own.iter_mut().enumerate() {
            *texel = own + k;
        }
        into.starts.copy_from_slice(&self.starts[own..own + LANES]);
        for axis in [0, 1] {
            let [c, _, e] = self.shapes.bends.each_ref().map(|bend| bend[axis][run]);
            let centers = into.off[axis].iter_mut().zip(&self.off[axis][own..]);
            for (off, center) in centers {
                *off = center + moved((c, e));
            }
            for side in [0, 1] {
                let middle = self.shapes.sides[side][axis][run];
                let change = self.changes[side][axis][run];
                for (k, side) in into.sides[side][axis].iter_mut().enumerate() {
                    *side = middle + (NUMBERS[k] - HALF) * change;
                }
            }
        }
    }

    fn start(&mut self, first: usize, steps: [i32; 2]) -> usize {
        self.steps = steps;
        vectorize(
            #[inline(always)]
            || {
                let (starts, off) = (&mut self.starts, &mut self.off);
                texels_of(self.centers.each_ref(), (first, steps), starts, off);
            },
        );
        self.held[self.way as usize]
    }

    fn place(&self, chunk: usize, room: &mut Room<F>) {
        let run = self.inside[Way::Places as usize][chunk];
        let own = self.first[run];
        room.count = LANES;
        for (k, texel) in room.own.iter_mut().enumerate() {
            *texel = own + k;
        }
        room.totals = [self.shapes.totals[run]; LANES];
        room.most = self.shapes.totals[run] as usize;
        let pair = |pair: &[[f32; RUNS]; 2]| pair.each_ref().map(|row| row[run]);
        let [[ax, ay], [bx, by]] = self.shapes.sides.each_ref().map(pair);
        let [[cx, cy], [dx, dy], [ex, ey]] = self.shapes.bends.each_ref().map(pair);
        let [[ax_by, ay_by], [bx_by, by_by]] = self.changes.each_ref().map(pair);
        let spread = self.shapes.spread(run);
        let (mut starts, mut ox, mut oy) = ([0; LANES], [0.0; LANES], [0.0; LANES]);
        starts.copy_from_slice(&self.starts[own..own + LANES]);
        ox.copy_from_slice(&self.off[0][own..own + LANES]);
        oy.copy_from_slice(&self.off[1][own..own + LANES]);
        vectorize(
            #[inline(always)]
            || {
                for first in (0..room.most).step_by(LANES) {
                    let (mut s, mut t) = ([0.0; LANES], [0.0; LANES]);
                    spread.places(first, &mut s, &mut t);
                    for (number, (&s, &t)) in s.iter().zip(&t).enumerate().take(room.most - first) {
                        let middle_x = off((s, t), (ax, bx), (cx, dx, ex));
                        let middle_y = off((s, t), (ay, by), (cy, dy, ey));
                        let change_x = s * ax_by + t * bx_by;
                        let change_y = s * ay_by + t * by_by;
                        let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
                        for k in 0..LANES {
                            let texel = NUMBERS[k] - HALF;
                            x[k] = ox[k] + (middle_x + texel * change_x);
                            y[k] = oy[k] + (middle_y + texel * change_y);
                        }
                        put(room, first + number, [&x, &y], (&starts, self.steps));
                    }
                }
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::super::parallelograms::{Parallelograms, TOGETHER};
    use super::*;
    use crate::image::raster::shape_of_size;
    use crate::image::view::ImageView;
    use crate::map::Map;
    use crate::resample::coordinate_map::CoordinateMap;
    use crate::resample::polynomial::{BLOCK, CoordinatePolynomials};

    /// Of the blocks of an image of random texels that have polynomials, the means of runs, and those of parallelograms of their own.
    fn means((source, target): (&str, &str), size: usize, filter: LookupFilter) -> Vec<[f32; 2]> {
        let [source, target] = [source, target].map(|name| Map::new(name).unwrap());
        let shape = shape_of_size(&source, 900);
        let texels: Vec<f32> = (0..shape.iter().product::<usize>() as u32)
            .map(|k| (k.wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 24) as f32)
            .collect();
        let image = ImageView::new(&source, &shape, 1, &texels).unwrap();
        let texture = Texture::new(&image);
        let raster = Raster::new(&target, &shape_of_size(&target, size)).unwrap();
        let coordinate_map = CoordinateMap::new(&source, &target, None);
        let patches =
            CoordinatePolynomials::new(coordinate_map, &texture.raster, &raster, 128).unwrap();
        let (mut runs, mut rooms) = (Runs::new(), Rooms::new());
        let mut own = Parallelograms::new();
        let mut found = Vec::new();
        raster.blocks(0, raster.rows, BLOCK, |whole| {
            let Ok(patch) = patches.of::<f32>(&whole) else {
                return;
            };
            if whole.columns < LANES {
                return;
            }
            for (row, block) in whole.bands(TILE / whole.columns, raster.columns) {
                let (mut places, mut slopes) = (Tile::new(), Tile::new());
                let (mut nodes, down, bends) = (Tile::new(), Tile::new(), Tile::new());
                patch.write(row, &block, &mut places);
                patch.slopes(row, &block, &mut slopes);
                patch.slopes_at_nodes(row, &block, &mut nodes);
                let face = places.0[2][0].whole() as usize;
                let of = (&texture.raster, face, filter);
                runs.set(of, [block.columns, block.rows], &places, (&nodes, &down));
                let (mut by_runs, mut by_own) = ([0.0; TILE], [0.0; TILE]);
                let mut done = [[false; TILE]; 2];
                let source = (&texture, filter);
                runs.means(source, (face, &mut rooms), &mut done[0], &mut by_runs);
                for first in [0, TOGETHER] {
                    own.set(of, (&places, first), (&slopes, &bends));
                    let (done, means) = (&mut done[1][first..], &mut by_own[first..]);
                    let done = &mut done[..TOGETHER];
                    own.means(source, (face, &mut rooms), done, means);
                }
                for k in 0..block.columns * block.rows {
                    if done[0][k] && done[1][k] {
                        found.push([by_runs[k], by_own[k]]);
                    }
                }
            }
        });
        found
    }

    /// Whatever the width: of 500 columns a row of blocks ends with runs that have texels in common. Texels are random between 0
    /// and 1, so that places that are off by a thirtieth of a texel, or fewer or more of them where counts
    /// change within a run, change means by a few hundredths; places of other texels would change most by a tenth and more.
    #[test]
    fn runs_have_nearly_the_means_of_their_texels() {
        for pair in [
            ("cube", "latlong"),
            ("latlong", "cube"),
            ("latlong", "angular"),
        ] {
            for size in [500, 512] {
                for filter in [LookupFilter::Bilinear, LookupFilter::Lanczos3] {
                    let found = means(pair, size, filter);
                    assert!(found.len() > 1000, "{pair:?} {size}: {}", found.len());
                    let off = found.iter().map(|[a, b]| (a - b).abs());
                    let mean = off.clone().sum::<f32>() / found.len() as f32;
                    let most = off.fold(0.0, f32::max);
                    assert!(mean < 0.02, "{pair:?} {size} {filter:?}: {mean} {most}");
                }
            }
        }
    }
}
