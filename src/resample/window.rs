//! A part of a target: what is asked for where the whole image is too much at once.
//!
//! A conversion walks its target in blocks, whose borders depend on the whole image alone, and a block is the smallest part that has
//! the bits of the whole: one polynomial may stand for its coordinates. So a window is widened to whole blocks, these are
//! computed, and what was not asked for is left out. Large windows lose little by it.

use crate::error::Error;
use crate::image::raster::Raster;
use crate::image::texel::Texel;
use crate::kernel::memory::expect_room;
use std::ops::Range;

/// Rows and columns of a stored image. Where faces are apart, their rows follow each other.
///
/// ```
/// use spheremap::resample::Window;
/// let window = Window { rows: 0..16, columns: 8..24 };
/// assert_eq!(window.texels(), 256);
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Window {
    /// Its rows.
    pub rows: Range<usize>,
    /// Its columns.
    pub columns: Range<usize>,
}

impl Window {
    /// All of an image.
    pub(crate) fn whole(raster: &Raster) -> Window {
        Window {
            rows: 0..raster.rows,
            columns: 0..raster.columns,
        }
    }

    /// How many texels it has.
    ///
    /// ```
    /// use spheremap::resample::Window;
    /// assert_eq!(Window { rows: 3..3, columns: 0..8 }.texels(), 0);
    /// ```
    pub fn texels(&self) -> usize {
        self.rows.len().saturating_mul(self.columns.len())
    }

    /// An error unless an image holds all of it.
    pub(crate) fn check(&self, raster: &Raster) -> Result<(), Error> {
        let held = |range: &Range<usize>, all: usize| range.start <= range.end && range.end <= all;
        if held(&self.rows, raster.rows) && held(&self.columns, raster.columns) {
            return Ok(());
        }
        Err(Error::Shape(format!(
            "Expected a window within {} rows and {} columns, got rows {} to {} and columns {} to {}.",
            raster.rows,
            raster.columns,
            self.rows.start,
            self.rows.end,
            self.columns.start,
            self.columns.end
        )))
    }

    /// Takes a stored texel of the image in, and all between.
    pub(crate) fn include(&mut self, texel: usize, raster: &Raster) {
        let (row, column) = (texel / raster.columns, texel % raster.columns);
        for (range, at) in [(&mut self.rows, row), (&mut self.columns, column)] {
            *range = range.start.min(at)..range.end.max(at + 1);
        }
    }

    /// The whole blocks of so many rows of the image, and so many columns of a face, that it touches.
    pub(crate) fn blocks(&self, raster: &Raster, (columns, rows): (usize, usize)) -> Window {
        let wide = raster.width;
        let from = |column: usize| column / wide * wide + column % wide / columns * columns;
        let to = |column: usize| {
            let last = column - 1;
            let end = last / wide * wide + (last % wide / columns + 1) * columns;
            end.min((last / wide + 1) * wide)
        };
        Window {
            rows: self.rows.start / rows * rows
                ..self.rows.end.next_multiple_of(rows).min(raster.rows),
            columns: from(self.columns.start)..to(self.columns.end),
        }
    }

    /// Where a stored texel of the image lies in it, if it does.
    pub(crate) fn index(&self, texel: usize, raster: &Raster) -> Option<usize> {
        let (row, column) = (texel / raster.columns, texel % raster.columns);
        let held = self.rows.contains(&row) && self.columns.contains(&column);
        held.then(|| (row - self.rows.start) * self.columns.len() + column - self.columns.start)
    }

    /// Fills it by `work`, which fills windows of whole blocks. `needed` is the window that it takes from these.
    pub(crate) fn fill<T: Texel>(
        &self,
        raster: &Raster,
        needed: &Window,
        block: (usize, usize),
        out: &mut [T],
        work: impl FnOnce(&Window, &mut [T]),
    ) -> Result<(), Error> {
        if self.texels() == 0 {
            return Ok(());
        }
        let blocks = needed.blocks(raster, block);
        if blocks == *self {
            work(self, out);
            return Ok(());
        }
        let channels = out.len() / self.texels();
        let count = blocks.texels() * channels;
        expect_room::<T>(count)?;
        let mut wider = vec![T::default(); count];
        work(&blocks, &mut wider);
        let width = self.columns.len() * channels;
        let skipped = (self.columns.start - blocks.columns.start) * channels;
        let rows = wider.chunks_exact(blocks.columns.len() * channels);
        let rows = rows.skip(self.rows.start - blocks.rows.start);
        for (out, row) in out.chunks_exact_mut(width).zip(rows) {
            out.copy_from_slice(&row[skipped..][..width]);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::image::view::ImageView;
    use crate::map::Map;
    use crate::resample::window::Window;
    use crate::resample::{Filter, Options, converted};
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        /// A window has the bits of the whole image: atlases, faces apart, rims, every kind of filter.
        #[test]
        fn a_window_is_a_part_of_the_whole(
            (map, shape) in prop::sample::select(vec![
                ("cube", vec![6, 100, 100]),
                ("cube:filament", vec![300, 400]),
                ("angular", vec![230, 230]),
                ("latlong", vec![150, 300]),
                ("dual_fisheye", vec![2, 120, 120]),
            ]),
            filter in prop::sample::select(vec![Filter::Bilinear, Filter::Lanczos3, Filter::Ewa, Filter::Area]),
            ends in prop::array::uniform4(0.0..1.0),
            skipna in any::<bool>(),
        ) {
            let latlong = Map::new("latlong").unwrap();
            let texels: Vec<f32> = (0..96 * 192 * 2).map(|k| (k as f32 * 0.37).sin()).collect();
            let image = ImageView::new(&latlong, &[96, 192], 2, &texels).unwrap();
            let target = Map::new(map).unwrap();
            let options = Options::new().filter(filter).skipna(skipna);
            let whole = converted(&image, &target, &shape, &options).unwrap();
            let columns = *shape.last().unwrap();
            let rows: usize = shape.iter().product::<usize>() / columns;
            let range = |a: f64, b: f64, all: usize| {
                let [a, b] = [a.min(b), a.max(b)].map(|x| (x * all as f64) as usize);
                a..(b + 1)
            };
            let window = Window {
                rows: range(ends[0], ends[1], rows),
                columns: range(ends[2], ends[3], columns),
            };
            let part = converted(&image, &target, &shape, &options.window(window.clone())).unwrap();
            let wanted: Vec<f32> = window
                .rows
                .flat_map(|row| whole[(row * columns + window.columns.start) * 2..][..window.columns.len() * 2].to_vec())
                .collect();
            prop_assert_eq!(part.len(), wanted.len());
            prop_assert!(part.iter().zip(&wanted).all(|(a, b)| a.to_bits() == b.to_bits()));
        }
    }

    #[test]
    fn what_the_image_does_not_hold_is_an_error() {
        let latlong = Map::new("latlong").unwrap();
        let image = ImageView::new(&latlong, &[1, 2], 1, &[0.5_f32; 2]).unwrap();
        let part = |rows, columns| {
            let options = Options::new().window(Window { rows, columns });
            converted(&image, &latlong, &[8, 16], &options)
        };
        assert_eq!(part(0..8, 0..16).unwrap().len(), 128);
        assert!(part(4..4, 0..16).unwrap().is_empty());
        assert!(part(0..9, 0..16).is_err());
        assert!(part(0..8, 0..17).is_err());
        #[expect(clippy::reversed_empty_ranges)]
        let backward = part(5..4, 0..16);
        assert!(backward.is_err());
    }
}
