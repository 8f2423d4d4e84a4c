//! What lies beyond an edge.
//!
//! A texel that the image does not hold is given as stored texels with weights: the same row half a turn around, the
//! mirrored edge of an octahedron, the neighbor face of a cube, the far side of a mirror ball's rim.
//!
//! - Latitude-longitude and octahedral maps: exactly a texel of the image, so that every filter is as good
//!   across the seam as elsewhere.
//! - Faces: the image at the place of the direction that this face's formula, continued, gives; cubic along
//!   both sides of the neighbor, from texels inside it. Bilinear lookups have a rule of their own (`edges`).
//! - Disks: interpolated along the meridian, between the nearest places on both sides of the rim that have all
//!   four texels: of second order.
//! - Mirrored rims and the cuts of a net: bilinear at the place where the projection says that the image goes on; texels
//!   there that hold nothing are beyond the rim again, and go on where they came from.
//! - Where the coverage ends, the nearest texel.

use super::edges::FaceEdge;
use super::place::Support;
use super::taps::Taps;
use super::texture::Texture;
use crate::image::rim::nearest_valid_texel;
use crate::image::texel::Texel;
use crate::map::grid::GridAxis;
use crate::number::angle;
use crate::projections::projection::Visitor;
use crate::projections::projection::one;
use crate::projections::projection::{Outline, Projection, Seam, Uv};
use crate::resample::seam::{Continued, Side, continued};

/// How often a place may go back and forth over a mirrored rim before its nearest texel is taken. Each time leaves half of
/// the weight or less, but beside poles.
const CROSSINGS: u8 = 4;

/// Less than this part of a texel beyond a rim takes the nearest texel at once.
const LITTLE: f64 = 1.0 / 128.0;

impl<T: Texel> Texture<'_, T> {
    /// The texel nearest to a place that its own index does not give.
    pub(crate) fn nearest(&self, face: usize, [u, v]: [f64; 2]) -> usize {
        let raster = &self.raster;
        let texel = |u: f64, v: f64| {
            let clamp = |(scale, offset): (f64, f64), x: f64, n: usize| {
                ((x * scale + offset + 0.5).floor() as isize).clamp(0, n as isize - 1)
            };
            (
                clamp(raster.along_u.index(), u, raster.width),
                clamp(raster.along_v.index(), v, raster.height),
            )
        };
        let (mut i, mut j) = texel(u, v);
        if raster.outline == Outline::Disk && !raster.holds(i, j) {
            // Half a texel's diagonal inside the rim every texel has its center inside.
            let (p, q) = (2.0 * u - 1.0, 2.0 * v - 1.0);
            let inside = (1.0 + self.safe(Support::PAIR)) / (2.0 * (p * p + q * q).sqrt());
            let within = texel(0.5 + 0.5 * p * inside, 0.5 + 0.5 * q * inside);
            if raster.holds(within.0, within.1) {
                (i, j) = within;
            }
        }
        // Of other outlines, and of a few texels, of which none lies half a diagonal inside.
        let (i, j) = nearest_valid_texel(raster, i as usize, j as usize);
        raster.view(face).index(i, j)
    }

    /// Adds the texels of a separable kernel around a place.
    pub(crate) fn window<const TAPS: usize>(
        &self,
        taps: &mut Taps,
        face: usize,
        uv: [f64; 2],
        weights: impl Fn(f64) -> [f64; TAPS],
    ) {
        let [x, y] = self.place(uv);
        let (left, top) = (x.floor(), y.floor());
        let (across, down) = (weights(x - left), weights(y - top));
        let before = TAPS as isize / 2 - 1;
        for (r, down) in down.into_iter().enumerate() {
            for (t, across) in across.into_iter().enumerate() {
                let i = left as isize + t as isize - before;
                let j = top as isize + r as isize - before;
                if self.raster.holds(i, j) {
                    let index = self.raster.view(face).index(i as usize, j as usize);
                    taps.push(index, across * down);
                } else {
                    self.beyond(taps, face, i, j, across * down);
                }
            }
        }
    }

    /// A place in texels: 0 at the first center, `width - 1` at the last.
    pub(crate) fn place(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let ((su, ou), (sv, ov)) = (self.raster.along_u.index(), self.raster.along_v.index());
        [u * su + ou, v * sv + ov]
    }

    /// Adds what stands for a place near an edge.
    pub(crate) fn resolve(&self, taps: &mut Taps, face: usize, uv: [f64; 2], weight: f64) {
        if self.seam == Seam::Faces {
            return FaceEdge {
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
    pub(crate) fn beyond(&self, taps: &mut Taps, face: usize, i: isize, j: isize, weight: f64) {
        match self.seam {
            Seam::RimMirrored | Seam::Cuts => {
                let place = (face, i, j);
                let find = || {
                    let mut taps = Taps::new();
                    self.elsewhere(&mut taps, place, 1.0, CROSSINGS);
                    taps.by_texel()
                };
                (self.continuations)
                    .of(place, find, |texel, share| taps.push(texel, weight * share));
            }
            _ if self.raster.outline == Outline::Disk => {
                self.across_rim(taps, face, i, j, weight);
            }
            _ if self.raster.outline == Outline::Shape => self.held(taps, face, i, j, weight),
            Seam::Faces => {
                let center = |axis: GridAxis, i: isize| axis.center(i as f64);
                let uv = Uv {
                    u: center(self.raster.along_u, i),
                    v: center(self.raster.along_v, j),
                    face: face as f64,
                };
                let there = self.map.visit_canonical(Continue(uv));
                self.cubic(taps, there.face as usize, [there.u, there.v], weight);
            }
            seam => {
                let sides =
                    [self.raster.width, self.raster.height].map(|n| Side { n, on_edges: false });
                let view = self.raster.view(face);
                // One image beyond an edge is as far as footprints on the smallest mip levels go: the rest of
                // them is its far edge. Around, they may go as often as they like.
                let near = |i: isize, n: usize| i.clamp(-(n as isize), 2 * n as isize - 1);
                let j = near(j, self.raster.height);
                let i = match seam {
                    Seam::Octahedral => near(i, self.raster.width),
                    _ => i,
                };
                match continued(seam, sides, [i, j]) {
                    Some(Continued::Texel([i, j])) => taps.push(view.index(i, j), weight),
                    Some(Continued::Between(pair)) => {
                        for [i, j] in pair {
                            taps.push(view.index(i, j), 0.5 * weight);
                        }
                    }
                    None => self.held(taps, face, i, j, weight),
                }
            }
        }
    }

    /// Adds a place by cubic interpolation from texels of its own face, wherever it lies on it.
    fn cubic(&self, taps: &mut Taps, face: usize, uv: [f64; 2], weight: f64) {
        let [x, y] = self.place(uv);
        let (first, across) = lagrange(x, self.raster.width);
        let (top, down) = lagrange(y, self.raster.height);
        for (r, down) in down.into_iter().enumerate() {
            for (t, across) in across.into_iter().enumerate() {
                if across * down != 0.0 {
                    let index = self.raster.view(face).index(first + t, top + r);
                    taps.push(index, weight * across * down);
                }
            }
        }
    }

    /// Adds a texel, or the nearest that holds a value.
    fn held(&self, taps: &mut Taps, face: usize, i: isize, j: isize, weight: f64) {
        let inside = |i: isize, n: usize| i.clamp(0, n as isize - 1) as usize;
        let (i, j) = (inside(i, self.raster.width), inside(j, self.raster.height));
        let (i, j) = nearest_valid_texel(&self.raster, i, j);
        taps.push(self.raster.view(face).index(i, j), weight);
    }

    /// Adds a texel beyond a rim or a cut: the image where the projection says that it goes on, bilinear. What of that
    /// lies beyond a rim again goes on where it came from, so that a place between the last texels of both sides gets
    /// what a line through them gives.
    fn elsewhere(
        &self,
        taps: &mut Taps,
        (face, i, j): (usize, isize, isize),
        weight: f64,
        crossings: u8,
    ) {
        let there = self.map.visit_canonical(Continue(Uv {
            u: self.raster.along_u.center(i as f64),
            v: self.raster.along_v.center(j as f64),
            face: face as f64,
        }));
        if there.u.is_nan() {
            return self.held(taps, face, i, j, weight);
        }
        let face = there.face as usize;
        let place = self.place([there.u, there.v]);
        self.four(taps, face, place, weight, |taps, i, j, weight| {
            if crossings > 0 && weight > LITTLE {
                self.elsewhere(taps, (face, i, j), weight, crossings - 1);
            } else {
                self.held(taps, face, i, j, weight);
            }
        });
    }

    /// Adds a texel beyond the rim of a disk: interpolated along its meridian, between the nearest
    /// places on both sides of the rim that have all four texels.
    fn across_rim(&self, taps: &mut Taps, face: usize, i: isize, j: isize, weight: f64) {
        let p = 2.0 * self.raster.along_u.center(i as f64) - 1.0;
        let q = 2.0 * self.raster.along_v.center(j as f64) - 1.0;
        let r = (p * p + q * q).sqrt();
        let (cos, sin) = (p / r, q / r);
        let at = |r: f64| self.place([0.5 + 0.5 * r * cos, 0.5 + 0.5 * r * sin]);
        let flipped = |r: f64| self.place([0.5 - 0.5 * r * cos, 0.5 + 0.5 * r * sin]);
        // All four are valid there, but for a share of rounding.
        let add = |taps: &mut Taps, face, place, weight| {
            self.four(taps, face, place, weight, |_, _, _, _| ());
        };
        let near = self.safe(Support::PAIR);
        let (face_across, across) = match self.seam {
            Seam::RimOpposite => (face, at(-near)),
            Seam::RimOtherFace => (1 - face, at(near)),
            Seam::RimOtherFaceFlipped => (1 - face, flipped(near)),
            _ => return add(taps, face, at(near), weight),
        };
        let angle = |r: f64| {
            let [x, y, z] = self
                .map
                .visit_canonical(Direction(Uv::flat(0.5 + 0.5 * r, 0.5)));
            angle::atan2(angle::length(x, y), z)
        };
        let (from, to) = (angle(near), angle(1.0));
        // As far beyond the rim as the mirrored place is before it.
        let beyond = 2.0 * to - angle((2.0 - r).clamp(near, 1.0));
        let share = ((beyond - from) / (2.0 * (to - from))).clamp(0.0, 1.0);
        add(taps, face, at(near), weight * (1.0 - share));
        add(taps, face_across, across, weight * share);
    }
}

/// The first of up to four of `n` nodes around x, and the weights of the polynomial through them.
fn lagrange(x: f64, n: usize) -> (usize, [f64; 4]) {
    let count = n.min(4);
    let first = (x.floor() - 1.0).clamp(0.0, (n - count) as f64);
    let x = x - first;
    let mut weights = [0.0; 4];
    for (k, weight) in weights.iter_mut().enumerate().take(count) {
        *weight = (0..count)
            .filter(|&m| m != k)
            .map(|m| (x - m as f64) / (k as f64 - m as f64))
            .product();
    }
    (first as usize, weights)
}

struct Direction(Uv<f64>);

impl Visitor for Direction {
    type Output = [f64; 3];
    fn visit<P: Projection>(self, p: P) -> [f64; 3] {
        one::decode(p, self.0)
    }
}

/// The place that the image continues with beyond a face.
struct Continue(Uv<f64>);

impl Visitor for Continue {
    type Output = Uv<f64>;
    fn visit<P: Projection>(self, p: P) -> Uv<f64> {
        p.beyond(self.0)
    }
}
