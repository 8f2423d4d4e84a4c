//! Pictures that map no sphere, looked up by (u, v) as the samplers of graphics APIs do.
//!
//! The centers of n texels lie at (i + ½)/n; what lies beyond the edges is said for u and v apart ([`Address`]). The rules are
//! those of the Direct3D 11.3 functional specification (7.18) and of OpenGL 4.6 (8.14), computed in f64 and rounded once, where
//! hardware has 8 bits of a texel or of a level. A filter that graphics APIs have not works here as everywhere.

mod address;
mod chain;
mod picture;

pub use address::Address;

use crate::error::Error;
use crate::image::texel::Texel;
use crate::kernel::Scalar;
use crate::kernel::threads;
use crate::number::real::Real;
use crate::resample::filters::{ByMethod, Filter};
use crate::resample::footprint::Footprint;
use crate::resample::levels::Levels;
use crate::resample::mip_sampler::{Detail, WORK};
use crate::resample::options::Options;
use crate::resample::sample::ByPlace;
use picture::Picture;

/// Lookups that a thread takes at a time.
const CHUNK: usize = 256;

/// A picture that can be looked up by (u, v), with its mip chain where the filter needs one.
///
/// ```
/// use spheremap::resample::flat::{Address, Sampler};
/// use spheremap::resample::{Detail, Filter, Options};
///
/// let texels = [0.0_f32, 1.0, 2.0, 3.0];
/// let options = Options::new().filter(Filter::Trilinear);
/// let sampler = Sampler::new(&texels, [2, 2], 1, [Address::Clamp; 2], &options)?;
/// let mut mean = [0.0];
/// sampler.sample(&[0.25, 0.25], Some(Detail::Lod(&[1.0])), &mut mean)?;
/// assert_eq!(mean, [1.5]);
/// # Ok::<(), spheremap::Error>(())
/// ```
#[derive(Debug)]
pub struct Sampler<'a, T: Texel> {
    texels: &'a [T],
    size: [usize; 2],
    channels: usize,
    address: [Address; 2],
    filter: Filter,
    fill: Vec<T>,
    border: Vec<f64>,
    chain: Vec<chain::Level<T::Float>>,
}

impl<'a, T: Texel> Sampler<'a, T> {
    /// Of texels in rows, `channels` numbers each; `size` is how wide and high the picture is, `address` what lies beyond its left
    /// and right edges and beyond the upper and lower ones. Of the options it takes the filter and the fill, which is the color of
    /// a border as well.
    ///
    /// # Errors
    /// For a size that does not fit or is 0, a filter that looks nothing up, and a `fill` of another number of channels; where there
    /// is no memory for levels.
    ///
    /// ```
    /// use spheremap::resample::Options;
    /// use spheremap::resample::flat::{Address, Sampler};
    /// let address = [Address::Wrap, Address::Clamp];
    /// assert!(Sampler::new(&[1_u8, 2], [2, 1], 1, address, &Options::new()).is_ok());
    /// assert!(Sampler::new(&[1_u8, 2], [2, 2], 1, address, &Options::new()).is_err());
    /// ```
    pub fn new(
        texels: &'a [T],
        size: [usize; 2],
        channels: usize,
        address: [Address; 2],
        options: &Options,
    ) -> Result<Self, Error> {
        let count = size[0].checked_mul(size[1]);
        let count = count.and_then(|count| count.checked_mul(channels));
        if count != Some(texels.len()) || texels.is_empty() {
            return Err(Error::Shape(format!(
                "Expected a picture of at least one texel, got {} × {} of {channels} numbers, {} in all.",
                size[1],
                size[0],
                texels.len()
            )));
        }
        let chain = match options.filter.by_method() {
            ByMethod::Mipmapped(_) => chain::chain(size, channels, texels)?,
            _ => options.filter.lookup().map(|_| Vec::new())?,
        };
        let fill: Vec<T> = options.fill.texel(channels)?;
        let border = fill.iter().map(|x| x.load().to_f64()).collect();
        Ok(Sampler {
            texels,
            size,
            channels,
            address,
            filter: options.filter,
            fill,
            border,
            chain,
        })
    }

    /// Looks (u, v) up: two numbers each in, a texel each out. What is not finite shows the fill. Filters of a mip chain need to
    /// know the detail, and others have none.
    ///
    /// # Errors
    /// For lengths that do not fit, and a detail that does not belong to the filter.
    ///
    /// ```
    /// use spheremap::resample::Options;
    /// use spheremap::resample::flat::{Address, Sampler};
    /// let row = Sampler::new(&[1.0, 2.0], [2, 1], 1, [Address::Wrap; 2], &Options::new())?;
    /// let mut seen = [0.0; 2];
    /// row.sample(&[0.25, 0.5, 1.0, 0.5], None, &mut seen)?;
    /// assert_eq!(seen, [1.0, 1.5]);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn sample(
        &self,
        uv: &[f64],
        detail: Option<Detail<'_>>,
        out: &mut [T],
    ) -> Result<(), Error> {
        let count = out.len() / self.channels;
        if uv.len() != 2 * count || out.len() != count * self.channels {
            return Err(Error::Shape(format!(
                "Expected two numbers a place, and `out` to have a texel of {} for each; got {} and {}.",
                self.channels,
                uv.len(),
                out.len()
            )));
        }
        match detail {
            None => drop(self.filter.of_points()?),
            Some(detail) => {
                detail.expect(count, 2)?;
                detail.expect_filter(self.filter.of_footprints()?)?;
            }
        }
        let image = self.picture(self.size, self.texels);
        let smaller = self.chain.iter();
        let smaller: Vec<_> = smaller.map(|(size, x)| self.picture(*size, x)).collect();
        let mut all = vec![(&image as &dyn ByPlace, self.size)];
        all.extend(
            smaller
                .iter()
                .map(|level| (level as &dyn ByPlace, level.size)),
        );
        let levels = Levels::sized(all);
        let look =
            |k: usize, uv: [f64; 2], values: &mut [f64]| match (self.filter.by_method(), detail) {
                (ByMethod::Lookup(filter), _) => {
                    image.look(filter, uv, &mut values[..self.channels])
                }
                (ByMethod::Mipmapped(filter), Some(detail)) => {
                    let footprint = |pair| self.footprint(uv, pair, k);
                    let place = [uv[0], uv[1], 0.0];
                    levels.look(&detail.aim(&levels, filter, k, place, footprint), values);
                }
                _ => (),
            };
        let channels = self.channels;
        threads::rows(out, CHUNK * channels, count * WORK, |chunk, out| {
            let mut values = vec![0.0; 2 * channels];
            for (k, out) in (chunk * CHUNK..).zip(out.chunks_exact_mut(channels)) {
                let uv = [uv[2 * k], uv[2 * k + 1]];
                if uv.iter().any(|x| !x.is_finite()) || detail.is_some_and(|d| d.is_nan(k, 2)) {
                    out.copy_from_slice(&self.fill);
                    continue;
                }
                look(k, uv, &mut values);
                for (out, value) in out.iter_mut().zip(&values) {
                    *out = T::store(T::Float::new(*value));
                }
            }
        });
        Ok(())
    }

    fn picture<'p, U>(&'p self, size: [usize; 2], texels: &'p [U]) -> Picture<'p, U> {
        Picture {
            size,
            channels: self.channels,
            texels,
            address: self.address,
            border: &self.border,
        }
    }

    /// What lookup k sees: derivatives of (u, v), times the size.
    fn footprint(&self, [u, v]: [f64; 2], pair: [&[f64]; 2], k: usize) -> Footprint {
        let [width, height] = self.size.map(|n| n as f64);
        let sides = pair.map(|d| [d[2 * k] * width, d[2 * k + 1] * height]);
        let source = [u, v, 0.0];
        Footprint::of_sides(source, sides)
    }
}

#[cfg(test)]
mod tests {
    use super::{Address, Sampler};
    use crate::resample::filters::Filter;
    use crate::resample::mip_sampler::Detail;
    use crate::resample::options::Options;

    #[test]
    fn what_does_not_fit_is_an_error() {
        let options = |filter| Options::new().filter(filter);
        let texels = [7_u8; 2 * 3 * 2];
        let make =
            |size, filter| Sampler::new(&texels, size, 2, [Address::Wrap; 2], &options(filter));
        assert!(make([3, 2], Filter::Area).is_err());
        assert!(make([3, 3], Filter::Bilinear).is_err());
        assert!(make([usize::MAX, 3], Filter::Bilinear).is_err());
        let fills = options(Filter::Nearest).fill(vec![0.0; 3]);
        assert!(Sampler::new(&texels, [3, 2], 2, [Address::Wrap; 2], &fills).is_err());
        assert!(
            Sampler::<u8>::new(&[], [0, 2], 2, [Address::Wrap; 2], &options(Filter::Ewa)).is_err()
        );
        let (uv, lod, mut out) = ([0.3; 4], [0.5; 2], [0; 4]);
        for filter in Filter::ALL {
            let Ok(sampler) = make([3, 2], *filter) else {
                continue;
            };
            let mipmapped = matches!(filter, Filter::Trilinear | Filter::Ewa);
            let pair = Detail::Derivatives([&uv, &uv]);
            assert_eq!(sampler.sample(&uv, None, &mut out).is_ok(), !mipmapped);
            assert_eq!(sampler.sample(&uv, Some(pair), &mut out).is_ok(), mipmapped);
            let level = sampler.sample(&uv, Some(Detail::Lod(&lod)), &mut out);
            assert_eq!(level.is_ok(), *filter == Filter::Trilinear);
            assert_eq!(out, [7; 4]);
            assert!(sampler.sample(&uv[..3], None, &mut out).is_err());
            assert!(
                sampler
                    .sample(&uv, Some(Detail::Lod(&lod[..1])), &mut out)
                    .is_err()
            );
        }
    }
}
