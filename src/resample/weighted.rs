//! Texels with weights of their own: alpha, and numbers that are not finite and count for nothing.
//!
//! A weighted mean is the quotient of two plain ones: of the values times their weights, and of the weights. So every
//! filter can have weights, and knows its seams as without. Both are looked up at once, as channels of one image of
//! floats, and rounded once.
//!
//! - By opacity alone, the weight of every color is the opacity, which is a channel already: no more is looked up than
//!   without. What is transparent has no color; black is as good as any, and is not NaN.
//! - Where what is not finite has no weight, each channel has weights of its own. A quotient of two sums in which weights are negative may
//!   be anything: beside a hole, filters that ring give way to the four nearest texels.

use crate::error::Error;
use crate::image::texel::Texel;
use crate::image::view::ImageView;
use crate::kernel::Scalar;
use crate::kernel::memory::expect_room;
use crate::kernel::{interrupt, threads};
use crate::number::real::Real;

/// Texels that a thread takes at a time.
const CHUNK: usize = 1 << 12;

/// How the texels of an image are weighed. That of an image may be had of its parts ([`Weights::with`]), each weighed by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Weights {
    channels: usize,
    /// Numbers of a weighed texel: the products of all channels; then, where there are holes, the weights of all channels, or, where
    /// opacity is not finite, a one, which tells such a mean from what lies outside.
    pub(crate) width: usize,
    alpha: Option<usize>,
    pub(crate) holes: bool,
}

/// An image's values times their weights, and these weights.
#[derive(Debug)]
pub(crate) struct Weighted<T: Texel> {
    texels: Vec<T::Float>,
    weights: Weights,
}

/// What is looked up.
#[derive(Clone, Copy)]
pub(crate) struct Looks {
    /// How many texels of a result.
    pub(crate) count: usize,
    /// Whether the filter has negative weights.
    pub(crate) ringing: bool,
}

impl<T: Texel> Weighted<T> {
    /// That of an image; none where all its texels weigh the same.
    pub(crate) fn new(
        image: &ImageView<'_, T>,
        alpha: Option<usize>,
        skipna: bool,
    ) -> Result<Option<Self>, Error> {
        let Some(weights) = Weights::of(image.texels(), image.channels(), alpha, skipna) else {
            return Ok(None);
        };
        let count = image.raster().texels() * weights.width;
        expect_room::<T::Float>(count)?;
        let mut texels = vec![T::Float::default(); count];
        weights.weigh_all(image.texels(), &mut texels);
        Ok(Some(Weighted { texels, weights }))
    }

    /// It as an image in the map of the one that it was made of.
    pub(crate) fn image<'w>(
        &'w self,
        of: &ImageView<'w, T>,
    ) -> Result<ImageView<'w, T::Float>, Error> {
        ImageView::new(of.map(), of.shape(), self.weights.width, &self.texels)
    }

    /// What a lookup is to give where the image holds nothing.
    pub(crate) fn nothing(&self) -> Vec<T::Float> {
        vec![T::Float::NAN; self.weights.width]
    }

    /// Writes means, as [`Weights::mean`].
    pub(crate) fn mean(
        &self,
        looks: Looks,
        fill: &[T],
        out: &mut [T],
        look: impl FnMut(bool, &mut [T::Float]) -> Result<(), Error>,
    ) -> Result<(), Error> {
        self.weights.mean(looks, fill, out, look)
    }
}

impl Weights {
    /// Those of texels; none where all of them weigh the same.
    pub(crate) fn of<T: Texel>(
        texels: &[T],
        channels: usize,
        alpha: Option<usize>,
        skipna: bool,
    ) -> Option<Self> {
        let is_hole = |x: &T| !x.load().to_f64().is_finite();
        let holes = skipna && T::NOTHING.is_nan() && texels.iter().any(is_hole);
        if !holes && alpha.is_none() {
            return None;
        }
        let opacities = alpha.iter().flat_map(|alpha| {
            let texels = texels.chunks_exact(channels);
            texels.map(|texel| texel[*alpha].load().to_f64())
        });
        let width = if holes {
            2 * channels
        } else if T::NOTHING.is_nan() && opacities.into_iter().any(|x| !x.is_finite()) {
            channels + 1
        } else {
            channels
        };
        Some(Weights {
            channels,
            width,
            alpha,
            holes,
        })
    }

    /// Those of this width, as [`Weights::of`] gave them.
    pub(crate) fn with(channels: usize, alpha: Option<usize>, holes: bool, width: usize) -> Self {
        Weights {
            channels,
            width,
            alpha,
            holes,
        }
    }

    /// Writes the products and weights of texels.
    pub(crate) fn weigh_all<T: Texel>(&self, texels: &[T], out: &mut [T::Float]) {
        let (channels, count) = (self.channels, texels.len() / self.channels);
        threads::rows(out, CHUNK * self.width, count, |chunk, out| {
            let texels = texels[chunk * CHUNK * channels..].chunks_exact(channels);
            for (texel, out) in texels.zip(out.chunks_exact_mut(self.width)) {
                self.weigh(texel, out);
            }
        });
    }

    /// Writes a texel's products and weights.
    fn weigh<T: Texel>(&self, texel: &[T], out: &mut [T::Float]) {
        let (zero, one) = (T::Float::ZERO, T::Float::ONE);
        let value = |c: usize| {
            let value = texel[c].load();
            if self.holes && !value.to_f64().is_finite() {
                (zero, zero)
            } else {
                (value, one)
            }
        };
        let opacity = self.alpha.map_or(one, |alpha| {
            let (value, held) = value(alpha);
            value * held
        });
        let (products, weights) = out.split_at_mut(self.channels);
        for (c, product) in products.iter_mut().enumerate() {
            let (value, held) = value(c);
            let weight = if self.alpha.is_some_and(|alpha| alpha != c) {
                held * opacity
            } else {
                held
            };
            // Infinity that counts for nothing is nothing.
            *product = if weight == zero { zero } else { value * weight };
            if self.holes {
                weights[c] = weight;
            }
        }
        if !self.holes {
            weights.fill(one);
        }
    }

    /// Writes means. `look` looks texels that are weighed up: by the filter, or, where it is told so, by the four
    /// nearest texels.
    pub(crate) fn mean<T: Texel>(
        &self,
        looks: Looks,
        fill: &[T],
        out: &mut [T],
        mut look: impl FnMut(bool, &mut [T::Float]) -> Result<(), Error>,
    ) -> Result<(), Error> {
        expect_room::<T::Float>(2 * looks.count * self.width)?;
        let mut seen = vec![T::Float::default(); looks.count * self.width];
        let twice = self.holes && looks.ringing;
        let first = if twice { 0.75 } else { 1.0 };
        interrupt::part(0.0, first, || look(false, &mut seen))?;
        self.each::<T>(&mut seen, |_, seen| self.divide::<T>(seen));
        if twice && self.any_beside_hole::<T>(&seen) {
            let mut near = vec![T::Float::default(); seen.len()];
            interrupt::part(first, 1.0, || look(true, &mut near))?;
            self.each::<T>(&mut near, |_, near| self.divide::<T>(near));
            self.each::<T>(&mut seen, |k, seen| {
                for c in 0..self.channels {
                    if self.beside_hole::<T>(seen, c) {
                        seen[c] = near[k * self.width + c];
                    }
                }
            });
        }
        let channels = self.channels;
        threads::rows(out, CHUNK * channels, looks.count, |chunk, out| {
            let seen = seen[chunk * CHUNK * self.width..].chunks_exact(self.width);
            for (out, seen) in out.chunks_exact_mut(channels).zip(seen) {
                self.store(seen, fill, out);
            }
        });
        Ok(())
    }

    /// Calls `work` with the number of each texel and what was looked up there.
    fn each<T: Texel>(&self, seen: &mut [T::Float], work: impl Fn(usize, &mut [T::Float]) + Sync) {
        let count = seen.len() / self.width;
        threads::rows(seen, CHUNK * self.width, count, |chunk, seen| {
            for (k, seen) in seen.chunks_exact_mut(self.width).enumerate() {
                work(chunk * CHUNK + k, seen);
            }
        });
    }

    /// The mean weight of a channel; NaN where the image holds nothing.
    fn share<T: Texel>(&self, seen: &[T::Float], c: usize) -> T::Float {
        match self.alpha {
            _ if self.holes => seen[self.channels + c],
            Some(alpha) if alpha != c => seen[alpha],
            _ if self.width > self.channels => seen[self.channels],
            _ if seen[c].is_nan() => T::Float::NAN,
            _ => T::Float::ONE,
        }
    }

    /// Makes means of sums; the weights stay.
    fn divide<T: Texel>(&self, seen: &mut [T::Float]) {
        for c in 0..self.channels {
            let share = self.share::<T>(seen, c);
            // Opacity itself, which others are divided by, has the weight 1 and stays.
            seen[c] = if share == T::Float::ZERO {
                T::Float::NAN
            } else {
                seen[c] / share
            };
        }
    }

    fn beside_hole<T: Texel>(&self, seen: &[T::Float], c: usize) -> bool {
        self.share::<T>(seen, self.alpha.unwrap_or(c)) != T::Float::ONE
    }

    fn any_beside_hole<T: Texel>(&self, seen: &[T::Float]) -> bool {
        let mut texels = seen.chunks_exact(self.width);
        texels.any(|seen| (0..self.channels).any(|c| self.beside_hole::<T>(seen, c)))
    }

    /// Rounds a texel of means.
    fn store<T: Texel>(&self, seen: &[T::Float], fill: &[T], out: &mut [T]) {
        let zero = T::Float::ZERO;
        let missing = match self.alpha {
            Some(alpha) => self.holes && self.share::<T>(seen, alpha) <= zero,
            None => false,
        };
        for (c, out) in out.iter_mut().enumerate() {
            let share = self.share::<T>(seen, c);
            let is_color = self.alpha.is_some_and(|alpha| alpha != c);
            *out = if share.is_nan() {
                fill[c]
            } else if missing {
                T::store(T::Float::NAN)
            } else if is_color && share <= zero {
                T::store(zero)
            } else {
                T::store(seen[c])
            };
        }
    }
}
