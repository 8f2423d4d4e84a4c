//! Environments seen in rough mirrors: the first factor of the split sum.
//!
//! For every direction n, with v = n, the mean of L(l) weighted by D(h) (n·l), h halfway between n and l (Karis
//! 2013). It is a lobe about n like any other, so that [`crate::light::lobe`] gives the exact sum; this module samples
//! it, for images too large for that.
//!
//! Half vectors follow D(h) (n·h): for v = n that *is* the distribution of visible normals. GGX: cos²θ =
//! (1 - ξ)/(1 + (α² - 1) ξ); Charlie: sin θ = ξ^(α/(2α + 1)). Both leave the weight n·l. The points (ξ, φ) are
//! Hammersley's, the same for every texel. Each looks up the level of a mip chain whose texels are as large as
//! what the sample stands for (filtered importance sampling, Křivánek & Colbert 2008): Ω = [`WIDENED`]/(N pdf),
//! and not less than the target's own texel.
//!
//! A sample has one level for the whole image, so texels are taken in runs, sample by sample: lookups of
//! neighbors meet in the cache, and all but the four loads is packed arithmetic.

use crate::error::{Error, expect_length};
use crate::image::ImageView;
use crate::image::raster::Raster;
use crate::image::texel::Texel;
use crate::image::texels::directions;
use crate::kernel::{interrupt, threads};
use crate::light::lobe;
use crate::light::pyramid::{Pyramid, Rows};
use crate::map::Map;
use crate::number::real::Real;
use crate::resample::lod::lod;
use std::f64::consts::PI;

/// How much larger than 1/(N pdf) a sample's footprint is, so that footprints overlap.
const WIDENED: f64 = 4.0;

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
}

/// An image to be filtered.
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

    /// Fills an image of `map` with the light under the distribution of roughness `alpha`; black outside its valid part.
    ///
    /// # Errors
    /// The shape is none of the map's, or `out` does not hold a number for each texel and channel.
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
        let mut normals = vec![0.0; 3 * raster.texels()];
        directions(map, shape, None, &mut normals)?;
        let normals = normals.as_chunks::<3>().0;
        let samples = spread(distribution, alpha, samples);
        let total: f64 = samples.iter().map(|s| s.local[2]).sum();
        let own = map.coverage().solid_angle() / raster.texels() as f64;
        const RUN: usize = 256;
        let channels = self.channels;
        let work = normals.len() * samples.len();
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
    let cos2: Vec<f64> = match distribution {
        Distribution::Ggx => numbers
            .iter()
            .map(|x| (1.0 - x) / (1.0 + (alpha * alpha - 1.0) * x))
            .collect(),
        Distribution::Charlie => lobe::power(&numbers, 2.0 * alpha / (2.0 * alpha + 1.0))
            .iter()
            .map(|sin2| 1.0 - sin2)
            .collect(),
    };
    let sin2: Vec<f64> = cos2.iter().map(|c| (1.0 - c).max(0.0)).collect();
    // Charlie's density needs a power of its own.
    let powers = match distribution {
        Distribution::Ggx => Vec::new(),
        Distribution::Charlie => lobe::power(&sin2, 0.5 / alpha),
    };
    let sample = |i: usize| {
        let (cos2, sin2) = (cos2[i], sin2[i]);
        let radical = (i as u32).reverse_bits() as f64 / 4_294_967_296.0;
        let (sin_phi, cos_phi) = f64::sin_cos_half_turns(2.0 * radical);
        let aside = 2.0 * (cos2 * sin2).sqrt();
        // D(h) (n·h)/(4 v·h), where v·h = n·h.
        let pdf = match distribution {
            Distribution::Ggx => {
                let d = cos2 * (alpha * alpha - 1.0) + 1.0;
                alpha * alpha / (PI * d * d) / 4.0
            }
            Distribution::Charlie => (2.0 + 1.0 / alpha) / (2.0 * PI) * powers[i] / 4.0,
        };
        Sample {
            local: [aside * cos_phi, aside * sin_phi, 2.0 * cos2 - 1.0],
            footprint: WIDENED / (n * pdf),
        }
    };
    (0..cos2.len())
        .map(sample)
        .filter(|sample| sample.local[2] > 0.0)
        .collect()
}
