//! Means of bilinear lookups: pairs of texels of two rows.
//!
//! What lies between the rows is added up for the left and for the right texels by themselves, and both are joined in the end: of texels of three or
//! four numbers eight numbers of a row are both texels of it, and half of the operations that texel by texel would be needed. Of one number, lanes
//! are parallelograms. All ways are sum by sum the same.

use super::gather::Bilinear;
use super::look::{Face, Look, Room, write};
use super::ones::Ones;
use super::place::Support;
use super::spread::LANES;
use super::wide::{eight, four};
use crate::image::texel::{Eight, Four, Texel};
use crate::kernel::{Scalar, vectorize};
use crate::number::real::Real;
use fearless_simd::{Simd, SimdBase, SimdSplit};

impl<T: Texel> Look<T> for Bilinear {
    const SUPPORT: Support = Support::PAIR;

    fn serves(_: &Face<'_, T>) -> bool {
        true
    }

    #[inline(always)]
    fn look<S: Simd, const STRAIGHT: bool>(
        simd: S,
        face: &Face<'_, T>,
        room: &Room<T::Float>,
        means: &mut [T],
    ) {
        let channels = face.channels;
        if let (1, Some(ones)) = (channels, Ones::<T, STRAIGHT>::new(face.texels, face.steps)) {
            for (&texel, mean) in room.own().iter().zip(room.means_of(ones)) {
                means[texel] = mean;
            }
            return;
        }
        for (lane, &texel) in room.own().iter().enumerate() {
            let own = (room, lane);
            match channels {
                3 if STRAIGHT => write::<T, 3>(means, texel, face.mean_of_pairs::<S, 3>(simd, own)),
                3 => write::<T, 3>(means, texel, face.mean_of_four::<S>(simd, own)),
                4 if STRAIGHT => write::<T, 4>(means, texel, face.mean_of_pairs::<S, 4>(simd, own)),
                4 => write::<T, 4>(means, texel, face.mean_of_four::<S>(simd, own)),
                _ => face.mean(own, &mut means[texel * channels..][..channels]),
            }
        }
    }
}

/// Puts the shares of bilinear lookups in their means into a room.
#[inline(never)]
pub(super) fn share<F: Scalar>(room: &mut Room<F>) {
    vectorize(
        #[inline(always)]
        || {
            // Arrays of its own: of what may be the same memory the compiler makes no lanes.
            let (totals, mut shares, mut right) = (room.totals, [F::ZERO; LANES], [F::ZERO; LANES]);
            for k in 0..LANES {
                shares[k] = F::new(1.0 / f64::from(totals[k]));
            }
            let numbers = room.tx.as_chunks_mut::<LANES>().0.iter_mut();
            for (number, tx) in numbers.enumerate().take(room.most) {
                let mut shared = *tx;
                for k in 0..LANES {
                    shared[k] = shared[k] * shares[k];
                    let own = (number as f32) < totals[k];
                    right[k] = right[k] + if own { shared[k] } else { F::ZERO };
                }
                *tx = shared;
            }
            (room.shares, room.right) = (shares, right);
        },
    );
}

impl<T: Texel> Face<'_, T> {
    /// Where the four texels of a lookup begin, of which the first is known.
    #[inline(always)]
    fn corners(&self, first: usize) -> [usize; 4] {
        let [right, down] = self.steps;
        let below = first.wrapping_add_signed(down);
        [
            first,
            first.wrapping_add_signed(right),
            below,
            below.wrapping_add_signed(right),
        ]
    }

    /// The mean of bilinear lookups of one lane of a room, of texels of CHANNELS numbers, three or four.
    ///
    /// Eight numbers of a row hold both texels of it. What lies between two rows is added up for the left and the right texels by
    /// themselves, by weights in eight lanes, and both are added in the end: half of the operations of
    /// [`Face::mean_of_four`], to the same bits.
    #[inline(always)]
    fn mean_of_pairs<S: Simd, const CHANNELS: usize>(
        &self,
        simd: S,
        (room, lane): (&Room<T::Float>, usize),
    ) -> [T; 4] {
        let (mut lefts, mut signs) = ([T::Float::ZERO; 8], [T::Float::ONE; 8]);
        for k in 0..CHANNELS {
            (lefts[k], signs[k]) = (T::Float::ONE, -T::Float::ONE);
        }
        let splat = |x| Eight::<T, S>::splat(simd, x);
        let signs = Eight::<T, S>::load_array(simd, signs);
        let lefts = Eight::<T, S>::load_array(simd, lefts) * splat(room.shares[lane]);
        let mut lookups = room.of(lane);
        let (mut base, mut sum) = (splat(T::Float::ZERO), splat(T::Float::ZERO));
        if let Some((first, _, ty)) = lookups.next() {
            base = self.between(simd, first, ty);
        }
        for (first, tx, ty) in lookups {
            let between = self.between(simd, first, ty);
            sum += (lefts + signs * splat(tx)) * (between - base);
        }
        let [(base, next), (left, right)] = [base, sum].map(
            #[inline(always)]
            |x| (x.split().0, x.slide::<CHANNELS>(x).split().0),
        );
        let right_share = Four::<T, S>::splat(simd, room.right[lane]);
        T::filtered_four(simd, base + ((left + right) + right_share * (next - base)))
    }

    /// What lies between eight numbers of a row and those below.
    #[inline(always)]
    fn between<S: Simd>(&self, simd: S, first: usize, ty: T::Float) -> Eight<T, S> {
        let upper = eight(simd, self.texels, first);
        let lower = eight(simd, self.texels, first.wrapping_add_signed(self.steps[1]));
        upper + Eight::<T, S>::splat(simd, ty) * (lower - upper)
    }

    /// That of texels that need not follow each other in rows.
    #[inline(always)]
    fn mean_of_four<S: Simd>(&self, simd: S, (room, lane): (&Room<T::Float>, usize)) -> [T; 4] {
        let splat = |x| Four::<T, S>::splat(simd, x);
        let (share, zero) = (splat(room.shares[lane]), splat(T::Float::ZERO));
        let (mut bases, mut sums) = ([zero; 2], [zero; 2]);
        for (number, (first, tx, ty)) in room.of(lane).enumerate() {
            // One by one: a closure of `map` is inlined by luck, and a call has no lanes.
            let [a, b, c, d] = self.corners(first);
            let (a, b) = (four(simd, self.texels, a), four(simd, self.texels, b));
            let (c, d) = (four(simd, self.texels, c), four(simd, self.texels, d));
            let (tx, ty) = (splat(tx), splat(ty));
            let (left, right) = (a + ty * (c - a), b + ty * (d - b));
            if number == 0 {
                bases = [left, right];
            }
            sums[0] += (share - tx) * (left - bases[0]);
            sums[1] += tx * (right - bases[1]);
        }
        let right_share = splat(room.right[lane]);
        let more = (sums[0] + sums[1]) + right_share * (bases[1] - bases[0]);
        T::filtered_four(simd, bases[0] + more)
    }

    /// That of any number of channels.
    #[inline(always)]
    fn mean(&self, (room, lane): (&Room<T::Float>, usize), mean: &mut [T]) {
        let share = room.shares[lane];
        for (c, mean) in mean.iter_mut().enumerate() {
            let (mut base, mut lefts, mut rights) = (
                (T::Float::ZERO, T::Float::ZERO),
                T::Float::ZERO,
                T::Float::ZERO,
            );
            for (number, (first, tx, ty)) in room.of(lane).enumerate() {
                let corners = self.corners(first + c).map(|at| self.texels[at].load());
                let (left, right) = sides(corners, ty);
                if number == 0 {
                    base = (left, right);
                }
                lefts = lefts + (share - tx) * (left - base.0);
                rights = rights + tx * (right - base.1);
            }
            *mean = T::store(joined(base, (lefts, rights), room.right[lane]));
        }
    }
}

impl<F: Scalar> Room<F> {
    /// The means of all, of texels of one number: sum by sum what [`Face::mean`] finds.
    #[inline(always)]
    fn means_of<T: Texel<Float = F>, const STRAIGHT: bool>(
        &self,
        ones: Ones<'_, T, STRAIGHT>,
    ) -> [T; LANES] {
        // Four arrays of numbers: of one of pairs the compiler makes no lanes.
        let (mut left_base, mut right_base) = ([F::ZERO; LANES], [F::ZERO; LANES]);
        let (mut lefts, mut rights) = ([F::ZERO; LANES], [F::ZERO; LANES]);
        let steps = self.tx.as_chunks::<LANES>().0.iter();
        let steps = steps.zip(self.ty.as_chunks::<LANES>().0);
        let numbers = self.first.as_chunks::<LANES>().0.iter().zip(steps);
        for (number, (first, (tx, ty))) in numbers.enumerate().take(self.most) {
            let mut pairs = [[[T::default(); 2]; LANES]; 2];
            for k in 0..LANES {
                [pairs[0][k], pairs[1][k]] = ones.pairs(first[k]);
            }
            for k in 0..LANES {
                let [[a, b], [c, d]] = [pairs[0][k], pairs[1][k]].map(|pair| pair.map(T::load));
                let (left, right) = sides([a, b, c, d], ty[k]);
                left_base[k] = if number == 0 { left } else { left_base[k] };
                right_base[k] = if number == 0 { right } else { right_base[k] };
                let more_left = lefts[k] + (self.shares[k] - tx[k]) * (left - left_base[k]);
                let more_right = rights[k] + tx[k] * (right - right_base[k]);
                let own = (number as f32) < self.totals[k];
                lefts[k] = if own { more_left } else { lefts[k] };
                rights[k] = if own { more_right } else { rights[k] };
            }
        }
        let mut means = [T::default(); LANES];
        for k in 0..LANES {
            let base = (left_base[k], right_base[k]);
            means[k] = T::store(joined(base, (lefts[k], rights[k]), self.right[k]));
        }
        means
    }
}

/// What lies between the rows of four corners, on the left and on the right.
#[inline(always)]
fn sides<F: Real>([a, b, c, d]: [F; 4], ty: F) -> (F, F) {
    (a + ty * (c - a), b + ty * (d - b))
}

/// The mean of lookups, of whose first one both sides are known, of all how much they are more than those, and how much the right sides
/// count.
#[inline(always)]
fn joined<F: Real>((left, right): (F, F), (lefts, rights): (F, F), share: F) -> F {
    left + ((lefts + rights) + share * (right - left))
}
