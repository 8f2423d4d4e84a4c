//! Looking directions up in an image.
//!
//! Directions become image coordinates, these become texels and fractions (`place`), and windows of texels
//! are read and weighted (`gather`): block by block, each step a plain loop. Nearly every lookup has its
//! window inside one face. The others meet an edge, and what lies beyond is the projection's
//! [`Seam`]: `border` resolves such a lookup, in f64, into stored texels with
//! weights that sum to 1, and the result is base + Σ w (texel - base): a constant image stays constant to the
//! bit, here as on the short way.
//!
//! Texels whose center lies outside the valid image (the corners around a disk, where photographers
//! print their credits; the empty cells of a cross) never take part.
//!
//! What did not help: continuing the image by its nearest texels (an error of first order at every seam), and a
//! padded copy of the source (a copy a call, for the few lookups that need it).

mod border;
mod edges;
mod gather;
mod level;
mod place;
mod taps;
mod weights;

use crate::error::Error;
use crate::image::raster::Raster;
use crate::image::texel::{Filtered, Texel};
use crate::kernel::Scalar;
use crate::kernel::threads;
use crate::kernel::tile::{TILE, Tile, Tuples};
use crate::map::Map;
use crate::map::verbs::EncodeTile;
use crate::number::real::Real;
use crate::projections::projection::Visitor;
use crate::projections::projection::{Outline, Projection, Seam};
use gather::{Bilinear, Gather, Gathering, Nearest, Separable, Stored};
use glam::DMat3;
pub(crate) use level::Level;
use ndarray::ArrayView2;
use place::{Places, Support};
use taps::Taps;
use weights::{CatmullRom, Kernel, Lanczos3, Mitchell};

/// How a value is taken from texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// The texel that holds the place.
    Nearest,
    /// The four texels around it.
    Bilinear,
    /// Sixteen texels, Catmull and Rom's cubic: interpolates and keeps parabolas.
    CatmullRom,
    /// Sixteen texels, Mitchell and Netravali's cubic: softer, hardly any ringing.
    Mitchell,
    /// Thirty-six texels, the sinc function in Lanczos' window.
    Lanczos3,
}

impl Filter {
    /// All names. Two mean the same filter: "bicubic" is what most programs call Catmull and Rom's.
    pub const NAMES: [&'static str; 6] = [
        "nearest",
        "bilinear",
        "bicubic",
        "catmull-rom",
        "mitchell",
        "lanczos3",
    ];

    /// The filter of this name.
    pub fn find(name: &str) -> Result<Filter, Error> {
        match name {
            "nearest" => Ok(Filter::Nearest),
            "bilinear" => Ok(Filter::Bilinear),
            "bicubic" | "catmull-rom" => Ok(Filter::CatmullRom),
            "mitchell" => Ok(Filter::Mitchell),
            "lanczos3" => Ok(Filter::Lanczos3),
            _ => Err(Error::unknown("filter", name, &Self::NAMES)),
        }
    }

    fn reach(self) -> Support {
        let wide = |before, after| Support {
            shift: 0.0,
            before,
            after,
        };
        match self {
            Filter::Nearest => Support {
                shift: 0.5,
                before: 0,
                after: 0,
            },
            Filter::Bilinear => wide(0, 1),
            Filter::CatmullRom | Filter::Mitchell => wide(1, 2),
            Filter::Lanczos3 => wide(2, 3),
        }
    }
}

/// An image that can be looked up.
#[derive(Clone, Copy)]
pub struct Source<'a, T> {
    map: &'a Map,
    shape: &'a [usize],
    raster: Raster,
    texels: &'a [T],
    channels: usize,
    seam: Seam,
}

impl<'a, T: Texel> Source<'a, T> {
    /// An image of a map: its shape without channels, and its texels, a row of channels each.
    pub fn new(map: &'a Map, shape: &'a [usize], texels: ArrayView2<'a, T>) -> Result<Self, Error> {
        struct GetSeam;
        impl Visitor for GetSeam {
            type Output = Seam;
            fn visit<P: Projection>(self, p: P) -> Seam {
                p.seam()
            }
        }
        let raster = Raster::new(map, shape)?;
        let channels = texels.ncols();
        let texels = texels
            .to_slice()
            .filter(|_| texels.nrows() == raster.texels() && channels > 0)
            .ok_or_else(|| {
                Error::Shape(format!(
                    "Expected {} texels of at least one channel, one after the other, got {:?}.",
                    raster.texels(),
                    texels.dim()
                ))
            })?;
        Ok(Source {
            map,
            shape,
            raster,
            texels,
            channels,
            seam: map.visit_canonical(GetSeam),
        })
    }

    /// The map that the image is in.
    pub fn map(&self) -> &'a Map {
        self.map
    }

    /// Its shape, without channels.
    pub fn shape(&self) -> &'a [usize] {
        self.shape
    }

    /// Its texels, a row of channels each.
    pub fn texels(&self) -> &'a [T] {
        self.texels
    }

    /// The geometry of the image.
    pub fn raster(&self) -> &Raster {
        &self.raster
    }

    /// Looks up world directions: three numbers each in, `channels` texels each out.
    pub fn sample<R: Scalar>(
        &self,
        rotation: Option<DMat3>,
        filter: Filter,
        fill: &[T],
        directions: &[R],
        out: &mut [T],
    ) {
        let turn = self.map.view_rotation(rotation);
        threads::blocks(directions, 3, out, self.channels, |directions, out| {
            let mut lookups = Lookups::new(self, filter, fill);
            for (tile, directions) in directions.chunks(3 * TILE).enumerate() {
                self.map.visit_canonical(EncodeTile {
                    turn,
                    input: Tuples::of(directions),
                    output: lookups.tile(),
                });
                lookups.place(directions.len() / 3);
                let area = Area {
                    start: tile * TILE,
                    columns: TILE,
                    stride: TILE,
                };
                lookups.push(out, area);
            }
            lookups.finish(out);
        });
    }

    fn stored(&self) -> Stored<'_, T> {
        Stored {
            raster: &self.raster,
            texels: self.texels,
            channels: self.channels,
        }
    }

    /// Within this distance from a disk's center all texels that a filter reaches are valid.
    fn safe(&self, reach: Support) -> f64 {
        if self.raster.outline != Outline::Disk {
            return f64::INFINITY;
        }
        let spacing = 2.0
            / (self
                .raster
                .along_u
                .index()
                .0
                .min(self.raster.along_v.index().0));
        let texels = reach.shift.max(reach.after as f64);
        (1.0 - std::f64::consts::SQRT_2 * texels * spacing).max(0.0)
    }

    #[cold]
    #[inline(never)]
    fn at_edge<O: Filtered<T>>(&self, filter: Filter, face: usize, uv: [f64; 2], out: &mut [O]) {
        let mut taps = Taps::new();
        match filter {
            Filter::Nearest => {
                let index = self.nearest(face, uv) * self.channels;
                for (out, &texel) in out.iter_mut().zip(&self.texels[index..]) {
                    *out = O::exact(texel);
                }
                return;
            }
            Filter::Bilinear => self.resolve(&mut taps, face, uv, 1.0),
            Filter::CatmullRom => self.window(&mut taps, face, uv, CatmullRom::weights),
            Filter::Mitchell => self.window(&mut taps, face, uv, Mitchell::weights),
            Filter::Lanczos3 => self.window(&mut taps, face, uv, Lanczos3::weights),
        }
        self.weigh(&taps, out);
    }

    /// The sum of texels by their weights, which add up to 1.
    fn weigh<O: Filtered<T>>(&self, taps: &Taps, out: &mut [O]) {
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

/// Lookups tile by tile: the texels of one are asked for while those of the one before are weighted.
pub struct Lookups<'s, 'a, T: Texel, O, R> {
    source: &'s Source<'a, T>,
    filter: Filter,
    fill: &'s [O],
    queue: [Queued<T::Float, R>; 2],
    current: usize,
}

struct Queued<F, R> {
    places: Places<F>,
    all_inside: bool,
    uv: Tile<R, 3>,
    area: Area,
    length: usize,
}

/// The rectangle of a band of stored texels that a tile of lookups fills, row by row.
#[derive(Clone, Copy, Debug)]
pub struct Area {
    /// Its first texel.
    pub start: usize,
    /// Texels in a row; at least one.
    pub columns: usize,
    /// Texels from one row to the next.
    pub stride: usize,
}

impl<'s, 'a, T: Texel, O: Filtered<T>, R: Scalar> Lookups<'s, 'a, T, O, R> {
    /// Lookups in an image. Where it holds nothing, the result is `fill`.
    pub fn new(source: &'s Source<'a, T>, filter: Filter, fill: &'s [O]) -> Self {
        let queued = || Queued {
            places: Places::new(),
            all_inside: false,
            uv: Tile::new(),
            area: Area {
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
        }
    }

    /// The canonical (u, v, face) of the next tile, to be written.
    pub fn tile(&mut self) -> &mut Tile<R, 3> {
        &mut self.queue[1 - self.current].uv
    }

    /// Those of the tile that was pushed last.
    pub fn pushed(&self) -> &Tile<R, 3> {
        &self.queue[self.current].uv
    }

    /// Finds the texels around the first `count` places of the next tile. Returns whether none of them lies at an edge or
    /// nowhere.
    pub fn place(&mut self, count: usize) -> bool {
        let source = self.source;
        let reach = self.filter.reach();
        let next = &mut self.queue[1 - self.current];
        next.all_inside = next.places.set(
            (&source.raster, source.channels),
            reach,
            source.safe(reach),
            &next.uv,
            count,
        );
        if source.raster.outline == Outline::Shape {
            next.all_inside = next
                .places
                .leave_out_rim(&source.raster, reach, &next.uv, count);
        }
        next.length = count;
        next.all_inside
    }

    /// Looks the places that were found up, into an area of `band`: at the next call.
    pub fn push(&mut self, band: &mut [O], area: Area) {
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
    fn gather(&self, band: &mut [O]) {
        match self.filter {
            Filter::Nearest => self.weigh::<Nearest>(band),
            Filter::Bilinear => self.weigh::<Bilinear>(band),
            Filter::CatmullRom => self.weigh::<Separable<CatmullRom, 4>>(band),
            Filter::Mitchell => self.weigh::<Separable<Mitchell, 4>>(band),
            Filter::Lanczos3 => self.weigh::<Separable<Lanczos3, 6>>(band),
        }
    }

    fn weigh<G: Gather<T>>(&self, band: &mut [O]) {
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
            edge: |k: usize, out: &mut [O]| {
                let [u, v, face] = tile.uv.at(k).map(Real::to_f64);
                if u.is_nan() {
                    out.copy_from_slice(self.fill);
                } else {
                    source.at_edge(self.filter, face as usize, [u, v], out);
                }
            },
        };
        work.run::<G>();
    }
}
