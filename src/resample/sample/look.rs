//! How each filter makes the means of places in parallelograms, [`LANES`] of these at a time.
//!
//! Three or four numbers of a texel lie in lanes, and parallelograms follow each other. Of one number nothing does, so there
//! lanes are parallelograms, and places of the same number follow each other: sum by sum the same. Everything is a
//! difference from the first lookup, itself a difference from a texel: a constant stays constant to the bit.

use super::corners::mix;
use super::gather::{Bilinear, Window, columns_of, four, slack, texel_of};
use super::ones::Ones;
use super::place::Support;
use super::spread::{LANES, MOST};
use super::texture::Texture;
use super::weights::{WIDEST, Weights, along};
use crate::image::texel::{Four, Texel};
use crate::kernel::{Scalar, vectorize};
use crate::number::real::Real;
use crate::resample::filters::claims::Kernel;
use fearless_simd::{Simd, SimdBase};

/// Places of parallelograms that are looked up together.
const ROOM: usize = MOST * LANES;

/// A filter that can make means.
pub(super) trait Look<T: Texel> {
    /// Which texels it needs around a place.
    const SUPPORT: Support;

    /// Whether it has a way for this face.
    fn serves(face: &Face<'_, T>) -> bool;

    /// Writes the means of the first parallelograms of a room into the texels that they are of, which are ordered. There must be room for
    /// one texel more.
    fn look<S: Simd, const STRAIGHT: bool>(
        simd: S,
        face: &Face<'_, T>,
        room: &Room<T::Float>,
        means: (&[usize], &mut [T]),
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
        (own, means): (&[usize], &mut [T]),
    ) {
        let channels = face.channels;
        if let (1, Some(ones)) = (channels, Ones::<T, STRAIGHT>::new(face.texels, face.steps)) {
            for (&texel, mean) in own.iter().zip(room.means_of(ones)) {
                means[texel] = mean;
            }
            return;
        }
        for (lane, &texel) in own.iter().enumerate() {
            let total = room.totals[lane];
            let lookups = room.of(lane, total as usize);
            let share = Real::new(1.0 / f64::from(total));
            // Of three numbers, four are written: the next texel's come after.
            let mean = &mut means[texel * channels..];
            if let (3 | 4, Some(mean)) = (channels, mean.first_chunk_mut()) {
                *mean = face.mean_of_four::<S, STRAIGHT>(simd, lookups, share);
            } else {
                face.mean(lookups, share, &mut mean[..channels]);
            }
        }
    }
}

/// The filters of TAPS × TAPS texels, whose weights [`weigh`] has put into the room: for each filter by itself this would be a megabyte more.
pub(super) struct Wide<const TAPS: usize>;

impl<T: Texel, const TAPS: usize> Look<T> for Wide<TAPS> {
    const SUPPORT: Support = Support::of(TAPS);

    /// Others are few.
    fn serves(face: &Face<'_, T>) -> bool {
        face.straight && matches!(face.channels, 1 | 3 | 4)
    }

    #[inline(always)]
    fn look<S: Simd, const STRAIGHT: bool>(
        simd: S,
        face: &Face<'_, T>,
        room: &Room<T::Float>,
        means: (&[usize], &mut [T]),
    ) {
        match face.channels {
            1 if STRAIGHT => room.wide_of_ones::<S, T, TAPS>(simd, face, means),
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
                along::<F, K, TAPS, LANES>(tx, LANES, across);
                along::<F, K, TAPS, LANES>(ty, LANES, down);
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

    /// Four numbers.
    #[inline(always)]
    fn texel(&self, first: usize) -> Option<&'a [T; 4]> {
        self.texels.get(first..)?.first_chunk()
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

    /// The mean of four numbers a lookup, difference by difference from the first one: a constant stays constant to the bit.
    #[inline(always)]
    fn mean_of_four<S: Simd, const STRAIGHT: bool>(
        &self,
        simd: S,
        lookups: impl Iterator<Item = Lookup<T::Float>>,
        share: T::Float,
    ) -> [T; 4] {
        let splat = |x| Four::<T, S>::splat(simd, x);
        let share = splat(share);
        let (mut base, mut sum) = (splat(T::Float::ZERO), splat(T::Float::ZERO));
        let (down, nothing) = (self.steps[1] as usize, [T::default(); 4]);
        for (k, (first, tx, ty)) in lookups.enumerate() {
            // One by one: a closure of `map` is inlined by luck, and a call has no lanes.
            let corners = if STRAIGHT {
                let upper = &self.texels[first..][..self.channels + 4];
                let lower = &self.texels[first + down..][..self.channels + 4];
                [
                    four::<S, T>(simd, upper, 0),
                    four::<S, T>(simd, upper, self.channels),
                    four::<S, T>(simd, lower, 0),
                    four::<S, T>(simd, lower, self.channels),
                ]
            } else {
                let [a, b, c, d] = self.corners(first);
                [
                    T::load_four(simd, self.texel(a).unwrap_or(&nothing)),
                    T::load_four(simd, self.texel(b).unwrap_or(&nothing)),
                    T::load_four(simd, self.texel(c).unwrap_or(&nothing)),
                    T::load_four(simd, self.texel(d).unwrap_or(&nothing)),
                ]
            };
            let value = mix(corners, splat(tx), splat(ty));
            if k == 0 {
                base = value;
            }
            sum += share * (value - base);
        }
        T::filtered_four(simd, base + sum)
    }

    /// That of any number of channels.
    #[inline(always)]
    fn mean(
        &self,
        lookups: impl Iterator<Item = Lookup<T::Float>> + Clone,
        share: T::Float,
        mean: &mut [T],
    ) {
        for (c, mean) in mean.iter_mut().enumerate() {
            let (mut base, mut sum) = (T::Float::ZERO, T::Float::ZERO);
            for (k, (first, tx, ty)) in lookups.clone().enumerate() {
                let corners = self.corners(first + c);
                let value = mix(corners.map(|at| self.texels[at].load()), tx, ty);
                if k == 0 {
                    base = value;
                }
                sum = sum + share * (value - base);
            }
            *mean = T::store(base + sum);
        }
    }
}

/// Where a window begins, and how far a place lies right of and below its first texel.
type Lookup<F> = (usize, F, F);

/// Lookups of [`LANES`] parallelograms, those of the same number after each other.
pub(super) struct Room<F> {
    /// How many lookups each has, and the most that one has.
    pub(super) totals: [f32; LANES],
    pub(super) most: usize,
    pub(super) first: [usize; ROOM],
    pub(super) tx: [F; ROOM],
    pub(super) ty: [F; ROOM],
    /// Of wide filters, along u and along v, those of each texel of a window.
    weights: Vec<[Weights<F, LANES>; 2]>,
}

impl<F: Scalar> Room<F> {
    pub(super) const NEW: Room<F> = Room {
        totals: [0.0; LANES],
        most: 0,
        first: [0; ROOM],
        tx: [F::ZERO; ROOM],
        ty: [F::ZERO; ROOM],
        weights: Vec::new(),
    };

    /// Where the windows of a number begin.
    #[inline(always)]
    pub(super) fn number(&self, number: usize) -> &[usize] {
        &self.first[number * LANES..][..LANES]
    }

    /// Those of one parallelogram.
    #[inline(always)]
    fn of(&self, lane: usize, total: usize) -> impl Iterator<Item = Lookup<F>> + Clone {
        let steps = self.tx.as_chunks::<LANES>().0.iter();
        let steps = steps.zip(self.ty.as_chunks::<LANES>().0);
        let lookups = self.first.as_chunks::<LANES>().0.iter().zip(steps);
        lookups
            .take(total)
            .map(move |(first, (tx, ty))| (first[lane], tx[lane], ty[lane]))
    }

    /// The means of all, of texels of one number: sum by sum what [`Face::mean`] finds.
    #[inline(always)]
    fn means_of<T: Texel<Float = F>, const STRAIGHT: bool>(
        &self,
        ones: Ones<'_, T, STRAIGHT>,
    ) -> [T; LANES] {
        let (mut base, mut sum) = ([F::ZERO; LANES], [F::ZERO; LANES]);
        let share = self.totals.map(|total| F::new(1.0 / f64::from(total)));
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
                let value = mix([a, b, c, d], tx[k], ty[k]);
                base[k] = if number == 0 { value } else { base[k] };
                let more = sum[k] + share[k] * (value - base[k]);
                let own = (number as f32) < self.totals[k];
                sum[k] = if own { more } else { sum[k] };
            }
        }
        let mut means = [T::default(); LANES];
        for k in 0..LANES {
            means[k] = T::store(base[k] + sum[k]);
        }
        means
    }

    /// The same by a wide filter.
    #[inline(always)]
    fn wide_of_ones<S: Simd, T: Texel<Float = F>, const TAPS: usize>(
        &self,
        simd: S,
        face: &Face<'_, T>,
        (own, means): (&[usize], &mut [T]),
    ) {
        let (mut base, mut sum) = ([F::ZERO; LANES], [F::ZERO; LANES]);
        let mut share = [F::ZERO; LANES];
        for (share, total) in share.iter_mut().zip(self.totals) {
            *share = F::new(1.0 / f64::from(total));
        }
        let mut bases = [F::ZERO; LANES];
        let mut columns = [[[F::ZERO; 4]; LANES]; 2];
        let numbers = self.first.as_chunks::<LANES>().0.iter().zip(&self.weights);
        for (number, (first, [across, down])) in numbers.enumerate().take(self.most) {
            for k in 0..LANES {
                if let Some(window) = face.window(first[k], TAPS, slack(TAPS)) {
                    let down = lane::<F, TAPS>(down, k);
                    let [left, right] = &mut columns;
                    let columns = [&mut left[k], &mut right[k]];
                    bases[k] = columns_of(simd, window, &down, columns);
                }
            }
            for k in 0..LANES {
                let mut more = F::ZERO;
                for t in 0..TAPS {
                    more = more + across[t][k] * columns[t / 4][k][t % 4];
                }
                let value = bases[k] + more;
                base[k] = if number == 0 { value } else { base[k] };
                let more = sum[k] + share[k] * (value - base[k]);
                let own = (number as f32) < self.totals[k];
                sum[k] = if own { more } else { sum[k] };
            }
        }
        for (k, &texel) in own.iter().enumerate() {
            means[texel] = T::store(base[k] + sum[k]);
        }
    }

    /// That of texels of CHANNELS numbers, three or four.
    #[inline(always)]
    fn wide<S: Simd, T: Texel<Float = F>, const TAPS: usize, const CHANNELS: usize>(
        &self,
        simd: S,
        face: &Face<'_, T>,
        (own, means): (&[usize], &mut [T]),
    ) {
        let zero = Four::<T, S>::splat(simd, F::ZERO);
        for (k, &texel) in own.iter().enumerate().take(LANES) {
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
            // Of three numbers, four are written: the next texel's come after.
            if let Some(mean) = means[texel * CHANNELS..].first_chunk_mut() {
                *mean = T::filtered_four(simd, base + sum);
            }
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
