//! Lookups among texels of one number: gray images, planes of video, masks.
//!
//! Of such a texel there is nothing to put into lanes, so lanes are lookups here: the pairs of texels above and below each place
//! are brought together first, and all of them are weighted at once. One by one, the conversions from bytes and
//! back took longer than those of three numbers a texel.
//!
//! Nothing is read beyond the pairs, so that there is no last texel to be careful with: where all places are inside of a face, all
//! pairs are in the image.

use super::corners::mix;
use super::place::Places;
use super::rectangle::{LENGTH, Rectangle, each_part};
use crate::image::texel::{Filtered, Four, Texel};
use crate::kernel::tile::prefetch_item;
use crate::number::real::Real;
use fearless_simd::{Simd, SimdBase};

/// The texels of a face, STRAIGHT if its rows are stored as rows.
#[derive(Clone, Copy)]
pub(super) struct Ones<'a, T, const STRAIGHT: bool> {
    pub(super) texels: &'a [T],
    /// How many texels lie from one to its neighbors right and below.
    pub(super) steps: [isize; 2],
    /// Where the last pair begins.
    last: usize,
}

impl<'a, T: Texel, const STRAIGHT: bool> Ones<'a, T, STRAIGHT> {
    /// None for an image without a pair.
    #[inline(always)]
    pub(super) fn new(texels: &'a [T], steps: [isize; 2]) -> Option<Self> {
        let last = texels.len().checked_sub(2)?;
        Some(Ones {
            texels,
            steps,
            last,
        })
    }

    /// The pairs above and below a place, or nothing where there are none.
    #[inline(always)]
    pub(super) fn pairs(self, first: usize) -> [[T; 2]; 2] {
        let [right, down] = self.steps;
        [first, first.wrapping_add_signed(down)].map(|at| {
            if !STRAIGHT {
                let texel = |at: usize| self.texels.get(at).copied().unwrap_or_default();
                [at, at.wrapping_add_signed(right)].map(texel)
            } else if at <= self.last {
                [self.texels[at], self.texels[at + 1]]
            } else {
                [T::default(); 2]
            }
        })
    }

    /// Fills an area of `band` with the texels that hold the places, and asks for those of the next ones.
    #[inline(always)]
    pub(super) fn nearest<O: Filtered<T>>(
        self,
        [places, next]: [&Places<T::Float>; 2],
        (band, area, length): (&mut [O], Rectangle, usize),
    ) {
        each_part(
            band,
            area,
            length,
            #[inline(always)]
            |first: usize, out: &mut [O]| {
                let lookups = places.first[first..].iter().zip(&next.first[first..]);
                for (out, (&first, &ahead)) in out.iter_mut().zip(lookups) {
                    prefetch_item(self.texels, ahead);
                    let texel = self.texels.get(first).copied().unwrap_or_default();
                    *out = O::exact(texel);
                }
            },
        );
    }

    /// Fills it with the means of the four texels around them.
    #[inline(always)]
    pub(super) fn bilinear<S: Simd, O: Filtered<T>>(
        self,
        simd: S,
        [places, next]: [&Places<T::Float>; 2],
        (band, area, length): (&mut [O], Rectangle, usize),
    ) {
        let (mut above, mut below) = ([[T::default(); 2]; LENGTH], [[T::default(); 2]; LENGTH]);
        each_part(
            band,
            area,
            length,
            #[inline(always)]
            |first: usize, out: &mut [O]| {
                let lookups = places.first[first..].iter().zip(&next.first[first..]);
                for (k, (&first, &ahead)) in lookups.enumerate().take(out.len()) {
                    prefetch_item(self.texels, ahead);
                    prefetch_item(self.texels, ahead.wrapping_add_signed(self.steps[1]));
                    [above[k], below[k]] = self.pairs(first);
                }
                let steps = (&places.tx[first..], &places.ty[first..]);
                if T::BY_FOURS {
                    return mixed_by_fours(simd, [&above, &below], steps, out);
                }
                let corners = above.iter().zip(&below).zip(steps.0.iter().zip(steps.1));
                for (out, ((above, below), (&tx, &ty))) in out.iter_mut().zip(corners) {
                    let [[a, b], [c, d]] = [above, below].map(|pair| pair.map(T::load));
                    *out = O::filtered(mix([a, b, c, d], tx, ty));
                }
            },
        );
    }
}

/// Writes the means of pairs of texels above and below places, which are converted several at a time: bytes take half as long again that way.
#[inline(always)]
fn mixed_by_fours<S: Simd, T: Texel, O: Filtered<T>>(
    simd: S,
    pairs: [&[[T; 2]; LENGTH]; 2],
    (tx, ty): (&[T::Float], &[T::Float]),
    out: &mut [O],
) {
    let mut numbers = [[[T::Float::ZERO; 2]; LENGTH]; 2];
    for (numbers, pairs) in numbers.iter_mut().zip(pairs) {
        let into = numbers.as_flattened_mut().as_chunks_mut::<8>().0;
        let from = pairs.as_flattened().as_chunks::<8>().0;
        for (into, from) in into.iter_mut().zip(from) {
            *into = T::load_eight(simd, from).to_array();
        }
    }
    let mut mixed = [T::Float::ZERO; LENGTH];
    let [above, below] = &numbers;
    let corners = above.iter().zip(below).zip(tx.iter().zip(ty));
    for (mixed, ((&[a, b], &[c, d]), (&tx, &ty))) in mixed.iter_mut().zip(corners) {
        *mixed = mix([a, b, c, d], tx, ty);
    }
    for (out, mixed) in out.chunks_mut(4).zip(mixed.as_chunks::<4>().0) {
        let four = O::filtered_four(simd, Four::<T, S>::load_array(simd, *mixed));
        out.copy_from_slice(&four[..out.len()]);
    }
}

#[cfg(test)]
mod tests {
    use crate::image::ImageView;
    use crate::image::shape_of_size;
    use crate::map::Map;
    use crate::resample::{Filter, Options, converted};
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        /// Alone or beside others: the same bits. Three numbers of a texel are added up in the same order, also where a texel is put
        /// together from single lookups.
        #[test]
        fn one_number_is_found_as_the_first_of_three_is(
            side in 3usize..200,
            antialias: bool,
            filter in prop::sample::select(vec![
                Filter::Nearest, Filter::Bilinear, Filter::CatmullRom, Filter::Lanczos3,
            ]),
            (from, shape) in prop::sample::select(vec![
                ("latlong", vec![128, 256]), ("cube", vec![6, 100, 100]), ("angular", vec![150, 150]),
            ]),
            to in prop::sample::select(vec!["latlong", "octahedral", "cube"]),
            seed: u32,
        ) {
            let (source, target) = (Map::new(from).unwrap(), Map::new(to).unwrap());
            let count: usize = shape.iter().product();
            let numbers = (0..3 * count as u32).map(|k| (k ^ seed).wrapping_mul(2_654_435_761));
            let mut triples: Vec<f32> = numbers.map(|x| (x >> 8) as f32 * 1e-5).collect();
            // Behind the last texel there is no fourth number: a lookup that reads so far takes the long way, whose fractions are rounded
            // otherwise. Between equal texels that makes no difference.
            let width = shape[shape.len() - 1];
            for row in 1..8 {
                triples[3 * (count - row * width)..][..3 * width][3 * (width - 8)..].fill(1.0);
            }
            let single: Vec<f32> = triples.iter().copied().step_by(3).collect();
            let size = shape_of_size(&target, side);
            let options = Options::new().filter(filter).antialias(antialias);
            let made = |texels: &[f32], channels: usize| {
                let image = ImageView::new(&source, &shape, channels, texels).unwrap();
                converted(&image, &target, &size, &options).unwrap()
            };
            let (alone, beside) = (made(&single, 1), made(&triples, 3));
            for (a, b) in alone.iter().zip(beside.iter().step_by(3)) {
                prop_assert_eq!(a.to_bits(), b.to_bits());
            }
        }

        #[test]
        fn bytes_are_found_as_their_numbers_are(
            side in 3usize..200,
            antialias: bool,
            seed: u32,
        ) {
            let (source, target) = (Map::new("latlong").unwrap(), Map::new("cube").unwrap());
            let bytes: Vec<u8> = (0..128 * 256_u32)
                .map(|k| ((k ^ seed).wrapping_mul(2_654_435_761) >> 24) as u8)
                .collect();
            let floats: Vec<f32> = bytes.iter().copied().map(f32::from).collect();
            let (shape, size, options) = ([128, 256], [6, side, side], Options::new().antialias(antialias));
            let bytes = ImageView::new(&source, &shape, 1, &bytes).unwrap();
            let floats = ImageView::new(&source, &shape, 1, &floats).unwrap();
            let bytes = converted(&bytes, &target, &size, &options).unwrap();
            let floats = converted(&floats, &target, &size, &options).unwrap();
            for (byte, float) in bytes.iter().zip(&floats) {
                prop_assert_eq!(f32::from(*byte), float.round_ties_even());
            }
        }
    }
}
