//! The texels of an image as light: where from, how much, and how bright.
//!
//! What cuts an image into lights or looks for its sun asks for texels as a list, in the order in which they are
//! stored, and only for those that hold sphere. Each counts with the solid angle that it stands for
//! ([`crate::image::rim`]): the covered part of a texel across a rim is counted with the nearest one inside. Luminance is
//! a weighted sum of channels, in f64 and in their order.

use crate::error::{Error, expect_length};
use crate::image::ImageView;
use crate::image::raster::Raster;
use crate::image::rim;
use crate::image::texel::Texel;
use crate::image::texels::Directions;
use crate::kernel::memory::expect_room;
use crate::kernel::{Scalar, interrupt, threads};

/// Stored rows that are listed at a time.
const BAND: usize = 16;

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
        let chord = 2.0 * (0.5 * radius).sin();
        Cap {
            axis,
            square: chord * chord,
        }
    }

    fn holds(self, toward: &[f64]) -> bool {
        let squares = [0, 1, 2].map(|c| (toward[c] - self.axis[c]) * (toward[c] - self.axis[c]));
        squares[0] + squares[1] + squares[2] <= self.square
    }
}

/// The texels of an image one by one, each with what it counts with.
pub struct Counted<'a, T> {
    image: ImageView<'a, T>,
    solid_angles: Vec<f64>,
    luminance: &'a [f64],
}

impl<'a, T: Texel> Counted<'a, T> {
    /// Of an image whose channels make luminance with these weights, one for each.
    pub fn new(image: &ImageView<'a, T>, luminance: &'a [f64]) -> Result<Self, Error> {
        let raster = image.raster();
        expect_length("luminance", luminance.len(), image.channels())?;
        expect_room::<f64>(raster.width * raster.height)?;
        let solid_angles = interrupt::part(0.0, 0.5, || rim::face_weights(image.map(), raster));
        Ok(Counted {
            image: *image,
            solid_angles,
            luminance,
        })
    }

    /// The image.
    pub fn image(&self) -> &ImageView<'a, T> {
        &self.image
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
        for run in raster.runs(row) {
            let Some((_, start, step)) = run.face else {
                continue;
            };
            for k in 0..run.length {
                let at = |axis: usize| (start[axis] + k as isize * step[axis]) as usize;
                let solid_angle = self.solid_angles[at(1) * raster.width + at(0)];
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
        let products = texel.iter().zip(self.luminance);
        products
            .filter(|(_, w)| **w != 0.0)
            .map(|(x, w)| x.load().to_f64() * w)
            .sum()
    }

    /// Where a stored texel looks.
    pub fn direction(&self, index: usize) -> [f64; 3] {
        let columns = self.raster().columns;
        let mut row = vec![0.0; 3 * columns];
        Directions::new(self.image.map(), self.raster(), None).rows(index / columns, &mut row);
        [0, 1, 2].map(|c| row[3 * (index % columns) + c])
    }

    /// The list of them, or of those in a cap.
    pub fn listed(&self, cap: Option<Cap>) -> Result<Lit, Error> {
        let (raster, channels) = (self.raster(), self.image.channels());
        // All of this, growing by doubling, and what finding lights and suns among it takes.
        let per_texel = 160 + 32 * channels;
        expect_room::<u8>(raster.texels().saturating_mul(per_texel))?;
        let directions = Directions::new(self.image.map(), raster, None);
        let mut bands = vec![Lit::none(channels); self.stored_rows().div_ceil(BAND)];
        let list = |band: usize, lit: &mut Lit| {
            let first = band * BAND;
            let rows = BAND.min(self.stored_rows() - first);
            let mut toward = vec![0.0; 3 * raster.columns * rows];
            directions.rows(first, &mut toward);
            for (j, toward) in toward.chunks_exact(3 * raster.columns).enumerate() {
                let row = first + j;
                self.row(row, |column, solid_angle, texel| {
                    let toward = &toward[3 * column..][..3];
                    if cap.is_none_or(|cap| cap.holds(toward)) {
                        lit.index.push(row * raster.columns + column);
                        lit.direction.push([toward[0], toward[1], toward[2]]);
                        lit.weight.push(solid_angle);
                        lit.light.extend(texel.iter().map(|x| x.load().to_f64()));
                        lit.luminance.push(self.luminance(texel));
                    }
                });
            }
        };
        threads::rows(&mut bands, 1, raster.texels() * 8, |band, lit| {
            list(band, &mut lit[0]);
        });
        interrupt::check()?;
        let mut all = Lit::none(channels);
        for band in bands {
            all.index.extend(band.index);
            all.direction.extend(band.direction);
            all.weight.extend(band.weight);
            all.light.extend(band.light);
            all.luminance.extend(band.luminance);
        }
        Ok(all)
    }
}

impl Lit {
    /// The texels of an image whose channels make luminance with these weights, one for each.
    pub fn new<T: Texel>(image: &ImageView<'_, T>, luminance: &[f64]) -> Result<Lit, Error> {
        Counted::new(image, luminance)?.listed(None)
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
    use crate::map::Map;

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
