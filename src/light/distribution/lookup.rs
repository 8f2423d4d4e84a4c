//! The density in directions.

use super::Distribution;
use crate::error::{Error, expect_length, expect_multiple};
use crate::kernel::threads;
use crate::kernel::tile::{TILE, Tile, Tuples};
use crate::kernel::{Scalar, vectorize};
use crate::map::verbs::EncodeTile;
use crate::number::math::{max, min};
use crate::number::real::Real;

impl Distribution {
    /// The density per steradian in world directions, three numbers each: 0 outside the coverage, NaN for
    /// what is no direction.
    ///
    /// # Errors
    /// The slices' lengths do not go together.
    ///
    /// ```
    /// use spheremap::light::distribution::Distribution;
    /// use spheremap::{Map, image::ImageView};
    /// let map = Map::new("latlong")?;
    /// let white = ImageView::new(&map, &[4, 8], 1, &[1.0_f32; 4 * 8])?;
    /// let light = Distribution::new(&white, &[1.0; 4 * 8])?;
    /// let mut pdf = [0.0_f64];
    /// light.pdf(&[0.0, 1.0, 0.0], &mut pdf)?;
    /// assert!((pdf[0] * 4.0 * std::f64::consts::PI - 1.0).abs() < 1e-6);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn pdf<R: Scalar>(&self, directions: &[R], out: &mut [R]) -> Result<(), Error> {
        expect_multiple("directions", directions.len(), 3)?;
        expect_length("out", out.len(), directions.len() / 3)?;
        threads::blocks(directions, 3, out, 1, |directions, out| {
            for (directions, out) in directions.chunks(3 * TILE).zip(out.chunks_mut(TILE)) {
                self.pdf_tile(directions, out);
            }
        });
        Ok(())
    }

    fn pdf_tile<R: Scalar>(&self, directions: &[R], out: &mut [R]) {
        let mut uv = Tile::new();
        self.map.visit_canonical(EncodeTile {
            turn: self.into_view,
            input: Tuples::of(directions),
            output: &mut uv,
        });
        let missing = vectorize(
            #[inline(always)]
            || self.gather(&uv, out),
        );
        if !missing {
            return;
        }
        for (k, out) in out.iter_mut().enumerate() {
            if uv.0[0][k].is_nan() {
                let d = [0, 1, 2].map(|c| directions[3 * k + c].to_f64());
                let direction = d.iter().all(|x| x.is_finite()) && d.iter().any(|x| *x != 0.0);
                *out = R::new(if direction { 0.0 } else { f64::NAN });
            }
        }
    }

    /// The densities of the texels at canonical places, and whether some place was no place.
    #[inline(always)]
    fn gather<R: Scalar>(&self, Tile([us, vs, faces]): &Tile<R, 3>, out: &mut [R]) -> bool {
        /// 1.5·2⁵²: what is added to it, a whole number, is its lowest bits.
        const MAGIC: f64 = 1.5 / f64::EPSILON;
        let (w, h) = (self.raster.width as f64, self.raster.height as f64);
        let ((su, ou), (sv, ov)) = (self.raster.along_u.index(), self.raster.along_v.index());
        let mut index = [0; TILE];
        let mut missing = false;
        for (k, index) in index[..out.len().min(TILE)].iter_mut().enumerate() {
            let (u, v) = (us[k].to_f64(), vs[k].to_f64());
            missing |= u.is_nan();
            // In this order NaN becomes 0.
            let i = Real::floor(min(max(u * su + (ou + 0.5), 0.0), w - 1.0));
            let j = Real::floor(min(max(v * sv + (ov + 0.5), 0.0), h - 1.0));
            let face = max(faces[k].to_f64(), 0.0);
            let place = (face * h + j) * w + i + MAGIC;
            *index = place.to_bits().wrapping_sub(MAGIC.to_bits());
        }
        for (out, index) in out.iter_mut().zip(&index) {
            *out = R::new(f64::from(self.density[*index as usize]));
        }
        missing
    }
}
