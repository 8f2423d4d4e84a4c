//! The density in directions.

use super::Distribution;
use crate::kernel::{Scalar, vectorize};
use crate::real::{Real, max, min};
use crate::sample::TILE;
use crate::threads;
use crate::verbs::EncodeCanonical;

impl Distribution {
    /// The density per steradian in world directions, three numbers each: 0 outside the coverage, NaN for
    /// what is no direction.
    pub fn pdf<R: Scalar>(&self, directions: &[R], out: &mut [R]) {
        threads::blocks(directions, 3, out, 1, |directions, out| {
            for (directions, out) in directions.chunks(3 * TILE).zip(out.chunks_mut(TILE)) {
                self.pdf_tile(directions, out);
            }
        });
    }

    fn pdf_tile<R: Scalar>(&self, directions: &[R], out: &mut [R]) {
        let mut uv = [R::default(); 3 * TILE];
        let uv = &mut uv[..directions.len()];
        self.map.visit_canonical(EncodeCanonical {
            turn: self.into_view,
            input: directions,
            output: uv,
        });
        let places = uv.as_chunks::<3>().0;
        let missing = vectorize(
            #[inline(always)]
            || self.gather(places, out),
        );
        if !missing {
            return;
        }
        for (k, out) in out.iter_mut().enumerate() {
            if uv[3 * k].is_nan() {
                let d = [0, 1, 2].map(|c| directions[3 * k + c].to_f64());
                let direction = d.iter().all(|x| x.is_finite()) && d.iter().any(|x| *x != 0.0);
                *out = R::new(if direction { 0.0 } else { f64::NAN });
            }
        }
    }

    /// The densities of the texels at canonical places, and whether some place was no place.
    #[inline(always)]
    fn gather<R: Scalar>(&self, places: &[[R; 3]], out: &mut [R]) -> bool {
        /// 1.5·2⁵²: what is added to it, a whole number, is its lowest bits.
        const MAGIC: f64 = 1.5 / f64::EPSILON;
        let (w, h) = (self.raster.width as f64, self.raster.height as f64);
        let ((su, ou), (sv, ov)) = (self.raster.along_u.index(), self.raster.along_v.index());
        let mut index = [0; TILE];
        let mut missing = false;
        for ([u, v, face], index) in places.iter().zip(&mut index) {
            let (u, v) = (u.to_f64(), v.to_f64());
            missing |= u.is_nan();
            // In this order NaN becomes 0.
            let i = Real::floor(min(max(u * su + (ou + 0.5), 0.0), w - 1.0));
            let j = Real::floor(min(max(v * sv + (ov + 0.5), 0.0), h - 1.0));
            let face = max(face.to_f64(), 0.0);
            let place = (face * h + j) * w + i + MAGIC;
            *index = place.to_bits().wrapping_sub(MAGIC.to_bits());
        }
        for (out, index) in out.iter_mut().zip(&index) {
            *out = R::new(f64::from(self.density[*index as usize]));
        }
        missing
    }
}
