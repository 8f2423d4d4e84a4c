//! Which tiles of an image lookups with a footprint read, in place of what is read: an image need not be there for that.
//!
//! Lookups go the way that they go among texels, over edges as well, so what is found is all of it.

use super::ellipse;
use super::in_level::{Held, InLevel, InTexture};
use super::level::{ByPlace, ByTile, Level};
use super::taps::Taps;
use super::texture::Texture;
use crate::image::raster::Raster;
use crate::image::texel::Texel;
use crate::map::Map;
use crate::resample::window::Window;
use std::ops::RangeInclusive;
use std::sync::atomic::{AtomicBool, Ordering};

/// An image of whose tiles is known which ones were seen. No tile has a part in two faces.
pub(crate) struct Seen<'a> {
    texture: Texture<'a, f32>,
    /// Rows and columns of a tile, and how many tiles a face has along both.
    tile: [usize; 2],
    count: [usize; 2],
    seen: Vec<AtomicBool>,
    /// For each face what each of its columns, and each of its rows, adds to the number of a tile.
    along: Vec<[Vec<u32>; 2]>,
}

impl<'a> Seen<'a> {
    /// Of an image of this geometry, nothing.
    pub(crate) fn new(map: &'a Map, raster: &Raster, tile: [usize; 2]) -> Self {
        let tile = tile.map(|side| side.max(1));
        let count = [
            raster.height.div_ceil(tile[0]),
            raster.width.div_ceil(tile[1]),
        ];
        let cells = raster.rows / raster.height * (raster.columns / raster.width);
        let all = cells * count[0] * count[1];
        let mut found = Seen {
            texture: Texture::geometry(map, raster, 0),
            tile,
            count,
            seen: (0..all).map(|_| AtomicBool::new(false)).collect(),
            along: Vec::new(),
        };
        let along = raster.views()[..raster.faces()].iter().map(|view| {
            let first = found.number(view.index(0, 0)) as u32;
            let columns = (0..raster.width).map(|i| found.number(view.index(i, 0)) as u32);
            let rows = (0..raster.height).map(|j| found.number(view.index(0, j)) as u32);
            // With turned faces they may go down.
            let rows = rows.map(|number| number.wrapping_sub(first));
            [columns.collect(), rows.collect()]
        });
        found.along = along.collect();
        found
    }

    /// The tiles that were seen.
    pub(crate) fn tiles(&self) -> Vec<Window> {
        let raster = &self.texture.raster;
        let seen = (self.seen.iter().enumerate()).filter(|(_, seen)| seen.load(Ordering::Relaxed));
        seen.map(|(number, _)| {
            let (rest, along_u) = (number / self.count[1], number % self.count[1]);
            let (cell, along_v) = (rest / self.count[0], rest % self.count[0]);
            let cells = raster.columns / raster.width;
            let side = |cell: usize, face: usize, tile: usize, k: usize| {
                let (first, end) = (k * tile, ((k + 1) * tile).min(face));
                cell * face + first..cell * face + end
            };
            Window {
                rows: side(cell / cells, raster.height, self.tile[0], along_v),
                columns: side(cell % cells, raster.width, self.tile[1], along_u),
            }
        })
        .collect()
    }

    /// The number of the tile that holds a stored texel.
    fn number(&self, texel: usize) -> usize {
        let raster = &self.texture.raster;
        let (row, column) = (texel / raster.columns, texel % raster.columns);
        let cells = raster.columns / raster.width;
        let cell = row / raster.height * cells + column / raster.width;
        let along_v = row % raster.height / self.tile[0];
        let along_u = column % raster.width / self.tile[1];
        (cell * self.count[0] + along_v) * self.count[1] + along_u
    }

    fn see(&self, number: usize) {
        // Threads that only read what all know do not wait for each other.
        if !self.seen[number].load(Ordering::Relaxed) {
            self.seen[number].store(true, Ordering::Relaxed);
        }
    }

    /// Takes the tiles in that have a part in a rectangle of texels of a face; false where not all of these hold something for
    /// certain.
    fn see_rectangle(
        &self,
        face: usize,
        uv: [f64; 2],
        [columns, rows]: [RangeInclusive<isize>; 2],
    ) -> bool {
        let raster = &self.texture.raster;
        let (left, right, top, bottom) =
            (*columns.start(), *columns.end(), *rows.start(), *rows.end());
        let within = left >= 0
            && top >= 0
            && left <= right
            && top <= bottom
            && (right as usize) < raster.width
            && (bottom as usize) < raster.height;
        let reach = |from: isize, to: isize, (scale, _): (f64, f64)| (to - from + 1) as f64 / scale;
        let reach = [
            reach(left, right, raster.along_u.index()),
            reach(top, bottom, raster.along_v.index()),
        ];
        if !within || !raster.holds_around(uv, reach) {
            return false;
        }
        let [along_u, along_v] = &self.along[face];
        let number = |i: isize, j: isize| along_u[i as usize].wrapping_add(along_v[j as usize]);
        let corners = [number(left, top), number(right, bottom)];
        self.see(corners[0] as usize);
        if corners[0] == corners[1] {
            return true;
        }
        // Wherever a number changes along a side, another tile begins.
        let begin = |range: RangeInclusive<isize>, along: &[u32]| -> Vec<isize> {
            let first = *range.start();
            let begins = |k: &isize| *k == first || along[*k as usize] != along[*k as usize - 1];
            range.filter(begins).collect()
        };
        let columns = begin(columns, along_u);
        for j in begin(rows, along_v) {
            for i in &columns {
                self.see(number(*i, j) as usize);
            }
        }
        true
    }

    fn see_taps(&self, taps: &Taps) {
        for (index, _) in taps.list() {
            self.see(self.number(*index));
        }
    }
}

/// An image that is looked up, and of which is known what was seen.
pub(crate) struct Watched<'a, T> {
    pub(crate) texture: &'a Texture<'a, T>,
    pub(crate) seen: &'a Seen<'a>,
}

/// Lookups that are watched.
struct WatchedLookups<'l, 'a, T: Texel> {
    seen: &'l Seen<'a>,
    inner: InTexture<'l, 'a, T>,
}

impl<T: Texel> InLevel<T::Float> for WatchedLookups<'_, '_, T> {
    fn place(&mut self, held: &mut Held<T::Float>) {
        for [u, v, face] in held.all() {
            self.seen.bilinear(face as usize, [u, v], &mut []);
        }
        self.inner.place(held);
    }

    fn look(&mut self, held: &Held<T::Float>, values: &mut [T::Float]) {
        self.inner.look(held, values);
    }
}

impl<T: Texel> ByTile<T::Float> for Watched<'_, T> {
    fn lookups(&self) -> Box<dyn InLevel<T::Float> + '_> {
        Box::new(WatchedLookups {
            seen: self.seen,
            inner: InTexture::new(self.texture),
        })
    }
}

impl<T: Texel> Level for Watched<'_, T> {
    fn ellipse(&self, face: usize, uv: [f64; 2], sides: [[f64; 2]; 2], out: &mut [f64]) {
        self.seen.ellipse(face, uv, sides, out);
        self.texture.ellipse(face, uv, sides, out);
    }
}

impl ByPlace for Seen<'_> {
    fn bilinear(&self, face: usize, uv: [f64; 2], out: &mut [f64]) {
        out.fill(0.0);
        let around = self.texture.place(uv).map(|x| {
            let first = x.floor() as isize;
            first..=first + 1
        });
        if !self.see_rectangle(face, uv, around) {
            let mut taps = Taps::new();
            self.texture.resolve(&mut taps, face, uv, 1.0);
            self.see_taps(&taps);
        }
    }
}

impl Level for Seen<'_> {
    fn ellipse(&self, face: usize, uv: [f64; 2], sides: [[f64; 2]; 2], out: &mut [f64]) {
        out.fill(0.0);
        let place = self.texture.place(uv);
        if self.see_rectangle(face, uv, ellipse::texels(place, sides)) {
            return;
        }
        let raster = &self.texture.raster;
        let mut taps = Taps::new();
        ellipse::each(place, sides, |i, j, weight| {
            if raster.holds(i, j) {
                taps.push(raster.view(face).index(i as usize, j as usize), weight);
            } else {
                self.texture.beyond(&mut taps, face, i, j, weight);
            }
        });
        self.see_taps(&taps);
    }
}
