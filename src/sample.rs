//! Looking directions up in an image.
//!
//! Nearly every lookup has its four texels inside one face and takes the short way. The others meet an
//! edge, and what lies beyond is the projection's [`Seam`]: the same row half a turn around, the mirrored edge of
//! an octahedron, the neighbour face of a cube, the far side of a mirror ball's rim. Such a lookup is
//! resolved, in f64, into a list of stored texels with weights that sum to 1, and the result is
//! base + Σ w (texel - base): a constant image stays constant to the bit, here as on the short way.
//!
//! Texels whose centre lies outside the valid image (the corners around a disk, where photographers
//! print their credits; the empty cells of a cross) never take part.
//!
//! Cubes have rules of their own, in `edges`. A texel beyond a disk's rim is interpolated along its meridian
//! between the nearest places on both sides that have all four texels. What did not help: continuing
//! the image by its nearest texels (an error of first order at every seam), and a padded copy of the
//! source (a copy a call, for the few lookups that need it).

use crate::edges;
use crate::error::Error;
use crate::image::{Raster, Texel};
use crate::kernel::Scalar;
use crate::map::{EncodeCanonical, Map};
use crate::projection::{Projection, Seam, Uv};
use crate::projections::Visitor;
use crate::real::Real;
use crate::threads;
use glam::DMat3;
use ndarray::ArrayView2;

/// How a value is taken from texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// The texel that holds the place.
    Nearest,
    /// The four texels around it.
    Bilinear,
}

impl Filter {
    /// All names.
    pub const NAMES: [&'static str; 2] = ["nearest", "bilinear"];

    /// The filter of this name.
    pub fn find(name: &str) -> Result<Filter, Error> {
        match name {
            "nearest" => Ok(Filter::Nearest),
            "bilinear" => Ok(Filter::Bilinear),
            _ => Err(Error::unknown("filter", name, &Self::NAMES)),
        }
    }
}

/// Points that are encoded before they are looked up: small enough for the first-level cache.
pub const TILE: usize = 256;

/// An image that can be looked up.
#[derive(Clone, Copy)]
pub struct Source<'a, T> {
    map: &'a Map,
    raster: Raster,
    texels: &'a [T],
    channels: usize,
    seam: Seam,
    /// Within this distance from a disk's centre all four texels are valid.
    safe: f64,
}

/// Stored texels and their weights.
pub(crate) struct Taps {
    list: [(usize, f64); 48],
    count: usize,
}

impl Taps {
    pub(crate) fn push(&mut self, index: usize, weight: f64) {
        if weight != 0.0 && self.count < self.list.len() {
            self.list[self.count] = (index, weight);
            self.count += 1;
        }
    }
}

impl<'a, T: Texel> Source<'a, T> {
    /// An image of a map: its shape without channels, and its texels, a row of channels each.
    pub fn new(map: &'a Map, shape: &[usize], texels: ArrayView2<'a, T>) -> Result<Self, Error> {
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
        let spacing = 2.0 / (raster.along_u.index().0.min(raster.along_v.index().0));
        Ok(Source {
            map,
            raster,
            texels,
            channels,
            seam: map.visit_canonical(GetSeam),
            safe: (1.0 - std::f64::consts::SQRT_2 * spacing).max(0.0),
        })
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
        let turn = self.map.turn(rotation);
        threads::blocks(directions, 3, out, self.channels, |directions, out| {
            let mut uv = [R::default(); 3 * TILE];
            for (d, out) in directions
                .chunks(3 * TILE)
                .zip(out.chunks_mut(TILE * self.channels))
            {
                let uv = &mut uv[..d.len()];
                self.map.visit_canonical(EncodeCanonical {
                    turn,
                    input: d,
                    output: uv,
                });
                self.lookup(filter, fill, uv, out);
            }
        });
    }

    /// Looks up canonical (u, v, face).
    pub fn lookup<R: Scalar>(&self, filter: Filter, fill: &[T], uv: &[R], out: &mut [T]) {
        match (filter, self.channels) {
            (Filter::Nearest, _) => self.nearest(fill, uv, out),
            (Filter::Bilinear, 1) => self.bilinear::<R, 1>(fill, uv, out),
            (Filter::Bilinear, 3) => self.bilinear::<R, 3>(fill, uv, out),
            (Filter::Bilinear, 4) => self.bilinear::<R, 4>(fill, uv, out),
            (Filter::Bilinear, _) => self.bilinear::<R, 0>(fill, uv, out),
        }
    }

    fn nearest<R: Scalar>(&self, fill: &[T], uv: &[R], out: &mut [T]) {
        let c = self.channels;
        for (uv, out) in uv.chunks_exact(3).zip(out.chunks_exact_mut(c)) {
            let (u, v) = (uv[0].to_f64(), uv[1].to_f64());
            if u.is_nan() {
                out.copy_from_slice(fill);
                continue;
            }
            let face = uv[2].to_f64() as usize;
            let (mut i, mut j) = self.nearest_texel(u, v);
            if !self.raster.holds(i, j) {
                // Half a texel's diagonal inside the rim every texel has its centre inside.
                let (p, q) = (2.0 * u - 1.0, 2.0 * v - 1.0);
                let inside = (1.0 + self.safe) / (2.0 * (p * p + q * q).sqrt());
                (i, j) = self.nearest_texel(0.5 + 0.5 * p * inside, 0.5 + 0.5 * q * inside);
            }
            let index = self.raster.view(face).index(i as usize, j as usize) * c;
            out.copy_from_slice(&self.texels[index..index + c]);
        }
    }

    fn nearest_texel(&self, u: f64, v: f64) -> (isize, isize) {
        let clamp = |(scale, offset): (f64, f64), x: f64, n: usize| {
            ((x * scale + offset + 0.5).floor() as isize).clamp(0, n as isize - 1)
        };
        let raster = &self.raster;
        (
            clamp(raster.along_u.index(), u, raster.width),
            clamp(raster.along_v.index(), v, raster.height),
        )
    }

    /// CHANNELS is 0 where their number is known at run time only.
    fn bilinear<R: Scalar, const CHANNELS: usize>(&self, fill: &[T], uv: &[R], out: &mut [T]) {
        let c = if CHANNELS == 0 {
            self.channels
        } else {
            CHANNELS
        };
        let (w, h) = (self.raster.width as f64, self.raster.height as f64);
        let ((su, ou), (sv, ov)) = (self.raster.along_u.index(), self.raster.along_v.index());
        let safe = if self.raster.disk {
            self.safe * self.safe
        } else {
            f64::INFINITY
        };
        for (uv, out) in uv.chunks_exact(3).zip(out.chunks_exact_mut(c)) {
            let (u, v) = (uv[0].to_f64(), uv[1].to_f64());
            let (x, y) = (u * su + ou, v * sv + ov);
            let (left, top) = (x.floor(), y.floor());
            let (p, q) = (2.0 * u - 1.0, 2.0 * v - 1.0);
            let inside = left >= 0.0 && left < w - 1.0 && top >= 0.0 && top < h - 1.0;
            if inside && p * p + q * q <= safe {
                let view = self.raster.view(uv[2].to_f64() as usize);
                let (i, j) = (left as usize, top as usize);
                let at = |i, j| &self.texels[view.index(i, j) * c..][..c];
                let taps = [at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)];
                let (tx, ty) = (T::Float::new(x - left), T::Float::new(y - top));
                for k in 0..c {
                    let [a, b, c, d] = taps.map(|tap| tap[k].load());
                    let upper = a + tx * (b - a);
                    let lower = c + tx * (d - c);
                    out[k] = T::store(upper + ty * (lower - upper));
                }
            } else if u.is_nan() {
                out.copy_from_slice(fill);
            } else {
                self.at_edge(uv[2].to_f64() as usize, [u, v], out);
            }
        }
    }

    #[cold]
    #[inline(never)]
    fn at_edge(&self, face: usize, uv: [f64; 2], out: &mut [T]) {
        let mut taps = Taps {
            list: [(0, 0.0); 48],
            count: 0,
        };
        self.resolve(&mut taps, face, uv, 1.0);
        let list = &taps.list[..taps.count];
        let heaviest = list
            .iter()
            .fold((0, 0.0), |a, b| if b.1 > a.1 { *b } else { a })
            .0;
        for (k, out) in out.iter_mut().enumerate() {
            let base = self.texels[heaviest * self.channels + k].load();
            let mut sum = T::Float::new(0.0);
            for &(index, weight) in list {
                let texel = self.texels[index * self.channels + k].load();
                sum = sum + T::Float::new(weight) * (texel - base);
            }
            *out = T::store(base + sum);
        }
    }

    /// A place in texels: 0 at the first centre, `width - 1` at the last.
    fn place(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let ((su, ou), (sv, ov)) = (self.raster.along_u.index(), self.raster.along_v.index());
        [u * su + ou, v * sv + ov]
    }

    /// Adds what stands for a place near an edge.
    fn resolve(&self, taps: &mut Taps, face: usize, uv: [f64; 2], weight: f64) {
        if self.seam == Seam::Faces {
            return edges::FaceEdge {
                raster: &self.raster,
                map: self.map,
            }
            .resolve(taps, face, self.place(uv), weight);
        }
        self.four(taps, face, self.place(uv), weight, |taps, i, j, weight| {
            self.beyond(taps, face, i, j, weight);
        });
    }

    /// Adds the four texels around a place; `beyond` stands in for those that the image does not hold.
    fn four(
        &self,
        taps: &mut Taps,
        face: usize,
        [x, y]: [f64; 2],
        weight: f64,
        beyond: impl Fn(&mut Taps, isize, isize, f64),
    ) {
        let (left, top) = (x.floor(), y.floor());
        let (tx, ty) = (x - left, y - top);
        for (di, dj, share) in [
            (0, 0, (1.0 - tx) * (1.0 - ty)),
            (1, 0, tx * (1.0 - ty)),
            (0, 1, (1.0 - tx) * ty),
            (1, 1, tx * ty),
        ] {
            let (i, j) = (left as isize + di, top as isize + dj);
            if share == 0.0 {
                continue;
            }
            if self.raster.holds(i, j) {
                let index = self.raster.view(face).index(i as usize, j as usize);
                taps.push(index, weight * share);
            } else {
                beyond(taps, i, j, weight * share);
            }
        }
    }

    /// Adds a texel that lies beyond an edge.
    fn beyond(&self, taps: &mut Taps, face: usize, i: isize, j: isize, weight: f64) {
        let (w, h) = (self.raster.width as isize, self.raster.height as isize);
        let stored = |i: isize, j: isize| {
            let (i, j) = (i.clamp(0, w - 1), j.clamp(0, h - 1));
            self.raster.view(face).index(i as usize, j as usize)
        };
        match self.seam {
            _ if self.raster.disk => self.across_rim(taps, face, i, j, weight),
            Seam::Latlong => {
                let wrapped = |i: isize| i.rem_euclid(w);
                if (0..h).contains(&j) {
                    return taps.push(stored(wrapped(i), j), weight);
                }
                let j = if j < 0 { -1 - j } else { 2 * h - 1 - j };
                // Half a turn around lies between two columns where their number is odd.
                let around = i + w / 2;
                if w % 2 == 0 {
                    taps.push(stored(wrapped(around), j), weight);
                } else {
                    taps.push(stored(wrapped(around), j), 0.5 * weight);
                    taps.push(stored(wrapped(around + 1), j), 0.5 * weight);
                }
            }
            Seam::Periodic => taps.push(stored(i.rem_euclid(w), j), weight),
            Seam::Octahedral => {
                let (mut i, mut j) = (i, j);
                if !(0..w).contains(&i) {
                    (i, j) = (if i < 0 { -1 - i } else { 2 * w - 1 - i }, h - 1 - j);
                }
                if !(0..h).contains(&j) {
                    (i, j) = (w - 1 - i, if j < 0 { -1 - j } else { 2 * h - 1 - j });
                }
                taps.push(stored(i, j), weight);
            }
            _ => taps.push(stored(i, j), weight),
        }
    }

    /// Adds a texel beyond the rim of a disk: interpolated along its meridian, between the nearest
    /// places on both sides of the rim that have all four texels.
    fn across_rim(&self, taps: &mut Taps, face: usize, i: isize, j: isize, weight: f64) {
        let p = 2.0 * self.raster.along_u.centre(i as f64) - 1.0;
        let q = 2.0 * self.raster.along_v.centre(j as f64) - 1.0;
        let r = (p * p + q * q).sqrt();
        let (cos, sin) = (p / r, q / r);
        let at = |r: f64| self.place([0.5 + 0.5 * r * cos, 0.5 + 0.5 * r * sin]);
        // All four are valid there, but for a share of rounding.
        let add = |taps: &mut Taps, face, place, weight| {
            self.four(taps, face, place, weight, |_, _, _, _| ());
        };
        let near = self.safe;
        let (face_across, across) = match self.seam {
            Seam::RimOpposite => (face, at(-near)),
            Seam::RimOtherFace => (1 - face, at(near)),
            _ => return add(taps, face, at(near), weight),
        };
        let angle = |r: f64| {
            let [x, y, z] = self
                .map
                .visit_canonical(Direction(Uv::flat(0.5 + 0.5 * r, 0.5)));
            x.hypot(y).atan2(z)
        };
        let (from, to) = (angle(near), angle(1.0));
        // As far beyond the rim as the mirrored place is before it.
        let beyond = 2.0 * to - angle((2.0 - r).clamp(near, 1.0));
        let share = ((beyond - from) / (2.0 * (to - from))).clamp(0.0, 1.0);
        add(taps, face, at(near), weight * (1.0 - share));
        add(taps, face_across, across, weight * share);
    }
}

struct Direction(Uv<f64>);

impl Visitor for Direction {
    type Output = [f64; 3];
    fn visit<P: Projection>(self, p: P) -> [f64; 3] {
        p.decode(self.0)
    }
}
