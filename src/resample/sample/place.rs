//! From image coordinates to texels: which ones, and how far between them.
//!
//! A tile of coordinates becomes rows of indices and fractions in vectorized loops, so that the loop that
//! gathers does nothing else, and so that texels can be asked for before they are needed. Each loop does one thing, and only
//! for what needs it: fractions for filters, a disk's rim for disks, faces where there are several.

use crate::image::raster::{FaceView, Raster};
use crate::kernel::tile::W;
use crate::kernel::tile::{TILE, Tile};
use crate::kernel::{Scalar, vectorize};
use crate::number::real::Real;
use crate::projections::faces::MAX_FACES;

/// Windows of texels for up to [`TILE`] coordinates.
pub(crate) struct Places<F> {
    /// Where the window begins among the image's numbers.
    pub(crate) first: [usize; TILE],
    /// How far the place lies to the right of the texel that is meant or on its left.
    pub(crate) tx: [F; TILE],
    /// How far it lies below the texel that is meant or above it.
    pub(crate) ty: [F; TILE],
    /// The face.
    pub(crate) face: [u8; TILE],
    /// Whether all texels that the filter needs are on the face and valid. Where they are not, all else
    /// means nothing.
    pub(crate) inside: [bool; TILE],
}

/// Which texels a filter needs around a place.
#[derive(Clone, Copy)]
pub(crate) struct Support {
    /// ½ where the nearest texel is meant and 0 where the one at the upper left.
    pub(crate) shift: f64,
    /// Texels to the left of (i, j).
    pub(crate) before: usize,
    /// Texels to the right of it.
    pub(crate) after: usize,
}

impl Support {
    /// The texel that holds the place.
    pub(crate) const NEAREST: Support = Support {
        shift: 0.5,
        before: 0,
        after: 0,
    };

    /// A texel and the next one.
    pub(crate) const PAIR: Support = Support::of(2);

    /// So many texels, an even number, in the middle of which the place is.
    pub(crate) const fn of(taps: usize) -> Support {
        Support {
            shift: 0.0,
            before: taps / 2 - 1,
            after: taps / 2,
        }
    }
}

/// How to get from the texel that a place is in, (i, j) of a face, to the first number of its window.
#[derive(Clone, Copy, Default)]
struct Steps {
    start: i64,
    right: i32,
    down: i32,
}

impl Steps {
    /// None for rows of more than 2³¹ numbers.
    fn new(view: &FaceView, reach: Support, channels: usize) -> Option<Steps> {
        let channels = channels as i64;
        let [right, down] = view.steps().map(|step| step as i64 * channels);
        let start = view.index(0, 0) as i64 * channels;
        Some(Steps {
            start: start - reach.before as i64 * (right + down),
            right: i32::try_from(right).ok()?,
            down: i32::try_from(down).ok()?,
        })
    }

    /// What lies off the face means nothing. (Products of two i32: CPUs have no quick one of two i64.)
    #[inline(always)]
    fn to(self, i: i32, j: i32) -> usize {
        let right = i64::from(i) * i64::from(self.right);
        let down = i64::from(j) * i64::from(self.down);
        self.start.wrapping_add(right).wrapping_add(down) as usize
    }
}

impl<F: Scalar> Places<F> {
    pub(crate) fn new() -> Self {
        let zero = F::default();
        Places {
            first: [0; TILE],
            face: [0; TILE],
            tx: [zero; TILE],
            ty: [zero; TILE],
            inside: [false; TILE],
        }
    }

    /// Takes over the first `count` canonical (u, v, face) of a tile, for an image with so many channels. Returns whether
    /// all are inside.
    pub(crate) fn set<R: Scalar>(
        &mut self,
        (raster, channels): (&Raster, usize),
        reach: Support,
        safe: f64,
        Tile([us, vs, faces]): &Tile<R, 3>,
        count: usize,
    ) -> bool {
        let count = count.min(TILE);
        let mut steps = [Steps::default(); MAX_FACES];
        for (steps, view) in steps.iter_mut().zip(&raster.views()[..raster.faces()]) {
            let Some(new) = Steps::new(view, reach, channels) else {
                self.inside.fill(false);
                return false;
            };
            *steps = new;
        }
        vectorize(
            #[inline(always)]
            || {
                let ((su, ou), (sv, ov)) = (raster.along_u.index(), raster.along_v.index());
                let (su, ou) = (R::new(su), R::new(ou + reach.shift));
                let (sv, ov) = (R::new(sv), R::new(ov + reach.shift));
                let low = R::new(reach.before as f64);
                // Beyond a quarter of 1/ε an index does not fit its bits: what lies there takes the long way.
                let last = |n: usize| {
                    R::new((n as f64 - 1.0 - reach.after as f64).min(0.25 / R::epsilon()))
                };
                let (right, bottom) = (last(raster.width), last(raster.height));
                let (mut i, mut j) = ([0_i32; TILE], [0_i32; TILE]);
                // Whole chunks, for a loop without an end of its own; what lies behind the places means nothing.
                let whole = count.next_multiple_of(W);
                let into = i[..whole].iter_mut().zip(&mut j[..whole]);
                let into = into.zip(&mut self.inside[..whole]);
                for (((i, j), inside), (&u, &v)) in into.zip(us.iter().zip(vs)) {
                    let left = Real::floor(u * su + ou);
                    let top = Real::floor(v * sv + ov);
                    (*i, *j) = (left.whole(), top.whole());
                    *inside = (left >= low) & (left <= right) & (top >= low) & (top <= bottom);
                }
                if reach.after > 0 {
                    let into = self.tx[..whole].iter_mut().zip(&mut self.ty[..whole]);
                    for ((tx, ty), (&u, &v)) in into.zip(us.iter().zip(vs)) {
                        let (x, y) = (u * su + ou, v * sv + ov);
                        *tx = F::new((x - Real::floor(x)).to_f64());
                        *ty = F::new((y - Real::floor(y)).to_f64());
                    }
                }
                if safe < f64::INFINITY {
                    let (safe, one, two) = (R::new(safe * safe), R::ONE, R::TWO);
                    for k in 0..count {
                        let (p, q) = (two * us[k] - one, two * vs[k] - one);
                        self.inside[k] &= p * p + q * q <= safe;
                    }
                }
                let mut face = 0;
                let mut several = false;
                if raster.faces() > 1 {
                    for (face, number) in self.face[..count].iter_mut().zip(faces) {
                        *face = number.whole() as u8;
                    }
                    face = self.face[0];
                    for k in 0..count {
                        several |= self.face[k] != face;
                    }
                }
                let into = self.first[..whole].iter_mut().zip(i.iter().zip(&j));
                if several {
                    for ((first, (&i, &j)), &face) in into.zip(&self.face) {
                        *first = steps[usize::from(face).min(MAX_FACES - 1)].to(i, j);
                    }
                } else {
                    let steps = steps[usize::from(face).min(MAX_FACES - 1)];
                    for (first, (&i, &j)) in into {
                        *first = steps.to(i, j);
                    }
                }
                let mut all = true;
                for k in 0..count {
                    all &= self.inside[k];
                }
                all
            },
        )
    }

    /// Takes out lookups that need a texel whose center lies outside an outline of any shape. Returns whether all are
    /// inside. Where they may not be, it looks at every texel of a window: valid corners of one say nothing of a notch.
    pub(crate) fn leave_out_rim<R: Scalar>(
        &mut self,
        raster: &Raster,
        reach: Support,
        Tile([us, vs, _]): &Tile<R, 3>,
        count: usize,
    ) -> bool {
        let ((su, ou), (sv, ov)) = (raster.along_u.index(), raster.along_v.index());
        let (before, after) = (reach.before as isize, reach.after as isize);
        // How far the texels of a window may be from its place.
        let window = [su, sv].map(|scale| reach.after.max(1) as f64 / scale);
        let mut all = true;
        for (k, inside) in self.inside[..count].iter_mut().enumerate() {
            let place = [us[k], vs[k]].map(Scalar::to_f64);
            if *inside && !raster.holds_around(place, window) {
                let at = |x: f64, scale: f64, offset: f64| {
                    (x * scale + offset + reach.shift).floor() as isize
                };
                let (i, j) = (at(place[0], su, ou), at(place[1], sv, ov));
                let row = |j: isize| (i - before..=i + after).all(|i| raster.holds(i, j));
                *inside = (j - before..=j + after).all(row);
            }
            all &= *inside;
        }
        all
    }
}
