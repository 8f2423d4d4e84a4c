//! The next level of a mip chain, whole or a window of it, made of the part that the window needs.
//!
//! A texel of the next level is the mean, by solid angle, of the texels that its rectangle covers, and nothing else is asked: so a
//! window has the bits of the whole. At a rim it is asked further away. A texel across it holds no value, and what of the sphere it
//! covers has that of the nearest texel that does: of the level before ([`rim::nearest_valid_texel`]), and of the next one, where such a texel's
//! sum goes to the one that owns it.

mod pairs;
mod side;

use crate::error::Error;
use crate::image::raster::Raster;
use crate::image::rim::{self, Across};
use crate::image::texel::Texel;
use crate::image::texels::{SolidAngles, solid_angle_of};
use crate::kernel::Scalar;
use crate::kernel::memory::expect_room;
use crate::kernel::threads;
use crate::map::Map;
use crate::number::real::Real;
use crate::projections::faces::MAX_FACES;
use crate::resample::window::Window;
use pairs::{Covered, are_pairs};
use side::{Covers, Side};
use std::cmp::Ordering;
use std::ops::Range;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;

/// How a level of an image becomes the next one.
pub(crate) struct Halving {
    map: Map,
    /// The level's geometry.
    pub(crate) fine: Raster,
    /// That of the next one.
    pub(crate) coarse: Raster,
    /// Its shape without channels.
    pub(crate) shape: Vec<usize>,
    /// The columns and rows of a face.
    across: Side,
    down: Side,
    solid_angles: SolidAngles,
    /// Texels of the next level across its rim that cover something, by their owners, those of one by rows.
    moved: Vec<Across>,
}

/// Texels of a level: those of a part of it.
#[derive(Clone, Copy)]
pub(crate) struct Held<'a, T> {
    /// Row by row.
    pub(crate) texels: &'a [T],
    /// Where they lie.
    pub(crate) part: &'a Window,
    /// Numbers of each.
    pub(crate) channels: usize,
}

/// A rectangle of a face: columns and rows.
type Rect = [Range<usize>; 2];

/// The solid angles of a rectangle of parts of a face's texels.
struct Cells<'r> {
    /// The columns of a face of the next level that cover it.
    columns: Range<usize>,
    /// Numbers of parts along both sides.
    rect: Rect,
    solid_angles: &'r [f64],
    /// Whether all are above 0.
    lit: bool,
}

/// The shape of the next level of an image of this shape, without channels; none where it cannot be made smaller, or no texel of it
/// would hold a value: lookups would have none.
pub(crate) fn smaller(map: &Map, shape: &[usize]) -> Result<Option<Vec<usize>>, Error> {
    let fine = Raster::new(map, shape)?;
    if fine.width.min(fine.height) < 2 {
        return Ok(None);
    }
    let layout = map.face_layout();
    let mut smaller = shape.to_vec();
    let n = smaller.len();
    smaller[n - 2] = fine.height / 2 * layout.rows;
    smaller[n - 1] = fine.width / 2 * layout.columns;
    // A grid of corners has no faces of one texel.
    let holds = Raster::new(map, &smaller).is_ok_and(|raster| raster.holds_any());
    Ok(holds.then_some(smaller))
}

impl Halving {
    /// Of an image of this shape without channels; none where it cannot be made smaller.
    pub(crate) fn new(map: &Map, shape: &[usize]) -> Result<Option<Halving>, Error> {
        let Some(smaller) = smaller(map, shape)? else {
            return Ok(None);
        };
        let (fine, coarse) = (Raster::new(map, shape)?, Raster::new(map, &smaller)?);
        let mut halving = Halving {
            map: map.clone(),
            fine,
            coarse,
            shape: smaller,
            across: Side::new(fine.along_u, fine.width, coarse.along_u, coarse.width),
            down: Side::new(fine.along_v, fine.height, coarse.along_v, coarse.height),
            solid_angles: SolidAngles::new(map, &fine),
            moved: Vec::new(),
        };
        let covers = |i, j| halving.covers(i, j);
        let mut moved = rim::across(&coarse, covers);
        moved.sort_by(|a, b| by_rows(a.owner, b.owner));
        halving.moved = moved;
        Ok(Some(halving))
    }

    /// Texels of the level across its rim that cover something, by rows: what [`Halving::needs`] asks of many windows.
    pub(crate) fn rim(&self) -> Vec<Across> {
        let covers = |i, j| solid_angle_of(&self.map, &self.fine, i, j) > 0.0;
        rim::across(&self.fine, covers)
    }

    /// Whether a texel of the next level covers anything of the sphere.
    fn covers(&self, i: usize, j: usize) -> bool {
        self.down.across[j].iter().any(|y| {
            let mut columns = self.across.across[i].iter();
            columns.any(|x| solid_angle_of(&self.map, &self.fine, x.texel, y.texel) > 0.0)
        })
    }

    /// The part of the level, within one rectangle of it, that a window of the next one is made of.
    pub(crate) fn needs(&self, rim: &[Across], window: &Window) -> Window {
        let mut needed: Option<Window> = None;
        for (face, rect) in self.faces(window).into_iter().enumerate() {
            let Some(rect) = rect else {
                continue;
            };
            let mut fine = self.covered(&rect);
            let rows = between(&self.moved, |moved| moved.owner[1], &rect[1]);
            for moved in rows.iter().filter(|moved| holds(&rect, moved.owner)) {
                let [i, j] = moved.texel;
                let [xs, ys] = self.covered(&[i..i + 1, j..j + 1]);
                include(&mut fine, [xs.start, ys.start]);
                include(&mut fine, [xs.end - 1, ys.end - 1]);
            }
            let covered = fine.clone();
            let rows = between(rim, |across| across.texel[1], &covered[1]);
            for across in rows.iter().filter(|across| holds(&covered, across.texel)) {
                include(&mut fine, across.owner);
            }
            let view = self.fine.view(face);
            let [xs, ys] = fine;
            for texel in [
                view.index(xs.start, ys.start),
                view.index(xs.end - 1, ys.end - 1),
            ] {
                let (row, column) = (texel / self.fine.columns, texel % self.fine.columns);
                let one = Window {
                    rows: row..row + 1,
                    columns: column..column + 1,
                };
                needed.get_or_insert(one).include(texel, &self.fine);
            }
        }
        needed.unwrap_or(Window {
            rows: 0..0,
            columns: 0..0,
        })
    }

    /// Fills a window of the next level, of zeros, from what it needs of this one. `room` is memory for solid angles, which windows
    /// that follow each other share.
    pub(crate) fn fill<T: Texel>(
        &self,
        held: Held<'_, T>,
        window: &Window,
        room: &mut Vec<f64>,
        out: &mut [T::Float],
    ) -> Result<(), Error> {
        let Held {
            texels,
            part,
            channels,
        } = held;
        let cells = self.cells(window, room)?;
        let weight = |x: Covers, y: Covers| {
            let [xs, ys] = &cells.rect;
            if xs.contains(&x.part) && ys.contains(&y.part) {
                cells.solid_angles[(y.part - ys.start) * xs.len() + x.part - xs.start]
            } else {
                // Of what a texel across the rim covers, there may be some beyond.
                let mut one = [0.0];
                self.parts(x.part, y.part, &mut one);
                one[0]
            }
        };
        let has_rim = self.fine.has_rim();
        let width = 1 + 2 * channels;
        let corner = [part.rows.start, part.columns.start];
        let views: Vec<_> = (0..self.fine.faces())
            .map(|face| {
                let view = self.fine.view(face);
                view.within(self.fine.columns, corner, part.columns.len())
            })
            .collect();
        // For a texel: its weight, and for each channel the first value and the sum of what the others differ by, so
        // that a constant stays constant to the bit.
        let sum = |face: usize, [i, j]: [usize; 2], sums: &mut [f64]| {
            sums[0] = 0.0;
            for &y in &self.down.across[j] {
                for &x in &self.across.across[i] {
                    let weight = weight(x, y);
                    if weight > 0.0 {
                        // Of a texel across the rim the part belongs here, and the value to another.
                        let (x, y) = if has_rim {
                            rim::nearest_valid_texel(&self.fine, x.texel, y.texel)
                        } else {
                            (x.texel, y.texel)
                        };
                        let k = views[face].index(x, y) * channels;
                        add(sums, weight, |c| texels[k + c].load().to_f64());
                    }
                }
            }
        };
        let plain = cells.lit && !has_rim && self.moved.is_empty();
        let pairs = are_pairs(&self.across.across[cells.columns.clone()]);
        // Whether a texel is made of what it covers, and all of that holds values.
        let is_whole = |owned: &[Across], [i, j]: [usize; 2]| {
            let holds = |x: Covers, y: Covers| {
                let is_held = || self.fine.holds(x.texel as isize, y.texel as isize);
                weight(x, y) > 0.0 && (!has_rim || is_held())
            };
            let covers = |&y: &Covers| self.across.across[i].iter().all(|&x| holds(x, y));
            of(owned, [i, j]).is_empty() && self.down.across[j].iter().all(covers)
        };
        let by_pairs = |face: usize, [i, j]: [usize; 2], out: &mut [T::Float]| {
            let view = &views[face];
            let count = out.len() / channels;
            if view.steps()[0] != 1 {
                return false;
            }
            let [xs, ys] = &cells.rect;
            let x = self.across.across[i][0];
            let covered = |y: &Covers| {
                let first = (y.part - ys.start) * xs.len() + x.part - xs.start;
                let texel = view.index(x.texel, y.texel);
                Covered {
                    texels: &texels[texel * channels..][..2 * count * channels],
                    solid_angles: &cells.solid_angles[first..][..2 * count],
                }
            };
            let rows: Vec<_> = self.down.across[j].iter().map(covered).collect();
            pairs::fill(channels, &rows, out);
            true
        };
        let work = |row: usize, out: &mut [T::Float]| {
            let (mut sums, mut moved) = (vec![0.0; width], vec![0.0; width]);
            for run in self.coarse.runs(window.rows.start + row) {
                let first = run.column.max(window.columns.start);
                let end = (run.column + run.length).min(window.columns.end);
                let (Some((face, start, step)), true) = (run.face, first < end) else {
                    continue;
                };
                let at = |column: usize| {
                    let k = (column - run.column) as isize;
                    [0, 1].map(|c| (start[c] + k * step[c]) as usize)
                };
                let owned = if step[1] == 0 {
                    let j = at(first)[1];
                    between(&self.moved, |moved| moved.owner[1], &(j..j + 1))
                } else {
                    &self.moved
                };
                let own = |columns: Range<usize>| {
                    let [from, to] =
                        [columns.start, columns.end].map(|c| (c - window.columns.start) * channels);
                    from..to
                };
                let in_pairs = pairs && step == [1, 0];
                let mut column = first;
                while column < end {
                    let whole = match in_pairs {
                        true if plain => column..end,
                        true => {
                            let part = |c: &usize| !is_whole(owned, at(*c));
                            column..(column..end).find(part).unwrap_or(end)
                        }
                        false => column..column,
                    };
                    let stop = whole.end;
                    if !whole.is_empty() && by_pairs(face, at(column), &mut out[own(whole)]) {
                        column = stop;
                        continue;
                    }
                    for column in column..stop.max(column + 1) {
                        let texel = at(column);
                        sum(face, texel, &mut sums);
                        for across in of(owned, texel) {
                            sum(face, across.texel, &mut moved);
                            let own = moved[0];
                            if own > 0.0 {
                                add(&mut sums, own, |c| {
                                    moved[1 + 2 * c] + moved[2 + 2 * c] / own
                                });
                            }
                        }
                        if sums[0] > 0.0 {
                            finish::<T>(&sums, &mut out[own(column..column + 1)]);
                        }
                    }
                    column = stop.max(column + 1);
                }
            }
        };
        let row = window.columns.len() * channels;
        threads::rows(out, row, 4 * window.texels(), work);
        Ok(())
    }

    /// What a window of the next level has of each face.
    fn faces(&self, window: &Window) -> [Option<Rect>; MAX_FACES] {
        let mut found = [const { None }; MAX_FACES];
        for row in window.rows.clone() {
            for run in self.coarse.runs(row) {
                let first = run.column.max(window.columns.start);
                let end = (run.column + run.length).min(window.columns.end);
                let (Some((face, start, step)), true) = (run.face, first < end) else {
                    continue;
                };
                for column in [first, end - 1] {
                    let k = (column - run.column) as isize;
                    let [i, j] = [0, 1].map(|c| (start[c] + k * step[c]) as usize);
                    let rect = found[face].get_or_insert([i..i + 1, j..j + 1]);
                    include(rect, [i, j]);
                }
            }
        }
        found
    }

    /// What a rectangle of the next level covers of this one: texels.
    fn covered(&self, rect: &Rect) -> Rect {
        self.ranges(rect, |covers| covers.texel)
    }

    /// Texels or parts that a rectangle of the next level covers.
    fn ranges(&self, [is, js]: &Rect, number: impl Fn(&Covers) -> usize) -> Rect {
        let range = |across: &[Vec<Covers>]| {
            let first = across.first().and_then(|covered| covered.first());
            let last = across.last().and_then(|covered| covered.last());
            match (first, last) {
                (Some(first), Some(last)) => number(first)..number(last) + 1,
                _ => 0..0,
            }
        };
        [
            range(&self.across.across[is.clone()]),
            range(&self.down.across[js.clone()]),
        ]
    }

    /// Finds the solid angles of parts of a row of them, from one on.
    fn parts(&self, first: usize, row: usize, out: &mut [f64]) {
        let (map, fine) = (&self.map, &self.fine);
        let (across, down) = (&self.across, &self.down);
        if across.whole && down.whole {
            return self.solid_angles.row(map, fine, row, first, out);
        }
        let sides = (down.edges[row], down.edges[row + 1]);
        let end = first + out.len();
        let columns = (&across.texels[first..end], &across.edges[first..=end]);
        (self.solid_angles).parts((map, fine), (down.texels[row], sides), columns, out);
    }

    /// The solid angles of all that a window of the next level covers, which are alike on all faces.
    fn cells<'r>(&self, window: &Window, room: &'r mut Vec<f64>) -> Result<Cells<'r>, Error> {
        let mut all: Option<Rect> = None;
        let mut columns: Option<Range<usize>> = None;
        for rect in self.faces(window).into_iter().flatten() {
            let [xs, ys] = self.ranges(&rect, |covers| covers.part);
            let own = columns.get_or_insert(rect[0].clone());
            *own = own.start.min(rect[0].start)..own.end.max(rect[0].end);
            let all = all.get_or_insert([xs.clone(), ys.clone()]);
            include(all, [xs.start, ys.start]);
            include(all, [xs.end - 1, ys.end - 1]);
        }
        let rect = all.unwrap_or([0..0, 0..0]);
        let (wide, high) = (rect[0].len(), rect[1].len());
        if room.len() < wide * high {
            expect_room::<f64>(wide * high)?;
            *room = vec![0.0; wide * high];
        }
        let solid_angles = &mut room[..wide * high];
        let lit = AtomicBool::new(true);
        threads::rows(solid_angles, wide, wide * high * 16, |row, out| {
            self.parts(rect[0].start, rect[1].start + row, out);
            // All of them are looked at, which makes lanes.
            if !out.iter().fold(true, |all, x| all & (*x > 0.0)) {
                lit.store(false, Relaxed);
            }
        });
        Ok(Cells {
            columns: columns.unwrap_or(0..0),
            rect,
            solid_angles,
            lit: lit.into_inner(),
        })
    }
}

fn include(rect: &mut Rect, texel: [usize; 2]) {
    for (range, at) in rect.iter_mut().zip(texel) {
        *range = range.start.min(at)..range.end.max(at + 1);
    }
}

fn holds([columns, rows]: &Rect, [i, j]: [usize; 2]) -> bool {
    columns.contains(&i) && rows.contains(&j)
}

fn by_rows([i, j]: [usize; 2], [a, b]: [usize; 2]) -> Ordering {
    (j, i).cmp(&(b, a))
}

/// Those of a list, sorted by these rows, that lie in some of them.
fn between<'a>(
    list: &'a [Across],
    row: impl Fn(&Across) -> usize,
    rows: &Range<usize>,
) -> &'a [Across] {
    let first = list.partition_point(|across| row(across) < rows.start);
    let end = list.partition_point(|across| row(across) < rows.end);
    &list[first..end]
}

/// Those of a list, sorted by their owners, that a texel owns.
fn of(list: &[Across], texel: [usize; 2]) -> &[Across] {
    let first = list.partition_point(|across| by_rows(across.owner, texel) == Ordering::Less);
    let rest = &list[first..];
    let count = rest.iter().take_while(|across| across.owner == texel);
    &rest[..count.count()]
}

fn add(sums: &mut [f64], weight: f64, value: impl Fn(usize) -> f64) {
    let new = sums[0] == 0.0;
    sums[0] += weight;
    for (c, sum) in sums[1..].chunks_exact_mut(2).enumerate() {
        if new {
            (sum[0], sum[1]) = (value(c), 0.0);
        }
        sum[1] += weight * (value(c) - sum[0]);
    }
}

/// Writes the mean that these sums are of, channel by channel.
fn finish<T: Texel>(sums: &[f64], out: &mut [T::Float]) {
    for (sum, out) in sums[1..].chunks_exact(2).zip(out) {
        *out = <T::Float as Real>::new(sum[0] + sum[1] / sums[0]);
    }
}

#[cfg(test)]
mod tests {
    use super::{Halving, Held, are_pairs};
    use crate::image::texels::solid_angle_of;
    use crate::image::view::ImageView;
    use crate::map::Map;
    use crate::resample::chain;
    use crate::resample::window::Window;
    use proptest::prelude::*;

    fn map(name: &str) -> (Map, Vec<usize>) {
        let (name, shape) = match name {
            "atlas" => ("cube:filament", vec![63, 84]),
            "faces" => ("cube", vec![6, 19, 19]),
            "corners" => ("latlong:cmft", vec![25, 49]),
            "even" => ("latlong", vec![32, 64]),
            "even atlas" => ("cube:filament", vec![48, 64]),
            "even faces" => ("cube", vec![6, 20, 20]),
            "disk" => ("angular", vec![41, 37]),
            "disks" => ("dual_fisheye", vec![2, 30, 30]),
            "shape" => ("sinusoidal", vec![31, 62]),
            "camera" => ("camera_brown_conrady(k1=-0.1)", vec![33, 40]),
            _ => ("latlong", vec![33, 67]),
        };
        (Map::new(name).unwrap(), shape)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// A window has the bits of the whole level, from the part that it needs.
        #[test]
        fn a_window_is_a_part_of_the_level(
            name in prop::sample::select(vec!["even", "even atlas", "even faces", "atlas", "faces", "corners", "disk", "disks", "shape", "camera", "latlong"]),
            ends in prop::array::uniform4(0.0..1.0),
        ) {
            let (map, shape) = map(name);
            let count: usize = shape.iter().product();
            let texels: Vec<f32> = (0..2 * count).map(|k| (k as f32 * 0.37).sin()).collect();
            let image = ImageView::new(&map, &shape, 2, &texels).unwrap();
            let halving = Halving::new(&map, &shape).unwrap().unwrap();
            let (level, whole) = &chain(&image).unwrap()[0];
            prop_assert_eq!(level, &halving.shape);
            let range = |a: f64, b: f64, all: usize| {
                let [a, b] = [a.min(b), a.max(b)].map(|x| (x * all as f64) as usize);
                a..(b + 1)
            };
            let (fine, coarse) = (&halving.fine, &halving.coarse);
            let window = Window {
                rows: range(ends[0], ends[1], coarse.rows),
                columns: range(ends[2], ends[3], coarse.columns),
            };
            let part = halving.needs(&halving.rim(), &window);
            prop_assert!(part.check(fine).is_ok());
            let of = |texels: &[f32], columns: usize, window: &Window| -> Vec<f32> {
                let width = 2 * window.columns.len();
                let row = |row: usize| &texels[2 * (row * columns + window.columns.start)..][..width];
                window.rows.clone().flat_map(row).copied().collect()
            };
            let held = Held {
                texels: &of(&texels, fine.columns, &part),
                part: &part,
                channels: 2,
            };
            let mut made = vec![0.0; 2 * window.texels()];
            halving.fill(held, &window, &mut Vec::new(), &mut made).unwrap();
            let wanted = of(whole, coarse.columns, &window);
            prop_assert!(made.iter().zip(&wanted).all(|(a, b)| a.to_bits() == b.to_bits()));
        }
    }

    #[test]
    fn a_row_of_pairs_is_summed_as_its_texels_are() {
        let map = Map::new("latlong").unwrap();
        let halving = Halving::new(&map, &[8, 16]).unwrap().unwrap();
        let part = Window {
            rows: 0..8,
            columns: 0..16,
        };
        for channels in 1..=5 {
            let texels: Vec<f64> = (0..8 * 16 * channels)
                .map(|k| (k as f64 * 0.73).sin())
                .collect();
            let held = Held {
                texels: &texels,
                part: &part,
                channels,
            };
            let window = Window {
                rows: 0..4,
                columns: 0..8,
            };
            let mut made = vec![0.0; 4 * 8 * channels];
            halving
                .fill(held, &window, &mut Vec::new(), &mut made)
                .unwrap();
            assert!(are_pairs(&halving.across.across[0..8]));
            for (k, made) in made.iter().enumerate() {
                let (texel, c) = (k / channels, k % channels);
                let (i, j) = (texel % 8, texel / 8);
                let (mut sum, mut weight) = (0.0, 0.0);
                for (x, y) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let (x, y) = (2 * i + x, 2 * j + y);
                    let own = solid_angle_of(&map, &halving.fine, x, y);
                    sum += own * texels[(y * 16 + x) * channels + c];
                    weight += own;
                }
                assert!((made - sum / weight).abs() < 1e-15, "{channels} {k}");
            }
        }
    }
}
