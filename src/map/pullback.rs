//! What flows back to directions from their image coordinates.
//!
//! `encode` has no Jacobian of its own: the two columns of that of `decode` are tangent to the sphere, and the inverse of the 2x2 matrix
//! of their products takes them to two rows that are tangent as well. A direction's length divides.

use crate::error::{Error, expect_length};
use crate::kernel::tile::TILE;
use crate::kernel::{Scalar, threads, vectorize};
use crate::map::Map;

/// Directions that one thread takes at a time.
const BLOCK: usize = 8 * TILE;

impl Map {
    /// What flows back to directions of any length, three numbers each, from `gradient`: what flows back to their u and v, two numbers
    /// each. None of it flows where none comes in, and NaN outside the coverage.
    ///
    /// # Errors
    /// For lengths that do not fit.
    ///
    /// ```
    /// use spheremap::Map;
    /// let map = Map::new("latlong")?;
    /// let mut back = [0.0_f64; 3];
    /// map.encode_gradient(&[0.0, 0.0, -2.0], &[1.0, 0.0], &mut back)?;
    /// let wanted = 0.25 / std::f64::consts::PI; // 1/2π over the length
    /// assert!((back[0] - wanted).abs() < 1e-16 && back[1..] == [0.0, 0.0]);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn encode_gradient<R: Scalar>(
        &self,
        directions: &[R],
        gradient: &[R],
        out: &mut [R],
    ) -> Result<(), Error> {
        let count = directions.len() / 3;
        expect_length("directions", directions.len(), 3 * count)?;
        expect_length("gradient", gradient.len(), 2 * count)?;
        expect_length("out", out.len(), 3 * count)?;
        let work = directions.chunks(3 * BLOCK).zip(gradient.chunks(2 * BLOCK));
        let work = work.zip(out.chunks_mut(3 * BLOCK));
        threads::each(count, work, |((directions, gradient), out)| {
            let tiles = directions.chunks(3 * TILE).zip(gradient.chunks(2 * TILE));
            for ((directions, gradient), out) in tiles.zip(out.chunks_mut(3 * TILE)) {
                self.pull_tile(directions, gradient, out);
            }
        });
        Ok(())
    }

    fn pull_tile<R: Scalar>(&self, directions: &[R], gradient: &[R], out: &mut [R]) {
        let count = directions.len() / 3;
        let (mut uv, mut columns) = ([R::default(); 3 * TILE], [R::default(); 6 * TILE]);
        let uv = &mut uv[..count * self.uv_width()];
        let columns = &mut columns[..6 * count];
        self.encode_numbers(None, directions, uv);
        self.jacobian_numbers(None, uv, columns);
        let rows = directions.as_chunks::<3>().0.iter();
        let rows = rows.zip(gradient.as_chunks::<2>().0);
        let rows = rows.zip(columns.as_chunks::<6>().0);
        let rows = rows.zip(out.as_chunks_mut::<3>().0);
        vectorize(
            #[inline(always)]
            || {
                for (((&[x, y, z], &[u, v]), &[p0, q0, p1, q1, p2, q2]), out) in rows {
                    let a = p0 * p0 + p1 * p1 + p2 * p2;
                    let b = p0 * q0 + p1 * q1 + p2 * q2;
                    let c = q0 * q0 + q1 * q1 + q2 * q2;
                    let length = (x * x + y * y + z * z).sqrt();
                    let over = R::ONE / ((a * c - b * b) * length);
                    let p = (c * u - b * v) * over;
                    let q = (a * v - b * u) * over;
                    let none = u == R::ZERO && v == R::ZERO;
                    let found = [p0 * p + q0 * q, p1 * p + q1 * q, p2 * p + q2 * q];
                    *out = found.map(|x| R::select(none, R::ZERO, x));
                }
            },
        );
    }
}
