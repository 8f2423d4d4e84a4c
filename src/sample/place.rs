//! From image coordinates to texels: which ones, and how far between them.
//!
//! A block of coordinates becomes rows of indices and fractions in one vectorised loop, so that the loop that
//! gathers does nothing else, and so that texels can be asked for before they are needed.

use super::TILE;
use crate::faces::MAX_FACES;
use crate::image::{FaceView, Raster};
use crate::kernel::{Scalar, vectorize};
use crate::real::Real;

/// Windows of texels for up to [`TILE`] coordinates.
pub(crate) struct Places<F> {
    /// The number, in the image, of the first texel of the window.
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
pub(crate) struct Reach {
    /// ½ where the nearest texel is meant and 0 where the one at the upper left.
    pub(crate) shift: f64,
    /// Texels to the left of (i, j).
    pub(crate) before: usize,
    /// Texels to the right of it.
    pub(crate) after: usize,
}

impl Reach {
    /// A texel and the next one.
    pub(crate) const PAIR: Reach = Reach {
        shift: 0.0,
        before: 0,
        after: 1,
    };
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

    /// Takes over canonical (u, v, face). Returns whether all are inside.
    pub(crate) fn set<R: Scalar>(
        &mut self,
        raster: &Raster,
        reach: Reach,
        safe: f64,
        uv: &[[R; 3]],
    ) -> bool {
        let uv = &uv[..uv.len().min(TILE)];
        vectorize(
            #[inline(always)]
            || {
                let ((su, ou), (sv, ov)) = (raster.along_u.index(), raster.along_v.index());
                let (su, ou) = (R::new(su), R::new(ou + reach.shift));
                let (sv, ov) = (R::new(sv), R::new(ov + reach.shift));
                let low = R::new(reach.before as f64);
                // Beyond a quarter of 1/ε an index does not fit its bits: what lies there takes the long way.
                let last =
                    |n: usize| R::new((n as f64 - 1.0 - reach.after as f64).min(0.25 / R::EPSILON));
                let (right, bottom) = (last(raster.width), last(raster.height));
                let safe = R::new(safe * safe);
                let (one, two) = (R::new(1.0), R::new(2.0));
                let mut all = true;
                let (mut i, mut j) = ([0_i32; TILE], [0_i32; TILE]);
                for (k, uv) in uv.iter().enumerate() {
                    let (u, v) = (uv[0], uv[1]);
                    let (x, y) = (u * su + ou, v * sv + ov);
                    let (left, top) = (Real::floor(x), Real::floor(y));
                    let (p, q) = (two * u - one, two * v - one);
                    let inside = (left >= low)
                        & (left <= right)
                        & (top >= low)
                        & (top <= bottom)
                        & (p * p + q * q <= safe);
                    i[k] = left.whole();
                    j[k] = top.whole();
                    self.face[k] = uv[2].whole() as u8;
                    self.tx[k] = F::new((x - left).to_f64());
                    self.ty[k] = F::new((y - top).to_f64());
                    self.inside[k] = inside;
                    all &= inside;
                }
                let (views, before) = (raster.views(), reach.before as isize);
                let number = |view: &FaceView, k: usize| {
                    view.number(i[k] as isize - before, j[k] as isize - before)
                };
                if raster.faces() == 1 {
                    let view = views[0];
                    for k in 0..uv.len() {
                        self.first[k] = number(&view, k);
                    }
                } else {
                    for k in 0..uv.len() {
                        self.first[k] = number(&views[self.face[k] as usize % MAX_FACES], k);
                    }
                }
                all
            },
        )
    }

    /// Takes out lookups that need a texel whose centre lies outside an outline of any shape. Returns whether all are
    /// inside. It looks at every texel of a window: valid corners of one say nothing of a notch.
    pub(crate) fn leave_out_rim<R: Scalar>(
        &mut self,
        raster: &Raster,
        reach: Reach,
        uv: &[[R; 3]],
    ) -> bool {
        let ((su, ou), (sv, ov)) = (raster.along_u.index(), raster.along_v.index());
        let (before, after) = (reach.before as isize, reach.after as isize);
        let mut all = true;
        for (inside, uv) in self.inside.iter_mut().zip(uv) {
            if *inside {
                let at = |x: R, scale: f64, offset: f64| {
                    (x.to_f64() * scale + offset + reach.shift).floor() as isize
                };
                let (i, j) = (at(uv[0], su, ou), at(uv[1], sv, ov));
                let row = |j: isize| (i - before..=i + after).all(|i| raster.holds(i, j));
                *inside = (j - before..=j + after).all(row);
            }
            all &= *inside;
        }
        all
    }
}
