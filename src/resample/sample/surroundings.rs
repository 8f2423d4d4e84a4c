//! Lookups that reach over an edge, by a filter that weights texels along u and along v.
//!
//! A texel beyond an edge has one value, whichever lookup asks for it, and lookups along an edge come to the same ones: that value is
//! found once, from the stored texels that stand for it (`border`), and kept for a while. With all stored texels and weights listed for
//! each lookup, those along the edges of a cube of 1024² took a third of what its conversion by `lanczos3` did.

use super::continuations::{Place, slot_of};
use super::taps::Taps;
use super::texture::Texture;
use crate::image::texel::{Filtered, Texel};
use crate::number::real::Real;

/// How many texels are kept, of so many numbers: a block of the target comes to fewer, and of more numbers it is no longer the
/// finding that counts.
fn slots_for(channels: usize) -> usize {
    ((1 << 12) / channels).clamp(1 << 6, 1 << 10)
}

/// Values of texels beyond edges, each in the one slot that its place has.
pub(super) struct Surroundings<T: Texel>(Vec<(Option<Place>, Vec<T::Float>)>);

impl<T: Texel> Surroundings<T> {
    /// None. Room is made when the first is asked for: most lookups come to no edge.
    pub(super) fn new() -> Self {
        Surroundings(Vec::new())
    }

    /// The value of a texel beyond an edge.
    #[inline(never)]
    fn beyond(&mut self, texture: &Texture<'_, T>, place: Place) -> &[T::Float] {
        let slots = &mut self.0;
        if slots.is_empty() {
            slots.resize_with(slots_for(texture.channels), || (None, Vec::new()));
        }
        let number = slot_of(place, slots.len());
        let (own, kept) = &mut slots[number];
        if *own != Some(place) {
            let (mut taps, (face, i, j)) = (Taps::new(), place);
            texture.beyond(&mut taps, face, i, j, 1.0);
            kept.resize(texture.channels, T::Float::ZERO);
            texture.weigh(&taps, kept);
            *own = Some(place);
        }
        kept
    }

    /// N numbers of a texel, which may be beyond an edge, from one on.
    #[inline(always)]
    fn numbers<const N: usize>(
        &mut self,
        texture: &Texture<'_, T>,
        (face, i, j): Place,
        first: usize,
    ) -> [T::Float; N] {
        if texture.raster.holds(i, j) {
            let texel = texture.raster.view(face).index(i as usize, j as usize);
            let numbers = &texture.texels[texel * texture.channels + first..][..N];
            std::array::from_fn(|c| numbers[c].load())
        } else {
            let numbers = &self.beyond(texture, (face, i, j))[first..][..N];
            std::array::from_fn(|c| numbers[c])
        }
    }
}

/// The heaviest of some weights.
fn heaviest<const TAPS: usize>(weights: &[f64; TAPS]) -> usize {
    (1..TAPS).fold(
        0,
        |best, t| if weights[t] > weights[best] { t } else { best },
    )
}

/// The texels around a place, from the first of a face on, and what they count with.
struct Window<const TAPS: usize> {
    first: Place,
    across: [f64; TAPS],
    down: [f64; TAPS],
}

impl<const TAPS: usize> Window<TAPS> {
    fn place(&self, t: usize, r: usize) -> Place {
        let (face, i, j) = self.first;
        (face, i + t as isize, j + r as isize)
    }

    /// Writes N numbers, from one of a texel's on.
    #[inline(always)]
    fn weigh<T: Texel, O: Filtered<T>, const N: usize>(
        &self,
        (texture, surroundings): (&Texture<'_, T>, &mut Surroundings<T>),
        first: usize,
        out: &mut [O],
    ) {
        let heaviest = self.place(heaviest(&self.across), heaviest(&self.down));
        let base: [T::Float; N] = surroundings.numbers(texture, heaviest, first);
        let mut sums = [T::Float::ZERO; N];
        for (r, down) in self.down.into_iter().enumerate() {
            for (t, across) in self.across.into_iter().enumerate() {
                let weight = across * down;
                // One that counts for nothing may be no number.
                if weight != 0.0 {
                    let weight = T::Float::new(weight);
                    let numbers: [T::Float; N] =
                        surroundings.numbers(texture, self.place(t, r), first);
                    for c in 0..N {
                        sums[c] = sums[c] + weight * (numbers[c] - base[c]);
                    }
                }
            }
        }
        for (c, out) in out.iter_mut().enumerate() {
            *out = O::filtered(base[c] + sums[c]);
        }
    }
}

impl<T: Texel> Texture<'_, T> {
    /// Weights the texels around a place of a face. `weights` are those of a place so far from the texel left of it: behind a pointer, so that
    /// filters of as many texels are one function.
    #[inline(never)]
    pub(super) fn weigh_around<O: Filtered<T>, const TAPS: usize>(
        &self,
        surroundings: &mut Surroundings<T>,
        (face, uv): (usize, [f64; 2]),
        weights: fn(f64) -> [f64; TAPS],
        out: &mut [O],
    ) {
        let [x, y] = self.place(uv);
        let (left, top): (f64, f64) = (Real::floor(x), Real::floor(y));
        let before = TAPS as isize / 2 - 1;
        let window = Window {
            first: (face, left as isize - before, top as isize - before),
            across: weights(x - left),
            down: weights(y - top),
        };
        match self.channels {
            1 => window.weigh::<T, O, 1>((self, surroundings), 0, out),
            2 => window.weigh::<T, O, 2>((self, surroundings), 0, out),
            3 => window.weigh::<T, O, 3>((self, surroundings), 0, out),
            n => {
                // The last four may have been found in part.
                for first in (0..n).step_by(4).map(|first| first.min(n - 4)) {
                    let out = &mut out[first..first + 4];
                    window.weigh::<T, O, 4>((self, surroundings), first, out);
                }
            }
        }
    }
}
