//! The texels of an image as light: where from, how much, and how bright.
//!
//! What cuts an image into lights or looks for its sun asks for texels as a list, in the order in which they are
//! stored, and only for those that hold sphere. Each counts with the solid angle that it stands for
//! ([`crate::image::rim`]): the covered part of a texel across a rim is counted with the nearest one inside. Luminance is
//! a weighted sum of channels, in f64 and in their order.

use crate::error::{Error, expect_length};
use crate::image::ImageView;
use crate::image::rim;
use crate::image::texel::Texel;
use crate::image::texels::directions;
use crate::kernel::Scalar;
use crate::kernel::memory::expect_room;

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

impl Lit {
    /// The texels of an image whose channels make luminance with these weights, one for each.
    pub fn new<T: Texel>(image: &ImageView<'_, T>, weights: &[f64]) -> Result<Lit, Error> {
        let (map, shape) = (image.map(), image.shape());
        let (stored, channels) = (image.raster().texels(), image.channels());
        expect_length("luminance", weights.len(), channels)?;
        // All of this, growing by doubling, and what finding lights and suns among it takes.
        let per_texel = 160 + 32 * channels;
        expect_room::<u8>(stored.saturating_mul(per_texel))?;
        let (mut solid_angle, mut toward) = (vec![0.0; stored], vec![0.0; 3 * stored]);
        rim::weights(map, shape, &mut solid_angle)?;
        directions(map, shape, None, &mut toward)?;
        let index: Vec<usize> = (0..stored).filter(|k| solid_angle[*k] > 0.0).collect();
        let light: Vec<f64> = index
            .iter()
            .flat_map(|k| image.texel(*k))
            .map(|texel| texel.load().to_f64())
            .collect();
        let luminance = |texel: &[f64]| {
            let products = texel.iter().zip(weights);
            products
                .filter(|(_, w)| **w != 0.0)
                .map(|(x, w)| x * w)
                .sum()
        };
        Ok(Lit {
            channels,
            direction: index
                .iter()
                .map(|k| [0, 1, 2].map(|c| toward[3 * k + c]))
                .collect(),
            weight: index.iter().map(|k| solid_angle[*k]).collect(),
            luminance: light.chunks(channels).map(luminance).collect(),
            light,
            index,
        })
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
