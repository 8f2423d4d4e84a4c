//! Lookups tile by tile, by any filter of the table.

use super::gather::{Bilinear, Gather, Gathering, Nearest, Separable, Stored};
use super::place::{Places, Support};
use super::rectangle::Rectangle;
use super::surroundings::Surroundings;
use super::taps::Taps;
use super::texture::Texture;
use super::weights::{self, WIDEST, Weights};
use crate::image::texel::{Filtered, Texel};
use crate::kernel::Scalar;
use crate::kernel::tile::{TILE, Tile};
use crate::number::real::Real;
use crate::projections::projection::{Outline, Seam};
use crate::resample::filters::LookupFilter;
use crate::resample::filters::claims::{Kernel, Visitor};
use std::cell::RefCell;

/// Lookups tile by tile: the texels of one are asked for while those of the one before are weighted.
pub(crate) struct Lookups<'s, 'a, T: Texel, O, R> {
    source: &'s Texture<'a, T>,
    filter: LookupFilter,
    fill: &'s [O],
    queue: [Queued<T::Float, R>; 2],
    current: usize,
    /// Of a filter of more than two texels along a side, those of the current tile along u and along v.
    weights: Option<Box<[Weights<T::Float, TILE>; 2]>>,
    /// Of lookups that reach over an edge.
    surroundings: RefCell<Surroundings<T>>,
}

struct Queued<F, R> {
    places: Places<F>,
    all_inside: bool,
    uv: Tile<R, 3>,
    area: Rectangle,
    length: usize,
}

impl<'s, 'a, T: Texel, O: Filtered<T>, R: Scalar> Lookups<'s, 'a, T, O, R> {
    /// Lookups in an image. Where it holds nothing, the result is `fill`.
    pub fn new(source: &'s Texture<'a, T>, filter: LookupFilter, fill: &'s [O]) -> Self {
        let queued = || Queued {
            places: Places::new(),
            all_inside: false,
            uv: Tile::new(),
            area: Rectangle {
                start: 0,
                columns: 1,
                stride: 1,
            },
            length: 0,
        };
        Lookups {
            source,
            filter,
            fill,
            queue: [queued(), queued()],
            current: 0,
            weights: None,
            surroundings: RefCell::new(Surroundings::new()),
        }
    }

    /// The canonical (u, v, face) of the next tile, to be written.
    pub fn tile(&mut self) -> &mut Tile<R, 3> {
        &mut self.queue[1 - self.current].uv
    }

    /// Finds the texels around the first `count` places of the next tile. Returns whether none of them lies at an edge or
    /// nowhere.
    pub fn place(&mut self, count: usize) -> bool {
        let source = self.source;
        let reach = support(self.filter);
        let next = &mut self.queue[1 - self.current];
        next.all_inside = source.find(&mut next.places, reach, &next.uv, count);
        next.length = count;
        next.all_inside
    }

    /// Looks the places that were found up, into an area of `band`: at the next call.
    pub fn push(&mut self, band: &mut [O], area: Rectangle) {
        self.queue[1 - self.current].area = area;
        self.gather(band);
        self.current = 1 - self.current;
    }

    /// Does what is left to do.
    pub fn finish(&mut self, band: &mut [O]) {
        self.gather(band);
        self.queue[self.current].length = 0;
    }

    /// Weights the texels of the current tile, and asks for those of the next.
    fn gather(&mut self, band: &mut [O]) {
        self.filter.visit(Weigh(self, band));
    }

    fn weigh<G: Gather<T>>(&self, band: &mut [O], weights: G::Weights<'_>) {
        let source = self.source;
        let tile = &self.queue[self.current];
        let next = &self.queue[1 - self.current].places;
        let work = Gathering {
            stored: source.stored(),
            places: &tile.places,
            all_inside: tile.all_inside,
            next,
            band,
            area: tile.area,
            length: tile.length,
            edge: &mut |k: usize, out: &mut [O]| {
                let [u, v, face] = tile.uv.at(k).map(Scalar::to_f64);
                if u.is_nan() {
                    out.copy_from_slice(self.fill);
                } else {
                    let surroundings = &mut *self.surroundings.borrow_mut();
                    at_edge(
                        (source, surroundings),
                        self.filter,
                        (face as usize, [u, v]),
                        out,
                    );
                }
            },
        };
        work.run::<G>(weights);
    }
}

/// Which texels a filter needs.
pub(super) fn support(filter: LookupFilter) -> Support {
    filter.visit(GetSupport)
}

struct GetSupport;

impl Visitor for GetSupport {
    type Output = Support;
    fn nearest(self) -> Support {
        Support::NEAREST
    }
    fn bilinear(self) -> Support {
        Support::PAIR
    }
    fn separable<K: Kernel<TAPS>, const TAPS: usize>(self) -> Support {
        Support::of(TAPS)
    }
}

/// Weights the texels of the current tile into a band.
struct Weigh<'l, 's, 'a, T: Texel, O, R>(&'l mut Lookups<'s, 'a, T, O, R>, &'l mut [O]);

impl<T: Texel, O: Filtered<T>, R: Scalar> Visitor for Weigh<'_, '_, '_, T, O, R> {
    type Output = ();
    fn nearest(self) {
        self.0.weigh::<Nearest>(self.1, ());
    }
    fn bilinear(self) {
        self.0.weigh::<Bilinear>(self.1, ());
    }
    fn separable<K: Kernel<TAPS>, const TAPS: usize>(self) {
        let Weigh(lookups, band) = self;
        let weights = lookups.weights.take();
        let mut weights =
            weights.unwrap_or_else(|| Box::new([[[T::Float::ZERO; TILE]; WIDEST]; 2]));
        let tile = &lookups.queue[lookups.current];
        weights::find::<T::Float, K, TAPS>(&tile.places, tile.length, &mut weights);
        lookups.weigh::<Separable<TAPS>>(band, &weights);
        lookups.weights = Some(weights);
    }
}

/// Looks a place up that lies at an edge.
#[cold]
#[inline(never)]
pub(super) fn at_edge<T: Texel, O: Filtered<T>>(
    (source, surroundings): (&Texture<'_, T>, &mut Surroundings<T>),
    filter: LookupFilter,
    at: (usize, [f64; 2]),
    out: &mut [O],
) {
    filter.visit(AtEdge {
        source,
        surroundings,
        at,
        out,
    });
}

struct AtEdge<'l, 'a, T: Texel, O> {
    source: &'l Texture<'a, T>,
    surroundings: &'l mut Surroundings<T>,
    at: (usize, [f64; 2]),
    out: &'l mut [O],
}

impl<T: Texel, O: Filtered<T>> Visitor for AtEdge<'_, '_, T, O> {
    type Output = ();
    fn nearest(self) {
        let (face, uv) = self.at;
        let index = self.source.nearest(face, uv) * self.source.channels;
        for (out, &texel) in self.out.iter_mut().zip(&self.source.texels[index..]) {
            *out = O::exact(texel);
        }
    }
    fn bilinear(self) {
        if self.source.seam == Seam::Faces {
            // What is between the last centers and an edge has a rule of its own.
            let ((face, uv), mut taps) = (self.at, Taps::new());
            self.source.resolve(&mut taps, face, uv, 1.0);
            self.source.weigh(&taps, self.out);
        } else {
            let weights = |t| [1.0 - t, t];
            (self.source).weigh_around(self.surroundings, self.at, weights, self.out);
        }
    }
    fn separable<K: Kernel<TAPS>, const TAPS: usize>(self) {
        (self.source).weigh_around(self.surroundings, self.at, K::weights::<f64>, self.out);
    }
}

impl<T: Texel> Texture<'_, T> {
    /// Its texels, as they are stored.
    pub(super) fn stored(&self) -> Stored<'_, T> {
        Stored {
            raster: &self.raster,
            texels: self.texels,
            channels: self.channels,
        }
    }

    /// Finds the texels around the first `count` places of a tile, for a filter that needs these. Returns whether none of them lies
    /// at an edge or nowhere.
    pub(super) fn find<R: Scalar>(
        &self,
        places: &mut Places<T::Float>,
        reach: Support,
        uv: &Tile<R, 3>,
        count: usize,
    ) -> bool {
        let (raster, safe) = (&self.raster, self.safe(reach));
        let all = places.set((raster, self.channels), reach, safe, uv, count);
        if raster.outline == Outline::Shape {
            return places.leave_out_rim(raster, reach, uv, count);
        }
        all
    }

    /// The sum of texels by their weights, which add up to 1.
    pub(super) fn weigh<O: Filtered<T>>(&self, taps: &Taps, out: &mut [O]) {
        let heaviest = taps
            .list()
            .iter()
            .fold((0, 0.0), |a, b| if b.1 > a.1 { *b } else { a })
            .0;
        for (k, out) in out.iter_mut().enumerate() {
            let base = self.texels[heaviest * self.channels + k].load();
            let mut sum = T::Float::ZERO;
            for &(index, weight) in taps.list() {
                let texel = self.texels[index * self.channels + k].load();
                sum = sum + T::Float::new(weight) * (texel - base);
            }
            *out = O::filtered(base + sum);
        }
    }
}
