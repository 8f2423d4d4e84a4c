//! How each filter makes the means of places in parallelograms, [`LANES`] of these at a time.
//!
//! Three or four numbers of a texel lie in lanes, and parallelograms follow each other. Of one number nothing does, so there
//! lanes are parallelograms, and places of the same number follow each other: sum by sum the same. Everything is a
//! difference from the first lookup, itself a difference from a texel: a constant stays constant to the bit.

use super::gather::Bilinear;
use super::ones::Ones;
use super::place::Support;
use super::spread::{LANES, MOST};
use super::texture::Texture;
use super::weights::{WIDEST, Weights, find_along};
use super::wide::{Window, along, columns_of, slack, texel_of};
use crate::image::texel::{Eight, Four, Texel};
use crate::kernel::{Scalar, vectorize};
use crate::number::real::Real;
use crate::resample::filters::claims::Kernel;
use fearless_simd::{Simd, SimdBase, SimdSplit};

/// Places of parallelograms that are looked up together.
const ROOM: usize = MOST * LANES;

/// A filter that can make means.
pub(super) trait Look<T: Texel> {
    /// Which texels it needs around a place.
    const SUPPORT: Support;

    /// Whether it has a way for this face.
    fn serves(face: &Face<'_, T>) -> bool;

    /// Writes the means of the parallelograms of a room into the texels that they are of.
    fn look<S: Simd, const STRAIGHT: bool>(
        simd: S,
        face: &Face<'_, T>,
        room: &Room<T::Float>,
        means: &mut [T],
    );
}

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
                3 if STRAIGHT => put::<T, 3>(means, texel, face.mean_of_pairs::<S, 3>(simd, own)),
                3 => put::<T, 3>(means, texel, face.mean_of_four::<S>(simd, own)),
                4 if STRAIGHT => put::<T, 4>(means, texel, face.mean_of_pairs::<S, 4>(simd, own)),
                4 => put::<T, 4>(means, texel, face.mean_of_four::<S>(simd, own)),
                _ => face.mean(own, &mut means[texel * channels..][..channels]),
            }
        }
    }
}

/// Writes the first numbers of four into a texel, and none into the next, which may be done.
#[inline(always)]
fn put<T: Texel, const CHANNELS: usize>(means: &mut [T], texel: usize, numbers: [T; 4]) {
    if let Some(mean) = means.get_mut(texel * CHANNELS..(texel + 1) * CHANNELS) {
        mean.copy_from_slice(&numbers[..CHANNELS]);
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

/// The filters of TAPS × TAPS texels, whose weights [`weigh`] has put into the room: for each filter by itself this would be a megabyte more.
pub(super) struct Wide<const TAPS: usize>;

impl<T: Texel, const TAPS: usize> Look<T> for Wide<TAPS> {
    const SUPPORT: Support = Support::of(TAPS);

    /// Others are few.
    fn serves(face: &Face<'_, T>) -> bool {
        face.straight && face.channels <= 4
    }

    #[inline(always)]
    fn look<S: Simd, const STRAIGHT: bool>(
        simd: S,
        face: &Face<'_, T>,
        room: &Room<T::Float>,
        means: &mut [T],
    ) {
        match face.channels {
            1 if STRAIGHT => room.wide_of_ones::<S, T, TAPS>(simd, face, means),
            2 if STRAIGHT => room.wide::<S, T, TAPS, 2>(simd, face, means),
            3 if STRAIGHT => room.wide::<S, T, TAPS, 3>(simd, face, means),
            4 if STRAIGHT => room.wide::<S, T, TAPS, 4>(simd, face, means),
            _ => {}
        }
    }
}

/// Finds the weights of all places in a room.
#[inline(never)]
pub(super) fn weigh<F: Scalar, K: Kernel<TAPS>, const TAPS: usize>(room: &mut Room<F>) {
    if room.weights.len() < room.most {
        room.weights
            .resize(room.most, [[[F::ZERO; LANES]; WIDEST]; 2]);
    }
    vectorize(
        #[inline(always)]
        || {
            let places = room.tx.as_chunks().0.iter().zip(room.ty.as_chunks().0);
            let places = places.take(room.most);
            for ([across, down], (tx, ty)) in room.weights.iter_mut().zip(places) {
                find_along::<F, K, TAPS, LANES>(tx, LANES, across);
                find_along::<F, K, TAPS, LANES>(ty, LANES, down);
            }
        },
    );
}

/// The stored texels of a face.
#[derive(Clone, Copy)]
pub(super) struct Face<'a, T> {
    pub(super) texels: &'a [T],
    channels: usize,
    /// Where the window of its first texel begins.
    pub(super) first: usize,
    /// How many numbers to go right and down.
    pub(super) steps: [isize; 2],
    /// Whether its rows are stored as rows.
    pub(super) straight: bool,
}

impl<'a, T: Texel> Face<'a, T> {
    pub(super) fn new(source: &Texture<'a, T>, face: usize, support: Support) -> Self {
        let view = source.raster.view(face);
        let steps = view.steps().map(|step| step * source.channels as isize);
        let before = steps.map(|step| step * support.before as isize);
        let first = view.index(0, 0) * source.channels;
        Face {
            texels: source.texels,
            channels: source.channels,
            first: first.wrapping_add_signed(-before[0] - before[1]),
            steps,
            straight: source.raster.is_straight(face),
        }
    }

    /// Its steps, if the numbers of a parallelogram fit an i32 after so many.
    pub(super) fn narrow_steps(&self) -> Option<[i32; 2]> {
        let most = i32::MAX / (2 * MOST as i32);
        let [right, down] = self.steps.map(|step| i32::try_from(step).ok());
        let steps = [right?, down?];
        steps.iter().all(|step| step.abs() <= most).then_some(steps)
    }

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

    /// Four numbers, or none that is anywhere.
    #[inline(always)]
    fn four<S: Simd>(&self, simd: S, first: usize) -> Four<T, S> {
        match self.texels.get(first..).and_then(<[T]>::first_chunk) {
            Some(texels) => T::load_four(simd, texels),
            None => Four::<T, S>::splat(simd, T::Float::ZERO),
        }
    }

    /// A window of so many texels along each side, and so many numbers after each row.
    #[inline(always)]
    fn window(&self, first: usize, side: usize, slack: usize) -> Option<Window<'a, T>> {
        let (step, width) = (self.steps[1] as usize, side * self.channels + slack);
        let needed = (side - 1) * step + width;
        let numbers = self.texels.get(first..first.wrapping_add(needed))?;
        Some(Window {
            numbers,
            step,
            width,
        })
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
        let upper = self.eight(simd, first);
        let lower = self.eight(simd, first.wrapping_add_signed(self.steps[1]));
        upper + Eight::<T, S>::splat(simd, ty) * (lower - upper)
    }

    /// Eight numbers, or none that is anywhere.
    #[inline(always)]
    fn eight<S: Simd>(&self, simd: S, first: usize) -> Eight<T, S> {
        match self.texels.get(first..).and_then(<[T]>::first_chunk) {
            Some(texels) => T::load_eight(simd, texels),
            None => Eight::<T, S>::splat(simd, T::Float::ZERO),
        }
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
            let (a, b) = (self.four(simd, a), self.four(simd, b));
            let (c, d) = (self.four(simd, c), self.four(simd, d));
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

/// Where a window begins, and how far a place lies right of and below its first texel.
type Lookup<F> = (usize, F, F);

/// Lookups of [`LANES`] parallelograms, those of the same number after each other.
pub(super) struct Room<F> {
    /// The texels that they are of, ordered, and how many these are: lanes that are left over do what the first one does.
    pub(super) own: [usize; LANES],
    pub(super) count: usize,
    /// How many lookups each has, and the most that one has.
    pub(super) totals: [f32; LANES],
    pub(super) most: usize,
    pub(super) first: [usize; ROOM],
    pub(super) tx: [F; ROOM],
    pub(super) ty: [F; ROOM],
    /// Of bilinear lookups, how much each counts, and how much the right texels of all do.
    shares: [F; LANES],
    right: [F; LANES],
    /// Of wide filters, along u and along v, those of each texel of a window.
    weights: Vec<[Weights<F, LANES>; 2]>,
}

impl<F: Scalar> Room<F> {
    pub(super) const NEW: Room<F> = Room {
        own: [0; LANES],
        count: 0,
        totals: [0.0; LANES],
        most: 0,
        first: [0; ROOM],
        tx: [F::ZERO; ROOM],
        ty: [F::ZERO; ROOM],
        shares: [F::ZERO; LANES],
        right: [F::ZERO; LANES],
        weights: Vec::new(),
    };

    fn own(&self) -> &[usize] {
        &self.own[..self.count]
    }

    /// Where the windows of a number begin.
    #[inline(always)]
    pub(super) fn number(&self, number: usize) -> &[usize] {
        &self.first[number * LANES..][..LANES]
    }

    /// Those of one parallelogram.
    #[inline(always)]
    fn of(&self, lane: usize) -> impl Iterator<Item = Lookup<F>> {
        let steps = self.tx.as_chunks::<LANES>().0.iter();
        let steps = steps.zip(self.ty.as_chunks::<LANES>().0);
        let lookups = self.first.as_chunks::<LANES>().0.iter().zip(steps);
        lookups
            .take(self.totals[lane] as usize)
            .map(move |(first, (tx, ty))| (first[lane], tx[lane], ty[lane]))
    }

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

    /// The same by a wide filter.
    #[inline(always)]
    fn wide_of_ones<S: Simd, T: Texel<Float = F>, const TAPS: usize>(
        &self,
        simd: S,
        face: &Face<'_, T>,
        means: &mut [T],
    ) {
        let (mut base, mut sum) = ([F::ZERO; LANES], [F::ZERO; LANES]);
        let mut share = [F::ZERO; LANES];
        for (share, total) in share.iter_mut().zip(self.totals) {
            *share = F::new(1.0 / f64::from(total));
        }
        let mut columns = [[[F::ZERO; 4]; LANES]; 2];
        let numbers = self.first.as_chunks::<LANES>().0.iter().zip(&self.weights);
        for (number, (first, [across, down])) in numbers.enumerate().take(self.most) {
            let mut rows = [&across[0][..]; TAPS];
            for (row, across) in rows.iter_mut().zip(across) {
                *row = across;
            }
            for k in 0..LANES {
                if let Some(window) = face.window(first[k], TAPS, slack(TAPS)) {
                    let down = lane::<F, TAPS>(down, k);
                    let [left, right] = &mut columns;
                    [left[k], right[k]] = columns_of(simd, window, &down);
                }
            }
            for k in 0..LANES {
                let value = along(rows, &columns, k);
                base[k] = if number == 0 { value } else { base[k] };
                let more = sum[k] + share[k] * (value - base[k]);
                let own = (number as f32) < self.totals[k];
                sum[k] = if own { more } else { sum[k] };
            }
        }
        for (k, &texel) in self.own().iter().enumerate() {
            means[texel] = T::store(base[k] + sum[k]);
        }
    }

    /// That of texels of CHANNELS numbers, three or four.
    #[inline(always)]
    fn wide<S: Simd, T: Texel<Float = F>, const TAPS: usize, const CHANNELS: usize>(
        &self,
        simd: S,
        face: &Face<'_, T>,
        means: &mut [T],
    ) {
        let zero = Four::<T, S>::splat(simd, F::ZERO);
        for (k, &texel) in self.own().iter().enumerate().take(LANES) {
            let total = self.totals[k];
            let share = Four::<T, S>::splat(simd, F::new(1.0 / f64::from(total)));
            let (mut base, mut sum) = (zero, zero);
            let numbers = self.first.as_chunks::<LANES>().0.iter().zip(&self.weights);
            for (number, (first, [across, down])) in numbers.enumerate().take(total as usize) {
                if let Some(window) = face.window(first[k], TAPS, slack(TAPS)) {
                    let (across, down) = (lane(across, k), lane(down, k));
                    let value = texel_of::<S, T, TAPS, CHANNELS>(simd, window, &across, &down);
                    if number == 0 {
                        base = value;
                    }
                    sum += share * (value - base);
                }
            }
            put::<T, CHANNELS>(means, texel, T::filtered_four(simd, base + sum));
        }
    }
}

/// The weights of one place.
#[inline(always)]
fn lane<F: Scalar, const TAPS: usize>(weights: &Weights<F, LANES>, k: usize) -> [F; TAPS] {
    let mut own = [F::ZERO; TAPS];
    for (own, weights) in own.iter_mut().zip(weights) {
        *own = weights[k];
    }
    own
}
