//! Bilinear lookups in one level of a mip chain, as many of a tile as go there.
//!
//! They are those in an image without levels (`gather`). First all levels find their texels and ask for their memory, and then each
//! weights them: by then most of it is there, in whatever order directions come.

use super::gather::{Bilinear, Gathering};
use super::lookups::at_edge;
use super::place::{Places, Support};
use super::rectangle::Rectangle;
use super::surroundings::Surroundings;
use super::texture::Texture;
use crate::image::texel::Texel;
use crate::kernel::Scalar;
use crate::kernel::tile::{TILE, Tile, prefetch_item};
use crate::number::real::Real;
use crate::resample::filters::LookupFilter;

/// How many numbers of an image lie between texels whose memory is nearly the same.
const NEAR: usize = 16;

/// Places of a tile that are looked up in one level.
pub(crate) struct Held<F> {
    count: usize,
    /// Of each its number in the tile, and how much it counts beside what was seen in the level before.
    numbers: [u16; TILE],
    shares: [F; TILE],
    /// Whether each counts for all.
    first: bool,
    uv: Tile<f64, 3>,
    places: Places<F>,
    all_inside: bool,
}

impl<F: Scalar> Held<F> {
    /// None.
    pub(crate) fn new() -> Self {
        Held {
            count: 0,
            numbers: [0; TILE],
            shares: [F::ZERO; TILE],
            first: true,
            uv: Tile::new(),
            places: Places::new(),
            all_inside: false,
        }
    }

    /// Lets go of all.
    pub(crate) fn clear(&mut self) {
        (self.count, self.first) = (0, true);
    }

    /// Takes in the place of number k: u, v and face. There is room for those of a tile.
    #[inline(always)]
    pub(crate) fn push(&mut self, k: usize, place: [f64; 3], share: F) {
        let own = self.count % TILE;
        self.uv.set(own, place);
        (self.numbers[own], self.shares[own]) = (k as u16, share);
        self.first &= share == F::ONE;
        self.count = own + 1;
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Whether these are so many of a tile, in their order, and count for all.
    pub(crate) fn is_all(&self, count: usize) -> bool {
        self.first && self.count == count
    }

    /// The number of each, and how much it counts.
    #[inline(always)]
    pub(crate) fn members(&self) -> impl Iterator<Item = (usize, F)> {
        let all = self.numbers[..self.count].iter().zip(&self.shares);
        all.map(|(&k, &share)| (usize::from(k), share))
    }

    /// All of their places.
    pub(super) fn all(&self) -> impl Iterator<Item = [f64; 3]> {
        (0..self.count).map(|k| self.uv.at(k))
    }
}

/// A level, looked up by one thread.
pub(crate) trait InLevel<F> {
    /// Finds the texels of places, and asks for them.
    fn place(&mut self, held: &mut Held<F>);

    /// Writes their bilinear values, one after the other.
    fn look(&mut self, held: &Held<F>, values: &mut [F]);
}

/// Lookups in a texture.
pub(super) struct InTexture<'l, 'a, T: Texel> {
    texture: &'l Texture<'a, T>,
    surroundings: Surroundings<T>,
}

impl<'l, 'a, T: Texel> InTexture<'l, 'a, T> {
    pub(super) fn new(texture: &'l Texture<'a, T>) -> Self {
        InTexture {
            texture,
            surroundings: Surroundings::new(),
        }
    }
}

impl<T: Texel> InLevel<T::Float> for InTexture<'_, '_, T> {
    fn place(&mut self, held: &mut Held<T::Float>) {
        let (texture, count) = (self.texture, held.count);
        let channels = texture.channels;
        held.all_inside = texture.find(&mut held.places, Support::PAIR, &held.uv, count);
        let row = texture.raster.columns * channels;
        let mut before = usize::MAX;
        for &first in &held.places.first[..count] {
            // Lookups of a picture read nearly the same memory.
            if first.abs_diff(before) > NEAR {
                for at in [first, first.wrapping_add(row)] {
                    prefetch_item(texture.texels, at);
                    prefetch_item(texture.texels, at.wrapping_add(2 * channels - 1));
                }
            }
            before = first;
        }
    }

    fn look(&mut self, held: &Held<T::Float>, values: &mut [T::Float]) {
        let (texture, count) = (self.texture, held.count);
        let surroundings = &mut self.surroundings;
        let mut the_long_way = |k: usize, out: &mut [T::Float]| {
            let [u, v, face] = held.uv.at(k);
            let at = (face as usize, [u, v]);
            at_edge((texture, surroundings), LookupFilter::Bilinear, at, out);
        };
        let work = Gathering {
            stored: texture.stored(),
            places: &held.places,
            all_inside: held.all_inside,
            // They have been asked for.
            next: &held.places,
            band: &mut *values,
            area: Rectangle {
                start: 0,
                columns: count,
                stride: count,
            },
            length: count,
            edge: &mut the_long_way,
        };
        work.run::<Bilinear>(());
        // What counts for nothing may be no number, and only the long way leaves it out.
        let zero = T::Float::ZERO;
        let fractions = held.places.tx[..count].iter().zip(&held.places.ty);
        let values = values.chunks_exact_mut(texture.channels);
        for (k, ((tx, ty), out)) in fractions.zip(values).enumerate() {
            if (*tx == zero || *ty == zero) && out.iter().any(|x| x.is_nan()) {
                the_long_way(k, out);
            }
        }
    }
}
