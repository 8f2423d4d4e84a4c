//! The texels of an image as light: where from, how much, and how bright.
//!
//! What cuts an image into lights or looks for its sun asks for texels as a list, in the order in which they are
//! stored, and only for those that hold sphere. Each counts with the solid angle that it stands for
//! ([`crate::image::rim`]): the covered part of a texel across a rim is counted with the nearest one inside. Luminance is
//! a weighted sum of channels, in f64 and in their order.

use crate::error::{Error, expect_length};
use crate::geometry::vector::dot;
use crate::image::ImageView;
use crate::image::raster::Raster;
use crate::image::texel::Texel;
use crate::image::texels::Directions;
use crate::kernel::memory::expect_room;
use crate::kernel::{Scalar, interrupt, pages, threads, vectorize};
use crate::light::patches::{Patches, Points, Sheet};
use crate::map::Map;
use crate::number::angle;
use std::collections::BTreeMap;

/// Stored rows that are listed at a time.
const BAND: usize = 16;

/// Bands that are seen at a time.
const AT_A_TIME: usize = 8;

/// The texels of an image that hold sphere, in the order in which they are stored.
#[derive(Clone, Debug)]
pub struct Lit {
    /// How many numbers a texel has.
    pub channels: usize,
    /// The stored texel of each.
    pub index: Vec<usize>,
    /// Unit directions of their centers, in the world.
    pub direction: Vec<[f64; 3]>,
    /// Steradians.
    pub weight: Vec<f64>,
    /// Radiance, a row of channels each.
    pub light: Vec<f64>,
    /// Luminance.
    pub luminance: Vec<f64>,
}

/// A part of the sphere about a direction.
#[derive(Clone, Copy, Debug)]
pub struct Cap {
    axis: [f64; 3],
    /// The square of the chord from its middle to its rim.
    square: f64,
}

impl Cap {
    /// About a unit vector, of a radius in radians.
    pub fn new(axis: [f64; 3], radius: f64) -> Cap {
        let chord = 2.0 * angle::sin(0.5 * radius);
        Cap {
            axis,
            square: chord * chord,
        }
    }

    /// Whether any of some directions, three numbers each, lies in it.
    fn holds_any(self, toward: &[f64]) -> bool {
        vectorize(
            #[inline(always)]
            || {
                let toward = toward.as_chunks::<3>().0.iter();
                toward.fold(false, |any, toward| any | self.holds(toward))
            },
        )
    }

    /// Whether a parallel about an axis comes into it, so far along the axis and so far from it.
    fn meets(self, axis: [f64; 3], [along, from]: [f64; 2]) -> bool {
        let own = dot(self.axis, axis);
        let flat = (1.0 - own * own).max(0.0).sqrt();
        // The nearest place of a circle about an axis is in one plane with it. Rounding may move any of these by some 1e-16.
        let square = (along - own) * (along - own) + (from - flat) * (from - flat);
        square <= self.square * (1.0 + 1e-9) + 1e-9
    }

    #[inline(always)]
    fn holds(self, toward: &[f64]) -> bool {
        // One by one: a closure of `map` is inlined by luck.
        let square = |c: usize| (toward[c] - self.axis[c]) * (toward[c] - self.axis[c]);
        square(0) + square(1) + square(2) <= self.square
    }
}

/// The texels of an image one by one, each with what it counts with.
pub struct Counted<'a, T> {
    image: ImageView<'a, T>,
    patches: Patches<'a>,
    luminance: &'a [f64],
}

impl<'a, T: Texel> Counted<'a, T> {
    /// Of an image whose channels make luminance with these weights, one for each.
    pub fn new(image: &ImageView<'a, T>, luminance: &'a [f64]) -> Result<Self, Error> {
        expect_length("luminance", luminance.len(), image.channels())?;
        let patches = interrupt::part(0.0, 0.5, || Patches::new(image.map(), image.shape(), true))?;
        Ok(Counted {
            image: *image,
            patches,
            luminance,
        })
    }

    /// The image.
    pub fn image(&self) -> &ImageView<'a, T> {
        &self.image
    }

    /// Its patches.
    pub fn patches(&self) -> &Patches<'a> {
        &self.patches
    }

    /// What makes luminance of its channels.
    pub fn weights(&self) -> &'a [f64] {
        self.luminance
    }

    /// How many rows the image stores.
    pub fn stored_rows(&self) -> usize {
        self.raster().texels() / self.raster().columns
    }

    fn raster(&self) -> &Raster {
        self.image.raster()
    }

    /// Calls `see(column, solid angle, texel)` on the texels of a stored row that hold sphere.
    pub fn row(&self, row: usize, mut see: impl FnMut(usize, f64, &'a [T])) {
        let raster = self.raster();
        let solid_angles = self.patches.face_weights();
        for run in raster.runs(row) {
            let Some((_, start, step)) = run.face else {
                continue;
            };
            for k in 0..run.length {
                let at = |axis: usize| (start[axis] + k as isize * step[axis]) as usize;
                let solid_angle = solid_angles[at(1) * raster.width + at(0)];
                if solid_angle > 0.0 {
                    let column = run.column + k;
                    see(
                        column,
                        solid_angle,
                        self.image.texel(row * raster.columns + column),
                    );
                }
            }
        }
    }

    /// The luminance of a texel.
    #[inline(always)]
    pub fn luminance(&self, texel: &[T]) -> f64 {
        luminance_of(texel, self.luminance)
    }

    /// Where a stored texel looks.
    pub fn direction(&self, index: usize) -> [f64; 3] {
        direction_of(self.image.map(), self.raster(), index)
    }

    /// How many there are, and the sum of their solid angles.
    pub fn covered(&self) -> (usize, f64) {
        let (mut count, mut covered) = (0, 0.0);
        for row in 0..self.stored_rows() {
            self.row(row, |_, solid_angle, _| {
                count += 1;
                covered += solid_angle;
            });
        }
        (count, covered)
    }

    /// The list of them, or of those in a cap.
    pub fn listed(&self, cap: Option<Cap>) -> Result<Lit, Error> {
        let (raster, channels) = (self.raster(), self.image.channels());
        // All of this, growing by doubling, and what finding suns among it takes.
        let per_texel = 160 + 32 * channels;
        expect_room::<u8>(raster.texels().saturating_mul(per_texel))?;
        let directions = Directions::new(self.image.map(), raster, None);
        let mut bands = vec![Lit::none(channels); self.stored_rows().div_ceil(BAND)];
        threads::rows(&mut bands, 1, raster.texels() * 8, |band, lit| {
            lit[0] = self.band(&directions, band, cap);
        });
        interrupt::check()?;
        let mut all = Lit::none(channels);
        all.reserve(bands.iter().map(|band| band.index.len()).sum());
        for band in bands {
            all.index.extend(band.index);
            all.direction.extend(band.direction);
            all.weight.extend(band.weight);
            all.light.extend(band.light);
            all.luminance.extend(band.luminance);
        }
        Ok(all)
    }

    /// Calls `take` with what `see` makes of the list of each band of stored rows, in their order. Some are seen at a time, on all
    /// threads, and no more are in memory.
    pub fn in_bands<R: Send>(
        &self,
        see: impl Fn(Lit) -> R + Sync,
        mut take: impl FnMut(R),
    ) -> Result<(), Error> {
        let directions = Directions::new(self.image.map(), self.raster(), None);
        let points = BAND * AT_A_TIME * self.raster().columns * 8;
        let all = self.stored_rows().div_ceil(BAND);
        for first in (0..all).step_by(AT_A_TIME) {
            let mut seen: Vec<Option<R>> =
                (first..all.min(first + AT_A_TIME)).map(|_| None).collect();
            let [from, to] =
                [first, first + AT_A_TIME].map(|k| 0.5 + 0.4 * (k.min(all) as f64 / all as f64));
            interrupt::part(from, to, || {
                threads::rows(&mut seen, 1, points, |number, seen| {
                    seen[0] = Some(see(self.band(&directions, first + number, None)));
                });
            });
            interrupt::check()?;
            seen.into_iter().flatten().for_each(&mut take);
        }
        Ok(())
    }

    /// Whether no texel of a stored row lies in a cap, as far as can be told without looking where each lies.
    fn misses(&self, row: usize, cap: Cap) -> bool {
        let (map, raster) = (self.image.map(), self.raster());
        if map.meridians().is_none() {
            return false;
        }
        let axis = map.view_rotation(None).inverse().apply([0.0, 1.0, 0.0]);
        !cap.meets(axis, map.parallel(raster.along_v.center(row as f64)))
    }

    /// The list of those in a band of stored rows, or of those of them in a cap.
    fn band(&self, directions: &Directions<'_, f64>, number: usize, cap: Option<Cap>) -> Lit {
        let columns = self.raster().columns;
        let first = number * BAND;
        let rows = BAND.min(self.stored_rows() - first);
        let mut lit = Lit::none(self.image.channels());
        if cap.is_some_and(|cap| (first..first + rows).all(|row| self.misses(row, cap))) {
            return lit;
        }
        let mut toward = vec![0.0; 3 * columns * rows];
        if cap.is_none() {
            lit.reserve(columns * rows);
        }
        directions.rows(first, &mut toward);
        for (j, toward) in toward.chunks_exact(3 * columns).enumerate() {
            if cap.is_some_and(|cap| !cap.holds_any(toward)) {
                continue;
            }
            let row = first + j;
            self.row(row, |column, solid_angle, texel| {
                let toward = &toward[3 * column..][..3];
                if cap.is_none_or(|cap| cap.holds(toward)) {
                    lit.index.push(row * columns + column);
                    lit.direction.push([toward[0], toward[1], toward[2]]);
                    lit.weight.push(solid_angle);
                    lit.light.extend(texel.iter().map(|x| x.load().to_f64()));
                    lit.luminance.push(self.luminance(texel));
                }
            });
        }
        lit
    }
}

/// The luminance of a texel whose channels make it with these weights.
#[inline(always)]
pub fn luminance_of<T: Texel>(texel: &[T], weights: &[f64]) -> f64 {
    let products = texel.iter().zip(weights);
    products
        .filter(|(_, w)| **w != 0.0)
        .map(|(x, w)| x.load().to_f64() * w)
        .sum()
}

/// Texels whose luminance is found together.
const TOGETHER: usize = 1 << 12;

/// The luminance of each of some texels.
pub fn luminances<T: Texel>(texels: &[T], weights: &[f64], out: &mut [f64]) {
    let channels = weights.len();
    threads::rows(out, TOGETHER, texels.len(), |number, out| {
        let texels = texels[number * TOGETHER * channels..].chunks_exact(channels);
        for (out, texel) in out.iter_mut().zip(texels) {
            *out = luminance_of(texel, weights);
        }
    });
}

/// Where a stored texel looks.
pub fn direction_of(map: &Map, raster: &Raster, index: usize) -> [f64; 3] {
    let columns = raster.columns;
    let mut row = vec![0.0; 3 * columns];
    Directions::new(map, raster, None).rows(index / columns, &mut row);
    [0, 1, 2].map(|c| row[3 * (index % columns) + c])
}

impl Lit {
    /// The texels of an image whose channels make luminance with these weights, one for each.
    #[cfg(test)]
    pub fn new<T: Texel>(image: &ImageView<'_, T>, luminance: &[f64]) -> Result<Lit, Error> {
        Counted::new(image, luminance)?.listed(None)
    }

    /// The texels of a sheet, or those of them in a cap: one by one, in the order of its patches, or as means over blocks of so many
    /// rows and columns of stored texels.
    pub fn of_sheet<T: Texel>(
        image: &ImageView<'_, T>,
        luminance: &[f64],
        patches: &Patches<'_>,
        sheet: &Sheet,
        cap: Option<Cap>,
        block: usize,
    ) -> Lit {
        let mut lit = Lit::none(image.channels());
        let mut points = Points::new();
        for strip in sheet.strips.clone() {
            let weights = patches.strip_weights(strip, &sheet.columns);
            for column in sheet.columns.clone() {
                let count = patches.points(strip, column, &weights, true, &mut points);
                for k in 0..count {
                    let toward = points.direction.0.each_ref().map(|axis| axis[k]);
                    if cap.is_none_or(|cap| cap.holds(&toward)) {
                        let texel = image.texel(points.index[k]);
                        lit.index.push(points.index[k]);
                        lit.direction.push(toward);
                        lit.weight.push(points.weight[k]);
                        lit.light.extend(texel.iter().map(|x| x.load().to_f64()));
                        lit.luminance.push(luminance_of(texel, luminance));
                    }
                }
            }
        }
        if block > 1 {
            lit.means(patches.raster().columns, block)
        } else {
            lit
        }
    }

    /// Its means over blocks of stored texels, each in the place of the first of them.
    fn means(&self, columns: usize, block: usize) -> Lit {
        let mut of_block: BTreeMap<[usize; 2], Vec<usize>> = BTreeMap::new();
        for (k, index) in self.index.iter().enumerate() {
            let place = [index / columns / block, index % columns / block];
            of_block.entry(place).or_default().push(k);
        }
        let mut means = Lit::none(self.channels);
        for texels in of_block.values() {
            let weight: f64 = texels.iter().map(|k| self.weight[*k]).sum();
            let mean = |of: &dyn Fn(usize) -> f64| {
                let sum: f64 = texels.iter().map(|k| self.weight[*k] * of(*k)).sum();
                sum / weight
            };
            let toward = [0, 1, 2].map(|axis| mean(&|k| self.direction[k][axis]));
            let length = toward.iter().map(|x| x * x).sum::<f64>().sqrt();
            means
                .index
                .extend(texels.iter().map(|k| self.index[*k]).min());
            means.direction.push(toward.map(|x| x / length));
            means.weight.push(weight);
            means.luminance.push(mean(&|k| self.luminance[k]));
            let channels = 0..self.channels;
            means
                .light
                .extend(channels.map(|c| mean(&|k| self.light[k * self.channels + c])));
        }
        means
    }

    /// A row of numbers for each: index, direction, weight, luminance, light.
    pub fn numbers(&self) -> Vec<f64> {
        let mut numbers = Vec::with_capacity(self.index.len() * (6 + self.channels));
        for k in 0..self.index.len() {
            // Below 2⁵³, as whole numbers are that floats hold.
            numbers.push(self.index[k] as f64);
            numbers.extend(self.direction[k]);
            numbers.extend([self.weight[k], self.luminance[k]]);
            numbers.extend(self.radiance(k));
        }
        numbers
    }

    /// From such rows, in the order in which they are stored.
    pub fn of_numbers(numbers: &[f64], channels: usize) -> Lit {
        let mut rows: Vec<&[f64]> = numbers.chunks_exact(6 + channels).collect();
        rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut lit = Lit::none(channels);
        for row in rows {
            lit.index.push(row[0] as usize);
            lit.direction.push([row[1], row[2], row[3]]);
            lit.weight.push(row[4]);
            lit.luminance.push(row[5]);
            lit.light.extend(&row[6..]);
        }
        lit
    }

    fn none(channels: usize) -> Lit {
        Lit {
            channels,
            index: Vec::new(),
            direction: Vec::new(),
            weight: Vec::new(),
            light: Vec::new(),
            luminance: Vec::new(),
        }
    }

    /// Makes room for so many.
    fn reserve(&mut self, count: usize) {
        pages::reserve(&mut self.index, count);
        pages::reserve(&mut self.direction, count);
        pages::reserve(&mut self.weight, count);
        pages::reserve(&mut self.light, count * self.channels);
        pages::reserve(&mut self.luminance, count);
    }

    /// The radiance of one.
    pub fn radiance(&self, k: usize) -> &[f64] {
        &self.light[k * self.channels..][..self.channels]
    }

    /// The brightest, the first of several; none of an image that holds no sphere.
    pub fn brightest(&self) -> Option<usize> {
        let brighter = |best: Option<usize>, k: usize| match best {
            Some(best) if self.luminance[k] <= self.luminance[best] => Some(best),
            _ => Some(k),
        };
        (0..self.luminance.len()).fold(None, brighter)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::raster::shape_of_size;
    use crate::map::Map;

    #[test]
    fn blocks_hold_the_light_of_their_texels() {
        let disk = Map::new("angular").unwrap();
        let image: Vec<f32> = (0..40 * 40).map(|k| (k % 7) as f32).collect();
        let image = ImageView::new(&disk, &[40, 40], 1, &image).unwrap();
        let patches = Patches::of_parts(&disk, &[40, 40]).unwrap();
        let of = |block| Lit::of_sheet(&image, &[1.0], &patches, &patches.whole(), None, block);
        let (all, blocks) = (of(1), of(8));
        assert_eq!(blocks.index.len(), 5 * 5);
        let total = |lit: &Lit| {
            lit.weight
                .iter()
                .zip(&lit.light)
                .map(|(w, x)| w * x)
                .sum::<f64>()
        };
        // Sums of some 1300 numbers.
        assert!((total(&all) / total(&blocks) - 1.0).abs() < 1e-12);
        let numbers = all.numbers();
        let again = Lit::of_numbers(&numbers, 1);
        assert!(again.index.is_sorted() && again.index.len() == all.index.len());
        assert_eq!(
            total(&again).to_bits(),
            total(&Lit::new(&image, &[1.0]).unwrap()).to_bits()
        );
    }

    /// Whole bands are left out by their parallels alone.
    #[test]
    fn a_cap_holds_what_lies_in_it() {
        for name in [
            "latlong",
            "latlong:blender",
            "mercator",
            "hemi_latlong",
            "octahedral",
        ] {
            let map = Map::new(name).unwrap();
            let shape = shape_of_size(&map, 64);
            let image = vec![1.0_f32; shape.iter().product()];
            let image = ImageView::new(&map, &shape, 1, &image).unwrap();
            let counted = Counted::new(&image, &[1.0]).unwrap();
            let all = counted.listed(None).unwrap();
            for k in (0..all.index.len()).step_by(97) {
                for radius in [1e-6, 0.02, 0.4, 2.0] {
                    let cap = Cap::new(all.direction[k], radius);
                    let held = all.index.iter().zip(&all.direction);
                    let held = held
                        .filter(|(_, d)| cap.holds(&d[..]))
                        .map(|(index, _)| *index);
                    assert_eq!(
                        counted.listed(Some(cap)).unwrap().index,
                        held.collect::<Vec<_>>(),
                        "{name} {k} {radius}"
                    );
                }
            }
        }
    }

    #[test]
    fn only_what_holds_sphere_counts() {
        let disk = Map::new("angular").unwrap();
        let image: Vec<f32> = (0..16 * 16 * 2).map(|k| k as f32).collect();
        let image = ImageView::new(&disk, &[16, 16], 2, &image).unwrap();
        let lit = Lit::new(&image, &[0.0, 2.0]).unwrap();
        assert!(lit.index.len() < 256 && !lit.index.contains(&0));
        let covered: f64 = lit.weight.iter().sum();
        // Exact solid angles: rounding of some 200 sums.
        assert!((covered - 4.0 * std::f64::consts::PI).abs() < 1e-9);
        assert_eq!(
            lit.radiance(3),
            [0, 1].map(|c| (2 * lit.index[3] + c) as f64)
        );
        assert_eq!(lit.luminance[3], 2.0 * lit.radiance(3)[1]);
        assert_eq!(lit.brightest(), Some(lit.index.len() - 1));
        assert!(Lit::new(&image, &[1.0]).is_err());
    }
}
