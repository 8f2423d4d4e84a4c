//! Environments seen in rough mirrors: the first factor of the split sum.
//!
//! For every direction n, with v = n, the mean of L(l) weighted by D(h) (n·l), h halfway between n and l (Karis
//! 2013). It is a lobe about n like any other, so that [`crate::light::lobe`] gives the exact sum; this module is for images too large
//! for that.
//!
//! A wide lobe is summed over a level of a mip chain whose texels are small beside it, if there are not too many ([`SUMMED`]): that takes
//! as long as samples would, and is fifty times as near, for a sample of a wide lobe looks up large texels, and a sun in one of
//! these might be anywhere in it. Narrow lobes are sampled, and so are those narrower than the target's texels.
//!
//! Half vectors follow D(h) (n·h): for v = n that *is* the distribution of visible normals. GGX: cos²θ =
//! (1 - ξ)/(1 + (α² - 1) ξ); Charlie: sin θ = ξ^(α/(2α + 1)). Both leave the weight n·l. Beyond 45° from n light would come from below
//! the horizon, where most of a narrow Charlie points: ξ ends there. The points (ξ, φ) are
//! Hammersley's, the same for every texel. Each looks up the level of a mip chain whose texels are as large as
//! what the sample stands for (filtered importance sampling, Křivánek & Colbert 2008): Ω = [`WIDENED`]/(N pdf),
//! and, of a lobe narrower than that, not less than the target's own texel.
//!
//! A sample has one level for the whole image, so texels are taken in runs, sample by sample: lookups of
//! neighbors meet in the cache, and all but the four loads is packed arithmetic.

use crate::error::{Error, expect_length};
use crate::image::ImageView;
use crate::image::raster::Raster;
use crate::image::texel::Texel;
use crate::image::texels::directions;
use crate::kernel::memory::expect_room;
use crate::kernel::{interrupt, threads};
use crate::light::lobe::{self, Lobe};
use crate::light::pyramid::{Pyramid, PyramidLevel, Rows};
use crate::map::Map;
use crate::number::real::Real;
use crate::resample::lod::lod;
use std::f64::consts::PI;

/// How much larger than 1/(N pdf) a sample's footprint is, so that footprints overlap.
const WIDENED: f64 = 4.0;

/// Texels that are summed up at most, for each sample: they take as long together.
const SUMMED: usize = 24;

/// Texels along a face, times α, from which on a level is as good as the image: a sum over it is within 1e-3 of that over the image, for a lone
/// sun of one texel.
const FINE: f64 = 32.0;

/// The least with which it is nearer than samples are: the error falls with the square, and is 1 % at 10.
const LEAST: f64 = 4.0;

/// Which distribution of normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Distribution {
    /// Trowbridge and Reitz 1975; Walter et al. 2007.
    Ggx,
    /// Estevez and Kulla 2017, for cloth.
    Charlie,
}

impl Distribution {
    /// The distribution of this name.
    ///
    /// # Errors
    /// No distribution has it.
    ///
    /// ```
    /// use spheremap::light::prefilter::Distribution;
    /// assert_eq!(Distribution::find("ggx")?, Distribution::Ggx);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn find(name: &str) -> Result<Distribution, Error> {
        match name {
            "ggx" => Ok(Distribution::Ggx),
            "charlie" => Ok(Distribution::Charlie),
            _ => Err(Error::unknown("distribution", name, &["ggx", "charlie"])),
        }
    }

    fn lobe(self, alpha: f64) -> Lobe {
        match self {
            Distribution::Ggx => Lobe::Ggx(alpha),
            Distribution::Charlie => Lobe::Charlie(alpha),
        }
    }
}

/// An image to be filtered.
#[derive(Debug)]
pub struct Source {
    channels: usize,
    pyramids: Vec<Pyramid>,
}

/// A direction to look up, in the frame of the normal.
struct Sample {
    local: [f64; 3],
    /// Steradians.
    footprint: f64,
}

impl Source {
    /// An image of a map, made ready to be filtered.
    ///
    /// # Errors
    /// There is no memory for it.
    ///
    /// ```
    /// use spheremap::light::prefilter::{Distribution, Source};
    /// use spheremap::{Map, image::ImageView};
    /// let map = Map::new("octahedral")?;
    /// let gray = vec![0.5_f32; 32 * 32];
    /// let source = Source::new(&ImageView::new(&map, &[32, 32], 1, &gray)?)?;
    /// let mut rough = vec![0.0; 8 * 8];
    /// source.filter(&map, &[8, 8], Distribution::Ggx, 0.25, 64, &mut rough)?;
    /// assert!(rough.iter().all(|x| (x - 0.5).abs() < 1e-5));
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn new<T: Texel>(image: &ImageView<'_, T>) -> Result<Source, Error> {
        let channels = image.channels();
        let pyramids = (0..channels)
            .step_by(4)
            .map(|first| {
                let [start, end] =
                    [first, (first + 4).min(channels)].map(|k| k as f64 / channels as f64);
                interrupt::part(start, end, || Pyramid::new(image, first))
            })
            .collect::<Result<_, _>>()?;
        Ok(Source { channels, pyramids })
    }

    /// Fills an image of `map` with the light under the distribution of roughness `alpha`; black outside its valid part. `samples` are what
    /// a texel may take: so many lookups, or the sum over as many texels of a small image as take as long.
    ///
    /// # Errors
    /// The shape is none of the map's, `out` does not hold a number for each texel and channel, `alpha` is negative or NaN, or
    /// there is no memory for it.
    ///
    /// ```
    /// use spheremap::light::prefilter::{Distribution, Source};
    /// use spheremap::{Map, image::ImageView};
    /// let map = Map::new("octahedral")?;
    /// let white = vec![1.0_f32; 16 * 16];
    /// let source = Source::new(&ImageView::new(&map, &[16, 16], 1, &white)?)?;
    /// let short = &mut [0.0; 10];
    /// assert!(source.filter(&map, &[8, 8], Distribution::Ggx, 0.25, 64, short).is_err());
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn filter(
        &self,
        map: &Map,
        shape: &[usize],
        distribution: Distribution,
        alpha: f64,
        samples: usize,
        out: &mut [f32],
    ) -> Result<(), Error> {
        let raster = Raster::new(map, shape)?;
        expect_length("out", out.len(), raster.texels() * self.channels)?;
        distribution.lobe(alpha).expect()?;
        expect_room::<f64>(3 * raster.texels())?;
        let mut normals = vec![0.0; 3 * raster.texels()];
        directions(map, shape, None, &mut normals)?;
        let own = map.coverage().solid_angle() / raster.texels() as f64;
        // Between texels that are wider than the lobe, light would be missed.
        let is_wide = PI * alpha * alpha > 4.0 * own;
        if is_wide && let Some(level) = self.summed(alpha, samples) {
            return self.sum(level, distribution.lobe(alpha), &normals, out);
        }
        let normals = normals.as_chunks::<3>().0;
        // A sample, and the numbers that it is made of; without a width one is enough.
        expect_room::<[u8; 64]>(if alpha > 0.0 { samples } else { 1 })?;
        let samples = spread(distribution, alpha, samples);
        let total: f64 = samples.iter().map(|s| s.local[2]).sum();
        let own = if is_wide { 0.0 } else { own };
        const RUN: usize = 256;
        let channels = self.channels;
        let work = normals.len().saturating_mul(samples.len());
        let run = |number: usize, out: &mut [f32]| {
            let normals = &normals[number * RUN..][..out.len() / channels];
            let mut rows = Rows::new(normals);
            for (group, pyramid) in self.pyramids.iter().enumerate() {
                let mut sums = vec![[0.0; 4]; normals.len()];
                for sample in &samples {
                    let footprint = sample.footprint.max(own);
                    let finest = pyramid.levels[0].texel_area();
                    let level = (0.5 * lod(footprint / finest)).round() as usize;
                    let level = &pyramid.levels[level.min(pyramid.levels.len() - 1)];
                    rows.local = sample.local.map(|x| x as f32);
                    level.add(&mut rows, (sample.local[2] / total) as f32, &mut sums);
                }
                let (first, count) = (4 * group, (channels - 4 * group).min(4));
                for ((out, sum), n) in out.chunks_exact_mut(channels).zip(&sums).zip(normals) {
                    for c in 0..count {
                        out[first + c] = if n[0].is_nan() { 0.0 } else { sum[c] };
                    }
                }
            }
        };
        interrupt::part(0.0, 1.0, || {
            threads::rows(out, RUN * channels, work, run);
        });
        Ok(())
    }

    /// The level over which a lobe is summed; none where it is sampled.
    fn summed(&self, alpha: f64, samples: usize) -> Option<usize> {
        let levels = &self.pyramids.first()?.levels;
        let few = |level: &PyramidLevel| 6 * level.n * level.n <= SUMMED.saturating_mul(samples);
        let first = levels.iter().position(few)?;
        let wide = |number: &usize| levels[*number].n as f64 * alpha;
        (first..levels.len())
            .rev()
            .find(|number| wide(number) >= FINE)
            .or(Some(first))
            .filter(|number| wide(number) >= LEAST)
    }

    /// The sums over a level under a lobe about each direction; black about none.
    fn sum(&self, level: usize, lobe: Lobe, normals: &[f64], out: &mut [f32]) -> Result<(), Error> {
        let (channels, groups) = (self.channels, self.pyramids.len() as f64);
        let cube = Map::new("cube")?;
        for (group, pyramid) in self.pyramids.iter().enumerate() {
            let (first, level) = (4 * group, &pyramid.levels[level]);
            let count = (channels - first).min(4);
            let (shape, texels) = ([6, level.n, level.n], level.texels(count));
            let view = ImageView::new(&cube, &shape, count, &texels)?;
            let mut sums = vec![0.0; normals.len() / 3 * count];
            let [start, end] = [group, group + 1].map(|k| k as f64 / groups);
            interrupt::part(start, end, || lobe::under(&view, lobe, normals, &mut sums))?;
            let texels = out.chunks_exact_mut(channels).zip(sums.chunks_exact(count));
            for ((out, sums), n) in texels.zip(normals.as_chunks::<3>().0) {
                for (out, sum) in out[first..].iter_mut().zip(sums) {
                    *out = if n[0].is_nan() { 0.0 } else { *sum as f32 };
                }
            }
        }
        Ok(())
    }
}

/// The samples above the horizon.
fn spread(distribution: Distribution, alpha: f64, count: usize) -> Vec<Sample> {
    if alpha <= 0.0 {
        return vec![Sample {
            local: [0.0, 0.0, 1.0],
            footprint: 0.0,
        }];
    }
    let n = count.max(1) as f64;
    let numbers: Vec<f64> = (0..count.max(1)).map(|i| (i as f64 + 0.5) / n).collect();
    // Twice sin²θ, from 0 to 1, and Charlie's power of it.
    let (twice, powers) = match distribution {
        Distribution::Ggx => {
            let sin2 = |x: &f64| {
                let x = x / (1.0 + alpha * alpha);
                alpha * alpha * x / (1.0 + (alpha * alpha - 1.0) * x)
            };
            (numbers.iter().map(|x| 2.0 * sin2(x)).collect(), Vec::new())
        }
        Distribution::Charlie => {
            let twice = lobe::power(&numbers, 2.0 * alpha / (2.0 * alpha + 1.0));
            let powers = lobe::power(&twice, 0.5 / alpha);
            (twice, powers)
        }
    };
    let sample = |i: usize| {
        let sin2 = 0.5 * twice[i];
        let cos2 = 1.0 - sin2;
        let radical = (i as u32).reverse_bits() as f64 / 4_294_967_296.0;
        let (sin_phi, cos_phi) = f64::sin_cos_half_turns(2.0 * radical);
        let aside = 2.0 * (cos2 * sin2).sqrt();
        // D(h) (n·h)/(4 v·h), where v·h = n·h, over the share of all h that is within 45°.
        let pdf = match distribution {
            Distribution::Ggx => {
                let d = cos2 * (alpha * alpha - 1.0) + 1.0;
                alpha * alpha * (1.0 + alpha * alpha) / (PI * d * d) / 4.0
            }
            Distribution::Charlie => (2.0 + 1.0 / alpha) / PI * powers[i] / 4.0,
        };
        Sample {
            local: [aside * cos_phi, aside * sin_phi, 1.0 - twice[i]],
            footprint: WIDENED / (n * pdf),
        }
    };
    (0..twice.len())
        .map(sample)
        .filter(|sample| sample.local[2] > 0.0)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_filtered_is_an_error() {
        let map = Map::new("cube").unwrap();
        let image = ImageView::new(&map, &[6, 4, 4], 1, &[0.5_f32; 96]).unwrap();
        let source = Source::new(&image).unwrap();
        let filter = |alpha, samples| {
            let out = &mut [0.0; 96];
            source.filter(&map, &[6, 4, 4], Distribution::Ggx, alpha, samples, out)
        };
        assert_eq!(filter(0.01, 8), Ok(()));
        assert_eq!(filter(0.0, usize::MAX), Ok(()));
        for samples in [usize::MAX, 1 << 52] {
            let error = filter(0.01, samples).unwrap_err();
            assert!(matches!(error, Error::Memory { .. }), "{error}");
        }
        for alpha in [-0.5, f64::NAN] {
            assert!(
                filter(alpha, 8)
                    .unwrap_err()
                    .to_string()
                    .contains("`alpha`")
            );
        }
    }
}
