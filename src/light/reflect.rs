//! Mirror reflection, the step before an environment lookup.
//!
//! The formula is [`mirrored`]; here it runs over arrays.

use crate::error::{Error, expect_length, expect_multiple};
use crate::geometry::mirror::mirrored;
use crate::kernel;
use crate::kernel::threads;
use crate::kernel::tile::{TILE, Tile, TuplesMut};
use crate::kernel::{Frame, Point, Scalar};

#[derive(Clone, Copy)]
struct Reflect;

impl<R: Scalar> Point<R, 6, 3> for Reflect {
    #[inline(always)]
    fn apply(self, [x, y, z, a, b, c]: [R; 6]) -> [R; 3] {
        mirrored([x, y, z], [a, b, c])
    }
}

/// Reflects `views` about `normals`, three numbers each; either may be a single one for all.
///
/// # Errors
/// A slice of more than one direction has another length than `out`.
///
/// ```
/// use spheremap::light::reflect;
/// let mut out = [0.0; 3];
/// reflect(&[1.0, 2.0, 3.0], &[0.0, 0.0, 5.0], &mut out)?;
/// assert_eq!(out, [-1.0, -2.0, 3.0]);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn reflect<R: Scalar>(views: &[R], normals: &[R], out: &mut [R]) -> Result<(), Error> {
    expect_multiple("out", out.len(), 3)?;
    for (name, slice) in [("views", views), ("normals", normals)] {
        if slice.len() != 3 {
            expect_length(name, slice.len(), out.len())?;
        }
    }
    let points = out.len() / 3;
    threads::rows(out, 3 * 32 * TILE, points, |block, out| {
        let mut pairs = Tile::<R, 6>::new();
        for (tile, out) in out.chunks_mut(3 * TILE).enumerate() {
            let first = (block * 32 + tile) * TILE;
            let n = out.len() / 3;
            for (c, row) in pairs.0.iter_mut().enumerate() {
                let (of, row) = (if c < 3 { views } else { normals }, &mut row[..n]);
                if of.len() == 3 {
                    row.fill(of[c % 3]);
                    continue;
                }
                for (x, d) in row.iter_mut().zip(of[3 * first..].as_chunks::<3>().0) {
                    *x = d[c % 3];
                }
            }
            kernel::run(Reflect, &Frame::plain(), pairs.first(n), TuplesMut::of(out));
        }
    });
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn reflects_about_normals_of_any_length() {
        for length in [1e-30_f32, 1.0, 1e30] {
            let mut r = [0.0_f32; 3];
            super::reflect(&[1.0, 2.0, 3.0], &[0.0, 0.0, length], &mut r).unwrap();
            for (got, want) in r.iter().zip([-1.0, -2.0, 3.0]) {
                // Products and a quotient: four roundings of numbers up to 6.
                assert!(
                    (got - want).abs() <= 4.0 * 6.0 * f32::EPSILON / 2.0,
                    "{r:?}"
                );
            }
        }
    }
}
