//! How each filter makes the means of places in parallelograms, [`LANES`] of these at a time.
//!
//! Numbers of a texel lie in lanes, and parallelograms follow each other. Of one number nothing does, so there
//! lanes are parallelograms, and places of the same number follow each other: sum by sum the same. Everything is a
//! difference from the first lookup, itself a difference from a texel: a constant stays constant to the bit. Bilinear means of few are in `pairs`,
//! and of many in `slices`.

use super::place::Support;
use super::spread::{LANES, MOST};
use super::texture::Texture;
use super::weights::{WIDEST, Weights, find_along};
use super::wide::{Window, along, columns_of, slack, texel_of};
use crate::image::texel::{Four, Texel};
use crate::kernel::{Scalar, vectorize};
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

    /// Writes the means of the parallelograms of a room into the texels that they are of.
    fn look<S: Simd, const STRAIGHT: bool>(
        simd: S,
        face: &Face<'_, T>,
        room: &Room<T::Float>,
        means: &mut [T],
    );
}

/// Writes the first numbers of four into a texel, and none into the next, which may be done.
#[inline(always)]
pub(super) fn write<T: Texel, const CHANNELS: usize>(
    means: &mut [T],
    texel: usize,
    numbers: [T; 4],
) {
    if let Some(mean) = means.get_mut(texel * CHANNELS..(texel + 1) * CHANNELS) {
        mean.copy_from_slice(&numbers[..CHANNELS]);
    }
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
                find_along::<F, K, TAPS>(tx, across);
                find_along::<F, K, TAPS>(ty, down);
            }
        },
    );
}

/// The stored texels of a face.
#[derive(Clone, Copy)]
pub(super) struct Face<'a, T> {
    pub(super) texels: &'a [T],
    pub(super) channels: usize,
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

    /// Its steps, if the numbers of a parallelogram fit an i32 after so many along both axes.
    pub(super) fn narrow_steps(&self, reach: i32) -> Option<[i32; 2]> {
        let most = i32::MAX / (2 * reach);
        let [right, down] = self.steps.map(|step| i32::try_from(step).ok());
        let steps = [right?, down?];
        steps.iter().all(|step| step.abs() <= most).then_some(steps)
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
}

/// Where a window begins, and how far a place lies right of and below its first texel.
type Lookup<F> = (usize, F, F);

/// Lookups of [`LANES`] parallelograms, those of the same number after each other.
pub(super) struct Room<F> {
    /// The texels that they are of, and how many these are: lanes that are left over do what the first one does.
    pub(super) own: [usize; LANES],
    pub(super) count: usize,
    /// How many lookups each has, and the most that one has.
    pub(super) totals: [f32; LANES],
    pub(super) most: usize,
    pub(super) first: [usize; ROOM],
    pub(super) tx: [F; ROOM],
    pub(super) ty: [F; ROOM],
    /// Of bilinear lookups, how much each counts, and how much the right texels of all do.
    pub(super) shares: [F; LANES],
    pub(super) right: [F; LANES],
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

    /// The texels that they are of.
    pub(super) fn own(&self) -> &[usize] {
        &self.own[..self.count]
    }

    /// Where the windows of a number begin.
    #[inline(always)]
    pub(super) fn number(&self, number: usize) -> &[usize] {
        &self.first[number * LANES..][..LANES]
    }

    /// Those of one parallelogram.
    #[inline(always)]
    pub(super) fn of(&self, lane: usize) -> impl Iterator<Item = Lookup<F>> {
        let steps = self.tx.as_chunks::<LANES>().0.iter();
        let steps = steps.zip(self.ty.as_chunks::<LANES>().0);
        let lookups = self.first.as_chunks::<LANES>().0.iter().zip(steps);
        lookups
            .take(self.totals[lane] as usize)
            .map(move |(first, (tx, ty))| (first[lane], tx[lane], ty[lane]))
    }

    /// The means of all by a wide filter, of texels of one number.
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
            write::<T, CHANNELS>(means, texel, T::filtered_four(simd, base + sum));
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
